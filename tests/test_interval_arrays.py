"""NumPy's functions of whole arrays on intervals: as on numbers, with every number inside."""

from __future__ import annotations

import re

import mpmath
import numpy as np
import pytest

from orthospec.errors import NoEnclosure
from orthospec.intervals import Boxes, Interval, eigenvalues

N = 40
CONSTANT = np.random.default_rng(9).normal(size=(3, 3))


def boxes_of(width, seed=0, d=3):
    random = np.random.default_rng(seed)
    lo = random.uniform(-1, 1 - width, (N, d))
    return Boxes(lo, lo + width * random.uniform(0, 1, (N, d)))


def points_of(boxes, count, seed=1):
    t = np.random.default_rng(seed).uniform(0, 1, (count, *boxes.lo.shape))
    t[:2] = [[[0.0]], [[1.0]]]
    return np.clip(boxes.lo + t * (boxes.hi - boxes.lo), boxes.lo, boxes.hi)


def matrices(p):
    """Matrices (n, 3, 3) that depend on the pose in ways that do not cancel."""
    x, y, z = p[:, 0], p[:, 1], p[:, 2]
    rows = [[2 + x * y, z, y - x], [x * x, 3 - z, y * z], [y, x + z, 2.5 + y * x]]
    return np.stack([np.stack(row, axis=1) for row in rows], axis=1)


def filled(p):
    found = np.zeros_like(p, shape=(len(p), 2, 3))
    found[:, 0, 1:] = p[:, :2] * p[:, 1:]
    found[:, 1] += p
    found[:, :, 0] -= p[:, :1]
    return found


def normalised(p):
    q = p + 3.0
    q /= np.sqrt(np.einsum("ni,ni->n", q, q))[:, None]
    return q


def written_through_views(p):
    moved, scaled = p + 1.0, np.stack([p, 2 * p], axis=1)
    first, turned = moved[:, 0], scaled.swapaxes(0, 1)
    first += p[:, 1] ** 2
    turned[1, :, 0] -= p[:, 2]
    negated, same = -moved, np.einsum("nij->nji", scaled)
    negated[:, 1] = 0.0
    same = same * 1.0
    same[:, 2] = p[:, :2]
    return np.concatenate([moved * p, negated, p.copy(), scaled[:, 1], same[:, :, 0]], axis=1)


ARRAYS = {
    "stack": matrices,
    "concatenate": lambda p: np.concatenate([p, p**2, np.ones((len(p), 1))], axis=1),
    "index": lambda p: p[:, [2, 0]] * p[:, None, 1:2][:, 0],
    "ellipsis": lambda p: matrices(p)[..., 1, :] - matrices(p)[:, 0],
    "axes": lambda p: np.moveaxis(np.swapaxes(matrices(p), 0, 2), -1, 0) + matrices(p).transpose(0, 2, 1),
    "transposed": lambda p: p.T * p.T[::-1],
    "reshape": lambda p: matrices(p).reshape(len(p), 9)[:, ::-1],
    "repeat": lambda p: np.repeat(p, 2, axis=1) * np.tile(p, (1, 2)),
    "roll": lambda p: np.roll(p, 1, axis=1) - np.flip(p, axis=1),
    "broadcast": lambda p: np.broadcast_to(p[:, None, :], (len(p), 2, 3)) * np.arange(6.0).reshape(2, 3),
    "pad": lambda p: np.pad(p, [(0, 0), (1, 2)]) + 1,
    "fill": filled,
    "views": written_through_views,
    "in place": normalised,
    "sum": lambda p: matrices(p).sum(axis=(1, 2)) + np.sum(p, axis=1) - p.mean(axis=1),
    "product": lambda p: np.prod(p + 2, axis=1),
    "extremes": lambda p: np.max(p * p, axis=1) - p.min(axis=1),
    "matmul": lambda p: matrices(p) @ np.swapaxes(matrices(p), 1, 2),
    "constant matmul": lambda p: CONSTANT @ matrices(p) @ CONSTANT[0],
    "gram": lambda p: np.einsum("nij,nik->njk", matrices(p), matrices(p)),
    "einsum": lambda p: np.einsum("nij,nj->ni", matrices(p), p) + np.einsum("nii->n", matrices(p))[:, None],
    "squares": lambda p: np.einsum("nij,nij->n", matrices(p), matrices(p)),
    "cross": lambda p: np.cross(p, p[:, [1, 2, 0]]) + np.cross(p, CONSTANT[0]),
    "trace": lambda p: np.trace(matrices(p), axis1=1, axis2=2),
    "where": lambda p: np.where(p > 0, p * p, -p),
    "clip": lambda p: np.clip(p, -0.5, None) + np.clip(p, None, 0.3),
    "upper triangle": lambda p: np.linalg.eigvalsh(matrices(p), UPLO="U"),
    "norm": lambda p: np.linalg.norm(matrices(p), axis=2),
    "spectral norm": lambda p: np.linalg.norm(matrices(p), 2, axis=(1, 2)),
    "determinant": lambda p: np.linalg.det(matrices(p)),
    "inverse": lambda p: np.linalg.inv(matrices(p) + 2 * np.eye(3)),
    "pseudo-inverse": lambda p: np.linalg.pinv(matrices(p) + 2 * np.eye(3)),
    "solve": lambda p: np.linalg.solve(matrices(p) + 2 * np.eye(3), CONSTANT),
    "eigenvalues": lambda p: np.linalg.eigvalsh(matrices(p) + np.swapaxes(matrices(p), 1, 2)),
    "singular values": lambda p: np.linalg.svd(matrices(p), compute_uv=False),
    "of a tall matrix": lambda p: np.linalg.svd(np.concatenate([matrices(p), p[:, None]], axis=1),
                                                compute_uv=False),
    "condition": lambda p: np.linalg.cond(matrices(p) + 2 * np.eye(3)),
}  # fmt: skip


@pytest.mark.parametrize("name", ARRAYS)
@pytest.mark.parametrize("width", [1e-6, 1e-2, 0.2])
def test_no_number_escapes(name, width):
    function, boxes = ARRAYS[name], boxes_of(width)
    found = function(boxes.poses)
    for points in points_of(boxes, 5):
        values = function(points)
        assert found.shape == values.shape
        rounding = 1e-13 * (1 + np.abs(values))
        undefined = np.isnan(found.lo)
        assert ((found.lo - rounding <= values) & (values <= found.hi + rounding) | undefined).all()
        assert not undefined.any() or (width > 0.1 and name == "condition")


@pytest.mark.parametrize("name", sorted(set(ARRAYS) - {"extremes", "where", "clip"}))
def test_small_boxes_give_narrow_enclosures(name):
    boxes = boxes_of(1e-6)
    found = ARRAYS[name](boxes.poses)
    assert np.max(found.hi - found.lo) < 2e-4


def test_inverses_keep_their_forms():
    boxes = boxes_of(1e-3)
    A = matrices(boxes.poses) + 2 * np.eye(3)
    residual = np.linalg.inv(A) @ A - np.eye(3)
    assert np.max(np.abs([residual.lo, residual.hi])) < 1e-4  # Of intervals alone: some 1e-3.
    assert (residual.lo <= 0).all()
    assert (residual.hi >= 0).all()


def test_what_may_be_singular_has_no_inverse():
    x = Interval(np.full((1, 2, 2), -1.0), np.full((1, 2, 2), 1.0))
    assert np.isnan(np.linalg.inv(x).lo).all()


def symmetric_family(kind, u, random, n):
    """Symmetric matrices A + Σ u_k B_k with ordinary, repeated or tiny eigenvalues at u = 0."""
    spectrum = {"apart": [1.0, 2.0, 5.0], "repeated": [1.0, 1.0, 1.0], "tiny": [1e-12, 1.0, 1.0]}[kind]
    q = np.linalg.qr(random.normal(size=(n, 3, 3)))[0]
    A = np.einsum("nij,j,nkj->nik", q, spectrum, q)
    B = random.normal(size=(3, n, 3, 3))
    A, B = (A + np.swapaxes(A, -1, -2)) / 2, B + np.swapaxes(B, -1, -2)
    return A, B, A + sum(u[:, k, None, None] * B[k] for k in range(3))


@pytest.mark.parametrize("kind", ["apart", "repeated", "tiny"])
@pytest.mark.parametrize("width", [0.0, 1e-15, 1e-6, 0.1])
def test_eigenvalues_against_fifty_digits(kind, width):
    half = width / 2
    boxes = Boxes(np.full((N, 3), -half), np.full((N, 3), half))
    A, B, over = symmetric_family(kind, boxes.poses, np.random.default_rng(3), N)
    found = np.linalg.eigvalsh(over)
    ratio = eigenvalues.eigenvalue_ratio(over)
    u = np.random.default_rng(4).choice([-half, half, 0.3 * half], (N, 3))
    for i in range(N):
        exact = mpmath.matrix(A[i].tolist())
        for k in range(3):
            exact += mpmath.mpf(float(u[i, k])) * mpmath.matrix(B[k, i].tolist())
        values = sorted(mpmath.eigsy(exact, eigvals_only=True))
        for j, value in enumerate(values):
            assert mpmath.mpf(float(found.lo[i, j])) <= value <= mpmath.mpf(float(found.hi[i, j]))
            assert lies_in_form(found.form, (i, j), value, boxes, u[i])
        if not np.isnan(ratio.lo[i]):
            assert mpmath.mpf(float(ratio.lo[i])) <= values[2] / values[0] <= mpmath.mpf(float(ratio.hi[i]))
            assert lies_in_form(ratio.form, i, values[2] / values[0], boxes, u[i])
    if width <= 1e-6:
        weyl = width * np.linalg.norm(B, axis=(2, 3)).sum(axis=0)
        assert ((found.hi - found.lo) <= 2 * weyl[:, None] + 1e-12).all()


def lies_in_form(form, where, value, boxes, pose):
    """Whether a value is within what its form says at a pose of the boxes, all of which are alike."""
    own = boxes.poses.form
    near = mpmath.mpf(float(form.c[where]))
    for k, x in enumerate(pose):
        u = (mpmath.mpf(float(x)) - mpmath.mpf(float(own.c[0, k]))) / mpmath.mpf(float(own.g[0, k, k]))
        near += u * mpmath.mpf(float(form.g[where][k]))
    return abs(value - near) <= mpmath.mpf(float(form.r[where]))


def test_simple_eigenvalues_move_as_their_forms_to_second_order():
    rests = []
    for width in (1e-2, 1e-3):
        half = np.full((N, 3), width / 2)
        over = symmetric_family("apart", Boxes(-half, half).poses, np.random.default_rng(3), N)[2]
        parts = (
            np.linalg.eigvalsh(over),
            eigenvalues.eigenvalue_ratio(over),
            np.linalg.svd(over, compute_uv=False),
        )
        rests.append([np.max(part.form.r) for part in parts])
        assert all((part.form.g != 0).all() for part in parts)
    assert (np.array(rests[1]) < np.array(rests[0]) / 80).all()


def test_what_may_be_singular_is_up_to_infinity_but_no_less_than_elsewhere():
    boxes = Boxes(np.array([[-0.1, 0.0, 0.0]]), np.array([[0.1, 0.0, 0.0]]))
    matrix = (
        np.eye(3)
        * np.stack([boxes.poses[:, 0], 1 + boxes.poses[:, 1], 2 + boxes.poses[:, 2]], axis=1)[:, None]
    )
    condition = np.linalg.cond(matrix)
    assert (condition.lo > 19.9, condition.hi) == (True, np.inf)
    roots = eigenvalues.inverse_roots(np.linalg.eigvalsh(matrix @ matrix))
    assert (roots.lo[0, 0] > 9.9, roots.hi[0, 0]) == (True, np.inf)
    assert np.isfinite([roots.lo[0, 1:], roots.hi[0, 1:]]).all()
    unknown = eigenvalues.inverse_roots(Interval(np.array([np.nan, -1.0]), np.array([np.nan, -0.5])))
    assert np.isnan(unknown.lo).all()


def test_extreme_eigenvalues_are_verified_to_rounding():
    random = np.random.default_rng(5)
    for m in (1, 2, 3, 6):
        A = random.normal(size=(200, m, m)) * 10.0 ** random.uniform(-8, 8, (200, 1, 1))
        A = A + np.swapaxes(A, 1, 2)
        lo, hi = eigenvalues.extreme_eigenvalues(A)
        values, size = np.linalg.eigvalsh(A), np.linalg.norm(A, axis=(1, 2))
        assert (lo <= values[:, 0]).all()
        assert (hi >= values[:, -1]).all()
        assert (values[:, 0] - lo <= 1e-12 * size).all()
        assert (hi - values[:, -1] <= 1e-12 * size).all()


def test_boxes_of_six_coordinates():
    """More corners than are looked at: Weyl's inequality alone."""
    boxes = boxes_of(1e-3, d=6)

    def spectrum(p):
        A = np.reshape(p[:, [0, 1, 2, 1, 3, 4, 2, 4, 5]], (len(p), 3, 3))
        return np.linalg.eigvalsh(A @ A + np.sin(A))

    found = spectrum(boxes.poses)
    for points in points_of(boxes, 10):
        values = spectrum(points)
        assert ((found.lo <= values + 1e-13) & (values <= found.hi + 1e-13)).all()
    assert np.max(found.hi - found.lo) < 0.05


def test_halves_cover_their_box():
    boxes = boxes_of(0.5)
    along = np.arange(N) % 3
    halves = boxes.halves(along)
    rows = np.arange(N)
    assert (halves.lo[:N] == boxes.lo).all()
    assert (halves.hi[N:] == boxes.hi).all()
    assert (halves.hi[:N][rows, along] == halves.lo[N:][rows, along]).all()


REFUSED = {
    "vectors": (lambda p: np.linalg.svd(matrices(p)), "compute_uv=False"),
    "masked sum": (lambda p: np.sum(p, where=np.ones(3, dtype=bool)), "np.sum with these arguments"),
    "initial": (lambda p: np.add.reduce(p, initial=5.0), "np.add.reduce"),
    "masked function": (lambda p: np.sqrt(p, where=np.ones(3, dtype=bool)), "np.sqrt"),
    "accumulate": (lambda p: np.add.accumulate(p), "np.add.accumulate"),
    "three factors": (lambda p: np.einsum("ni,nj,nk->nijk", p, p, p), "two at a time"),
    "other norm": (lambda p: np.linalg.norm(p, -1, axis=1), "ord=-1"),
    "powers of intervals": (lambda p: np.ones(3) ** p, "np.exp"),
    "sorting": (lambda p: np.sort(p, axis=1), "np.sort"),
    "written poses": (lambda p: np.add(p, 1.0, out=p), "a = a + b"),
    "written shape": (lambda p: np.add((p + 1).reshape(-1), 1.0, out=(p + 1).reshape(-1)), "a = a + b"),
    "truth": (lambda p: p or 1.0, "np.where"),
    "method": (lambda p: p.argmax(axis=1), ".argmax"),
}


@pytest.mark.parametrize("size", [1e-85, 1e-100, 1e-170])
@pytest.mark.parametrize("function", [lambda A: np.linalg.svd(A, compute_uv=False), np.linalg.eigvalsh])
def test_of_matrices_whose_squares_underflow_nothing_escapes(function, size):
    boxes = boxes_of(0.1)
    matrices = np.random.default_rng(3).normal(size=(N, 3, 3))
    matrices = size * (matrices + np.swapaxes(matrices, 1, 2))

    def values(poses):
        return function(matrices * (1 + poses[:, 0, None, None]))

    found = values(boxes.poses)
    for poses in points_of(boxes, 4):
        exact = size * function(matrices / size * (1 + poses[:, 0, None, None]))
        assert (found.lo <= exact + 1e-14 * size).all()
        assert (found.hi >= exact - 1e-14 * size).all()


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_not_served_is_refused_and_never_passed_over(name):
    function, words = REFUSED[name]
    with pytest.raises(NoEnclosure, match=re.escape(words)):
        function(boxes_of(0.1).poses)


@pytest.mark.parametrize(
    "function",
    [
        lambda p: np.zeros_like(p, dtype=int),
        lambda p: np.full_like(p, 0.5, dtype=np.float32),
        lambda p: np.ones_like(p, shape=3, dtype=bool),
        lambda p: np.sqrt(p + 2, dtype=np.float16),
        lambda p: np.add(p, 1, dtype=np.float32),
        lambda p: np.add.reduce(p, axis=1, dtype=np.float32),
        lambda p: np.sum(p, dtype=np.float32),
        lambda p: np.stack([p, p], dtype=np.float32),
        lambda p: np.concatenate([p, p], dtype=int),
    ],
)
def test_numbers_of_another_type_are_refused(function):
    """They are rounded to it, or cut off, and what is rounded so would lie outside."""
    with pytest.raises(NoEnclosure, match="a result of another type or in place knows numbers only"):
        function(boxes_of(0.1).poses)


def test_the_type_of_the_numbers_themselves_may_be_named():
    p = boxes_of(0.1).poses
    for same in (np.zeros_like(p, dtype=float), np.add(p, 0, dtype=np.float64), np.stack([p], dtype="d")):
        assert same.shape[-1] == 3

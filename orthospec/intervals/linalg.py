"""Bounds on inverses, determinants, eigenvalues and singular values of small matrices over boxes.

**Inverse.** With R ≈ A_c⁻¹ and P = R A − I, of which |P| <= Q entry by entry,

    A⁻¹ = R − P R + P² (I + P)⁻¹ R,      |P² (I + P)⁻¹ R| <= (I − Q)⁻¹ Q² |R|,

where Q w <= q w for some w > 0 and q < 1 (else nothing is known). The rest is of second order, and w follows
the units of the rows.

**Symmetric eigenvalues** of A(u) = A_c + Σ u_k G_k + E. λ_max is convex and λ_min concave, so that their ends
over the box are those at its 2^d corners, apart from ‖E‖; V the eigenvectors at the middle, the diagonal of
VᵀAV gives the others, apart from the rest of that matrix (Weyl). Corners are verified by Cholesky
factors, whose rounding is bounded (Demmel 1989; Higham, *Accuracy and Stability of Numerical Algorithms*,
theorem 10.3; Rump 2006).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np

from orthospec.intervals import ends, functions
from orthospec.intervals.functions import einsum, matmul
from orthospec.intervals.interval import PLAIN, Interval, as_interval
from orthospec.intervals.linear import Linear
from orthospec.intervals.refusal import refuse
from orthospec.intervals.rounding import FEW, SPARE, TINY, ULP

if TYPE_CHECKING:
    from orthospec.arrays import Array, Flags

CORNERS = 16
"""Most corners of a box that eigenvalues are asked at."""
CLOSE = 2.0**-46
"""How far from computed eigenvalues verified bounds are tried, relative to the matrix's norm."""
PERRON = 4
"""Rounds of power iteration for w; any w > 0 gives a bound."""


def inverse(x: Any) -> Interval:
    """A⁻¹ of any square matrices (..., m, m); undefined where they may be singular."""
    A = as_interval(x)
    R = _approximate_inverse(A.form_over(A.coordinates).c)
    P = matmul(R, A) - np.eye(A.shape[-1])
    c, g, r = P.form_over(A.coordinates)
    Q = (np.abs(c) + np.abs(g).sum(axis=-1) + r) * SPARE
    w = np.ones(Q.shape[:-1])
    for _ in range(PERRON):
        w = (Q @ w[..., None])[..., 0] + FEW * w + TINY
        w /= w.max(axis=-1, keepdims=True)
    w = np.maximum(w, FEW)
    q = ((Q @ w[..., None])[..., 0] / w).max(axis=-1) * SPARE
    second = Q @ (Q @ np.abs(R)) * SPARE
    third = Q @ second * SPARE
    tail = ((Q @ third) / w[..., None]).max(axis=-2, keepdims=True) / (1 - q)[..., None, None]
    rest = (second + third + w[..., None] * tail * SPARE) * SPARE * SPARE
    found = R - matmul(P, R)
    rest = np.where((q < 1)[..., None, None], rest, np.nan)
    return _loosened(found, rest)


def _loosened(x: Interval, rest: Array) -> Interval:
    form = x.form and x.form._replace(r=(x.form.r + rest) * SPARE)
    return Interval(*ends.outward(x.lo - rest, x.hi + rest), form).narrowed()


def _approximate_inverse(matrices: Array) -> Array:
    determinant = np.linalg.det(matrices)
    known = (np.isfinite(determinant) & (determinant != 0))[..., None, None]
    found = np.linalg.inv(np.where(known, matrices, np.eye(matrices.shape[-1])))
    return np.where(known, found, np.nan)


def solve(a: Any, b: Any) -> Any:
    """A⁻¹ b, b (m,) or (..., m, k) as in NumPy."""
    return matmul(inverse(a), b)


def determinant(x: Any) -> Any:
    """det A, by expansion along rows."""
    A = as_interval(x)
    m = A.shape[-1]
    minors: dict[tuple[int, ...], Any] = {(): 1.0}
    for row in range(m - 1, -1, -1):
        wider: dict[tuple[int, ...], Any] = {}
        for columns in _subsets(m, m - row):
            terms = [
                A[..., row, j] * minors[columns[:k] + columns[k + 1 :]] * (-1.0) ** k
                for k, j in enumerate(columns)
            ]
            wider[columns] = sum(terms[1:], terms[0])
        minors = wider
    return minors[tuple(range(m))]


def _subsets(m: int, size: int) -> list[tuple[int, ...]]:
    from itertools import combinations

    return list(combinations(range(m), size))


def symmetric_eigenvalues(x: Any) -> Interval:
    """Eigenvalues (..., m), ascending, of symmetric matrices (..., m, m); their lower triangles are read."""
    A = _mirrored(as_interval(x))
    form = A.form_over(A.coordinates)
    turned, theta = _in_middle_axes(A, form.c)
    diagonal = functions.diagonal(turned, 0, -2, -1)
    apart = _size_off_diagonal(turned)
    lo, hi = np.sort(diagonal.lo, axis=-1), np.sort(diagonal.hi, axis=-1)
    most, least = lo[..., -1], hi[..., 0]
    lo, hi = ends.outward(lo - apart[..., None], hi + apart[..., None])
    lo[..., -1], hi[..., 0] = np.maximum(lo[..., -1], most), np.minimum(hi[..., 0], least)
    lo, hi = ends.multiply((lo, hi), (1 - theta, 1 + theta))
    if A.coordinates and 2**A.coordinates <= CORNERS:
        first, last = _extremes_at_corners(form)
        lo, hi = _raised(lo, first[..., None]), _lowered(hi, last[..., None])
    unknown: Flags = np.any(np.isnan(A.lo), axis=(-2, -1)) | np.any(np.isnan(diagonal.lo), axis=-1)
    unknown = unknown[..., None]
    return Interval(np.where(unknown, np.nan, lo), np.where(unknown, np.nan, hi))


def eigenvalue_ratio(x: Any) -> Interval:
    """λ_max / λ_min (...) of symmetric matrices (..., m, m), undefined unless they are positive definite.

    {A : λ_max <= k λ_min} is convex, so that the ratio over a box is greatest at its corners.
    """
    A = _mirrored(as_interval(x))
    spectrum = symmetric_eigenvalues(A)
    lo, hi = ends.divide(
        (spectrum.lo[..., -1], spectrum.hi[..., -1]), (spectrum.lo[..., 0], spectrum.hi[..., 0])
    )
    if A.coordinates and 2**A.coordinates <= CORNERS:
        corners, rest = _corners(A.form_over(A.coordinates))
        least, greatest = extreme_eigenvalues(corners)
        least, greatest = ends.outward(least - rest, greatest + rest)
        ratio = ends.outward(greatest / least, greatest / least)[1]
        hi = _lowered(hi, np.where((least > 0).all(axis=0), ratio.max(axis=0), np.nan))
    unknown = ~(spectrum.lo[..., 0] > 0)
    return Interval(np.where(unknown, np.nan, np.maximum(lo, 1.0)), np.where(unknown, np.nan, hi))


def singular_values(x: Any) -> Interval:
    """Singular values (..., k), descending, of any matrices."""
    M = as_interval(x)
    if M.shape[-2] < M.shape[-1]:
        M = _transposed(M)
    squares = symmetric_eigenvalues(matmul(_transposed(M), M))
    found: Any = np.sqrt(np.maximum(squares, 0.0))
    form = M.form_over(M.coordinates)
    near = Interval(form.c, form.c)
    middle: Any = symmetric_eigenvalues(matmul(_transposed(near), near))
    middle = np.sqrt(np.maximum(middle, 0.0))
    moved = _frobenius(form.spread)[..., None]
    lo, hi = ends.outward(middle.lo - moved, middle.hi + moved)
    lo, hi = _raised(found.lo, lo), _lowered(found.hi, hi)
    return Interval(lo[..., ::-1], hi[..., ::-1])


def extreme_eigenvalues(matrices: Array) -> tuple[Array, Array]:
    """Verified bounds below the least and above the greatest eigenvalue of symmetric matrices (..., m, m)."""
    m = matrices.shape[-1]
    norm = _frobenius(matrices)
    found = _approximate_eigenvalues(matrices.reshape(-1, m, m)).reshape(*matrices.shape[:-1])
    margin = norm * CLOSE + TINY
    least, greatest = found[..., 0] - margin, found[..., -1] + margin
    eye = np.eye(m)
    upper = _least_eigenvalue_is_above(greatest[..., None, None] * eye - matrices)
    lower = _least_eigenvalue_is_above(matrices - least[..., None, None] * eye)
    # The differences were rounded: on the diagonal only.
    spare = (np.abs(greatest) + np.abs(least) + norm) * FEW
    lo = np.where(np.isnan(lower), -norm, least + lower - spare)
    hi = np.where(np.isnan(upper), norm, greatest - upper + spare)
    return lo, hi


def _least_eigenvalue_is_above(matrices: Array) -> Array:
    """A number (...) just below 0 that no eigenvalue lies below; NaN where no Cholesky factor was found.

    The computed factor belongs to a matrix that differs by at most 2 (m + 1) u sqrt(a_ii a_jj) in each entry.
    """
    m = matrices.shape[-1]
    columns = np.ascontiguousarray(np.moveaxis(matrices, (-2, -1), (0, 1)))
    L: list[list[Array]] = []
    positive = np.ones(matrices.shape[:-2], dtype=bool)
    for i in range(m):
        row: list[Array] = []
        for j in range(i):
            left = columns[i, j] - sum(row[k] * L[j][k] for k in range(j))
            row.append(left / L[j][j])
        pivot = columns[i, i] - sum(entry * entry for entry in row)
        positive &= pivot > 0
        row.append(np.sqrt(np.where(pivot > 0, pivot, 1.0)))
        L.append(row)
    trace = np.abs(np.einsum("...ii->...", matrices))
    return np.where(positive, -(2 * (m + 2) * ULP * trace + TINY), np.nan)


def _approximate_eigenvalues(matrices: Array) -> Array:
    known = np.asarray(np.isfinite(matrices).all(axis=(1, 2)))
    safe = matrices if known.all() else np.where(known[:, None, None], matrices, 0.0)
    if matrices.shape[1] == 3:
        from orthospec import kernels

        found = kernels.symmetric_eigenvalues(safe)
    else:
        found = np.linalg.eigvalsh(safe).astype(np.float64)
    return np.where(known[:, None], found, np.nan)


def _extremes_at_corners(form: Linear) -> tuple[Array, Array]:
    """Below λ_min and above λ_max over each box."""
    corners, rest = _corners(form)
    least, greatest = extreme_eigenvalues(corners)
    return ends.outward(least.min(axis=0) - rest, greatest.max(axis=0) + rest)


def _corners(form: Linear) -> tuple[Array, Array]:
    """A_c + Σ ± G_k (2^d, ..., m, m), and how far (...) from their hull a matrix of the box may lie."""
    signs = np.array(list(product((-1.0, 1.0), repeat=form.g.shape[-1])))
    slopes = np.moveaxis(form.g, -1, 0)
    corners = form.c + np.tensordot(signs, slopes, axes=1)
    rounding = FEW * (np.abs(form.c) + np.abs(form.g).sum(axis=-1))
    rest = (form.r + rounding) * SPARE
    return corners, np.minimum(_frobenius(rest), rest.sum(axis=-1).max(axis=-1) * SPARE)


def _in_middle_axes(A: Interval, middle: Array) -> tuple[Interval, Array]:
    """VᵀAV and θ: each eigenvalue of A is one of VᵀAV times 1 ± θ (Ostrowski), V nearly orthogonal."""
    known = np.asarray(np.isfinite(middle).all(axis=(-2, -1)))[..., None, None]
    V = np.linalg.eigh(np.where(known, middle, 0.0))[1]
    Vt = np.swapaxes(V, -1, -2)
    m = V.shape[-1]
    defect = _frobenius(Vt @ V - np.eye(m)) + m * m * FEW
    turned = matmul(matmul(Vt, A), V)
    return turned, 2 * defect[..., None]


def _size_off_diagonal(x: Interval) -> Array:
    magnitude = np.maximum(np.abs(x.lo), np.abs(x.hi))
    return _frobenius(magnitude * (1 - np.eye(x.shape[-1])))


def _frobenius(matrices: Array) -> Array:
    return np.asarray(np.sqrt(np.einsum("...ij,...ij->...", matrices, matrices)) * SPARE)


def _mirrored(A: Interval) -> Interval:
    lower = np.tril(np.ones(A.shape[-2:], dtype=bool))
    found: Any = np.where(lower, A, _transposed(A))
    return as_interval(found)


def _transposed(x: Any) -> Interval:
    return functions.swapaxes(x, -1, -2)


def _raised(lo: Array, other: Array) -> Array:
    return np.where(other > lo, other, lo)


def _lowered(hi: Array, other: Array) -> Array:
    return np.where(other < hi, other, hi)


def _norm(x: Any, ord: Any = None, axis: Any = None, keepdims: bool = False) -> Any:
    """The length of vectors, or the norm of matrices that ``ord`` names."""
    x = as_interval(x)
    axes = (tuple(range(x.ndim)) if axis is None else tuple(np.atleast_1d(axis)))  # fmt: skip
    if ord in (None, "fro") or (ord == 2 and len(axes) == 1):
        return np.sqrt(np.sum(np.square(x), axis=axes, keepdims=keepdims))
    if ord == 2 and len(axes) == 2 and not keepdims:
        return singular_values(np.moveaxis(x, axes, (-2, -1)))[..., 0]
    if ord in (1, np.inf) and len(axes) == 1:
        size = np.abs(x)
        return (size.sum if ord == 1 else size.max)(axis=int(axes[0]), keepdims=keepdims)
    raise refuse(f"np.linalg.norm with ord={ord!r}", PLAIN)


def _svd(x: Any, full_matrices: bool = True, compute_uv: bool = True, **_: Any) -> Interval:  # noqa: ARG001
    if compute_uv:
        raise refuse("np.linalg.svd with vectors", "ask for singular values alone, compute_uv=False")
    return singular_values(x)


def _eigvalsh(x: Any, UPLO: str = "L") -> Interval:
    return symmetric_eigenvalues(x if UPLO == "L" else _transposed(x))


def _cond(x: Any, p: Any = None) -> Any:
    if p not in (None, 2):
        raise refuse(f"np.linalg.cond with p={p!r}", PLAIN)
    return np.sqrt(eigenvalue_ratio(einsum("...ji,...jk->...ik", x, x)))


TABLE: Mapping[Callable[..., Any], Callable[..., Any]] = {
    np.linalg.inv: inverse,
    np.linalg.solve: solve,
    np.linalg.det: determinant,
    np.linalg.eigvalsh: _eigvalsh,
    np.linalg.svd: _svd,
    np.linalg.svdvals: singular_values,
    np.linalg.norm: _norm,
    np.linalg.cond: _cond,
}

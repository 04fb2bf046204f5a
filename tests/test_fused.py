"""Sums and products of intervals in C: those of their twin, and what they enclose."""

from __future__ import annotations

from fractions import Fraction
from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from orthospec.intervals import Boxes, Interval, fused, rounding, twin
from orthospec.intervals.interval import as_interval
from orthospec.intervals.linear import Linear
from orthospec.kernels import _kernels

KINDS = ("numbers", "ends", "form")
SPECIAL = [0.0, -0.0, 5e-324, 1e-300, -1e300, np.inf, -np.inf, np.nan]
SHAPES = [((7,), (7,)), ((5, 3), (3,)), ((4, 1, 3), (2, 1)), ((), (6,)), ((300, 2), (300, 2)), ((0, 3), (3,))]
seeds = st.integers(0, 2**32 - 1)


def quantities(random, shape, kind, d=3, special=0.0):
    """Numbers, pairs of ends, or ends and a form beside them; a part of all of them special."""

    def numbers(scale, size=shape):
        found = scale * random.standard_normal(size)
        return np.where(random.random(size) < special, random.choice(SPECIAL, size), found)

    if kind == "numbers":
        return as_interval(numbers(1.0))
    middle, radius = numbers(1.0), np.abs(numbers(0.1))
    with np.errstate(invalid="ignore"):
        lo, hi = middle - radius, middle + radius
    if kind == "ends":
        return Interval(lo, hi)
    return Interval(lo, hi, Linear(middle, numbers(0.03, (*shape, d)), np.abs(numbers(0.05))))


def parts(x):
    return [x.lo, x.hi, *(x.form or ())]


@np.errstate(all="ignore")
def check_bits(found, expected):
    assert len(parts(found)) == len(parts(expected))
    for one, other in zip(parts(found), parts(expected), strict=True):
        np.testing.assert_array_equal(one, other)


def pairs():
    return [pair for pair in product(KINDS, KINDS) if pair != ("numbers", "numbers")]


@pytest.mark.parametrize("special", [0.0, 0.2])
@pytest.mark.parametrize("shapes", SHAPES, ids=str)
@pytest.mark.parametrize("kinds", pairs(), ids=str)
@pytest.mark.parametrize("name", ["add", "multiply"])
def test_entry_by_entry_the_bits_are_those_of_the_twin(name, kinds, shapes, special):
    random = np.random.default_rng(len(kinds[0]) + 7 * len(shapes[0]))
    for d in (1, 3, 7):
        a, b = (quantities(random, s, k, d, special) for s, k in zip(shapes, kinds, strict=True))
        with np.errstate(all="ignore"):
            check_bits(getattr(fused, name)(a, b), getattr(twin, name)(a, b))


@settings(max_examples=50, deadline=None)
@given(seeds)
def test_strides_of_any_sign_and_order_change_nothing(seed):
    random = np.random.default_rng(seed)
    a, b = (quantities(random, (6, 5, 4), kind) for kind in random.choice(KINDS[1:], 2))
    a, b = a[::-2, :, 1:3], b[:3, ::-1, ::2]
    a, b = a.transpose(2, 0, 1), b.transpose(2, 0, 1)
    for name in ("add", "multiply"):
        check_bits(getattr(fused, name)(a, b), getattr(twin, name)(a, b))
    names = ("kij", "kim", "kjm")
    check_close(fused.contract(*names, a, b), twin.contract(*names, a, b))


@np.errstate(all="ignore")
def check_close(found, expected):
    """To the rounding of sums in another order."""
    for one, other in zip(parts(found), parts(expected), strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-12, atol=1e-14)


CONTRACTIONS = [
    ("...ij", "...jk", "...ik", (40, 3, 4), (40, 4, 2)),
    ("...ij", "...jk", "...ik", (3, 4), (33, 4, 2)),
    ("...ij", "j", "...i", (40, 3, 4), (4,)),
    ("nij", "nj", "ni", (65, 6, 6), (65, 6)),
    ("nji", "njk", "nik", (5, 6, 6), (5, 6, 6)),
    ("i", "i", "", (5,), (5,)),
    ("i", "j", "ij", (5,), (3,)),
    ("nii", "n", "ni", (8, 3, 3), (8,)),
    ("...i", "...i", "...", (2, 1, 3), (4, 3)),
    ("nij", "nij", "n", (9, 1, 3), (9, 2, 3)),
    ("ij", "jk", "ki", (3, 0), (0, 2)),
    ("ij", "jk", "ik", (0, 3), (3, 2)),
]


@pytest.mark.parametrize("kinds", pairs(), ids=str)
@pytest.mark.parametrize("contraction", CONTRACTIONS, ids=str)
def test_sums_of_products_are_those_of_the_twin(contraction, kinds):
    left, right, out, *shapes = contraction
    random = np.random.default_rng(3)
    a, b = (quantities(random, s, k) for s, k in zip(shapes, kinds, strict=True))
    found, expected = fused.contract(left, right, out, a, b), twin.contract(left, right, out, a, b)
    assert found.shape == expected.shape
    check_close(found, expected)


@pytest.mark.parametrize("kinds", pairs(), ids=str)
def test_what_is_not_finite_spreads_in_sums_of_products_and_nowhere_else(kinds):
    random = np.random.default_rng(4)
    a, b = (quantities(random, (70, 3, 3), k, special=0.02) for k in kinds)
    with np.errstate(all="ignore"):
        found, expected = (by.contract("nij", "njk", "nik", a, b) for by in (fused, twin))
    np.testing.assert_array_equal(np.isnan(found.lo), np.isnan(expected.lo))
    finite = np.isfinite(expected.lo) & np.isfinite(expected.hi)
    assert 0 < np.count_nonzero(finite) < finite.size
    np.testing.assert_allclose(found.lo[finite], expected.lo[finite], rtol=1e-12, atol=1e-13)


@settings(max_examples=100, deadline=None)
@given(seeds, st.sampled_from([1e-12, 1e-3, 1.0]))
def test_exact_sums_and_products_lie_within(seed, width):
    """In rational arithmetic, over points of the box that both depend on: of the ends and of the form."""
    random = np.random.default_rng(seed)
    lo = random.standard_normal((3, 2))
    poses = Boxes(lo, lo + width * random.random((3, 2))).poses
    u = random.uniform(-1, 1, 2)
    scale = random.standard_normal((2, 2))
    a, b = poses * scale[0], poses[::-1] * scale[1] + random.standard_normal(2)
    for name, exact in (("add", lambda x, y: x + y), ("multiply", lambda x, y: x * y)):
        found = getattr(fused, name)(a, b)
        for k in np.ndindex(found.shape):
            value = exact(at(a, k, u), at(b, k, u))
            assert Fraction(found.lo[k]) <= value <= Fraction(found.hi[k])
            assert abs(value - at(found, k, u)) <= Fraction(found.form.r[k])
    found = fused.contract("ni", "mi", "nm", a, b)
    for n, m in np.ndindex(found.shape):
        value = sum(at(a, (n, i), u) * at(b, (m, i), u) for i in range(2))
        assert Fraction(found.lo[n, m]) <= value <= Fraction(found.hi[n, m])
        assert abs(value - at(found, (n, m), u)) <= Fraction(found.form.r[n, m])


def at(x, k, u):
    """What a form without its rest is at a point of the box, exactly."""
    slopes = x.form.g[k]
    return Fraction(x.form.c[k]) + sum(Fraction(g) * Fraction(t) for g, t in zip(slopes, u, strict=True))


def test_what_has_no_coordinates_is_as_narrow_as_it_was():
    """By ends alone, by a form over no coordinates, and by numbers: no row is written that is not there."""
    lo, hi = np.zeros((2, 3)), np.ones((2, 3))
    for x in ((lo, hi), (lo, hi, lo, np.zeros((2, 3, 0)), hi), (lo,)):
        room = np.full((3, 2, 3), 7.0)
        _kernels.narrow_intervals(x, room[:2])
        np.testing.assert_array_equal(room, [lo, hi if len(x) > 1 else lo, np.full((2, 3), 7.0)])


def test_rounding_is_that_of_rounding_py():
    """Of sums and products without any width, at the least that each constant adds."""
    one = Interval(np.ones(1), np.ones(1).copy())
    found = fused.add(one, one)
    step = 2.0 * rounding.ULP + rounding.TINIEST
    assert (found.lo[0], found.hi[0]) == (2.0 - step, 2.0 + step)
    zero = Interval(np.zeros(1), np.zeros(1), Linear(np.zeros(1), np.zeros((1, 1)), np.zeros(1)))
    assert fused.multiply(zero, zero).form.r[0] == rounding.TINY


@pytest.mark.parametrize(
    ("left", "right", "out", "shapes"),
    [
        ("ij", "jk", "iz", ((2, 3), (3, 4))),
        ("ij", "jk", "ii", ((2, 3), (3, 4))),
        ("ijk", "jk", "i", ((2, 3), (3, 4))),
        ("ij", "jk", "ik", ((5, 2, 3), (3, 4))),
        ("...ij", "...jk", "ik", ((5, 2, 3), (3, 4))),
        ("ij", "jk", "ik", ((2, 3), (4, 5))),
        ("ij", "ij", "ij", ((2, 3), (3, 3))),
    ],
)
def test_names_that_numpy_refuses_are_refused(left, right, out, shapes):
    a, b = (Interval(np.zeros(shape), np.ones(shape)) for shape in shapes)
    with pytest.raises(ValueError, match=r"einsum|axes"):
        fused.contract(left, right, out, a, b)
    with pytest.raises(ValueError, match=r"einstein|operand"):
        np.einsum(f"{left},{right}->{out}", a.lo, b.lo)


TWO = (np.zeros((2, 3)), np.ones((2, 3)))
FORM = (*TWO, np.zeros((2, 3)), np.zeros((2, 3, 2)), np.zeros((2, 3)))


@pytest.mark.parametrize(
    ("x", "out", "error", "message"),
    [
        ([1], np.empty((2, 2, 3)), TypeError, r"expected \(numbers,\), \(lo, hi\) or"),
        ((*TWO, TWO[0]), np.empty((2, 2, 3)), TypeError, r"expected \(numbers,\), \(lo, hi\) or"),
        ((TWO[0], 1.0), np.empty((2, 2, 3)), TypeError, "expected an array of float64"),
        ((TWO[0], TWO[1].astype("f4")), np.empty((2, 2, 3)), TypeError, "wrong type of element"),
        ((TWO[0], TWO[1][:1]), np.empty((2, 2, 3)), ValueError, "different shapes"),
        (FORM, np.empty((7, 2, 3)), ValueError, "another number of coordinates"),
        (TWO, np.empty((3, 2, 3)), ValueError, r"\(2, ...\) or \(4 \+ d, ...\)"),
        (TWO, np.empty((2, 3)), ValueError, "fewer axes"),
        (TWO, np.empty((2, 2, 4)), ValueError, "cannot be broadcast"),
        (TWO, np.empty((2, 2, 3))[:, :, ::-1], ValueError, "C-contiguous"),
        (TWO, np.broadcast_to(0.0, (2, 2, 3)), ValueError, "C-contiguous|read-only"),
        (TWO, np.empty((2, 2, 3), dtype="i8"), TypeError, "wrong type of element"),
    ],
)
def test_arrays_that_do_not_fit_are_refused(x, out, error, message):
    with pytest.raises(error, match=message):
        _kernels.multiply_intervals(x, TWO, out)
    if len(np.shape(out)) > 2:
        with pytest.raises(error, match=message.replace("cannot be broadcast", "lengths of the axes")):
            _kernels.contract_intervals(x, b"\0\1", TWO, b"\0\1", out)


def test_what_is_written_must_not_be_read():
    out = np.empty((2, 2, 3))
    for call in (
        lambda: _kernels.narrow_intervals((out[0], out[1]), out),
        lambda: _kernels.add_intervals(TWO, (out[1],), out),
        lambda: _kernels.contract_intervals(TWO, b"\0\1", (out[0],), b"\0\1", out),
    ):
        with pytest.raises(ValueError, match="out overlaps another argument"):
            call()


@pytest.mark.parametrize(
    ("axes", "message"), [(b"\0", "as many axes"), (b"\0\x40", "beyond"), (b"\0\1\2", "as many axes")]
)
def test_axes_that_are_not_there_are_refused(axes, message):
    with pytest.raises(ValueError, match=message):
        _kernels.contract_intervals(TWO, axes, TWO, b"\0\1", np.empty((2, 2, 3)))

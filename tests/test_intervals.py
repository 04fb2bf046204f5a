"""Interval operations against 50 digits: at no point of any box may a value escape its enclosure."""

from __future__ import annotations

import re

import mpmath
import numpy as np
import pytest

from orthospec.errors import NoEnclosure
from orthospec.intervals import Boxes, Interval, as_interval

POINTS = 4
"""Points tried in each interval: its ends, and others."""


def intervals(seed, count, low=-3.0, high=3.0):
    """Intervals of all widths, points and single units in the last place among them, some at powers of 2."""
    random = np.random.default_rng(seed)
    middle = random.uniform(low, high, count)
    middle[::7] = np.clip(np.exp2(np.round(np.log2(np.abs(middle[::7])))), max(low, 0.0), high)
    radius = np.abs(middle) * 10.0 ** random.uniform(-17, 0, count)
    radius[::5] = 0.0
    return np.maximum(middle - radius, low), np.minimum(middle + radius, high)


def inside(lo, hi, seed):
    """POINTS numbers in each interval (POINTS, n), both ends first."""
    t = np.random.default_rng(seed).uniform(0, 1, (POINTS - 2, len(lo)))
    return np.concatenate([[lo, hi], np.clip(lo + t * (hi - lo), lo, hi)])


def escapes(found, points, exact):
    """How many exact values lie outside of their interval."""
    count = 0
    for row in points:
        for i, numbers in enumerate(row):
            value = exact(*(mpmath.mpf(float(x)) for x in np.atleast_1d(numbers)))
            count += not (mpmath.mpf(float(found.lo[i])) <= value <= mpmath.mpf(float(found.hi[i])))
    return count


UNARY = {
    "negative": (np.negative, lambda x: -x, (-3, 3)),
    "absolute": (np.abs, abs, (-3, 3)),
    "square": (np.square, lambda x: x * x, (-3, 3)),
    "cube": (lambda x: x**3, lambda x: x**3, (-3, 3)),
    "fourth power": (lambda x: x**4, lambda x: x**4, (-3, 3)),
    "reciprocal square": (lambda x: x**-2.0, lambda x: x**-2, (0.01, 3)),
    "power 1.5": (lambda x: x**1.5, lambda x: x ** mpmath.mpf("1.5"), (1e-9, 3)),
    "sqrt": (np.sqrt, mpmath.sqrt, (0, 3)),
    "exp": (np.exp, mpmath.exp, (-30, 3)),
    "log": (np.log, mpmath.log, (1e-9, 3)),
    "sin": (np.sin, mpmath.sin, (-7, 7)),
    "cos": (np.cos, mpmath.cos, (-7, 7)),
    "sin far out": (np.sin, mpmath.sin, (1e5, 1e5 + 7)),
    "tan": (np.tan, mpmath.tan, (-1.4, 1.4)),
    "arctan": (np.arctan, mpmath.atan, (-20, 20)),
    "arcsin": (np.arcsin, mpmath.asin, (-1, 1)),
    "arccos": (np.arccos, mpmath.acos, (-1, 1)),
    "sinh": (np.sinh, mpmath.sinh, (-5, 5)),
    "cosh": (np.cosh, mpmath.cosh, (-5, 5)),
    "tanh": (np.tanh, mpmath.tanh, (-25, 25)),
    "reciprocal": (np.reciprocal, lambda x: 1 / x, (1e-3, 3)),
    "sign": (np.sign, mpmath.sign, (-3, 3)),
    "minimum": (lambda x: np.minimum(x, 0.7), lambda x: min(x, mpmath.mpf(0.7)), (-3, 3)),
    "clip": (lambda x: np.clip(x, -1, 0.7), lambda x: max(min(x, mpmath.mpf(0.7)), -1), (-3, 3)),
}


@pytest.mark.parametrize("name", UNARY)
def test_functions_of_one_interval(name):
    function, exact, (low, high) = UNARY[name]
    lo, hi = intervals(1, 150, low, high)
    assert escapes(function(Interval(lo, hi)), inside(lo, hi, 2), exact) == 0


BINARY = {
    "add": (np.add, lambda x, y: x + y),
    "subtract": (np.subtract, lambda x, y: x - y),
    "multiply": (np.multiply, lambda x, y: x * y),
    "divide": (lambda x, y: x / (y + 4), lambda x, y: x / (y + 4)),
    "hypot": (np.hypot, mpmath.hypot),
    "arctan2": (np.arctan2, mpmath.atan2),
    "maximum": (np.maximum, max),
    "minimum": (np.minimum, min),
}


@pytest.mark.parametrize("name", BINARY)
def test_functions_of_two_intervals(name):
    function, exact = BINARY[name]
    x, y = intervals(3, 150), intervals(4, 150)
    points = np.stack([inside(*x, 5), inside(*y, 6)[[1, 0, 2, 3]]], axis=2)
    assert escapes(function(Interval(*x), Interval(*y)), points, exact) == 0


def test_no_result_is_wider_than_a_few_units():
    x = as_interval(np.array([0.3, -1.7, 2.0]))
    for found in (x + 0.1, x * 0.7, x / 3.1, np.sqrt(x * x), np.square(x)):
        assert np.all(found.hi - found.lo <= 1e-15 * np.abs(found.hi))
    for found in (np.sin(x), np.exp(x), np.cos(x)):
        assert np.all(found.hi - found.lo <= 1e-14 * np.abs(found.hi))


# Mean-value forms: each of these has dependencies that interval arithmetic alone loses.
COMPOSITE = {
    "difference of squares": (lambda x, y: x * x - y**2 - (x - y) * (x + y), (-1, 1)),
    "quotient": (lambda x, y: (x - y) / (x + y), (0.5, 2)),
    "circle": (lambda x, y: (1 - x * x - y * y) ** 0.5 / (2 + x), (-0.5, 0.5)),
    "powers": (lambda x, y: x**3 * y**-2.0 + x / y, (0.5, 2)),
    "magnitude": (lambda x, y: abs(x - y) + abs(x) * y, (-1, 1)),
}


@pytest.mark.parametrize("name", COMPOSITE)
@pytest.mark.parametrize("width", [0.0, 1e-15, 1e-9, 1e-3, 0.3])
def test_mean_value_forms(name, width):
    function, (low, high) = COMPOSITE[name]
    random = np.random.default_rng(7)
    lo = random.uniform(low, high - width, (12, 2))
    boxes = Boxes(lo, lo + width * random.uniform(0, 1, (12, 2)))
    found = function(*boxes.poses.T)
    points = np.clip(boxes.lo + random.uniform(0, 1, (3, 12, 2)) * (boxes.hi - boxes.lo), boxes.lo, boxes.hi)
    points = np.concatenate([points, [boxes.lo, boxes.hi]])
    assert escapes(found, points, function) == 0
    for row in points:
        for i, pose in enumerate(row):
            assert lies_in_form(found.form, i, function(*map(exactly, pose)), coordinates(boxes, i, pose))


@pytest.mark.parametrize(
    "name", ["sqrt", "exp", "log", "sin", "tan", "arctan", "arcsin", "arccos", "sinh", "cosh", "tanh"]
)
@pytest.mark.parametrize("width", [0.0, 1e-9, 1e-3, 0.1])
def test_mean_value_forms_of_functions(name, width):
    function, exact, (low, high) = UNARY[name]
    check_forms(lambda x: function(x[:, 0]), exact, max(low, -2.0), min(high, 2.0), width, 1)


@pytest.mark.parametrize("width", [0.0, 1e-9, 1e-3, 0.1])
def test_mean_value_forms_of_angles(width):
    check_forms(lambda p: np.arctan2(p[:, 0], p[:, 1]), mpmath.atan2, -1.0, 1.0, width, 2)


def check_forms(function, exact, low, high, width, d):
    random = np.random.default_rng(8)
    lo = random.uniform(low, high - width, (20, d))
    boxes = Boxes(lo, lo + width * random.uniform(0.5, 1, (20, d)))
    found = function(boxes.poses)
    points = np.clip(boxes.lo + random.uniform(0, 1, (3, 20, d)) * (boxes.hi - boxes.lo), boxes.lo, boxes.hi)
    assert escapes(found, points, exact) == 0
    near = np.abs(found.form.g).max(axis=1) > 0
    assert width == 0 or np.count_nonzero(near) > 15
    for row in points:
        for i, pose in enumerate(row):
            assert lies_in_form(found.form, i, exact(*map(exactly, pose)), coordinates(boxes, i, pose))


def test_the_angle_is_any_where_it_jumps_and_undefined_where_its_coordinates_are():
    y, x = np.array([-0.1, 0.0, np.nan, 1.0]), np.array([-1.0, 0.0, 1.0, -2.0])
    found = np.arctan2(Interval(y, y + 0.2), Interval(x, x + 0.1))
    assert found.lo[:2] == pytest.approx([-np.pi] * 2)
    assert found.hi[:2] == pytest.approx([np.pi] * 2)
    assert np.isnan([found.lo[2], found.hi[2]]).all()
    assert np.arctan2(1.2, -2.0) <= found.hi[3] < np.arctan2(1.0, -2.0) + 0.01


def exactly(x):
    return mpmath.mpf(float(x))


def coordinates(boxes, i, pose):
    """u of a pose of box i."""
    form = boxes.poses.form
    parts = zip(pose, form.c[i], form.g[i].diagonal(), strict=True)
    return [(exactly(p) - exactly(c)) / exactly(g) for p, c, g in parts]


def lies_in_form(form, i, value, u):
    near = exactly(form.c[i]) + mpmath.fdot(map(exactly, form.g[i]), u)
    return abs(value - near) <= exactly(form.r[i]) and max(map(abs, u)) <= 1


def test_boxes_that_are_moved_keep_the_coordinates_of_those_that_they_were():
    random = np.random.default_rng(11)
    lo = random.uniform(-1, 1, (12, 2))
    boxes = Boxes(lo, lo + 1e-9)
    by = random.uniform(-1, 1, (12, 2))
    there, here = boxes.moved(by), boxes.poses
    for k in range(2):
        apart = there.poses[:, k] - here[:, k]
        assert np.max(apart.hi - apart.lo) < 1e-14  # Of intervals alone: 2e-9.
        for i, pose in enumerate(boxes.hi):
            exact = exactly(pose[k]) + exactly(by[i, k])
            assert lies_in_form(there.poses[:, k].form, i, exact, coordinates(boxes, i, pose))
            assert exactly(there.lo[i, k]) <= exact <= exactly(there.hi[i, k])
    with pytest.raises(NoEnclosure):
        there.poses[0] = 0.0


@pytest.mark.parametrize(
    ("function", "exact", "low", "high"),
    [
        (np.sqrt, mpmath.sqrt, 1e-172, 9e-172),
        (lambda x: x**0.5, mpmath.sqrt, 1e-200, 9e-200),
        (np.arccos, mpmath.acos, 1 - 1e-7, 1.0),
        (np.arcsin, mpmath.asin, 1 - 1e-7, 1.0),
    ],
)
def test_where_squares_underflow_and_where_a_slope_has_no_end_nothing_escapes(function, exact, low, high):
    lo, hi = intervals(0, 400, low, high)
    found = function(Boxes(lo[:, None], hi[:, None]).poses[:, 0])
    assert escapes(found, inside(lo, hi, 1), exact) == 0


def test_forms_converge_quadratically():
    def excess(width):
        boxes = Boxes(np.array([[0.3, 0.4]]), np.array([[0.3 + width, 0.4 + width]]))
        x, y = boxes.poses.T
        found = (x - y) / np.sqrt(1 - x * x - y * y)
        t = np.linspace(0, width, 201)
        X, Y = np.meshgrid(0.3 + t, 0.4 + t)
        values = (X - Y) / np.sqrt(1 - X**2 - Y**2)
        return (found.hi - found.lo - np.ptp(values)).item()

    assert excess(0.002) < excess(0.02) / 90
    assert excess(0.0002) < excess(0.002) / 90


def test_what_may_be_undefined_is_nan_and_spreads():
    x = Interval(np.array([-1.0, 1.0]), np.array([1.0, 2.0]))
    for found in (np.sqrt(x), np.log(x), x**0.5, x / x, np.minimum(np.sqrt(x), 3.0) * 0, x**-1.0 * 0):
        assert np.isnan([found.lo[0], found.hi[0]]).all()
        assert not np.isnan([found.lo[1], found.hi[1]]).any()
    found = 1 / x
    assert (found.lo[0], found.hi[0]) == (-np.inf, np.inf)


def test_comparisons_and_choices_between_values():
    x = Interval(np.array([-2.0, -1.0, 1.0]), np.array([-1.0, 1.0, 2.0]))
    positive = x > 0
    assert positive.surely.tolist() == [False, False, True]
    assert positive.possibly.tolist() == [False, True, True]
    found = np.where(positive, x, -10.0)
    assert found.lo.tolist() == [-10, -10, 1]
    assert found.hi.tolist() == [-10, 1, 2]
    assert np.isfinite(x).all()
    negative = ~(positive | (x == 0))
    assert negative.surely.tolist() == [True, False, False]
    assert negative.possibly.tolist() == [True, True, False]


def by_stacking(x):
    return np.array([x[:, 0], x[:, 1]])


def by_filling(x):
    found = np.empty(x.shape)
    found[:, 0] = x[:, 1]
    return found


def in_place(x):
    found = np.ones(x.shape)
    found += x
    return found


def by_float(x):
    return float(x[0, 0])


def by_if(x):
    return x[:, 0] if x[0, 0] > 0 else -x[:, 0]


def by_mask(x):
    return x[x > 0]


def by_other_function(x):
    return np.median(x)


@pytest.mark.parametrize(
    ("code", "way_out"),
    [
        (by_stacking, "np.stack"),
        (by_filling, "np.zeros_like(poses, shape=...)"),
        (in_place, "a = a + b"),
        (by_float, "elementary functions"),
        (by_if, "np.where"),
        (by_mask, "np.where"),
        (by_other_function, "elementary functions"),
    ],
)
def test_code_for_numbers_only_is_told_where_it_stands(code, way_out):
    with pytest.raises(NoEnclosure, match=re.escape(way_out)) as caught:
        code(Boxes(np.full((2, 2), -1.0), np.ones((2, 2))).poses)
    first = code.__code__.co_firstlineno
    found = re.match(rf"{re.escape(__name__)}, line (\d+): ", str(caught.value))
    assert first < int(found[1]) <= first + 3

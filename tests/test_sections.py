"""Sections against closed forms, Saint-Venant's series in 50 digits, and Prandtl's membrane."""

from __future__ import annotations

import math

import mpmath
import numpy as np
import pytest
import scipy.sparse as sparse
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse.linalg import spsolve

from orthospec.mechanics.sections import circle, rectangle

sizes = st.floats(1e-3, 0.5)
factors = st.floats(0.1, 10.0)


@given(sizes)
def test_solid_circle_is_the_textbook_one(d):
    section = circle(diameter=d)
    assert section.area == pytest.approx(math.pi * d**2 / 4, rel=1e-14)
    assert section.Iy == section.Iz == pytest.approx(math.pi * d**4 / 64, rel=1e-14)
    assert pytest.approx(math.pi * d**4 / 32, rel=1e-14) == section.J


@given(sizes, st.floats(0.01, 0.49))
def test_tube_is_its_outside_less_its_hollow(d, part):
    inner = d - 2 * part * d
    tube = circle(diameter=d, wall=part * d)
    expected = np.subtract(circle(diameter=d), circle(diameter=inner))
    np.testing.assert_allclose(tube, expected, rtol=1e-9)


@given(sizes, sizes, st.floats(0.01, 0.49))
def test_box_is_its_outside_less_its_hollow_but_for_torsion(height, width, part):
    wall = part * min(height, width)
    box = rectangle(height=height, width=width, wall=wall)
    hollow = rectangle(height=height - 2 * wall, width=width - 2 * wall)
    expected = np.subtract(rectangle(height=height, width=width), hollow)
    np.testing.assert_allclose(box[:3], expected[:3], rtol=1e-9)


def test_height_is_along_z():
    section = rectangle(height=0.3, width=0.2)
    assert section.Iy == pytest.approx(0.2 * 0.3**3 / 12, rel=1e-15)
    assert section.Iz == pytest.approx(0.3 * 0.2**3 / 12, rel=1e-15)


@pytest.mark.parametrize(
    ("sides", "coefficient"),
    [((1.0, 1.0), 0.1406), ((2.0, 1.0), 0.229), ((4.0, 1.0), 0.281), ((10.0, 1.0), 0.312)],
)
def test_torsion_of_solid_rectangles_is_timoshenko_and_goodiers_table(sides, coefficient):
    a, b = sides
    assert rectangle(height=a, width=b).J / (a * b**3) == pytest.approx(coefficient, abs=1e-3)


def torsion_in_fifty_digits(a, b):
    with mpmath.workdps(50):

        def term(k):
            n = 2 * k + 1
            return mpmath.tanh(n * mpmath.pi * mpmath.mpf(a) / (2 * mpmath.mpf(b))) / n**5

        series = mpmath.nsum(term, [0, mpmath.inf])
        return float(
            mpmath.mpf(a) * mpmath.mpf(b) ** 3 * (mpmath.mpf(1) / 3) - 64 * b**4 / mpmath.pi**5 * series
        )


@pytest.mark.parametrize("sides", [(1.0, 1.0), (0.7, 0.71), (2.0, 1.0), (3.0, 7.0), (50.0, 1.0)])
def test_torsion_of_solid_rectangles_is_exact_to_rounding(sides):
    expected = torsion_in_fifty_digits(max(sides), min(sides))
    assert pytest.approx(expected, rel=2e-15) == rectangle(height=sides[0], width=sides[1]).J


def test_torsion_has_no_kink_at_the_square():
    h = 1e-4
    low, mid, high = (rectangle(height=1 + step, width=1.0).J for step in (-h, 0, h))
    curvature = (low - 2 * mid + high) / h**2
    assert (mid - low) / h == pytest.approx((high - mid) / h, abs=1.01 * h * abs(curvature))
    assert abs(curvature) < 1


def membrane(a, b, wall, divisions):
    """J = 2 ∫φ by five-point differences: ∇²φ = −2, φ = 0 outside, one value over the hollow."""
    h = b / divisions
    i, j = np.indices((round(a / h) + 1, divisions + 1))
    depth = np.minimum.reduce([i, j, i.max() - i, j.max() - j])
    free, hollow = (depth > 0) & (depth < round(wall / h)), depth >= round(wall / h)
    n = np.count_nonzero(free)
    unknown = np.full(i.shape, n + 1)
    unknown[free], unknown[hollow] = np.arange(n), n
    heads = np.concatenate([unknown[:-1].ravel(), unknown[:, :-1].ravel()])
    tails = np.concatenate([unknown[1:].ravel(), unknown[:, 1:].ravel()])
    ones, edges = np.ones(heads.size), np.arange(heads.size)
    rises = sparse.csr_array((ones, (edges, heads))) - sparse.csr_array((ones, (edges, tails)))
    load = 2 * h**2 * np.bincount(unknown.ravel())[: n + 1]
    return load @ spsolve((rises.T @ rises)[: n + 1, : n + 1].tocsc(), load)


@pytest.mark.parametrize(
    ("sides", "wall", "low", "high"),
    [
        ((1.0, 1.0), 0.1, 0.955, 0.97),
        ((1.0, 1.0), 0.25, 0.93, 0.945),
        ((2.0, 1.0), 0.1, 0.965, 0.98),
        ((2.0, 1.0), 0.4, 0.95, 0.97),
        ((4.0, 1.0), 0.2, 0.965, 0.98),
    ],
)
def test_torsion_of_boxes_is_within_what_its_docstring_says(sides, wall, low, high):
    found = rectangle(height=sides[0], width=sides[1], wall=wall).J
    assert low < found / membrane(*sides, wall, divisions=40) < high


def test_torsion_of_thin_boxes_is_bredts():
    height, width, wall = 0.2, 0.1, 1e-5
    bredt = 2 * (height * width) ** 2 * wall / (height + width)
    assert pytest.approx(bredt, rel=5e-4) == rectangle(height=height, width=width, wall=wall).J


def test_torsion_where_no_hollow_is_left_is_near_the_solid_one():
    for side in (1.0, 1.5, 2.0, 4.0):
        box, solid = rectangle(height=side, width=1.0, wall=0.4999), rectangle(height=side, width=1.0)
        assert pytest.approx(solid.J, rel=0.04) == box.J


@given(sizes, sizes, factors, st.none() | st.floats(0.01, 0.49))
def test_sections_scale_with_their_powers_of_length(height, width, factor, part):
    wall = None if part is None else part * min(height, width)
    scaled = None if wall is None else wall * factor
    powers = np.array([2, 4, 4, 4])
    for small, large in (
        (
            rectangle(height=height, width=width, wall=wall),
            rectangle(height=height * factor, width=width * factor, wall=scaled),
        ),
        (
            circle(diameter=max(height, width), wall=wall),
            circle(diameter=max(height, width) * factor, wall=scaled),
        ),
    ):
        np.testing.assert_allclose(large, np.array(small) * factor**powers, rtol=1e-9)


@given(sizes, sizes, st.none() | st.floats(0.01, 0.49))
def test_a_turned_rectangle_exchanges_its_second_moments(height, width, part):
    wall = None if part is None else part * min(height, width)
    one = rectangle(height=height, width=width, wall=wall)
    other = rectangle(height=width, width=height, wall=wall)
    np.testing.assert_allclose(other, [one.area, one.Iz, one.Iy, one.J], rtol=1e-12)


@pytest.mark.parametrize("wall", [0.0, -0.001, 0.01, 0.02])
def test_a_wall_that_leaves_no_hollow_is_refused(wall):
    with pytest.raises(ValueError, match=r"less than 0\.01 m, half of the smallest outer size"):
        circle(diameter=0.02, wall=wall)
    with pytest.raises(ValueError, match=r"less than 0\.01 m, half of the smallest outer size"):
        rectangle(height=0.05, width=0.02, wall=wall)

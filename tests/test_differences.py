"""Difference quotients against derivatives known by hand, inside the box, on its bounds, and beside a gap."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from orthospec.composite.differences import hessian, jacobian, positive_part

FREE = np.full(3, np.inf)


def smooth(points):
    x, y, z = points.T
    return np.stack([np.exp(x) * np.sin(y), x * y * z + z**2, np.sqrt(4 + x + y * y)], axis=1)


def slopes_at(x, y, z):
    root = 2 * np.sqrt(4 + x + y * y)
    return np.array(
        [
            [np.exp(x) * np.sin(y), np.exp(x) * np.cos(y), 0],
            [y * z, x * z, x * y + 2 * z],
            [1 / root, 2 * y / root, 0],
        ]
    )


def bend_at(x, y, z, weights):
    """Hessian of weights·smooth."""
    a = np.exp(x) * np.array([[np.sin(y), np.cos(y), 0], [np.cos(y), -np.sin(y), 0], [0, 0, 0]])
    b = np.array([[0, z, y], [z, 0, x], [y, x, 2]])
    s = 4 + x + y * y
    c = np.array([[-1 / 4, -y / 2, 0], [-y / 2, s - y * y, 0], [0, 0, 0]]) / s**1.5
    return weights[0] * a + weights[1] * b + weights[2] * c


points = st.tuples(*[st.floats(-1.5, 1.5)] * 3).map(np.array)


@settings(deadline=None)
@given(points)
def test_jacobian_is_central_in_the_open(x):
    values, slopes = jacobian(smooth, x, np.ones(3), -FREE, FREE)
    np.testing.assert_array_equal(values, smooth(x[None])[0])
    np.testing.assert_allclose(slopes, slopes_at(*x), atol=1e-9)


@settings(deadline=None)
@given(points, st.tuples(*[st.sampled_from([-1, 0, 1])] * 3))
def test_jacobian_is_second_order_on_a_bound_and_never_leaves_the_box(x, ends):
    lower = np.where(np.array(ends) == -1, x, x - 1.0)
    upper = np.where(np.array(ends) == 1, x, x + 1.0)

    def watched(points):
        assert (points >= lower).all()
        assert (points <= upper).all()
        return smooth(points)

    slopes = jacobian(watched, x, np.ones(3), lower, upper)[1]
    np.testing.assert_allclose(slopes, slopes_at(*x), atol=1e-8)


def test_jacobian_follows_the_scale_of_the_variables():
    """f(1e6 x) with scale 1e-6 has the digits of f(x)."""
    scale = np.full(3, 1e-6)
    x = np.array([0.3, -0.2, 0.9]) * scale
    slopes = jacobian(lambda points: smooth(points / scale), x, scale, -FREE, FREE)[1]
    np.testing.assert_allclose(slopes * scale, slopes_at(*(x / scale)), atol=1e-9)


@pytest.mark.parametrize("gap", [-1.0, 1.0])
def test_a_neighbour_that_cannot_be_evaluated_leaves_a_one_sided_quotient(gap):
    def broken(points):
        values = smooth(points)
        values[gap * points[:, 0] > 0.0] = np.nan
        return values

    slopes = jacobian(broken, np.zeros(3), np.ones(3), -FREE, FREE)[1]
    np.testing.assert_allclose(slopes, slopes_at(0, 0, 0), atol=1e-5)


def test_no_neighbour_at_all_is_nan():
    def lonely(points):
        values = smooth(points)
        values[(points != 0).any(axis=1)] = np.nan
        return values

    values, slopes = jacobian(lonely, np.zeros(3), np.ones(3), -FREE, FREE)
    assert np.isfinite(values).all()
    assert np.isnan(slopes).all()


@settings(deadline=None)
@given(points)
def test_hessian_of_a_weighted_sum(x):
    weights = np.array([0.7, -1.2, 2.0])
    found = hessian(smooth, weights, x, np.ones(3), -FREE, FREE)
    np.testing.assert_array_equal(found, found.T)
    np.testing.assert_allclose(found, bend_at(*x, weights), atol=1e-6)


def test_hessian_of_a_quadratic_is_exact_on_a_bound_too():
    q = np.array([[2.0, -1.0, 0.5], [-1.0, 3.0, 0.0], [0.5, 0.0, -1.0]])

    def quadratic(points):
        return np.einsum("ni,ij,nj->n", points, q, points)[:, None] / 2

    found = hessian(quadratic, np.ones(1), np.zeros(3), np.ones(3), np.zeros(3), np.ones(3))
    np.testing.assert_allclose(found, q, atol=1e-7)


def test_rows_without_weight_may_be_nan():
    def half(points):
        return np.column_stack([points[:, 0] ** 2, np.full(len(points), np.nan)])

    found = hessian(half, np.array([1.0, 0.0]), np.ones(2), np.ones(2), -FREE[:2], FREE[:2])
    np.testing.assert_allclose(found, [[2, 0], [0, 0]], atol=1e-6)


def test_curvature_that_cannot_be_had_counts_as_none():
    found = hessian(
        lambda points: np.full((len(points), 1), np.nan),
        np.ones(1),
        np.zeros(2),
        np.ones(2),
        -FREE[:2],
        FREE[:2],
    )
    np.testing.assert_array_equal(found, np.zeros((2, 2)))


@pytest.mark.parametrize("off", [0.0, 3e-5, 4e-5, -1.2e-4])
def test_a_kink_has_no_curvature(off):
    def kinked(points):
        x, y = points.T
        return np.column_stack([np.maximum(x - off, 0.0), x**2 + x * y])

    found = hessian(kinked, np.ones(2), np.zeros(2), np.ones(2), -FREE[:2], FREE[:2])
    np.testing.assert_allclose(found, [[2, 1], [1, 0]], atol=1e-6)


@given(st.integers(0, 2**32 - 1))
def test_positive_part_is_the_nearest_semidefinite_matrix(seed):
    matrix = np.random.default_rng(seed).normal(size=(4, 4))
    matrix = (matrix + matrix.T) / 2
    part = positive_part(matrix)
    rest = matrix - part
    assert np.linalg.eigvalsh(part)[0] >= -1e-12
    assert np.linalg.eigvalsh(rest)[-1] <= 1e-12
    assert np.trace(part @ rest) == pytest.approx(0.0, abs=1e-12)

"""Curvature of a greatest value whose place moves, against functions whose greatest value is known."""

from __future__ import annotations

import numpy as np
import pytest

from orthospec.workspace.drift import Box, moving_curvature

WIDE = Box(np.full(2, -9.0), np.full(2, 9.0), np.ones(2))


def bowl(x, u):
    """F = x₀·u₀ + 2 x₁ u₁ − u₀² − 3 u₁² + u₀ u₁ + x₀ x₁: its greatest over u bends by F_xu (−F_uu)⁻¹ F_ux."""
    a, b = u.T
    return (x[0] * a + 2 * x[1] * b - a**2 - 3 * b**2 + a * b + x[0] * x[1])[None]


def expected(free):
    mixed, fall = np.diag([1.0, 2.0])[:, free], np.array([[2.0, -1.0], [-1.0, 6.0]])[np.ix_(free, free)]
    return mixed @ np.linalg.inv(fall) @ mixed.T


@pytest.mark.parametrize(
    ("u", "free"), [((0.1, -0.2), [0, 1]), ((0.5, 0.0), [1]), ((0.1, -0.5), [0]), ((0.5, -0.5), [])]
)
def test_only_free_coordinates_move(u, free):
    found = moving_curvature(bowl, np.array([[3.0]]), np.array([u]), np.array([0.3, 0.1]), WIDE)
    np.testing.assert_allclose(found, 3 * expected(free), atol=1e-6)


def test_a_point_that_is_no_peak_adds_nothing_and_one_that_cannot_be_computed_neither():
    def saddle(x, u):
        return np.array([x[0] * u[:, 0] + u[:, 0] ** 2, np.where(u[:, 0] > 0, np.nan, u[:, 0])])

    u, weights = np.array([[0.0, 0.5]]), np.array([[1.0], [2.0]])
    np.testing.assert_array_equal(moving_curvature(saddle, weights, u, np.zeros(2), WIDE), np.zeros((2, 2)))


def test_weights_and_points_add_up_and_a_reversed_row_takes_away():
    u = np.array([[0.0, 0.0], [0.2, 0.1]])
    found = moving_curvature(bowl, np.array([[2.0, -0.5]]), u, np.array([9.0, 0.0]), WIDE)
    np.testing.assert_allclose(found, 1.5 * expected([0, 1]), atol=1e-6)

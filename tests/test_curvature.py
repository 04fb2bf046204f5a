"""A convex stand-in for a Hessian: true along what binds, and never indefinite."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from orthospec.composite.curvature import binding_gradients, bound_gradients, convex_part, directions
from orthospec.composite.subproblem import HalfLines, Rows, solve


@given(st.integers(0, 10_000), st.integers(0, 4))
def test_it_is_semidefinite_and_true_along_the_null_space(seed, count):
    """There the Hessian is made positive: what remains is exact."""
    random = np.random.default_rng(seed)
    gradients = np.column_stack([random.normal(size=(count, 4)), np.zeros(count)])
    hessian = random.normal(size=(4, 4))
    hessian = hessian + hessian.T
    along = np.linalg.svd(np.vstack([gradients[:, :4], np.zeros((4, 4))]))[2][count:]
    hessian += along.T @ along * 20
    found = convex_part(hessian, *directions(gradients))
    assert np.linalg.eigvalsh(found).min() > -1e-9
    np.testing.assert_allclose(along @ found @ along.T, along @ hessian @ along.T, atol=1e-8)


@given(st.integers(0, 10_000), st.integers(0, 4))
def test_directions_along_rows_leave_them_as_they_are_and_the_others_complete_them(seed, count):
    gradients = np.random.default_rng(seed).normal(size=(count, 5))
    along, across = directions(gradients)
    both = np.hstack([along, across])
    np.testing.assert_allclose(both.T @ both, np.eye(4), atol=1e-12)
    # Four variables and the factor: so many rows, in general position, leave 5 − count directions of both.
    assert along.shape == (4, min(4, 5 - count))


def test_at_a_vertex_no_direction_is_left():
    along, across = directions(np.array([[1.0, 0.0, -1.0], [-1.0, 0.5, -1.0], [0.0, 1.0, 0.0]]))
    assert along.shape == (2, 0)
    assert across.shape == (2, 2)


def test_without_rows_it_is_the_positive_part():
    np.testing.assert_allclose(
        convex_part(np.diag([3.0, -2.0]), *directions(np.zeros((0, 3)))), np.diag([3.0, 0.0])
    )


def test_negative_curvature_across_a_row_does_not_stiffen_it_along():
    """H = −n nᵀ + t tᵀ mixed: the positive part of the whole would leave more than tᵀHt along t."""
    hessian, row = np.array([[1.0, 2.0], [2.0, -1.0]]), np.array([[0.0, 1.0, 0.0]])
    assert convex_part(hessian, *directions(row))[0, 0] == pytest.approx(1.0)


def test_rows_of_soft_goals_bind_with_the_factor():
    """Two goals that rise against each other: along both, x cannot move; with one alone, it may."""
    rows = Rows((), HalfLines(0, np.ones(2), np.zeros(2)))
    slopes = np.array([[1.0, 0.0], [-1.0, 0.0]])
    step = solve(rows, np.zeros(2), slopes, np.eye(2), -np.ones(2), np.ones(2), penalty=10.0)
    gradients = binding_gradients(rows, slopes, step)
    np.testing.assert_allclose(gradients, np.array([[1, 0, -1], [-1, 0, -1]]) / np.sqrt(2), atol=1e-6)
    np.testing.assert_allclose(
        convex_part(np.diag([-5.0, 4.0]), *directions(gradients)), np.diag([0.0, 4.0]), atol=1e-9
    )


def test_a_variable_pressed_on_its_bound_is_held_and_one_on_the_trust_region_is_not():
    rows = Rows((), HalfLines(0, np.ones(1), np.zeros(1)))
    slopes = np.array([[1.0, 1.0]])
    lower = np.array([0.0, -1.0])
    step = solve(rows, np.zeros(1), slopes, np.zeros((2, 2)), lower, np.ones(2), penalty=10.0)
    found = bound_gradients(step, np.array([0.0, 0.0]), np.array([0.0, -9.0]), np.full(2, 9.0))
    np.testing.assert_array_equal(found, [[1.0, 0.0, 0.0]])

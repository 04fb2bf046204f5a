"""The convex subproblem: answers and multipliers against optima known by hand."""

from __future__ import annotations

import cvxpy as cp
import numpy as np
import pytest

from orthospec.composite.subproblem import Block, HalfLines, Rows, solve
from orthospec.composite.template import compile_form


def lines(on_factor, on_slack):
    return Rows((), HalfLines(0, np.array(on_factor, dtype=float), np.array(on_slack, dtype=float)))


def test_a_linear_program_ends_in_its_vertex():
    """min λ, δ1 + 2 <= λ, δ2 − δ1 <= λ in |δ| <= 1: the first row and δ1 = −1 bind, λ = 1."""
    rows = lines([1, 1], [0, 0])
    slopes = np.array([[1.0, 0.0], [-1.0, 1.0]])
    step = solve(rows, np.array([2.0, 0.0]), slopes, np.zeros((2, 2)), -np.ones(2), np.ones(2), penalty=10.0)
    assert step.factor == pytest.approx(1.0, abs=1e-9)
    assert step.delta[0] == pytest.approx(-1.0, abs=1e-9)
    np.testing.assert_allclose(step.multipliers, [1.0, 0.0], atol=1e-8)
    np.testing.assert_allclose(step.on_bounds[0], [1.0, 0.0], atol=1e-8)


def test_curvature_counts():
    """min λ + δ², δ <= λ − 1 without bounds: δ = −1/2, λ = 1/2."""
    wide = np.full(1, 100.0)
    step = solve(lines([1], [0]), np.array([1.0]), np.ones((1, 1)), 2 * np.eye(1), -wide, wide, penalty=10.0)
    assert step.delta[0] == pytest.approx(-0.5, abs=1e-8)
    assert step.factor == pytest.approx(0.5, abs=1e-8)


def test_multipliers_are_the_price_of_a_shift():
    random = np.random.default_rng(2)
    rows, slopes, w = lines([1, 2, 1], [0, 0, 0]), random.normal(size=(3, 2)), random.normal(size=3)

    def factor(w):
        return solve(rows, w, slopes, np.eye(2), -np.ones(2), np.ones(2), penalty=10.0)

    step = factor(w)
    for i in range(3):
        moved = w.copy()
        moved[i] += 1e-5
        up = factor(moved)
        rise = up.factor + up.delta @ up.delta / 2 - step.factor - step.delta @ step.delta / 2
        assert rise / 1e-5 == pytest.approx(step.multipliers[i], abs=1e-3)


def test_conflicting_hard_rows_share_the_least_slack():
    """δ <= −1 + s and −δ <= −1 + s: slack 1 at δ = 0; the penalty is split over both."""
    rows = lines([0, 0], [1, 1])
    slopes = np.array([[1.0], [-1.0]])
    step = solve(rows, np.ones(2), slopes, np.zeros((1, 1)), -np.ones(1), np.ones(1), 8.0, factor_weight=0.0)
    assert step.slack == pytest.approx(1.0, abs=1e-9)
    assert step.delta[0] == pytest.approx(0.0, abs=1e-8)
    assert step.pressure == pytest.approx(8.0, abs=1e-6)
    np.testing.assert_allclose(step.shares, [4.0, 4.0], atol=1e-6)


def test_pressure_is_small_where_the_hard_rows_cost_little():
    """min λ: δ <= λ, −δ <= slack: δ = 0 for a penalty above the multiplier 1, slack for one below."""
    rows, slopes = lines([1, 0], [0, 1]), np.array([[1.0], [-1.0]])

    def answer(penalty):
        return solve(rows, np.zeros(2), slopes, np.zeros((1, 1)), -np.ones(1), np.ones(1), penalty)

    assert answer(10.0).pressure == pytest.approx(1.0, abs=1e-7)
    assert answer(10.0).slack == pytest.approx(0.0, abs=1e-8)
    assert answer(0.5).slack == pytest.approx(1.0, abs=1e-8)


class TestBlocks:
    """min λ, c·δ <= λ, with X(δ) = diag δ or the vector δ kept in its cone at several copies."""

    def answer(self, template, shape, radii, slopes_of):
        copies, n, width = len(radii), 2, int(np.prod(shape)) + 2
        w = np.zeros(1 + copies * width)
        slopes = np.zeros((len(w), n))
        slopes[0] = [-1.0, -1.0]
        for k, radius in enumerate(radii):
            at = 1 + k * width
            w[at + width - 2 : at + width] = radius, np.log(radius)
            slopes[at : at + width - 2] = slopes_of
        rows = Rows((Block(template, 1, copies),), HalfLines(0, np.ones(1), np.zeros(1)))
        return solve(rows, w, slopes, np.zeros((n, n)), -np.full(n, 9.0), np.full(n, 9.0), penalty=100.0)

    def test_second_order_cones_hold_at_every_copy(self):
        disc = compile_form(lambda x, bound, slack: [cp.norm(x) <= bound + slack], (2,))
        step = self.answer(disc, (2,), (3.0, 1.0, 2.0), np.eye(2))
        np.testing.assert_allclose(step.delta, np.full(2, np.sqrt(0.5)), atol=1e-7)
        assert step.factor == pytest.approx(-np.sqrt(2), abs=1e-8)
        # Only the tightest copy has multipliers: the gradient of its norm, (1, 1)/√2, times √2.
        inside = step.multipliers[1:].reshape(3, 4)[:, :2]
        np.testing.assert_allclose(inside, [[0, 0], [1, 1], [0, 0]], atol=1e-6)

    def test_auxiliary_variables_are_each_copys_own(self):
        def spread(x, bound, slack):
            middle = cp.Variable()
            return [cp.norm(x - middle, "inf") <= bound + slack]

        template = compile_form(spread, (2,))
        step = self.answer(template, (2,), (0.5, 1.0), np.array([[1.0, 0.0], [0.0, 0.0]]))
        assert step.delta[0] == pytest.approx(1.0, abs=1e-7)
        assert step.delta[1] == pytest.approx(9.0, abs=1e-7)

    def test_semidefinite_cones_hold(self):
        below = compile_form(lambda x, bound, slack: [x << (bound + slack) * np.eye(2)], (2, 2))
        slopes = np.zeros((4, 2))
        slopes[0, 0] = slopes[3, 1] = 1.0
        step = self.answer(below, (2, 2), (0.7,), slopes)
        np.testing.assert_allclose(step.delta, [0.7, 0.7], atol=1e-7)


def test_an_empty_box_gives_no_step():
    rows = lines([1], [0])
    assert solve(rows, np.zeros(1), np.ones((1, 1)), np.zeros((1, 1)), np.ones(1), -np.ones(1), 1.0) is None

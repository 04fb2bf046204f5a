"""The convex-composite trust region: a smallest problem for each ending, and what it promises on the way."""

from __future__ import annotations

import numpy as np
import pytest

from orthospec.composite import trust_region
from orthospec.composite.subproblem import HalfLines, Rows
from orthospec.composite.trust_region import Assessment, Ending, minimise


class Scalar:
    """min λ, soft(x) <= λ, hard(x) <= 0, over one variable; counts what it is asked."""

    def __init__(self, soft=None, hard=None, lower=-np.inf, upper=np.inf):
        self.soft, self.hard = soft, hard
        self.lower, self.upper, self.scale = np.array([lower]), np.array([upper]), np.ones(1)
        self.has_factor = soft is not None
        self.asked = []

    def values(self, x):
        return np.array([f(float(x[0])) for f in (self.soft, self.hard) if f is not None])

    def assess(self, x):
        self.asked.append(float(x[0]))
        factor = self.soft(float(x[0])) if self.soft else 0.0
        violation = max(0.0, self.hard(float(x[0]))) if self.hard else 0.0
        if not np.isfinite([factor, violation]).all():
            return Assessment(x, np.inf, np.inf)
        return Assessment(x, factor, violation)

    def rows(self, x):  # noqa: ARG002
        kinds = [kind for kind, f in ((1.0, self.soft), (0.0, self.hard)) if f is not None]
        return Rows((), HalfLines(0, np.array(kinds), 1.0 - np.array(kinds)))

    def smooth(self, points, rows):  # noqa: ARG002
        return np.array([self.values(x) for x in points])

    def drift(self, x, rows, step):  # noqa: ARG002
        return np.zeros((1, 1))


def test_a_vertex_is_reached_at_first_order():
    found = minimise(Scalar(lambda x: x, lambda x: 2 - x * x, lower=0.1), np.array([3.0]))
    assert found.ending is Ending.SOLVED
    assert found.x[0] == pytest.approx(np.sqrt(2), abs=1e-9)
    assert found.violation <= 1e-9
    assert found.subproblems <= 12


def test_a_vertex_asks_for_no_second_differences(monkeypatch):
    problem, asked = Scalar(lambda x: x, lambda x: 2 - x * x, lower=0.1), []
    monkeypatch.setattr(trust_region, "hessian", lambda *_: asked.append(1) or np.zeros((1, 1)))
    assert minimise(problem, np.array([1.5])).x[0] == pytest.approx(np.sqrt(2), abs=1e-9)
    assert not asked


def test_a_smooth_minimum_is_reached_by_curvature():
    found = minimise(Scalar(lambda x: np.cosh(x - 0.7)), np.array([4.0]))
    assert found.ending is Ending.SOLVED
    assert found.x[0] == pytest.approx(0.7, abs=1e-5)
    assert found.factor == pytest.approx(1.0, abs=1e-10)
    assert found.subproblems <= 30


def test_no_feasible_point_ends_infeasible_with_the_least_violation():
    found = minimise(Scalar(lambda x: -x, lambda x: 1 + (x - 0.5) ** 2), np.array([3.0]))
    assert found.ending is Ending.INFEASIBLE
    assert found.violation == pytest.approx(1.0, abs=1e-8)
    assert found.x[0] == pytest.approx(0.5, abs=1e-4)
    assert found.subproblems <= 30


def test_a_penalty_too_small_is_raised_before_a_step_is_taken():
    """A unit of x is worth fifty of λ, and the first penalty asks ten for it."""
    found = minimise(Scalar(lambda x: -50 * x, lambda x: x), np.array([0.1]))
    assert found.history[0].violation == pytest.approx(0.0, abs=1e-9)
    assert found.ending is Ending.SOLVED
    assert found.x[0] == pytest.approx(0.0, abs=1e-9)


def test_the_penalty_stays_small_where_nothing_comes_nearer_to_feasibility():
    found = minimise(Scalar(lambda x: -x, lambda x: 1 + (x - 0.5) ** 2), np.array([3.0]))
    assert found.ending is Ending.INFEASIBLE
    assert found.x[0] == pytest.approx(0.5, abs=1e-4)
    assert max(iterate.penalty for iterate in found.history) <= 100


def test_without_a_factor_any_feasible_point_will_do():
    found = minimise(Scalar(hard=lambda x: x * x - 4), np.array([7.0]))
    assert found.ending is Ending.SOLVED
    assert abs(found.x[0]) <= 2 + 1e-9


def test_a_feasible_start_without_a_factor_stays():
    found = minimise(Scalar(hard=lambda x: x - 4), np.array([1.25]))
    assert found.ending is Ending.SOLVED
    assert found.violation == 0.0


def test_a_start_that_cannot_be_evaluated_is_stalled():
    found = minimise(Scalar(lambda _: np.nan), np.array([1.0]))
    assert found.ending is Ending.STALLED
    assert found.subproblems == 0
    assert found.step is None


def test_the_limit_of_subproblems_is_kept():
    found = minimise(Scalar(lambda x: x), np.array([0.0]), most=7)
    assert found.ending is Ending.EXHAUSTED
    assert 7 <= found.subproblems <= 8


def test_trial_points_that_cannot_be_evaluated_are_refused():
    """ln ends at 0; the minimum of x − ln x is 1, and the first steps overshoot to where there is nothing."""

    def soft(x):
        return 5 * x - np.log(x) if x > 0 else np.nan

    found = minimise(Scalar(soft), np.array([1.2]), radius=1.0)
    assert found.ending is Ending.SOLVED
    assert found.x[0] == pytest.approx(0.2, abs=1e-5)


def test_the_box_is_never_left():
    problem = Scalar(lambda x: -x, lambda x: x - 9, lower=-1.0, upper=2.0)
    found = minimise(problem, np.array([-1.0]))
    assert found.x[0] == pytest.approx(2.0, abs=1e-9)
    assert min(problem.asked) >= -1.0
    assert max(problem.asked) <= 2.0
    assert found.step.on_bounds[0, 1] == pytest.approx(1.0, abs=1e-6)


def test_merit_never_rises_where_a_feasible_start_stays_feasible():
    found = minimise(Scalar(lambda x: (x - 3) ** 2, lambda x: x - 1), np.array([-5.0]))
    factors = [iterate.factor for iterate in found.history if iterate.violation == 0]
    assert factors == sorted(factors, reverse=True)
    assert found.x[0] == pytest.approx(1.0, abs=1e-9)


def test_each_iterate_is_told():
    told = []
    found = minimise(
        Scalar(lambda x: x, lambda x: 2 - x * x, lower=0.1),
        np.array([3.0]),
        on_iterate=lambda here, iterate: told.append((here.factor, iterate)),
    )
    assert [iterate for _, iterate in told][: len(found.history)] == list(found.history)
    assert told[-1][0] == found.factor


def test_every_ending_says_what_to_do():
    for ending in Ending:
        assert ending is Ending.SOLVED or len(ending.value.split()) > 5

"""Goal attainment of plain functions: textbook problems with known optima, each in at most 30 subproblems."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest

from orthospec.composite.goals import attain_goals
from orthospec.composite.trust_region import Ending


class Textbook(NamedTuple):
    """min λ with f − wλ <= goal; what it must give."""

    functions: object
    start: tuple
    goals: tuple
    weights: tuple
    x: tuple | None
    factor: float
    lower: object = -np.inf
    upper: object = np.inf


def fgoalattain_simple(x):
    return [2 + (x[0] - 3) ** 2, 5 + x[0] ** 2 / 4]


def pole_placement(x):
    a = np.array([[-0.5, 0, 0], [0, -2, 10], [0, 1, -2]])
    b = np.array([[1, 0], [-2, 2], [0, 1]])
    c = np.array([[1, 0, 0], [0, 0, 1]])
    return np.sort(np.linalg.eigvals(a + b @ x.reshape(2, 2) @ c).real)


def cb2(x):
    return [x[0] ** 2 + x[1] ** 4, (2 - x[0]) ** 2 + (2 - x[1]) ** 2, 2 * np.exp(x[1] - x[0])]


def cb3(x):
    return [x[0] ** 4 + x[1] ** 2, (2 - x[0]) ** 2 + (2 - x[1]) ** 2, 2 * np.exp(x[1] - x[0])]


def demyanov_malozemov(x):
    return [5 * x[0] + x[1], -5 * x[0] + x[1], x[0] ** 2 + x[1] ** 2 + 4 * x[1]]


def lq(x):
    return [-x[0] - x[1], -x[0] - x[1] + x[0] ** 2 + x[1] ** 2 - 1]


def ql(x):
    square = x[0] ** 2 + x[1] ** 2
    return [square, square + 10 * (4 - 4 * x[0] - x[1]), square + 10 * (6 - x[0] - 2 * x[1])]


def rosenbrock(x):
    return [100 * (x[1] - x[0] ** 2) ** 2 + (1 - x[0]) ** 2]


def wong_1(x):
    """Hock and Schittkowski 43 (Rosen and Suzuki): an objective and three hard rows."""
    a, b, c, d = x
    return [
        a * a + b * b + 2 * c * c + d * d - 5 * a - 5 * b - 21 * c + 7 * d,
        a * a + b * b + c * c + d * d + a - b + c - d,
        a * a + 2 * b * b + c * c + 2 * d * d - a - d,
        2 * a * a + b * b + c * c + 2 * a - b - d,
    ]


def hs_35(x):
    a, b, c = x
    cost = 9 - 8 * a - 6 * b - 4 * c + 2 * a * a + 2 * b * b + c * c + 2 * a * b + 2 * a * c
    return [cost, a + b + 2 * c]


PROBLEMS = {
    "MATLAB fgoalattain": Textbook(fgoalattain_simple, (0.5,), (3, 6), (1, 1), (2,), 0.0),
    "Charalambous-Bandler 2": Textbook(
        cb2, (1, -0.1), (0, 0, 0), (1, 1, 1), (1.13903765, 0.89955993), 1.9522244939
    ),
    "Charalambous-Bandler 3": Textbook(cb3, (2, 2), (0, 0, 0), (1, 1, 1), (1, 1), 2.0),
    "Demyanov-Malozemov": Textbook(demyanov_malozemov, (1, 1), (0, 0, 0), (1, 1, 1), (0, -3), -3.0),
    "LQ": Textbook(lq, (-0.5, -0.5), (0, 0), (1, 1), None, -np.sqrt(2)),
    "QL": Textbook(ql, (-1, 5), (0, 0, 0), (1, 1, 1), (1.2, 2.4), 7.2),
    "Rosen-Suzuki, hard rows": Textbook(
        wong_1, (0, 0, 0, 0), (0, 8, 10, 5), (1, 0, 0, 0), (0, 1, 2, -1), -44.0
    ),
    "Hock-Schittkowski 35, a smooth trade-off": Textbook(
        hs_35, (0.5, 0.5, 0.5), (0, 3), (1, 0), (4 / 3, 7 / 9, 4 / 9), 1 / 9, lower=0.0
    ),
    "a parabola, weights 2 and 1": Textbook(
        lambda x: [x[0] ** 2, (x[0] - 3) ** 2], (10.0,), (0, 0), (4, 1), (2,), 1.0
    ),
    "start on a bound that does not hold it": Textbook(
        lambda x: [(x[0] - 0.3) ** 2 + (x[1] - 0.6) ** 2], (0, 1), (0,), (1,), (0.3, 0.6), 0.0, 0.0, 1.0
    ),
    "start on the bound that holds it": Textbook(
        lambda x: [x[0] + x[1] ** 2], (0, 1), (0,), (1,), (0, 0), 0.0, 0.0, 1.0
    ),
}


@pytest.mark.parametrize("name", PROBLEMS)
def test_textbook_problem_ends_in_its_optimum(name):
    problem = PROBLEMS[name]
    found = attain_goals(
        problem.functions, problem.start, problem.goals, problem.weights, problem.lower, problem.upper
    )
    assert found.ending is Ending.SOLVED
    assert found.factor == pytest.approx(problem.factor, rel=1e-8, abs=1e-8)
    assert found.violation <= 1e-9
    assert found.subproblems <= 30
    if problem.x is not None:
        np.testing.assert_allclose(found.x, problem.x, atol=2e-5)


def test_fgoalattain_example_is_attained_exactly():
    found = attain_goals(fgoalattain_simple, [0.5], goals=[3, 6], weights=[1, 1])
    assert found.x[0] == pytest.approx(2.0, abs=1e-8)
    assert found.factor == pytest.approx(0.0, abs=1e-8)
    np.testing.assert_allclose(fgoalattain_simple(found.x), [3, 6], atol=1e-7)


def test_pole_placement_is_matlabs():
    found = attain_goals(
        pole_placement, [-1, -1, -1, -1], goals=[-5, -3, -1], weights=[5, 3, 1], lower=-4, upper=4
    )
    assert found.ending is Ending.SOLVED
    assert found.subproblems <= 30
    np.testing.assert_allclose(found.x, [-4, -0.2564, -4, -4], atol=5e-5)
    np.testing.assert_allclose(pole_placement(found.x), [-6.9313, -4.1588, -1.4099], atol=5e-5)
    assert found.factor == pytest.approx(-0.3863, abs=5e-5)


def test_rosenbrocks_valley_is_followed_to_its_end():
    found = attain_goals(rosenbrock, [-1.2, 1.0], goals=[0], weights=[1])
    assert found.factor == pytest.approx(0.0, abs=1e-8)
    np.testing.assert_allclose(found.x, [1, 1], atol=1e-3)


def test_larger_weight_gives_its_goal_more_slack():
    def legs(x):
        return [x[0], 1 / x[0]]

    for weights in ((1, 1), (3, 1), (1, 5)):
        found = attain_goals(legs, [2.0], goals=[0.5, 0.5], weights=weights, lower=0.1, upper=10)
        first, second = np.array(legs(found.x)) - 0.5
        assert first / weights[0] == pytest.approx(found.factor, abs=1e-8)
        assert second / weights[1] == pytest.approx(found.factor, abs=1e-8)


def test_conflicting_hard_goals_end_infeasible_with_the_least_violation():
    found = attain_goals(
        lambda x: [x[1] ** 2 - x[0], x[0] + 1, 1 - x[0]], [3.0, 1.0], goals=[0, 0, 0], weights=[1, 0, 0]
    )
    assert found.ending is Ending.INFEASIBLE
    assert found.violation == pytest.approx(1.0, abs=1e-8)
    assert found.subproblems <= 30


def test_hard_goals_alone_find_a_feasible_point():
    found = attain_goals(
        lambda x: [x[0] ** 2 + x[1] ** 2, -x[0] - x[1]], [5, -3], goals=[1, -1], weights=[0, 0]
    )
    assert found.ending is Ending.SOLVED
    assert found.violation <= 1e-9
    assert found.x @ found.x <= 1 + 1e-8
    assert found.x.sum() >= 1 - 1e-8


def test_start_outside_of_the_box_is_brought_in():
    found = attain_goals(lambda x: [x[0]], [50.0], goals=[0], weights=[1], lower=1, upper=2)
    assert found.x[0] == pytest.approx(1.0, abs=1e-12)
    assert found.factor == pytest.approx(1.0, abs=1e-12)


def two_parabolas(x):
    return [x[0] ** 2, (x[0] - 3) ** 2]


@pytest.mark.parametrize(
    ("goals", "weights", "message"),
    [
        ([0, 0], [1, -1], "a weight is below 0: turn its sign, and those of its objective and goal"),
        ([0, 0], [1, np.nan], "a weight is below 0"),
        ([0, 0], [1], "2 goals, 1 weights and values of shape"),
        ([0, 0, 0], [1, 1, 1], r"3 goals, 3 weights and values of shape \(2,\)"),
    ],
)
def test_goals_and_weights_that_mean_nothing_are_refused(goals, weights, message):
    with pytest.raises(ValueError, match=message):
        attain_goals(two_parabolas, [0.5], goals, weights)

"""Pareto sets: the paper's front against SciPy's on the same corners, and sets of known shape."""

from __future__ import annotations

from itertools import product
from pathlib import Path

import numpy as np
import pytest
import yaml
from scipy.optimize import minimize

from orthospec.errors import SpecError
from orthospec.optimise.pareto import find_front
from orthospec.optimise.workers import Here
from orthospec.result import compose
from orthospec.result.model import Result
from orthospec.show import show
from orthospec.spec import load_spec

SPECS = Path(__file__).parents[1] / "specs"
CORNERS = np.array(list(product((-0.5, 0.5), repeat=3))) * [1, 1, 0.8]
PLANE = """\
orthospec: 1
variables: VARIABLES
manipulator: {use: orthoglide, leg_lengths: [1, 1, 1]}
workspace: {size: [0.2, 0.2, 0.2], divisions: 4}
goals: GOALS
optimise: {starts: 1}
pareto: {points: POINTS}
"""
"""The machine is always the same: the goals are functions of the variables alone."""


def least_base(third, most=2.0):
    """The shortest base legs for this third one: all eight corners in SLSQP, from the loop equations."""

    def margins(x):
        lengths = np.array([x[0], x[0], third])
        found = []
        for pose in CORNERS + np.array([x[1], x[1], x[2]]):
            rows = -pose / np.sqrt(lengths**2 - (pose @ pose - pose**2))[:, None]
            np.fill_diagonal(rows, 1)
            spread = np.log(np.linalg.eigvalsh(rows.T @ rows))
            found += [np.log(4) - spread.max(), 2 * np.log(most) + spread.min()]
        return np.array(found)

    solved = minimize(
        lambda x: x[0],
        [1.6, -0.09, -0.2],
        constraints={"type": "ineq", "fun": margins},
        method="SLSQP",
        options={"ftol": 1e-14, "maxiter": 300},
    )
    assert margins(solved.x).min() > -1e-10
    return solved.x[0]


def front_of(spec_of, variables, goals, points):
    text = PLANE.replace("VARIABLES", variables).replace("GOALS", goals).replace("POINTS", str(points))
    spec = spec_of(text)
    found = find_front(spec, Here()).points
    return np.array([point.met.gaps for point in found]), [point.is_knee for point in found]


@pytest.fixture(scope="module")
def front(outcome_of):
    return outcome_of("orthoglide-1x1x0.8-pareto").finding.pareto


def test_each_point_of_the_papers_front_is_the_shortest_base_for_its_third_leg(front):
    assert len(front) == 7
    for point in front:
        base, third = point.design.values["base"], point.design.values["third"]
        assert base == pytest.approx(least_base(third), abs=1e-6)
        assert point.evaluation.holds


def test_the_ends_are_each_goal_alone(front):
    assert front[0].design.values["third"] == 3.0
    assert front[0].design.values["base"] == pytest.approx(1.2931579121, abs=1e-8)
    assert front[-1].design.values["base"] == 3.0
    assert front[-1].design.values["third"] == pytest.approx(1.0369296063, abs=1e-8)


def test_no_point_is_better_than_another_and_they_are_evenly_spread(front):
    goals = np.array([[one.value for one in point.attainment.goals.values()] for point in front])
    assert (np.diff(goals[:, 0]) > 0).all()
    assert (np.diff(goals[:, 1]) < 0).all()
    scaled = (goals - goals.min(axis=0)) / np.ptp(goals, axis=0)
    along = (scaled @ [1, -1] + 1) / 2
    np.testing.assert_allclose(along, np.linspace(0, 1, 7), atol=1e-7)


def test_the_knee_stands_out_furthest_from_the_line_through_the_ends(front):
    goals = np.array([[one.value for one in point.attainment.goals.values()] for point in front])
    scaled = (goals - goals.min(axis=0)) / np.ptp(goals, axis=0)
    assert [point.is_knee for point in front].index(True) == scaled.sum(axis=1).argmin()
    assert sum(point.is_knee for point in front) == 1


def test_a_points_prices_are_of_bounds_and_ranges_alone(front):
    kinds = {limit.kind for point in front for limit in point.limits}
    assert kinds == {"bound", "variable"}
    middle = next(limit for limit in front[3].limits if limit.side == "at_most")
    assert middle.gain > 0
    assert middle.cost > 0


def test_an_ends_prices_are_of_its_goal_alone_in_parts_of_its_range(front):
    bases = [one.design.values["base"] for one in front]
    (limit,) = [one for one in front[0].limits if one.kind == "bound"]
    won = least_base(3.0) - least_base(3.0, most=2.02)
    assert limit.gain == pytest.approx(won / (max(bases) - min(bases)), rel=1e-4)


def test_a_concave_set_is_covered_and_has_no_knee(spec_of):
    goals = '{f: {minimise: x, goal: 2}, g: {minimise: "2 - x**2", goal: 3}}'
    gaps, knees = front_of(spec_of, "{x: {min: 0, max: 1}}", goals, 5)
    x = gaps[:, 0] + 2
    np.testing.assert_allclose(gaps[:, 1] + 3, 2 - x**2, atol=1e-8)
    np.testing.assert_allclose((x + x**2) / 2, np.linspace(0, 1, 5), atol=1e-7)
    assert len(x) == 5
    assert not any(knees)


def test_where_the_set_has_a_gap_nothing_dominated_is_told(spec_of):
    """g falls, rises and falls again: what lies on the rise, and above the first valley, is no answer."""
    text = "1 - x + 0.3 * sin(9.42477796 * x)"
    goals = f'{{f: {{minimise: x, goal: 1}}, g: {{minimise: "{text}", goal: 2}}}}'
    gaps, _ = front_of(spec_of, "{x: {min: 0, max: 1}}", goals, 9)
    x, g = gaps[:, 0] + 1, gaps[:, 1] + 2
    every = np.linspace(0, 1, 20001)
    of_every = 1 - every + 0.3 * np.sin(9.42477796 * every)
    for one, value in zip(x, g, strict=True):
        assert value <= of_every[every <= one + 1e-9].min() + 1e-6
    assert 2 <= len(x) <= 9


def test_goals_that_agree_have_a_set_of_one_point(spec_of):
    goals = "{f: {minimise: x, goal: 1}, g: {minimise: 2 * x + 1, goal: 2}}"
    gaps, knees = front_of(spec_of, "{x: {min: 0.5, max: 1}}", goals, 5)
    np.testing.assert_allclose(gaps, [[-0.5, 0.0]], atol=1e-8)
    assert knees == [False]


def test_of_ends_that_agree_the_one_that_is_best_in_both_is_told(spec_of):
    """f is flat up to 0.5, and alone leaves x at its start there; g alone wants 0.2."""
    goals = '{f: {minimise: "max(x, 0.5)", goal: 1}, g: {minimise: (x - 0.2)**2 + 1, goal: 2}}'
    gaps, _ = front_of(spec_of, "{x: {min: 0, max: 1, start: 0.45}}", goals, 5)
    np.testing.assert_allclose(gaps, [[-0.5, -1.0]], atol=1e-8)


def test_three_goals_lie_on_the_sphere_that_is_their_set(spec_of):
    """min 3 − x_i on the ball |x| <= 1, as hard goal: the set is the sphere's positive part."""
    names = "abc"
    soft = ", ".join(f"{n}: {{minimise: 3 - {n}1, goal: 1}}" for n in names)
    variables = ", ".join(f"{n}1: {{min: 0, max: 1, start: 0.5}}" for n in names)
    goals = f"{{{soft}, ball: {{minimise: a1**2 + b1**2 + c1**2, goal: 1, weight: 0}}}}"
    gaps, knees = front_of(spec_of, f"{{{variables}}}", goals, 6)
    assert len(gaps) == 6
    np.testing.assert_allclose(((2 - gaps) ** 2).sum(axis=1), 1, atol=1e-7)
    ends = [gap for gap in gaps if np.isclose(gap, 1).any()]
    assert len(ends) == 3
    assert sum(knees) == 1


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        (", g: {minimise: y, goal: 1}", "", "a Pareto set is of 2 or 3 goals with weights above 0, 1 given"),
        ("g: {minimise: y, goal: 1}", "g: {match: y, goal: 1, weight: 1}", "to match is a hard bound"),
    ],
)
def test_what_there_is_no_set_of_is_a_mistake(spec_of, old, new, said):
    text = PLANE.replace("VARIABLES", "{x: {min: 0, max: 1}, y: {min: 0, max: 1}}")
    goals = "{f: {minimise: x, goal: 1}, g: {minimise: y, goal: 1}}"
    text = text.replace("GOALS", goals).replace("POINTS", "3")
    assert spec_of(text).pareto == 3
    with pytest.raises(SpecError, match=said):
        spec_of(text.replace(old, new))


def test_a_result_holds_the_set_and_is_shown_with_it(outcome_of):
    spec = load_spec(SPECS / "orthoglide-1x1x0.8-pareto.yaml")
    content = yaml.safe_load(yaml.safe_dump(compose(spec, outcome_of("orthoglide-1x1x0.8-pareto").finding)))
    read = Result.model_validate(content)
    assert [one.knee for one in read.pareto].count(True) == 1
    keys = {"attainment", "variables", "manipulator", "indices", "joints", "workspace", "limits"}
    assert all(keys <= one.keys() for one in content["pareto"])
    text = " ".join(show(content, width=100, colour=False, spec=spec).split())
    assert "Pareto set: 7 designs" in text
    assert "1 1.29316 m 3 m 1.29316 m 3 m" in text

"""Pareto sets over catalogues: against closed forms, and against each combination as a spec of its own."""

from __future__ import annotations

import numpy as np
import pytest
import yaml
from scipy.optimize import brentq

from orthospec.optimise import branch, ends, hired, remembering, solve
from orthospec.optimise.hunt import hunt
from orthospec.optimise.pareto import find_front
from orthospec.optimise.space import DesignSpace
from orthospec.optimise.workers import Here
from orthospec.result import compose
from orthospec.result.model import Result
from orthospec.show import show
from orthospec.spec.writing import dump

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
SIZES = (1.0, 2.0, 4.0)
REAL = """\
orthospec: 1
variables:
  base: {min: 1.0, max: 3.0}
  third: {choices: [1.2, 1.6, 2.4]}
manipulator: {use: orthoglide, leg_lengths: [base, base, third]}
workspace: {size: [1, 1, 0.8], divisions: 4}
measures: {transmission: {use: velocity_transmission, at_least: 0.5, at_most: 2}}
goals: {base_legs: {minimise: base, goal: 1.3}, third_leg: {minimise: third, goal: 1.3}}
optimise: {starts: 1}
pareto: {points: 3}
"""


@pytest.fixture(scope="module")
def plane(spec_of):
    def load(variables, goals, points):
        text = PLANE.replace("VARIABLES", variables).replace("GOALS", goals)
        return spec_of(text.replace("POINTS", str(points)))

    return load


@pytest.fixture(scope="module")
def front_of(plane):
    return lambda *asked: find_front(plane(*asked), Here())


def values(front, *goals):
    return np.array([point.met.gaps for point in front.points]) + goals


def chosen(front, name):
    return [point.space.spec.variables[name].start for point in front.points]


def lower_edge(curves, low, high, points):
    """What the best of several falling curves y(x), x in an interval, meet from a line between two points.

    λ of one curve is where the normal from P crosses it, or at the end of its interval on that side.
    """
    low, high = np.array(low), np.array(high)
    ranges = np.array([high[0] - low[0], low[1] - high[1]])
    met = []
    for share in np.linspace(0, 1, points):
        place = (1 - share) * low + share * high

        def tilt(x, curve, place=place):
            return (x - place[0]) / ranges[0] - (curve(x) - place[1]) / ranges[1]

        found = []
        for curve, start, stop in curves:
            x = start if tilt(start, curve) >= 0 else stop
            if tilt(start, curve) < 0 < tilt(stop, curve):
                x = brentq(tilt, start, stop, args=(curve,), xtol=1e-14)
            found.append((max((np.array([x, curve(x)]) - place) / ranges), x, curve(x)))
        met.append(min(found)[1:])
    met = np.unique(np.round(met, 9), axis=0)
    return np.array([one for one in met if not ((met <= one).all(axis=1) & (met < one).any(axis=1)).any()])


@pytest.mark.parametrize("power", [1, 2])
def test_the_set_is_the_lower_edge_of_all_branches_with_its_gaps(front_of, power):
    """Lines, or curves that bulge the wrong way, one a size: f = c + x, g = 8/c − 2x^p, x in [0, 1]."""
    goals = f"{{f: {{minimise: c + x, goal: 1}}, g: {{minimise: 8 / c - 2 * x**{power}, goal: 3}}}}"
    front = front_of("{c: {choices: [4, 1, 2]}, x: {min: 0, max: 1}}", goals, 9)
    curves = [(lambda f, c=c: 8 / c - 2 * (f - c) ** power, c, c + 1) for c in SIZES]
    wanted = lower_edge(curves, (1, 8), (5, 0), 9)
    found = values(front, 1, 3)
    assert found.shape == wanted.shape
    np.testing.assert_allclose(found, wanted, atol=1e-6)
    assert set(chosen(front, "c")) == set(SIZES)
    assert front.search.branches == 3
    assert front.search.met + front.search.left_out == 27
    assert front.search.left_out > 0


def test_a_goal_on_choices_alone_leaves_no_other_goal_where_it_was(front_of):
    """The set is one point a size; within a size f does not move, and would let x be anything."""
    goals = '{f: {minimise: c, goal: 2}, g: {minimise: "(x - 0.3 * c)**2 + 1 / (1 + c)", goal: 3}}'
    front = front_of("{c: {choices: [0, 1, 3]}, x: {min: 0, max: 3}}", goals, 7)
    np.testing.assert_allclose(values(front, 2, 3), [[0, 1], [1, 0.5], [3, 0.25]], atol=1e-9)
    assert [point.is_knee for point in front.points] == [False, True, False]


def test_of_sizes_equally_good_in_one_goal_the_end_is_the_best_in_the_other(front_of):
    goals = "{f: {minimise: x, goal: 2}, g: {minimise: 2 - x + 0.1 * c, goal: 3}}"
    front = front_of("{c: {choices: [3, 1, 2]}, x: {min: 0, max: 1}}", goals, 5)
    x = np.linspace(0, 1, 5)
    np.testing.assert_allclose(values(front, 2, 3), np.stack([x, 2.1 - x], axis=1), atol=1e-8)
    assert chosen(front, "c") == [1.0] * 5


def test_a_catalogue_alone_has_the_set_of_its_entries(front_of):
    goals = "{f: {minimise: c, goal: 2}, g: {maximise: 2 - (c - 3)**2, goal: 3}}"
    front = front_of("{c: {choices: [1, 2, 3, 4]}}", goals, 9)
    assert chosen(front, "c") == [1.0, 2.0, 3.0]


def test_a_size_with_which_nothing_holds_has_no_part_in_the_set(front_of):
    goals = (
        "{f: {minimise: c + x, goal: 1}, g: {maximise: 2 * x - 8 / c, goal: 3},"
        " most: {minimise: c, goal: 3, weight: 0}}"
    )
    front = front_of("{c: {choices: [1, 2, 4]}, x: {min: 0, max: 1}}", goals, 3)
    assert front.search.branches == 3
    np.testing.assert_allclose(values(front, 1, -3)[[0, -1]], [[1, 8], [3, 2]], atol=1e-8)
    assert set(chosen(front, "c")) == {1.0, 2.0}


def test_three_goals_with_a_catalogue_lie_on_the_best_branch(front_of):
    """f = c; the other two trade one for one in x, and y off 0.2 helps nothing: g + h = 1 + 2/c."""
    goals = (
        "{f: {minimise: c, goal: 2}, g: {minimise: x + 1 / c, goal: 3},"
        ' h: {minimise: "1 - x + (y - 0.2)**2 + 1 / c", goal: 3}}'
    )
    front = front_of("{c: {choices: [1, 2]}, x: {min: 0, max: 1}, y: {min: 0, max: 1}}", goals, 3)
    f, g, h = values(front, 2, 3, 3).T
    np.testing.assert_allclose(g + h, 1 + 2 / f, atol=1e-8)
    assert set(f) == {1.0, 2.0}


@pytest.fixture(scope="module")
def real(spec_of):
    spec = spec_of(REAL)
    return spec, solve(spec).finding


@pytest.fixture(scope="module")
def shortest_base(spec_of):
    """Of a spec of its own, the third leg a number."""

    def find(third, most=2):
        text = REAL.replace("  third: {choices: [1.2, 1.6, 2.4]}\n", "").replace("third]", f"{third}]")
        text = text.replace(", third_leg: {minimise: third, goal: 1.3}", "")
        text = text.replace("pareto: {points: 3}\n", "").replace("at_most: 2", f"at_most: {most}")
        space = DesignSpace(spec_of(text))
        return space.values(hunt(space, Here()).best.end.design)["base"]

    return find


def test_on_a_machine_each_entry_of_the_catalogue_has_its_shortest_base(real, shortest_base):
    found = {one.design.values["third"]: one.design.values["base"] for one in real[1].pareto}
    assert found.keys() == {1.2, 1.6, 2.4}
    for third, base in found.items():
        assert base == pytest.approx(shortest_base(third), abs=1e-8)
    assert all(one.evaluation.holds for one in real[1].pareto)


def test_each_point_is_priced_in_its_own_branch(real, shortest_base):
    """1 % of `at_most` is worth that much of the shortest base, in parts of the base's range over the set."""
    front = real[1].pareto
    bases = [one.design.values["base"] for one in front]
    for k, third in enumerate([2.4, 1.6, 1.2]):
        (limit,) = [one for one in front[k].limits if one.side == "at_most"]
        won = (bases[k] - shortest_base(third, 2.02)) / (bases[2] - bases[0])
        assert front[k].design.values["third"] == third
        assert limit.gain == pytest.approx(won, rel=1e-5)


def test_a_result_tells_what_was_searched_and_is_shown_with_the_choices(real):
    spec, finding = real
    content = yaml.safe_load(dump(compose(spec, finding)))
    read = Result.model_validate(content)
    assert read.search.pareto.branches == 3
    assert read.search.pareto.met + read.search.pareto.left_out == 9
    text = " ".join(show(content, width=100, colour=False, spec=spec).split())
    assert "Pareto set: 3 designs The best of 3 combinations, which met" in text
    assert "more cannot be better than another combination's." in text


LINES = (
    "{c: {choices: [1, 2, 4]}, x: {min: 0, max: 1}}",
    "{f: {minimise: c + x, goal: 1}, g: {minimise: 8 / c - 2 * x, goal: 3}}",
    5,
)


def test_two_processes_and_kept_results_give_the_same_to_the_last_bit(plane, tmp_path):
    spec = plane(*LINES)
    alone = met(find_front(spec, Here()))
    with hired(jobs=2) as two, remembering(two, tmp_path) as workers:
        assert met(find_front(spec, workers)) == alone
    with remembering(Here(), tmp_path) as workers:
        assert met(find_front(spec, workers)) == alone
        assert workers.known == workers.asked


def met(front):
    return [(point.met, point.is_knee) for point in front.points], front.search


def test_of_many_combinations_the_best_of_each_goal_in_turn_are_searched(plane, monkeypatch):
    monkeypatch.setattr(branch, "MOST", 2)
    front = find_front(plane(*LINES), Here())
    assert front.search.branches == 2
    assert set(chosen(front, "c")) == {1.0, 4.0}


def test_ctrl_c_while_an_end_is_searched_tells_no_set(plane, monkeypatch):
    def stopped(space, workers, progress=None):
        found = hunt(space, workers, progress)
        found.interrupted = True
        return found

    monkeypatch.setattr(ends, "hunt", stopped)
    outcome = solve(plane(*LINES))
    assert outcome.interrupted
    assert outcome.finding.status == "unfinished"
    assert outcome.finding.pareto == ()

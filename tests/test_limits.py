"""What holds a design back, and its price: against closed forms and against the moved problem solved anew."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import ClassVar

import numpy as np
import pytest

from orthospec import registry
from orthospec.measures import Measure
from orthospec.optimise import limits as limits_module
from orthospec.optimise import solve
from orthospec.optimise.hunt import hunt
from orthospec.optimise.space import DesignSpace
from orthospec.optimise.workers import Here
from orthospec.quantities import Length
from orthospec.spec import load_spec

SPECS = Path(__file__).parents[1] / "specs"


def best_factor(spec):
    """λ of a spec, without the evaluation and the prices."""
    best = hunt(DesignSpace(spec), Here()).best
    return best.factor * best.unit


def least_leg(least, most, side=0.2):
    """The shortest equal legs for a cube with transmission factors in [least, most].

    On the diagonal the factors are 1/|1 − 2u| and 1/|1 + u|; the lower corner has u = −v.
    """
    v = min((1 / least - 1) / 2, 1 - 1 / most)
    u = min((1 - 1 / most) / 2, 1 / least - 1)
    return side / (v / np.sqrt(1 + 2 * v * v) + u / np.sqrt(1 + 2 * u * u))


@pytest.fixture(scope="module")
def limits(outcome_of):
    found = outcome_of("orthoglide-200").finding.limits
    return {(limit.kind, limit.name, limit.side): limit for limit in found}


def test_all_that_binds_is_named_and_nothing_else(limits):
    assert set(limits) == {
        ("bound", "transmission", "at_least"),
        ("bound", "transmission", "at_most"),
        ("goal", "leg_length", None),
    }


def test_where_a_solve_ran_out_of_subproblems_what_binds_has_no_price(limits):
    space = DesignSpace(load_spec(SPECS / "orthoglide-200.yaml", ["optimise.starts=1"]))
    best = replace(hunt(space, Here()).best, exhausted=True)
    found = limits_module.find_limits(space, best, Here())
    assert {(limit.kind, limit.name, limit.side) for limit in found} == set(limits)
    assert {limit.gain for limit in found} == {limit.cost for limit in found} == {None}


def test_prices_are_the_closed_forms(limits):
    """1 % of at_most is worth 1.00 mm loosened and 2.37 mm tightened; of at_least 0 and 2.65 mm."""
    best = least_leg(0.5, 2.0)
    at_most, at_least = (limits["bound", "transmission", side] for side in ("at_most", "at_least"))
    assert at_most.gain == pytest.approx(best - least_leg(0.5, 2.02), abs=1e-8)
    assert at_most.cost == pytest.approx(least_leg(0.5, 1.98) - best, abs=1e-8)
    assert at_least.gain == pytest.approx(0.0, abs=1e-8)
    assert at_least.cost == pytest.approx(least_leg(0.505, 2.0) - best, abs=1e-8)
    np.testing.assert_allclose(
        [at_most.gain, at_most.cost, at_least.cost], [0.00100, 0.00237, 0.00265], atol=6e-6
    )


def test_price_of_a_goal_is_its_own_one_per_cent(limits):
    goal = limits["goal", "leg_length", None]
    assert goal.gain == pytest.approx(0.003, abs=1e-8)
    assert goal.cost == pytest.approx(0.003, abs=1e-8)


def test_poses_where_a_bound_binds_are_told(limits):
    low, high = -0.1267949192, 0.0732050808
    at_least = np.array(limits["bound", "transmission", "at_least"].at)
    np.testing.assert_allclose(at_least, [[low] * 3], atol=2e-8)
    at_most = np.array(sorted(limits["bound", "transmission", "at_most"].at))
    np.testing.assert_allclose(at_most, [[low] * 3, [high] * 3], atol=2e-8)


def test_the_largest_gain_comes_first(outcome_of):
    for name in ("orthoglide-200", "orthoglide-1x1x0.8-sum"):
        gains = [limit.gain or 0.0 for limit in outcome_of(name).finding.limits]
        assert gains == sorted(gains, reverse=True)


@pytest.mark.parametrize(
    ("setting", "limit", "side", "sign"),
    [
        ("measures.transmission.at_most=2.02", "transmission", "at_most", "gain"),
        ("measures.transmission.at_most=1.98", "transmission", "at_most", "cost"),
        ("measures.transmission.at_least=0.495", "transmission", "at_least", "gain"),
        ("measures.transmission.at_least=0.505", "transmission", "at_least", "cost"),
    ],
)
def test_price_is_the_difference_of_two_optima(outcome_of, setting, limit, side, sign):
    """On a smooth trade-off, where no price has a closed form."""
    name = "orthoglide-1x1x0.8-sum"
    base = outcome_of(name).finding
    (price,) = [one for one in base.limits if (one.name, one.side) == (limit, side)]
    moved = best_factor(load_spec(SPECS / f"{name}.yaml", (setting, "optimise.starts=1")))
    change = moved - base.attainment.factor
    assert getattr(price, sign) == pytest.approx(change if sign == "cost" else -change, abs=1e-8)


def test_price_of_an_end_of_a_variables_range(outcome_of):
    """One per cent of the range, 0.4623139 mm of leg: κ = 3 falls as (1 + u)/(1 − 2u) does."""
    finding = outcome_of("orthoglide-condition").finding
    (end,) = [limit for limit in finding.limits if limit.kind == "variable"]
    assert (end.name, end.side, end.at) == ("leg", "at_most", ())
    step = 0.01 * (0.32623139 - 0.280)
    assert end.gain == pytest.approx(
        finding.attainment.factor + 2 - worst_condition(0.32623139 + step), abs=1e-7
    )
    assert end.cost == pytest.approx(
        worst_condition(0.32623139 - step) - 2 - finding.attainment.factor, abs=1e-7
    )


def worst_condition(leg):
    """The best worst condition number of a 200 mm cube at this leg, by bisection of the closed form."""
    low, high = 1.0, 50.0
    for _ in range(200):
        k = (low + high) / 2
        v, u = (k - 1) / (k + 2), (k - 1) / (2 * k + 1)
        room = leg * (v / np.sqrt(1 + 2 * v * v) + u / np.sqrt(1 + 2 * u * u))
        low, high = (low, k) if room >= 0.2 else (k, high)
    return high


class Shortfall(Measure):
    """What the legs are longer than a length, with its sign turned: its bounds are below 0."""

    unit: ClassVar[str] = "m"
    sides: ClassVar[frozenset[str]] = frozenset({"at_most"})
    length: Length = 0.0

    def values(self, manipulator, poses):
        return self.length - manipulator.leg_lengths[0] + 0.0 * poses[:, 0]


SHORTFALL = """\
orthospec: 1
variables: {leg: {min: 320 mm, max: 500 mm, start: 400 mm}}
manipulator: {use: orthoglide, leg_lengths: [leg, leg, leg]}
workspace: {size: [200 mm, 200 mm, 200 mm], divisions: 10}
measures: {mine: {use: mine, length: %s mm, at_most: %s mm}}
goals: {legs: {minimise: leg, goal: 300 mm}}
optimise: {starts: 1}
"""


@pytest.mark.parametrize(
    ("length", "bound", "price"), [(0, -350, 0.0035), (200, -150, 0.0015), (350, 0, None)]
)
def test_one_per_cent_of_a_bound_is_that_of_its_magnitude_and_0_has_none(
    monkeypatch, spec_of, length, bound, price
):
    find = registry.find_measure
    monkeypatch.setattr(registry, "find_measure", lambda name: Shortfall if name == "mine" else find(name))
    finding = solve(spec_of(SHORTFALL % (length, bound))).finding
    assert finding.design.values["leg"] == pytest.approx(0.35, abs=1e-9)
    (mine,) = [limit for limit in finding.limits if limit.name == "mine"]
    expected = (None, None) if price is None else pytest.approx((price, price), abs=1e-8)
    assert (mine.gain, mine.cost) == expected


JOINTS = """\
orthospec: 1
variables: {leg: {min: 320 mm, max: 500 mm, start: 330 mm}}
manipulator: {use: orthoglide, leg_lengths: [leg, leg, leg], joint_limits: {max: 400 mm}}
workspace: {size: [200 mm, 200 mm, 200 mm], divisions: 10}
measures: {transmission: {use: velocity_transmission, at_least: 0.5, at_most: 2}}
goals: {legs: {maximise: leg, goal: 500 mm}}
optimise: {starts: 1}
"""


def test_joint_limits_that_bind_are_named_with_the_pose_inside_the_face(spec_of):
    """The longest legs whose sliders stay below 400 mm: q + L = 0.4 with q = 0.2 − L/√6."""
    leg = 0.2 / (1 - 1 / np.sqrt(6))
    finding = solve(spec_of(JOINTS)).finding
    assert finding.design.values["leg"] == pytest.approx(leg, rel=1e-8)
    joints = {limit.name: limit for limit in finding.limits if limit.kind == "joint"}
    assert set(joints) == {"joint_limits.0", "joint_limits.1", "joint_limits.2"}
    for i in range(3):
        limit = joints[f"joint_limits.{i}"]
        assert limit.side == "at_most"
        pose = np.zeros(3)
        pose[i] = 0.4 - leg
        np.testing.assert_allclose(limit.at[0], pose, atol=1e-4)
    for moved, sign in ((404, "gain"), (396, "cost")):
        setting = f"manipulator.joint_limits.max=[{moved} mm, 400 mm, 400 mm]"
        change = abs(best_factor(spec_of(JOINTS, setting)) - finding.attainment.factor)
        assert getattr(joints["joint_limits.0"], sign) == pytest.approx(change, abs=1e-8)


def test_bounds_that_do_not_bind_are_not_named(spec_of):
    text = JOINTS.replace("max: 400 mm}}", "max: 900 mm}}")
    finding = solve(spec_of(text)).finding
    assert finding.status == "attained"
    assert finding.design.values["leg"] == pytest.approx(0.5, rel=1e-12)
    assert {(limit.kind, limit.name) for limit in finding.limits} == {("variable", "leg"), ("goal", "legs")}


def test_prices_are_the_same_numbers_each_time(outcome_of):
    name = "orthoglide-condition"
    assert (
        solve(load_spec(SPECS / f"{name}.yaml", ["proof=false"])).finding.limits
        == outcome_of(name).finding.limits
    )


def test_no_price_is_told_where_a_solve_did_not_come_to_its_end(monkeypatch):
    """One subproblem is enough where the optimum stays in its place; elsewhere more is to be had."""
    monkeypatch.setattr(limits_module, "SUBPROBLEMS", 1)
    spec = load_spec(SPECS / "orthoglide-200.yaml", ["proof=false", "workspace.divisions=4"])
    found = {(one.name, one.side): (one.gain, one.cost) for one in solve(spec).finding.limits}
    assert found["transmission", "at_least"] == found["transmission", "at_most"] == (None, None)
    assert found["leg_length", None] == pytest.approx((0.003, 0.003), abs=1e-8)

"""The infeasibility card: against closed forms of the Orthoglide, and the loosened problem solved anew."""

from __future__ import annotations

import numpy as np
import pytest
import yaml
from scipy.optimize import brentq

from orthospec.optimise import hired, loosen, remembering, solve
from orthospec.optimise.hunt import hunt
from orthospec.optimise.space import DesignSpace
from orthospec.optimise.workers import Here
from orthospec.result import compose
from orthospec.show import show
from orthospec.spec.writing import dump

SHORT = """\
orthospec: 1
variables: {leg: {min: 100 mm, max: 300 mm, start: 280 mm}}
manipulator: {use: orthoglide, leg_lengths: [leg, leg, leg]}
workspace: {size: [200 mm, 200 mm, 200 mm], divisions: 10}
measures: {transmission: {use: velocity_transmission, at_least: 0.5, at_most: 2}}
optimise: {starts: 1}
"""
JOINTS = """\
orthospec: 1
variables: {leg: {min: 320 mm, max: 500 mm, start: 340 mm}}
manipulator: {use: orthoglide, leg_lengths: [leg, leg, leg], joint_limits: {max: 380 mm}}
workspace: {size: [200 mm, 200 mm, 200 mm], divisions: 10}
measures: {transmission: {use: velocity_transmission, at_least: 0.5, at_most: 2}}
goals: {long: {maximise: leg, goal: 340 mm, weight: 0}}
optimise: {starts: 1}
"""


def least_leg(most):
    """The shortest equal legs for a 200 mm cube with transmission factors in [0.5, most], most >= 2."""
    u, v = (1 - 1 / most) / 2, 0.5
    return 0.2 / (v / np.sqrt(1 + 2 * v * v) + u / np.sqrt(1 + 2 * u * u))


def culprits(finding):
    return {(one.kind, one.name, one.side): one for one in finding.search.card.culprits}


@pytest.fixture(scope="module")
def short(spec_of):
    spec = spec_of(SHORT)
    return spec, solve(spec).finding


def test_a_bound_that_varies_is_told_as_it_is_where_loosening_it_did(spec_of):
    """With legs as long as may be, and not with those that the search begins with."""
    varying = SHORT.replace("at_most: 2", "at_most: 1.7 + leg").replace("start: 280", "start: 150")
    card = solve(spec_of(varying)).finding.search.card
    bound = next(one for one in card.culprits if one.kind == "bound")
    assert bound.value == pytest.approx(2.0, rel=1e-8)
    assert bound.needed == pytest.approx(brentq(lambda most: least_leg(most) - 0.3, 2, 9), rel=1e-7)


def test_the_conflict_is_the_smallest_one_and_says_so(short):
    """The lower bound takes part in the least violation, but legs and upper bound conflict without it."""
    card = short[1].search.card
    assert set(culprits(short[1])) == {
        ("variable", "leg", "at_most"),
        ("bound", "transmission", "at_most"),
    }
    assert card.irreducible


def test_each_loosening_alone_is_the_closed_form(short):
    found = culprits(short[1])
    leg, bound = found["variable", "leg", "at_most"], found["bound", "transmission", "at_most"]
    assert leg.needed == pytest.approx(least_leg(2.0), rel=1e-7)
    assert leg.by == pytest.approx((least_leg(2.0) - 0.3) / 0.2, rel=1e-6)
    wanted = brentq(lambda most: least_leg(most) - 0.3, 2, 3, xtol=1e-14)
    assert bound.needed == pytest.approx(wanted, rel=1e-7)
    assert bound.by == pytest.approx(wanted / 2 - 1, rel=1e-6)


def test_all_loosened_by_one_part_is_less_than_each_alone(short):
    part = brentq(lambda part: least_leg(2 * (1 + part)) - 0.3 - 0.2 * part, 0, 0.1, xtol=1e-14)
    assert short[1].search.card.together == pytest.approx(part, rel=1e-6)


def test_the_cuboid_that_would_do_is_the_prescribed_one_to_scale(short):
    assert short[1].search.card.scale == pytest.approx(0.3 / least_leg(2.0), rel=1e-7)


def test_the_cheapest_comes_first_and_each_has_its_place(short):
    first, second = short[1].search.card.culprits
    assert first.by < second.by
    assert first.place.endswith("spec.yaml:2:32")
    assert second.place.endswith("spec.yaml:5:70")


@pytest.mark.parametrize(("part", "enough"), [(0.9999, False), (1.0001, True)])
def test_a_loosening_is_just_enough(short, spec_of, part, enough):
    for one in short[1].search.card.culprits:
        key = "variables.leg.max" if one.kind == "variable" else "measures.transmission.at_most"
        value = one.value + part * (one.needed - one.value)
        best = hunt(DesignSpace(spec_of(SHORT, f"{key}={value!r}")), Here()).best
        assert best.feasible is enough


def test_joint_limits_count_as_one_and_what_is_not_enough_alone_says_so(spec_of):
    """At 340 mm the slides go to 0.2 + L(1 - 1/√6); no upper bound on the factors makes them stop earlier."""
    found = culprits(solve(spec_of(JOINTS)).finding)
    limit = found["joint", "joint_limits", "at_most"]
    assert limit.by == pytest.approx((0.2 + 0.34 * (1 - 1 / np.sqrt(6))) / 0.38 - 1, rel=1e-6)
    assert limit.needed is None
    assert {one.by for key, one in found.items() if key[0] == "bound"} <= {None}


def test_a_hard_goal_that_asks_too_much_is_told_with_the_value_that_can_be_had(spec_of):
    text = SHORT.replace("max: 300 mm", "max: 400 mm")
    text += "goals: {legs: {minimise: leg, goal: 300 mm, weight: 0}}\n"
    goal = culprits(solve(spec_of(text)).finding)["goal", "legs", None]
    assert goal.needed == pytest.approx(least_leg(2.0), rel=1e-7)
    assert goal.place.endswith("spec.yaml:7:31")


def test_a_variable_that_must_go_far_beyond_its_range_is_told_how_far(spec_of):
    text = SHORT.replace("min: 100 mm, max: 300 mm, start: 280 mm", "min: 299.9 mm, max: 300 mm")
    leg = culprits(solve(spec_of(text)).finding)["variable", "leg", "at_most"]
    assert leg.needed == pytest.approx(least_leg(2.0), rel=1e-7)
    assert leg.by == pytest.approx((least_leg(2.0) - 0.3) / 1e-4, rel=1e-5)


def test_of_two_conflicts_through_one_variable_it_alone_is_the_way_out(spec_of):
    """Longer legs bring both factors near 1; without the upper bound the lower one still conflicts."""
    spec = spec_of(SHORT, "measures.transmission.at_least=0.97", "measures.transmission.at_most=1.03")
    finding = solve(spec).finding
    found = culprits(finding)
    assert found["variable", "leg", "at_most"].needed > 1.0
    assert {one.by for one in found.values() if one.kind == "bound"} == {None}
    text = " ".join(show(compose(spec, finding), width=100, colour=False, spec=spec).split())
    assert "These cannot all hold. variable leg: at most 300 mm" in text


def test_what_is_not_enough_says_how_far_was_tried(short):
    spec, finding = short
    content = compose(spec, finding)
    content["search"]["card"]["conflict"][0] |= {"by": None, "needed": None}
    text = " ".join(show(content, width=100, colour=False, spec=spec).split())
    assert "no design was found by loosening it alone, by up to 10000 times its range" in text


def test_where_a_design_is_found_there_is_no_card(spec_of):
    assert solve(spec_of(SHORT, "variables.leg.max=400 mm")).finding.search.card is None


def test_the_card_is_shown_with_places_values_and_ways_out(short):
    spec, finding = short
    text = " ".join(show(compose(spec, finding), width=100, colour=False, spec=spec).split())
    assert "These cannot all hold; without any one of them a design was found." in text
    assert "variable leg: at most 300 mm (spec.yaml:2:32) alone: to 310.583 mm, by 5.3 % of its range" in text
    assert "measure transmission: at most 2 (spec.yaml:5:70) alone: to 2.24843, by 12 %" in text
    assert "Or: all of these by 3.6 %, or a cuboid of 96.59 % of the size." in text


def bytes_of(spec, **options):
    return dump(compose(spec, solve(spec, **options).finding))


def test_two_processes_give_the_same_bytes(short):
    with hired(jobs=2) as two:
        assert bytes_of(short[0], workers=two) == dump(compose(*short))


def test_a_card_that_is_kept_is_not_solved_again(short, tmp_path, monkeypatch):
    with remembering(Here(), tmp_path) as workers:
        first = bytes_of(short[0], workers=workers)

    def not_again(*_, **__):
        raise AssertionError

    monkeypatch.setattr(loosen, "minimise", not_again)
    with remembering(Here(), tmp_path) as workers:
        assert bytes_of(short[0], workers=workers) == first
        assert workers.known == workers.asked


def stopped_at(stage, done, spec):
    """The outcome of a solve that Ctrl-C ends once so much of a stage is done."""

    def stop(name, now, _):
        if (name, now) == (stage, done):
            raise KeyboardInterrupt

    return solve(spec, progress=stop)


def test_ctrl_c_keeps_the_loosenings_that_are_known(short):
    spec, whole = short
    outcome = stopped_at("what would have to give way", 1, spec)
    finding = outcome.finding
    assert outcome.interrupted
    assert finding.status == "unfinished"
    known, cut_off = finding.search.card.culprits
    assert known in whole.search.card.culprits
    assert not cut_off.sought
    assert finding.search.card.together is None
    assert finding.search.conflicts == whole.search.conflicts
    content = yaml.safe_load(dump(compose(spec, finding)))
    assert ["by" in one for one in content["search"]["card"]["conflict"]] == [True, False]
    text = " ".join(show(content, width=100, colour=False, spec=spec).split())
    assert text.count("stopped before it was known how far it alone") == 1
    assert "What conflicts" in text


def test_ctrl_c_before_the_conflict_is_known_keeps_what_shares_the_violation(short):
    spec, whole = short
    outcome = stopped_at("what conflicts", 1, spec)
    assert outcome.interrupted
    assert outcome.finding.search.card is None
    assert outcome.finding.limits == whole.limits

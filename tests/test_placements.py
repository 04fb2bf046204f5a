"""No larger cuboid fits: against closed forms, and never proved where one does fit."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from orthospec.intervals import Boxes, Interval
from orthospec.manipulators.linear_delta import LinearDelta
from orthospec.manipulators.orthoglide import Orthoglide
from orthospec.measures import Demand
from orthospec.measures.dynamic import JointSpeed
from orthospec.measures.kinematic import ConditionNumber, VelocityTransmission
from orthospec.workspace import guarantee, placements
from orthospec.workspace.cuboid import Cuboid
from orthospec.workspace.evaluate import Setting, evaluate
from orthospec.workspace.guarantee import bracket, proof_over
from orthospec.workspace.machine import Machine
from orthospec.workspace.placements import Placing, none_fits

LEG = 0.2 / (1 / np.sqrt(6) + 1 / np.sqrt(18))
LOW, HIGH = -LEG / np.sqrt(6), LEG / np.sqrt(18)
CUBE = Cuboid((LOW,) * 3, (HIGH,) * 3)
SIZE = np.full(3, 0.2)
FACTORS = VelocityTransmission(), {"at_least": 0.5, "at_most": 2.0}
HIGH_UP = {"leg_lengths": (0.5,) * 3, "base_radius": 0.3, "platform_radius": 0.05}


def machine(measure=None, bounds=None, **keys):
    demands = {"it": Demand("it", measure, bounds)} if measure else {}
    return Machine(Orthoglide(leg_lengths=(LEG,) * 3, **keys), demands)


def test_no_cube_larger_by_a_millionth_fits_anywhere():
    proved, boxes, _ = none_fits(machine(*FACTORS), SIZE * (1 + 1e-6), None, 50_000)
    assert proved
    assert boxes < 8_000


def balanced(at_most):
    """Bounds, and the cube that is largest with them: its low corner too slow, its high one too fast.

    On the diagonal J⁻¹ has the eigenvalues 1 + 2t and twice 1 − t, where t = −x / sqrt(L² − 2x²).
    """
    slack = (1 - 1 / at_most) / 2
    return {"at_least": 0.5, "at_most": at_most}, Cuboid(
        (LOW,) * 3, (LEG * slack / np.sqrt(1 + 2 * slack**2),) * 3
    )


@pytest.mark.parametrize("at_most", [2.01, 2.2])
def test_corners_that_hold_each_other_in_balance_are_weighed(at_most):
    """Either corner alone leaves a thin disc of centres, of which boxes would be as many as 1 / part."""
    bounds, cube = balanced(at_most)
    for part in (1e-3, 1e-6):
        proved, boxes, _ = none_fits(machine(FACTORS[0], bounds), cube.size * (1 + part), None, 20_000, cube)
        assert proved
        assert boxes < 8_000


def test_of_flat_cuboids_too_none_larger_by_a_millionth_fits():
    size = np.array([0.2, 0.2, 0.01])
    found = evaluate(machine(*FACTORS), Setting(size, divisions=10)).joint
    ends = bracket(machine(*FACTORS), size, found.cuboid, found.scale, None, 50_000)
    assert found.scale * (1 - 2e-6) < ends.least <= found.scale <= ends.most < found.scale * (1 + 2e-6)


@pytest.mark.parametrize("at_most", [2.0, 2.04])
def test_no_centre_is_excluded_at_which_the_cube_fits(at_most):
    bounds, cube = balanced(at_most)
    random = np.random.default_rng(0)
    for part in (1e-6, 1e-3, 0.1):
        search = placements._Search(machine(FACTORS[0], bounds), cube.size * (1 - part), cube)
        half = 0.1 * 10 ** random.uniform(-7, 0, (200, 1))
        low = cube.centre - half * random.uniform(0, 2, (200, 3))
        assert search.not_excluded(Boxes(low, low + 2 * half)).all()


def test_where_a_cube_fits_nothing_is_proved():
    for part in (1e-6, 0.5):
        assert not none_fits(machine(*FACTORS), SIZE * (1 - part), None, 5_000).excluded


def test_a_flat_cuboid_that_fits_far_from_the_origin_is_not_excluded():
    """More than ten thousand of its heights away."""
    delta = Machine(LinearDelta(**HIGH_UP, joint_limits={"min": 1.5, "max": 2.0}), {})
    size = np.array([0.05, 0.05, 1e-4])
    place = Cuboid.around(np.array([0.0, 0.0, 1.25]), size)
    assert proof_over(delta, place, 0.0, 1_000).verdict == "proved"
    assert not none_fits(delta, size, None, 20_000).excluded
    assert bracket(delta, size, Cuboid.around(place.centre, size / 10), 0.1, None, 20_000).most is None


def test_where_the_reach_ends_far_out_is_seen_for_flat_cuboids_too():
    """Seen from above the reach is the same at every height; no square of 415 mm has room in it."""
    delta = Machine(LinearDelta(**HIGH_UP, joint_limits={"min": 1.5, "max": 2.0}), {})
    assert none_fits(delta, np.array([0.415, 0.415, 1e-4]), None, 2_000).excluded
    legs_alone = Machine(LinearDelta(**HIGH_UP), {})
    assert none_fits(legs_alone, np.array([0.415, 0.415, 1e-4]), None, 2_000).excluded


@settings(deadline=None, max_examples=10)
@given(
    st.sampled_from(["orthoglide", "linear_delta"]),
    st.integers(-6, 6).map(lambda half: half / 2),
    st.tuples(*[st.floats(-4.0, -1.0)] * 3),
    st.tuples(*[st.floats(0.0, 1.0)] * 3),
    st.booleans(),
)
def test_a_cuboid_that_is_proved_to_fit_somewhere_is_not_said_to_fit_nowhere(name, at, edges, place, known):
    """Of any proportions, with joint limits anywhere."""
    if name == "orthoglide":
        one = Orthoglide(leg_lengths=(0.5,) * 3, joint_limits={"min": 0.4, "max": 0.6})
        low = np.full(3, -0.1)
    else:
        one = LinearDelta(**HIGH_UP, joint_limits={"min": at, "max": at + 0.2})
        low = np.array([-0.1, -0.1, at - 0.4])
    size = 10.0 ** np.array(edges)
    cuboid = Cuboid.around(low + 0.2 * np.array(place), size)
    assume(proof_over(Machine(one, {}), cuboid, 0.0, 200).verdict == "proved")
    largest = Cuboid.around(cuboid.centre, 0.9 * size) if known else None
    assert not none_fits(Machine(one, {}), size, None, 2_000, largest).excluded


def test_a_box_that_one_condition_alone_excludes_needs_no_measure():
    """The joint limit leaves 100 mm of slide: less than any cube of 101 mm takes."""
    short = machine(joint_limits={"min": 0.26, "max": 0.36})
    assert none_fits(short, np.full(3, 0.101), None, 20_000).excluded
    assert not none_fits(short, np.full(3, 0.05), None, 2_000).excluded


def test_a_region_smaller_than_the_cuboid_leaves_it_no_place():
    region = Cuboid((-0.1,) * 3, (0.1, 0.1, 0.099))
    assert none_fits(machine(*FACTORS), SIZE, region, 10) == Placing(True, 0)


def test_a_measure_that_tells_nothing_of_boxes_excludes_nothing(monkeypatch):
    def broken(*_):
        raise ValueError("not of boxes")

    monkeypatch.setattr(VelocityTransmission, "enclosure", broken)
    assert not none_fits(machine(*FACTORS), SIZE * 1.2, None, 2_000).excluded
    assert none_fits(machine(*FACTORS), SIZE * 1.2, None, 2_000, CUBE) == Placing(False, 1)


@pytest.mark.parametrize(
    "enclosure",
    [
        lambda _, boxes: Interval(np.full(len(boxes) + 1, 9.0), np.full(len(boxes) + 1, 9.0)),
        lambda _, boxes: np.full(len(boxes), 9.0),
        lambda *_: None,
    ],
)
def test_an_enclosure_that_is_none_excludes_nothing(monkeypatch, enclosure):
    monkeypatch.setattr(ConditionNumber, "enclosure", lambda *given: enclosure(*given[1:]))
    one = machine(ConditionNumber(), {"at_most": 3.0})
    assert none_fits(one, SIZE, None, 2_000, CUBE) == Placing(False, 1)


def test_a_form_over_other_coordinates_is_left_aside(monkeypatch):
    """Its ends exclude as ever."""

    def enclosure(*given):
        boxes = given[-1]
        flat = Interval(np.full(len(boxes), 9.0), np.full(len(boxes), 9.5))
        return flat + 0 * Boxes(np.zeros((len(boxes), 5)), np.ones((len(boxes), 5))).poses[:, 4]

    monkeypatch.setattr(ConditionNumber, "enclosure", enclosure)
    assert not none_fits(machine(ConditionNumber(), {"at_most": 3.0}), SIZE, None, 2_000, CUBE).excluded


def test_what_is_not_proved_costs_two_budgets_at_most(monkeypatch):
    """From the finest part to the coarsest, and then finer while there is a proof."""
    asked = []

    def fits_nowhere(_, size, *__):
        part = float(f"{size[0] / SIZE[0] - 1:.3g}")
        asked.append(part)
        return Placing(part >= least, 0)

    monkeypatch.setattr(guarantee, "none_fits", fits_nowhere)
    for least, tried in ((0, [1e-6]), (1e-2, [1e-6, 1e-1, 1e-2, 1e-4]), (1, [1e-6, 1e-1])):
        asked.clear()
        most = bracket(machine(*FACTORS), SIZE, CUBE, 1.0, None, 1_000).most
        assert asked == tried
        if least == 1:
            assert most is None
        else:
            assert most == pytest.approx(1 + tried[-2 if least else -1], rel=1e-11)


def test_the_scale_is_enclosed_within_a_millionth():
    ends = bracket(machine(*FACTORS), SIZE, CUBE, 1.0, None, 50_000)
    assert ends.least == pytest.approx(1.0, abs=1.1e-6)
    assert ends.most == pytest.approx(1.0, abs=1.1e-6)
    assert ends.least < 1 < ends.most


def test_a_region_bounds_the_scale_too():
    region = Cuboid((-0.1,) * 3, (0.1, 0.1, 0.05))
    size = np.array([0.1, 0.1, 0.1])
    cuboid = Cuboid((-0.075,) * 3, (0.075, 0.075, 0.075))
    ends = bracket(machine(), size, Cuboid(cuboid.low, (0.075, 0.075, 0.05)), 1.0, region, 2_000)
    assert ends.most == pytest.approx(1.5, rel=1e-11)
    assert ends.most >= 1.5


def test_the_box_of_a_smaller_scale_is_proved_only_where_it_holds():
    """The cuboid is too large by a tenth: less than that much less of it is not proved."""
    wide = Cuboid(tuple(1.05 * x for x in CUBE.low), tuple(1.05 * x for x in CUBE.high))
    ends = bracket(machine(*FACTORS), SIZE, wide, 1.05, None, 3_000)
    assert ends.least is not None
    assert ends.least < 1


def test_the_verdict_tells_what_decides_it():
    loose = proof_over(machine(*FACTORS), CUBE, 1e-3, 10_000)
    assert (loose.verdict, loose.condition, loose.at) == ("proved", None, None)
    assert 0 < loose.excess <= 1e-3
    moved = Cuboid(tuple(x + 1e-3 for x in CUBE.low), tuple(x + 1e-3 for x in CUBE.high))
    refuted = proof_over(machine(*FACTORS), moved, 1e-3, 10_000)
    assert (refuted.verdict, refuted.condition) == ("refuted", "it: at_most")
    assert refuted.at == pytest.approx(moved.high)
    spent = proof_over(machine(*FACTORS), CUBE, 1e-9, 100)
    assert spent.verdict == "undecided"
    assert spent.excess > 1e-9


def test_conditions_on_one_measure_count_their_boxes_once():
    both = proof_over(machine(*FACTORS), CUBE, 1e-3, 10_000)
    one = proof_over(machine(VelocityTransmission(), {"at_most": 2.0}), CUBE, 1e-3, 10_000)
    assert both.boxes < 1.5 * one.boxes


def test_the_condition_number_is_known_up_to_singularities():
    """Twice the same eigenvalue in the worst corners: κ = (1 − t) / (1 + 2t) and (1 + 2t) / (1 − t)."""
    low, high = (LEG * t / np.sqrt(1 + 2 * t * t) for t in (-4 / 7, 4 / 11))
    cube = Cuboid((low,) * 3, (high,) * 3)
    ends = bracket(machine(ConditionNumber(), {"at_most": 5.0}), cube.size, cube, 1.0, None, 30_000)
    assert 1 - 1.1e-6 < ends.least < 1 < ends.most < 1 + 1.1e-6


@pytest.mark.parametrize("measure", [ConditionNumber(), JointSpeed(speed=1.0)])
def test_other_measures_have_proved_ends(measure):
    bound = 4.0 if isinstance(measure, ConditionNumber) else 1.3
    one = machine(measure, {"at_most": bound})
    edge = next(e for e in np.linspace(0.4, 0.02, 39) if _holds(one, np.full(3, e)))
    assert none_fits(one, np.full(3, 3 * edge), None, 20_000).excluded


def _holds(one, size):
    return proof_over(one, Cuboid.around(np.array(CUBE.centre), size), 0.0, 3_000).verdict == "proved"

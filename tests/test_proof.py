"""Proof over cuboids: against closed forms for what holds, and against poses for what does not."""

from __future__ import annotations

import itertools
from pathlib import Path
from typing import ClassVar

import numpy as np
import pytest

from orthospec import registry
from orthospec.intervals import Interval
from orthospec.manipulators.linear_delta import LinearDelta
from orthospec.manipulators.orthoglide import Orthoglide
from orthospec.measures import Demand, Measure
from orthospec.measures.dynamic import Acceleration, GieNorm
from orthospec.measures.elastic import Deflection
from orthospec.measures.kinematic import ConditionNumber, VelocityTransmission
from orthospec.workspace.cuboid import Cuboid
from orthospec.workspace.machine import Machine
from orthospec.workspace.proof import Budget, prove

# With factors in [1/2, 2] the largest cube has its corners on the diagonal, at −L/√6 and L/√18.
LEG = 0.2 / (1 / np.sqrt(6) + 1 / np.sqrt(18))
LOW, HIGH = -LEG / np.sqrt(6), LEG / np.sqrt(18)
CUBE = Cuboid((LOW,) * 3, (HIGH,) * 3)
FACTORS = {"at_least": 0.5, "at_most": 2.0}
LEGS = {"kind": "PUU", "material": "aluminium", "section": {"round": {"diameter": 0.02, "wall": 0.002}}}


def orthoglide(**keys):
    return Orthoglide(leg_lengths=(LEG,) * 3, **keys)


def claims_of(manipulator, measure, bounds, cuboid=CUBE, slack=1e-3, **budget):
    machine = Machine(manipulator, {"it": Demand("it", measure, bounds)})
    found = prove(machine, cuboid, slack=slack, budget=Budget(**budget) if budget else None)
    return {(c.condition.name, c.condition.side): c for c in found}


def scaled(factor):
    return Cuboid(*(tuple(factor * x for x in end) for end in (CUBE.low, CUBE.high)))


@pytest.mark.parametrize("slack", [1e-3, 1e-6, 1e-9])
def test_the_exact_cube_is_proved_within_any_slack(slack):
    claims = claims_of(orthoglide(), VelocityTransmission(), FACTORS, slack=slack)
    assert {claim.verdict for claim in claims.values()} == {"proved"}
    both = [claims["it", side] for side in FACTORS]
    assert both[0].boxes <= 1200  # With Weyl's inequality alone.
    assert all(0 <= claim.excess <= slack for claim in both)  # The bounds hold with equality in two corners.


def test_without_slack_what_holds_with_equality_stays_undecided():
    claims = claims_of(orthoglide(), VelocityTransmission(), FACTORS, slack=0.0, boxes=2000)
    assert claims["it", "at_most"].verdict == "undecided"
    assert 0 < claims["it", "at_most"].excess < 1e-3
    assert claims["it", "at_most"].at is None


def test_a_cube_that_is_a_little_too_large_is_refuted_with_a_pose():
    manipulator, cuboid = orthoglide(), scaled(1.002)
    claims = claims_of(manipulator, VelocityTransmission(), FACTORS, cuboid)
    refuted = claims["it", "at_most"]
    assert refuted.verdict == "refuted"
    pose = np.array([refuted.at])
    assert (np.array(cuboid.low) <= pose).all()
    assert (pose <= np.array(cuboid.high)).all()
    factor = 1 / np.linalg.svd(manipulator.inverse_jacobian(pose), compute_uv=False)[0, -1]
    assert factor > 2 * 1.001
    assert refuted.excess == pytest.approx(factor / 2 - 1, rel=1e-9)


def test_slack_is_relative_to_the_bound():
    for bound, verdict in ((4.0, "proved"), (3.99, "proved"), (3.9, "refuted")):
        claims = claims_of(orthoglide(), ConditionNumber(), {"at_most": bound}, slack=5e-3)
        assert claims["it", "at_most"].verdict == verdict  # κ = 4 in the worst corner.


def test_joint_limits_have_slack_and_singularities_none():
    # Sliders of the exact cube: LOW + sqrt(L² − 2 LOW²) ... HIGH + sqrt(L² − 2 HIGH²) at its corners.
    least = LOW + np.sqrt(LEG**2 - 2 * LOW**2)
    for factor, verdict in ((1.0, "proved"), (1.0005, "proved"), (1.002, "refuted")):
        limits = {"min": factor * least}
        claims = claims_of(orthoglide(joint_limits=limits), ConditionNumber(), {"at_most": 5})
        assert claims["joint_limits.0", "at_least"].verdict == verdict
    beyond = Cuboid((-0.05,) * 3, (1.0001 * LEG / np.sqrt(6),) * 3)
    claims = claims_of(orthoglide(), ConditionNumber(), {"at_most": 1e9}, beyond, boxes=20_000)
    assert claims["singularity", None].verdict == "refuted"
    assert claims["it", "at_most"].verdict == "undecided"
    assert claims["it", "at_most"].boxes == 0


def test_deflection_and_dynamics_over_the_cube():
    """Bounds that hold with equality at the worst of a fine lattice, where these measures are greatest."""
    parts = {"force": 100, "stiffness": 2e7, "mass": 2.0}
    manipulator = orthoglide(legs=LEGS, actuators=parts, platform={"mass": 1.0})
    lattice = np.array(list(itertools.product(np.linspace(LOW, HIGH, 9), repeat=3)))
    for measure, side in (
        (Deflection(force=50), "at_most"),
        (GieNorm(), "at_most"),
        (Acceleration(), "at_least"),
    ):
        values = measure.values(manipulator, lattice)
        bound = values.max() if side == "at_most" else values.min()
        claim = claims_of(manipulator, measure, {side: bound}, slack=1e-2)["it", side]
        assert claim.verdict == "proved"
        assert claim.boxes < 1000
        worse = bound * (0.97 if side == "at_most" else 1.03)
        claim = claims_of(manipulator, measure, {side: worse}, slack=1e-2)["it", side]
        assert claim.verdict == "refuted"


class Spike(Measure):
    """A narrow peak: on the lattice of the search it is not to be seen."""

    unit: ClassVar[str] = "1"
    sides: ClassVar[frozenset[str]] = frozenset({"at_most"})

    def values(self, manipulator, poses):  # noqa: ARG002
        distance = np.sum((poses - np.array([0.0123, -0.0456, 0.0321])) ** 2, axis=1)
        return 1.0 + 1e-7 / (1e-7 + distance)


def test_a_peak_between_the_nodes_of_any_lattice_is_found():
    refuted = claims_of(orthoglide(), Spike(), {"at_most": 1.5})["it", "at_most"]
    assert refuted.verdict == "refuted"
    np.testing.assert_allclose(refuted.at, [0.0123, -0.0456, 0.0321], atol=1e-3)
    assert claims_of(orthoglide(), Spike(), {"at_most": 2.0})["it", "at_most"].verdict == "proved"


class Masked(Spike):
    """Code for numbers only."""

    def values(self, manipulator, poses):
        found = np.zeros(len(poses))
        found[:] = super().values(manipulator, poses)
        return found


class Faulty(Spike):
    """Raises on anything but plain arrays."""

    def values(self, manipulator, poses):
        if not isinstance(poses, np.ndarray):
            raise TypeError("an array was expected")
        return super().values(manipulator, poses)


class Swapped(Spike):
    """Gives its ends the wrong way round."""

    def enclosure(self, manipulator, boxes):
        found = super().enclosure(manipulator, boxes)
        return Interval(found.hi + 1.0, found.lo)


class Doubled(Spike):
    """Gives least and greatest, where its values are one."""

    def enclosure(self, manipulator, boxes):
        found = super().enclosure(manipulator, boxes)
        return Interval(*(np.stack([end, end], axis=1) for end in found.ends))


class Silent(Spike):
    """Has no enclosure to give."""

    def enclosure(self, manipulator, boxes):  # noqa: ARG002
        return None


@pytest.mark.parametrize(
    ("measure", "words"),
    [
        (Masked(), "np.stack"),
        (Faulty(), "an array was expected"),
        (Silent(), "Silent gives no enclosure"),
        (Doubled(), "Doubled gives an enclosure of shape (1, 2) for values of 1 axes"),
        (Swapped(), "Swapped gives an enclosure whose lower end lies above the upper one"),
    ],
)
def test_without_enclosure_nothing_is_claimed_and_the_reason_told(measure, words):
    claim = claims_of(orthoglide(), measure, {"at_most": 2.0})["it", "at_most"]
    assert claim.verdict == "undecided"
    assert words in claim.why
    # Results tell of it, and have no paths in them.
    assert str(Path(__file__).parent) not in claim.why
    if not isinstance(measure, Silent | Swapped | Doubled):
        assert claim.why.startswith(f"{__name__}, line ")


class Sure(Spike):
    """Claims that no value lies above 1.05, where the greatest one is 1.13."""

    def values(self, manipulator, poses):  # noqa: ARG002
        return 1.0 + np.abs(poses[:, 0])

    def enclosure(self, manipulator, boxes):  # noqa: ARG002
        return Interval(np.ones(len(boxes)), np.full(len(boxes), 1.05))


def test_an_enclosure_that_a_value_contradicts_proves_nothing():
    claim = claims_of(orthoglide(), Sure(), {"at_most": 1.05})["it", "at_most"]
    assert claim.verdict == "refuted"
    assert abs(claim.at[0]) == pytest.approx(0.1268, abs=1e-4)


def test_budgets_end_the_search():
    claims = claims_of(orthoglide(), VelocityTransmission(), FACTORS, boxes=50)
    assert claims["it", "at_most"].verdict == "undecided"
    assert claims["it", "at_most"].boxes <= 50
    assert claims["it", "at_most"].excess > 1e-3
    claims = claims_of(orthoglide(), VelocityTransmission(), FACTORS, seconds=0.0)
    assert {claim.verdict for claim in claims.values()} == {"undecided"}


def test_the_same_question_has_the_same_answer():
    def first():
        return claims_of(orthoglide(), VelocityTransmission(), FACTORS)

    assert first() == first()


GIVEN = {
    "joint_speed": {"speed": 1.0},
    "deflection": {"force": 100.0},
    "rotation": {"torque": 1.0},
    "actuator_force": {"acceleration": 1.0},
}
PARTS = {
    "legs": {
        "kind": "PRPaR",
        "section": {"round": {"diameter": 0.03, "wall": 0.002}},
        "material": "carbon",
        "spacing": 0.08,
    },
    "actuators": {"force": 400.0, "speed": 1.0, "stiffness": 2e7, "mass": 2.0, "friction": 15.0},
    "platform": {"mass": 2.0},
    "gravity": [0.0, 0.0, -9.81],
}
BUILT_IN = {
    name
    for name in registry.names(registry.MEASURES)
    if registry.distribution_of(registry.MEASURES, name).distribution == "orthospec"
}
MACHINES = {
    "orthoglide": Orthoglide(leg_lengths=(LEG, LEG, 1.02 * LEG), **PARTS),
    "linear_delta": LinearDelta(
        leg_lengths=(0.55, 0.56, 0.55), base_radius=0.3, platform_radius=0.05, **PARTS
    ),
}


@pytest.mark.parametrize("machine", MACHINES)
@pytest.mark.parametrize("name", sorted(BUILT_IN))
def test_each_measure_is_proved_next_to_its_extremes_and_refuted_beyond(name, machine):
    manipulator, measure = MACHINES[machine], registry.find_measure(name)(**GIVEN.get(name, {}))
    cuboid = Cuboid((-0.08,) * 3, (0.06,) * 3)
    u = np.random.default_rng(0).uniform(-0.5, 0.5, (4000, 3))
    u[:8] = list(itertools.product((-0.5, 0.5), repeat=3))
    values = measure.values(manipulator, cuboid.poses(u, 3)).reshape(len(u), -1)
    for side in measure.sides:
        extreme = values[:, 0].min() if side == "at_least" else values[:, -1].max()
        for part, verdict in ((0.05, "proved"), (-0.01, "refuted")):
            bound = extreme * (1 + part if side == "at_most" else 1 - part)
            claims = claims_of(manipulator, measure, {side: float(bound)}, cuboid, boxes=20_000)
            assert claims["it", side].verdict == verdict, claims["it", side].why


# Machines within tolerances.


def within(leg, tolerance, bounds=FACTORS, slack=1e-6, **keys):
    """The claims on the 200 mm cube for all Orthoglides whose legs are off by at most a tolerance [m]."""
    machine = Machine(
        Orthoglide(leg_lengths=(leg,) * 3, **keys), {"it": Demand("it", VelocityTransmission(), bounds)}
    )
    found = prove(machine, CUBE, slack=slack, tolerances={"leg_lengths": tolerance})
    return {(c.condition.name, c.condition.side): c for c in found}


def excess_in_worst_corner(leg):
    """Of at_most 2 with three legs of a length.

    At (q, q, q) J⁻¹ has the eigenvalues 1 − 2r and, twice, 1 + r, with r = q / sqrt(L² − 2q²).
    """
    r = np.array([LOW, HIGH]) / np.sqrt(leg**2 - 2 * np.array([LOW, HIGH]) ** 2)
    return max(1 / np.abs([1 - 2 * r, 1 + r]).min() / 2 - 1, 0.0)


@pytest.mark.parametrize("margin", [1e-4, 1e-3])
def test_room_in_the_legs_is_what_they_may_be_off_by(margin):
    """With legs longer than the shortest that do, by as much as the tolerance, all of them do."""
    for part, verdict in ((0.9, "proved"), (1.0, "proved"), (1.01, "refuted")):
        claims = within(LEG + margin, part * margin)
        assert {claims["it", side].verdict for side in FACTORS} == {verdict}
    refuted = claims["it", "at_most"]
    shortest = LEG - 0.01 * margin
    assert refuted.machine["leg_lengths"] == pytest.approx((shortest,) * 3, rel=1e-12)
    assert refuted.excess == pytest.approx(excess_in_worst_corner(shortest), rel=1e-6)
    own = Orthoglide(leg_lengths=refuted.machine["leg_lengths"])
    factors = VelocityTransmission().values(own, np.array([refuted.at]))
    assert factors[0, 1] == pytest.approx(2 * (1 + refuted.excess), rel=1e-12)


def test_unequal_legs_within_tolerances_stay_within_what_is_proved():
    claims, random = within(LEG + 2e-4, 2e-4), np.random.default_rng(2)
    machines = LEG + 2e-4 + 2e-4 * np.round(random.uniform(-1, 1, (200, 3)), 0)
    corners = np.array(list(itertools.product((LOW, HIGH), repeat=3)))
    for lengths in machines:
        factors = VelocityTransmission().values(Orthoglide(leg_lengths=tuple(lengths)), corners)
        assert factors[:, 1].max() / 2 - 1 <= claims["it", "at_most"].excess
        assert 1 - factors[:, 0].min() / 0.5 <= claims["it", "at_least"].excess


def test_joint_limits_are_met_by_sliders_of_all_machines():
    def least(leg):
        return LOW + np.sqrt(leg**2 - 2 * LOW**2)

    for tolerance in (1e-4, 1e-3):
        for limit, verdict in ((0.9999, "proved"), (1.0021, "refuted")):
            limits = {"min": limit * least(0.35 - tolerance)}
            claim = within(0.35, tolerance, slack=1e-3, joint_limits=limits)["joint_limits.0", "at_least"]
            assert claim.verdict == verdict
    assert claim.machine["leg_lengths"][0] == pytest.approx(0.349, rel=1e-12)
    assert claim.excess == pytest.approx(1 - 1 / limit, rel=1e-9)


def test_a_measure_that_knows_one_machine_only_is_undecided():
    class Single(Spike):
        """Asks for the length of a leg as a number."""

        def values(self, manipulator, poses):
            return super().values(manipulator, poses) * float(manipulator.leg_lengths[0])

    machine = Machine(orthoglide(), {"it": Demand("it", Single(), {"at_most": 2.0})})
    claim = prove(machine, CUBE, slack=1e-3, tolerances={"leg_lengths": 1e-4})[-1]
    assert claim.verdict == "undecided"
    assert "float()" in claim.why
    assert prove(machine, CUBE, slack=1e-3)[-1].verdict == "proved"


class Bowl(Measure):
    """x² + y² and nothing that depends on z, though over a box waste (sin² + cos² − 1) seems to."""

    unit: ClassVar[str] = "m^2"
    sides: ClassVar[frozenset[str]] = frozenset({"at_most"})
    waste: float = 0.0

    def values(self, manipulator, poses):  # noqa: ARG002
        x, y, z = poses.T
        return x * x + y * y + self.waste * (np.sin(20 * z) ** 2 + np.cos(20 * z) ** 2 - 1)


def test_a_coordinate_that_changes_nothing_is_not_cut():
    """Its bound holds with little to spare along a whole edge: thousands of boxes, were that cut too."""
    low, high = np.array(CUBE.low), np.array(CUBE.high)
    greatest = float(2 * np.maximum(low**2, high**2)[0])
    bounds = {"at_most": greatest * (1 + 1e-7)}
    idle, wasted = (
        claims_of(orthoglide(), Bowl(waste=waste), bounds, slack=0.0, boxes=200_000)["it", "at_most"]
        for waste in (0.0, 1e-3)
    )
    assert (idle.verdict, wasted.verdict) == ("proved", "proved")
    assert idle.boxes < 300 < wasted.boxes

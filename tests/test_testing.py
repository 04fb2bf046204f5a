"""The conformance test passes what is built in, and catches each planted fault with its pose."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar, Literal

import numpy as np
import pytest

from orthospec.errors import NoEnclosure
from orthospec.manipulators import Manipulator, Skeleton
from orthospec.manipulators.linear_delta import LinearDelta
from orthospec.manipulators.orthoglide import Orthoglide
from orthospec.measures import ConvexForm, Measure
from orthospec.measures.elastic import Deflection
from orthospec.measures.forms import greatest_entry
from orthospec.quantities import Acceleration, Length, Mass, Number
from orthospec.registry import MEASURES, distribution_of, find_measure, names
from orthospec.testing import Nonconformity, check_manipulator, check_measure

WHOLE = Orthoglide.model_validate(
    {
        "leg_lengths": [0.31, 0.33, 0.35],
        "legs": {
            "kind": "PRPaR",
            "section": {"round": {"diameter": 0.02}},
            "material": "steel",
            "spacing": 0.08,
        },
        "actuators": {"stiffness": 5e7, "mass": 1.0, "force": 100.0, "speed": 1.0, "friction": 2.0},
        "platform": {"mass": 1.0},
        "gravity": [0.5, -1.0, -9.0],
    }
)
BUILT_IN = [n for n in names(MEASURES) if distribution_of(MEASURES, n).distribution == "orthospec"]
KEYS: Mapping[str, Mapping[str, float]] = {
    "deflection": {"force": 100.0},
    "rotation": {"torque": 10.0},
    "joint_speed": {"speed": 1.0},
    "actuator_force": {"acceleration": 1.0, "speed": 2.0},
}


def test_the_built_in_machines_conform() -> None:
    check_manipulator(WHOLE)
    delta = LinearDelta(leg_lengths=(0.4,) * 3, base_radius=0.25, platform_radius=0.05)
    check_manipulator(delta, region=([-0.3, -0.3, -0.2], [0.3, 0.3, 0.2]))


@pytest.mark.parametrize("name", BUILT_IN)
def test_the_measures_at_hand_conform(name: str) -> None:
    check_measure(find_measure(name)(**KEYS.get(name, {})), WHOLE)


def test_a_measure_whose_numbers_have_different_units_conforms() -> None:
    check_measure(Deflection(wrench=(10.0, -20.0, 5.0, 1.0, 2.0, -3.0)), WHOLE)


class Slider(Manipulator):
    """One slider and a leg to a point on a line above it: ρ = x + sqrt(L² − h²), x the pose."""

    leg: Length = 1.0
    """Length of the leg [m]."""
    most: Length = 0.4
    """How far to either side the tool may go [m]."""

    axes: ClassVar[tuple[str, ...]] = ("x", "y")
    joint_units: ClassVar[tuple[str, ...]] = ("m", "m")
    index_units: ClassVar[Mapping[str, str]] = {"stroke": "m"}
    toleranced: ClassVar[Mapping[str, str]] = {"leg": "m", "most": "m"}

    def inverse_kinematics(self, poses: Any) -> Any:
        """ρ1 = sqrt(L² + x²), ρ2 = y + x."""
        joints = np.stack([np.sqrt(self.leg**2 + poses[:, 0] ** 2), poses.sum(axis=1)], axis=1)
        return joints, np.min(np.stack(list(self.reach(poses).values())), axis=0) >= -1e-12

    def reach(self, poses: Any) -> Any:
        """Within most of the origin."""
        return {"side": 1 - np.abs(poses[:, 0]) / self.most, "height": 1 - np.abs(poses[:, 1]) / self.most}

    def inverse_jacobian(self, poses: Any) -> Any:
        """Rows (x / ρ1, 0) and (1, 1)."""
        slope = poses[:, 0] / np.sqrt(self.leg**2 + poses[:, 0] ** 2)
        first = np.stack([slope, np.zeros_like(slope)], axis=1)
        return np.stack([first, np.ones_like(first)], axis=1)

    def indices(self, joint_ranges: Any) -> Any:
        """The longer travel."""
        return {"stroke": float(np.max(joint_ranges[:, 1] - joint_ranges[:, 0]))}

    def skeleton(self, poses: Any) -> Skeleton:
        """One line."""
        line = np.zeros((len(poses), 1, 2, 3))
        line[:, 0, 1, :2] = poses
        return Skeleton(line, np.array([0.01]), ("leg_1",))


class Heavy(Slider):
    """Both joints move a mass, and the first one lifts it."""

    mass: Mass = 2.0
    """Each of the masses [kg]."""
    gravity: Acceleration = 9.81
    """Against the first joint [m/s^2]."""

    def joint_inertia(self, poses: Any) -> Any:
        """Of the masses."""
        return np.tile(self.mass * np.eye(2), (len(poses), 1, 1))

    def rest_load(self, poses: Any) -> Any:
        """The first mass's weight."""
        return np.tile([self.mass * self.gravity, 0.0], (len(poses), 1))

    def velocity_forces(self, poses: Any) -> Any:
        """ρ̈1 = L² / ρ1³ ẋ² at a constant velocity."""
        found = np.zeros((len(poses), 2, 2, 2))
        found[:, 0, 0, 0] = self.mass * self.leg**2 / np.sqrt(self.leg**2 + poses[:, 0] ** 2) ** 3
        return found


def refuse_points(boxes: Any) -> None:
    if (boxes.hi == boxes.lo).all():
        raise NoEnclosure("a point", "of no width", "a box")


class Wrong:
    """Planted faults: each a class, and what is said of it."""

    class Undescribed(Slider):
        """Has a field without a word."""

        other: Length = 1.0

    class Shape(Slider):
        """Joints of one column."""

        def inverse_kinematics(self, poses: Any) -> Any:
            joints, reachable = super().inverse_kinematics(poses)
            return joints, reachable[:, None]

    class Flags(Slider):
        """Reaches what its margins forbid."""

        def inverse_kinematics(self, poses: Any) -> Any:
            joints, reachable = super().inverse_kinematics(poses)
            return joints, reachable | (poses[:, 0] > 0)

    class Shy(Slider):
        """Does not reach what its margins allow."""

        def inverse_kinematics(self, poses: Any) -> Any:
            joints, reachable = super().inverse_kinematics(poses)
            return joints, reachable & (poses[:, 0] > 0)

    class Gaps(Slider):
        """Has no joints where it says it reaches."""

        def inverse_kinematics(self, poses: Any) -> Any:
            joints, reachable = super().inverse_kinematics(poses)
            return np.where(poses[:, :1] > 0.1, np.nan, joints), reachable

    class Derivative(Slider):
        """J instead of J⁻¹."""

        def inverse_jacobian(self, poses: Any) -> Any:
            return -super().inverse_jacobian(poses)

    class Company(Slider):
        """A pose's margin depends on the others."""

        def reach(self, poses: Any) -> Any:
            return {name: m - 1e-3 * np.mean(poses) for name, m in super().reach(poses).items()}

    class Yielding(Slider):
        """A pose's compliance, which is small, depends on the others."""

        def compliance(self, poses: Any) -> Any:
            return np.tile(1e-9 * (1 + np.ptp(poses)) * np.eye(6), (len(poses), 1, 1))

    class Careless(Slider):
        """Writes into what it is given."""

        def inverse_jacobian(self, poses: Any) -> Any:
            if poses.flags.writeable:
                poses[:] = 0
            return super().inverse_jacobian(np.array(poses))

    class Metres(Slider):
        """A length stands in the code."""

        def reach(self, poses: Any) -> Any:
            return super().reach(poses) | {"near": 1 - np.sum(poses**2, axis=1) / 0.1}

    class Unit(Slider):
        """An index without a unit."""

        def indices(self, joint_ranges: Any) -> Any:
            return {**super().indices(joint_ranges), "extra": 1.0}

    class Drawn(Slider):
        """Two names for one line."""

        def skeleton(self, poses: Any) -> Skeleton:
            drawn = super().skeleton(poses)
            return Skeleton(drawn.segments, drawn.radii, ("a", "b"))

    class Hollow(Slider):
        """A line of less than no width."""

        def skeleton(self, poses: Any) -> Skeleton:
            drawn = super().skeleton(poses)
            return Skeleton(drawn.segments, -drawn.radii, drawn.names)

    class Blurred(Slider):
        """A line of a width that is not known."""

        def skeleton(self, poses: Any) -> Skeleton:
            drawn = super().skeleton(poses)
            return Skeleton(drawn.segments, np.nan * drawn.radii, drawn.names)

    class Missing(Slider):
        """Asks for a field that it does not have."""

        def missing(self, what: str) -> tuple[str, ...]:
            return ("mass",) if what == "compliance" else ()

    class Promising(Slider):
        """An index that it never gives."""

        index_units: ClassVar[Mapping[str, str]] = {**Slider.index_units, "reserve": "1"}

    class Open(Slider):
        """A margin that it does not enclose."""

        def reach_enclosure(self, boxes: Any) -> Any:
            return dict(list(super().reach_enclosure(boxes).items())[1:])

    class Absent(Slider):
        """What it misses cannot be asked."""

        def missing(self, what: str) -> tuple[str, ...]:
            raise KeyError(what)

    class Soft(Slider):
        """A compliance that is not symmetric."""

        def compliance(self, poses: Any) -> Any:
            return np.tile(np.triu(np.ones((6, 6))) + 6 * np.eye(6), (len(poses), 1, 1))

    class Rising(Slider):
        """Rises against a load."""

        def compliance(self, poses: Any) -> Any:
            return np.tile(-np.eye(6), (len(poses), 1, 1))

    class Torn(Slider):
        """A compliance that is not known."""

        def compliance(self, poses: Any) -> Any:
            return np.where(poses[:, :1, None] > 0.2, np.nan, np.eye(6))

    class Loose(Slider):
        """A compliance that is inf in part."""

        def compliance(self, poses: Any) -> Any:
            return np.tile(np.diag([np.inf, 1, 1, 1, 1, 1]), (len(poses), 1, 1))

    class Vague(Slider):
        """Masses that are not known."""

        def joint_inertia(self, poses: Any) -> Any:
            return np.where(poses[:, :1, None] > 0.2, np.nan, np.eye(2))

    class Light(Slider):
        """A mass below nothing."""

        def joint_inertia(self, poses: Any) -> Any:
            return np.tile(np.diag([1.0, -1.0]), (len(poses), 1, 1))

    class Unnamed(Slider):
        """Something that may be off is no field."""

        toleranced: ClassVar[Mapping[str, str]] = {"mass": "kg"}

    class Grams(Slider):
        """A length that may be off by a mass."""

        toleranced: ClassVar[Mapping[str, str]] = {"leg": "kg"}

    class Chosen(Slider):
        """What may be off is a word."""

        leg_kind: Literal["steel"] = "steel"
        """What the leg is made of."""
        toleranced: ClassVar[Mapping[str, str]] = {"leg_kind": "m"}

    class Same(Slider):
        """Is itself whatever it is off by."""

        def varied(self, fields: Any) -> Any:  # noqa: ARG002
            return self

    class Averaging(Slider):
        """Takes one number for all poses."""

        def inverse_kinematics(self, poses: Any) -> Any:
            joints, reachable = super().inverse_kinematics(poses)
            return np.stack([np.hypot(np.mean(self.leg), poses[:, 0]), joints[:, 1]], axis=1), reachable

    class Single(Slider):
        """Cannot have an array in a field."""

        def reach(self, poses: Any) -> Any:
            return Slider(leg=float(self.leg), most=float(self.most)).reach(poses)

    class Exact(Slider):
        """Encloses the reach of one machine for that of all within an interval."""

        def reach_enclosure(self, boxes: Any) -> Any:
            return Slider().reach_enclosure(boxes)

    class Tireless(Heavy):
        """A load that gives work around a loop."""

        def rest_load(self, poses: Any) -> Any:
            return super().rest_load(poses) * (1 + poses[:, 1:])

    class Weary(Heavy):
        """A load that is not known."""

        def rest_load(self, poses: Any) -> Any:
            return np.where(poses[:, :1] > 0.2, np.nan, super().rest_load(poses))

    class Braking(Heavy):
        """Forces of the wrong sign."""

        def velocity_forces(self, poses: Any) -> Any:
            return -super().velocity_forces(poses)

    class Lopsided(Heavy):
        """Forces that are right for every velocity, in matrices that are not symmetric."""

        def velocity_forces(self, poses: Any) -> Any:
            return super().velocity_forces(poses) + np.array([[0.0, 1.0], [-1.0, 0.0]])

    class Certain(Slider):
        """An enclosure of its margins that is too narrow."""

        def reach_enclosure(self, boxes: Any) -> Any:
            from orthospec.intervals import Interval

            return {name: Interval(m, m) for name, m in self.reach(boxes.centres).items()}

    class Choosy(Certain):
        """The same, but it refuses points."""

        def reach_enclosure(self, boxes: Any) -> Any:
            refuse_points(boxes)
            return super().reach_enclosure(boxes)


MACHINES = {
    "Undescribed": "field other has no description",
    "Shape": "gave no flags beside the joints",
    "Flags": r"at \(.*\) is called reachable though a margin is below 0",
    "Shy": r"at \(.*\) is called out of reach though all margins are above 0",
    "Gaps": r"joints are not finite at \(.*\), which is called reachable",
    "Derivative": r"inverse_jacobian for joint 1 and x at \(.*\) is .*, by differences",
    "Company": "alone and",
    "Yielding": r"compliance gives [^g]* alone and",
    "Careless": "inverse_jacobian changes the poses",
    "Metres": "twice as large, it reaches otherwise",
    "Promising": "indices gave no 'reserve', which index_units names",
    "Open": "reach_enclosure gave no '.*', which reach has",
    "Absent": r"raised KeyError: '.*' \(test_testing.py:\d+\): raise nothing",
    "Unit": "indices gave 'extra', of which index_units knows no unit",
    "Drawn": "1 names|2 names",
    "Hollow": r"skeleton's 'leg_1' has the radius -0\.01",
    "Blurred": r"skeleton's 'leg_1' has the radius nan",
    "Missing": r"missing\('compliance'\) names 'mass', which is no field",
    "Soft": "compliance is not symmetric",
    "Rising": "compliance gives way against a load",
    "Torn": r"compliance is neither finite nor inf at \(.*\), well within the reach",
    "Loose": r"compliance is neither finite nor inf at \(.*\), well within the reach",
    "Vague": r"joint_inertia is not finite at \(.*\), well within the reach",
    "Light": "joint_inertia is not symmetric and positive definite",
    "Unnamed": "toleranced names 'mass', which is no field",
    "Grams": "toleranced has 'leg' in kg, the field itself is in m",
    "Chosen": "toleranced names 'leg_kind', which is 'steel'",
    "Same": r"gives .* with arrays in 'leg' and 'most', and .* with the numbers of this pose",
    "Averaging": r"inverse_kinematics gives .* with arrays in 'leg' and 'most', and",
    "Single": r"fails with arrays \(n,\) in 'leg' and 'most': .* TypeError",
    "Exact": r"reach 'side' leaves its enclosure at \(.*\) with leg .*, where intervals stand in 'leg'",
    "Tireless": r"rest_load has no energy at \(.*\): its force at the tool along x changes with y by",
    "Weary": r"rest_load is not finite at \(.*\), well within the reach",
    "Braking": r"velocity_forces of joint 1 for x and x at \(.*\) is -.*, by differences of the inertia",
    "Lopsided": r"velocity_forces of joint 1 for x and y at \(.*\) is 1, by differences of the inertia",
    "Certain": "leaves its enclosure",
    "Choosy": "leaves its enclosure",
}
REGION = ([-0.5, -0.5], [0.5, 0.5])


def test_the_machine_that_the_faults_are_planted_in_conforms() -> None:
    check_manipulator(Slider(), REGION)
    check_manipulator(Heavy(), REGION)


@pytest.mark.parametrize("fault", MACHINES)
def test_a_fault_of_a_machine_is_caught(fault: str) -> None:
    machine = getattr(Wrong, fault)
    machine.__qualname__ = f"Wrong.{fault}"
    with pytest.raises(Nonconformity, match=MACHINES[fault]):
        check_manipulator(machine(), REGION)


class Height(Measure):
    """Distance of the tool from the x axis and something more, times a factor."""

    factor: Number = 1.0
    """By what it is multiplied."""
    more: Length = 1.0
    """What is added [m]."""
    unit: ClassVar[str] = "m"
    sides: ClassVar[frozenset[str]] = frozenset({"at_most"})
    least: ClassVar[float] = 0.0

    def values(self, manipulator: Any, poses: Any) -> Any:  # noqa: ARG002
        """What is added and |y|."""
        return self.factor * (self.more + np.abs(poses[:, 1]))


class WrongMeasure:
    class Unknown(Height):
        """A unit that nobody knows."""

        unit: ClassVar[str] = "parsec"

    class Sides(Height):
        """No side."""

        sides: ClassVar[frozenset[str]] = frozenset({"above"})

    class Whole(Height):
        """Numbers that are not floats."""

        def values(self, manipulator: Any, poses: Any) -> Any:
            return super().values(manipulator, poses).astype(int)

    class Holes(Height):
        """No value at some poses."""

        def values(self, manipulator: Any, poses: Any) -> Any:
            return np.where(poses[:, 0] > 0.1, np.nan, super().values(manipulator, poses))

    class Company(Height):
        """A pose's value depends on the others."""

        def values(self, manipulator: Any, poses: Any) -> Any:
            return super().values(manipulator, poses) + poses.mean()

    class Swapped(Height):
        """The greatest first."""

        def values(self, manipulator: Any, poses: Any) -> Any:
            value = super().values(manipulator, poses)
            return np.stack([value + 1, value], axis=1)

    class Below(Height):
        """Values below its least."""

        least: ClassVar[float] = 1.2

    class Metres(Height):
        """A length stands in the code."""

        def values(self, manipulator: Any, poses: Any) -> Any:
            return super().values(manipulator, poses) + 0.1

    class Fast(Height):
        """A unit that is not that of the values."""

        unit: ClassVar[str] = "m/s"

    class Certain(Height):
        """An enclosure that is too narrow."""

        def enclosure(self, manipulator: Any, boxes: Any) -> Any:
            from orthospec.intervals import Interval

            values = self.values(manipulator, boxes.centres)
            return Interval(values, values)

    class Elsewhere(Height):
        """An enclosure whose form is over larger boxes of its own."""

        def enclosure(self, manipulator: Any, boxes: Any) -> Any:
            from orthospec.intervals import Boxes

            wider = Boxes(boxes.lo - 0.01, boxes.hi + 0.01)
            return super().enclosure(manipulator, wider)

    class Choosy(Certain):
        """The same, but it refuses points."""

        def enclosure(self, manipulator: Any, boxes: Any) -> Any:
            refuse_points(boxes)
            return super().enclosure(manipulator, boxes)

    class Outside(Height):
        """Raises out of reach."""

        def values(self, manipulator: Any, poses: Any) -> Any:
            if (np.abs(poses[:, 0]) > 1.001 * manipulator.most).any():
                raise ValueError("too far")
            return super().values(manipulator, poses)

    class Spreading(Height):
        """Has no value anywhere where one pose has none."""

        def values(self, manipulator: Any, poses: Any) -> Any:
            known = manipulator.inverse_kinematics(poses)[1].all()
            return np.where(known, super().values(manipulator, poses), np.nan)

    class Dividing(Height):
        """Raises at one pose alone."""

        def values(self, manipulator: Any, poses: Any) -> Any:
            if len(poses) == 1:
                raise ZeroDivisionError("no number")
            return super().values(manipulator, poses)

    class Boxless(Height):
        """Raises over boxes."""

        def values(self, manipulator: Any, poses: Any) -> Any:
            if not isinstance(poses, np.ndarray):
                raise ZeroDivisionError("no number")
            return super().values(manipulator, poses)

    class Ending(Height):
        """Ends the program."""

        def values(self, manipulator: Any, poses: Any) -> Any:  # noqa: ARG002
            raise SystemExit(7)

    class Masked(Height):
        """Masks some values."""

        def values(self, manipulator: Any, poses: Any) -> Any:
            return np.ma.masked_greater(super().values(manipulator, poses), 1.2)

    class Formless(Height):
        """Gives something else for a form."""

        def form(self, manipulator: Any, poses: Any, side: str) -> Any:  # noqa: ARG002
            return 5

    class Short(Height):
        """A form for one pose only."""

        def form(self, manipulator: Any, poses: Any, side: str) -> Any:  # noqa: ARG002
            return greatest_entry(np.log(self.values(manipulator, poses))[:1, None])

    class Holding(Height):
        """A form whose constraints raise."""

        def form(self, manipulator: Any, poses: Any, side: str) -> Any:  # noqa: ARG002
            def holds(*_: Any) -> Any:
                raise ValueError("no such thing")

            return ConvexForm(np.log(self.values(manipulator, poses))[:, None], holds)

    class Unformed(Height):
        """Has no form out of reach."""

        def form(self, manipulator: Any, poses: Any, side: str) -> Any:  # noqa: ARG002
            if not manipulator.inverse_kinematics(poses)[1].all():
                raise ValueError("too far")
            return greatest_entry(np.log(self.values(manipulator, poses))[:, None])

    class Blank(Height):
        """A form of nothing that is known."""

        def form(self, manipulator: Any, poses: Any, side: str) -> Any:  # noqa: ARG002
            return greatest_entry(np.full((len(poses), 1), np.nan))

    class Lenient(Height):
        """A form that holds where the bound does not."""

        def form(self, manipulator: Any, poses: Any, side: str) -> Any:  # noqa: ARG002
            inside = np.log(0.5 * self.values(manipulator, poses))[:, None]
            from orthospec.measures import logarithm

            return ConvexForm(inside, lambda x, bound, slack: [x <= logarithm(bound) + slack])

    class Absolute(Height):
        """A form whose slack is not relative."""

        def form(self, manipulator: Any, poses: Any, side: str) -> Any:  # noqa: ARG002
            inside = self.values(manipulator, poses)[:, None]
            return ConvexForm(inside, lambda x, bound, slack: [x <= bound + 1000 * slack])


MEASURES_WITH_FAULTS = {
    "Unknown": "unit 'parsec'",
    "Sides": "at_least, at_most or both",
    "Whole": "floats .* are owed",
    "Holes": r"the value is NaN at \(.*\), well within the reach",
    "Company": "alone and",
    "Swapped": "the least value exceeds the greatest",
    "Below": "the value is below 'least'",
    "Metres": r"the value is no 'm' at \(.*\): with a unit of length 0.5 times as large it is .*, not",
    "Fast": r"the value is no 'm/s' at \(.*\): with a unit of time 0.5 times as large it is .*, not",
    "Elsewhere": "the value leaves its enclosure",
    "Certain": "the value leaves its enclosure",
    "Choosy": "the value leaves its enclosure",
    "Dividing": r"values at \(.*\), in reach, raised ZeroDivisionError: no number: give NaN",
    "Boxless": "enclosure over 40 boxes raised ZeroDivisionError: no number: give None",
    "Ending": r"values for a block of \d+ poses raised SystemExit: 7",
    "Masked": "values gave MaskedArray",
    "Formless": "the form of at_most is int: give ConvexForm",
    "Short": r"inside of the form of at_most has the shape \(1, 1\): \(\d+, ...\) is owed",
    "Holding": "holds of the form of at_most for the bound .* raised ValueError: no such thing: give cvxpy",
    "Outside": r"values at \(.*\), out of reach, raised ValueError: too far",
    "Spreading": r"in a block with poses out of reach",
    "Unformed": r"form of at_most at \(.*\), out of reach, raised ValueError: too far",
    "Blank": r"inside of the form of at_most is not finite at \(.*\), where the value is",
    "Lenient": "the form of at_most needs a slack of",
    "Absolute": "the form of at_most needs a slack of",
}


def test_the_measure_that_the_faults_are_planted_in_conforms() -> None:
    check_measure(Height(), Slider(), REGION)


class Longer(Height):
    """A measure for machines with one leg alone."""

    def values(self, manipulator: Any, poses: Any) -> Any:
        """The leg comes to it."""
        return super().values(manipulator, poses) + manipulator.leg


def test_a_measure_for_machines_of_one_class_conforms() -> None:
    check_measure(Longer(), Slider(), REGION)


@pytest.mark.parametrize("fault", MEASURES_WITH_FAULTS)
def test_a_fault_of_a_measure_is_caught(fault: str) -> None:
    with pytest.raises(Nonconformity, match=MEASURES_WITH_FAULTS[fault]):
        check_measure(getattr(WrongMeasure, fault)(), Slider(), REGION)


class Sideways(Measure):
    """How fast the tool goes along x, of the frame that happens to be."""

    unit: ClassVar[str] = "1"
    sides: ClassVar[frozenset[str]] = frozenset({"at_most"})

    def values(self, manipulator: Any, poses: Any) -> Any:
        """|J_x|."""
        return np.linalg.norm(np.linalg.inv(manipulator.inverse_jacobian(poses))[:, 0], axis=1)


def test_a_measure_that_depends_on_the_frame_is_caught() -> None:
    with pytest.raises(Nonconformity, match=r"depends on the frame in which the machine is told at \("):
        check_measure(Sideways(), WHOLE)


def test_a_machine_without_an_end_asks_for_a_region() -> None:
    class Endless(Slider):
        """Reaches everything."""

        def reach(self, poses: Any) -> Any:
            return {"all": np.ones(len(poses))}

    with pytest.raises(Nonconformity, match=r"give the test a region=\(low, high\)"):
        check_manipulator(Endless())

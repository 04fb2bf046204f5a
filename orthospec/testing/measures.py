"""The promises of a measure."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from orthospec.errors import NoEnclosure
from orthospec.intervals import as_interval
from orthospec.manipulators import Manipulator
from orthospec.measures import ConvexForm, Measure
from orthospec.measures.demand import bounded_side
from orthospec.testing.expectations import (
    asked,
    at,
    documented,
    expect,
    faults_told,
    is_unit,
    survives,
    where,
)
from orthospec.testing.fields import apart
from orthospec.testing.machines import MachineUnderTest
from orthospec.testing.sampling import (
    ALIKE,
    CLOSE,
    INSIDE,
    LARGER,
    SINGLES,
    block,
    boxes,
    read_only,
    retold,
    told_at,
    tried_in,
    within,
)
from orthospec.testing.views import Units, axis_factors, in_units, turned
from orthospec.workspace.cuboid import Cuboid

if TYPE_CHECKING:
    from orthospec.arrays import Array, Poses


def check_measure(measure: Measure, machine: Manipulator, region: tuple[Any, Any] | None = None) -> None:
    """Try every promise of a measure on a machine that conforms; `Nonconformity` tells the first one broken.

    ``region``, least and greatest coordinates, is where to try; a box around the reach is found if left out.
    """
    with faults_told(measure):
        _Measure(measure, machine, tried_in(machine, region)).check()


NAN = "give NaN where there is no value, in reach or out of it"


class _Measure:
    """The promises of a measure."""

    SIDES: ClassVar[frozenset[str]] = frozenset({"at_least", "at_most"})

    def __init__(self, measure: Measure, machine: Manipulator, box: Cuboid) -> None:
        self.measure, self.machine = measure, machine
        self.of_machine = MachineUnderTest(machine, box)
        self.poses = self.of_machine.inside()

    def check(self) -> None:
        """Try all of them."""
        documented(type(self.measure))
        survives(self.measure)
        self.declared()
        self.values()
        self.outside()
        self.frame()
        self.units()
        self.enclosure()
        for side in sorted(self.measure.sides):
            form = self.form_at(side, self.poses)
            if form is not None:
                self.form(form, side)

    def declared(self) -> None:
        """Unit, sides and needs are those that orthospec knows."""
        measure = self.measure
        is_unit(measure, measure.unit, "unit")
        expect(
            measure.sides and measure.sides <= self.SIDES,
            measure,
            f"sides are {sorted(measure.sides)}",
            "at_least, at_most or both",
        )
        needs = {"compliance", "joint_inertia", "actuator_forces", "actuator_speeds", "sliding_joints"}
        expect(
            measure.needs <= needs,
            measure,
            f"needs {sorted(measure.needs - needs)}",
            f"of {', '.join(sorted(needs))}",
        )

    def values(self) -> None:
        """Shapes, order, and the same for each pose in any company."""
        measure, poses, before = self.measure, self.poses, self.poses.copy()
        together, given = self.values_at(poses), before.copy()
        again = self.values_at(given)
        n = len(poses)
        expect(
            isinstance(together, np.ndarray)
            and not isinstance(together, np.ma.MaskedArray)
            and together.shape in {(n,), (n, 2)}
            and together.dtype.kind == "f",
            measure,
            f"values gave {type(together).__name__} of shape {np.shape(together)}",
            f"floats ({n},) or ({n}, 2) are owed",
        )
        expect(np.array_equal(given, before), measure, "values changes the poses", "compute with copies")
        expect(
            np.array_equal(together, again, equal_nan=True),
            measure,
            "values gives other numbers the second time",
            "nothing random, and no state",
        )
        wrong = np.asarray(np.isnan(together).reshape(n, -1).any(axis=1))
        expect(
            not wrong.any(),
            measure,
            f"the value is NaN {where(poses, wrong)}, well within the reach",
            "what is infinite is inf; what cannot be computed is for poses out of reach",
        )
        for k in range(0, n, max(n // SINGLES, 1)):
            alone = self.values_at(poses[k : k + 1].copy())
            expect(
                np.shape(alone) == (1, *together.shape[1:]),
                measure,
                f"values gave the shape {np.shape(alone)} for one pose alone {at(poses[k])}",
                f"{(1, *together.shape[1:])} is owed, as for a block",
            )
            alone = alone[0]
            if found := apart(alone, together, k):
                said = f"values gives {found[0]} alone and {found[1]} in a block {at(poses[k])}"
                expect(False, measure, said, "each pose on its own row")
        if together.ndim == 2:
            wrong = together[:, 0] > together[:, 1]
            expect(
                not wrong.any(),
                measure,
                f"the least value exceeds the greatest {where(poses, wrong)}",
                "swap them",
            )
        wrong = np.asarray((together < measure.least - CLOSE * abs(measure.least)).reshape(n, -1).any(axis=1))
        expect(
            not wrong.any(),
            measure,
            f"the value is below 'least' {where(poses, wrong)}",
            f"least is {measure.least}",
        )

    def outside(self) -> None:
        """Values and forms are computed out of reach too, NaN or not, and change none within it."""
        fields: dict[str, Callable[[Poses], Any]] = {"values": self.values_at}
        for side in sorted(self.measure.sides):
            fields[f"form of {side}"] = partial(self.inside_of_form, side)
        beyond = self.beyond()
        for name, ask in fields.items() if len(beyond) else ():
            for k in range(len(beyond)):
                ask(beyond[k : k + 1])
            alone, mixed = ask(self.poses), ask(read_only(np.concatenate([self.poses, beyond])))
            for k in range(len(self.poses) if alone is not None else 0):
                if found := apart(mixed[k], alone, k):
                    said = (
                        f"{name} gives {found[0]} {at(self.poses[k])} in a block with poses out of reach,"
                        f" {found[1]} without them"
                    )
                    expect(False, self.measure, said, "each pose on its own row")

    def told(self, poses: Poses) -> str:
        """Which poses, in words."""
        if len(poses) > 1:
            return f"for a block of {len(poses)} poses"
        reachable = self.machine.inverse_kinematics(poses)[1][0]
        return f"{at(poses[0])}, {'in' if reachable else 'out of'} reach,"

    def values_at(self, poses: Poses) -> Array:
        """The values at the poses."""
        ask = partial(self.measure.values, self.machine, poses)
        return asked(self.measure, f"values {self.told(poses)}", ask, NAN)

    def form_at(self, side: str, poses: Poses) -> ConvexForm | None:
        """The form of a side at the poses, its inside with a row for each."""
        ask = partial(self.measure.form, self.machine, poses, side)
        form = asked(self.measure, f"the form of {side} {self.told(poses)}", ask, NAN)
        if form is None:
            return None
        expect(
            isinstance(form, ConvexForm),
            self.measure,
            f"the form of {side} is {type(form).__name__}",
            "give ConvexForm(inside, holds), or None where there is none",
        )
        expect(
            isinstance(form.inside, np.ndarray) and form.inside.shape[:1] == (len(poses),),
            self.measure,
            f"inside of the form of {side} has the shape {np.shape(form.inside)}",
            f"({len(poses)}, ...) is owed",
        )
        return form

    def inside_of_form(self, side: str, poses: Poses) -> Array | None:
        """What the form of a side linearises."""
        form = self.form_at(side, poses)
        return None if form is None else form.inside

    def beyond(self) -> Poses:
        """Poses out of reach, near and far."""
        box, axes = self.of_machine.box, self.of_machine.axes
        wide = block(Cuboid.around(box.centre, 2 * box.size), axes, seed=5)
        poses = np.concatenate([self.of_machine.poses, wide])
        return read_only(poses[~self.machine.inverse_kinematics(read_only(poses))[1]])

    def frame(self) -> None:
        """In turned axes the same machine has the same values, unless the measure is given a direction."""
        named = [value for value in self.measure.model_dump().values() if isinstance(value, list | tuple)]
        if self.machine.axes != ("x", "y", "z") or named:
            return
        axes, _ = np.linalg.qr(np.random.default_rng(4).standard_normal((3, 3)))
        turn = axes * np.sign(np.linalg.det(axes))
        here = self.values_at(self.poses)
        there = seen(self.measure, turned(self.machine, turn), self.poses @ turn.T)
        if there is None:
            return
        alike = np.isclose(here, there, rtol=ALIKE, atol=0).reshape(len(here), -1)
        wrong = np.asarray(~alike.all(axis=1))
        expect(
            not wrong.any(),
            self.measure,
            f"the value depends on the frame in which the machine is told {where(self.poses, wrong)}",
            "a direction of its own has to be a field of the measure",
        )

    def units(self) -> None:
        """In other units of length, mass and time the values are what the measure's unit says.

        With angles among joints or pose coordinates a norm mixes them with lengths: then not for those.
        """
        angles = {*self.machine.axes} - {"x", "y", "z"} or {*self.machine.joint_units} - {"m"}
        here = self.values_at(self.poses)
        for kind in ("mass", "time") if angles else ("length", "mass", "time"):
            for units in (Units(**{kind: factor}) for factor in (LARGER, 1 / LARGER)):
                measure = retold(self.measure, units)
                poses = self.poses * axis_factors(self.machine, units)
                there = None if measure is None else seen(measure, in_units(self.machine, units), poses)
                if there is None:
                    continue
                owed = here * units.of(self.measure.unit)
                size = float(np.abs(owed[np.isfinite(owed)]).max(initial=0.0))
                alike = np.isclose(there, owed, rtol=ALIKE, atol=CLOSE * size).reshape(len(here), -1)
                wrong = np.asarray(~alike.all(axis=1))
                k = int(np.argmax(wrong))
                expect(
                    not wrong.any(),
                    self.measure,
                    f"the value is no '{self.measure.unit}' {where(self.poses, wrong)}: with a unit of {kind}"
                    f" {1 / getattr(units, kind):g} times as large it is {there[k]}, not {owed[k]}",
                    "check 'unit'; what has a unit has to be a field of orthospec.quantities with that unit",
                )

    def enclosure(self) -> None:
        """Values at poses of a box lie within what is told of the whole box."""
        for several in boxes(self.of_machine.box, self.of_machine.axes, around=self.poses):
            try:
                enclosed = asked(
                    self.measure,
                    f"enclosure over {len(several)} boxes",
                    partial(self.measure.enclosure, self.machine, several),
                    "give None, or raise NoEnclosure, where nothing is known of boxes",
                )
            except NoEnclosure:
                continue  # Allowed: then nothing is proved of these.
            if enclosed is None:
                continue
            enclosed = as_interval(enclosed)
            for k in range(INSIDE):
                poses = within(several, k)
                values = self.values_at(poses)
                expect(
                    enclosed.lo.shape == values.shape,
                    self.measure,
                    f"enclosure has the shape {enclosed.lo.shape}",
                    f"that of values is {values.shape}",
                )
                least, greatest = told_at(enclosed, several, poses)
                outside = (values < least) | (values > greatest)
                wrong = np.asarray(outside.reshape(len(poses), -1).any(axis=1))
                expect(
                    not wrong.any(),
                    self.measure,
                    f"the value leaves its enclosure {where(poses, wrong)}",
                    "give nothing that is not certain",
                )

    def form(self, form: ConvexForm, side: str) -> None:
        """The bound holds without slack where the values meet it, and nowhere else."""
        values, n = bounded_side(self.values_at(self.poses), side), len(self.poses)
        sound = np.isfinite(values) & (values > 0)
        wrong = np.asarray(sound & ~np.isfinite(form.inside).reshape(n, -1).all(axis=1))
        expect(
            not wrong.any(),
            self.measure,
            f"inside of the form of {side} is not finite {where(self.poses, wrong)}, where the value is",
            "what is linearised has to be known wherever the value is finite and above 0",
        )
        for k in np.flatnonzero(sound)[:: max(int(sound.sum()) // SINGLES, 1)]:
            for factor in (0.8, 0.95, 1.05, 1.25):
                bound = factor * float(values[k])
                met = factor > 1 if side == "at_most" else factor < 1
                slack = asked(
                    self.measure,
                    f"holds of the form of {side} for the bound {bound:.6g} {at(self.poses[k])}",
                    partial(least_slack, form, k, bound),
                    "give cvxpy constraints that are convex in X, bound and slack",
                )
                needed = abs(np.log(factor))
                holds = slack <= 1e-6 if met else 0.3 * needed < slack < 3 * needed + 1e-6
                expect(
                    holds,
                    self.measure,
                    f"the form of {side} needs a slack of {slack:.3g} for {factor:g} times the value as bound"
                    f" {at(self.poses[k])}",
                    "0 where the value meets it, else about the logarithm of their ratio",
                )


def seen(measure: Measure, view: Manipulator, poses: Poses) -> Array | None:
    """The values on a machine seen otherwise; None where the measure is for machines of one class alone."""
    try:
        return measure.values(view, read_only(poses))
    except Exception:
        return None


def least_slack(form: ConvexForm, k: int, bound: float) -> float:
    """The slack that a form needs for a bound at pose k."""
    import cvxpy as cp

    slack = cp.Variable(nonneg=True)
    problem = cp.Problem(cp.Minimize(slack), form.holds(cp.Constant(form.inside[k]), bound, slack))
    problem.solve(solver=cp.CLARABEL)
    return float(slack.value) if slack.value is not None else np.inf

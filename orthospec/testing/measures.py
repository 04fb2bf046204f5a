"""The promises of a measure."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from orthospec.errors import NoEnclosure, OrthospecError
from orthospec.intervals import as_interval
from orthospec.manipulators import Manipulator
from orthospec.measures import Measure
from orthospec.measures.demand import bounded_side
from orthospec.testing.expectations import at, documented, expect, is_unit, survives, where
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
    from orthospec.measures import ConvexForm


def check_measure(measure: Measure, machine: Manipulator, region: tuple[Any, Any] | None = None) -> None:
    """Try every promise of a measure on a machine that conforms; `Nonconformity` tells the first one broken.

    ``region``, least and greatest coordinates, is where to try; a box around the reach is found if left out.
    """
    _Measure(measure, machine, tried_in(machine, region)).check()


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
            form = self.measure.form(self.machine, self.poses, side)
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
        needs = {"compliance", "joint_inertia", "actuator_forces", "actuator_speeds"}
        expect(
            measure.needs <= needs,
            measure,
            f"needs {sorted(measure.needs - needs)}",
            f"of {', '.join(sorted(needs))}",
        )

    def values(self) -> None:
        """Shapes, order, and the same for each pose in any company."""
        measure, poses, before = self.measure, self.poses, self.poses.copy()
        together, given = measure.values(self.machine, poses), before.copy()
        again = measure.values(self.machine, given)
        n = len(poses)
        expect(
            isinstance(together, np.ndarray)
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
            alone = measure.values(self.machine, poses[k : k + 1].copy())[0]
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
        asked: dict[str, Callable[[Poses], Any]] = {"values": partial(self.measure.values, self.machine)}
        for side in sorted(self.measure.sides):
            asked[f"form of {side}"] = partial(self.inside_of_form, side)
        beyond = self.beyond()
        for name, ask in asked.items() if len(beyond) else ():
            self.raises_nowhere(name, ask, beyond)
            alone, mixed = ask(self.poses), ask(read_only(np.concatenate([self.poses, beyond])))
            for k in range(len(self.poses) if alone is not None else 0):
                if found := apart(mixed[k], alone, k):
                    said = (
                        f"{name} gives {found[0]} {at(self.poses[k])} in a block with poses out of reach,"
                        f" {found[1]} without them"
                    )
                    expect(False, self.measure, said, "each pose on its own row")

    def inside_of_form(self, side: str, poses: Poses) -> Array | None:
        """What the form of a side linearises."""
        form = self.measure.form(self.machine, poses, side)
        return None if form is None else form.inside

    def beyond(self) -> Poses:
        """Poses out of reach, near and far."""
        box, axes = self.of_machine.box, self.of_machine.axes
        wide = block(Cuboid.around(box.centre, 2 * box.size), axes, seed=5)
        poses = np.concatenate([self.of_machine.poses, wide])
        return read_only(poses[~self.machine.inverse_kinematics(read_only(poses))[1]])

    def raises_nowhere(self, name: str, ask: Callable[[Poses], Any], poses: Poses) -> None:
        """Neither at a pose alone nor in a block."""
        for some in (*(poses[k : k + 1] for k in range(len(poses))), poses):
            try:
                ask(some)
            except OrthospecError:
                raise
            except Exception as error:
                place = at(some[0]) if len(some) == 1 else "for a block of poses"
                said = f"{name} raised {type(error).__name__}: {error}; {place}, out of reach"
                expect(False, self.measure, said, "give NaN where there is no value")

    def frame(self) -> None:
        """In turned axes the same machine has the same values, unless the measure is given a direction."""
        named = [value for value in self.measure.model_dump().values() if isinstance(value, list | tuple)]
        if self.machine.axes != ("x", "y", "z") or named:
            return
        axes, _ = np.linalg.qr(np.random.default_rng(4).standard_normal((3, 3)))
        turn = axes * np.sign(np.linalg.det(axes))
        here = self.measure.values(self.machine, self.poses)
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
        here = self.measure.values(self.machine, self.poses)
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
                enclosed = self.measure.enclosure(self.machine, several)
            except NoEnclosure:
                continue  # Allowed: then nothing is proved of these.
            if enclosed is None:
                continue
            enclosed = as_interval(enclosed)
            for k in range(INSIDE):
                poses = within(several, k)
                values = self.measure.values(self.machine, poses)
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
        values, n = bounded_side(self.measure.values(self.machine, self.poses), side), len(self.poses)
        expect(
            len(form.inside) == n,
            self.measure,
            f"inside of the form of {side} has the shape {np.shape(form.inside)}",
            f"({n}, ...) is owed",
        )
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
                slack = least_slack(form, k, bound)
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

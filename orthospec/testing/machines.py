"""The promises of a machine."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from orthospec.errors import NoEnclosure
from orthospec.manipulators import Manipulator
from orthospec.mechanics import inertia
from orthospec.show.keys import keys_of
from orthospec.testing.expectations import (
    at,
    documented,
    expect,
    faults_told,
    is_unit,
    survives,
    where,
)
from orthospec.testing.fields import apart, fields_of, offers
from orthospec.testing.sampling import (
    CLOSE,
    DIFFERENCE,
    INSIDE,
    LARGER,
    POSES,
    SINGLES,
    WELL_INSIDE,
    block,
    boxes,
    retold,
    told_at,
    tried_in,
    within,
)
from orthospec.testing.tolerances import check_toleranced
from orthospec.testing.views import Units

if TYPE_CHECKING:
    from orthospec.arrays import Array, Poses
    from orthospec.workspace.cuboid import Cuboid


def check_manipulator(machine: Manipulator, region: tuple[Any, Any] | None = None) -> None:
    """Try every promise of a machine; raises `Nonconformity` with the first that it does not keep.

    ``region``, least and greatest coordinates, is where to try; a box around the reach is found if left out.
    """
    with faults_told(machine):
        MachineUnderTest(machine, tried_in(machine, region)).check()


class MachineUnderTest:
    """The promises of a machine, each by a method of its own."""

    def __init__(self, machine: Manipulator, box: Cuboid) -> None:
        self.machine, self.box, self.axes = machine, box, len(machine.axes)
        self.poses = block(box, self.axes, seed=1)

    def check(self) -> None:
        """Try all of them."""
        documented(type(self.machine))
        survives(self.machine)
        self.kinematics()
        self.reach()
        self.blocks()
        self.jacobian()
        self.lengths()
        self.enclosure()
        self.indices()
        self.drawing()
        self.missing()
        check_toleranced(self.machine, self.box, self.inside())
        if not self.machine.missing("compliance") and offers(self.machine, "compliance"):
            self.compliance()
        if not self.machine.missing("joint_inertia") and offers(self.machine, "joint_inertia"):
            self.inertia()
            if offers(self.machine, "rest_load"):
                self.rest_load()
            if offers(self.machine, "velocity_forces"):
                self.velocity_forces()

    def kinematics(self) -> None:
        """Joints and flags have their shapes, and joints are finite where they are reachable."""
        machine, n, m = self.machine, len(self.poses), len(self.machine.joint_units)
        joints, reachable = machine.inverse_kinematics(self.poses)
        expect(
            joints.shape == (n, m) and np.asarray(reachable).shape == (n,),
            machine,
            f"inverse_kinematics gave shapes {joints.shape} and {np.shape(reachable)}",
            f"({n}, {m}) joints and ({n},) flags are owed",
        )
        expect(np.asarray(reachable).dtype == bool, machine, "reachable is not of bool", "give flags")
        expect(
            reachable.any(),
            machine,
            "reaches none of the poses that were tried",
            "give the test a region where it does",
        )
        wrong = reachable & ~np.isfinite(joints).all(axis=1)
        expect(
            not wrong.any(),
            machine,
            f"joints are not finite {where(self.poses, wrong)}, which is called reachable",
            "let reach have a margin for what is missing there",
        )
        expect(
            set(machine.axes) <= {"x", "y", "z", "rx", "ry", "rz"},
            machine,
            f"axes are {machine.axes}",
            "each is one of x y z rx ry rz",
        )

    def reach(self) -> None:
        """Flags follow the margins."""
        machine = self.machine
        reachable = machine.inverse_kinematics(self.poses)[1]
        margins = dict(machine.reach(self.poses))
        expect(margins, machine, "reach gives no margin", "a cuboid has to know where the reach ends")
        for name, margin in margins.items():
            expect(
                np.shape(margin) == reachable.shape,
                machine,
                f"reach '{name}' has the shape {np.shape(margin)}",
                f"{reachable.shape} is owed",
            )
        least = np.min(np.stack(list(margins.values())), axis=0)
        for wrong, said in (
            (reachable & ~(least >= -CLOSE), "is called reachable though a margin is below 0 or NaN"),
            (~reachable & (least > CLOSE), "is called out of reach though all margins are above 0"),
        ):
            expect(
                not wrong.any(),
                machine,
                f"the pose {where(self.poses, wrong)} {said}",
                "let flags follow reach",
            )

    def blocks(self) -> None:
        """A block gives what its poses give one by one, twice the same, and is left as it was."""
        before = self.poses.copy()
        for name, field in fields_of(self.machine).items():
            together, given = field(self.machine, self.poses), before.copy()
            again = field(self.machine, given)
            expect(
                np.array_equal(given, before),
                self.machine,
                f"{name} changes the poses that it is given",
                "compute with copies",
            )
            expect(
                np.array_equal(together, again, equal_nan=True),
                self.machine,
                f"{name} gives other numbers the second time",
                "nothing random, and no state",
            )
            for k in range(0, POSES, POSES // SINGLES):
                alone = field(self.machine, self.poses[k : k + 1].copy())[0]
                if found := apart(alone, together, k):
                    said = f"{name} gives {found[0]} alone and {found[1]} in a block {at(self.poses[k])}"
                    expect(False, self.machine, said, "each pose on its own row")

    def inside(self) -> Poses:
        """Poses well within the reach."""
        many = block(self.box, self.axes, seed=2, count=20 * POSES)
        least = np.min(np.stack(list(self.machine.reach(many).values())), axis=0)
        found: Poses = many[np.nan_to_num(least, nan=-1.0) > WELL_INSIDE][:POSES]
        expect(
            len(found),
            self.machine,
            "no pose was found whose margins are all above a hundredth",
            "make margins relative to a length of the machine",
        )
        found.flags.writeable = False
        return found

    def jacobian(self) -> None:
        """J⁻¹ is the derivative of the joints."""
        poses, m, d = self.inside(), len(self.machine.joint_units), self.axes
        given = self.machine.inverse_jacobian(poses)
        expect(
            given.shape == (len(poses), m, d),
            self.machine,
            f"inverse_jacobian gave the shape {given.shape}",
            f"({len(poses)}, {m}, {d}) is owed",
        )
        h = 1e-6 * float(np.max(self.box.size))
        for k in range(d):
            step = h * np.eye(d)[k]
            ahead, behind = (self.machine.inverse_kinematics(poses + sign * step)[0] for sign in (1, -1))
            by_differences = (ahead - behind) / (2 * h)
            near = DIFFERENCE * np.abs(given).max()
            wrong = ~np.isclose(given[:, :, k], by_differences, rtol=DIFFERENCE, atol=near)
            if wrong.any():
                n, i = np.argwhere(wrong)[0]
                found = f"{given[n, i, k]:.6g}, by differences {by_differences[n, i]:.6g}"
                said = (
                    f"inverse_jacobian for joint {i + 1} and {self.machine.axes[k]} {at(poses[n])} is {found}"
                )
                expect(False, self.machine, said, "J⁻¹ = ∂ρ/∂p, row i for joint i")

    def lengths(self) -> None:
        """A machine twice as large, at poses twice as far, has joints twice as long, and angles the same."""
        larger = retold(self.machine, Units(length=LARGER))
        if larger is None or set(self.machine.axes) - {"x", "y", "z"}:
            return
        joints, reachable = self.machine.inverse_kinematics(self.poses)
        others, also = larger.inverse_kinematics(LARGER * self.poses)
        least = np.min(np.stack(list(self.machine.reach(self.poses).values())), axis=0)
        wrong = (reachable != also) & (np.abs(np.nan_to_num(least)) > CLOSE)
        expect(
            not wrong.any(),
            self.machine,
            f"twice as large, it reaches otherwise {where(self.poses, wrong)}",
            "lengths have to be fields of lengths, with no number in metres in the code",
        )
        factors = np.array([LARGER if unit == "m" else 1.0 for unit in self.machine.joint_units])
        both = reachable & also
        wrong = both & ~np.isclose(others, factors * joints, rtol=1e-7, atol=1e-9).all(axis=1)
        expect(
            not wrong.any(),
            self.machine,
            f"twice as large, its joints are not {where(self.poses, wrong)}",
            "joints are in m or rad, as joint_units says",
        )

    def enclosure(self) -> None:
        """Margins at poses of a box lie within what is told of the whole box."""
        for several in boxes(self.box, self.axes):
            try:
                enclosed = self.machine.reach_enclosure(several)
            except NoEnclosure:
                continue  # Allowed: then nothing is proved of these.
            for k in range(INSIDE):
                poses = within(several, k)
                for name, margin in self.machine.reach(poses).items():
                    least, greatest = told_at(enclosed[name], several, poses)
                    wrong = (margin < least) | (margin > greatest)
                    expect(
                        not wrong.any(),
                        self.machine,
                        f"reach '{name}' leaves its enclosure {where(poses, wrong)}",
                        "give nothing that is not certain",
                    )

    def indices(self) -> None:
        """Each is a number with a unit that is known beforehand."""
        machine = self.machine
        joints, reachable = machine.inverse_kinematics(self.poses)
        ranges = np.stack([joints[reachable].min(axis=0), joints[reachable].max(axis=0)], axis=1)
        given = machine.indices(ranges)
        unknown = set(given) - set(machine.index_units)
        expect(
            not unknown,
            machine,
            f"indices gives {', '.join(sorted(unknown))}, of which index_units knows no unit",
            "name each with its unit there",
        )
        for name, value in given.items():
            expect(
                isinstance(value, float) and np.isfinite(value),
                machine,
                f"index {name} is {value!r}",
                "give a float",
            )
        for name, unit in machine.index_units.items():
            is_unit(machine, unit, f"index {name}")
        nothing = machine.indices(np.full_like(ranges, np.nan))
        expect(
            set(nothing) == set(given),
            machine,
            "indices names others where joints are NaN",
            "let them be NaN",
        )

    def drawing(self) -> None:
        """The skeleton has its shapes, and can be drawn."""
        poses = self.inside()[:5]
        n = len(poses)
        drawn = self.machine.skeleton(poses)
        s = len(drawn.names)
        expect(
            np.shape(drawn.segments) == (n, s, 2, 3) and np.shape(drawn.radii) == (s,),
            self.machine,
            f"skeleton has segments {np.shape(drawn.segments)}, radii {np.shape(drawn.radii)} and {s} names",
            "segments (n, s, 2, 3), radii (s,), names (s,)",
        )
        expect(
            np.isfinite(drawn.segments).all(),
            self.machine,
            "skeleton is not finite within the reach",
            "draw all",
        )
        for name, radius in zip(drawn.names, drawn.radii, strict=True):
            expect(
                radius >= 0 and np.isfinite(radius),
                self.machine,
                f"skeleton's '{name}' has the radius {radius}",
                "give a length in m",
            )

    def missing(self) -> None:
        """What it names are fields."""
        known = {".".join(key.path) for key in keys_of(type(self.machine)).every()}
        asked = (
            "compliance",
            "joint_inertia",
            "actuator_forces",
            "actuator_speeds",
            *self.machine.index_units,
        )
        for what in asked:
            for field in self.machine.missing(what):
                expect(
                    field in known or field.split(".")[0] in type(self.machine).model_fields,
                    self.machine,
                    f"missing('{what}') names '{field}', which is no field",
                    "name fields as a spec writes them",
                )

    def compliance(self) -> None:
        """Symmetric, and no load makes it rise; inf as a whole where the machine is loose."""
        poses = self.inside()
        given = self.machine.compliance(poses)
        expect(
            given.shape == (len(poses), 6, 6),
            self.machine,
            f"compliance has the shape {given.shape}",
            "(n, 6, 6)",
        )
        known = np.asarray(np.isfinite(given).all(axis=(1, 2)))
        wrong = np.asarray(~known & ~np.isposinf(given).all(axis=(1, 2)))
        expect(
            not wrong.any(),
            self.machine,
            f"compliance is neither finite nor inf {where(poses, wrong)}, well within the reach",
            "all entries are inf where the machine is loose, and NaN is for poses out of reach",
        )
        size = np.abs(np.where(known[:, None, None], given, 0.0)).max(axis=(1, 2), keepdims=True)
        skew = known & (np.abs(given - np.swapaxes(given, 1, 2)) > CLOSE * size).any(axis=(1, 2))
        expect(
            not skew.any(), self.machine, f"compliance is not symmetric {where(poses, skew)}", "it always is"
        )
        least = np.linalg.eigvalsh(np.where(known[:, None, None], given, np.eye(6)))[:, 0]
        wrong = known & (least < -CLOSE * size[:, 0, 0])
        expect(
            not wrong.any(),
            self.machine,
            f"compliance gives way against a load {where(poses, wrong)}",
            "check signs",
        )

    def inertia(self) -> None:
        """Finite, symmetric and positive definite."""
        poses = self.inside()
        given = self.machine.joint_inertia(poses)
        unknown = np.asarray(~np.isfinite(given).all(axis=(1, 2)))
        expect(
            not unknown.any(),
            self.machine,
            f"joint_inertia is not finite {where(poses, unknown)}, well within the reach",
            "let reach have a margin for the singularity there",
        )
        least = np.linalg.eigvalsh((given + np.swapaxes(given, 1, 2)) / 2)[:, 0]
        size = np.abs(given).max(axis=(1, 2))
        wrong = (np.abs(given - np.swapaxes(given, 1, 2)).max(axis=(1, 2)) > CLOSE * size) | ~(least > 0)
        expect(
            not wrong.any(),
            self.machine,
            f"joint_inertia is not symmetric and positive definite {where(poses, wrong)}",
            "masses are positive",
        )

    def rest_load(self) -> None:
        """The force at the tool F = J⁻ᵀ τ is the slope of an energy: its own slopes are symmetric."""
        poses, size = self.inside(), float(np.max(self.box.size))
        h, at_tool = inertia.STEP * size, self.load_at_tool(poses)
        unknown = np.asarray(~np.isfinite(at_tool).all(axis=1))
        expect(
            not unknown.any(),
            self.machine,
            f"rest_load is not finite {where(poses, unknown)}, well within the reach",
            "let reach have a margin for the singularity there",
        )
        ahead, behind = (
            np.stack([self.load_at_tool(poses + sign * step) for step in h * np.eye(self.axes)], axis=2)
            for sign in (1, -1)
        )
        slopes = (ahead - behind) / (2 * h)
        near = DIFFERENCE * (np.abs(slopes).max(axis=(1, 2)) + np.abs(at_tool).max(axis=1) / size)
        skew = np.abs(slopes - np.swapaxes(slopes, 1, 2)) > near[:, None, None]
        if skew.any():
            n, k, j = np.argwhere(skew)[0]
            along, other = self.machine.axes[k], self.machine.axes[j]
            said = (
                f"rest_load has no energy {at(poses[n])}: its force at the tool along {along} changes with"
                f" {other} by {slopes[n, k, j]:.6g}, that along {other} with {along} by {slopes[n, j, k]:.6g}"
            )
            expect(False, self.machine, said, "weights do no work around a loop: check signs, and τ = Jᵀ F")

    def load_at_tool(self, poses: Poses) -> Array:
        """J⁻ᵀ τ (n, d)."""
        inverse, load = self.machine.inverse_jacobian(poses), self.machine.rest_load(poses)
        return np.asarray((load[:, None, :] @ inverse)[:, 0])

    def velocity_forces(self) -> None:
        """They follow from how the inertia changes with the pose."""
        poses, machine = self.inside(), self.machine
        given = machine.velocity_forces(poses)
        h = inertia.STEP * float(np.max(self.box.size))
        coarse, by_differences = (inertia.velocity_forces(machine, poses, step) for step in (h, h / 2))
        # Differences are as good as two half-widths agree.
        near = DIFFERENCE * np.abs(by_differences) + 10 * np.abs(coarse - by_differences)
        wrong = ~(np.abs(given - by_differences) <= near.max(axis=(1, 2, 3), keepdims=True))
        if wrong.any():
            n, i, j, k = np.argwhere(wrong)[0]
            said = (
                f"velocity_forces of joint {i + 1} for {machine.axes[j]} and {machine.axes[k]}"
                f" {at(poses[n])} is {given[n, i, j, k]:.6g}, by differences of the inertia"
                f" {by_differences[n, i, j, k]:.6g}"
            )
            expect(False, machine, said, "Q_i is symmetric, and the force of joint i is ṗᵀ Q_i ṗ")

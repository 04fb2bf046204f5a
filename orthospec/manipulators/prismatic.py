"""`PrismaticManipulator`: what all machines with prismatic legs share; a machine adds its geometry.

The formulas stand in `orthospec.mechanics.prismatic` and its neighbours `prismatic_elastic` and
`prismatic_inertia`.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from functools import cached_property
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, Self

from pydantic import BeforeValidator, ConfigDict, Field, model_validator

from orthospec.arrays import np
from orthospec.described import Described
from orthospec.manipulators.base import ActuatorLimits, Manipulator, Skeleton, remembering
from orthospec.manipulators.parts import Actuators, Body, FeetOrRigid, Legs
from orthospec.manipulators.stock import PositiveLength
from orthospec.mechanics import prismatic, prismatic_elastic, prismatic_inertia
from orthospec.mechanics.inertia import inverse
from orthospec.quantities import Acceleration, Length

if TYPE_CHECKING:
    from orthospec.arrays import Array, Flags, Joints, Matrices, Poses

Triple = tuple[Length, Length, Length]
EachSlider = Annotated[
    Triple,
    BeforeValidator(
        lambda given: given if isinstance(given, list | tuple) else [given] * 3,
        json_schema_input_type=Length | Triple,
    ),
]

ROUNDING = 1e-12
"""A pose counts as reachable down to this margin: designs end exactly on their limits."""


class JointLimits(Described):
    """How far the sliders may go."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    min: EachSlider | None = None
    """Least slider coordinate, one for all or one for each [m]."""
    max: EachSlider | None = None
    """Greatest slider coordinate, one for all or one for each [m]."""

    @model_validator(mode="after")
    def _has_room(self) -> Self:
        if self.min is not None and self.max is not None:
            for least, greatest in zip(self.min, self.max, strict=True):
                if least >= greatest:
                    raise ValueError(f"min {least:g} m is not below max {greatest:g} m")
        return self


class PrismaticManipulator(Manipulator):
    """Three slides, three legs, and a platform that only translates; a subclass gives the geometry.

    What is not given has no mass. Nothing is taken for rigid unless the spec says so: without legs' sections
    and actuators' stiffness there is no compliance.
    """

    leg_lengths: Annotated[
        tuple[PositiveLength, PositiveLength, PositiveLength], Field(examples=[["400 mm"] * 3])
    ]
    """Lengths of the legs of the three slides [m]."""
    joint_limits: JointLimits = JointLimits()
    """How far the sliders may go [m]; no limit where none is given."""
    branch: tuple[Literal[1, -1], Literal[1, -1], Literal[1, -1]] = (1, 1, 1)
    """On which side of the tool each slider stands: 1 is the side to which its slide points."""
    legs: Legs | None = None
    """What the legs are made of."""
    feet: FeetOrRigid = None
    """The bars from the sliders to the legs: rigid, or with a length, section and material."""
    actuators: Actuators = Actuators()
    """The drive of each slider."""
    platform: Body | None = None
    """The platform."""
    tool: Body | None = None
    """The tool and what carries it."""
    payload: Body | None = None
    """What the machine moves beside its own parts."""
    gravity: tuple[Acceleration, Acceleration, Acceleration] = (0.0, 0.0, 0.0)
    """Acceleration of gravity along x, y and z [m/s^2]."""

    toleranced: ClassVar[Mapping[str, str]] = {"leg_lengths": "m"}
    index_units: ClassVar[Mapping[str, str]] = {
        "leg_length_total": "m",
        "stroke": "m",
        "footprint": "m^2",
        "total_mass": "kg",
        "moving_mass": "kg",
        "foot_mass": "kg",
        "leg_1_mass": "kg",
        "leg_2_mass": "kg",
        "leg_3_mass": "kg",
    }

    @property
    @abstractmethod
    def geometry(self) -> prismatic.PrismaticLegs:
        """Slides and legs of this design."""

    @property
    def _lengths(self) -> Array:
        """L_i (3, 1), or (3, n) where each pose has legs of its own."""
        return np.stack(self.leg_lengths).reshape(3, -1)

    # Kinematics.

    @remembering
    def closed_legs(self, poses: Poses) -> prismatic.Legs:
        """The legs over a block of poses, their loops closed."""
        return prismatic.close(self.geometry, poses)

    def inverse_kinematics(self, poses: Poses) -> tuple[Joints, Flags]:
        """Slider coordinates ρ (n, 3) [m], NaN where a leg is too short, and reachability (n,)."""
        reachable = np.ones(len(poses), dtype=bool)
        for margin in self.reach(poses).values():
            reachable &= margin >= -ROUNDING
        return self.closed_legs(poses).rho, reachable

    @remembering
    def reach(self, poses: Poses) -> Mapping[str, Array]:
        """Margins: each leg closes its loop, no parallel singularity is passed, the joint limits hold."""
        machine, legs = self.geometry, self.closed_legs(poses)
        margins = prismatic.margins(machine, legs)
        for side, sign in (("min", -1.0), ("max", 1.0)):
            for i, limit in enumerate(getattr(self.joint_limits, side) or ()):
                key = f"joint_limits.{i}.{'at_least' if side == 'min' else 'at_most'}"
                margins[key] = sign * (limit - legs.rho[:, i]) / (abs(limit) or self.leg_lengths[i])
        return margins

    def inverse_jacobian(self, poses: Poses) -> Matrices:
        """J⁻¹ (n, 3, 3), dimensionless: row i is s_iᵀ / (s_i·e_i)."""
        return prismatic.inverse_jacobian(self.closed_legs(poses))

    @remembering
    def _jacobian(self, poses: Poses) -> Matrices:
        return inverse(self.inverse_jacobian(poses))

    # Elasticity.

    def compliance(self, poses: Poses) -> Array:
        """C (n, 6, 6) at the tool, by the virtual joint method."""
        return prismatic_elastic.compliance(self.geometry, self.springs, self.closed_legs(poses))

    @cached_property
    def springs(self) -> prismatic_elastic.Springs:
        """The elasticity of the chains; `missing` says what it lacks."""
        assert self.legs is not None
        assert self.actuators.stiffness is not None
        bars: Any = [self.legs.bar_compliance(length) for length in self.leg_lengths]
        feet = np.zeros((3, 6, 6))
        if self.feet is not None:
            foot = self.feet.bar_compliance()
            assert foot is not None
            feet = prismatic_elastic.feet_in_space(self.geometry, foot)
        return prismatic_elastic.Springs(
            actuator=1.0 / self.actuators.stiffness,
            feet=feet,
            bars=np.stack(bars),
            spacing=self.legs.spacing if self.legs.kind == "PRPaR" else None,
        )

    # Dynamics.

    def joint_inertia(self, poses: Poses) -> Matrices:
        """D (n, 3, 3) [kg]: sliders and feet, legs as uniform bars, platform, tool and payload."""
        return prismatic_inertia.joint_inertia(self.geometry, self.masses, self._jacobian(poses))

    def rest_load(self, poses: Poses) -> Joints:
        """The slider forces (n, 3) [N] that hold the machine against gravity."""
        if not any(self.gravity):
            return np.zeros((len(poses), 3))
        return prismatic_inertia.rest_load(
            self.geometry, self.masses, self._jacobian(poses), np.array(self.gravity)
        )

    def velocity_forces(self, poses: Poses) -> Array:
        """Q (n, 3, 3, 3) [kg/m]: slider i is pushed with ṗᵀ Q_i ṗ at a constant tool velocity ṗ."""
        return prismatic_inertia.velocity_forces(
            self.geometry, self.masses, self.closed_legs(poses), self._jacobian(poses)
        )

    def actuator_limits(self) -> ActuatorLimits:
        """Force, speed and friction of the drives, the same for all three."""
        drive = self.actuators
        given = (drive.force, drive.speed, drive.friction)
        forces, speeds, friction = (
            np.full(3, default if value is None else value)
            for value, default in zip(given, (np.inf, np.inf, 0.0), strict=True)
        )
        return ActuatorLimits(forces, speeds, friction)

    @cached_property
    def masses(self) -> prismatic_inertia.Masses:
        """Of what moves [kg]; what is not given has none."""
        return prismatic_inertia.Masses(
            sliders=self._slider_mass,
            legs=np.stack(self._leg_masses).reshape(3, -1).T,
            platform=self._platform_mass,
        )

    @property
    def _slider_mass(self) -> float:
        return (self.actuators.mass or 0.0) + self._foot_mass

    @property
    def _platform_mass(self) -> float:
        return sum(body.mass for body in (self.platform, self.tool, self.payload) if body)

    @property
    def _foot_mass(self) -> float:
        return (self.feet.bar_mass() or 0.0) if self.feet is not None else 0.0

    @property
    def _leg_masses(self) -> tuple[float, ...]:
        if self.legs is None:
            return (0.0, 0.0, 0.0)
        bars = 2 if self.legs.kind == "PRPaR" else 1
        masses = [self.legs.bar_mass(length) for length in self.leg_lengths]
        return tuple(0.0 if mass is None else bars * mass for mass in masses)

    # What can be had, and what it comes to.

    def missing(self, what: str) -> tuple[str, ...]:
        """The keys to give before ``what`` can be had: stiffness, masses, or what the drives can do."""
        if what == "compliance":
            return self._missing_springs()
        if what in {"joint_inertia", "total_mass", "moving_mass"}:
            return self._missing_masses()
        if what.startswith("leg_") and what.endswith("_mass"):
            return ("legs",) if self.legs is None else self.legs.missing("mass")
        if what == "foot_mass":
            return ("feet",) if self.feet is None else self.feet.missing("mass")
        given = {"actuator_forces": self.actuators.force, "actuator_speeds": self.actuators.speed}
        if what in given and given[what] is None:
            return ("actuators." + what.removeprefix("actuator_").removesuffix("s"),)
        return ()

    def _missing_springs(self) -> tuple[str, ...]:
        missing = ("legs",) if self.legs is None else self.legs.missing("compliance")
        if self.feet is not None:
            missing += self.feet.missing("compliance")
        return missing if self.actuators.stiffness is not None else (*missing, "actuators.stiffness")

    def _missing_masses(self) -> tuple[str, ...]:
        parts = [part for part in (self.legs, self.feet) if part is not None]
        missing = tuple(key for part in parts for key in part.missing("mass"))
        moving = (self._platform_mass, self._slider_mass, *self._leg_masses)
        if not missing and not any(moving):
            return ("platform.mass", "actuators.mass")
        return missing

    def indices(self, joint_ranges: Array) -> Mapping[str, float]:
        """Lengths, room and masses; those whose parts are not known are left out.

        ``leg_length_total`` ΣL_i; ``stroke``, the longest slider travel; ``footprint``, the area of the
        smallest rectangle along x and y that holds all sliders over the cuboid; ``total_mass`` of sliders,
        feet, legs, platform and tool; ``moving_mass``, that and the payload; ``foot_mass`` of one foot;
        ``leg_1_mass`` ... of each leg with all of its bars.
        """
        machine = self.geometry
        ends = machine.bases[:, None, :, 0] + joint_ranges[:, :, None] * machine.axes[:, None, :]
        room = np.ptp(ends.reshape(-1, 3), axis=0)
        masses = self.masses
        moving = 3 * masses.sliders + float(masses.legs.sum()) + masses.platform
        found = {
            "leg_length_total": float(sum(self.leg_lengths)),
            "stroke": float(np.max(joint_ranges[:, 1] - joint_ranges[:, 0])),
            "footprint": float(room[0] * room[1]),
            "total_mass": moving - (self.payload.mass if self.payload else 0.0),
            "moving_mass": moving,
            "foot_mass": self._foot_mass,
            **{f"leg_{i + 1}_mass": float(mass) for i, mass in enumerate(masses.legs[0])},
        }
        return {name: value for name, value in found.items() if not self.missing(name)}

    def skeleton(self, poses: Poses) -> Skeleton:
        """Slides from their base points to the sliders, the legs' bars, and the platform's arms."""
        machine, rho = self.geometry, self.inverse_kinematics(poses)[0]
        bases, joints = machine.bases[:, :, 0], machine.joints[:, :, 0]
        slider = bases + rho[:, :, None] * machine.axes
        tool = np.broadcast_to(poses[:, None, :], slider.shape)
        joint = tool + joints
        thickness = 0.02 * float(np.mean(machine.lengths))
        spacing = self.legs.spacing if self.legs is not None and self.legs.kind == "PRPaR" else None
        lines = [("slide", np.broadcast_to(bases, slider.shape), slider, thickness)]
        if spacing is None:
            lines.append(("leg", slider, joint, thickness / 2))
        else:
            half = spacing / 2 * machine.revolutes
            lines += [
                (f"bar_{side}", slider + sign * half, joint + sign * half, thickness / 2)
                for side, sign in (("left", 1.0), ("right", -1.0))
            ]
            lines += [
                (f"link_{end}", at - half, at + half, thickness / 2)
                for end, at in (("outer", slider), ("inner", joint))
            ]
        if joints.any():
            lines.append(("arm", joint, tool, thickness / 2))
        return Skeleton(
            segments=np.concatenate([np.stack([a, b], axis=2) for _, a, b, _ in lines], axis=1),
            radii=np.repeat([radius for *_, radius in lines], 3),
            names=tuple(f"{name}_{i}" for name, *_ in lines for i in (1, 2, 3)),
        )

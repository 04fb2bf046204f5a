"""The Orthoglide: three orthogonal slides, three legs, a tool that only translates.

Chablat and Wenger, *Architecture optimization of a 3-DOF parallel mechanism for machining applications, the
Orthoglide* (IEEE Trans. Robotics and Automation 19(3), 2003). At the origin all legs lie along their slides
and J = I: the isotropic pose.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import TYPE_CHECKING, Annotated, ClassVar, Literal, Self

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, model_validator

from orthospec.arrays import np
from orthospec.manipulators.base import Manipulator, Skeleton
from orthospec.mechanics import prismatic
from orthospec.quantities import Length

if TYPE_CHECKING:
    from orthospec.arrays import Array, Flags, Joints, Matrices, Poses

PositiveLength = Annotated[Length, Field(gt=0)]
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


class JointLimits(BaseModel):
    """How far the sliders may go."""

    model_config = ConfigDict(frozen=True, extra="forbid", use_attribute_docstrings=True)

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


class Orthoglide(Manipulator):
    """Slider i moves along coordinate axis i: ρ_i = p_i + β_i sqrt(L_i² − Σ_{k≠i} p_k²).

    Row i of J⁻¹ is s_iᵀ / s_ii with s_i = ρ_i e_i − p: the bracket of eq. 14 of Pashkevich, Chablat and
    Wenger (2009). The machine is of Chablat and Wenger (2003).
    """

    leg_lengths: tuple[PositiveLength, PositiveLength, PositiveLength]
    """Lengths of the legs of the x, y and z slides [m]."""
    joint_limits: JointLimits = JointLimits()
    """How far the sliders may go [m]; no limit where none is given."""
    branch: tuple[Literal[1, -1], Literal[1, -1], Literal[1, -1]] = (1, 1, 1)
    """On which side of the tool each slider stands: 1 is the positive one."""

    index_units: ClassVar[Mapping[str, str]] = {"leg_length_total": "m", "stroke": "m", "footprint": "m^2"}

    @cached_property
    def _machine(self) -> prismatic.PrismaticLegs:
        return prismatic.PrismaticLegs(
            axes=np.eye(3),
            bases=np.zeros((3, 3)),
            joints=np.zeros((3, 3)),
            lengths=np.array(self.leg_lengths),
            branches=np.array(self.branch, dtype=float),
        )

    def inverse_kinematics(self, poses: Poses) -> tuple[Joints, Flags]:
        """Slider coordinates ρ (n, 3) [m], NaN where a leg is too short, and reachability (n,)."""
        rho = prismatic.sliders(self._machine, poses)
        reachable = np.ones(len(poses), dtype=bool)
        for margin in self._margins(poses, rho).values():
            reachable &= margin >= -ROUNDING
        return rho, reachable

    def reach(self, poses: Poses) -> Mapping[str, Array]:
        """Margins: each leg closes its loop, no parallel singularity is passed, the joint limits hold."""
        return self._margins(poses, self.inverse_kinematics(poses)[0])

    def _margins(self, poses: Poses, rho: Joints) -> dict[str, Array]:
        closing = prismatic.leg_margins(self._machine, poses)
        margins = {f"leg_{i + 1}": closing[:, i] for i in range(3)}
        rows = prismatic.unit_legs(self._machine, poses, rho)
        margins["singularity"] = prismatic.volume_margin(rows, sign=1.0)
        margins["assembly"] = prismatic.pairs_margin(rows, self._machine.axes)
        for side, sign in (("min", -1.0), ("max", 1.0)):
            for i, limit in enumerate(getattr(self.joint_limits, side) or ()):
                key = f"joint_limits.{i}.{'at_least' if side == 'min' else 'at_most'}"
                margins[key] = sign * (limit - rho[:, i]) / (abs(limit) or self.leg_lengths[i])
        return margins

    def inverse_jacobian(self, poses: Poses) -> Matrices:
        """J⁻¹ (n, 3, 3), dimensionless: the bracket of eq. 14."""
        return prismatic.inverse_jacobian(self._machine, poses, self.inverse_kinematics(poses)[0])

    def indices(self, joint_ranges: Array) -> Mapping[str, float]:
        """``leg_length_total`` ΣL_i, ``stroke`` (the longest slider travel), and ``footprint``.

        The footprint is the area of the smallest rectangle along x and y that holds all sliders over the
        cuboid; the z slider stands at x = y = 0.
        """
        low, high = np.minimum(joint_ranges[:, 0], 0), np.maximum(joint_ranges[:, 1], 0)
        return {
            "leg_length_total": float(sum(self.leg_lengths)),
            "stroke": float(np.max(joint_ranges[:, 1] - joint_ranges[:, 0])),
            "footprint": float(np.prod((high - low)[:2])),
        }

    def skeleton(self, poses: Poses) -> Skeleton:
        """Three slides from the origin to their sliders, three legs from the sliders to the tool."""
        machine = self._machine
        rho = self.inverse_kinematics(poses)[0]
        slider = rho[:, :, None] * machine.axes
        origin, tool = np.zeros_like(slider), np.broadcast_to(poses[:, None, :], slider.shape)
        slides, rods = np.stack([origin, slider], axis=2), np.stack([slider, tool], axis=2)
        thickness = 0.02 * float(np.mean(machine.lengths))
        return Skeleton(
            segments=np.concatenate([slides, rods], axis=1),
            radii=np.repeat([thickness, thickness / 2], 3),
            names=("slide_1", "slide_2", "slide_3", "leg_1", "leg_2", "leg_3"),
        )

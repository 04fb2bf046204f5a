"""The linear Delta: three slides around a vertical axis, three legs, a platform that only translates.

Clavel's Delta (1988) with linear drives, of which UraneSX, Triglide and most Delta printers are forms: see
Merlet, *Parallel Robots* (2006), chapter 2. With ``rail_tilt`` 0 the slides are vertical and every height
is alike; with 90 deg they form a horizontal star.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cached_property
from typing import TYPE_CHECKING, Annotated, ClassVar, Self

from pydantic import Field, model_validator

from orthospec.arrays import np
from orthospec.manipulators.prismatic import PrismaticManipulator
from orthospec.mechanics.prismatic import PrismaticLegs
from orthospec.quantities import Angle, Length

if TYPE_CHECKING:
    from orthospec.arrays import Array

AZIMUTHS = (0.0, 2 * math.pi / 3, 4 * math.pi / 3)
"""Directions of the three slides around z, from the x axis [rad]."""


class LinearDelta(PrismaticManipulator):
    """Slide i passes the base circle at azimuth α_i = 0, 120, 240 deg; the tool is the platform's centre.

    With r_i = (cos α_i, sin α_i, 0) the slider stands at R r_i + ρ_i e_i, e_i = sin τ r_i + cos τ z, and
    the leg's other end at p + r r_i: R ``base_radius``, r ``platform_radius``, τ ``rail_tilt``. Row i of J⁻¹
    is s_iᵀ / (s_i·e_i). The legs' first revolute axes, or short links, are the tangents z × r_i.
    """

    toleranced: ClassVar[Mapping[str, str]] = dict.fromkeys(
        ("leg_lengths", "base_radius", "platform_radius"), "m"
    )

    base_radius: Annotated[Length, Field(ge=0, examples=["250 mm"])]
    """Radius of the circle on which the slides have ρ = 0 [m]."""
    platform_radius: Annotated[Length, Field(ge=0, examples=["50 mm"])]
    """Radius of the circle of the legs' ends on the platform [m]."""
    rail_tilt: Annotated[Angle, Field(gt=-math.pi / 2, le=math.pi / 2 + 1e-12)] = 0.0
    """Angle of the slides with the vertical; above 0 they lean outwards at the top [rad]."""

    @model_validator(mode="after")
    def _can_move(self) -> Self:
        if self.legs is not None and self.legs.offset:
            raise ValueError("legs.offset has no meaning here: platform_radius places the legs' ends")
        if self.rail_tilt == 0 and self.base_radius == self.platform_radius:
            raise ValueError(
                "base_radius and platform_radius are equal: with vertical slides the legs are parallel, and"
                " the machine is singular at every pose"
            )
        return self

    @cached_property
    def geometry(self) -> PrismaticLegs:
        """The three slides, a third of a turn apart."""
        radial = np.array([[math.cos(alpha), math.sin(alpha), 0.0] for alpha in AZIMUTHS])
        up = np.array([0.0, 0.0, 1.0])
        branches = np.array(self.branch, dtype=float)
        return PrismaticLegs(
            axes=math.sin(self.rail_tilt) * radial + math.cos(self.rail_tilt) * up,
            bases=radial[:, :, None] * self.base_radius,
            joints=radial[:, :, None] * self.platform_radius,
            lengths=self._lengths,
            branches=branches,
            revolutes=np.cross(up, radial),
            home=(self._lean[:, None] * radial + up) / math.sqrt(2),
        )

    @property
    def _lean(self) -> Array:
        """Whether the legs, as β_i s_i points, lean outwards (1) or inwards (−1) where the machine works.

        On flat rails they lean as their slides do. On steep ones that decides itself where a slider, a leg's
        length along its slide, is farther out than the platform's joint or not: in between, the machine is
        singular. NaN where several machines are asked about at once that differ in this.
        """
        branches = np.array(self.branch, dtype=float)
        if abs(self.rail_tilt) > math.pi / 4:
            return np.full(3, math.copysign(1.0, self.rail_tilt))
        travel = branches[:, None] * self._lengths
        outside = self.base_radius + travel * math.sin(self.rail_tilt) >= self.platform_radius
        mixed_or_not = np.where(np.any(outside, axis=1), np.nan, -branches)
        return np.where(np.all(outside, axis=1), branches, mixed_or_not)

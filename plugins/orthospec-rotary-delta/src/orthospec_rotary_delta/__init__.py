"""``rotary_delta``: Clavel's Delta, three arms on rotary drives, parallelograms, a tool that only translates.

Shoulder i stands at R r_i on a horizontal circle, r_i = (cos α_i, sin α_i, 0), α_i = 0, 120, 240 deg. Its
arm, of length a, turns by θ_i from the horizontal downwards in the plane of r_i and z: the elbow is

    k_i = (R + a cos θ_i) r_i − a sin θ_i z.

A parallelogram of length l joins it to the platform at p + r r_i. With s_i = p + r r_i − k_i the loop
closes where |s_i| = l, that is with x, y, z the platform's joint as seen from the shoulder, x along r_i,

    A cos θ + B sin θ = C,      A = 2 a x,  B = −2 a z,  C = x² + y² + z² + a² − l²,

of which the root with the elbow outwards is taken, cos θ = (A C + B W) / P, sin θ = (B C − A W) / P, with
P = A² + B² and W = sqrt(P − C²) (R. Clavel, *Conception d'un robot parallèle rapide à 4 degrés de liberté*,
thesis, EPFL, 1991). Differentiating |s_i|² = l² gives row i of J⁻¹,

    s_iᵀ / (s_i · t_i),      t_i = ∂k_i/∂θ_i = −a sin θ_i r_i − a cos θ_i z.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Self

import numpy as np
from pydantic import Field, model_validator

from orthospec.manipulators import Manipulator, Skeleton
from orthospec.quantities import Angle, Length

if TYPE_CHECKING:
    from orthospec.arrays import Array, Poses

__all__ = ["RotaryDelta"]

AZIMUTHS = tuple(2 * math.pi * k / 3 for k in range(3))
"""Directions of the three arms around z, from the x axis [rad]."""
CLEARANCE = 1e-8
"""What a margin of the closing loops keeps from its end: at the end the arm cannot follow the tool."""
ROUNDING = 1e-12
"""A pose counts as reachable down to this margin: designs end exactly on their limits."""


class RotaryDelta(Manipulator):
    """Clavel's Delta: cos θ = (A C + B W) / P with A = 2 a x, B = −2 a z, C = x² + y² + z² + a² − l².

    x, y, z is the platform's joint from the shoulder, P = A² + B², W = sqrt(P − C²). The tool works below
    its base, z < 0. Clavel (1991).
    """

    base_radius: Annotated[Length, Field(ge=0, examples=["125 mm"])]
    """Radius of the circle of the shoulders [m]."""
    platform_radius: Annotated[Length, Field(ge=0, examples=["50 mm"])]
    """Radius of the circle of the joints on the platform [m]."""
    arm: Annotated[Length, Field(gt=0, examples=["200 mm"])]
    """Length of the driven arms [m]."""
    forearm: Annotated[Length, Field(gt=0, examples=["450 mm"])]
    """Length of the parallelograms [m]."""
    lowest: Angle = -math.pi / 2
    """Least angle of an arm, from the horizontal downwards [rad]."""
    highest: Angle = math.pi / 2
    """Greatest angle of an arm [rad], by half a turn at most above the least one."""

    joint_units: ClassVar[tuple[str, ...]] = ("rad", "rad", "rad")
    index_units: ClassVar[Mapping[str, str]] = {"length_total": "m", "swing": "rad", "footprint": "m^2"}

    @model_validator(mode="after")
    def _turns_by_half_a_turn_at_most(self) -> Self:
        if not 0 < self.highest - self.lowest <= math.pi * (1 + ROUNDING):
            raise ValueError("highest must be above lowest, by half a turn (180 deg) at most")
        return self

    def inverse_kinematics(self, poses: Poses) -> tuple[Array, Any]:
        """Angles θ (n, 3) [rad], NaN where a loop cannot close, and reachability (n,)."""
        _, cosine, sine, _ = self._closed(poses)
        reachable = np.ones(len(poses), dtype=bool)
        for margin in self.reach(poses).values():
            reachable &= margin >= -ROUNDING
        return np.arctan2(sine, cosine).T, reachable

    def reach(self, poses: Poses) -> Mapping[str, Array]:
        """Each loop closes, the angles are within their limits, and the forearms span a volume."""
        room, cosine, sine, s = self._closed(poses)
        margins = {f"loop_{i + 1}": room[i] - CLEARANCE for i in range(3)}
        for side, sign, end in (("at_least", 1.0, self.lowest), ("at_most", -1.0, self.highest)):
            for i in range(3):
                # The sine of the way to the limit: an angle itself is not smooth where it turns over. Limits
                # are half a turn apart at most: one of both is below 0 just where the arm is beyond.
                away = sign * (sine[i] * math.cos(end) - cosine[i] * math.sin(end))
                margins[f"angles.{i}.{side}"] = away / (abs(end) or 1.0)
        u = s / self.forearm
        volume = (
            u[0, 0] * (u[1, 1] * u[2, 2] - u[1, 2] * u[2, 1])
            + u[0, 1] * (u[1, 2] * u[2, 0] - u[1, 0] * u[2, 2])
            + u[0, 2] * (u[1, 0] * u[2, 1] - u[1, 1] * u[2, 0])
        )
        margins["singularity"] = -volume if self.base_radius + self.arm > self.platform_radius else volume
        margins["below"] = -poses[:, 2] / self.forearm
        return margins

    def inverse_jacobian(self, poses: Poses) -> Array:
        """J⁻¹ (n, 3, 3) [rad/m]: row i is s_iᵀ / (s_i·t_i)."""
        _, cosine, sine, s = self._closed(poses)
        rows = []
        for i, alpha in enumerate(AZIMUTHS):
            outward = math.cos(alpha) * s[i, 0] + math.sin(alpha) * s[i, 1]
            with np.errstate(divide="ignore", invalid="ignore"):
                rows.append(s[i] / -(self.arm * (sine[i] * outward + cosine[i] * s[i, 2])))
        return np.moveaxis(np.stack(rows), 2, 0)

    def indices(self, joint_ranges: Array) -> Mapping[str, float]:
        """All lengths of arms and forearms; the largest swing of an arm; the circle that the base needs."""
        return {
            "length_total": 3 * (self.arm + self.forearm),
            "swing": float(np.max(joint_ranges[:, 1] - joint_ranges[:, 0])),
            "footprint": math.pi * (self.base_radius + self.arm) ** 2,
        }

    def skeleton(self, poses: Poses) -> Skeleton:
        """The base, the arms, the parallelograms and the platform."""
        _, cosine, sine, _ = self._closed(poses)
        lines: list[tuple[str, Array, Array, float]] = []
        thick, up, tool = 0.025 * self.arm, np.array([0.0, 0.0, 1.0]), np.asarray(poses)[:, :3]
        for i, alpha in enumerate(AZIMUTHS):
            radial = np.array([math.cos(alpha), math.sin(alpha), 0.0])
            beside = 0.1 * self.arm * np.cross(up, radial)
            shoulder = np.broadcast_to(self.base_radius * radial, tool.shape)
            along = cosine[i][:, None] * radial - sine[i][:, None] * up
            elbow, wrist = shoulder + self.arm * along, tool + self.platform_radius * radial
            lines += [
                (f"base_{i + 1}", np.zeros_like(tool), shoulder, 1.4 * thick),
                (f"arm_{i + 1}", shoulder, elbow, 1.2 * thick),
                (f"elbow_{i + 1}", elbow - beside, elbow + beside, 0.7 * thick),
                (f"left_{i + 1}", elbow - beside, wrist - beside, 0.5 * thick),
                (f"right_{i + 1}", elbow + beside, wrist + beside, 0.5 * thick),
                (f"wrist_{i + 1}", wrist - beside, wrist + beside, 0.7 * thick),
                (f"platform_{i + 1}", wrist, tool, 0.7 * thick),
            ]
        segments = np.stack([np.stack([a, b], axis=1) for _, a, b, _ in lines], axis=1)
        return Skeleton(
            segments, np.array([radius for *_, radius in lines]), tuple(name for name, *_ in lines)
        )

    def _closed(self, poses: Any) -> tuple[Any, Any, Any, Any]:
        """Of each arm 1 − C²/P (3, n), cos θ and sin θ (3, n), and s (3, 3, n), its second axis x, y, z."""
        room, cosines, sines, ways = [], [], [], []
        x, y, z = poses[:, 0], poses[:, 1], poses[:, 2]
        for alpha in AZIMUTHS:
            cos, sin = math.cos(alpha), math.sin(alpha)
            out = cos * x + sin * y + (self.platform_radius - self.base_radius)
            across = cos * y - sin * x
            a, b = 2 * self.arm * out, -2 * self.arm * z
            c = out**2 + across**2 + z**2 + (self.arm**2 - self.forearm**2)
            p = a**2 + b**2
            with np.errstate(invalid="ignore", divide="ignore"):
                left = 1 - c**2 / p
                w = np.sqrt(p - c**2)
                cosine, sine = (a * c + b * w) / p, (b * c - a * w) / p
            # The platform's joint from the elbow, outwards and down; across it nothing turns.
            outward, height = out - self.arm * cosine, z + self.arm * sine
            ways.append(np.stack([cos * outward - sin * across, sin * outward + cos * across, height]))
            room.append(left)
            cosines.append(cosine)
            sines.append(sine)
        return np.stack(room), np.stack(cosines), np.stack(sines), np.stack(ways)

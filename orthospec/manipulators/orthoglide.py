"""The Orthoglide: three orthogonal slides, three legs, a tool that only translates.

Chablat and Wenger, *Architecture optimization of a 3-DOF parallel mechanism for machining applications, the
Orthoglide* (IEEE Trans. Robotics and Automation 19(3), 2003). At the origin all legs lie along their slides
and J = I: the isotropic pose.
"""

from __future__ import annotations

from functools import cached_property

from orthospec.arrays import np
from orthospec.manipulators.prismatic import PrismaticManipulator
from orthospec.mechanics.prismatic import PrismaticLegs


class Orthoglide(PrismaticManipulator):
    """Slider i moves along coordinate axis i: ρ_i = p_i + β_i sqrt(L_i² − Σ_{k≠i} p_k²).

    Row i of J⁻¹ is s_iᵀ / s_ii with s_i = ρ_i e_i − p: the bracket of eq. 14 of Pashkevich, Chablat and
    Wenger (2009). The machine is of Chablat and Wenger (2003). The first revolute axis of the legs of the
    x, y and z slides lies along z, x and y. An offset of the legs moves the leg's end on the platform
    along the slide, away from the tool; ρ counts from a point as far from the origin.
    """

    @cached_property
    def geometry(self) -> PrismaticLegs:
        """Slides along the coordinate axes; the slides' base points stand off as far as the legs' ends do."""
        branches = np.array(self.branch, dtype=float)
        offset = 0.0 if self.legs is None else self.legs.offset
        ends = np.diag(branches * offset)[:, :, None]
        return PrismaticLegs(
            axes=np.eye(3),
            bases=ends,
            joints=ends,
            lengths=self._lengths,
            branches=branches,
            revolutes=np.roll(np.eye(3), 1, axis=0),
            home=np.eye(3),
        )

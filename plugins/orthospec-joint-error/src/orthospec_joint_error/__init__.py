"""``joint_error``: how far the tool is off when each actuator is a little off.

Each actuator's position carries an independent error of standard deviation e, from its scale or its servo. To
first order the tool's error is δp = J δρ, J = ∂p/∂ρ, and by the law of propagation of uncertainty (JCGM
100:2008, *Guide to the expression of uncertainty in measurement*, eq. 10) coordinate k of the tool has the
variance e² Σ_i J_ki². Their sum is the mean square of the distance between the tool and where it should be:

    error = e ‖J‖_F.

The norm is convex in J, and so is its logarithm's excess over what the norm was: divided by itself,

    ‖J‖_F / ‖J_0‖_F − 1 + ln(e ‖J_0‖_F) <= ln b,

which is exact where J = J_0. This is the convex form. The values are written with whole arrays, so that they
hold for boxes of poses too, and a proof needs no more.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, ClassVar

import numpy as np
from pydantic import Field

from orthospec.measures import ConvexForm, Measure, logarithm
from orthospec.quantities import Length

if TYPE_CHECKING:
    from orthospec.arrays import Array, Flags, Poses
    from orthospec.manipulators import Manipulator

__all__ = ["JointError"]


class JointError(Measure):
    """Root-mean-square position error of the tool, e ‖J‖_F, from independent errors e of the actuators.

    JCGM 100:2008 (GUM), eq. 10, summed over the tool's coordinates. For machines with prismatic actuators
    and a tool that only translates.
    """

    error: Annotated[Length, Field(gt=0)]
    """Standard deviation of each actuator's position [m]."""

    unit: ClassVar[str] = "m"
    sides: ClassVar[frozenset[str]] = frozenset({"at_most"})

    def values(self, manipulator: Manipulator, poses: Poses) -> Array:
        """The error at each pose (n,) [m]; inf at a parallel singularity, NaN where J⁻¹ is not finite."""
        if {*manipulator.axes} - {"x", "y", "z"} or {*manipulator.joint_units} != {"m"}:
            raise ValueError("joint_error is for prismatic actuators and a tool that only translates")
        jacobian, known, regular = _jacobian(manipulator, poses)
        error = np.where(regular, self.error * np.linalg.norm(jacobian, axis=(1, 2)), np.inf)
        return np.where(known, error, np.nan)

    def form(self, manipulator: Manipulator, poses: Poses, side: str) -> ConvexForm:  # noqa: ARG002
        """‖Y‖ − 1 + l <= ln b with Y = J / ‖J‖_F and l = ln(e ‖J‖_F); NaN where J is not finite."""
        jacobian, known, regular = _jacobian(manipulator, poses)
        sound, parts = known & regular, jacobian.reshape(len(poses), -1)
        size = np.linalg.norm(parts, axis=1)
        inside = np.column_stack([parts / size[:, None], np.log(self.error * size)])

        def holds(x: Any, bound: Any, slack: Any) -> list[Any]:
            import cvxpy as cp

            return [cp.norm(x[:-1]) <= 1 + logarithm(bound) + slack - x[-1]]

        return ConvexForm(np.where(sound[:, None], inside, np.nan), holds)


def _jacobian(manipulator: Manipulator, poses: Poses) -> tuple[Array, Flags, Flags]:
    """J (n, d, d), the identity where it has no value; where J⁻¹ is finite, and where not singular (n,)."""
    inverse, eye = manipulator.inverse_jacobian(poses), np.eye(len(manipulator.axes))
    known: Flags = np.isfinite(inverse).all(axis=(1, 2))
    finite = np.where(known[:, None, None], inverse, eye)
    regular: Flags = np.linalg.det(finite) != 0
    jacobian: Array = np.linalg.inv(np.where(regular[:, None, None], finite, eye))
    return jacobian, known, regular

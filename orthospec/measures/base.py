"""`Measure`: a local performance of a machine at a pose, with the convex structure of its bounds.

Built-in and foreign measures are registered alike, in the entry-point group ``orthospec.measures``.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from pydantic import ConfigDict

from orthospec.described import Described

if TYPE_CHECKING:
    from orthospec.arrays import Array, Poses
    from orthospec.intervals import Boxes, Interval
    from orthospec.manipulators import Manipulator


@dataclass(frozen=True)
class ConvexForm:
    """A bound on a measure as a convex set of something smooth.

    ``inside`` (n, ...) is smooth in pose and design; it is linearised. ``holds(X, bound, slack)`` gives the
    cvxpy constraints that state the bound for one affine X of the shape of one inside. They are kept as they
    are, so repeated singular values are no trouble. ``slack`` is relative: with it the bound is met up to
    about a factor e^slack. ``bound`` is a number, or a scalar cvxpy expression that may stand on the convex
    side only; `logarithm` gives its logarithm, affine too.
    """

    inside: Array
    holds: Callable[[Any, Any, Any], list[Any]]


def logarithm(bound: Any) -> Any:
    """The logarithm of a bound that ``holds`` was given: a number's own, or the solver's affine twin."""
    return math.log(bound) if isinstance(bound, int | float) else bound.logarithm


class Measure(Described, ABC):
    """A frozen pydantic model: its fields are the spec's keys (not: use, at_least, at_most, levels)."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    unit: ClassVar[str]
    """The unit of its values: "1", "m", "kg", "m/s^2" ..."""
    sides: ClassVar[frozenset[str]]
    """Which of "at_least" and "at_most" mean something."""
    least: ClassVar[float] = -math.inf
    """No machine has a value below this: an upper bound there is a mistake."""
    needs: ClassVar[frozenset[str]] = frozenset()
    """What the machine must offer beside its kinematics: of "compliance", "joint_inertia",
    "actuator_forces", "actuator_speeds"; and "sliding_joints", where the unit is right for these alone."""

    @abstractmethod
    def values(self, manipulator: Manipulator, poses: Poses) -> Array:
        """(n,), or (n, 2) for least and greatest over directions; NaN where it cannot be computed.

        ``at_least`` bounds the first column, ``at_most`` the second.
        """

    def form(self, manipulator: Manipulator, poses: Poses, side: str) -> ConvexForm | None:  # noqa: ARG002
        """The convex form of one side; without one the logarithm of the value is linearised."""
        return None

    def enclosure(self, manipulator: Manipulator, boxes: Boxes) -> Interval | None:
        """Bounds on the values at all poses of each box, shaped as `values`; None where nothing is known.

        Unless a measure has a better one, these are its own ``values``, computed with intervals for numbers.
        Raises NoEnclosure where its code cannot be carried over intervals. A mean-value form that they carry
        is over the coordinates of ``boxes.poses``.
        """
        from orthospec.intervals import as_interval

        found: object = self.values(manipulator, boxes.poses)  # type: ignore[arg-type]
        return as_interval(found)

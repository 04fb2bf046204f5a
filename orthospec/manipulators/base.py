"""`Manipulator`: one design of one machine, as frozen numbers with batched mechanics.

A subclass declares its dimensions as pydantic fields (types from `orthospec.quantities`, SI) and computes for
whole blocks of poses. Built-in and foreign machines are registered alike, in the entry-point group
``orthospec.manipulators``.
"""

from __future__ import annotations

import functools
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from pydantic import BaseModel, ConfigDict, PrivateAttr

if TYPE_CHECKING:
    from orthospec.arrays import Array, Flags, Joints, Matrices, Poses


@dataclass(frozen=True)
class Skeleton:
    """The machine's lines at each pose: segments (n, s, 2, 3) [m], radii (s,) [m], names (s,)."""

    segments: Array
    radii: Array
    names: tuple[str, ...]


class Manipulator(BaseModel, ABC):
    """One design: a frozen pydantic model of numbers whose fields are the spec's keys.

    Methods take poses (n, d) and must be computable, with NaN where they are not, a little outside the reach:
    difference quotients and trial steps go there.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, use_attribute_docstrings=True)

    axes: ClassVar[tuple[str, ...]] = ("x", "y", "z")
    """The columns of a pose, of x y z rx ry rz; the cuboid spans the first ``len(size)``."""
    joint_units: ClassVar[tuple[str, ...]] = ("m", "m", "m")
    index_units: ClassVar[Mapping[str, str]] = {}
    """Names and units of the indices, known before a machine is built."""

    _memory: dict[str, tuple[object, Any]] = PrivateAttr(default_factory=dict)

    def __init_subclass__(cls, **kwargs: Any) -> None:
        """Let each field over the poses remember the block in hand: several measures then cost one field."""
        super().__init_subclass__(**kwargs)
        for name in ("inverse_kinematics", "inverse_jacobian", "compliance", "joint_inertia"):
            if name in cls.__dict__:
                setattr(cls, name, _remembering(name, cls.__dict__[name]))

    @abstractmethod
    def inverse_kinematics(self, poses: Poses) -> tuple[Joints, Flags]:
        """Joint coordinates (n, m) and whether each pose is reachable (n,)."""

    @abstractmethod
    def reach(self, poses: Poses) -> Mapping[str, Array]:
        """Each condition of *reachable* as a smooth signed margin (n,), >= 0 inside.

        A key may end in ``.at_least`` or ``.at_most``, the side of the limit that it stands for. A margin
        relative to its limit (or to a length of the machine) makes one per cent of it mean something.
        """

    @abstractmethod
    def inverse_jacobian(self, poses: Poses) -> Matrices:
        """J⁻¹ = ∂ρ/∂p, (n, m, m): joint rates for a unit rate of each pose coordinate."""

    def missing(self, what: str) -> tuple[str, ...]:  # noqa: ARG002
        """The fields to give before ``what`` ("compliance", "joint_inertia") can be had; () when it can."""
        return ()

    @abstractmethod
    def indices(self, joint_ranges: Array) -> Mapping[str, float]:
        """The global indices; joint_ranges (m, 2): least and greatest joint value over the cuboid."""

    @abstractmethod
    def skeleton(self, poses: Poses) -> Skeleton:
        """Segments to draw the machine at each pose."""


def _remembering(name: str, method: Callable[[Any, Any], Any]) -> Callable[[Any, Any], Any]:
    @functools.wraps(method)
    def remembered(self: Any, poses: Any) -> Any:
        held = self._memory.get(name)
        if held is not None and held[0] is poses:
            return held[1]
        value = method(self, poses)
        if not poses.flags.writeable:
            self._memory[name] = (poses, value)
        return value

    return remembered

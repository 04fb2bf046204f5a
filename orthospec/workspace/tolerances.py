"""All machines within tolerances of one: what they deviate by is so many more coordinates of a proof's boxes.

A coordinate stands for one number of a toleranced field, each on its own: the three lengths of
``leg_lengths`` are three. A box of poses and numbers is asked about as a block of poses of one machine whose
fields are intervals; at points, one whose fields are arrays.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from orthospec.intervals import Boxes
from orthospec.manipulators import Manipulator
from orthospec.workspace.cuboid import Cuboid

if TYPE_CHECKING:
    from orthospec.arrays import Array, Poses


@dataclass(frozen=True)
class Family:
    """A machine, and all those that differ from it by no more than the tolerances."""

    nominal: Manipulator
    tolerances: Mapping[str, float] = field(default_factory=dict)
    """How far each number of a field may be off, by the field's name."""

    def whole(self, cuboid: Cuboid) -> Boxes:
        """All poses of a cuboid of all machines, as one box."""
        axes = len(self.nominal.axes)
        lo, hi = np.zeros((2, 1, axes))
        lo[0, : len(cuboid.low)], hi[0, : len(cuboid.high)] = cuboid.low, cuboid.high
        numbers = np.concatenate([np.zeros(0), *(self._numbers(name) for name in self.tolerances)])
        off = np.repeat(
            list(self.tolerances.values()), [len(self._numbers(name)) for name in self.tolerances]
        )
        # Outwards: the sums are rounded.
        least, most = (np.nextafter(numbers + sign * off, sign * np.inf) for sign in (-1, 1))
        least, most = (np.where(off > 0, end, numbers)[None] for end in (least, most))
        return Boxes(np.concatenate([lo, least], axis=1), np.concatenate([hi, most], axis=1))

    def over(self, boxes: Boxes) -> tuple[Manipulator, Boxes]:
        """Over boxes of all coordinates: a machine with intervals for fields, and the boxes of its poses."""
        if not self.tolerances:
            return self.nominal, boxes
        axes = len(self.nominal.axes)
        return self._with(boxes.poses[:, axes:]), boxes.of_first(axes)

    def at(self, points: Array) -> tuple[Manipulator, Poses]:
        """At points (n, d) of all coordinates: a machine with arrays for fields, and its poses."""
        axes = len(self.nominal.axes)
        poses = points[:, :axes].copy()
        poses.flags.writeable = False
        return self._with(points[:, axes:]), poses

    def named(self, point: Array) -> dict[str, tuple[float, ...]]:
        """The numbers of the machine at one point (d,), by field."""
        values = iter(point[len(self.nominal.axes) :].tolist())
        return {name: tuple(next(values) for _ in self._numbers(name)) for name in self.tolerances}

    def _with(self, numbers: Any) -> Manipulator:
        if not self.tolerances:
            return self.nominal
        columns = iter(numbers.T)
        fields = {}
        for name in self.tolerances:
            own = tuple(next(columns) for _ in self._numbers(name))
            fields[name] = own if isinstance(getattr(self.nominal, name), tuple) else own[0]
        return self.nominal.varied(fields)

    def _numbers(self, name: str) -> Array:
        return np.atleast_1d(np.array(getattr(self.nominal, name), dtype=float))

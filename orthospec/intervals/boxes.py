"""Boxes of poses, many at a time."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from orthospec.intervals.interval import Interval
from orthospec.intervals.linear import Linear
from orthospec.intervals.rounding import SPARE, TINY

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from orthospec.arrays import Flags, Poses


@dataclass(frozen=True, eq=False)
class Boxes:
    """All poses between ``lo`` and ``hi``, (n, d) each."""

    lo: Poses
    hi: Poses

    def __len__(self) -> int:
        """How many boxes there are."""
        return len(self.lo)

    @property
    def centres(self) -> Poses:
        """A pose in the middle of each box (n, d)."""
        return np.asarray((self.lo + self.hi) / 2)

    @cached_property
    def poses(self) -> Interval:
        """The boxes as an interval (n, d), which remembers what of a result depends on which coordinate."""
        n, d = self.lo.shape
        slopes = np.zeros((d, n, d))  # In memory the coordinates come first: long inner loops.
        centres = self.centres
        for k in range(d):
            half = np.maximum(self.hi[:, k] - centres[:, k], centres[:, k] - self.lo[:, k])
            slopes[k, :, k] = half * SPARE + TINY
        form = Linear(centres, np.moveaxis(slopes, 0, -1), np.zeros((n, d)))
        poses = Interval(self.lo.copy(), self.hi.copy(), form)
        poses.make_read_only()
        return poses

    def of_first(self, count: int) -> Boxes:
        """The boxes of the first coordinates alone, whose poses remember how they depend on all of them."""
        first = Boxes(self.lo[:, :count], self.hi[:, :count])
        first.__dict__["poses"] = self.poses[:, :count]
        return first

    def moved(self, by: Poses) -> Boxes:
        """Each box moved by (n, d), whose poses remember how they depend on these boxes' coordinates.

        Quantities at several places about one box can so be added up, each with what it depends on.
        """
        poses: Interval = self.poses + by
        poses.make_read_only()
        moved = Boxes(poses.lo, poses.hi)
        moved.__dict__["poses"] = poses
        return moved

    def __getitem__(self, chosen: Flags | NDArray[np.intp] | slice) -> Boxes:
        """Some of the boxes."""
        return Boxes(self.lo[chosen], self.hi[chosen])

    def joined(self, others: Boxes) -> Boxes:
        """These boxes and then the others."""
        return Boxes(np.concatenate([self.lo, others.lo]), np.concatenate([self.hi, others.hi]))

    def halves(self, along: NDArray[np.intp]) -> Boxes:
        """Each box cut in two across the coordinate that ``along`` (n,) names for it, (2n, d)."""
        return self.cut(along, self.centres)

    def cut(self, along: NDArray[np.intp], at: Poses) -> Boxes:
        """Each box cut in two at a pose of its own (n, d), across the coordinate that ``along`` names."""
        rows = np.arange(len(self))
        lower, upper = self.hi.copy(), self.lo.copy()
        lower[rows, along] = upper[rows, along] = at[rows, along]
        return Boxes(np.concatenate([self.lo, upper]), np.concatenate([lower, self.hi]))

"""Poses at which something fails, none of which a cuboid may hold.

One such pose excludes all cuboids around it: a whole box of placements at once, and without bounds over any
box of poses. So where cuboids are too large by more than a little, a few poses stand for thousands of boxes.
They are looked for in the cuboids that are left, in plain arithmetic, and proved to fail before they count.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from orthospec.intervals import Boxes
from orthospec.workspace.critical import lattice

if TYPE_CHECKING:
    from orthospec.arrays import Array, Flags

    Fail: TypeAlias = Callable[[Array], Flags]
    """Which of the poses (k, d) fail."""

SMALL = 0.5
"""Boxes whose edges are below this part of the cuboid's: in larger ones cuboids have little in common."""
FEW = 32
"""Fewer boxes are not worth a search, nor is a search that leaves out fewer."""
CHOSEN = 16
"""Boxes at a time in which a pose is looked for."""
SAMPLED = 343
"""About as many poses of a cuboid are looked at."""
INNER = 0.98
"""They span this part of its edges: a pose on a face would be held by no other cuboid."""
AT_ONCE = 64
"""Poses that are compared with all boxes at a time."""


class Obstacles:
    """The failing poses known so far, for cuboids of one size.

    ``seem_to_fail`` tells in plain arithmetic which poses fail, ``certainly_fail`` of which it is proved.
    """

    def __init__(self, size: Array, seem_to_fail: Fail, certainly_fail: Fail) -> None:
        self._size, self._seem_to_fail, self._certainly_fail = size, seem_to_fail, certainly_fail
        self._poses = np.zeros((0, len(size)))
        self._places = INNER * lattice(max(3, round(SAMPLED ** (1 / len(size)))), len(size))

    def leave(self, boxes: Boxes) -> Boxes:
        """The boxes of centres in which a cuboid may hold no failing pose; more such poses are learnt."""
        boxes = boxes[~self._hold_one_of(self._poses, boxes)]
        small = np.asarray(((boxes.hi - boxes.lo) < SMALL * self._size).all(axis=1))
        found = self._found_in(boxes[small])
        if not len(found):
            return boxes
        found = found[self._certainly_fail(found)]
        self._poses = np.concatenate([self._poses, found])
        return boxes[~self._hold_one_of(found, boxes)]

    def _found_in(self, boxes: Boxes) -> Array:
        """Poses (k, d) that seem to fail, for as long as they leave out boxes enough."""
        found = [self._poses[:0]]
        while len(boxes) >= FEW:
            some = boxes[np.linspace(0, len(boxes) - 1, CHOSEN).astype(int)]
            found.append(self._deepest_in(some.centres))
            held = self._hold_one_of(found[-1], boxes)
            if held.sum() < FEW:
                break
            boxes = boxes[~held]
        return np.concatenate(found)

    def _deepest_in(self, centres: Array) -> Array:
        """Of each cuboid about a centre (n, d) the pose that lies deepest of those that seem to fail."""
        poses = centres[:, None, :] + self._size * self._places
        fails = self._seem_to_fail(poses.reshape(-1, len(self._size))).reshape(len(poses), -1)
        depths = np.where(fails, 0.5 - np.abs(self._places).max(axis=1), 0.0)
        each, deepest = np.arange(len(poses)), depths.argmax(axis=1)
        return np.asarray(poses[each, deepest][depths[each, deepest] > 0])

    def _hold_one_of(self, poses: Array, boxes: Boxes) -> Flags:
        """Whether each cuboid with its centre in a box (n,) holds the same one of these poses (k, d)."""
        low, high = (
            np.nextafter(boxes.hi - self._size / 2, np.inf),
            np.nextafter(boxes.lo + self._size / 2, -np.inf),
        )
        held = np.zeros(len(boxes), dtype=bool)
        for first in range(0, len(poses), AT_ONCE):
            inside = np.ones((len(boxes), len(poses[first : first + AT_ONCE])), dtype=bool)
            for axis, x in enumerate(poses[first : first + AT_ONCE].T):
                inside &= (low[:, axis, None] <= x) & (x <= high[:, axis, None])
            held |= inside.any(axis=1)
        return held

"""Proof that no cuboid of some size fits anywhere, by branch and bound over boxes of placements.

A box of centres is excluded where, for one place u of the cuboid, all poses centre + size∘u are out of reach
or violate one bound: then each cuboid of the box, and each larger one with such a centre, has a pose at which
something does not hold. Otherwise it is cut in two. Tried are the corners, the middles of edges and faces,
the centre, and the critical points of a cuboid that is nearly too large: those first that are worst, in
plain arithmetic, at the box's own middle.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from orthospec.intervals import Boxes
from orthospec.measures import Demand
from orthospec.measures.demand import bounded_side
from orthospec.workspace.conditions import Sample, conditions_of
from orthospec.workspace.critical import find_peaks
from orthospec.workspace.cuboid import Cuboid
from orthospec.workspace.machine import Machine

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from orthospec.arrays import Array, Flags

BATCH = 4096
"""Boxes of centres at a time."""
TRIED = 4
"""Places of the cuboid that are tried in each box."""
WORTH = 1.0
"""A place is tried where a condition fails by so many times what it changes by over the box."""
ROOM, APART, MOST_CRITICAL = 0.05, 0.01, 24
"""A condition has little room below this; places nearer than this are one; critical points at most."""
FAR = 1024.0
"""Without a region, centres are looked at within so many sizes of the origin."""
NEAR = 4.0
"""Those within so many sizes of the largest cuboid's centre may be near the machine's reach."""
FINEST = 2.0**-40


def none_fits(
    machine: Machine, size: Array, region: Cuboid | None, most: int, largest: Cuboid | None = None
) -> tuple[bool, int]:
    """Whether it is proved that no cuboid of this size fits, and the boxes of centres that it took.

    ``largest`` is a cuboid of less size whose critical points are worth a try.
    False where more than ``most`` boxes are needed, as where one does fit.
    """
    search = _Search(machine, size, largest)
    spent, waiting = 0, _centres(size, region, np.zeros(len(size)) if largest is None else largest.centre)
    while len(waiting):
        # The last are the smallest: where a cuboid does fit, the search comes to its end there first.
        waiting, boxes = waiting[:-BATCH], waiting[-BATCH:]
        spent += len(boxes)
        if spent > most:
            return False, spent
        rest = boxes[search.not_excluded(boxes)]
        if len(rest) and ((rest.hi - rest.lo) <= FINEST * size).all(axis=1).any():
            return False, spent
        waiting = waiting.joined(_cut(rest, size))
    return True, spent


def _cut(boxes: Boxes, size: Array) -> Boxes:
    """Each box in two, across its longest edge beside the cuboid's; few boxes in each direction."""
    for _ in range(len(size) if len(boxes) * 2 ** len(size) <= BATCH else 1):
        boxes = boxes.halves(((boxes.hi - boxes.lo) / size).argmax(axis=1))
    return boxes


def _centres(size: Array, region: Cuboid | None, middle: Array) -> Boxes:
    """All centres, as one box or some; none where the region is too small.

    Without a region those near the ``middle`` stand apart from those far out, which are excluded at once.
    """
    if region is None:
        ends = np.stack([-FAR * size, middle - NEAR * size, middle + NEAR * size, FAR * size])
        cuts = np.clip(ends, -FAR * size, FAR * size)
        thirds = np.array(list(product(range(3), repeat=len(size))))
        axes = np.arange(len(size))
        return Boxes(cuts[thirds, axes], cuts[thirds + 1, axes])
    low, high = np.array(region.low) + size / 2, np.array(region.high) - size / 2
    if (low > high).any():
        return Boxes(np.zeros((0, len(size))), np.zeros((0, len(size))))
    return Boxes(low[None], high[None])


class _Search:
    """What is asked of each box of centres."""

    def __init__(self, machine: Machine, size: Array, largest: Cuboid | None) -> None:
        self._machine, self._size, self._axes = machine, size, len(machine.manipulator.axes)
        self._demands = tuple(machine.demands.values())
        self._conditions = conditions_of(machine.manipulator, self._demands, np.zeros((1, self._axes)))
        names = [demand.name for demand in self._demands]
        self._case_of = np.array([-1 if c.kind == "joint" else names.index(c.name) for c in self._conditions])
        """The demand that each condition is of, by number; −1 for the reach."""
        self._places = np.array(list(product((-0.5, 0.0, 0.5), repeat=len(size))))
        if largest is not None:
            self._places = np.vstack([self._places, self._critical(largest)])

    def _critical(self, cuboid: Cuboid) -> Array:
        """Where in a cuboid the conditions are worst (k, d), of those that it leaves little room."""

        def functions(u: Array) -> Array:
            sample = Sample(self._machine, cuboid.poses(u, self._axes))
            return sample.rows(self._conditions, [], {})

        peaks = find_peaks(functions, len(self._size))
        found = peaks.u[peaks.value > -ROOM]
        apart = np.abs(found[:, None] - self._places).max(axis=2).min(axis=1) > APART
        return np.asarray(found[apart][:MOST_CRITICAL])

    def not_excluded(self, boxes: Boxes) -> Flags:
        """Which boxes are left."""
        edges = (boxes.hi - boxes.lo) / self._size
        left = np.ones(len(boxes), dtype=bool)
        for place, condition, sure in self._most_sure(boxes.centres):
            (mine,) = np.nonzero(left & (sure > WORTH * edges.max(axis=1)))
            for case in np.unique(self._case_of[condition[mine]]):
                these = mine[self._case_of[condition[mine]] == case]
                at = self._size * self._places[place[these]]
                left[these] = ~self._never_holds(int(case), boxes[these], at)
        return left

    def _most_sure(self, centres: Array) -> Iterator[tuple[NDArray[np.intp], NDArray[np.intp], Array]]:
        """Places where something does not hold, most surely first: place, condition, how sure (n,) each.

        That is far out of reach, or far beyond a bound and yet well within reach: near its edge, where values
        are greatest, a box tells nothing. It counts beside what the condition changes by over the cuboid.
        """
        n = len(centres)
        poses = (centres[:, None, :] + self._size * self._places).reshape(-1, len(self._size))
        rows = Sample(self._machine, self._padded(poses)).rows(self._conditions, [], {})
        rows = rows.reshape(len(rows), n, -1)
        spread = _spread(rows)
        rows = np.where(np.isfinite(rows), rows, -np.inf)
        of_reach = self._case_of < 0
        beyond = rows[of_reach].max(axis=0)
        rows[~of_reach] = np.minimum(rows[~of_reach], -beyond)
        sure, condition = rows.max(axis=0), rows.argmax(axis=0)
        order = np.argsort(-sure, axis=1, kind="stable")[:, :TRIED]
        each = np.arange(n)
        for place in order.T:
            decides = condition[each, place]
            yield place, decides, sure[each, place] / spread[decides, each]

    def _never_holds(self, case: int, boxes: Boxes, at: Array) -> Flags:
        """Whether in each box, moved by ``at`` (n, d), the reach (−1) or a demand holds nowhere."""
        low, high = np.nextafter(boxes.lo + at, -np.inf), np.nextafter(boxes.hi + at, np.inf)
        moved = Boxes(self._padded(low), self._padded(high))
        try:
            return self._out_of_reach(moved) if case < 0 else self._violates(self._demands[case], moved)
        except Exception:
            # What cannot be carried over boxes excludes nothing; a verdict tells why.
            return np.zeros(len(boxes), dtype=bool)

    def _out_of_reach(self, boxes: Boxes) -> Flags:
        margins = self._machine.manipulator.reach_enclosure(boxes)
        keys = (condition.reach_key for condition in self._conditions if condition.kind == "joint")
        return np.asarray(np.any([margins[key].hi < 0 for key in keys], axis=0))

    def _violates(self, demand: Demand, boxes: Boxes) -> Flags:
        found = demand.measure.enclosure(self._machine.manipulator, boxes)
        never = np.zeros(len(boxes), dtype=bool)
        if found is not None:
            for side, bound in demand.bounds.items():
                if side == "at_most":
                    never |= bounded_side(found.lo, side) > bound
                else:
                    never |= bounded_side(found.hi, side) < bound
        return never

    def _padded(self, poses: Array) -> Array:
        padded = np.zeros((len(poses), self._axes))
        padded[:, : poses.shape[1]] = poses
        padded.flags.writeable = False
        return padded


def _spread(rows: Array) -> Array:
    """What each condition changes by over each cuboid (k, n), at most 1; of rows (k, n, places)."""
    known = np.isfinite(rows)
    highest = np.where(known, rows, -np.inf).max(axis=2)
    lowest = np.where(known, rows, np.inf).min(axis=2)
    with np.errstate(invalid="ignore"):
        return np.asarray(np.clip(np.nan_to_num(highest - lowest, nan=1.0), 1e-9, 1.0))

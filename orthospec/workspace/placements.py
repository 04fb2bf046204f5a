"""Proof that no cuboid of some size fits anywhere, by branch and bound over boxes of placements.

A box of centres is excluded where, for one place u of the cuboid, all poses centre + size∘u are out of reach
or violate one bound, or where several conditions at several places cannot all hold (`weighing`): then each
cuboid of the box, and each larger one with such a centre, has a pose at which something does not hold.
Otherwise it is cut in two. Tried are the corners, the middles of edges and faces, the centre, and the
critical points of a cuboid that is nearly too large: those first that are worst, in plain arithmetic, at the
box's own middle. Before all this come poses that are known to fail, which exclude most boxes at no cost
(`obstacles`).
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import product
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from orthospec.errors import RAISED
from orthospec.intervals import Boxes, Interval
from orthospec.intervals.linear import Linear
from orthospec.measures.demand import bounded_side
from orthospec.workspace.conditions import Sample, conditions_of
from orthospec.workspace.critical import Peaks, find_peaks, lattice
from orthospec.workspace.cuboid import Cuboid
from orthospec.workspace.machine import Machine
from orthospec.workspace.obstacles import Obstacles
from orthospec.workspace.weighing import cannot_all_hold

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from orthospec.arrays import Array, Flags

BATCH = 4096
"""Boxes of centres at a time."""
AT_ONCE = 1024
"""About as many looks at a time: one after the other at many boxes, of which most need no second one."""
TRIED = 6
"""Looks at each box: conditions, each at a place of the cuboid."""
WORTH = 2.0
"""A condition may fail somewhere in a box of half-width h where it has less room than 4 h of its spread."""
ROOM, APART, MOST_CRITICAL = 0.05, 0.01, 24
"""A condition has little room below this; places nearer than this are one; critical points at most."""
FAR = 1e9
"""Without a region, all centres are looked at that are so far out at most along each axis [m, rad].

No machine reaches so far, and doubles still tell a tenth of a micrometre there."""
NEAR = 4.0
"""Centres within so many sizes of the largest cuboid's may be near the machine's reach."""
FINEST = 2.0**-40


class Placing(NamedTuple):
    """What came of a search for a place."""

    excluded: bool
    """Whether it is proved that the cuboid fits nowhere."""
    boxes: int
    """Of centres, that were looked at."""
    fits: Cuboid | None = None
    """Where it does fit as far as plain arithmetic tells; None where no such place was met."""


def none_fits(
    machine: Machine, size: Array, region: Cuboid | None, most: int, largest: Cuboid | None = None
) -> Placing:
    """Whether it is proved that no cuboid of this size fits.

    ``largest`` is a cuboid of less size whose critical points are worth a try. Not proved where more than
    ``most`` boxes are needed; at once where a place is met at which it seems to fit, or where nothing
    excludes the largest one's centre alone.
    """
    search = _Search(machine, size, largest)
    middle = np.zeros(len(size)) if largest is None else largest.centre
    spent, waiting = 0, _centres(size, region, middle)
    if largest is not None and len(waiting):
        best = np.clip(middle, waiting.lo.min(axis=0), waiting.hi.max(axis=0))[None]
        if search.not_excluded(Boxes(best, best)).any():
            return Placing(False, 1, search.place_in(Boxes(best, best)))
    while len(waiting):
        # The last are the smallest: where a cuboid does fit, the search comes to its end there first.
        waiting, boxes = waiting[:-BATCH], waiting[-BATCH:]
        boxes = search.obstacles.leave(boxes)
        spent += len(boxes)
        if spent > most:
            return Placing(False, spent)
        rest = boxes[search.not_excluded(boxes)] if len(boxes) else boxes
        fits = search.place_in(rest)
        if fits is not None:
            return Placing(False, spent, fits)
        if len(rest) and ((rest.hi - rest.lo) <= FINEST * size).all(axis=1).any():
            return Placing(False, spent)
        waiting = waiting.joined(_cut(rest, middle, NEAR * size))
    return Placing(True, spent)


def _cut(boxes: Boxes, middle: Array, near: Array) -> Boxes:
    """Each box in two, across the edge that is longest beside ``near``; few boxes in each direction.

    Farther than that from the middle an edge counts, and is halved, by the logarithm of how far its ends are.
    """
    for _ in range(len(middle) if len(boxes) * 2 ** len(middle) <= BATCH else 1):
        lo, hi = (_reckoned((end - middle) / near) for end in (boxes.lo, boxes.hi))
        at = np.clip(middle + near * _unreckoned((lo + hi) / 2), boxes.lo, boxes.hi)
        boxes = boxes.cut((hi - lo).argmax(axis=1), at)
    return boxes


def _reckoned(x: Array) -> Array:
    """x from −1 to 1, and beyond with its sign 1 + log|x|."""
    return np.asarray(np.where(np.abs(x) <= 1, x, np.copysign(1 + np.log(np.maximum(np.abs(x), 1)), x)))


def _unreckoned(y: Array) -> Array:
    """The x that is reckoned so."""
    return np.asarray(np.where(np.abs(y) <= 1, y, np.copysign(np.exp(np.maximum(np.abs(y), 1) - 1), y)))


def _centres(size: Array, region: Cuboid | None, middle: Array) -> Boxes:
    """All centres, as one box or some; none where the region is too small.

    Without a region those near the ``middle`` stand apart from those farther out, most of which are excluded
    at once.
    """
    if region is None:
        far = np.full(len(size), FAR)
        cuts = np.clip(np.stack([-far, middle - NEAR * size, middle + NEAR * size, far]), -FAR, FAR)
        thirds = np.array(list(product(range(3), repeat=len(size))))
        axes = np.arange(len(size))
        return Boxes(cuts[thirds, axes], cuts[thirds + 1, axes])
    low, high = np.array(region.low) + size / 2, np.array(region.high) - size / 2
    if (low > high).any():
        return Boxes(np.zeros((0, len(size))), np.zeros((0, len(size))))
    return Boxes(low[None], high[None])


class _Looks(NamedTuple):
    """Which conditions are asked about where, of each box (n, k): those first that most surely fail."""

    place: NDArray[np.intp]
    condition: NDArray[np.intp]
    worth: Flags
    """Whether anything can come of it."""


class _Search:
    """What is asked of each box of centres."""

    def __init__(self, machine: Machine, size: Array, largest: Cuboid | None) -> None:
        self._machine, self._size, self._axes = machine, size, len(machine.manipulator.axes)
        self._demands = tuple(machine.demands.values())
        self._conditions = conditions_of(machine.manipulator, self._demands, np.zeros((1, self._axes)))
        names = [demand.name for demand in self._demands]
        self._case_of = np.array([-1 if c.kind == "joint" else names.index(c.name) for c in self._conditions])
        """The demand that each condition is of, by number; −1 for the reach."""
        self._places = lattice(3, len(size))
        self.obstacles = Obstacles(size, self._seem_to_fail, self._certainly_fail)
        if largest is not None:
            self._places = np.vstack([self._places, self._critical(largest)])

    def _critical(self, cuboid: Cuboid) -> Array:
        """Where in a cuboid the conditions are worst (k, d), of those that it leaves little room."""
        peaks = self._peaks(cuboid)
        found = peaks.u[peaks.value > -ROOM]
        apart = np.abs(found[:, None] - self._places).max(axis=2).min(axis=1) > APART
        return np.asarray(found[apart][:MOST_CRITICAL])

    def _peaks(self, cuboid: Cuboid) -> Peaks:
        """Where in a cuboid each condition is worst."""

        def functions(u: Array) -> Array:
            sample = Sample(self._machine, cuboid.poses(u, self._axes))
            return sample.rows(self._conditions, [], {})

        return find_peaks(functions, len(self._size))

    def place_in(self, boxes: Boxes) -> Cuboid | None:
        """A cuboid about the middle of one of the boxes that fits as far as plain arithmetic tells.

        Tried is the one that fits best of those that do at all places that are looked at.
        """
        if not len(boxes):
            return None
        worst = np.nan_to_num(self._rows(boxes), nan=np.inf).max(axis=(0, 2))
        best = int(worst.argmin())
        if worst[best] > 0:
            return None
        cuboid = Cuboid.around(boxes.centres[best], self._size)
        return cuboid if (self._peaks(cuboid).value <= 0).all() else None

    def not_excluded(self, boxes: Boxes) -> Flags:
        """Which boxes are left: of which no condition fails throughout, nor some of them by turns."""
        looks, centres = self._looks(boxes), Boxes(self._padded(boxes.lo), self._padded(boxes.hi))
        found = _unknown(looks.worth.shape, self._axes)
        left, turn = np.ones(len(boxes), dtype=bool), np.arange(looks.worth.shape[1])
        done = 0
        while done < len(turn) and left.any():
            more = done + max(1, AT_ONCE // int(left.sum()))
            asked = looks.worth & left[:, None] & (turn >= done) & (turn < more)
            for case in np.unique(self._case_of[looks.condition[asked]]):
                box, look = np.nonzero(asked & (self._case_of[looks.condition] == case))
                left[box[self._fails(int(case), centres, looks, box, look, found)]] = False
            done = more
        rest = np.flatnonzero(left)
        left[rest] = ~cannot_all_hold(Linear(*(part[rest] for part in found)))
        return left

    def _seem_to_fail(self, poses: Array) -> Flags:
        """At which of the poses (k, d) a condition fails, in plain arithmetic."""
        rows = Sample(self._machine, self._padded(poses)).rows(self._conditions, [], {})
        return np.asarray((rows > 0).any(axis=0))

    def _certainly_fail(self, poses: Array) -> Flags:
        """At which of the poses (k, d) a condition is proved to fail."""
        fails, padded = np.zeros(len(poses), dtype=bool), self._padded(poses)
        for case in np.unique(self._case_of):
            for excess in self._over(int(case), Boxes(padded, padded)).values():
                fails |= excess.lo > 0
        return fails

    def _looks(self, boxes: Boxes) -> _Looks:
        """The worst conditions at the worst places of the cuboid, in plain arithmetic at each box's middle.

        That is far out of reach, or far beyond a bound and yet well within reach: near its edge, where values
        are greatest, a box tells nothing. It counts beside what the condition changes by over the cuboid.
        """
        n, each = len(boxes), np.arange(len(boxes))[:, None]
        rows = self._rows(boxes)
        spread = _spread(rows)
        rows = np.where(np.isfinite(rows), rows, -np.inf)
        of_reach = self._case_of < 0
        beyond = rows[of_reach].max(axis=0)
        rows[~of_reach] = np.minimum(rows[~of_reach], -beyond)
        rows /= spread[:, :, None]
        places = np.argsort(-rows.max(axis=0), axis=1, kind="stable")[:, :TRIED]
        near = np.moveaxis(rows[:, each, places], 0, 2).reshape(n, -1)
        order = np.argsort(-near, axis=1, kind="stable")[:, :TRIED]
        sure = near[each, order]
        edges = ((boxes.hi - boxes.lo) / self._size).max(axis=1, keepdims=True)
        worth = (sure > -WORTH * edges) & (sure[:, :1] > 0)
        return _Looks(places[each, order // len(rows)], order % len(rows), worth)

    def _rows(self, boxes: Boxes) -> Array:
        """By how much conditions fail (k, n, places) in the cuboid about each box's middle, by arithmetic."""
        poses = (boxes.centres[:, None, :] + self._size * self._places).reshape(-1, len(self._size))
        rows = Sample(self._machine, self._padded(poses)).rows(self._conditions, [], {})
        return rows.reshape(len(rows), len(boxes), -1)

    def _fails(
        self,
        case: int,
        centres: Boxes,
        looks: _Looks,
        box: NDArray[np.intp],
        look: NDArray[np.intp],
        found: Linear,
    ) -> Flags:
        """Whether at looks of one case a condition fails throughout; ``found`` keeps the one asked about."""
        condition, at = looks.condition[box, look], self._size * self._places[looks.place[box, look]]
        fails = np.zeros(len(box), dtype=bool)
        for number, excess in self._over(case, centres[box].moved(self._padded(at))).items():
            fails |= excess.lo > 0
            own = condition == number
            c, g, r = excess[own].form_over(self._axes)
            places = box[own], look[own]
            found.c[places] = np.where(np.isnan(excess.lo[own]), np.nan, c)
            found.g[places], found.r[places] = g, r
        return fails

    def _over(self, case: int, boxes: Boxes) -> Mapping[int, Interval]:
        """Over boxes how far each condition of the reach (−1) or of a demand is exceeded, by its number."""
        numbers = [int(number) for number in np.flatnonzero(self._case_of == case)]
        try:
            over = self._reach(numbers, boxes) if case < 0 else self._bounds(case, numbers, boxes)
        except RAISED:
            # What cannot be carried over boxes excludes nothing; a verdict tells why.
            return {}
        return {k: excess for k, excess in over.items() if self._is_of(excess, boxes)}

    def _is_of(self, excess: object, boxes: Boxes) -> bool:
        if not isinstance(excess, Interval) or excess.shape != (len(boxes),):
            return False
        return excess.coordinates in {0, self._axes}

    def _reach(self, numbers: list[int], boxes: Boxes) -> Mapping[int, Interval]:
        margins = self._machine.manipulator.reach_enclosure(boxes)
        return {k: -margins[self._conditions[k].reach_key] for k in numbers}

    def _bounds(self, case: int, numbers: list[int], boxes: Boxes) -> Mapping[int, Interval]:
        demand = self._demands[case]
        found: dict[int, Any] = {}
        values: Any = demand.enclosure(self._machine.manipulator, boxes)
        for k in numbers:
            side = str(self._conditions[k].side)
            over = bounded_side(values, side) - demand.bounds[side]
            found[k] = over if side == "at_most" else -over
        return found

    def _padded(self, poses: Array) -> Array:
        padded = np.zeros((len(poses), self._axes))
        padded[:, : poses.shape[1]] = poses
        padded.flags.writeable = False
        return padded


def _unknown(shape: tuple[int, ...], d: int) -> Linear:
    return Linear(np.full(shape, np.nan), np.zeros((*shape, d)), np.full(shape, np.nan))


def _spread(rows: Array) -> Array:
    """What each condition changes by over each cuboid (k, n), at most 1; of rows (k, n, places)."""
    known = np.isfinite(rows)
    highest = np.where(known, rows, -np.inf).max(axis=2)
    lowest = np.where(known, rows, np.inf).min(axis=2)
    with np.errstate(invalid="ignore"):
        return np.asarray(np.clip(np.nan_to_num(highest - lowest, nan=1.0), 1e-9, 1.0))

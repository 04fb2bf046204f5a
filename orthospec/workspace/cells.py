"""The states of a grid's nodes, by whole cells of nodes where bounds over a cell decide them.

Verified bounds on the margins and measures over the box that a cell spans, those of the proofs, tell of many
cells that all their nodes meet a bound, violate it or are out of reach. Any other cell is cut in two along
each axis, and in the smallest ones the nodes are measured. Nothing is decided nearer to a bound than `CLEAR`,
far more than rounding: the states are those of `orthospec.workspace.field.node_states`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from orthospec.errors import RAISED
from orthospec.intervals import Boxes, Interval
from orthospec.manipulators import Manipulator
from orthospec.measures import Demand
from orthospec.measures.demand import bounded_side
from orthospec.workspace.field import (
    BLOCK,
    Blocks,
    Failure,
    Progress,
    State,
    failed,
    failures_at,
    judged,
    measured,
    measured_blocks,
    node_states,
)
from orthospec.workspace.grid import Grid

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from orthospec.arrays import Array, Flags, Poses

FEW = 1 << 19
"""So few nodes are measured sooner than bounded."""
COARSEST, FINEST = 64, 16
"""Nodes along an edge of the first cells that are bounded and of the last ones.

Bounds over one cell take as long as the measures at some 350 nodes.
"""
BATCH = 512
"""Cells that are bounded at a time."""
CLEAR = 1e-6
"""Relative distance from a bound, or of a margin from 0, which is far more than rounding."""


States = tuple[list["NDArray[np.uint8]"], list[Failure]]
"""The state of each node under each demand alone, shaped as the grid, and each measure's first failure."""


FindStates = Callable[[Manipulator, Sequence[Demand], Grid, Progress | None], States]
"""Who finds them."""


def grid_states(
    manipulator: Manipulator,
    demands: Sequence[Demand],
    grid: Grid,
    progress: Progress | None = None,
    blocks: Blocks = measured_blocks,
    by_cells: FindStates | None = None,
) -> States:
    """What `node_states` gives.

    ``blocks`` serve small grids, and measures of which nothing is known over boxes; ``by_cells`` the others,
    `cell_states` if not given.
    """
    bounded = _with_enclosures(manipulator, demands, grid) if grid.nodes >= FEW else []
    if not bounded:
        return node_states(manipulator, demands, grid, progress, blocks)
    states, failures = (by_cells or cell_states)(manipulator, bounded, grid, progress)
    others = [demand for demand in demands if demand not in bounded]
    if others:
        more, theirs = node_states(manipulator, others, grid, progress, blocks)
        states, failures = [*states, *more], [*failures, *theirs]
    order = [[*bounded, *others].index(demand) for demand in demands]
    return [states[number] for number in order], failures


def cell_states(
    manipulator: Manipulator, demands: Sequence[Demand], grid: Grid, progress: Progress | None = None
) -> States:
    """The states under demands on measures that have enclosures."""
    search = _Search(manipulator, demands, grid, progress)
    search.run()
    return list(search.states), search.failures()


def _with_enclosures(manipulator: Manipulator, demands: Sequence[Demand], grid: Grid) -> list[Demand]:
    """The demands of whose measures something can be known over a box."""
    middle = _Cells.all_of(grid.shape, 0)
    boxes = replace(middle, first=(middle.first + middle.stop) // 2).boxes(grid)
    if _margins(manipulator, boxes) is None:
        return []
    return [demand for demand in demands if _enclosed(manipulator, demand, boxes) is not None]


@dataclass(frozen=True)
class _Cells:
    """Nodes ``first`` ... ``stop`` − 1 along each axis, (n, d) each."""

    first: NDArray[np.intp]
    stop: NDArray[np.intp]
    inside: Flags
    """Which are known to be in reach (n,)."""
    open: Flags
    """Which demands are not decided in which cell (n, demands)."""

    @classmethod
    def all_of(cls, shape: tuple[int, ...], demands: int) -> _Cells:
        """One cell of all nodes, of which nothing is known."""
        first, stop = np.zeros((1, len(shape)), dtype=np.intp), np.array([shape], dtype=np.intp)
        return cls(first, stop, np.zeros(1, dtype=bool), np.ones((1, demands), dtype=bool))

    def __len__(self) -> int:
        return len(self.first)

    def __getitem__(self, chosen: Flags | slice) -> _Cells:
        return _Cells(self.first[chosen], self.stop[chosen], self.inside[chosen], self.open[chosen])

    @property
    def nodes(self) -> int:
        """How many nodes all of them have."""
        return int(np.prod(self.stop - self.first, axis=1).sum())

    def slices(self, cell: int) -> tuple[slice, ...]:
        """Where the nodes of one cell stand in an array of all nodes."""
        ends = zip(self.first[cell].tolist(), self.stop[cell].tolist(), strict=True)
        return tuple(slice(first, stop) for first, stop in ends)

    def halves(self, edge: int) -> _Cells:
        """Each in two along each axis, of which the first has ``edge`` nodes and the second what is left."""
        d = self.first.shape[1]
        ways = np.stack(np.meshgrid(*[[0, edge]] * d, indexing="ij"), axis=-1).reshape(-1, d)
        first = (self.first[:, None] + ways).reshape(-1, d)
        inside, open_ = (np.repeat(flags, len(ways), axis=0) for flags in (self.inside, self.open))
        ends = np.repeat(self.stop, len(ways), axis=0)
        return _Cells(first, np.minimum(first + edge, ends), inside, open_)[(first < ends).all(axis=1)]

    def boxes(self, grid: Grid) -> Boxes:
        """What they span, from their first to their last nodes."""
        lo, hi = np.zeros((len(self), grid.coordinates)), np.zeros((len(self), grid.coordinates))
        for k in range(len(grid.shape)):
            axis = grid.axis(k)
            lo[:, k], hi[:, k] = axis[self.first[:, k]], axis[self.stop[:, k] - 1]
        return Boxes(lo, hi)

    def nodes_along(self, k: int) -> NDArray[np.intp]:
        """Indices of the nodes along axis k (n, `FINEST`); where a cell is shorter, its last node again."""
        nodes = self.first[:, k, None] + np.arange(FINEST)
        return np.asarray(np.minimum(nodes, self.stop[:, k, None] - 1))


class _Search:
    """The states under demands on measures that have enclosures."""

    def __init__(
        self, manipulator: Manipulator, demands: Sequence[Demand], grid: Grid, progress: Progress | None
    ) -> None:
        self._manipulator, self._demands, self._grid, self._progress = manipulator, demands, grid, progress
        self.states = np.full((len(demands), *grid.shape), State.UNREACHABLE, dtype=np.uint8)
        measures = [demand.measure for demand in demands]
        self._owners = [demand for k, demand in enumerate(demands) if demand.measure not in measures[:k]]
        """One demand on each distinct measure."""
        self._on = np.array([[measure == owner.measure for measure in measures] for owner in self._owners])
        """Which demands are on the measure of which owner (owners, demands)."""
        self._failed_at: dict[str, int] = {}
        self._done = 0

    def run(self) -> None:
        """Find all states."""
        edge = FINEST
        while edge < max(self._grid.shape):
            edge *= 2
        cells = _Cells.all_of(self._grid.shape, len(self._demands))
        while edge > FINEST:
            edge //= 2
            cells = cells.halves(edge)
            if edge <= COARSEST:
                cells = _joined([cells[:0], *self._left(cells)])
        self._measure(cells)

    def failures(self) -> list[Failure]:
        """The first node at which each measure failed."""
        return failures_at(self._failed_at, self._demands, self._grid)

    def _left(self, cells: _Cells) -> Iterator[_Cells]:
        """The cells in which something is open yet; of the others the states are noted."""
        for first in range(0, len(cells), BATCH):
            some = cells[first : first + BATCH]
            reached = self._reached(some)
            parts = [reached[~reached.inside]]
            inside = reached[reached.inside]
            parts += [self._bounded(inside[rows], needed) for needed, rows in _alike(self._needed(inside))]
            self._tell(some.nodes - sum(part.nodes for part in parts))
            yield from parts

    def _reached(self, cells: _Cells) -> _Cells:
        """The cells that are not wholly out of reach, as all states are at first."""
        unknown = ~cells.inside
        margins = _margins(self._manipulator, cells[unknown].boxes(self._grid)) if unknown.any() else None
        if margins is None:
            return cells
        inside, out = cells.inside.copy(), np.zeros(len(cells), dtype=bool)
        inside[unknown] = np.all([margin.lo > CLEAR for margin in margins], axis=0)
        out[unknown] = np.any([margin.hi < -CLEAR for margin in margins], axis=0)
        return replace(cells, inside=inside)[~out]

    def _needed(self, cells: _Cells) -> Flags:
        """The measures of which owners are needed in which cell (n, owners)."""
        return np.asarray((cells.open[:, None, :] & self._on).any(axis=2))

    def _bounded(self, cells: _Cells, needed: Flags) -> _Cells:
        """Of cells in reach those that bounds on the needed measures leave open."""
        boxes, left = cells.boxes(self._grid), cells.open.copy()
        for k in np.flatnonzero(needed).tolist():
            ends = _enclosed(self._manipulator, self._owners[k], boxes)
            if ends is None:
                continue
            for number in np.flatnonzero(self._on[k]).tolist():
                meets, violates = _decided(self._demands[number], ends)
                for cell in np.flatnonzero((meets | violates) & left[:, number]).tolist():
                    state = State.MEETS if meets[cell] else State.VIOLATES
                    self.states[number][cells.slices(cell)] = state
                    left[cell, number] = False
        return replace(cells, open=left)[np.asarray(left.any(axis=1))]

    def _measure(self, cells: _Cells) -> None:
        """Measure the nodes of all cells, those together in which the same measures are needed."""
        several = max(1, BLOCK // FINEST ** len(self._grid.shape))
        for pattern, rows in _alike(np.column_stack([cells.inside, self._needed(cells)])):
            alike = cells[rows]
            for first in range(0, len(alike), several):
                some = alike[first : first + several]
                self._measure_nodes(some, pattern[1:])
                self._tell(some.nodes)

    def _measure_nodes(self, cells: _Cells, needed: Flags) -> None:
        poses = _poses(self._grid, cells)
        reachable = np.ones(len(poses), dtype=bool)
        if not cells.inside.all():
            reachable = np.asarray(self._manipulator.inverse_kinematics(poses)[1])
        inside = poses if reachable.all() else poses[reachable]
        inside.flags.writeable = False
        for k in np.flatnonzero(needed).tolist() if len(inside) else ():
            values = measured(self._owners[k], self._manipulator, inside)
            for number in np.flatnonzero(self._on[k]).tolist():
                self._note(cells, self._demands[number], number, reachable, values)

    def _note(self, cells: _Cells, demand: Demand, number: int, reachable: Flags, values: Array) -> None:
        """The states of measured nodes, and the first that failed."""
        states = np.full(len(reachable), State.UNREACHABLE, dtype=np.uint8)
        states[reachable] = judged(demand, values)
        shape = (len(cells), *[FINEST] * len(self._grid.shape))
        found = states.reshape(shape)
        for cell in np.flatnonzero(cells.open[:, number]).tolist():
            extent = tuple(slice(0, n) for n in cells.stop[cell] - cells.first[cell])
            self.states[number][cells.slices(cell)] = found[cell][extent]
        if failed(values).any():
            which, *places = np.unravel_index(np.flatnonzero(states == State.FAILED), shape)
            nodes = tuple(cells.nodes_along(k)[which, place] for k, place in enumerate(places))
            first = int(np.ravel_multi_index(nodes, self._grid.shape).min())
            self._failed_at[demand.name] = min(first, self._failed_at.get(demand.name, first))

    def _tell(self, nodes: int) -> None:
        self._done += nodes
        if self._progress is not None and nodes:
            self._progress("grid", self._done, self._grid.nodes)


def _joined(parts: Sequence[_Cells]) -> _Cells:
    names = ("first", "stop", "inside", "open")
    return _Cells(*(np.concatenate([getattr(part, name) for part in parts]) for name in names))


def _alike(flags: Flags) -> Iterator[tuple[Flags, Flags]]:
    """Each distinct row of flags (n, m), and which rows are equal to it (n,)."""
    for row in np.unique(flags, axis=0):
        yield row, (flags == row).all(axis=1)


def _poses(grid: Grid, cells: _Cells) -> Poses:
    """Poses of the nodes of cells, each filled up to `FINEST` nodes along each axis."""
    d = len(grid.shape)
    poses = np.zeros((len(cells), *[FINEST] * d, grid.coordinates))
    for k in range(d):
        coordinates = grid.axis(k)[cells.nodes_along(k)]
        poses[..., k] = coordinates.reshape(len(cells), *(FINEST if k == axis else 1 for axis in range(d)))
    return poses.reshape(-1, grid.coordinates)


def _margins(manipulator: Manipulator, boxes: Boxes) -> list[Interval] | None:
    """Bounds on all margins of the reach; None where nothing is known."""
    try:
        margins = list(manipulator.reach_enclosure(boxes).values())
    except RAISED:  # As in a proof, which tells why: here the nodes are measured instead.
        return None
    return margins or None


def _enclosed(manipulator: Manipulator, demand: Demand, boxes: Boxes) -> Interval | None:
    """Bounds on a demand's measure, shaped as its values; None where nothing is known."""
    try:
        return demand.enclosure(manipulator, boxes)
    except RAISED:  # As in a proof, which tells why: here the nodes are measured instead.
        return None


def _decided(demand: Demand, ends: Interval) -> tuple[Flags, Flags]:
    """In which boxes all poses meet the bounds, and in which all violate them (n,) each."""
    whole = ~(np.isnan(ends.lo) | np.isnan(ends.hi)).reshape(len(ends.lo), -1)
    known: Flags = np.all(whole, axis=1)
    meets, violates = known.copy(), np.zeros_like(known)
    for side, bound in demand.bounds.items():
        sign = 1.0 if side == "at_most" else -1.0
        lo, hi = bounded_side(ends.lo, side), bounded_side(ends.hi, side)
        clear = CLEAR * (abs(bound) or np.maximum(np.abs(lo), np.abs(hi)))
        nearest, farthest = (lo, hi) if side == "at_most" else (hi, lo)
        meets &= sign * (farthest - bound) < -clear
        violates |= known & (sign * (nearest - bound) > clear)
    return meets, violates

"""A design's field in slabs of nodes: each is kept as soon as it is there, and a large field is shared out.

Whoever computes a slab, its bytes are the same; what follows goes by the numbers of its nodes.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from orthospec.optimise.kept_fields import KeptFields
from orthospec.optimise.space import DesignSpace
from orthospec.optimise.tasks import Task, machine_and_measures
from orthospec.optimise.workers import Here
from orthospec.workspace.field import BLOCK, Block, measured_blocks
from orthospec.workspace.grid import Grid, make_grid

if TYPE_CHECKING:
    from orthospec.arrays import Array
    from orthospec.manipulators import Manipulator
    from orthospec.measures import Demand
    from orthospec.workspace.field import Progress

SLAB = 4 * BLOCK
"""Nodes to a slab: about 0.1 s of work, for a megabyte or two that cost 4 ms to be fetched and judged."""
WORTH_SHARING = 3.0
"""Seconds that the rest of a field must take, by one slab of it, before others are asked to help.

Processes begin in one or two seconds, and two of them save half of what is left at most.
"""
MOST_KEPT = 1 << 25
"""Fields of more nodes are not kept: one number a node would fill a quarter of a folder."""


@dataclass(frozen=True)
class Slab:
    """Measures of a design at the nodes start ... stop − 1."""

    design: tuple[float, ...]
    """Values of the variables, in the spec's order."""
    measures: tuple[str, ...]
    grid: Grid
    start: int
    stop: int


def measure_slab(space: DesignSpace, slab: Slab, progress: Progress | None = None) -> Block:  # noqa: ARG001
    """The measures at the nodes of a slab, in blocks that stay near the processor."""
    design = space.spec.design(dict(zip(space.spec.variables, slab.design, strict=True)))
    demands = [demand for demand in design.demands if demand.name in slab.measures]
    blocks = list(measured_blocks(design.manipulator, demands, slab.grid, None, slab.start, slab.stop))
    reachable = np.concatenate([block.reachable for block in blocks])
    return Block(slab.start, reachable, {name: _joined(name, blocks) for name in slab.measures})


def _joined(name: str, blocks: Sequence[Block]) -> Array:
    """A measure's values, block after block; where nothing is in reach their shape is not known."""
    parts = [block.values[name] for block in blocks if len(block.values[name])]
    return np.concatenate(parts) if parts else np.empty(0)


SLABS = Task("grid", measure_slab, machine_and_measures)


@dataclass(frozen=True)
class Slabs:
    """The field of a design, as `node_states` and `fields` ask for it: `space` tells who helps and keeps."""

    space: DesignSpace
    design: tuple[float, ...]

    def __call__(
        self,
        manipulator: Manipulator,  # noqa: ARG002  # made anew wherever a slab is measured
        demands: Sequence[Demand],
        grid: Grid,
        progress: Progress | None = None,
    ) -> Iterator[Block]:
        """What is kept first, then the rest as it is completed."""
        names = tuple(demand.name for demand in demands)
        kept = self._kept if grid.nodes <= MOST_KEPT else None
        left, done = [], 0
        for start in range(0, grid.nodes, SLAB):
            slab = Slab(self.design, names, grid, start, min(start + SLAB, grid.nodes))
            known = [] if kept is None else _known(kept, slab)
            yield from known
            missing = tuple(name for name in names if all(name not in block.values for block in known))
            if missing or not names:
                left.append(replace(slab, measures=missing))
            else:
                done = _told(progress, done + slab.stop - slab.start, grid)
        if self.space.cache is not None and grid.nodes > SLAB:
            self.space.cache.count(len(range(0, grid.nodes, SLAB)), len(left))
        for block in self._measured(left, progress):
            if kept is not None:
                kept.write(block, grid)
            yield block
            done = _told(progress, done + len(block.reachable), grid)
        if self.space.cache is not None and grid.nodes > SLAB:
            # A sweep makes field after field: they may not fill the disk before its end.
            self.space.cache.trim(kind=".field")

    def grid(self, manipulator: Manipulator) -> Grid:
        """The grid of the spec's workspace."""
        if self._kept is not None:
            return self._kept.grid(manipulator)
        setting = self.space.setting
        return make_grid(manipulator, setting.size, setting.divisions, setting.region)

    @cached_property
    def _kept(self) -> KeptFields | None:
        cache = self.space.cache
        return None if cache is None else KeptFields(cache, self.space, self.design)

    def _measured(self, slabs: Sequence[Slab], progress: Progress | None) -> Iterator[Block]:
        """The slab in the middle here; the others by those who help, where it is worth their while."""
        # The first slabs are mostly out of reach, and tell nothing of the time that the others take.
        middle = len(slabs) // 2
        begin = time.perf_counter()
        here = [measure_slab(self.space, slab) for slab in slabs[middle : middle + 1]]
        seconds = time.perf_counter() - begin
        yield from here
        rest = [*slabs[:middle], *slabs[middle + 1 :]]
        helpers = self.space.helpers if seconds * len(rest) > WORTH_SHARING else None
        # Many helpers are faster than this process takes their slabs: no more may wait than a kept field has.
        several = max(1, MOST_KEPT // SLAB)
        for first in range(0, len(rest), several):
            some = rest[first : first + several]
            for _, block in (helpers or Here()).each(SLABS, self.space, some, progress):
                yield block


def _known(kept: KeptFields, slab: Slab) -> list[Block]:
    """Each measure of a slab that is kept."""
    found = (kept.read(measure, slab.grid, slab.start, slab.stop) for measure in slab.measures)
    return [block for block in found if block is not None]


def _told(progress: Progress | None, done: int, grid: Grid) -> int:
    if progress is not None:
        progress("grid", done, grid.nodes)
    return done

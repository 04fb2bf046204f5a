"""The states of a design's grid; a large one is cut across its first axis, and its parts are shared out.

Whoever finds the states of a part, they are the same bytes; of several failures the first node's is told.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from orthospec.optimise.slabs import WORTH_SHARING, Slabs
from orthospec.optimise.space import DesignSpace
from orthospec.optimise.tasks import Task, machine_and_measures
from orthospec.optimise.workers import Here
from orthospec.workspace.cells import States, cell_states, grid_states
from orthospec.workspace.grid import Grid

if TYPE_CHECKING:
    from orthospec.manipulators import Manipulator
    from orthospec.measures import Demand
    from orthospec.workspace.field import Progress

PART = 1 << 21
"""Nodes to a part: some 0.1 to 1 s of work, for a byte a node and bound that has to be fetched."""


@dataclass(frozen=True)
class Part:
    """Some planes of a grid, and what is asked of a design there."""

    design: tuple[float, ...]
    """Values of the variables, in the spec's order."""
    bounds: tuple[tuple[str, tuple[tuple[str, float], ...]], ...]
    """Measures by name, each with the bounds of one state."""
    grid: Grid


def part_states(space: DesignSpace, part: Part, progress: Progress | None = None) -> States:
    """The states of one part."""
    design = space.spec.design(dict(zip(space.spec.variables, part.design, strict=True)))
    demands = {demand.name: demand for demand in design.demands}
    asked = [replace(demands[name], bounds=dict(bounds), levels=()) for name, bounds in part.bounds]
    return cell_states(design.manipulator, asked, part.grid, progress)


PARTS = Task("grid", part_states, machine_and_measures)


@dataclass(frozen=True)
class GridStates:
    """`grid_states` of a design; ``space`` tells who helps, and where values of some measures are kept."""

    space: DesignSpace
    design: tuple[float, ...]

    def __call__(
        self,
        manipulator: Manipulator,
        demands: Sequence[Demand],
        grid: Grid,
        progress: Progress | None = None,
    ) -> States:
        """The states under each demand alone, and the first failure of each measure."""
        by_cells = cell_states if self.space.helpers is None else self._shared
        slabs = Slabs(self.space, self.design)
        return grid_states(manipulator, demands, grid, progress, slabs, by_cells)

    def _shared(
        self,
        manipulator: Manipulator,  # noqa: ARG002  # made anew wherever a part is done
        demands: Sequence[Demand],
        grid: Grid,
        progress: Progress | None,
    ) -> States:
        """The part in the middle here; the others by those who help, where it is worth their while."""
        bounds = tuple((demand.name, tuple(demand.bounds.items())) for demand in demands)
        parts = [Part(self.design, bounds, part) for part in _cut(grid)]
        # The first parts are mostly out of reach, and tell nothing of the time that the others take.
        middle = len(parts) // 2
        begin = time.perf_counter()
        found = {middle: part_states(self.space, parts[middle])}
        seconds = time.perf_counter() - begin
        rest = [number for number in range(len(parts)) if number != middle]
        helpers = self.space.helpers if seconds * len(rest) > WORTH_SHARING else None
        done = parts[middle].grid.nodes
        for k, made in (helpers or Here()).each(PARTS, self.space, [parts[number] for number in rest]):
            found[rest[k]] = made
            done += parts[rest[k]].grid.nodes
            if progress is not None:
                progress("grid", done, grid.nodes)
        several = [found[number] for number in range(len(parts))]
        states = [np.concatenate(planes) for planes in zip(*(one for one, _ in several), strict=True)]
        failures = {failure.measure: failure for _, some in reversed(several) for failure in some}
        order = dict.fromkeys(demand.name for demand in demands)
        return states, [failures[name] for name in order if name in failures]


def _cut(grid: Grid) -> list[Grid]:
    """Parts of some planes each, of about `PART` nodes."""
    planes = max(1, PART // max(1, grid.nodes // grid.shape[0]))
    return [
        replace(
            grid,
            first=(grid.first[0] + start, *grid.first[1:]),
            shape=(min(planes, grid.shape[0] - start), *grid.shape[1:]),
        )
        for start in range(0, grid.shape[0], planes)
    ]

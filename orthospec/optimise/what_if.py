"""What moved bounds would do to the cuboids of one design, on the grid, where its measures are kept.

With the values at the nodes in hand a bound is a comparison, and the largest cube of indices one pass.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import reduce
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from orthospec.errors import UsageError
from orthospec.kernels import largest_cube
from orthospec.measures import Demand
from orthospec.optimise.slabs import Slabs
from orthospec.optimise.space import DesignSpace
from orthospec.optimise.tasks import Task, machine_and_measures
from orthospec.optimise.workers import Here, Workers, in_order
from orthospec.quantities.fields import resolve
from orthospec.spec import Design, Spec
from orthospec.spec.asked import never_met
from orthospec.workspace.field import Block, failed
from orthospec.workspace.grid import Grid

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from orthospec.workspace.field import Progress

_Key: TypeAlias = tuple[object, ...]
_Masks: TypeAlias = "dict[_Key, NDArray[np.bool_]]"


@dataclass(frozen=True)
class Moved:
    """A bound, as the spec has it (None: it has none) and as it is asked for."""

    measure: str
    side: str
    before: float | None
    after: float


@dataclass(frozen=True)
class Change:
    """A scale of the largest cuboid, on the grid alone."""

    before: float
    after: float


@dataclass(frozen=True)
class Answer:
    """What all moves together come to."""

    moved: tuple[Moved, ...]
    joint: Change | None
    """Of all measures; None where each has a cuboid of its own."""
    measures: Mapping[str, Change]
    """Of each measure that is moved, alone."""


@dataclass(frozen=True)
class Known:
    """A design's measures on the grid, for any number of questions; scales that were told are remembered."""

    spec: Spec
    design: Design
    grid: Grid
    blocks: tuple[Block, ...]
    """Each measure at each node once."""
    scales: dict[tuple[_Key, ...], float] = field(default_factory=dict)

    def answer(self, moves: Sequence[Moved]) -> Answer:
        """The cuboids before and after."""
        before = {demand.name: demand for demand in self.design.demands}
        after = dict(before)
        for move in moves:
            here = after[move.measure]
            after[move.measure] = replace(here, bounds={**here.bounds, move.side: move.after})
        names = dict.fromkeys(move.measure for move in moves)
        masks: _Masks = {}
        alone = {name: self._change([before[name]], [after[name]], masks) for name in names}
        together = self.spec.workspace.together
        joint = self._change(list(before.values()), list(after.values()), masks) if together else None
        return Answer(tuple(moves), joint, alone)

    def _change(self, before: Sequence[Demand], after: Sequence[Demand], masks: _Masks) -> Change:
        return Change(self._scale(before, masks), self._scale(after, masks))

    def _scale(self, demands: Sequence[Demand], masks: _Masks) -> float:
        """The grid's metric where all demands are met; ``masks`` has what each comes to, once found."""
        keys = tuple((demand.name, *sorted(demand.bounds.items())) for demand in demands)
        if keys not in self.scales:
            for key, demand in zip(keys, demands, strict=True):
                if key not in masks:
                    masks[key] = self._met(demand)
            met = reduce(np.logical_and, [masks[key] for key in keys])
            edge = largest_cube(met.reshape(self.grid.shape))
            self.scales[keys] = max(edge - 1, 0) / self.spec.workspace.divisions
        return self.scales[keys]

    def _met(self, demand: Demand) -> NDArray[np.bool_]:
        """Whether each node meets a demand, (nodes,)."""
        met = np.zeros(self.grid.nodes, dtype=bool)
        for block in self.blocks:
            if demand.name in block.values:
                values = block.values[demand.name]
                met[block.nodes][block.reachable] = demand.meets(values) & ~failed(values)
        return met


def know(
    spec: Spec,
    values: Mapping[str, float],
    *,
    progress: Progress | None = None,
    workers: Workers | None = None,
) -> Known:
    """The measures of a design on the spec's grid: as they are kept, else computed."""
    space, design = DesignSpace(spec), spec.design(values)
    one = tuple(design.values.values())
    ((grid, blocks),) = in_order(workers or Here(), FIELD, space, [one], progress)
    return Known(spec, design, grid, blocks)


def _field(
    space: DesignSpace, values: tuple[float, ...], progress: Progress | None = None
) -> tuple[Grid, tuple[Block, ...]]:
    """The grid of a design, and all its measures there."""
    design = space.spec.design(dict(zip(space.spec.variables, values, strict=True)))
    slabs = Slabs(space, values)
    grid = slabs.grid(design.manipulator)
    return grid, tuple(slabs(design.manipulator, design.demands, grid, progress))


FIELD = Task("grid", _field, machine_and_measures, keeps_parts=True, divides=True)


def read_moves(spec: Spec, values: Mapping[str, float], texts: Sequence[str]) -> tuple[Moved, ...]:
    """The moves in ``transmission.at_most=2.2``; UsageError for what is none, or what no machine meets."""
    demands = {demand.name: demand for demand in spec.design(values).demands}
    moves = tuple(_read(demands, values, text) for text in texts)
    uses = {plan.name: plan.blueprint.use for plan in spec.measures}
    for text, move in zip(texts, moves, strict=True):
        made_of = type(demands[move.measure].measure)
        why = never_met(uses[move.measure], made_of, move.after) if move.side == "at_most" else ""
        if why:
            raise UsageError(f"--what-if {text}: {why}")
    return moves


def _read(demands: Mapping[str, Demand], values: Mapping[str, float], text: str) -> Moved:
    key, _, value = text.partition("=")
    name, _, side = key.strip().rpartition(".")
    if name not in demands or not value.strip():
        known = ", ".join(demands) or "none"
        raise UsageError(f"--what-if {text}: MEASURE.SIDE=VALUE was expected; the measures are {known}")
    demand = demands[name]
    if side not in demand.measure.sides:
        known = " and ".join(sorted(demand.measure.sides))
        raise UsageError(f"--what-if {text}: {name} has no '{side}'; it knows {known}")
    try:
        after = resolve(value.strip(), demand.measure.unit, values)
    except ValueError as error:
        raise UsageError(f"--what-if {text}: {error}") from None
    return Moved(name, side, demand.bounds.get(side), after)

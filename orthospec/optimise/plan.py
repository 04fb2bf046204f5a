"""What a run of a spec would do, without doing it: its grids, its search, what is told beside, what is kept.

All that follows from the spec is exact. A time is told of the grid alone, from some of its poses measured
here; how long a search or a proof takes is not known before.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from orthospec import registry
from orthospec.errors import UnbuildableDesign
from orthospec.optimise.appraise import APPRAISE, asked
from orthospec.optimise.branch import MOST, every_choice
from orthospec.optimise.cache import kept_of
from orthospec.optimise.explore import MEASURE, candidates, coarse_grid
from orthospec.optimise.hunt import KEPT, REFINED
from orthospec.optimise.lattice import shares_of
from orthospec.optimise.meet import soft_goals
from orthospec.optimise.space import DesignSpace, machine_of
from orthospec.spec import Design, Spec
from orthospec.workspace.field import BLOCK, measured
from orthospec.workspace.grid import Grid, make_grid

if TYPE_CHECKING:
    from orthospec.arrays import Poses

PIECES = 32
"""Places all over the grid from which poses are taken."""


@dataclass(frozen=True)
class Timed:
    """Poses all over a grid, measured once here."""

    poses: int
    seconds: float

    def of(self, grid: Grid) -> float:
        """What the whole grid would take at this pace [s]."""
        return self.seconds * grid.nodes / self.poses


@dataclass(frozen=True)
class Searching:
    """What is searched, where there are variables."""

    combinations: int
    """Of the catalogues' choices; 1 without catalogues."""
    branches: int
    """How many of them are searched; more are first screened on the coarse grid."""
    starts: int
    """Designs on the coarse grid, in each branch."""
    refined: int
    """Most of them that are refined."""
    solved: int
    """Most places from which it is solved to the end."""
    coarse: Grid


@dataclass(frozen=True)
class Plan:
    """What would be done."""

    design: Design
    """Where the search begins: the grids are of this one."""
    grid: Grid
    memory: int
    """Bytes that the grid's nodes take, beside a block of poses at work."""
    timed: Timed
    searching: Searching | None
    proofs: int
    """Most cuboids of one design over which something is proved; 0: nothing is."""
    front: int
    """Most designs of a Pareto set; 0: none is asked for."""
    plugins: tuple[registry.Installed, ...]
    kept: int
    """Of ``steps``, how many were done already."""
    steps: int
    """The first of the run's steps: the starts, or the one design."""


def plan(spec: Spec, cache: Path | None = None) -> Plan:
    """The plan of a run.

    Raises what the run would raise at its beginning: UsageError for a grid that is too large or a reach
    without an end, PluginFault for a measure that fails on the poses tried.
    """
    design, searching, kept, steps = _begin(spec, cache)
    setting = DesignSpace(spec).setting
    grid = make_grid(design.manipulator, setting.size, setting.divisions, setting.region)
    return Plan(
        design=design,
        grid=grid,
        memory=_memory(design, grid),
        timed=timed(design, grid),
        searching=searching,
        proofs=_proofs(spec, design) if spec.proof is not None else 0,
        front=0 if spec.pareto is None else len(shares_of(len(soft_goals(spec)), spec.pareto)),
        plugins=spec.plugins,
        kept=kept,
        steps=steps,
    )


def _begin(spec: Spec, cache: Path | None) -> tuple[Design, Searching | None, int, int]:
    """The first design, the search, and how many of its first steps are kept."""
    space = DesignSpace(spec)
    if not spec.variables:
        design = spec.design({})
        kept = kept_of(cache, APPRAISE, space, [asked(design, spec.workspace.divisions)])
        return design, None, kept, 1
    every = every_choice(spec)
    branches = [DesignSpace(spec.chosen(choice)) for choice in every[:MOST]]
    starts = [[tuple(map(float, z)) for z in candidates(branch)] for branch in branches]
    kept = sum(kept_of(cache, MEASURE, branch, some) for branch, some in zip(branches, starts, strict=True))
    design = _first(branches[0], starts[0])
    number = len(starts[0])
    refined = min(number, max(REFINED, number // 2))
    coarse = coarse_grid(machine_of(design), space.setting)
    searching = Searching(len(every), len(branches), number, refined, min(refined, KEPT), coarse)
    # Which of many combinations are searched is not known before they are screened.
    known = len(every) <= MOST
    return design, searching, kept if known else 0, number * len(branches) if known else 0


def _first(space: DesignSpace, starts: Sequence[tuple[float, ...]]) -> Design:
    """The spec's own start, or the first other one that can be built."""
    refused: UnbuildableDesign | None = None
    for z in starts:
        try:
            return space.design(np.array(z))
        except UnbuildableDesign as error:
            refused = refused or error
    assert refused is not None
    raise refused


def _memory(design: Design, grid: Grid) -> int:
    """A byte a node for each bound and level; and of one at a time its mask, its bits, where cubes end."""
    states = sum(bool(demand.bounds) + len(demand.levels) for demand in design.demands)
    return grid.nodes * (max(states, 1) + 3)


def timed(design: Design, grid: Grid) -> Timed:
    """The measures at poses all over the grid; the second time counts, when all is loaded."""
    piece = max(1, min(BLOCK, grid.nodes) // PIECES)
    firsts = np.unique(np.linspace(0, max(grid.nodes - piece, 0), PIECES).astype(int))
    poses = np.concatenate([grid.poses(int(first), int(first) + piece) for first in firsts])
    seconds = [_measure(design, poses.copy()) for _ in range(2)]
    return Timed(len(poses), min(seconds))


def _measure(design: Design, poses: Poses) -> float:
    begin = time.perf_counter()
    reachable = np.asarray(design.manipulator.inverse_kinematics(poses)[1])
    inside = poses[reachable]
    for demand in design.demands:
        if len(inside):
            measured(demand, design.manipulator, inside)
    return time.perf_counter() - begin


def _proofs(spec: Spec, design: Design) -> int:
    """Cuboids that a result tells of one design: prescribed and largest ones, and those of levels."""
    bounded = sum(bool(demand.bounds) for demand in design.demands)
    levels = sum(len(demand.levels) for demand in design.demands)
    if spec.workspace.together or not bounded:
        return 2 + (bounded if bounded > 1 else 0) + levels
    return 2 * bounded + levels

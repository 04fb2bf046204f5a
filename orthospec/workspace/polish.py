"""Polish: from the grid's cuboid to the largest one, continuous in size and place.

Maximises μ over (μ, centre) of one design, by the same trust region as the goals. It can shrink as well as
grow: a grid under-reports by up to two steps, and may over-report between its nodes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from orthospec.composite.trust_region import FEASIBLE, minimise
from orthospec.workspace.conditions import Extreme
from orthospec.workspace.cuboid import Cuboid
from orthospec.workspace.fit import FitProblem, Group
from orthospec.workspace.layout import Limits, Point
from orthospec.workspace.machine import Machine

if TYPE_CHECKING:
    from orthospec.arrays import Array


@dataclass(frozen=True)
class LargestScale:
    """The objective −μ."""

    extremes: tuple[Extreme, ...] = ()
    reversed: frozenset[Extreme] = frozenset()

    @property
    def on_factor(self) -> Array:
        """One soft row."""
        return np.ones(1)

    @property
    def on_slack(self) -> Array:
        """No hard row."""
        return np.zeros(1)

    def rows(self, machine: Machine, point: Point) -> Array:  # noqa: ARG002
        """−μ."""
        return np.array([-point.scale])


@dataclass(frozen=True)
class Polished:
    """The largest cuboid found, and its scale."""

    scale: float
    cuboid: Cuboid


def polish(
    machine: Machine,
    names: Sequence[str],
    size: Array,
    starts: Sequence[Cuboid],
    region: Cuboid | None = None,
) -> Polished | None:
    """The largest cuboid in which the named demands and the reach hold, from the best of these starts.

    None where no start led to one. Error below 1e-6 of the size where the measures are smooth.
    """
    best: Polished | None = None
    none = np.zeros(0)
    for start in starts:
        scale = float(np.max(start.size / size))
        # A start of one node is given some room, or no direction would change anything.
        first = max(scale, 1e-3)
        limits = Limits((none, none), region, scale=(1e-9, max(1e3, 10 * first)))
        group = Group(tuple(names), tuple(start.centre))
        problem = FitProblem(lambda _: machine, size, [group], LargestScale(), limits, (none, first))
        found = minimise(problem, problem.start)
        if found.violation <= FEASIBLE and (best is None or -found.factor > best.scale):
            best = Polished(-found.factor, problem.cuboids(found.x)[0])
    return best

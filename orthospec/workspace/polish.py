"""Polish: from the grid's cuboid to the largest one, continuous in size and place.

Maximises μ over (μ, centre) of one design, by the same trust region as the goals. It can shrink as well as
grow: a grid under-reports by up to two steps, and may over-report between its nodes.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from orthospec.composite.trust_region import FEASIBLE, Assessment, minimise
from orthospec.workspace.conditions import Extreme
from orthospec.workspace.cuboid import Cuboid
from orthospec.workspace.fit import FitProblem, Group
from orthospec.workspace.forms import Forms
from orthospec.workspace.layout import Limits, Point
from orthospec.workspace.machine import Machine

if TYPE_CHECKING:
    from orthospec.arrays import Array


SMALLEST = 1e-3
"""The scale that a cuboid of a single node is given to start from."""
SHRUNK = (1e-9, 1e-8, 1e-7, 1e-6, 1e-4)
"""Parts by which the last cuboid of a loop is made smaller where it is a hair too large."""
SHRINKINGS = 12
"""How often a start is shrunk."""


@dataclass(frozen=True)
class LargestScale:
    """The objective −μ."""

    extremes: tuple[Extreme, ...] = ()

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
    forms: Forms | None = None,
) -> Polished | None:
    """The largest cuboid in which the named demands and the reach hold, from the best of these starts.

    None where no start led to one. Error below 1e-6 of the size where the measures are smooth. ``forms`` have
    been compiled for others of these measures.
    """
    best: Polished | None = None
    forms = forms or Forms()
    for start in starts:
        for problem in _problems(machine, names, size, start, region, forms):
            found = _grown(problem)
            if found.violation <= FEASIBLE:
                if best is None or -found.factor > best.scale:
                    best = Polished(-found.factor, problem.cuboids(found.x)[0])
                break
    return best


def _grown(problem: FitProblem) -> Assessment:
    """The end of a solve; where that went back to a point before, what is left of its last one if shrunk.

    Next to a singular pose, or with a derivative out of reach, a loop may stop a hair beyond a bound.
    """
    trace: list[Assessment] = []
    found = minimise(problem, problem.start, on_iterate=lambda here, _: trace.append(here))
    best = Assessment(found.x, found.factor, found.violation)
    if not trace or trace[-1].violation <= FEASIBLE or not np.isfinite(trace[-1].violation):
        return best
    point = problem.layout.unpack(trace[-1].x)
    for part in SHRUNK:
        smaller = problem.assess(problem.layout.pack(point._replace(scale=(1 - part) * point.scale)))
        if smaller.violation <= FEASIBLE:
            return smaller if best.violation > FEASIBLE or smaller.factor < best.factor else best
    return best


def _problems(
    machine: Machine, names: Sequence[str], size: Array, start: Cuboid, region: Cuboid | None, forms: Forms
) -> Iterator[FitProblem]:
    """The problem from a grid cuboid; then from the first smaller one in which everything holds.

    The second serves where a singular pose hides between the nodes of the first.
    """
    none = np.zeros(0)
    group = Group(tuple(names), tuple(start.centre))
    # A cuboid of one node is given some room, or no direction would change anything.
    scale = max(float(np.max(start.size / size)), SMALLEST)
    limits = Limits((none, none), region, scale=(1e-9, max(1e3, 10 * scale)))
    for shrinking in range(SHRINKINGS):
        aim, begin = LargestScale(), (none, scale)
        problem = FitProblem(lambda _: machine, size, [group], aim, limits, begin, forms=forms)
        violation = problem.assess(problem.start).violation
        if violation <= FEASIBLE or (shrinking == 0 and np.isfinite(violation)):
            yield problem
        if shrinking and violation <= FEASIBLE:
            return
        scale *= 0.7

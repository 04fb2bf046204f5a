"""The Pareto set of two or three goals: designs none of which is better than another in all of them.

Its ends are each goal alone, searched as any problem. Between them lie reference points P, evenly spread over
the line or plane through the ends; from each the set is met along the normal of that plane in scaled goals
(Das and Dennis, *SIAM J. Optim.* 8, 1998), by goal attainment:

    minimise λ    subject to    F_i − λ r_i <= P_i,

F_i the gap of goal i and r_i its range between the ends. As inequalities they lead to points of the set also
where it has gaps or is not convex: several P may then come to one point, and fewer points are told.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import count
from typing import TYPE_CHECKING

import numpy as np

from orthospec.optimise.attain import FINISH, Attained, attain
from orthospec.optimise.hunt import hunt
from orthospec.optimise.place import Place, fit_at
from orthospec.optimise.space import DesignSpace
from orthospec.optimise.tasks import Task, problem_of
from orthospec.optimise.workers import Workers, in_order
from orthospec.spec import Spec
from orthospec.workspace.evaluate import FINE
from orthospec.workspace.field import Progress

if TYPE_CHECKING:
    from orthospec.arrays import Array

SAME = 1e-6
"""Goals nearer than this, as a part of their range, are one."""
BETTER = 1e-7
"""A neighbour's design that does better than a point by this is where the point is sought again."""
AGAIN = 3
"""How often points are sought again from their neighbours."""

Aims = tuple[tuple[str, float, float], ...]
"""Of each soft goal: its name, by how much easier it is, and its weight."""


@dataclass(frozen=True)
class Sought:
    """A point to look for, and where from."""

    aims: Aims
    place: Place


@dataclass(frozen=True)
class Met:
    """What was met, and the gaps of the spec's soft goals there, in their order."""

    attained: Attained
    gaps: tuple[float, ...]


@dataclass(frozen=True)
class Point:
    """A point of the set."""

    aims: Aims
    met: Met
    is_knee: bool = False

    def space(self, spec: Spec) -> DesignSpace:
        """The problem that the point solves."""
        return _space(spec, self.aims)


def seek(space: DesignSpace, sought: Sought, _: Progress | None = None) -> Met:
    """Meet the set from one place."""
    found = attain(_space(space.spec, sought.aims), sought.place)
    return Met(found, _gaps(space, found.end))


SEEK = Task("points of the Pareto set", seek, problem_of, (Met, *FINISH.makes))


def find_front(spec: Spec, workers: Workers, progress: Progress | None = None) -> tuple[Point, ...]:
    """The set, from the end that is best in the first goal; empty where no design was found."""
    space = DesignSpace(spec)
    names = [plan.name for plan in spec.goals if plan.is_soft]
    ends = [_end(space, name, workers, progress) for name in names]
    known = [end for end in ends if end is not None]
    if len(known) < len(names):
        return ()
    gaps = np.array([end.gaps for end in known])
    ranges = gaps.max(axis=0) - np.diag(gaps)
    if (ranges <= SAME * np.maximum(np.abs(gaps).max(axis=0), 1e-12)).any():
        return (Point(((names[0], 0.0, 1.0),), known[0]),)
    lattice = _Lattice(space, tuple(names), gaps, ranges, _weights(len(names), spec.pareto or 0))
    met = _met(lattice, known, workers, progress)
    return _named(lattice, met)


@dataclass(frozen=True)
class _Lattice:
    """The reference points, by their weights on the ends."""

    space: DesignSpace
    names: tuple[str, ...]
    ends: Array
    """Gaps of the ends, one row each."""
    ranges: Array
    weights: Array
    """(n, goals): whole shares of each end, of equal sum."""

    def reference(self, k: int) -> Array:
        """P of a point."""
        return np.asarray(self.weights[k] @ self.ends / self.weights[k].sum())

    def factor(self, k: int, gaps: Sequence[float]) -> float:
        """λ that gaps come to in the problem of point k."""
        return float(np.max((np.array(gaps) - self.reference(k)) / self.ranges))

    def aims(self, k: int) -> Aims:
        """The aims of a point; an end has one alone."""
        if self.weights[k].max() == self.weights[k].sum():
            at = int(self.weights[k].argmax())
            return ((self.names[at], float(self.ends[at, at]), float(self.ranges[at])),)
        moved = self.reference(k) + self._far(k) * self.ranges
        parts = zip(self.names, moved, self.ranges, strict=True)
        return tuple((name, float(by), float(weight)) for name, by, weight in parts)

    def _far(self, k: int) -> float:
        """How far along the normal the aims stand: λ differs by it, and no goal comes near 0."""
        plain = {plan.name: plan for plan in self.space.spec.goals}
        start = self.space.spec.default_values()
        goals = [plain[name].at(start) for name in self.names]
        signs = np.array([-1.0 if goal.sense == "maximise" else 1.0 for goal in goals])
        at = np.array([goal.goal for goal in goals]) + signs * self.reference(k)
        for step in count():
            for far in (float(step), -float(step)):
                if (np.abs(at + signs * far * self.ranges) >= 0.4 * self.ranges).all():
                    return far
        raise AssertionError

    def neighbours(self, k: int) -> list[int]:
        """The points one step away."""
        steps = np.abs(self.weights - self.weights[k]).sum(axis=1)
        return [int(i) for i in np.flatnonzero(steps == 2)]


def _weights(goals: int, points: int) -> Array:
    """All whole shares of one sum, as many as fit into ``points``, but the ends at least."""
    total = max(points - 1, 1)
    if goals == 3:
        total = max(int((np.sqrt(8 * points + 1) - 3) / 2), 1)
    return np.array(sorted(_shares(goals, total), reverse=True), dtype=float)


def _shares(parts: int, total: int) -> Iterator[tuple[int, ...]]:
    if parts == 1:
        yield (total,)
        return
    for first in range(total + 1):
        yield from ((first, *rest) for rest in _shares(parts - 1, total - first))


def _end(space: DesignSpace, name: str, workers: Workers, progress: Progress | None) -> Met | None:
    """The best in one goal, whatever that costs in the others."""
    best = hunt(_space(space.spec, ((name, 0.0, 1.0),)), workers, progress).best
    return None if best is None or not best.feasible else Met(best, _gaps(space, best.end))


def _met(
    lattice: _Lattice, ends: Sequence[Met], workers: Workers, progress: Progress | None
) -> dict[int, Met]:
    """What is met from each reference point: wave by wave from the ends, then again from better ones."""
    met = {int(lattice.weights[:, i].argmax()): end for i, end in enumerate(ends)}
    while wave := _next_to(lattice, met):
        _seek(lattice, wave, met, workers, progress)
    for _ in range(AGAIN):
        again = _worth_another(lattice, met)
        if not again:
            break
        _seek(lattice, again, met, workers, progress)
    return met


def _next_to(lattice: _Lattice, met: dict[int, Met]) -> dict[int, list[int]]:
    """Points not sought yet beside those that were, with the neighbours to begin from."""
    wave = {}
    for k in range(len(lattice.weights)):
        known = [i for i in lattice.neighbours(k) if i in met]
        if k not in met and known:
            wave[k] = known
    return wave


def _worth_another(lattice: _Lattice, met: dict[int, Met]) -> dict[int, list[int]]:
    """Points that a design met elsewhere would serve better, with the best of these."""
    again = {}
    for k, here in met.items():
        factors = {i: lattice.factor(k, other.gaps) for i, other in met.items()}
        best = min(factors, key=lambda i: (factors[i], i))
        if len(lattice.aims(k)) > 1 and factors[best] < lattice.factor(k, here.gaps) - BETTER:
            again[k] = [best]
    return again


def _seek(
    lattice: _Lattice,
    wave: dict[int, list[int]],
    met: dict[int, Met],
    workers: Workers,
    progress: Progress | None,
) -> None:
    """Seek points from where others were met; the best of what each comes to is kept."""
    tries = [(k, start) for k, starts in wave.items() for start in starts]
    items = [Sought(lattice.aims(k), met[start].attained.end) for k, start in tries]
    for (k, _), found in zip(tries, in_order(workers, SEEK, lattice.space, items, progress), strict=True):
        if not found.attained.feasible:
            continue
        if k not in met or lattice.factor(k, found.gaps) < lattice.factor(k, met[k].gaps) - 1e-9:
            met[k] = found
    for k, starts in wave.items():
        met.setdefault(k, met[starts[0]])


def _named(lattice: _Lattice, met: dict[int, Met]) -> tuple[Point, ...]:
    """The points that no other one is better than, each once; the knee stands out furthest from the plane."""
    order = sorted(met)
    gaps = {k: np.array(met[k].gaps) / lattice.ranges for k in order}
    kept: list[int] = []
    for k in order:
        dominated = any((gaps[i] <= gaps[k] + SAME).all() and (gaps[i] < gaps[k] - SAME).any() for i in order)
        known = any(np.abs(gaps[i] - gaps[k]).max() <= SAME for i in kept)
        if not dominated and not known:
            kept.append(k)
    factors = {k: lattice.factor(k, met[k].gaps) for k in kept}
    knee = min(kept, key=lambda k: (round(factors[k], 9), k))
    bulges = factors[knee] < -SAME
    return tuple(Point(lattice.aims(k), met[k], bulges and k == knee) for k in kept)


def _space(spec: Spec, aims: Aims) -> DesignSpace:
    return DesignSpace(spec.aimed({name: (easier, weight) for name, easier, weight in aims}))


def _gaps(space: DesignSpace, place: Place) -> tuple[float, ...]:
    """How far each soft goal of the spec is missed with the design at a place; negative where it is met."""
    fit = fit_at(space, place)
    fit.problem.lattice = FINE
    point = fit.problem.layout.unpack(fit.problem.assess(fit.problem.start).x)
    rows = fit.objective.rows(fit.problem.machine(point.design), point)
    soft = [plan.name for plan in space.spec.goals if plan.is_soft]
    owners = fit.objective.owners
    return tuple(
        max(float(row) for row, owner in zip(rows, owners, strict=True) if owner == name) for name in soft
    )

"""The Pareto set of two or three goals: designs none of which is better than another in all of them.

Its ends are each goal alone, searched as any problem. Between them lie reference points P, evenly spread over
the line or plane through the ends; from each the set is met along the normal of that plane in scaled goals
(Das and Dennis, *SIAM J. Optim.* 8, 1998), by goal attainment:

    minimise λ    subject to    F_i − λ r_i <= P_i,

F_i the gap of goal i and r_i its range between the ends. As inequalities they lead to points of the set also
where it has gaps or is not convex: several P may then come to one point, and fewer points are told.

With catalogues the ends are the best of all branches, and from each P every branch meets its own set: the
least λ is kept. A branch is left out at a P where even what it comes to in each goal alone, all at once,
would be worse than a design of another one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from orthospec.optimise.ends import (
    SAME,
    BranchEnds,
    End,
    agree,
    best_ends,
    best_in_all,
    ranges_of,
    search_branches,
)
from orthospec.optimise.lattice import Lattice, shares_of
from orthospec.optimise.meet import SEEK, Met, Sought, as_aimed, soft_goals, space_of
from orthospec.optimise.space import DesignSpace
from orthospec.optimise.workers import Workers, in_order
from orthospec.result import FrontSearch
from orthospec.spec import Spec
from orthospec.workspace.field import Progress

if TYPE_CHECKING:
    from orthospec.arrays import Array, Flags

BETTER = 1e-7
"""A neighbour's design that does better than a point by this is where the point is sought again."""
AGAIN = 3
"""How often points are sought again from their neighbours."""

Spot: TypeAlias = tuple[int, int]
"""Numbers of a branch and of a reference point."""


@dataclass(frozen=True)
class Point:
    """A point of the set, and the problem that it solves."""

    space: DesignSpace
    met: Met
    is_knee: bool = False


@dataclass(frozen=True)
class Front:
    """The points, from the end that is best in the first goal, and what was searched for them."""

    points: tuple[Point, ...]
    search: FrontSearch


def find_front(spec: Spec, workers: Workers, progress: Progress | None = None) -> Front:
    """The set; empty where no design was found. Ctrl-C is KeyboardInterrupt."""
    names = soft_goals(spec)
    branches, searched = search_branches(spec, workers, progress)
    ends = best_ends(spec, branches, workers, progress)
    if not ends:
        return Front((), FrontSearch(searched, 0, 0))
    if agree(ends):
        one = best_in_all(ends)
        space = space_of(spec, branches[one.branch].choice, one.met.aims)
        return Front((Point(space, one.met),), FrontSearch(searched, 0, 0))
    gaps = np.array([end.met.gaps for end in ends])
    lattice = Lattice(spec, names, gaps, ranges_of(ends), shares_of(len(names), spec.pareto or 0))
    walk = _Walk(lattice, branches, workers, progress)
    walk.go(ends)
    search = FrontSearch(searched, len(walk.met), len(walk.left_out))
    return Front(_named(lattice, branches, walk.best(ends)), search)


@dataclass
class _Walk:
    """Meets the branches' sets from the reference points: in waves from the ends, then from better ones."""

    lattice: Lattice
    branches: Sequence[BranchEnds]
    workers: Workers
    progress: Progress | None
    met: dict[Spot, Met] = field(default_factory=dict)
    left_out: set[Spot] = field(default_factory=set)
    """Where a branch cannot be better than another one."""
    tried: set[Spot] = field(default_factory=set)

    def go(self, ends: Sequence[End]) -> None:
        """From the ends of all branches over all reference points."""
        for b, branch in enumerate(self.branches):
            corners = {(b, self.lattice.corner(i)): end for i, end in enumerate(branch.ends) if end}
            self.met |= corners
        self.met |= {(end.branch, self.lattice.corner(i)): end.met for i, end in enumerate(ends)}
        while wave := self._next():
            self._seek(wave)
        for _ in range(AGAIN):
            again = self._worth_another()
            if not again:
                break
            self._seek(again)

    def best(self, ends: Sequence[End]) -> dict[int, End]:
        """At each reference point the branch with the least λ; of equal ones what is less in sum."""
        found = {self.lattice.corner(i): end for i, end in enumerate(ends)}
        for k in range(len(self.lattice.weights)):
            here = [
                End(b, met) for (b, at), met in sorted(self.met.items(), key=lambda item: item[0]) if at == k
            ]
            if k in found or not here:
                continue
            factors = self.lattice.factors(np.array([one.met.gaps for one in here]))[k]
            tied = [one for one, λ in zip(here, factors, strict=True) if λ <= factors.min() + BETTER]
            found[k] = min(tied, key=lambda one: (self._sum(one), one.branch))
        return found

    def _sum(self, end: End) -> float:
        return round(float(np.sum(np.array(end.met.gaps) / self.lattice.ranges)), 9)

    def _next(self) -> dict[Spot, list[Spot]]:
        """Spots beside those that were dealt with, and where to begin; those that are beaten are left out."""
        while True:
            done = self.met.keys() | self.left_out | self.tried
            beside = [spot for spot in self._all() if spot not in done and self._around(spot, done)]
            beaten = self._beaten()
            out = {spot for spot in beside if beaten[spot]}
            self.left_out |= out
            wave = {spot: self._starts(spot) for spot in beside if spot not in out}
            if wave or not out:
                return wave

    def _all(self) -> list[Spot]:
        return [(b, k) for b in range(len(self.branches)) for k in range(len(self.lattice.weights))]

    def _around(self, spot: Spot, done: set[Spot]) -> list[Spot]:
        """The spots of a branch one step away that are among others."""
        b, k = spot
        near = np.flatnonzero(self.lattice.steps[k] == 1)
        return [(b, int(i)) for i in near if (b, int(i)) in done]

    def _starts(self, spot: Spot) -> list[Spot]:
        """Where the branch was met one step away, or else where it was met nearest."""
        known = [k for b, k in self.met if b == spot[0]]
        away = {k: self.lattice.steps[spot[1], k] for k in sorted(known)}
        return [(spot[0], k) for k, steps in away.items() if steps == min(away.values())]

    def _beaten(self) -> Flags:
        """At which reference points a branch cannot be better than a design of another one (b, n)."""
        floors = self.lattice.factors(np.array([branch.floor for branch in self.branches])).T
        best = np.array([self._factors(b).min(axis=1) for b in range(len(self.branches))])
        others = [np.delete(best, b, axis=0).min(axis=0, initial=np.inf) for b in range(len(best))]
        return np.asarray(np.array(others) < floors - BETTER)

    def _factors(self, b: int) -> Array:
        """λ of all that a branch met, in the order of the reference points, at each of them (n, m)."""
        gaps = [self.met[spot].gaps for spot in sorted(self.met) if spot[0] == b]
        return self.lattice.factors(np.array(gaps))

    def _worth_another(self) -> dict[Spot, list[Spot]]:
        """Spots that a design which their branch met elsewhere would serve better, with the best of these."""
        again = {}
        for b in range(len(self.branches)):
            spots = [spot for spot in sorted(self.met) if spot[0] == b]
            for spot, factors in zip(spots, self._factors(b)[[k for _, k in spots]], strict=True):
                here = factors[spots.index(spot)]
                if not self.lattice.is_end(spot[1]) and factors.min() < here - BETTER:
                    again[spot] = [spots[int(factors.argmin())]]
        return again

    def _seek(self, wave: dict[Spot, list[Spot]]) -> None:
        """Seek points from where others were met; the best of what each comes to is kept."""
        tries = [(spot, start) for spot, starts in wave.items() for start in starts]
        ranges = tuple(map(float, self.lattice.ranges))
        items = [
            Sought(self.branches[b].choice, self.lattice.aims(k), ranges, self.met[start].attained.end)
            for (b, k), start in tries
        ]
        space = DesignSpace(self.lattice.spec)
        for (spot, _), found in zip(
            tries, in_order(self.workers, SEEK, space, items, self.progress), strict=True
        ):
            self.tried.add(spot)
            if found.attained.feasible and (spot not in self.met or self._is_better(spot, found)):
                self.met[spot] = found

    def _is_better(self, spot: Spot, found: Met) -> bool:
        now, before = self.lattice.factors(np.array([found.gaps, self.met[spot].gaps]))[spot[1]]
        return bool(now < before - 1e-9)


def _named(lattice: Lattice, branches: Sequence[BranchEnds], best: dict[int, End]) -> tuple[Point, ...]:
    """The points that no other one is better than, each once; the knee stands out furthest from the plane."""
    kept = _distinct(lattice, {k: np.array(end.met.gaps) for k, end in sorted(best.items())})
    depths = {k: round(lattice.depth(np.array(best[k].met.gaps)), 9) for k in kept}
    knee = min(kept, key=lambda k: (depths[k], k))
    bulges = depths[knee] < -SAME
    return tuple(_point(lattice, branches, best[k], bulges and k == knee) for k in kept)


def _distinct(lattice: Lattice, gaps: dict[int, Array]) -> list[int]:
    """Where what no other one is better than was met; of several places at an end, or with the least λ."""
    scaled = {k: one / lattice.ranges for k, one in gaps.items()}
    factors = {k: round(float(lattice.factors(one[None])[k, 0]), 9) for k, one in gaps.items()}
    kept: list[int] = []
    for k in sorted(gaps, key=lambda k: (not lattice.is_end(k), factors[k], k)):
        here = scaled[k]
        dominated = any((one <= here + SAME).all() and (one < here - SAME).any() for one in scaled.values())
        if not dominated and not any(np.abs(scaled[i] - here).max() <= SAME for i in kept):
            kept.append(k)
    return sorted(kept)


def _point(lattice: Lattice, branches: Sequence[BranchEnds], end: End, is_knee: bool) -> Point:
    """A point with the problem that it solves, the goals weighted by their ranges over the set."""
    ranges = dict(zip(lattice.names, map(float, lattice.ranges), strict=True))
    met = replace(end.met, aims=tuple((name, by, ranges[name]) for name, by, _ in end.met.aims))
    space = space_of(lattice.spec, branches[end.branch].choice, met.aims)
    if met.aims != end.met.aims:
        met = replace(met, attained=as_aimed(space, met.attained))
    return Point(space, met, is_knee)

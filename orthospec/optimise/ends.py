"""The ends of a Pareto set: what is best in each goal alone, over all branches of the catalogues."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from orthospec.optimise.branch import choices_of
from orthospec.optimise.hunt import hunt
from orthospec.optimise.meet import LOWER, Aims, Chosen, Lowering, Met, gaps_at, soft_goals, space_of
from orthospec.optimise.space import DesignSpace
from orthospec.optimise.workers import Workers, in_order
from orthospec.spec import Spec
from orthospec.workspace.field import Progress

if TYPE_CHECKING:
    from orthospec.arrays import Array

SAME = 1e-6
"""Goals nearer than this, as a part of their range, are one."""
TIED = 1e-7
"""Ends of two branches nearer than this, as a part of the goal's range, are equally good."""


@dataclass(frozen=True)
class BranchEnds:
    """One combination of choices, and what was found with it for each goal alone."""

    choice: Chosen
    ends: tuple[Met | None, ...]

    @property
    def floor(self) -> Array:
        """The least gap of each goal (g,), which no design of the branch is known to beat."""
        return np.array([-np.inf if end is None else end.gaps[i] for i, end in enumerate(self.ends)])


@dataclass(frozen=True)
class End:
    """The best in one goal, and the number of its branch."""

    branch: int
    met: Met


def search_branches(
    spec: Spec, workers: Workers, progress: Progress | None = None
) -> tuple[tuple[BranchEnds, ...], int]:
    """The branches in which a design was found, and how many were searched. Ctrl-C is KeyboardInterrupt."""
    names = soft_goals(spec)
    choices, _ = choices_of([spec.aimed(dict([_alone(name)])) for name in names], workers, progress)
    found = []
    for choice in (tuple(one.items()) for one in choices):
        ends = tuple(_end(spec, choice, name, workers, progress) for name in names)
        if any(end is not None for end in ends):
            found.append(BranchEnds(choice, ends))
    return tuple(found), len(choices)


def _alone(name: str) -> tuple[str, tuple[float, float]]:
    return name, (0.0, 1.0)


def _aims(name: str) -> Aims:
    return ((name, 0.0, 1.0),)


def _end(spec: Spec, choice: Chosen, name: str, workers: Workers, progress: Progress | None) -> Met | None:
    """The best in one goal, whatever that costs in the others."""
    found = hunt(space_of(spec, choice, _aims(name)), workers, progress)
    if found.interrupted:
        raise KeyboardInterrupt
    best = found.best
    if best is None or not best.feasible:
        return None
    return Met(best, gaps_at(spec, choice, best.end), _aims(name))


def best_ends(
    spec: Spec, branches: Sequence[BranchEnds], workers: Workers, progress: Progress | None = None
) -> tuple[End, ...]:
    """The best end of each goal; none where a goal has no end.

    Where several branches are equally good in a goal, and where it is flat in one of them, the end is the
    design that is best in the others.
    """
    names = soft_goals(spec)
    every = [
        [End(b, end) for b, one in enumerate(branches) if (end := one.ends[i])] for i in range(len(names))
    ]
    if not all(every):
        return ()
    ends = tuple(min(ones, key=lambda one: (one.met.gaps[i], one.branch)) for i, ones in enumerate(every))
    ranges = ranges_of(ends)
    if agree(ends):
        return ends
    tied = [
        (i, one)
        for i, ones in enumerate(every)
        for one in ones
        if one.met.gaps[i] <= ends[i].met.gaps[i] + TIED * ranges[i]
    ]
    items = [Lowering(branches[one.branch].choice, tuple(map(float, ranges)), one.met) for _, one in tied]
    lowered = in_order(workers, LOWER, DesignSpace(spec), items, progress)
    known = [(i, End(one.branch, met)) for (i, one), met in zip(tied, lowered, strict=True)]
    return tuple(
        min((one for of, one in known if of == i), key=lambda one: _others(one, ranges))
        for i in range(len(names))
    )


def _others(end: End, ranges: Array) -> tuple[float, int]:
    """By what to choose among ends that are equally good in their own goal."""
    return round(float(np.sum(np.array(end.met.gaps) / ranges)), 9), end.branch


def ranges_of(ends: Sequence[End]) -> Array:
    """How far each goal lies apart between the ends (g,)."""
    gaps = np.array([end.met.gaps for end in ends])
    return np.asarray(gaps.max(axis=0) - np.diag(gaps))


def best_in_all(ends: Sequence[End]) -> End:
    """Of ends that agree the one that is best in the others' goals too: one that is flat need not be."""
    gaps = np.array([end.met.gaps for end in ends])
    sizes = np.maximum(np.abs(gaps).max(axis=0), 1e-12)
    return ends[int(np.argmin(np.round(np.sum((gaps - np.diag(gaps)) / sizes, axis=1), 9)))]


def agree(ends: Sequence[End]) -> bool:
    """Whether what is best in one goal is so in another: there is nothing between the ends."""
    sizes = np.abs([end.met.gaps for end in ends]).max(axis=0)
    return bool((ranges_of(ends) <= SAME * np.maximum(sizes, 1e-12)).any())

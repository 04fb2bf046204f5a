"""The reference points of a Pareto set: evenly spread over the line or the plane through its ends."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import count
from typing import TYPE_CHECKING

import numpy as np

from orthospec.optimise.meet import Aims
from orthospec.spec import Spec

if TYPE_CHECKING:
    from orthospec.arrays import Array


@dataclass(frozen=True)
class Lattice:
    """The reference points, by their weights on the ends."""

    spec: Spec
    names: tuple[str, ...]
    """Of the soft goals."""
    ends: Array
    """Gaps of the ends, one row each."""
    ranges: Array
    weights: Array
    """(n, goals): whole shares of each end, of equal sum."""

    @cached_property
    def references(self) -> Array:
        """P of each point (n, goals)."""
        return np.array([shares @ self.ends / shares.sum() for shares in self.weights])

    def factors(self, gaps: Array) -> Array:
        """λ that gaps (m, goals) come to in the problem of each point (n, m)."""
        missed = gaps - self.references[:, None]
        return np.asarray(np.max(missed / self.ranges, axis=2))

    def depth(self, gaps: Array) -> float:
        """λ of gaps (goals,) on a normal of their own: the less, the further they stand out."""
        goals = len(self.names)
        system = np.ones((goals + 1, goals + 1))
        system[:goals, :goals] = (self.ends / self.ranges).T
        system[goals, goals] = 0.0
        return float(np.linalg.lstsq(system, np.array([*gaps / self.ranges, 1.0]), rcond=None)[0][goals])

    def is_end(self, k: int) -> bool:
        """Whether a point is an end."""
        return bool(self.weights[k].max() == self.weights[k].sum())

    def corner(self, goal: int) -> int:
        """The point that is the end of a goal."""
        return int(self.weights[:, goal].argmax())

    def aims(self, k: int) -> Aims:
        """The aims of a point; an end has one alone."""
        if self.is_end(k):
            at = int(self.weights[k].argmax())
            return ((self.names[at], float(self.ends[at, at]), float(self.ranges[at])),)
        moved = self.references[k] + self._far(k) * self.ranges
        parts = zip(self.names, moved, self.ranges, strict=True)
        return tuple((name, float(by), float(weight)) for name, by, weight in parts)

    @cached_property
    def steps(self) -> Array:
        """How many steps each point is away from each other (n, n)."""
        return np.asarray(np.abs(self.weights[:, None] - self.weights).sum(axis=2) / 2)

    def _far(self, k: int) -> float:
        """How far along the normal the aims stand: λ differs by it, and no goal comes near 0."""
        plain = {plan.name: plan for plan in self.spec.goals}
        start = self.spec.default_values()
        goals = [plain[name].at(start) for name in self.names]
        signs = np.array([-1.0 if goal.sense == "maximise" else 1.0 for goal in goals])
        at = np.array([goal.goal for goal in goals]) + signs * self.references[k]
        for step in count():
            for far in (float(step), -float(step)):
                if (np.abs(at + signs * far * self.ranges) >= 0.4 * self.ranges).all():
                    return far
        raise AssertionError


def shares_of(goals: int, points: int) -> Array:
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

"""The search of one design space: explore, refine the better half, cluster, solve the best to the end.

A start's merit on the coarse grid tells little of where it leads. After a few subproblems it tells more, and
starts that lead to one place stand near each other: one of them goes on.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from orthospec.optimise.attain import BEGIN, FINISH, Attained
from orthospec.optimise.explore import explore
from orthospec.optimise.place import Place
from orthospec.optimise.space import DesignSpace
from orthospec.optimise.tasks import Stopped
from orthospec.optimise.workers import Workers, counted
from orthospec.workspace.field import Progress

REFINED = 4
"""Starts that are refined, where there are as many; of more than twice as many the better half."""
KEPT = 3
"""Most clusters whose best is solved to the end."""
DISTINCT = 0.02
"""Designs nearer than this, as a part of the variables' ranges, are one."""
PENALTY = 10.0
"""What a violation counts against the factor where refined starts are compared."""


@dataclass
class Hunt:
    """What a search has found so far; kept outside of it, so that Ctrl-C loses nothing."""

    designs: int = 0
    begun: dict[int, Attained] = field(default_factory=dict)
    """Each start refined, by the start's rank."""
    distinct: int = 0
    """Places that the refined starts lead to."""
    solved: dict[int, Attained] = field(default_factory=dict)
    """The end of each solve, by the rank of the place it went on from."""
    interrupted: bool = False

    @property
    def best(self) -> Attained | None:
        """The best end; of equal ones the first, whichever was there first.

        What was only begun counts where the search was stopped.
        """
        best: Attained | None = None
        ends = [*sorted(self.solved.items()), *(sorted(self.begun.items()) if self.interrupted else ())]
        for _, found in ends:
            if best is None or found.beats(best):
                best = found
        return best

    def history(self, space: DesignSpace) -> list[dict[str, Any]]:
        """Each start that was refined, whether it was solved to the end, and its steps, for the log."""
        ends = {one.start: one for one in self.solved.values()}
        return [
            {
                "start": space.values(one.start.design),
                "to_the_end": one.start in ends,
                "iterates": [vars(iterate) for iterate in ends.get(one.start, one).iterates],
            }
            for _, one in sorted(self.begun.items())
        ]


def hunt(space: DesignSpace, workers: Workers, progress: Progress | None = None) -> Hunt:
    """Search the design space; stopped by Ctrl-C it gives back what it has."""
    state = Hunt()
    stage = state.begun
    try:
        starts, state.designs = explore(space, workers, progress)
        better = [start.place for start in starts][: max(REFINED, len(starts) // 2)]
        for number, found in counted(workers, BEGIN, space, better, progress):
            stage[number] = found
        clusters = _clusters([state.begun[number] for number in range(len(better))])
        state.distinct = len(clusters)
        stage = state.solved
        for number, found in counted(workers, FINISH, space, clusters[:KEPT], progress):
            stage[number] = found
    except Stopped as stopped:
        state.interrupted = True
        if isinstance(stopped.made, Attained):
            stage[max(stage, default=-1) + 1] = stopped.made
    except KeyboardInterrupt:
        state.interrupted = True
    return state


def _clusters(begun: Sequence[Attained]) -> list[Attained]:
    """The most promising of each cluster of places, the best first."""
    kept: list[Attained] = []
    for one in sorted(begun, key=_promise):
        if all(_distance(one.end, other.end) > DISTINCT for other in kept):
            kept.append(one)
    return kept


def _promise(one: Attained) -> float:
    """The less the better; to eight digits, so that rounding does not choose between equals."""
    violation = 0.0 if one.feasible else one.violation
    return round(one.factor + PENALTY * violation, 8)


def _distance(one: Place, other: Place) -> float:
    return float(np.abs(one.design - other.design).max(initial=0.0))

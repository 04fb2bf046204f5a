"""Catalogues beside continuous variables: each combination of choices is a branch with the same starts.

More combinations than `MOST` are screened first: each is measured at the spec's own start on the coarse grid,
and the best go on. What was not searched is told.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from math import inf, prod
from typing import Any

from orthospec.errors import UsageError
from orthospec.optimise.attain import Attained
from orthospec.optimise.explore import problem_on_grid, start_at
from orthospec.optimise.hunt import Hunt, hunt
from orthospec.optimise.meet import LOWER, SLACK, Lowering, Met, gaps_at
from orthospec.optimise.space import DesignSpace
from orthospec.optimise.tasks import Task
from orthospec.optimise.workers import Workers, in_order, labelled
from orthospec.result import Branch
from orthospec.spec import Spec
from orthospec.workspace.field import Progress

MOST = 64
"""Most branches that are searched."""
MOST_SCREENED = 4096
"""Most combinations that are screened."""

Choice = Mapping[str, float]


@dataclass(frozen=True)
class Branches:
    """What the search of all branches found."""

    combinations: int
    hunts: tuple[tuple[DesignSpace, Hunt], ...]
    """Of each branch that was searched, in the order of the choices."""

    @property
    def best(self) -> tuple[DesignSpace, Hunt]:
        """The branch with the best end; of equal ones the first."""
        first, *others = self.hunts
        best = first
        for space, found in others:
            known = best[1].best
            if found.best is not None and (known is None or found.best.beats(known)):
                best = space, found
        return best

    @property
    def interrupted(self) -> bool:
        """Whether the search was stopped."""
        return any(found.interrupted for _, found in self.hunts)

    @property
    def searched(self) -> tuple[int, int, int, int]:
        """Designs measured on the coarse grid, refined, distinct ends of these, solved to the end."""
        counts = ((h.designs, len(h.begun), h.distinct, len(h.solved)) for _, h in self.hunts)
        designs, refined, distinct, solved = map(sum, zip(*counts, strict=True))
        return designs, refined, distinct, solved

    def history(self) -> list[dict[str, Any]]:
        """Each start and the steps from there, for the log."""
        return [entry for space, found in self.hunts for entry in found.history(space)]

    def records(self) -> tuple[Branch, ...]:
        """Each branch with what was found in it, the best first; none where there is no catalogue."""
        space, found = self.best
        if not catalogues(space.spec):
            return ()
        taken = _record(space, found.best)
        others = [_record(other, hunt.best) for other, hunt in self.hunts if other is not space]
        every = (taken, *sorted(others, key=_order))
        return tuple(replace(one, cost=_cost(one, taken)) for one in every)


def catalogues(spec: Spec) -> tuple[str, ...]:
    """The variables of a spec, or of one of its branches, that have choices."""
    return tuple(name for name, one in spec.variables.items() if one.choices or one.min == one.max)


def hunt_branches(spec: Spec, workers: Workers, progress: Progress | None = None) -> Branches:
    """Search each branch; stopped by Ctrl-C it gives back what it has."""
    choices, combinations = choices_of([spec], workers, progress)
    hunts = []
    for number, choice in enumerate(choices, start=1):
        space, several = DesignSpace(spec.chosen(choice)), len(choices) > 1
        label = f"combination {number} of {len(choices)}"
        hunts.append((space, hunt(space, workers, labelled(progress, label) if several else progress)))
        if hunts[-1][1].interrupted:
            break
    return Branches(combinations, tuple(hunts))


def choices_of(
    specs: Sequence[Spec], workers: Workers, progress: Progress | None = None
) -> tuple[list[Choice], int]:
    """The combinations to search, and how many there are; ``specs`` are one problem with various goals."""
    every = every_choice(specs[0])
    if len(every) <= MOST:
        return every, len(every)
    return _screened(specs, every, workers, progress), len(every)


def every_choice(spec: Spec) -> list[Choice]:
    """All combinations of a spec's catalogues; `UsageError` where they are too many."""
    lists = {name: spec.variables[name].choices for name in catalogues(spec)}
    combinations = prod(map(len, lists.values()))
    if combinations > MOST_SCREENED:
        raise UsageError(
            f"the catalogues have {combinations} combinations; at most {MOST_SCREENED} can be tried"
        )
    return [dict(zip(lists, values, strict=True)) for values in product(*lists.values())]


def _screened(
    specs: Sequence[Spec], every: list[Choice], workers: Workers, progress: Progress | None
) -> list[Choice]:
    """The best combinations on the coarse grid, in their own order; by turns of each of the specs."""
    choices = [tuple(choice.items()) for choice in every]
    ranks: dict[int, int] = {}
    for spec in specs:
        merits = in_order(workers, SCREEN, DesignSpace(spec), choices, progress)
        known = sorted((merit, number) for number, merit in enumerate(merits) if merit is not None)
        for rank, (_, number) in enumerate(known):
            ranks[number] = min(rank, ranks.get(number, rank))
    kept = sorted(sorted(ranks, key=lambda number: (ranks[number], number))[:MOST])
    return [every[number] for number in kept] or every[:1]


def beside_choices(
    space: DesignSpace, best: Attained, workers: Workers, progress: Progress | None = None
) -> Attained:
    """The best of a branch, the other goals lowered where goals on choices alone decide λ.

    Such a goal has one value in the branch: λ leaves the others wherever the solve stopped.
    """
    choice = tuple((name, space.spec.variables[name].start) for name in catalogues(space.spec))
    soft = [goal for goal in space.design(best.end.design).goals if goal.weight > 0]
    if not (choice and best.feasible and len(soft) > 1) or any(goal.sense == "match" for goal in soft):
        return best
    gaps = gaps_at(space.spec, choice, best.end)
    rows = {goal.name: gap / goal.weight for goal, gap in zip(soft, gaps, strict=True)}
    deciding = {name for name, row in rows.items() if row >= max(rows.values()) - SLACK}
    plans = [plan for plan in space.spec.goals if plan.name in deciding]
    if not all(plan.depends_on_only(dict(choice).keys()) for plan in plans):
        return best
    aims = tuple((goal.name, 0.0, goal.weight) for goal in soft)
    one = Lowering(choice, tuple(goal.weight for goal in soft), Met(best, gaps, aims))
    (met,) = in_order(workers, LOWER, space, [one], progress)
    return replace(best, end=met.attained.end)


def start_merit(
    space: DesignSpace, choice: tuple[tuple[str, float], ...], _: Progress | None = None
) -> float | None:
    """The merit of the spec's own start with a combination; None where there is no start."""
    branch = DesignSpace(space.spec.chosen(dict(choice)))
    start = start_at(branch, tuple(map(float, branch.scaled(space.spec.default_values()))))
    return None if start is None else start.merit


def _start_on_grid(content: Mapping[str, Any]) -> dict[str, Any]:
    return {**problem_on_grid(content), "variables": content["variables"]}


SCREEN = Task("screening the catalogues", start_merit, _start_on_grid)


def _order(one: Branch) -> tuple[bool, float]:
    """The least λ first, then the least violation; to eight digits, so that rounding does not decide."""
    merit = one.factor if one.found else one.least_violation
    return not one.found, inf if merit is None and not one.found else float(f"{merit or 0.0:.8g}")


def _cost(one: Branch, taken: Branch) -> float | None:
    return None if one.factor is None or taken.factor is None else one.factor - taken.factor


def _record(space: DesignSpace, best: Attained | None) -> Branch:
    choices = {name: space.spec.variables[name].start for name in catalogues(space.spec)}
    if best is None or not best.feasible:
        return Branch(choices, False, None, None if best is None else best.violation)
    soft = any(goal.weight > 0 for goal in space.design(best.end.design).goals)
    return Branch(choices, True, best.factor * best.unit if soft else None, None)

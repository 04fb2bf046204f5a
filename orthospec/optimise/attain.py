"""Goal attainment of a spec: explore, solve from the best starts, keep the best, confirm it more finely."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from orthospec.composite.trust_region import FEASIBLE, Assessment, Iterate, Solution, minimise
from orthospec.optimise.explore import explore
from orthospec.optimise.objective import Learnt
from orthospec.optimise.place import Fit, Place, fit_at
from orthospec.optimise.space import DesignSpace
from orthospec.optimise.tasks import Stopped, Task, problem_of
from orthospec.optimise.workers import Workers, counted
from orthospec.workspace.conditions import Condition, Extreme
from orthospec.workspace.evaluate import FINE
from orthospec.workspace.field import Progress
from orthospec.workspace.fit import FitProblem, Group

if TYPE_CHECKING:
    from orthospec.arrays import Array

ROUNDING = 1e-10
"""A scaled variable this near an end of its range stands on it."""
SAME = 1e-8
"""Ends nearer than this, relative, are one: the first is kept, and rounding does not choose between them."""
CONFIRMATIONS = 4
"""How often a solution may be refined with critical points that only the finer lattice shows."""


@dataclass(frozen=True)
class Pressure:
    """What pushes against the least violation, each with its part of the whole."""

    conditions: tuple[tuple[Condition, float], ...]
    goals: tuple[tuple[str, float], ...]
    """Hard goals, by name; one with several rows stands here as often."""
    ends: tuple[tuple[float, float], ...]
    """Multipliers of both ends of each variable's range."""


@dataclass(frozen=True)
class Attained:
    """The best point found from one start, as plain data: `orthospec.optimise.place` makes its fit anew."""

    start: Place
    end: Place
    learnt: Learnt
    factor: float
    violation: float
    unit: float
    """What one unit of the factor is in λ."""
    subproblems: int
    iterates: tuple[Iterate, ...]
    pressure: Pressure | None = None
    """None where the solve was stopped before its end, or a bound has no part in it."""

    @property
    def feasible(self) -> bool:
        """Whether every bound holds."""
        return self.violation <= FEASIBLE

    @property
    def merit(self) -> float:
        """λ, or the violation where not every bound holds."""
        return self.factor * self.unit if self.feasible else self.violation

    def beats(self, other: Attained) -> bool:
        """Whether it is the better one, by more than rounding: feasible first, then the lower merit."""
        if self.feasible != other.feasible:
            return self.feasible
        return self.merit < other.merit - SAME * abs(other.merit)


@dataclass
class Hunt:
    """What a search has found so far; kept outside of it, so that Ctrl-C loses nothing."""

    designs: int = 0
    solved: dict[int, Attained] = field(default_factory=dict)
    """The end of each start's solve, by the start's rank."""
    interrupted: bool = False

    @property
    def best(self) -> Attained | None:
        """The best end; of equal ones that of the first start, whichever was there first."""
        best: Attained | None = None
        for _, found in sorted(self.solved.items()):
            if best is None or found.beats(best):
                best = found
        return best

    def history(self, space: DesignSpace) -> list[dict[str, Any]]:
        """Each start and the steps from there, for the log."""
        return [
            {"start": space.values(one.start.design), "iterates": [vars(iterate) for iterate in one.iterates]}
            for _, one in sorted(self.solved.items())
        ]


def attain(space: DesignSpace, place: Place, progress: Progress | None = None) -> Attained:
    """Solve from one place."""
    fit = fit_at(space, place)
    problem = fit.problem
    iterates: list[Iterate] = []
    here = problem.assess(problem.start)

    def follow(now: Assessment, iterate: Iterate) -> None:
        nonlocal here
        here = now
        iterates.append(iterate)
        if progress is not None:
            progress(f"subproblem {iterate.subproblems}", 0, 0)

    try:
        found = minimise(problem, problem.start, on_iterate=follow)
        spent = found.subproblems
        problem.lattice = FINE
        here = confirmed = problem.assess(_snapped(problem, found.x))
        for _ in range(CONFIRMATIONS):
            if confirmed.violation <= max(FEASIBLE, 1.01 * found.violation):
                break
            found = minimise(problem, confirmed.x, radius=0.02, on_iterate=follow)
            spent += found.subproblems
            here = confirmed = problem.assess(_snapped(problem, found.x))
    except KeyboardInterrupt:
        spent = iterates[-1].subproblems if iterates else 0
        raise Stopped(_attained(fit, here, spent, iterates, None)) from None
    return _attained(fit, confirmed, spent, iterates, found)


_PARTS = (Attained, Place, Group, Learnt, Extreme, Iterate, Pressure, Condition)
ATTAIN = Task("solving from the best starts", attain, problem_of, _PARTS)


def _attained(
    fit: Fit, here: Assessment, spent: int, iterates: list[Iterate], solution: Solution | None
) -> Attained:
    return Attained(
        fit.place,
        fit.place.at(fit.problem.layout.unpack(here.x)),
        fit.objective.learnt,
        float(here.factor),
        float(here.violation),
        fit.objective.unit,
        spent,
        tuple(_plain(iterate) for iterate in iterates),
        _pressure(fit, solution) if solution is not None and here.violation > FEASIBLE else None,
    )


def _plain(iterate: Iterate) -> Iterate:
    return Iterate(
        iterate.subproblems,
        float(iterate.factor),
        float(iterate.violation),
        float(iterate.radius),
        float(iterate.penalty),
        bool(iterate.accepted),
    )


def _pressure(fit: Fit, solution: Solution) -> Pressure | None:
    """The shares in the last subproblem's pressure."""
    rows, step = solution.rows, solution.step
    if rows is None or step is None:
        return None
    owners, stop = fit.objective.owners, rows.half_lines.stop
    hard = map(float, step.shares[stop - len(owners) : stop])
    ends = step.on_bounds[: len(fit.place.z)]
    return Pressure(
        tuple((condition, float(share)) for condition, share in fit.problem.shares(rows, step).items()),
        tuple(zip(owners, hard, strict=True)),
        tuple((float(low), float(high)) for low, high in ends),
    )


def hunt(space: DesignSpace, workers: Workers, progress: Progress | None = None) -> Hunt:
    """Search the design space; stopped by Ctrl-C it gives back what it has."""
    import cvxpy  # noqa: F401  # before Ctrl-C is caught: an import cut in half cannot be mended

    state = Hunt()
    try:
        starts, state.designs = explore(space, workers, progress)
        places = [start.place for start in starts]
        for number, found in counted(workers, ATTAIN, space, places, progress):
            state.solved[number] = found
    except Stopped as stopped:
        state.interrupted = True
        if isinstance(stopped.made, Attained):
            state.solved[max(state.solved, default=-1) + 1] = stopped.made
    except KeyboardInterrupt:
        state.interrupted = True
    return state


def _snapped(problem: FitProblem, x: Array) -> Array:
    """Put variables that lie on an end of their range, but for the solver's rounding, exactly there."""
    x = np.where(np.abs(x - problem.lower) <= ROUNDING, problem.lower, x)
    return np.where(np.abs(x - problem.upper) <= ROUNDING, problem.upper, x)

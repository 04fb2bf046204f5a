"""One local solve: the trust region from a place to its end, confirmed with more critical points."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from orthospec.composite.trust_region import FEASIBLE, Assessment, Ending, Iterate, Solution, minimise
from orthospec.optimise.objective import Learnt
from orthospec.optimise.place import Fit, Place, fit_at
from orthospec.optimise.space import DesignSpace
from orthospec.optimise.tasks import Stopped, Task, problem_of
from orthospec.result import Taken
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
FIRST = 8
"""Most subproblems of a solve that is only begun."""
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
    exhausted: bool = False
    """Whether the solve ran out of subproblems: what it came to may not be its end."""

    @property
    def feasible(self) -> bool:
        """Whether every bound holds."""
        return self.violation <= FEASIBLE

    @property
    def merit(self) -> float:
        """λ, or the violation where not every bound holds."""
        return self.factor * self.unit if self.feasible else self.violation

    @property
    def taken(self) -> tuple[Taken, ...]:
        """Where the solve stood after each step that was taken; beyond nine decimals there is noise."""
        return tuple(
            Taken(one.subproblems, round(one.factor * self.unit, 9), round(one.violation, 9))
            for one in self.iterates
            if one.accepted
        )

    def beats(self, other: Attained) -> bool:
        """Whether it is the better one, by more than rounding: feasible first, then the lower merit."""
        if self.feasible != other.feasible:
            return self.feasible
        size = max(abs(other.merit), self.unit) if self.feasible else abs(other.merit)
        return self.merit < other.merit - SAME * size


@dataclass
class _Trace:
    """The steps of a solve as they are taken: one stopped by Ctrl-C is not lost."""

    here: Assessment
    before: int = 0
    """Subproblems that went before, in an earlier part of the solve."""
    progress: Progress | None = None
    iterates: list[Iterate] = field(default_factory=list)

    @property
    def spent(self) -> int:
        """Subproblems up to the last step."""
        return self.iterates[-1].subproblems if self.iterates else self.before

    def follow(self, here: Assessment, iterate: Iterate) -> None:
        """Note a step."""
        self.here = here
        self.iterates.append(_plain(iterate, self.before))
        if self.progress is not None:
            self.progress(f"subproblem {self.spent}", 0, 0)


def begin(space: DesignSpace, place: Place, progress: Progress | None = None) -> Attained:
    """The first few subproblems of a solve: enough to tell where it leads."""
    fit = fit_at(space, place)
    trace = _Trace(fit.problem.assess(fit.problem.start), progress=progress)
    try:
        found = minimise(fit.problem, fit.problem.start, most=FIRST, on_iterate=trace.follow)
    except KeyboardInterrupt:
        raise Stopped(_attained(fit, trace.here, trace.spent, trace)) from None
    # Where the trace ends, feasible or not: it is on its way.
    return _attained(fit, trace.here, found.subproblems, trace)


def finish(space: DesignSpace, begun: Attained, progress: Progress | None = None) -> Attained:
    """Solve to the end what was begun."""
    return _continued(fit_at(space, begun.end, begun.learnt), begun, progress)


@dataclass(frozen=True)
class Refuted:
    """The end of a solve, and the poses at which proofs have found that something does not hold."""

    end: Attained
    poses: tuple[tuple[float, ...], ...]


def refit(space: DesignSpace, refuted: Refuted, progress: Progress | None = None) -> Attained:
    """Solve on from an end that was refuted, minding the poses that were found."""
    before = refuted.end
    fit = fit_at(space, before.end, before.learnt, pinned=np.array(refuted.poses))
    return _continued(fit, before, progress)


def attain(space: DesignSpace, place: Place, progress: Progress | None = None) -> Attained:
    """Solve from one place."""
    return _to_the_end(fit_at(space, place), 0, progress)


_PARTS = (Attained, Place, Group, Learnt, Extreme, Iterate, Pressure, Condition)
BEGIN = Task("refining the better starts", begin, problem_of, _PARTS)
REFIT = Task("solving on where a proof failed", refit, problem_of, _PARTS)
FINISH = Task("solving from the best starts", finish, problem_of, _PARTS)


def _continued(fit: Fit, before: Attained, progress: Progress | None) -> Attained:
    """Solve on from where another solve stood, as one solve with it."""
    found = _to_the_end(fit, before.subproblems, progress)
    # Where weights vary with the design, so does the unit.
    earlier = tuple(replace(one, factor=one.factor * (before.unit / found.unit)) for one in before.iterates)
    return replace(found, start=before.start, iterates=earlier + found.iterates)


def _to_the_end(fit: Fit, before: int, progress: Progress | None) -> Attained:
    """Solve, counting from the subproblems ``before``, and confirm on a finer lattice."""
    problem = fit.problem
    trace = _Trace(problem.assess(problem.start), before, progress)
    try:
        found = minimise(problem, problem.start, on_iterate=trace.follow)
        spent = before + found.subproblems
        problem.lattice = FINE
        trace.here = confirmed = problem.assess(_snapped(problem, found.x))
        for _ in range(CONFIRMATIONS):
            if confirmed.violation <= max(FEASIBLE, 1.01 * found.violation):
                break
            trace.before = spent
            found = minimise(problem, confirmed.x, radius=0.02, on_iterate=trace.follow)
            spent += found.subproblems
            trace.here = confirmed = problem.assess(_snapped(problem, found.x))
    except KeyboardInterrupt:
        raise Stopped(_attained(fit, trace.here, trace.spent, trace)) from None
    pressure = _pressure(fit, found) if confirmed.violation > FEASIBLE else None
    exhausted = found.ending is Ending.EXHAUSTED
    return replace(_attained(fit, confirmed, spent, trace), pressure=pressure, exhausted=exhausted)


def _attained(fit: Fit, here: Assessment, spent: int, trace: _Trace) -> Attained:
    return Attained(
        fit.place,
        fit.place.at(fit.problem.layout.unpack(here.x)),
        fit.objective.learnt,
        float(here.factor),
        float(here.violation),
        fit.objective.unit,
        spent,
        tuple(trace.iterates),
    )


def _plain(iterate: Iterate, before: int) -> Iterate:
    return Iterate(
        before + iterate.subproblems,
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


def _snapped(problem: FitProblem, x: Array) -> Array:
    """Put variables that lie on an end of their range, but for the solver's rounding, exactly there."""
    x = np.where(np.abs(x - problem.lower) <= ROUNDING, problem.lower, x)
    return np.where(np.abs(x - problem.upper) <= ROUNDING, problem.upper, x)

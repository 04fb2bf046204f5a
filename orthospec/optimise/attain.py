"""Goal attainment of a spec: explore, solve from the best starts, keep the best, confirm it more finely."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from orthospec.composite.trust_region import FEASIBLE, Assessment, Iterate, Solution, minimise
from orthospec.optimise.explore import Start, explore
from orthospec.optimise.space import DesignSpace
from orthospec.workspace.cuboid import Cuboid
from orthospec.workspace.evaluate import FINE
from orthospec.workspace.field import Progress
from orthospec.workspace.fit import FitProblem

if TYPE_CHECKING:
    from orthospec.arrays import Array

ROUNDING = 1e-10
"""A scaled variable this near an end of its range stands on it."""
SAME = 1e-8
"""Ends nearer than this, relative, are one: the first is kept, and rounding does not choose between them."""
CONFIRMATIONS = 4
"""How often a solution may be refined with critical points that only the finer lattice shows."""


@dataclass(frozen=True)
class Attained:
    """The best point found from one start."""

    start: Start
    x: Array
    factor: float
    violation: float
    subproblems: int
    solution: Solution | None = None
    """None where the solve was stopped before its end."""

    @property
    def feasible(self) -> bool:
        """Whether every bound holds."""
        return self.violation <= FEASIBLE

    @property
    def merit(self) -> float:
        """λ, or the violation where not every bound holds."""
        return self.factor * self.start.objective.unit if self.feasible else self.violation

    def beats(self, other: Attained) -> bool:
        """Whether it is the better one, by more than rounding: feasible first, then the lower merit."""
        if self.feasible != other.feasible:
            return self.feasible
        return self.merit < other.merit - SAME * abs(other.merit)

    def cuboids(self) -> dict[str, Cuboid]:
        """The prescribed cuboids, by measure; "" names the joint one."""
        problem = self.start.problem
        placed = zip(problem.groups, problem.cuboids(self.x), strict=True)
        design = self.start.space.design(self.z)
        apart = not self.start.space.spec.workspace.together and any(d.bounds for d in design.demands)
        return {group.names[0] if apart else "": cuboid for group, cuboid in placed}

    @property
    def z(self) -> Array:
        """The scaled design."""
        return self.start.problem.layout.unpack(self.x).design


@dataclass
class Hunt:
    """What a search has found so far; kept outside of it, so that Ctrl-C loses nothing."""

    designs: int = 0
    starts: int = 0
    best: Attained | None = None
    current: Attained | None = None
    """Where the solve under way stands."""
    history: list[dict[str, Any]] = field(default_factory=list)
    interrupted: bool = False

    def finish(self, found: Attained | None) -> None:
        """Keep a solve's end where it is better than what is kept."""
        self.current = None
        if found is not None and (self.best is None or found.beats(self.best)):
            self.best = found


def hunt(space: DesignSpace, progress: Progress | None = None) -> Hunt:
    """Search the design space; stopped by Ctrl-C it gives back what it has."""
    import cvxpy  # noqa: F401  # before Ctrl-C is caught: an import cut in half cannot be mended

    state = Hunt()
    try:
        if progress is not None:
            progress("designs on the coarse grid", 0, 0)
        starts, state.designs = explore(space)
        for start in starts:
            state.starts += 1
            _solve(start, state, progress)
    except KeyboardInterrupt:
        state.interrupted = True
        state.finish(state.current)
    return state


def _solve(start: Start, state: Hunt, progress: Progress | None) -> None:
    problem = start.problem
    iterates: list[dict[str, float]] = []
    state.history.append({"start": start.space.values(start.z), "iterates": iterates})

    def follow(here: Assessment, iterate: Iterate) -> None:
        iterates.append({name: float(value) for name, value in vars(iterate).items()})
        state.current = Attained(start, here.x, here.factor, here.violation, iterate.subproblems)
        if progress is not None:
            progress(f"start {state.starts}, subproblem {iterate.subproblems}", 0, 0)

    found = minimise(problem, problem.start, on_iterate=follow)
    spent = found.subproblems
    problem.lattice = FINE
    confirmed = problem.assess(_snapped(problem, found.x))
    for _ in range(CONFIRMATIONS):
        if confirmed.violation <= max(FEASIBLE, 1.01 * found.violation):
            break
        found = minimise(problem, confirmed.x, radius=0.02, on_iterate=follow)
        spent += found.subproblems
        confirmed = problem.assess(_snapped(problem, found.x))
    state.finish(Attained(start, confirmed.x, confirmed.factor, confirmed.violation, spent, found))


def _snapped(problem: FitProblem, x: Array) -> Array:
    """Put variables that lie on an end of their range, but for the solver's rounding, exactly there."""
    x = np.where(np.abs(x - problem.lower) <= ROUNDING, problem.lower, x)
    return np.where(np.abs(x - problem.upper) <= ROUNDING, problem.upper, x)

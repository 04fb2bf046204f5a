"""What a user would take instead, on the problems whose optimum is known and whose goals are variables.

python benchmarks/optimisers.py [--limit 600] [--divisions 20] [PROBLEM ...]        needs orthospec[bench]

The rivals work as the paper does: λ from the goals, under the constraint that the largest cuboid on a grid
has at least the prescribed size. SLSQP (SciPy) starts anew from random designs until the time is up, with
steps of a hundredth of the range, since the grid's scale is a step function; differential evolution (SciPy)
gets the constraint as a penalty, NSGA-II (pymoo) as one, and the goals apart. Told are the designs measured
and the time until λ is within 5e-2, 2e-2, 1e-2 and 1e-6 of the optimum with the constraint held, and both as
multiples of orthospec's, which goes to 1e-6.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any
from unittest.mock import patch

import numpy as np
from problems import ACCURACY, SpecProblem, problems
from pymoo.algorithms.moo.nsga2 import NSGA2
from pymoo.core.problem import ElementwiseProblem
from pymoo.optimize import minimize as pymoo_minimize
from scipy.optimize import differential_evolution, minimize

from orthospec.errors import OrthospecError
from orthospec.spec import Spec
from orthospec.workspace.cuboid import Cuboid, edge_lengths, largest
from orthospec.workspace.field import State, node_states, together
from orthospec.workspace.grid import make_grid

LEVELS = (5e-2, 2e-2, 1e-2, 1e-6)
WORST = 1e3
"""What a design without a machine or a cuboid is worth."""


class Enough(Exception):
    """The time is up, or the tightest level reached."""


@dataclass
class Rival:
    """A problem as the grid shows it, with a count of what it was asked."""

    problem: SpecProblem
    divisions: float
    limit: float
    measured: int = 0
    start: float = field(default_factory=time.perf_counter)
    reached: dict[float, tuple[int, float]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.spec = self.problem.spec()
        self.variables = self.spec.variables

    def measure(self, z: Any) -> tuple[list[float], float]:
        """Each goal's miss over its weight, and how far the grid's scale is below 1, of a scaled design."""
        spent = time.perf_counter() - self.start
        if spent > self.limit:
            raise Enough
        self.measured += 1
        gaps, shortage = self._misses(np.clip(z, 0, 1))
        error = abs(max(gaps) - self.problem.optimum)
        for level in LEVELS:
            if shortage <= 0 and error <= level and level not in self.reached:
                self.reached[level] = self.measured, time.perf_counter() - self.start
        if LEVELS[-1] in self.reached:
            raise Enough
        return gaps, shortage

    def _misses(self, z: Any) -> tuple[list[float], float]:
        pairs = zip(self.variables.items(), z, strict=True)
        values = {name: float(v.min + part * (v.max - v.min)) for (name, v), part in pairs}
        try:
            design = self.spec.design(values)
        except OrthospecError:
            return [WORST] * len(self.spec.goals), 1.0
        gaps = []
        for goal in design.goals:
            miss = goal.expression.value(values, {}) - goal.goal
            gaps.append((miss if goal.sense == "minimise" else -miss) / goal.weight)
        return gaps, 1.0 - self._scale(design)

    def _scale(self, design: Any) -> float:
        asked = self.spec.workspace
        region = Cuboid(asked.region.min, asked.region.max) if asked.region else None
        try:
            grid = make_grid(design.manipulator, np.array(asked.size), self.divisions, region)
        except OrthospecError:
            return 0.0
        states, _ = node_states(design.manipulator, list(design.demands), grid)
        placed = largest(edge_lengths(together(states) == State.MEETS))
        return 0.0 if placed is None else float(np.max(grid.cuboid(placed).size / np.array(asked.size)))


def slsqp(rival: Rival) -> None:
    """Minimise λ, the scale as a constraint."""
    random = np.random.default_rng(0)
    held = {"type": "ineq", "fun": lambda z: -rival.measure(z)[1]}
    while True:
        minimize(
            lambda z: max(rival.measure(z)[0]),
            random.random(len(rival.variables)),
            method="SLSQP",
            bounds=[(0, 1)] * len(rival.variables),
            constraints=[held],
            options={"eps": 1e-2},
        )


def evolution(rival: Rival) -> None:
    """Minimise λ plus a penalty on the missing scale."""

    def cost(z: Any) -> float:
        gaps, shortage = rival.measure(z)
        return max(gaps) + (10 + 10 * shortage if shortage > 0 else 0)

    differential_evolution(cost, [(0, 1)] * len(rival.variables), rng=0, tol=0, maxiter=10**6, polish=False)


def nsga2(rival: Rival) -> None:
    """The goals as objectives, the scale as a constraint."""

    class Measured(ElementwiseProblem):
        def __init__(self) -> None:
            count = len(rival.variables)
            super().__init__(n_var=count, n_obj=len(rival.spec.goals), n_ieq_constr=1, xl=0.0, xu=1.0)

        def _evaluate(self, x: Any, out: dict[str, Any], *_: Any, **__: Any) -> None:
            out["F"], shortage = rival.measure(x)
            out["G"] = [shortage]

    pymoo_minimize(Measured(), NSGA2(pop_size=40), ("n_gen", 10**6), seed=0)


RIVALS: dict[str, Callable[[Rival], None]] = {"SLSQP": slsqp, "DE": evolution, "NSGA-II": nsga2}


def ours(problem: SpecProblem) -> tuple[int, float]:
    """Designs built and time until orthospec's search ends."""
    built = 0
    design = Spec.design

    def counted(spec: Spec, values: Any) -> Any:
        nonlocal built
        built += 1
        return design(spec, values)

    with patch.object(Spec, "design", counted):
        found = problem.solve()
    assert found.error < ACCURACY
    return built, found.seconds


def compare(name: str, problem: SpecProblem, divisions: float, limit: float) -> None:
    designs, seconds = ours(problem)
    print(f"{name}: orthospec within 1e-06 after {designs} designs, {seconds:.2f} s", flush=True)
    for title, optimise in RIVALS.items():
        rival = Rival(problem, divisions, limit)
        with suppress(Enough):
            optimise(rival)
        told = []
        for level in LEVELS:
            if level not in rival.reached:
                told.append(f"{level:g}: never")
                continue
            count, spent = rival.reached[level]
            ratios = f"{count / designs:.2g} x, {spent / seconds:.2g} x"
            told.append(f"{level:g}: {count} designs, {spent:.1f} s ({ratios})")
        print(f"  {title:8} {';  '.join(told)};  {rival.measured} designs in all", flush=True)


def simple() -> dict[str, SpecProblem]:
    """The problems whose goals are of variables alone: others ask for more than a grid's scale."""
    found = {}
    for name, problem in problems().items():
        if isinstance(problem, SpecProblem):
            spec = problem.spec()
            if all(goal.expression.names <= spec.variables.keys() for goal in spec.goals):
                found[name] = problem
    return {name: found[name] for name in found if not found[name].spec().goals[0].expression.extremes}


def main() -> None:
    known = simple()
    asked = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    asked.add_argument("names", nargs="*", metavar="PROBLEM", help=", ".join(known))
    asked.add_argument("--limit", type=float, default=600.0, help="seconds for each rival")
    asked.add_argument("--divisions", type=float, default=20.0, help="of the prescribed size on the grid")
    given = asked.parse_args()
    for name in given.names or known:
        compare(name, known[name], given.divisions, given.limit)


if __name__ == "__main__":
    main()

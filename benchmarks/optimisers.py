"""What a user would take instead, on the problems whose optimum is known and whose goals are variables.

python benchmarks/optimisers.py [--limit 600] [--divisions 40] [PROBLEM ...]        needs orthospec[bench]

The rivals work as the paper does: λ from the goals, under the constraint that the largest cuboid on a grid
has at least the prescribed size. SLSQP (SciPy) starts anew from random designs until the time is up, with
steps of a hundredth of the range, since the grid's scale is a step function; differential evolution (SciPy)
gets the constraint as a penalty, NSGA-II (pymoo) as one, and the goals apart.

Told are, for orthospec and each rival, the designs built, the poses at which the machine was computed and
the seconds (of processor time, on one thread) until λ is first within 5e-2, 2e-2, 1e-2 and 1e-6 of the
optimum with all bounds held; and a rival's as multiples of orthospec's at the same level.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from typing import Any, NamedTuple
from unittest.mock import patch

import cvxpy  # noqa: F401  # no one's imports are timed
import numpy as np
from problems import SpecProblem, problems
from pymoo.algorithms.moo.nsga2 import NSGA2
from pymoo.core.problem import ElementwiseProblem
from pymoo.optimize import minimize as pymoo_minimize
from scipy.optimize import differential_evolution, minimize

from orthospec.composite.trust_region import FEASIBLE, Assessment
from orthospec.errors import OrthospecError
from orthospec.mechanics import prismatic
from orthospec.optimise.objective import GoalObjective
from orthospec.spec import Spec
from orthospec.workspace.cuboid import Cuboid, largest
from orthospec.workspace.field import State, node_states, together
from orthospec.workspace.fit import FitProblem
from orthospec.workspace.grid import make_grid

LEVELS = (5e-2, 2e-2, 1e-2, 1e-6)
WORST = 1e3
"""What a design without a machine or a cuboid is worth."""


class Enough(Exception):
    """The time is up, or the tightest level reached."""


class Spent(NamedTuple):
    """What it took to come to a level."""

    designs: int
    poses: int
    seconds: float


@dataclass
class Meter:
    """Counts what is asked of machines, and what had been spent when each level was first reached."""

    optimum: float
    designs: int = 0
    poses: int = 0
    start: float = field(default_factory=time.process_time)
    reached: dict[float, Spent] = field(default_factory=dict)

    @property
    def spent(self) -> Spent:
        return Spent(self.designs, self.poses, time.process_time() - self.start)

    def note(self, factor: float, held: bool) -> None:
        """A design with this λ was judged."""
        for level in LEVELS:
            if held and level not in self.reached and abs(factor - self.optimum) <= level:
                self.reached[level] = self.spent


@contextmanager
def metered(optimum: float) -> Iterator[Meter]:
    """A meter that sees each design built and each block of poses."""
    meter, design, close = Meter(optimum), Spec.design, prismatic.close

    def counted_design(spec: Spec, values: Any) -> Any:
        meter.designs += 1
        return design(spec, values)

    def counted_close(machine: Any, poses: Any) -> Any:
        meter.poses += len(poses)
        return close(machine, poses)

    with patch.object(Spec, "design", counted_design), patch.object(prismatic, "close", counted_close):
        yield meter


@dataclass
class Rival:
    """A problem as the grid shows it."""

    problem: SpecProblem
    divisions: float
    limit: float
    meter: Meter

    def __post_init__(self) -> None:
        self.spec = self.problem.spec()
        self.variables = self.spec.variables

    def measure(self, z: Any) -> tuple[list[float], float]:
        """Each goal's miss over its weight, and how far the grid's scale is below 1, of a scaled design."""
        if self.meter.spent.seconds > self.limit or LEVELS[-1] in self.meter.reached:
            raise Enough
        gaps, shortage = self._misses(np.clip(z, 0, 1))
        self.meter.note(max(gaps), held=shortage <= 0)
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
        placed = largest(together(states) == State.MEETS)
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


def ours(problem: SpecProblem) -> Meter:
    """orthospec's whole search: all starts, each solved to the end."""
    assess = FitProblem.assess
    with metered(problem.optimum) as meter:

        def noted(fit: FitProblem, x: Any) -> Assessment:
            found = assess(fit, x)
            objective = fit._objective
            if isinstance(objective, GoalObjective):
                meter.note(found.factor * objective.unit, held=found.violation <= FEASIBLE)
            return found

        with patch.object(FitProblem, "assess", noted):
            problem.solve()
    return meter


def compare(name: str, problem: SpecProblem, divisions: float, limit: float) -> None:
    mine = ours(problem)
    print(f"{name}\n  {'':10} {'within':>7} {'designs':>8} {'poses':>10} {'seconds':>9}   times orthospec's")
    for level in LEVELS:
        _print_row("orthospec", level, mine.reached.get(level), None)
    for title, optimise in RIVALS.items():
        with metered(problem.optimum) as meter, suppress(Enough):
            optimise(Rival(problem, divisions, limit, meter))
        for level in LEVELS:
            _print_row(title, level, meter.reached.get(level), mine.reached.get(level))
        print(
            f"  {title:10} in all  {meter.designs:8} {meter.poses:10.2g} {meter.spent.seconds:9.1f}",
            flush=True,
        )


def _print_row(title: str, level: float, spent: Spent | None, mine: Spent | None) -> None:
    if spent is None:
        print(f"  {title:10} {level:7g} {'never':>8}", flush=True)
        return
    times = ", ".join(f"{a / b:.2g}" for a, b in zip(spent, mine, strict=True)) if mine else ""
    print(
        f"  {title:10} {level:7g} {spent.designs:8} {spent.poses:10.2g} {spent.seconds:9.2f}   {times}",
        flush=True,
    )


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
    asked.add_argument("--divisions", type=float, default=40.0, help="of the prescribed size on the grid")
    given = asked.parse_args()
    for name in given.names or known:
        compare(name, known[name], given.divisions, given.limit)


if __name__ == "__main__":
    main()

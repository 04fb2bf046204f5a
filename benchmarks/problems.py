"""Problems with known optima, and how near the solver comes to them.

python benchmarks/problems.py                  the table: error, subproblems, time
python benchmarks/problems.py --starts 200     from 200 random designs of five of them: how many get there

``optima.py`` derives the optima. Goals are weighted so that λ is of order 1, mostly relative to the goal;
the error is that of λ.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np
import optima
from mpmath import mpf

from orthospec.composite.goals import attain_goals
from orthospec.optimise import run
from orthospec.spec import Spec, load_spec

ACCURACY = 1e-6
"""The error below which an optimum counts as found."""
RANDOM = ("shortest legs", "flat, sum", "lightest legs", "legs and drives", "stroke and legs")
"""Problems started at random."""


@dataclass(frozen=True)
class Solved:
    """How a problem was solved."""

    error: float
    subproblems: int
    seconds: float


@dataclass(frozen=True)
class SpecProblem:
    """A spec and the λ of its optimum."""

    text: str
    optimum: float

    def spec(self, *settings: str) -> Spec:
        """The spec, with KEY=VALUE overrides."""
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "problem.yaml"
            path.write_text(self.text, encoding="utf-8")
            return load_spec(path, settings)

    @property
    def variables(self) -> int:
        return len(self.spec().variables)

    def solve(self, *settings: str) -> Solved:
        """What a run of the spec finds, without the proof and the prices that follow."""
        with patch.object(run, "find_limits", lambda *_: ()):
            outcome = run.solve(self.spec("proof=false", *settings))
        attainment, solves = outcome.finding.attainment, outcome.log["solves"]
        factor = attainment.factor if attainment is not None and outcome.finding.evaluation.holds else None
        error = np.inf if factor is None else abs(factor - self.optimum)
        count = sum(int(one["iterates"][-1]["subproblems"]) for one in solves if one["iterates"])
        return Solved(error, count, outcome.log["seconds"]["optimise"])

    def solve_from(self, z: Sequence[float]) -> Solved:
        """The same from one design: each variable so far along its range."""
        ranges = self.spec().variables.items()
        starts = [
            f"variables.{name}.start={float(v.min + part * (v.max - v.min))!r}"
            for (name, v), part in zip(ranges, z, strict=True)
        ]
        return self.solve("optimise.starts=1", *starts)


@dataclass(frozen=True)
class FunctionProblem:
    """Plain functions with goals, weights, a box and a start, and the λ of their optimum."""

    functions: Callable[[Any], Any]
    goals: tuple[float, ...]
    weights: tuple[float, ...]
    start: tuple[float, ...]
    optimum: float
    box: tuple[float, float] = (-np.inf, np.inf)

    @property
    def variables(self) -> int:
        return len(self.start)

    def solve(self) -> Solved:
        start = time.perf_counter()
        found = attain_goals(self.functions, self.start, self.goals, self.weights, *self.box)
        return Solved(abs(found.factor - self.optimum), found.subproblems, time.perf_counter() - start)


Problem = SpecProblem | FunctionProblem


def known(
    factor: Any, variables: str, machine: str, measures: str, *goals: str, workspace: str = ""
) -> SpecProblem:
    """A problem of which the optimal λ is known; a goal without a weight has one relative to it."""
    weighed = (goal if "weight" in goal else f"{goal}, weight: relative" for goal in goals)
    listed = "".join(f"  g{k}: {{{goal}}}\n" for k, goal in enumerate(weighed))
    text = (
        f"orthospec: 1\nvariables: {{{variables}}}\nmanipulator: {{{machine}}}\n"
        f"workspace: {{{workspace or 'size: [0.2, 0.2, 0.2]'}, divisions: 5}}\n"
        f"measures: {{{measures}}}\ngoals:\n{listed}optimise: {{starts: 2}}\n"
    )
    return SpecProblem(text, float(factor))


def least(value: Any, goal: str, *parts: str, workspace: str = "") -> SpecProblem:
    """A problem of which the least value of one expression is known; ``goal`` is EXPRESSION, goal: NUMBER."""
    factor = value / mpf(goal.rsplit(":", 1)[1].strip()) - 1
    return known(factor, *parts, f"minimise: {goal}", workspace=workspace)


def greatest(value: Any, goal: str, *parts: str) -> SpecProblem:
    """The same of a greatest value."""
    factor = 1 - value / mpf(goal.rsplit(":", 1)[1].strip())
    return known(factor, *parts, f"maximise: {goal}")


A, L = mpf("0.2"), mpf("0.4")
"""Edge of the cube, and the legs where they are given [m]."""
LEG = "leg: {min: 0.25, max: 0.6}"
ON_LEG = "use: orthoglide, leg_lengths: [leg, leg, leg]"
GIVEN = "use: orthoglide, leg_lengths: [0.4, 0.4, 0.4]"
FACTORS = "t: {use: velocity_transmission, at_least: 0.5, at_most: 2}"
WIDE = "t: {use: velocity_transmission, at_least: 0.1, at_most: 9}"
FLAT = (
    "base: {min: 1, max: 3, start: 2}, third: {min: 1, max: 3}",
    "use: orthoglide, leg_lengths: [base, base, third]",
    FACTORS,
)


def geometry() -> dict[str, Problem]:
    """Lengths of legs, place and size of the cuboid, joints."""
    legs, flat = optima.shortest_legs(A), "size: [1, 1, 0.8]"
    slides = "s: {use: joint_speed, speed: 1, at_most: 1.1}"
    return {
        "shortest legs": least(legs, "leg, goal: 0.3", LEG, ON_LEG, FACTORS),
        "flat, equal weights": known(
            optima.flat_goals((mpf(1), mpf(1)), mpf("1.3")),
            *FLAT,
            "minimise: base, goal: 1.3, weight: 1",
            "minimise: third, goal: 1.3, weight: 1",
            workspace=flat,
        ),
        "flat, weights 1 : 10": known(
            optima.flat_goals((mpf("0.1"), mpf(1)), mpf("1.3")),
            *FLAT,
            "minimise: base, goal: 1.3, weight: 0.1",
            "minimise: third, goal: 1.3, weight: 1",
            workspace=flat,
        ),
        "flat, sum": least(optima.flat_sum(1), "base + third, goal: 2.5", *FLAT, workspace=flat),
        "flat, total": least(optima.flat_sum(2), "leg_length_total, goal: 4", *FLAT, workspace=flat),
        "best condition": least(
            optima.best_condition(A, mpf("0.33")),
            "worst(c), goal: 2",
            "leg: {min: 0.28, max: 0.33}",
            ON_LEG,
            "c: {use: condition_number, at_most: 5}",
        ),
        "largest cube": greatest(
            2 * mpf("0.31") / (2 * legs), "scale, goal: 1.5", "leg: {min: 0.25, max: 0.31}", ON_LEG, FACTORS
        ),
        "end of the slides": least(
            legs * (1 + 1 / optima.sqrt(18)),
            "rail, goal: 0.4",
            f"{LEG}, rail: {{min: 0.3, max: 1}}",
            f"{ON_LEG}, joint_limits: {{max: rail}}",
            FACTORS,
        ),
        "stroke and legs": known(
            optima.stroke_and_legs(A, mpf("0.3"), mpf("0.2")),
            LEG,
            ON_LEG,
            WIDE,
            "minimise: leg, goal: 0.3",
            "minimise: stroke, goal: 0.2",
        ),
        "legs for slow slides": least(
            optima.legs_for_slides(A, mpf("1.1")), "leg, goal: 0.3", LEG, ON_LEG, slides
        ),
        "legs of a linear Delta": least(
            optima.delta_legs(A, A, mpf("1.25")),
            "leg, goal: 0.5",
            "leg: {min: 0.4, max: 0.9}",
            "use: linear_delta, leg_lengths: [leg, leg, leg], base_radius: 0.25, platform_radius: 0.05",
            "s: {use: joint_speed, speed: 1, at_most: 1.25}",
            workspace="size: [0.2, 0.2, 0.1], region: {min: [-0.4, -0.4, -0.05], max: [0.4, 0.4, 0.05]}",
        ),
    }


STEEL = "material: {E: 210e9, G: 80e9, density: 7800}"
RIGID = "actuators: {stiffness: 1e18}"
ROUND = f"legs: {{kind: PUU, section: {{round: {{diameter: d}}}}, {STEEL}}}, feet: rigid, {RIGID}"
TUBE = f"legs: {{kind: PUU, section: {{round: {{diameter: 0.03, wall: w}}}}, {STEEL}}}, feet: rigid"
FOOT = (
    f"legs: {{kind: PUU, section: rigid}}, {RIGID}, "
    f"feet: {{length: 0.1, section: {{rectangle: {{height: h, width: w}}}}, {STEEL}}}"
)
STIFF = "k: {use: stiffness, at_least: 2e7}"


def factors_of_a_diameter(count: int) -> SpecProblem:
    """The least weighted sum of many variables whose product is the diameter of round legs."""
    costs = [mpf(f"{0.8 + 0.02 * i:.2f}") for i in range(count)]
    names = [f"x{i}" for i in range(count)]
    product = f"0.01 * {' * '.join(names)}"
    return least(
        optima.product_of_many(costs, optima.round_leg(A, L, mpf("2e7")) / mpf("0.01")),
        f"{' + '.join(f'{cost} * {name}' for cost, name in zip(costs, names, strict=True))}, goal: {count}",
        ", ".join(f"{name}: {{min: 0.5, max: 2}}" for name in names),
        f"{GIVEN}, {ROUND.replace('diameter: d', f'diameter: {product}')}",
        STIFF,
    )


def sections() -> dict[str, Problem]:
    """Bars of legs and feet for a stiffness."""
    stiffness = mpf("2e7")
    return {
        "twenty factors": factors_of_a_diameter(20),
        "round legs": least(
            optima.round_leg(A, L, stiffness),
            "d, goal: 0.01",
            "d: {min: 0.005, max: 0.05}",
            f"{GIVEN}, {ROUND}",
            STIFF,
        ),
        "lightest legs": least(
            optima.lightest_legs(A, stiffness),
            "leg * d**2, goal: 5e-5",
            f"{LEG}, d: {{min: 0.005, max: 0.05}}",
            f"{ON_LEG}, {ROUND}",
            STIFF,
        ),
        "wall of a tube": least(
            optima.tube_wall(A, L, mpf("1e8"), stiffness, mpf("0.03")),
            "w, goal: 3e-4",
            "w: {min: 1e-4, max: 5e-3}",
            f"{GIVEN}, {TUBE}, actuators: {{stiffness: 1e8}}",
            "bend: {use: deflection, force: 100, at_most: 5e-6}",
        ),
        "square feet": least(
            optima.square_foot(A, L, mpf("0.1"), stiffness),
            "h * w, goal: 3e-4",
            "h: {min: 0.01, max: 0.06}, w: {min: 0.01, max: 0.06}",
            f"{GIVEN}, {FOOT}",
            STIFF,
        ),
    }


MASSLESS = "legs: {kind: PUU, mass: 0}, feet: rigid"
SLIDER = "m: {min: 0.1, max: 9}", f"{GIVEN}, {MASSLESS}, actuators: {{mass: m}}, platform: {{mass: 1}}"
LIGHT = ROUND.replace("legs: {", "legs: {mass: 0, ").replace("1e18}", "1e18, mass: 1, force: f}")
"""Round legs whose mass is none, sliders of 1 kg."""
THRUST = "f: {min: 5, max: 300}"
QUICK = "a: {use: acceleration, at_least: 20}"


def drives() -> dict[str, Problem]:
    """Masses, forces and speeds of the drives."""
    both = optima.legs_and_drives(A, L, mpf("2e7"), mpf(20), (mpf("0.012"), mpf("21.5")))
    return {
        "heaviest sliders": greatest(
            optima.heaviest_slider(A, L, 1, 8), "m, goal: 4", *SLIDER, "g: {use: gie_norm, at_most: 8}"
        ),
        "sliders for isotropy": greatest(
            optima.slider_for_isotropy(A, L, 1, 2),
            "m, goal: 1",
            *SLIDER,
            "i: {use: dynamic_isotropy, at_most: 2}",
        ),
        "thrust for a platform": least(
            optima.thrust_of_platform(A, L, 40),
            "f, goal: 40",
            THRUST,
            f"{GIVEN}, {MASSLESS}, actuators: {{mass: 0, force: f}}, platform: {{mass: 2}}",
            QUICK,
        ),
        "drives that carry themselves": least(
            optima.thrust_of_itself(A, L, 20, 1, 250),
            "f, goal: 20",
            THRUST,
            f"{GIVEN}, {MASSLESS}, actuators: {{mass: 1 + f / 250, force: f}}, platform: {{mass: 0}}",
            QUICK,
        ),
        "speed and legs": known(
            optima.drives_and_legs(A, 1, 1, mpf("0.3")),
            f"{LEG}, v: {{min: 0.5, max: 5}}",
            f"{ON_LEG}, actuators: {{speed: v}}",
            "s: {use: tool_speed, at_least: 1}",
            "minimise: v, goal: 1",
            "minimise: leg, goal: 0.3",
        ),
        "legs and drives": known(
            both,
            f"d: {{min: 0.005, max: 0.05}}, {THRUST}",
            f"{GIVEN}, {LIGHT}, platform: {{mass: 0}}",
            f"{STIFF}, {QUICK}",
            "minimise: d, goal: 0.012",
            "minimise: f, goal: 21.5",
        ),
    }


def parabolas(x: Any) -> list[float]:
    return [2 + (x[0] - 3) ** 2, 5 + x[0] ** 2 / 4]


def real_poles(x: Any) -> Any:
    a = np.array([[-0.5, 0, 0], [0, -2, 10], [0, 1, -2]])
    b = np.array([[1, 0], [-2, 2], [0, 1]])
    c = np.array([[1, 0, 0], [0, 0, 1]])
    return np.sort(np.linalg.eigvals(a + b @ np.reshape(x, (2, 2)) @ c).real)


def fgoalattain() -> dict[str, Problem]:
    """The two examples in the manual of MATLAB's function of this name; the first has x = 2, λ = 0."""
    poles = float(optima.pole_placement())
    return {
        "fgoalattain, parabolas": FunctionProblem(parabolas, (3, 6), (1, 1), (0.5,), 0.0),
        "fgoalattain, poles": FunctionProblem(real_poles, (-5, -3, -1), (5, 3, 1), (-1,) * 4, poles, (-4, 4)),
    }


def problems() -> dict[str, Problem]:
    """All of them, by name."""
    return {**geometry(), **sections(), **drives(), **fgoalattain()}


def print_table() -> None:
    print(f"{'problem':30} {'variables':>9} {'error':>9} {'subproblems':>12} {'time [s]':>9}")
    for name, problem in problems().items():
        found = problem.solve()
        print(
            f"{name:30} {problem.variables:9} {found.error:9.1e} {found.subproblems:12} {found.seconds:9.2f}",
            flush=True,
        )


def print_shares(starts: int) -> None:
    """Random designs are uniform in the variables' ranges, and the same in each run."""
    print(f"{'problem':30} {'starts':>7} {'optimum':>8} {'greatest error':>15} {'most subproblems':>17}")
    for name in RANDOM:
        problem = problems()[name]
        assert isinstance(problem, SpecProblem)
        designs = np.random.default_rng(0).random((starts, problem.variables))
        found = [problem.solve_from(z) for z in designs]
        share = sum(one.error < ACCURACY for one in found) / starts
        worst, most = max(one.error for one in found), max(one.subproblems for one in found)
        print(f"{name:30} {starts:7} {share:8.1%} {worst:15.1e} {most:17}", flush=True)


def main() -> None:
    asked = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    asked.add_argument("--starts", type=int, help="random starts of each of five problems")
    starts = asked.parse_args().starts
    print_shares(starts) if starts else print_table()


if __name__ == "__main__":
    main()

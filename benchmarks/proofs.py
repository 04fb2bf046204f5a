"""What a proof costs: boxes and seconds by slack, against the nodes that a grid of equal resolution has.

python benchmarks/proofs.py [SPEC ...] [--set KEY=VALUE ...]        needs orthospec[bench]

Each spec is solved, and its prescribed cuboid proved at several slacks. A grid is as fine as a slack when no
value changes by more than it over half a cell's diagonal: its step follows from the steepest slope of any
excess at 20000 random poses. It would prove nothing all the same. Then the same cuboid is moved by 1 mm along
each axis, and the scale of the largest one enclosed.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import cvxpy  # noqa: F401  # no one's imports are timed
import numpy as np

from orthospec.optimise.hunt import hunt
from orthospec.optimise.space import DesignSpace
from orthospec.optimise.workers import Here
from orthospec.spec import load_spec
from orthospec.workspace.conditions import Condition, Sample, conditions_of
from orthospec.workspace.cuboid import Cuboid
from orthospec.workspace.guarantee import bracket, proof_over
from orthospec.workspace.machine import Machine

SPECS = Path(__file__).parents[1] / "specs"
NAMES = ("orthoglide-200", "orthoglide-200-drives", "linear-delta-300")
SLACKS = (1e-2, 1e-3, 1e-4, 1e-6)
BOXES = 200_000
POSES = 20_000
STEP = 1e-6

T = TypeVar("T")


def timed(work: Callable[[], T]) -> tuple[T, float]:
    """The best of three."""
    seconds = []
    for _ in range(3):
        start = time.perf_counter()
        found = work()
        seconds.append(time.perf_counter() - start)
    return found, min(seconds)


def steepest(machine: Machine, cuboid: Cuboid) -> float:
    """The greatest slope of any excess at random poses [1/m]."""
    d, axes = len(cuboid.low), len(machine.manipulator.axes)
    u = np.random.default_rng(0).uniform(-0.5, 0.5, (POSES, d))
    conditions = conditions_of(machine.manipulator, list(machine.demands.values()), np.zeros((1, axes)))
    bounds = [condition for condition in conditions if isinstance(condition, Condition)]

    def rows(u: Any) -> Any:
        return Sample(machine, cuboid.poses(u, axes)).rows(bounds, [], {})

    slopes = [(rows(u + h) - rows(u - h)) / (2 * STEP) for h in STEP * np.eye(d) / cuboid.size]
    return float(np.nanmax(np.linalg.norm(slopes, axis=0)))


def tell(path: Path, sets: list[str]) -> None:
    space = DesignSpace(load_spec(path, sets))
    best = hunt(space, Here()).best
    assert best is not None
    machine = space.machine(best.end.design)
    cuboid = best.end.cuboids(space)[""]
    slope, d = steepest(machine, cuboid), len(cuboid.low)
    print(f"{path.stem}: the steepest excess changes by {slope:.3g} a metre")
    for slack in SLACKS:
        proof, seconds = timed(lambda slack=slack: proof_over(machine, cuboid, slack, BOXES))  # type: ignore[misc]
        step = 2 * slack / slope / d**0.5
        nodes = float(np.prod(cuboid.size / step))
        print(f"  slack {slack:g}: {proof.verdict}, {proof.boxes} boxes, {seconds:.3f} s; {nodes:.1e} nodes")
    moved = Cuboid.around(cuboid.centre + 1e-3, cuboid.size)
    proof, seconds = timed(lambda: proof_over(machine, moved, 1e-3, BOXES))
    print(f"  moved by 1 mm: {proof.verdict}, {proof.condition} at {proof.at}, {seconds:.3f} s")
    size, region = space.setting.size, space.setting.region
    ends, seconds = timed(lambda: bracket(machine, size, cuboid, best.end.scale, region, BOXES))
    print(f"  scale {best.end.scale}: from {ends.least} to {ends.most}, {seconds:.2f} s", flush=True)


def main() -> None:
    asked = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    asked.add_argument("specs", nargs="*", type=Path, metavar="SPEC")
    asked.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", dest="sets")
    given = asked.parse_args()
    for path in given.specs or [SPECS / f"{name}.yaml" for name in NAMES]:
        tell(path, given.sets)


if __name__ == "__main__":
    main()

"""Nested cubes of an Orthoglide for velocity and for stiffness bounds: where they lie, and what they cost.

python benchmarks/nested_cubes.py [divisions]

The study of section 6.2 of Pashkevich, Chablat and Wenger (2009) on ``specs/orthoglide-200-nested.yaml``,
whose cube of 50 mm in 50 divisions has the paper's grid of 1 mm over the region, 251 nodes an edge. For each
velocity level it finds the stiffness bound whose largest cube has the same edge, and tells how far apart the
two cubes' centres lie, as a part of the edge. Then the time and peak memory of the fields, and the stiffness
of a block of poses beside the straightforward way: eq. 6 as a bordered matrix for each chain, inverted in
batches.
"""

from __future__ import annotations

import resource
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import brentq

from orthospec import evaluate_spec, load_spec
from orthospec.manipulators.prismatic import PrismaticManipulator
from orthospec.measures import Demand
from orthospec.mechanics import virtual_joints as vj
from orthospec.mechanics.parallelogram import parallelogram_stiffness
from orthospec.workspace.cuboid import Cuboid
from orthospec.workspace.machine import Machine
from orthospec.workspace.polish import Polished, polish

SPEC = Path(__file__).parents[1] / "specs" / "orthoglide-200-nested.yaml"
POSES = 1 << 15
ROUNDS = 5


def same_edge(machine: PrismaticManipulator, stiffness: Any, cube: Cuboid) -> tuple[float, Cuboid]:
    """The stiffness bound whose largest cube has the edge of this one, and that cube."""
    size = np.asarray(cube.size)

    def largest(logarithm: float) -> Polished | None:
        demand = Demand("stiffness", stiffness, {"at_least": float(np.exp(logarithm))})
        return polish(Machine(machine, {"stiffness": demand}), ["stiffness"], size, [cube])

    centre = float(np.log(stiffness.values(machine, cube.poses(np.full((1, 3), -0.5), 3))[0]))

    def surplus(logarithm: float) -> float:
        found = largest(logarithm)
        return -1.0 if found is None else found.scale - 1.0

    root = brentq(surplus, centre - 1.0, centre + 1.0, xtol=1e-9)
    return float(np.exp(root)), largest(root).cuboid


def straightforward(machine: PrismaticManipulator, poses: np.ndarray) -> np.ndarray:
    """Compliance by eq. 6 chain by chain, the bordered matrices inverted in batches."""
    n, geometry, springs = len(poses), machine.geometry, machine.springs
    s = np.moveaxis(machine.closed_legs(poses).s, 2, 0)
    total = np.zeros((n, 6, 6))
    for i in range(3):
        x, a = -s[:, i] / geometry.lengths[i], geometry.revolutes[i]
        z = np.cross(x, a)
        cosine = np.linalg.norm(z, axis=1)
        z /= cosine[:, None]
        frames = np.stack([x, np.cross(z, x), z], axis=1)
        inner, outer = np.tile(geometry.joints[i, :, 0], (n, 1)), geometry.joints[i, :, 0] + s[:, i]
        pair = parallelogram_stiffness(springs.bars[i], spacing=springs.spacing, cos=cosine, sin=x @ a)
        space = np.broadcast_to(np.eye(3), (n, 3, 3))
        drive = np.tile(np.concatenate([geometry.axes[i], np.zeros(3)]), (n, 1))
        compliance = vj.spring_at(np.linalg.pinv(pair, hermitian=True), frames, inner)
        compliance += vj.spring_at(springs.feet[i], space, outer) + vj.actuator(drive, springs.actuator)
        hinge, slide = (
            np.concatenate([np.zeros(3), a]),
            np.concatenate([frames[:, 1], np.zeros((n, 3))], axis=1),
        )
        passive = np.stack(
            [vj.transported_twists(hinge, outer), vj.transported_twists(hinge, inner), slide], axis=1
        )
        bordered = np.zeros((n, 9, 9))
        bordered[:, :6, :6] = compliance * 1e8
        bordered[:, 6:, :6] = passive
        bordered[:, :6, 6:] = np.swapaxes(passive, 1, 2)
        total += np.linalg.inv(bordered)[:, :6, :6] * 1e8
    return np.linalg.inv(total)


def best_time(work: Any) -> float:
    times = []
    for _ in range(ROUNDS):
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
    return min(times)


def main() -> None:
    divisions = sys.argv[1] if len(sys.argv) > 1 else "50"
    spec = load_spec(SPEC, [f"workspace.divisions={divisions}"])
    start = time.perf_counter()
    evaluation = evaluate_spec(spec).finding.evaluation
    seconds = time.perf_counter() - start
    nodes = sum(evaluation.measures["stiffness"].largest.nodes.values())
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024

    design = spec.design({})
    machine = design.manipulator
    stiffness = next(demand.measure for demand in design.demands if demand.name == "stiffness")
    print("velocity within   edge [mm]  centre [mm]   same edge: stiffness [N/um]  centre [mm]  apart / edge")
    for demand in design.demands:
        if not demand.name.startswith("speed"):
            continue
        cube = evaluation.measures[demand.name].largest.cuboid
        bound, twin = same_edge(machine, stiffness, cube)
        edge = float(cube.size[0])
        apart = float(np.linalg.norm(cube.centre - twin.centre)) / edge
        most = demand.bounds["at_most"]
        print(
            f"1/{most:<4g} ... {most:<4g} {1e3 * edge:11.3f} {1e3 * cube.centre[0]:12.3f}"
            f" {bound / 1e6:29.4f} {1e3 * twin.centre[0]:12.3f} {apart:13.2%}"
        )
    print(f"\n{nodes} nodes, {len(evaluation.measures)} measures: {seconds:.1f} s, peak {peak:.0f} MiB")

    poses = np.random.default_rng(0).uniform(-0.126, 0.073, (POSES, 3))
    ours = best_time(lambda: machine.compliance(poses))
    theirs = best_time(lambda: straightforward(machine, poses))
    difference = np.abs(machine.compliance(poses) / straightforward(machine, poses) - 1)[
        :, range(6), range(6)
    ].max()
    print(
        f"compliance of {POSES} poses: {1e9 * ours / POSES:.0f} ns a pose, straightforward"
        f" {1e9 * theirs / POSES:.0f} ns: {theirs / ours:.0f} times (they differ by {difference:.0e})"
    )


if __name__ == "__main__":
    main()

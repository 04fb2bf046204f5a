"""Five nested cuboids for the stiffness of an Orthoglide with parallelograms, on a grid of 8.1 million nodes.

python benchmarks/stiffness.py [EDGE]      nodes along an edge of the 200 mm cube, 201 if left out: 1 mm apart

Ours is `orthospec evaluate`: from the spec to the five cuboids, polished. Beside it stands what it replaces:
eq. 6 of Pashkevich, Chablat and Wenger (2009) as a bordered matrix for each chain, inverted by NumPy in
batches, and its least stiffness compared with the bounds; no cuboids, and no polish. Both have two processes.
"""

from __future__ import annotations

import resource
import statistics
import sys
import tempfile
import time
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np
from nested_cubes import straightforward

from orthospec import evaluate_spec, load_spec
from orthospec.optimise.workers import hired
from orthospec.spec import Spec

EDGE, PROCESSES, ROUNDS = 201, 2, 3
BLOCK = 1 << 15
SAMPLE = 16
"""Blocks that the straightforward way is timed on, spread over the grid; the others take as long."""
LEAST = (10e6, 15e6, 20e6, 25e6, 30e6)
"""Stiffness bounds [N/m]."""
SPEC = """
orthospec: 1
manipulator:
  use: orthoglide
  leg_lengths: [310.583 mm, 310.583 mm, 310.583 mm]
  joint_limits: {{}}
  legs:
    kind: PRPaR
    section: {{rectangle: {{height: 14 mm, width: 14 mm}}}}
    material: aluminium
    spacing: 80 mm
  actuators: {{stiffness: 50 N/um}}
workspace:
  size: [200 mm, 200 mm, 200 mm]
  divisions: {divisions}
  region: {{min: [-127 mm, -127 mm, -127 mm], max: [73 mm, 73 mm, 73 mm]}}
measures:
  stiffness: {{use: stiffness, at_least: 10 N/um, levels: {{at_least: [15 N/um, 20 N/um, 25 N/um, 30 N/um]}}}}
proof: false
"""


def axis(edge: int) -> np.ndarray:
    return np.linspace(-0.127, 0.073, edge)


def poses_of(start: int, edge: int) -> np.ndarray:
    """Those of a block."""
    nodes = np.arange(start, min(start + BLOCK, edge**3))
    return axis(edge)[np.stack(np.unravel_index(nodes, (edge,) * 3), axis=1)]


def least_stiffness(start: int, edge: int) -> np.ndarray:
    """Of each pose of a block [N/m], and how many bounds it meets."""
    compliance = straightforward(load(edge).design({}).manipulator, poses_of(start, edge))[:, :3, :3]
    least = 1.0 / np.linalg.eigvalsh(compliance)[:, -1]
    return np.stack([least, (least[:, None] >= LEAST).sum(axis=1)])


def load(edge: int) -> Spec:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "spec.yaml"
        path.write_text(SPEC.format(divisions=edge - 1), encoding="utf-8")
        return load_spec(path)


def ours(edge: int) -> tuple[float, list[tuple[float, int]]]:
    """Seconds; then for each bound the edge of its cuboid [m], and how many nodes meet it."""
    spec = load(edge)
    with hired(PROCESSES) as workers:
        start = time.perf_counter()
        measured = evaluate_spec(spec, workers=workers).finding.evaluation.measures["stiffness"]
        seconds = time.perf_counter() - start
    found = [measured.largest, *(largest for _, largest in measured.levels)]
    return seconds, [(float(one.cuboid.size[0]), one.nodes["meets"]) for one in found]


def theirs(edge: int) -> float:
    """Seconds for all nodes, by those of a sample."""
    starts = np.unique(np.linspace(0, (edge**3 - 1) // BLOCK, SAMPLE).astype(int)) * BLOCK
    with ProcessPoolExecutor(PROCESSES) as pool:
        list(pool.map(least_stiffness, starts[:PROCESSES], [edge] * PROCESSES))
        start = time.perf_counter()
        found = list(pool.map(least_stiffness, starts, [edge] * len(starts)))
        seconds = time.perf_counter() - start
    check(edge, starts, found)
    return seconds / sum(one.shape[1] for one in found) * edge**3


def check(edge: int, starts: np.ndarray, found: list[np.ndarray]) -> None:
    """Both ways give the same stiffness."""
    design = load(edge).design({})
    (demand,) = design.demands
    for start, (least, _) in zip(starts, found, strict=True):
        values = demand.measure.values(design.manipulator, poses_of(start, edge))
        np.testing.assert_allclose(values, least, rtol=1e-7)


def main(edge: int) -> None:
    seconds: dict[str, list[float]] = {"orthospec evaluate, five cuboids": [], "eq. 6 inverted by NumPy": []}
    for _ in range(ROUNDS):
        mine, cubes = ours(edge)
        usages = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
        for taken, one in zip(seconds.values(), (mine, theirs(edge)), strict=True):
            taken.append(one)
    print(f"{edge**3} nodes, {PROCESSES} processes, medians of {ROUNDS}; least and greatest in brackets")
    for name, taken in seconds.items():
        print(f"  {name:<34}{statistics.median(taken):9.2f} s  ({min(taken):.2f} ... {max(taken):.2f})")
    first, second = map(statistics.median, seconds.values())
    peak = max(usage.ru_maxrss for usage in usages) / 2**20
    print(f"  ratio {second / first:.0f}; our greatest peak of a process {peak:.2f} GiB")
    for bound, (size, count) in zip(LEAST, cubes, strict=True):
        print(f"  at least {1e-6 * bound:.0f} N/um: {1e3 * size:8.3f} mm, {count} nodes meet it")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else EDGE)

"""Whole fields beside batched NumPy, their growth with the grid, and what memory they take.

python benchmarks/fields.py [EDGE...]      edges in nodes; 33 65 129 201 257 if left out, 513 takes a minute
"""

from __future__ import annotations

import resource
import sys
import time

import numpy as np

from orthospec.manipulators.orthoglide import Orthoglide
from orthospec.measures import Demand
from orthospec.measures.elastic import Deflection
from orthospec.measures.kinematic import VelocityTransmission
from orthospec.workspace.cuboid import largest
from orthospec.workspace.field import State, node_states
from orthospec.workspace.grid import Grid

EDGES = (33, 65, 129, 201, 257)
SAMPLE = 200_000
"""Poses for the way in NumPy, which is slow: its time is told for as many as the field has."""
LEG, LOW, SIDE = 0.310583, -0.126795, 0.2
PARTS = {
    "legs": {
        "kind": "PRPaR",
        "section": {"rectangle": {"height": 0.014, "width": 0.014}},
        "material": "aluminium",
        "spacing": 0.08,
    },
    "actuators": {"stiffness": 5e7},
}


def grid_of(edge: int) -> Grid:
    """The 200 mm cube in so many nodes a side."""
    step = SIDE / (edge - 1)
    first = round(LOW / step)
    return Grid((step,) * 3, (first,) * 3, (edge,) * 3, 3)


def by_numpy(grid: Grid) -> float:
    """Seconds for velocity factors by batched SVD, as a user would write it."""
    poses = grid.poses(0, min(SAMPLE, grid.nodes))
    start = time.perf_counter()
    squares = np.sum(poses**2, axis=1)[:, None] - poses**2
    sliders = poses + np.sqrt(LEG**2 - squares)
    ways = sliders[:, :, None] * np.eye(3) - poses[:, None, :]
    inverse = ways / np.einsum("nii->ni", ways)[:, :, None]
    factors = np.linalg.svd(np.linalg.inv(inverse), compute_uv=False)
    np.count_nonzero((factors[:, -1] >= 0.5) & (factors[:, 0] <= 2))
    return (time.perf_counter() - start) / len(poses) * grid.nodes


def field(machine: Orthoglide, demand: Demand, grid: Grid) -> tuple[float, int]:
    """Seconds for the states of all nodes and the largest cube among them, and its steps."""
    start = time.perf_counter()
    (states,), _ = node_states(machine, [demand], grid)
    found = largest(states == State.MEETS)
    return time.perf_counter() - start, found.steps if found else 0


def main(edges: tuple[int, ...]) -> None:
    machine = Orthoglide.model_validate({"leg_lengths": [LEG] * 3, **PARTS})
    velocity = Demand("velocity", VelocityTransmission(), {"at_least": 0.5, "at_most": 2.0})
    stiff = Demand("deflection", Deflection(force=100.0), {"at_most": 15e-6})
    print("edge      nodes  velocity  ns a node  NumPy SVD  ratio     peak")
    for edge in edges:
        grid = grid_of(edge)
        seconds, _ = field(machine, velocity, grid)
        rival = by_numpy(grid)
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
        each = seconds / grid.nodes * 1e9
        ours = f"{edge:4d} {grid.nodes:10d} {seconds:8.3f}s {each:10.1f}"
        print(f"{ours} {rival:9.2f}s {rival / seconds:6.1f} {peak:5.2f}GiB")
    grid = grid_of(65)
    seconds, _ = field(machine, stiff, grid)
    print(f"\ndeflection of parallelograms, {grid.nodes} nodes: {seconds / grid.nodes * 1e9:.0f} ns a node")


if __name__ == "__main__":
    main(tuple(map(int, sys.argv[1:])) or EDGES)

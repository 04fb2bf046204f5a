"""Whole fields with the largest cube in them, beside what a user would write; their growth, and their memory.

python benchmarks/fields.py [EDGE...]      nodes along an edge, in which the field grows; to 513 if left out

All on one thread. The rivals judge each node for itself: by singular values of batched matrices in NumPy, and
by a loop in numba that keeps to + − * / and a root and makes nothing but the mask.
"""

from __future__ import annotations

import math
import resource
import sys
import time
from dataclasses import dataclass
from typing import Any

import numba
import numpy as np
from timing import compare

from orthospec.kernels import largest_cube
from orthospec.manipulators.orthoglide import Orthoglide
from orthospec.measures import Demand
from orthospec.measures.dynamic import JointSpeed
from orthospec.measures.elastic import Deflection, Rotation, Stiffness
from orthospec.measures.kinematic import ConditionNumber, VelocityTransmission
from orthospec.workspace.cells import FindStates, grid_states
from orthospec.workspace.field import State, node_states, together
from orthospec.workspace.grid import Grid

EDGES = (33, 65, 129, 201, 257, 513)
EDGE, ROUNDS = 201, 3
BLOCK = 1 << 16
LEG, LOW, SIDE, REACH = 0.310583, -0.126795, 0.2, 0.35
LEAST, MOST = 0.5, 2.0
PARTS = {
    "legs": {
        "kind": "PRPaR",
        "section": {"rectangle": {"height": 0.014, "width": 0.014}},
        "material": "aluminium",
        "spacing": 0.08,
    },
    "actuators": {"stiffness": 5e7},
}
VELOCITY = Demand("velocity", VelocityTransmission(), {"at_least": LEAST, "at_most": MOST})
STIFF = Demand("deflection", Deflection(force=100.0), {"at_most": 15e-6})
MORE = (
    VELOCITY,
    STIFF,
    Demand("condition", ConditionNumber(), {"at_most": 3.0}),
    Demand("joints", JointSpeed(speed=1.0), {"at_most": 2.5}),
    Demand("stiffness", Stiffness(), {"at_least": 5e6}),
    Demand("rotation", Rotation(force=100.0), {"at_most": 1e-3}),
)


@dataclass(frozen=True)
class Room:
    """A cube, by its least coordinate and its side."""

    low: float
    side: float

    def grid(self, edge: int) -> Grid:
        """So many nodes a side."""
        step = self.side / (edge - 1)
        return Grid((step,) * 3, (round(self.low / step),) * 3, (edge,) * 3, 3)


ROOMS = {"the 200 mm cube": Room(LOW, SIDE), "the whole reach": Room(-REACH, 2 * REACH)}


def by_numpy(grid: Grid) -> np.ndarray:
    """Which nodes meet the bounds, by batched singular values."""
    met = np.empty(grid.nodes, dtype=bool)
    for start in range(0, grid.nodes, BLOCK):
        poses = grid.poses(start, min(start + BLOCK, grid.nodes))
        squares = LEG**2 - (np.sum(poses**2, axis=1)[:, None] - poses**2)
        reached = (squares > 0).all(axis=1)
        sliders = poses + np.sqrt(np.where(squares > 0, squares, 1.0))
        ways = sliders[:, :, None] * np.eye(3) - poses[:, None, :]
        inverse = ways / np.einsum("nii->ni", ways)[:, :, None]
        factors = 1.0 / np.linalg.svd(inverse, compute_uv=False)
        within = (factors[:, 0] >= LEAST) & (factors[:, -1] <= MOST)
        met[start : start + len(poses)] = reached & within & (np.linalg.det(inverse) > 0)
    return met.reshape(grid.shape)


@numba.njit(fastmath=True, error_model="numpy")
def fused(first: float, step: float, edge: int, mask: np.ndarray) -> None:
    """The same by leading minors of AᵀA − b² I, with A the inverse Jacobian, and of a² I − AᵀA."""
    low, high = 1.0 / MOST**2, 1.0 / LEAST**2
    for i in range(edge):
        for j in range(edge):
            for k in range(edge):
                x, y, z = first + step * i, first + step * j, first + step * k
                p, q, r = LEG**2 - y * y - z * z, LEG**2 - x * x - z * z, LEG**2 - x * x - y * y
                a, b, c = (
                    1 / math.sqrt(max(p, 1e-9)),
                    1 / math.sqrt(max(q, 1e-9)),
                    1 / math.sqrt(max(r, 1e-9)),
                )
                a12, a13, a21, a23, a31, a32 = -y * a, -z * a, -x * b, -z * b, -x * c, -y * c
                xx, yy, zz = 1 + a21 * a21 + a31 * a31, 1 + a12 * a12 + a32 * a32, 1 + a13 * a13 + a23 * a23
                xy, xz, yz = a12 + a21 + a31 * a32, a13 + a31 + a21 * a23, a23 + a32 + a12 * a13
                volume = 1 - a23 * a32 - a12 * (a21 - a23 * a31) + a13 * (a21 * a32 - a31)
                reached = (p > 0) & (q > 0) & (r > 0) & (volume > 0)
                slow = positive(xx - low, yy - low, zz - low, xy, xz, yz)
                fast = positive(high - xx, high - yy, high - zz, -xy, -xz, -yz)
                mask[i, j, k] = reached & slow & fast


@numba.njit(fastmath=True, inline="always")
def positive(xx: float, yy: float, zz: float, xy: float, xz: float, yz: float) -> bool:
    """Whether a symmetric matrix has no negative leading minor."""
    minor = xx * yy - xy * xy
    whole = xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz)
    return (xx >= 0) & (minor >= 0) & (whole >= 0)


def by_numba(grid: Grid) -> np.ndarray:
    mask = np.empty(grid.shape, dtype=np.bool_)
    fused(grid.first[0] * grid.step[0], grid.step[0], grid.shape[0], mask)
    return mask


def ours(machine: Orthoglide, demands: tuple[Demand, ...], grid: Grid, states_of: FindStates) -> np.ndarray:
    """Which nodes meet all demands."""
    states, _ = states_of(machine, demands, grid, None)
    return together(states) == State.MEETS


def compare_fields(machine: Orthoglide) -> None:
    """Velocity factors in the 200 mm cube and over the whole reach."""
    for title, room in ROOMS.items():
        grid = room.grid(EDGE)
        ways: dict[str, Any] = {
            "by cells, as runs do": lambda grid=grid: ours(machine, (VELOCITY,), grid, grid_states),
            "each node for itself": lambda grid=grid: ours(machine, (VELOCITY,), grid, node_states),
            "a fused loop in numba": lambda grid=grid: by_numba(grid),
            "NumPy's batched SVD": lambda grid=grid: by_numpy(grid),
        }
        masks = {name: way() for name, way in ways.items()}
        first = masks.pop("by cells, as runs do")
        np.testing.assert_array_equal(first, masks.pop("each node for itself"))
        for name, mask in masks.items():
            # Rounding may differ where a node lies on a bound.
            assert np.count_nonzero(mask != first) <= 8, name
            assert largest_cube(mask) == largest_cube(first), name
        rivals = {name: lambda way=way: largest_cube(way()) for name, way in ways.items()}
        compare(f"velocity factors, {EDGE}^3 nodes of {title}", rivals, grid.nodes, ROUNDS)


def compare_demands(machine: Orthoglide) -> None:
    """What a further measure costs."""
    for title, room in ROOMS.items():
        grid = room.grid(EDGE)
        rivals = {
            f"{count} measures, the last {MORE[count - 1].name}": (
                lambda demands=MORE[:count], grid=grid: ours(machine, demands, grid, grid_states)
            )
            for count in range(1, len(MORE) + 1)
        }
        compare(f"growth with measures, {EDGE}^3 nodes of {title}", rivals, grid.nodes, ROUNDS)


def tell_growth(machine: Orthoglide, edges: tuple[int, ...]) -> None:
    """The greatest memory so far of the process stands in each row."""
    print(f"\n{'growth with nodes':<20}{''.join(map('{:>24}'.format, ROOMS))}{'peak':>12}")
    for edge in edges:
        row = f"{f'{edge}^3, {edge**3}':<20}"
        for room in ROOMS.values():
            grid = room.grid(edge)
            start = time.perf_counter()
            largest_cube(ours(machine, (VELOCITY,), grid, grid_states))
            seconds = time.perf_counter() - start
            row += f"{1e3 * seconds:12.1f} ms {1e9 * seconds / grid.nodes:5.1f} ns"
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
        print(f"{row}{peak:8.2f} GiB", flush=True)


def main(edges: tuple[int, ...]) -> None:
    machine = Orthoglide.model_validate({"leg_lengths": [LEG] * 3, **PARTS})
    tell_growth(machine, edges)
    compare_fields(machine)
    compare_demands(machine)


if __name__ == "__main__":
    main(tuple(map(int, sys.argv[1:])) or EDGES)

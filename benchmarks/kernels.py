"""The kernels beside what a user would take instead, as ratios within one run.

python benchmarks/kernels.py
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import edt
import numba
import numpy as np
import timing
from scipy.ndimage import distance_transform_cdt

from orthospec.intervals import Boxes, Interval, fused, twin
from orthospec.kernels import (
    Within,
    chain_compliance,
    cube_ends,
    cube_sizes,
    gram_eigenvalues,
    largest_cube,
    positive_inverse,
    positive_solve,
    row_norms,
    singular_values,
    symmetric_eigenvalues,
    symmetric_eigenvectors,
)

EDGE = 201
MATRICES = 32_768
PLATFORMS = 32_768
BOXES = 512
ROUNDS = 9

Rivals = dict[str, Callable[[Any], Any]]
Platforms = tuple[np.ndarray, np.ndarray]


def numpy_cube_sizes(mask: np.ndarray) -> np.ndarray:
    """The same sizes in whole NumPy planes: runs along k, squares along j, cubes along i."""
    sizes = runs(mask)
    np.minimum(sizes[:, 0], 1, out=sizes[:, 0])
    for j in range(1, sizes.shape[1]):
        row, before = sizes[:, j], sizes[:, j - 1]
        np.minimum(row[:, 1:], 1 + np.minimum(before[:, 1:], before[:, :-1]), out=row[:, 1:])
    np.minimum(sizes[0], 1, out=sizes[0])
    for i in range(1, sizes.shape[0]):
        plane, below = sizes[i], sizes[i - 1]
        rows = np.minimum(below[1:], below[:-1])
        np.minimum(plane[1:, 1:], 1 + np.minimum(rows[:, 1:], rows[:, :-1]), out=plane[1:, 1:])
    return sizes


def runs(mask: np.ndarray) -> np.ndarray:
    """Ones in a row that end at each node, by the place of the last zero."""
    place = np.arange(1, mask.shape[2] + 1, dtype=np.uint16)
    return place - np.maximum.accumulate(np.where(mask, np.uint16(0), place), axis=2)


def chessboard(mask: np.ndarray) -> np.ndarray:
    """Another question, often taken for this one: half the edge of the largest cube *about* each node."""
    return distance_transform_cdt(np.pad(mask, 1), metric="chessboard")


@numba.njit
def recurrence(mask: np.ndarray) -> int:
    """The paper's recurrence as it is written, two planes of it, and its maximum."""
    ni, nj, nk = mask.shape
    sizes = np.zeros((2, nj + 1, nk + 1), dtype=np.uint16)
    best = 0
    for i in range(ni):
        here, below = sizes[i % 2], sizes[1 - i % 2]
        for j in range(nj):
            for k in range(nk):
                size = 0
                if mask[i, j, k]:
                    size = 1 + min(
                        below[j + 1, k + 1],
                        here[j, k + 1],
                        here[j + 1, k],
                        below[j, k + 1],
                        below[j + 1, k],
                        here[j, k],
                        below[j, k],
                    )
                here[j + 1, k + 1] = size
                best = max(best, size)
    return best


@numba.njit
def recurrence_everywhere(mask: np.ndarray) -> np.ndarray:
    """The same with all of Φ kept."""
    ni, nj, nk = mask.shape
    sizes = np.zeros((ni + 1, nj + 1, nk + 1), dtype=np.uint8)
    for i in range(ni):
        for j in range(nj):
            for k in range(nk):
                if mask[i, j, k]:
                    sizes[i + 1, j + 1, k + 1] = 1 + min(
                        sizes[i, j + 1, k + 1],
                        sizes[i + 1, j, k + 1],
                        sizes[i + 1, j + 1, k],
                        sizes[i, j, k + 1],
                        sizes[i, j + 1, k],
                        sizes[i + 1, j, k],
                        sizes[i, j, k],
                    )
    return sizes[1:, 1:, 1:]


def size_and_places(nodes: Any) -> np.ndarray:
    """Where the largest cubes end."""
    return cube_ends(nodes, largest_cube(nodes))


def numpy_compliance(platforms: Platforms) -> np.ndarray:
    compliances, wrenches = platforms
    flows = np.linalg.solve(compliances, wrenches)
    return np.linalg.inv((np.swapaxes(wrenches, 2, 3) @ flows).sum(axis=1))


def compare(title: str, rivals: Rivals, argument: Any, count: int, read: int | None = None) -> None:
    """Print a row for each, of which ``count`` says how many things it does."""
    ready = {name: partial(rival, argument) for name, rival in rivals.items()}
    timing.compare(title, ready, count, ROUNDS, read)


def masks() -> dict[str, np.ndarray]:
    axis = np.linspace(-1.0, 1.0, EDGE)
    x, y, z = np.meshgrid(axis, axis, axis, indexing="ij", sparse=True)
    noise = np.random.default_rng(0).random((EDGE,) * 3) < 0.9
    return {"ball": (x**2 + y**2 + z**2 <= 0.9).astype(np.uint8), "noise": noise.astype(np.uint8)}


def platforms(chains: int, wrenches: int) -> Platforms:
    random = np.random.default_rng(2)
    halves = random.standard_normal((PLATFORMS, chains, wrenches, wrenches))
    compliances = halves @ np.swapaxes(halves, 2, 3) + np.eye(wrenches)
    return compliances, random.standard_normal((PLATFORMS, chains, wrenches, 6))


def compare_cubes() -> None:
    size: Rivals = {
        "largest_cube": largest_cube,
        "largest_cube and cube_ends": size_and_places,
        "the recurrence in numba": recurrence,
        "distance_transform_cdt (centred cubes)": chessboard,
        "edt (Euclidean distances)": edt.edt,
        "numpy.max of the mask": np.max,
    }
    sizes: Rivals = {
        "cube_sizes": cube_sizes,
        "the recurrence in numba": recurrence_everywhere,
        "the same in NumPy planes": numpy_cube_sizes,
    }
    for name, mask in masks().items():
        assert largest_cube(mask) == recurrence(mask) == cube_sizes(mask).max()
        for sizes_of in sizes.values():
            np.testing.assert_array_equal(cube_sizes(mask), sizes_of(mask))
        compare(f"{name}, {EDGE}^3 nodes", size, mask, mask.size, mask.nbytes)
        compare(f"{name}, Φ at all nodes", sizes, mask, mask.size, mask.nbytes)


def compare_fields() -> None:
    """The ball as a field within a bound: one value a node, and least and greatest."""
    shape = (EDGE,) * 3
    axis = np.linspace(-1.0, 1.0, EDGE)
    x, y, z = np.meshgrid(axis, axis, axis, indexing="ij", sparse=True)
    squares = (x**2 + y**2 + z**2).ravel()
    rivals: Rivals = {
        "largest_cube within bounds": lambda field: largest_cube(Within(field, shape, at_most=0.9)),
        "numpy.max of the field": np.max,
    }
    for name, field in {"one value": squares, "two values": np.column_stack([squares, squares])}.items():
        compare(f"{name} a node, {EDGE}^3 nodes", rivals, field, squares.size, field.nbytes)


def compare_small_matrices(size: int) -> None:
    """Each kernel beside NumPy's function, which takes matrices one at a time."""
    halves = np.random.default_rng(1).standard_normal((MATRICES, size, size))
    symmetric = halves + np.swapaxes(halves, 1, 2)
    positive = halves @ np.swapaxes(halves, 1, 2) + np.eye(size)
    pairs: list[tuple[str, Rivals, np.ndarray]] = [
        (
            "symmetric",
            {"symmetric_eigenvalues": symmetric_eigenvalues, "numpy.linalg.eigvalsh": np.linalg.eigvalsh},
            symmetric,
        ),
        (
            "symmetric",
            {"symmetric_eigenvectors": symmetric_eigenvectors, "numpy.linalg.eigh": np.linalg.eigh},
            symmetric,
        ),
        (
            "",
            {
                "gram_eigenvalues": gram_eigenvalues,
                "singular_values": singular_values,
                "numpy.linalg.svd": lambda matrices: np.linalg.svd(matrices, compute_uv=False),
            },
            halves,
        ),
        (
            "positive definite",
            {"positive_inverse": positive_inverse, "numpy.linalg.inv": np.linalg.inv},
            positive,
        ),
        (
            "positive definite",
            {
                "positive_solve, one right side": lambda matrices: positive_solve(matrices, halves[:, 0]),
                "numpy.linalg.solve": lambda matrices: np.linalg.solve(matrices, halves[:, 0, :, None]),
            },
            positive,
        ),
        (
            "",
            {
                "row_norms": row_norms,
                "numpy.linalg.norm": lambda matrices: np.linalg.norm(matrices, axis=2),
            },
            halves,
        ),
    ]
    for kind, rivals, matrices in pairs:
        compare(" ".join(f"{MATRICES} {kind} {size} x {size}".split()), rivals, matrices, MATRICES)


def matrices_over_boxes() -> Interval:
    """Matrices (n, 6, 6) that depend on the pose, over small boxes."""
    lo = np.random.default_rng(3).uniform(1.0, 2.0, (BOXES, 3))
    poses = Boxes(lo, lo + 1e-3).poses
    rows = [np.stack([poses[:, (i + j) % 3] * (1.0 + i) + j for j in range(6)], axis=1) for i in range(6)]
    return np.stack(rows, axis=1)  # type: ignore[no-any-return]


def compare_intervals() -> None:
    """Ends and mean-value forms in one pass, and in whole NumPy arrays."""
    matrices = matrices_over_boxes()
    turned = matrices[:, ::-1]
    products = ("nij", "njk", "nik")
    every: dict[str, tuple[Callable[[Any], Any], Callable[[Any], Any]]] = {
        "sums": (lambda x: fused.add(x, turned), lambda x: twin.add(x, turned)),
        "products": (lambda x: fused.multiply(x, turned), lambda x: twin.multiply(x, turned)),
        "matrix products": (
            lambda x: fused.contract(*products, x, turned),
            lambda x: twin.contract(*products, x, turned),
        ),
    }
    for name, (ours, numpys) in every.items():
        title = f"{name} of {BOXES} matrices 6 x 6 over boxes, by entries"
        compare(title, {"in C": ours, "whole NumPy arrays": numpys}, matrices, matrices.size)


def main() -> None:
    compare_cubes()
    compare_fields()
    for size in (2, 3, 6):
        compare_small_matrices(size)
    stiffnesses: Rivals = {
        "chain_compliance": lambda platforms: chain_compliance(*platforms),
        "numpy.linalg.solve and inv": numpy_compliance,
    }
    for chains, wrenches in ((3, 2), (3, 3), (6, 1)):
        title = f"{PLATFORMS} platforms, {chains} chains of {wrenches}"
        compare(title, stiffnesses, platforms(chains, wrenches), PLATFORMS)
    compare_intervals()


if __name__ == "__main__":
    main()

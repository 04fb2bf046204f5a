"""The loops that are too slow in Python, in C; `twin` is the plain Python of each.

>>> import numpy as np
>>> int(cube_sizes(np.ones((4, 5, 6), dtype=np.uint8)).max())
4
>>> symmetric_eigenvalues(np.diag([3.0, 1.0, 2.0])[None])
array([[1., 2., 3.]])
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from orthospec.kernels import _kernels
from orthospec.kernels.floats import numbers
from orthospec.kernels.largest_cubes import Within, cube_ends, largest_cube

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from orthospec.arrays import Array, Flags, Matrices, Poses

__all__ = [
    "Within",
    "chain_compliance",
    "close_legs",
    "cube_ends",
    "cube_sizes",
    "gram_eigenvalues",
    "instruction_set",
    "largest_cube",
    "leg_margins",
    "legs_compliance",
    "positive_inverse",
    "positive_solve",
    "row_norms",
    "singular_values",
    "symmetric_eigenvalues",
    "symmetric_eigenvectors",
]

LARGEST = 6
"""Rows of the largest matrices that the kernels of small matrices take."""
ILL_CONDITIONED = 1e-6
"""Below this ratio of the eigenvalues of AᵀA the slower SVD is asked, which does not square κ."""


def cube_sizes(mask: NDArray[np.uint8 | np.bool_]) -> NDArray[np.uint8] | NDArray[np.uint16]:
    """Φ (i, j, k): edge, in nodes, of the largest cube of nonzero nodes that ends at each node.

    "Ends": the node is the cube's corner of greatest indices. Pashkevich, Chablat and Wenger (2009),
    section 4. A cell is one byte as long as no cube that the mask has room for is over 255 nodes.
    """
    nodes = np.ascontiguousarray(mask)
    cell = np.uint8 if min(nodes.shape) <= np.iinfo(np.uint8).max else np.uint16
    sizes = np.empty(nodes.shape, dtype=cell)
    _kernels.cube_sizes(nodes, sizes)
    return sizes


def symmetric_eigenvalues(matrices: Matrices) -> Array:
    """Eigenvalues (n, m), ascending, of symmetric matrices, of which the lower triangles are read.

    To rounding of each matrix's norm, repeated eigenvalues included. A matrix that is not finite has NaN. Of
    more than 6 rows by LAPACK, one at a time.
    """
    if not isinstance(matrices, np.ndarray):  # Intervals, which take part in NumPy's functions.
        return np.linalg.eigvalsh(matrices)
    matrices = _square(matrices)
    if not 1 <= matrices.shape[1] <= LARGEST:
        return _eigenvalues_of_any_size(matrices)
    eigenvalues = np.empty(matrices.shape[:2])
    _kernels.symmetric_eigenvalues(matrices, eigenvalues)
    return eigenvalues


def symmetric_eigenvectors(matrices: Matrices) -> tuple[Array, Matrices]:
    """Eigenvalues λ (n, m), ascending, and unit eigenvectors, in columns V (n, m, m): A V = V diag(λ).

    The lower triangles are read. A matrix that is not finite has NaN. V is orthonormal to rounding, repeated
    eigenvalues included, and λ right to rounding of the norm; those of a positive definite matrix are so to
    rounding of each, times the condition number that the matrix has once its diagonal is 1, where LAPACK's
    are not. Of more than 6 rows by LAPACK, one at a time.
    """
    matrices = _square(matrices)
    eigenvalues, vectors = np.full(matrices.shape[:2], np.nan), np.full(matrices.shape, np.nan)
    if 1 <= matrices.shape[1] <= LARGEST:
        _kernels.symmetric_eigenvectors(matrices, eigenvalues, vectors)
    else:
        known = np.isfinite(np.tril(matrices)).all(axis=(1, 2))
        eigenvalues[known], vectors[known] = np.linalg.eigh(matrices[known])
    return eigenvalues, vectors


def gram_eigenvalues(matrices: Matrices) -> Array:
    """Eigenvalues (n, m), ascending, of AᵀA for matrices A (n, m, m): the squares of the singular values.

    To rounding of the greatest. A matrix that is not finite has NaN. Of more than 6 rows by LAPACK, one at a
    time.
    """
    matrices = _square(matrices)
    if not 1 <= matrices.shape[1] <= LARGEST:
        with np.errstate(invalid="ignore", over="ignore"):
            return _eigenvalues_of_any_size(np.swapaxes(matrices, 1, 2) @ matrices)
    eigenvalues = np.empty(matrices.shape[:2])
    _kernels.gram_eigenvalues(matrices, eigenvalues)
    return eigenvalues


def singular_values(matrices: Matrices) -> Array:
    """Singular values (n, m), ascending, of matrices (n, m, m); NaN where one is not finite.

    To some 1e-10 of each; where they are over a thousand apart by LAPACK, to rounding of the greatest.
    """
    if not isinstance(matrices, np.ndarray):  # Intervals, which take part in NumPy's functions.
        return np.linalg.svd(matrices, compute_uv=False)[:, ::-1]
    squares = gram_eigenvalues(matrices)
    with np.errstate(invalid="ignore"):
        poor = ~(squares[:, 0] >= ILL_CONDITIONED * squares[:, -1])
        values = np.sqrt(squares)
    if poor.any():
        poor &= np.isfinite(matrices).all(axis=(1, 2))
        values[poor] = np.linalg.svd(matrices[poor], compute_uv=False)[:, ::-1]
    return values


def positive_inverse(matrices: Matrices) -> tuple[Matrices, Flags]:
    """A⁻¹ (n, m, m) of symmetric positive definite matrices, and where it is safe (n,).

    The lower triangles are read, m of 1 to 6. Safe means positive definite, with pivots over 1e-6 of the
    diagonal entries; the error is then rounding over the least of these, whatever the units of rows and
    columns. Elsewhere the inverse is NaN.
    """
    matrices = _square(matrices)
    inverse, safe = np.empty(matrices.shape), np.empty(len(matrices), dtype=np.bool_)
    _kernels.positive_inverse(matrices, inverse, safe)
    return inverse, safe


def positive_solve(matrices: Matrices, right: Array) -> tuple[Array, Flags]:
    """x of A x = b for symmetric positive definite A (n, m, m), and where it is safe (n,).

    ``right`` is b, vectors (n, m) or columns (n, m, k), and x has its shape. The lower triangles are read, m
    of 1 to 6. What is safe is told as for `positive_inverse`, by A alone; elsewhere x is NaN.
    """
    matrices, right = _square(matrices), numbers(right)
    if right.ndim not in (2, 3):
        raise ValueError(f"right has the shape {right.shape}: expected (n, m) or (n, m, k)")
    columns = right[:, :, None] if right.ndim == 2 else right
    solution, safe = np.empty(columns.shape), np.empty(len(matrices), dtype=np.bool_)
    _kernels.positive_solve(matrices, columns, solution, safe)
    return solution.reshape(right.shape), safe


def row_norms(matrices: Array) -> Array:
    """‖row‖₂ (n, r) of the rows of matrices (n, r, c), as the root of the sum of squares.

    As in NumPy, squares that overflow make inf, and those that vanish are 0.
    """
    if not isinstance(matrices, np.ndarray):  # Intervals, which take part in NumPy's functions.
        return np.linalg.norm(matrices, axis=2)
    matrices = numbers(matrices)
    if matrices.ndim != 3:
        raise ValueError(f"matrices has the shape {matrices.shape}: expected (n, r, c)")
    if abs(matrices.strides[0]) < abs(matrices.strides[1]):  # The norms lie as the rows do, as in NumPy.
        norms = np.empty(matrices.shape[1::-1])
        _kernels.row_norms(np.swapaxes(matrices, 0, 1), norms)
        return norms.T
    norms = np.empty(matrices.shape[:2])
    _kernels.row_norms(matrices, norms)
    return norms


def close_legs(geometry: Array, poses: Poses) -> tuple[Array, Array, Array, Array]:
    """ρ (n, 3), s (3, 3, n), s·e (3, n) and its square (3, n) of three legs on slides.

    ``geometry`` (3, 8) has the axis e, the offset c − b, the length and the branch of each leg:
    `orthospec.mechanics.prismatic.close` tells what they are.
    """
    n = len(poses)
    rho, s, along, closing = np.empty((n, 3)), np.empty((3, 3, n)), np.empty((3, n)), np.empty((3, n))
    _kernels.close_legs(geometry, np.ascontiguousarray(poses, dtype=np.float64), rho, s, along, closing)
    return rho, s, along, closing


def leg_margins(scales: Array, s: Array, closing: Array) -> Array:
    """The margins (5, n) of three legs, of the volume that they span and of their pairs.

    ``scales`` (3, 7) has for each leg its length squared, its branch over its length, a row of the inverse of
    the home directions transposed, the sign of their determinant, and the least (s·e / L)².
    """
    margins = np.empty((5, closing.shape[1]))
    _kernels.leg_margins(scales, s, closing, margins)
    return margins


def instruction_set() -> str:
    """The best for which there are kernels and which this processor has."""
    return _kernels.instruction_sets()[0]


def _square(matrices: Matrices) -> Matrices:
    matrices = numbers(matrices)
    if matrices.ndim != 3 or matrices.shape[1] != matrices.shape[2]:
        raise ValueError(f"matrices has the shape {matrices.shape}: expected (n, m, m)")
    return matrices


def _eigenvalues_of_any_size(matrices: Matrices) -> Array:
    eigenvalues = np.full(matrices.shape[:2], np.nan)
    known = np.isfinite(np.tril(matrices)).all(axis=(1, 2))
    eigenvalues[known] = np.linalg.eigvalsh(matrices[known])
    return eigenvalues


def chain_compliance(compliances: Array, wrenches: Array) -> tuple[Matrices, Flags]:
    """C = (Σ Wᵀ D⁻¹ W)⁻¹ (n, 6, 6) of platforms on chains side by side, and where it is safe (n,).

    ``compliances`` D (n, chains, m, m) are symmetric, of which the lower triangles are read, and ``wrenches``
    are W (n, chains, m, 6), m of 1 to 6. Safe means that all D and the sum are positive definite, with pivots
    over 1e-6 of their diagonal entries; the error is then rounding over the least of these. Elsewhere C is
    NaN.
    """
    compliances = np.ascontiguousarray(compliances, dtype=np.float64)
    wrenches = np.ascontiguousarray(wrenches, dtype=np.float64)
    out, safe = np.empty((len(compliances), 6, 6)), np.empty(len(compliances), dtype=np.bool_)
    _kernels.chain_compliance(compliances, wrenches, out, safe)
    return out, safe


def legs_compliance(legs: Array, feet: Array, s: Array) -> tuple[Matrices, Flags]:
    """C (n, 6, 6) of a platform on three elastic legs on slides, and where it is safe (n,), as above.

    ``legs`` (3, 21) has for each leg the first revolute axis a, the arm c, the slide's axis e, the length,
    the drive's compliance, the entries 00, 03, 04, 33, 34 and 44 of its bar's compliance, h_xx, h_xz and h_zz
    of `orthospec.mechanics.parallelogram`, and half the spacing of its bars, 0 for one bar. ``feet``
    (3, 6, 6) are the feet's compliances along the axes of space, and ``s`` (3, 3, n) leads along the legs.
    """
    out, safe = np.empty((s.shape[2], 6, 6)), np.empty(s.shape[2], dtype=np.bool_)
    _kernels.legs_compliance(legs, feet, s, out, safe)
    return out, safe

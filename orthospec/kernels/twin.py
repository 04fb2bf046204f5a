"""The kernels in plain Python: what they compute, and the oracle of their tests."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from orthospec.arrays import Array, Matrices

__all__ = [
    "chain_compliance",
    "cube_ends",
    "cube_sizes",
    "largest_cube",
    "positive_inverse",
    "positive_solve",
    "row_norms",
    "symmetric_eigenvalues",
    "symmetric_eigenvectors",
]


def cube_sizes(mask: NDArray[np.uint8 | np.bool_]) -> NDArray[np.int64]:
    """Φ as Pashkevich, Chablat and Wenger (2009) write it, section 4, Steps 0 to 2.

    Step 0: Φ = 0.  Step 1: Φ = Ω in the first plane, row and column of each axis.  Step 2: elsewhere, in the
    order of the indices, Φ = 1 + the least of the seven predecessors where Ω = 1.
    """
    omega = np.asarray(mask) != 0
    i_max, j_max, k_max = omega.shape
    phi = [[[0] * k_max for _ in range(j_max)] for _ in range(i_max)]
    for i in range(i_max):
        for j in range(j_max):
            for k in range(k_max):
                if i == 0 or j == 0 or k == 0:
                    phi[i][j][k] = int(omega[i, j, k])
                elif omega[i, j, k]:
                    phi[i][j][k] = 1 + min(
                        phi[i - 1][j][k],
                        phi[i][j - 1][k],
                        phi[i][j][k - 1],
                        phi[i - 1][j - 1][k],
                        phi[i - 1][j][k - 1],
                        phi[i][j - 1][k - 1],
                        phi[i - 1][j - 1][k - 1],
                    )
    return np.array(phi, dtype=np.int64).reshape(omega.shape)


def largest_cube(mask: NDArray[np.uint8 | np.bool_]) -> int:
    """The greatest Φ, for masks of two or three axes."""
    return int(_sizes(mask).max(initial=0))


def cube_ends(mask: NDArray[np.uint8 | np.bool_], edge: int) -> NDArray[np.int64]:
    """Where Φ is ``edge`` or more, (n, axes)."""
    return np.argwhere(_sizes(mask) >= edge)


def _sizes(mask: NDArray[np.uint8 | np.bool_]) -> NDArray[np.int64]:
    """Φ; squares of a plane are the cubes of a solid that is everywhere the plane."""
    if mask.ndim == 3:
        return cube_sizes(mask)
    thickness = max(min(mask.shape), 1)
    return cube_sizes(np.repeat(mask[:, None], thickness, axis=1))[:, -1]


def symmetric_eigenvalues(matrices: Matrices) -> Array:
    """Eigenvalues (n, m), ascending, by LAPACK; the matrices have to be finite."""
    return np.linalg.eigvalsh(matrices).astype(np.float64)


def symmetric_eigenvectors(matrices: Matrices) -> tuple[Array, Matrices]:
    """Eigenvalues (n, m), ascending, and eigenvectors (n, m, m) by LAPACK; the matrices have to be finite."""
    eigenvalues, vectors = np.linalg.eigh(matrices)
    return eigenvalues, vectors


def positive_inverse(matrices: Matrices) -> Matrices:
    """A⁻¹ (n, m, m), one after the other; nothing may be singular."""
    return np.array([np.linalg.inv(one) for one in matrices]).reshape(matrices.shape)


def positive_solve(matrices: Matrices, right: Array) -> Array:
    """x (n, m) or (n, m, k) of A x = b, one after the other; nothing may be singular."""
    pairs = zip(matrices, right, strict=True)
    return np.array([np.linalg.solve(one, b) for one, b in pairs]).reshape(right.shape)


def row_norms(matrices: Array) -> Array:
    """‖row‖₂ (n, r) of matrices (n, r, c)."""
    return np.asarray(np.linalg.norm(matrices, axis=2))


def chain_compliance(compliances: Array, wrenches: Array) -> Matrices:
    """C = (Σ Wᵀ D⁻¹ W)⁻¹ (n, 6, 6), node by node and chain by chain; nothing may be singular."""
    platforms = []
    for node_compliances, node_wrenches in zip(compliances, wrenches, strict=True):
        stiffness = np.zeros((6, 6))
        for d, w in zip(node_compliances, node_wrenches, strict=True):
            stiffness += w.T @ np.linalg.inv(d) @ w
        platforms.append(np.linalg.inv(stiffness))
    return np.array(platforms).reshape(-1, 6, 6)

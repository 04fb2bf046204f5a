"""Inertia at the tool, and the forces that its change with the pose asks of the actuators.

The kinetic energy is ½ ρ̇ᵀ D ρ̇ = ½ ṗᵀ G ṗ with G = J⁻ᵀ D J⁻¹ (Pashkevich, Chablat and Wenger 2009, eq. 8;
Asada 1983). Lagrange's equations in the pose coordinates give the force at the tool

    F = G p̈ + Γ,      Γ_k = Σ_jl (∂G_kj/∂p_l − ½ ∂G_jl/∂p_k) ṗ_j ṗ_l,

and τ = Jᵀ F at the actuators.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from orthospec.arrays import np

if TYPE_CHECKING:
    from orthospec.arrays import Array, Matrices, Poses

STEP = 6e-6
"""Half-width of the differences [m, rad]: the cube root of the rounding, for machines of about a metre."""


class _Inert(Protocol):
    def inverse_jacobian(self, poses: Poses, /) -> Matrices: ...

    def joint_inertia(self, poses: Poses, /) -> Matrices: ...


def inverse(matrices: Matrices) -> Matrices:
    """Inverses (n, 3, 3) or of any size; not finite where a matrix is singular, where LAPACK would raise."""
    if not isinstance(matrices, np.ndarray):  # Intervals know better than cofactors.
        return np.linalg.inv(matrices)
    if matrices.shape[1:] != (3, 3):
        return _inverse_of_any_size(matrices)
    a, b, c = np.ascontiguousarray(np.moveaxis(matrices, 0, 2))
    columns = np.stack([_cross(b, c), _cross(c, a), _cross(a, b)], axis=1)
    determinant = a[0] * columns[0, 0] + a[1] * columns[1, 0] + a[2] * columns[2, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.ascontiguousarray(np.moveaxis(columns / determinant, 2, 0))


def _cross(a: Array, b: Array) -> Array:
    """a × b, components first."""
    return np.stack([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def _inverse_of_any_size(matrices: Matrices) -> Matrices:
    found = np.full(matrices.shape, np.nan)
    known = np.flatnonzero(np.isfinite(matrices).all(axis=(1, 2)))
    known = known[np.linalg.det(matrices[known]) != 0]
    found[known] = np.linalg.inv(matrices[known])
    return found


def at_tool(inverse_jacobian: Matrices, joint_inertia: Matrices) -> Matrices:
    """G = J⁻ᵀ D J⁻¹ (n, d, d), symmetric."""
    found: Matrices = np.swapaxes(inverse_jacobian, 1, 2) @ joint_inertia @ inverse_jacobian
    return (found + np.swapaxes(found, 1, 2)) / 2


def velocity_forces(machine: _Inert, poses: Poses, step: float = STEP) -> Array:
    """Q (n, m, d, d), symmetric: the actuators exert ṗᵀ Q_i ṗ at a constant tool velocity ṗ.

    From central differences of G over the pose, of half-width ``step`` [m, rad].
    """
    n, d = poses.shape
    steps = step * np.concatenate([np.eye(d), -np.eye(d)])
    around = (poses[:, None, :] + steps).reshape(-1, d)
    G = at_tool(machine.inverse_jacobian(around), machine.joint_inertia(around)).reshape(n, 2, d, d, d)
    slope = (G[:, 0] - G[:, 1]) / (2 * step)
    # slope[n, l, j, k] = ∂G_jk/∂p_l, and Γ_k is made symmetric in j and l.
    along = np.transpose(slope, (0, 3, 2, 1))
    gamma = (along + np.swapaxes(along, 2, 3) - slope) / 2
    return np.asarray(np.einsum("nki,nkjl->nijl", inverse(machine.inverse_jacobian(poses)), gamma))

"""Inertia of machines with prismatic legs: sliders, uniform bars, a platform that only translates.

A bar of mass m between points that move with v1 and v2 has the kinetic energy m/6 (v1² + v1·v2 + v2²). With
j_i row i of J⁻¹, so that ρ̇_i = j_i·ṗ, the inertia at the tool is

    G = m_p I + Σ_i [(m_s + m_l/3) j_i j_iᵀ + m_l/3 I + m_l/6 (j_i e_iᵀ + e_i j_iᵀ)],      D = Jᵀ G J

in joint space. Differentiating |eρ̇ − ṗ|² + s·(eρ̈ − p̈) = 0, the loop's second derivative, gives
ρ̈_i = j_i·p̈ + ṗᵀ H_i ṗ with H_i = −(e_i j_iᵀ − I)ᵀ (e_i j_iᵀ − I) / (s_i·e_i).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from orthospec.arrays import np
from orthospec.mechanics.prismatic import inverse_jacobian

if TYPE_CHECKING:
    from orthospec.arrays import Array, Joints, Matrices
    from orthospec.mechanics.prismatic import Legs, PrismaticLegs


class Masses(NamedTuple):
    """What moves [kg]."""

    sliders: float
    """One slider with its foot."""
    legs: Array
    """Each leg, with all of its bars (1, 3); (n, 3) where each pose has legs of its own."""
    platform: float
    """Platform, tool and payload."""


def joint_inertia(machine: PrismaticLegs, masses: Masses, J: Matrices) -> Matrices:
    """D (n, 3, 3) [kg], from J = ∂p/∂ρ (n, 3, 3)."""
    m = masses.legs
    # At the joints j_i becomes unit vector i, and e_i becomes Jᵀ e_i.
    mixed = (m / 6)[:, :, None] * (machine.axes @ J)
    all_at_tool = masses.platform + m.sum(axis=1)[:, None, None] / 3
    at_sliders = (masses.sliders + m / 3)[:, :, None] * np.eye(3)
    found: Matrices = all_at_tool * (np.swapaxes(J, 1, 2) @ J)
    found += mixed + np.swapaxes(mixed, 1, 2) + at_sliders
    return found


def rest_load(machine: PrismaticLegs, masses: Masses, J: Matrices, gravity: Array) -> Joints:
    """The actuator forces (n, 3) [N] that hold the machine still; gravity (3,) [m/s^2]."""
    at_sliders = (masses.sliders + masses.legs / 2) * (machine.axes @ gravity)
    at_tool = (masses.platform + masses.legs.sum(axis=1)[:, None] / 2) * gravity
    load: Joints = -at_sliders - (at_tool[:, None, :] @ J)[:, 0]
    return load


def velocity_forces(machine: PrismaticLegs, masses: Masses, legs: Legs, J: Matrices) -> Array:
    """Q (n, 3, 3, 3) [kg/m]: actuator i exerts ṗᵀ Q_i ṗ at a constant tool velocity ṗ."""
    m = masses.legs
    sway = machine.axes[:, :, None] * inverse_jacobian(legs)[:, :, None, :] - np.eye(3)
    with np.errstate(divide="ignore", invalid="ignore"):
        H = -np.swapaxes(sway, 2, 3) @ sway / legs.along.T[:, :, None, None]
    # Row i: how the inertia of chain i's slider and leg against its slider's acceleration acts on each joint.
    coupling = (masses.sliders + m / 3)[:, :, None] * np.eye(3) + (m / 6)[:, :, None] * (machine.axes @ J)
    forces: Array = np.einsum("nij,niab->njab", coupling, H)
    return forces

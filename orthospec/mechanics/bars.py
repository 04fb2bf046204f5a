"""Bars as 6-dof springs at their ends: compliance matrices by Euler-Bernoulli beam theory.

Twists and wrenches are ordered (x, y, z, rx, ry, rz), a wrench is (force, moment). Bar frame: x along the bar
from the clamped end to the loaded one, y and z the principal axes of the section. Clamped at one end and
loaded at the other,

    C11 = L/EA,   C22 = L³/3EIz,  C26 = L²/2EIz,   C66 = L/EIz,
    C44 = L/GJ,   C33 = L³/3EIy,  C35 = −L²/2EIy,  C55 = L/EIy

(Gere and Goodno, *Mechanics of Materials*). Shear deformation is left out: below 2 % of the bending of a tube
ten times as long as it is thick.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from orthospec.arrays import np

if TYPE_CHECKING:
    from orthospec.arrays import Array
    from orthospec.mechanics.materials import Material
    from orthospec.mechanics.sections import Section

PRINTED = 1e-6
"""How far a given compliance may be from symmetric and semidefinite: programs print some seven digits."""


def cantilever(section: Section, material: Material, length: float | Array) -> Array:
    """C (..., 6, 6) of a bar's loaded end relative to its clamped end [m/N, rad/N, rad/(N*m)].

    The length (...) [m] is a number, or an array for bars of several lengths.
    """
    C = np.zeros_like(length, shape=(*np.shape(length), 6, 6), dtype=float)
    C[..., 0, 0] = length / (material.E * section.area)
    C[..., 3, 3] = length / (material.G * section.J)
    for along, about, sign, second_moment in ((1, 5, 1, section.Iz), (2, 4, -1, section.Iy)):
        EI = material.E * second_moment
        C[..., along, along] = length**3 / (3 * EI)
        C[..., about, about] = length / EI
        C[..., along, about] = C[..., about, along] = sign * length**2 / (2 * EI)
    return C


def is_symmetric(compliance: Array) -> bool:
    """Whether C (6, 6) is symmetric, each entry to what its two diagonal entries allow."""
    return bool(np.all(np.abs(compliance - compliance.T) <= PRINTED * _sizes(compliance)))


def is_compliance(compliance: Array) -> bool:
    """Whether C (6, 6) is symmetric and positive semidefinite: no wrench gains energy from the bar.

    Judged on C_ij / sqrt(C_ii C_jj), so that the units of its blocks don't matter.
    """
    if not is_symmetric(compliance) or np.any(np.diag(compliance) < 0):
        return False
    sizes = _sizes(compliance)
    if np.any(compliance[sizes == 0] != 0):
        return False
    correlations = compliance / np.where(sizes > 0, sizes, 1)
    return bool(np.linalg.eigvalsh((correlations + correlations.T) / 2)[0] >= -PRINTED)


def _sizes(compliance: Array) -> Array:
    """sqrt(|C_ii C_jj|), the largest that |C_ij| can be."""
    roots = np.sqrt(np.abs(np.diag(compliance)))
    return np.asarray(np.outer(roots, roots))

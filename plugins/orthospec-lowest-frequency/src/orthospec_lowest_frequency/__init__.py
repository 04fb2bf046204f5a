"""``lowest_frequency``: the lowest natural frequency of the machine, its drives held, at a pose.

What moves is told by the inertia at the tool, G = J⁻ᵀ D J⁻¹ with D in joint space, and what gives way by
the compliance of the tool against forces, C_tt. Masses in between follow the tool as they do when nothing
bends, so that this is a static condensation (R. J. Guyan, *Reduction of stiffness and mass matrices*, AIAA
Journal 3(2), 1965). Free vibrations of the tool are G p̈ + C_tt⁻¹ p = 0: with λ the eigenvalues of C_tt G,

    f = 1 / (2 π sqrt(λ_max(C_tt G))).

With G = L Lᵀ these are the eigenvalues of A = Lᵀ C_tt L, which is symmetric. Two of them are one where the
machine is symmetric, and there f has a kink: the convex form is about the matrix, which has none,

    λ_min(−½ ln A − ln 2π) >= ln b.

There are no bounds over boxes of poses, since a Cholesky factor is not among what intervals know. A run with
this measure holds it at the critical poses that it finds, and says that it is not proved.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np

from orthospec.kernels import symmetric_eigenvalues
from orthospec.measures import ConvexForm, Measure
from orthospec.measures.forms import least_eigenvalue, semidefinite_logarithm
from orthospec.mechanics.inertia import at_tool

if TYPE_CHECKING:
    from orthospec.arrays import Array, Flags, Matrices, Poses
    from orthospec.manipulators import Manipulator

__all__ = ["LowestFrequency"]


class LowestFrequency(Measure):
    """Lowest natural frequency f = 1 / (2 π sqrt(λ_max(C_tt G))), the drives held, all masses at the tool.

    Guyan (1965). For machines whose tool only translates.
    """

    unit: ClassVar[str] = "Hz"
    sides: ClassVar[frozenset[str]] = frozenset({"at_least"})
    least: ClassVar[float] = 0.0
    needs: ClassVar[frozenset[str]] = frozenset({"compliance", "joint_inertia"})

    def values(self, manipulator: Manipulator, poses: Poses) -> Array:
        """The frequency at each pose (n,) [Hz]; 0 where the machine is loose or singular."""
        if manipulator.axes != ("x", "y", "z"):
            raise ValueError("lowest_frequency is for machines whose tool translates along x, y and z")
        product, known = _swinging(manipulator, poses)
        slowest = np.where(known, symmetric_eigenvalues(product)[:, -1], np.inf)
        with np.errstate(divide="ignore"):
            return np.asarray(1.0 / (2.0 * np.pi * np.sqrt(slowest)))

    def form(self, manipulator: Manipulator, poses: Poses, side: str) -> ConvexForm:  # noqa: ARG002
        """λ_min(−½ ln A − ln 2π) >= ln b."""
        logarithms = semidefinite_logarithm(_swinging(manipulator, poses)[0])
        return least_eigenvalue(-0.5 * logarithms - np.log(2.0 * np.pi) * np.eye(3))


def _swinging(manipulator: Manipulator, poses: Poses) -> tuple[Matrices, Flags]:
    """A = Lᵀ C_tt L (n, 3, 3) [s²], G = L Lᵀ, and where it is known (n,): not where loose or singular."""
    compliance = manipulator.compliance(poses)[:, :3, :3]
    inertia = at_tool(manipulator.inverse_jacobian(poses), manipulator.joint_inertia(poses))
    known = np.isfinite(compliance).all(axis=(1, 2)) & np.isfinite(inertia).all(axis=(1, 2))
    found = np.full(compliance.shape, np.nan)
    factor = np.linalg.cholesky((inertia[known] + np.swapaxes(inertia[known], 1, 2)) / 2)
    found[known] = np.swapaxes(factor, 1, 2) @ compliance[known] @ factor
    return found, known

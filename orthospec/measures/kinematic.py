"""Kinematic measures: how the tool's velocity follows the joint rates, ṗ = J ρ̇.

All three are functions of the singular values σ_1 <= ... <= σ_d of J = ∂p/∂ρ, that is of the stretch in the
polar decomposition J = V R. Its logarithm

    H = ln V = −½ ln(J⁻ᵀ J⁻¹),      eigenvalues ln σ_i,

is smooth in pose and design also where singular values coincide, and every bound is convex in it and linear
in the bound's logarithm: λ_max(H) <= ln b, λ_min(H) >= ln b, λ_max(H) − λ_min(H) <= ln k, tr H >= ln w.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar

from orthospec.arrays import np
from orthospec.measures import forms
from orthospec.measures.base import ConvexForm, Measure, logarithm

if TYPE_CHECKING:
    from orthospec.arrays import Array, Matrices, Poses
    from orthospec.intervals import Boxes, Interval
    from orthospec.manipulators import Manipulator


def transmission_factors(inverse_jacobian: Matrices) -> Array:
    """Singular values of J, ascending (n, m), from J⁻¹; inf at a parallel singularity, NaN from NaN."""
    from orthospec import kernels

    with np.errstate(divide="ignore"):
        return np.asarray(1.0 / kernels.singular_values(inverse_jacobian)[:, ::-1])


def logarithmic_stretch(inverse_jacobian: Matrices) -> Matrices:
    """H = −½ ln(J⁻ᵀ J⁻¹) (n, m, m), symmetric; NaN from what is singular or not finite."""
    with np.errstate(invalid="ignore", over="ignore"):
        gram = np.swapaxes(inverse_jacobian, 1, 2) @ inverse_jacobian
    return np.asarray(-0.5 * forms.matrix_logarithm(gram))


def _stretch(manipulator: Manipulator, poses: Poses) -> Matrices:
    return logarithmic_stretch(manipulator.inverse_jacobian(poses))


class VelocityTransmission(Measure):
    """Velocity transmission factors: least and greatest singular value of J = ∂p/∂ρ.

    The tool's speed for a joint rate of norm 1 lies between them in every direction. Chablat and Wenger
    (2003); Pashkevich, Chablat and Wenger (2009), section 3.1.
    """

    unit: ClassVar[str] = "1"
    sides: ClassVar[frozenset[str]] = frozenset({"at_least", "at_most"})
    least: ClassVar[float] = 0.0

    def values(self, manipulator: Manipulator, poses: Poses) -> Array:
        """σ_min(J) and σ_max(J), (n, 2)."""
        from orthospec import kernels

        ends = kernels.singular_values(manipulator.inverse_jacobian(poses))[:, [-1, 0]]
        with np.errstate(divide="ignore"):
            return np.asarray(1.0 / ends)

    def enclosure(self, manipulator: Manipulator, boxes: Boxes) -> Interval:
        """Of 1/sqrt(λ(J⁻ᵀJ⁻¹))."""
        from orthospec.intervals import eigenvalues

        inverse: Any = manipulator.inverse_jacobian(boxes.poses)  # type: ignore[arg-type]
        squares = eigenvalues.symmetric_eigenvalues(np.swapaxes(inverse, 1, 2) @ inverse)
        return eigenvalues.inverse_roots(squares[:, [-1, 0]])

    def form(self, manipulator: Manipulator, poses: Poses, side: str) -> ConvexForm:
        """λ_max(H) <= ln b, or λ_min(H) >= ln b."""
        stretch = _stretch(manipulator, poses)
        return forms.greatest_eigenvalue(stretch) if side == "at_most" else forms.least_eigenvalue(stretch)


class ConditionNumber(Measure):
    """Condition number κ(J) = σ_max(J) / σ_min(J): 1 where the machine moves alike in all directions.

    Pashkevich, Chablat and Wenger (2009), eq. 4.
    """

    unit: ClassVar[str] = "1"
    sides: ClassVar[frozenset[str]] = frozenset({"at_most"})
    least: ClassVar[float] = 1.0

    def values(self, manipulator: Manipulator, poses: Poses) -> Array:
        """κ(J), (n,); inf at a singularity."""
        sigma = transmission_factors(manipulator.inverse_jacobian(poses))
        with np.errstate(invalid="ignore"):
            return np.asarray(sigma[:, -1] / sigma[:, 0])

    def enclosure(self, manipulator: Manipulator, boxes: Boxes) -> Interval:
        """Of κ(J⁻¹), by the ratio of the eigenvalues of J⁻ᵀJ⁻¹."""
        from orthospec.intervals import eigenvalues

        return eigenvalues.condition_number(manipulator.inverse_jacobian(boxes.poses))  # type: ignore[arg-type]

    def form(self, manipulator: Manipulator, poses: Poses, side: str) -> ConvexForm:  # noqa: ARG002
        """λ_max(H) − λ_min(H) <= ln k."""
        return forms.ratio_of_eigenvalues(_stretch(manipulator, poses))


class Manipulability(Measure):
    """Manipulability w = sqrt(det J Jᵀ) = |det J| (Yoshikawa 1985): volume of the velocity ellipsoid."""

    unit: ClassVar[str] = "1"
    sides: ClassVar[frozenset[str]] = frozenset({"at_least"})

    def values(self, manipulator: Manipulator, poses: Poses) -> Array:
        """|det J|, (n,); inf at a parallel singularity."""
        with np.errstate(divide="ignore", invalid="ignore"):
            volume: Array = 1.0 / np.abs(np.linalg.det(manipulator.inverse_jacobian(poses)))
        return volume

    def form(self, manipulator: Manipulator, poses: Poses, side: str) -> ConvexForm:  # noqa: ARG002
        """tr H >= ln w."""

        def holds(x: Any, bound: Any, slack: Any) -> list[Any]:
            import cvxpy as cp

            return [cp.trace(x) >= logarithm(bound) - slack]

        return ConvexForm(_stretch(manipulator, poses), holds)

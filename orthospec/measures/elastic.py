"""Elastic measures: how the tool gives under a load, δt = C w, with C the compliance at the tool point.

C has blocks of displacement (t) and rotation (r) per force and per moment,

    C = [ C_tt  C_tr ]
        [ C_rt  C_rr ],      C_rt = C_trᵀ,

and the worst over all directions of a load is a norm of one block. Displacements and rotations are never
mixed. Where the machine is loose, all of C is inf: what moves is inf, a stiffness is 0.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Self, TypeAlias

from pydantic import Field, model_validator

from orthospec.arrays import np
from orthospec.measures import forms
from orthospec.measures.base import ConvexForm, Measure
from orthospec.quantities import Force, Torque

if TYPE_CHECKING:
    from orthospec.arrays import Array, Flags, Matrices, Poses
    from orthospec.manipulators import Manipulator

PositiveForce: TypeAlias = Annotated[Force, Field(gt=0)]
PositiveTorque: TypeAlias = Annotated[Torque, Field(gt=0)]
Wrench: TypeAlias = tuple[Force, Force, Force, Torque, Torque, Torque]

TRANSLATION, ROTATION = slice(0, 3), slice(3, 6)
ROUNDING = 1e-7
"""What a load moves is followed down to this, relative to the most that a load of its size could move."""


class Deflection(Measure):
    """Deflection of the tool under a load: the length of its displacement.

      force F, in whichever direction moves the tool most:   F ‖C_tt‖₂
      wrench w = (force, moment) at the tool point:          ‖[C_tt C_tr] w‖

    C = K⁻¹ is the compliance of the machine at the tool point. Pashkevich, Chablat and Wenger (2009), eq. 7;
    it prints K f, where a displacement is K⁻¹ f.
    """

    unit: ClassVar[str] = "m"
    sides: ClassVar[frozenset[str]] = frozenset({"at_most"})
    least: ClassVar[float] = 0.0
    needs: ClassVar[frozenset[str]] = frozenset({"compliance"})

    force: PositiveForce | None = None
    """A force of this size in the worst direction; or give 'wrench' [N]."""
    wrench: Wrench | None = None
    """Force and moment at the tool point, [Fx, Fy, Fz, Mx, My, Mz]; or give 'force' [N, N*m]."""

    @model_validator(mode="after")
    def _has_one_load(self) -> Self:
        _check_load(force=self.force, wrench=self.wrench)
        return self

    def values(self, manipulator: Manipulator, poses: Poses) -> Array:
        """The deflection [m] (n,); inf where the machine is loose."""
        compliance = manipulator.compliance(poses)
        if self.force is not None:
            return self.force * greatest_compliance(compliance, TRANSLATION)
        return _length(_moved(compliance, TRANSLATION, self.wrench), compliance)

    def form(self, manipulator: Manipulator, poses: Poses, side: str) -> ConvexForm:  # noqa: ARG002
        """λ_max(ln F C_tt) <= ln b, or a second-order cone."""
        compliance = manipulator.compliance(poses)
        if self.force is not None:
            return forms.greatest_eigenvalue(_logarithm(compliance, TRANSLATION, self.force))
        return _wrench_form(compliance, TRANSLATION, self.wrench)


class Rotation(Measure):
    """Rotation of the tool under a load: the angle that it turns by.

      torque M about whichever axis turns the tool most:      M ‖C_rr‖₂
      force F, in whichever direction turns the tool most:    F ‖C_rt‖₂
      wrench w = (force, moment) at the tool point:           ‖[C_rt C_rr] w‖

    The rotational twin of 'deflection'. C = K⁻¹ is the compliance of the machine at the tool point.
    """

    unit: ClassVar[str] = "rad"
    sides: ClassVar[frozenset[str]] = frozenset({"at_most"})
    least: ClassVar[float] = 0.0
    needs: ClassVar[frozenset[str]] = frozenset({"compliance"})

    torque: PositiveTorque | None = None
    """A moment of this size about the worst axis; or give 'force' or 'wrench' [N*m]."""
    force: PositiveForce | None = None
    """A force of this size in the worst direction; or give 'torque' or 'wrench' [N]."""
    wrench: Wrench | None = None
    """Force and moment at the tool point, [Fx, Fy, Fz, Mx, My, Mz]; or give 'torque' or 'force' [N, N*m]."""

    @model_validator(mode="after")
    def _has_one_load(self) -> Self:
        _check_load(torque=self.torque, force=self.force, wrench=self.wrench)
        return self

    def values(self, manipulator: Manipulator, poses: Poses) -> Array:
        """The rotation [rad] (n,); inf where the machine is loose."""
        compliance = manipulator.compliance(poses)
        if self.torque is not None:
            return self.torque * greatest_compliance(compliance, ROTATION)
        if self.force is not None:
            return self.force * _greatest_coupling(compliance)
        return _length(_moved(compliance, ROTATION, self.wrench), compliance)

    def form(self, manipulator: Manipulator, poses: Poses, side: str) -> ConvexForm:  # noqa: ARG002
        """λ_max(ln M C_rr) <= ln b, the norm of F C_rt, or a second-order cone."""
        compliance = manipulator.compliance(poses)
        if self.torque is not None:
            return forms.greatest_eigenvalue(_logarithm(compliance, ROTATION, self.torque))
        if self.force is not None:
            return _coupling_form(compliance, self.force)
        return _wrench_form(compliance, ROTATION, self.wrench)


class Stiffness(Measure):
    """Translational stiffness in the weakest direction: 1/‖C_tt‖₂, all moments free.

    It is the least force for a unit of displacement, C = K⁻¹ the compliance at the tool point; not an
    eigenvalue of K, which would hold the rotations fast.
    """

    unit: ClassVar[str] = "N/m"
    sides: ClassVar[frozenset[str]] = frozenset({"at_least"})
    needs: ClassVar[frozenset[str]] = frozenset({"compliance"})

    def values(self, manipulator: Manipulator, poses: Poses) -> Array:
        """1/λ_max(C_tt) [N/m] (n,); 0 where the machine is loose."""
        return _stiffness(manipulator.compliance(poses), TRANSLATION)

    def form(self, manipulator: Manipulator, poses: Poses, side: str) -> ConvexForm:  # noqa: ARG002
        """λ_min(−ln C_tt) >= ln b."""
        return forms.least_eigenvalue(-_logarithm(manipulator.compliance(poses), TRANSLATION))


class RotationalStiffness(Measure):
    """Rotational stiffness about the weakest axis: 1/‖C_rr‖₂, all forces free.

    It is the least moment for a unit of rotation, C = K⁻¹ the compliance at the tool point.
    """

    unit: ClassVar[str] = "N*m/rad"
    sides: ClassVar[frozenset[str]] = frozenset({"at_least"})
    needs: ClassVar[frozenset[str]] = frozenset({"compliance"})

    def values(self, manipulator: Manipulator, poses: Poses) -> Array:
        """1/λ_max(C_rr) [N*m/rad] (n,); 0 where the machine is loose."""
        return _stiffness(manipulator.compliance(poses), ROTATION)

    def form(self, manipulator: Manipulator, poses: Poses, side: str) -> ConvexForm:  # noqa: ARG002
        """λ_min(−ln C_rr) >= ln b."""
        return forms.least_eigenvalue(-_logarithm(manipulator.compliance(poses), ROTATION))


def greatest_compliance(compliance: Matrices, part: slice) -> Array:
    """‖C_tt‖₂ or ‖C_rr‖₂ (n,) of C (n, 6, 6): inf where loose, NaN from NaN."""
    from orthospec import kernels

    found = kernels.symmetric_eigenvalues(compliance[:, part, part])[:, -1]
    return np.where(_is_loose(compliance), np.inf, found)


def _check_load(**loads: object) -> None:
    given = [name for name, load in loads.items() if load is not None]
    if len(given) != 1:
        *most, last = (f"'{name}'" for name in loads)
        told = " and ".join(f"'{name}'" for name in given) or "none"
        raise ValueError(f"one of {', '.join(most)} and {last} was expected, {told} given")
    wrench = loads["wrench"]
    if isinstance(wrench, tuple) and not any(wrench):
        raise ValueError("a wrench with a force or a moment in it was expected, all of 'wrench' is 0")


def _is_loose(compliance: Matrices) -> Flags:
    loose: Flags = np.isinf(compliance[:, 0, 0])
    return loose


def _stiffness(compliance: Matrices, part: slice) -> Array:
    with np.errstate(divide="ignore"):
        stiffness: Array = 1.0 / greatest_compliance(compliance, part)
    return stiffness


def _logarithm(compliance: Matrices, part: slice, load: float = 1.0) -> Matrices:
    return forms.semidefinite_logarithm(load * compliance[:, part, part])


def _moved(compliance: Matrices, part: slice, wrench: Wrench | None) -> Array:
    """What a wrench moves (n, 3): the part of C w."""
    with np.errstate(invalid="ignore"):
        moved: Array = compliance[:, part] @ np.array(wrench, dtype=float)
    return moved


def _length(moved: Array, compliance: Matrices) -> Array:
    return np.where(_is_loose(compliance), np.inf, np.linalg.norm(moved, axis=1))


def _greatest_coupling(compliance: Matrices) -> Array:
    """‖C_rt‖₂ (n,)."""
    from orthospec import kernels

    coupling = compliance[:, ROTATION, TRANSLATION]
    with np.errstate(invalid="ignore"):
        squares = kernels.symmetric_eigenvalues(coupling @ np.swapaxes(coupling, 1, 2))[:, -1]
    return np.where(_is_loose(compliance), np.inf, np.sqrt(np.maximum(squares, 0.0)))


def _most(compliance: Matrices, part: slice, force: float, moment: float) -> Array:
    """A limit (n,) to what a load can move: C is semidefinite, so ‖C_rt‖² <= ‖C_rr‖ ‖C_tt‖."""
    with np.errstate(invalid="ignore"):
        roots = [np.sqrt(np.einsum("nii->n", compliance[:, p, p])) for p in (part, TRANSLATION, ROTATION)]
        return np.asarray(roots[0] * (roots[1] * force + roots[2] * moment))


def _wrench_form(compliance: Matrices, part: slice, wrench: Wrench | None) -> ConvexForm:
    moved = _moved(compliance, part, wrench)
    force, moment = np.linalg.norm(np.array(wrench, dtype=float).reshape(2, 3), axis=1)
    floor = ROUNDING * _most(compliance, part, force, moment)

    def within(y: Any, limit: Any) -> list[Any]:
        import cvxpy as cp

        return [cp.norm(y) <= limit]

    return forms.convex_size(moved, np.linalg.norm(moved, axis=1), within, floor)


def _coupling_form(compliance: Matrices, force: float) -> ConvexForm:
    turned = force * compliance[:, ROTATION, TRANSLATION].reshape(-1, 9)
    floor = ROUNDING * _most(compliance, ROTATION, force, 0.0)

    def within(y: Any, limit: Any) -> list[Any]:
        import cvxpy as cp

        return [cp.sigma_max(cp.reshape(y, (3, 3), order="C")) <= limit]

    return forms.convex_size(turned, force * _greatest_coupling(compliance), within, floor)

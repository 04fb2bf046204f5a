"""Dynamic measures: what the tool weighs to its actuators, and what they can make it do.

With J⁻¹ = ∂ρ/∂p and the inertia D in joint space, the inertia at the tool is G = J⁻ᵀ D J⁻¹, and the actuators
exert

    τ_i = r_i·p̈ + ṗᵀ Q_i ṗ + g_i,      r_i = row i of D J⁻¹,      g the load at rest (gravity),

less what friction f_i takes. What is promised holds for every direction of the acceleration and of the
velocity, each in the one that is worst for the actuator. At a parallel singularity D is infinite, and the
actuators hold nothing: whatever is asked there is not met, a mass, a force and an anisotropy are inf, an
acceleration is 0.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

from pydantic import Field

from orthospec import quantities
from orthospec.arrays import np
from orthospec.measures import forms
from orthospec.measures.base import ConvexForm, Measure
from orthospec.mechanics.inertia import at_tool

if TYPE_CHECKING:
    from orthospec.arrays import Array, Matrices, Poses
    from orthospec.intervals import Boxes, Interval
    from orthospec.manipulators import Manipulator

UNLIMITED = 1e30
"""Stands for the limit of an actuator that has none, in a logarithm."""
WEAK = 0.01
"""Part of an actuator's limit below which what is left of its force is not told by its logarithm."""
FADED = 500.0
"""Where the exponential that goes on from there ends."""
SINGULAR = 1e-12
"""Below this determinant of J⁻¹, relative to the lengths of its rows, the pose is singular to rounding."""
SMALL_ROW = 1e-9
"""A row of a matrix is told from 0 down to this, relative to the matrix."""


class GieNorm(Measure):
    """Norm of the generalised inertia ellipsoid: the greatest mass that the tool has in any direction, ‖G‖₂.

    G = J⁻ᵀ D J⁻¹, the inertia at the tool. Asada (1983); Pashkevich, Chablat and Wenger (2009), eq. 8; the
    text before it writes D, the inertia in joint space, for G.
    """

    unit: ClassVar[str] = "kg"
    sides: ClassVar[frozenset[str]] = frozenset({"at_most"})
    least: ClassVar[float] = 0.0
    needs: ClassVar[frozenset[str]] = frozenset({"joint_inertia"})

    def values(self, manipulator: Manipulator, poses: Poses) -> Array:
        """λ_max(G) [kg] (n,)."""
        masses = _eigenvalues(_inertia(manipulator, poses))[:, -1]
        return _or_if_singular(np.inf, masses, manipulator, poses)

    def form(self, manipulator: Manipulator, poses: Poses, side: str) -> ConvexForm:  # noqa: ARG002
        """λ_max(ln G) <= ln b."""
        return forms.greatest_eigenvalue(forms.semidefinite_logarithm(_inertia(manipulator, poses)))


class DynamicIsotropy(Measure):
    """Dynamic isotropy κ(G) = λ_max(G) / λ_min(G): 1 where the tool weighs the same in all directions.

    G = J⁻ᵀ D J⁻¹, the inertia at the tool. Asada (1983).
    """

    unit: ClassVar[str] = "1"
    sides: ClassVar[frozenset[str]] = frozenset({"at_most"})
    least: ClassVar[float] = 1.0
    needs: ClassVar[frozenset[str]] = frozenset({"joint_inertia"})

    def values(self, manipulator: Manipulator, poses: Poses) -> Array:
        """κ(G), (n,); inf where the tool has no mass in some direction."""
        masses = _eigenvalues(_inertia(manipulator, poses))
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = masses[:, -1] / np.maximum(masses[:, 0], 0.0)
        return _or_if_singular(np.inf, ratio, manipulator, poses)

    def enclosure(self, manipulator: Manipulator, boxes: Boxes) -> Interval:
        """The set of G with a ratio up to k is convex: bounded at each box's corners."""
        from orthospec.intervals import eigenvalues

        return eigenvalues.eigenvalue_ratio(_inertia(manipulator, boxes.poses))  # type: ignore[arg-type]

    def form(self, manipulator: Manipulator, poses: Poses, side: str) -> ConvexForm:  # noqa: ARG002
        """λ_max(ln G) − λ_min(ln G) <= ln k."""
        return forms.ratio_of_eigenvalues(forms.matrix_logarithm(_inertia(manipulator, poses)))


class Acceleration(Measure):
    """Acceleration that the actuators can give the tool from rest in every direction.

      box          min_i t_i / ‖r_i‖               forces of |τ_i| <= t_i
      ellipsoid    σ_min(J D⁻¹ diag(t_1...t_m))    forces of Σ (τ_i / t_i)² <= 1

    with r_i = row i of D J⁻¹ and t_i = τ_i^max − f_i − |g_i| what friction and gravity leave of the force.
    Not above 0 where an actuator cannot hold the machine still.

    Pashkevich, Chablat and Wenger (2009), eq. 9, read as every direction; the ellipsoid: Yoshikawa (1985).
    """

    unit: ClassVar[str] = "m/s^2"
    sides: ClassVar[frozenset[str]] = frozenset({"at_least"})
    needs: ClassVar[frozenset[str]] = frozenset({"joint_inertia", "actuator_forces"})

    ball: Literal["box", "ellipsoid"] = "box"
    """Whether the actuators' forces fill a box, each to its own limit, or the ellipsoid inside it."""

    def values(self, manipulator: Manipulator, poses: Poses) -> Array:
        """The radius [m/s²] (n,) of the ball of accelerations."""
        rows = _force_rows(manipulator, poses)
        left = _forces_left(manipulator, poses).min(axis=2)
        with np.errstate(divide="ignore", invalid="ignore"):
            radius = (left / _norms(rows)).min(axis=1)
            if self.ball == "ellipsoid":
                ellipsoid = 1.0 / np.sqrt(_eigenvalues(_gram(rows, left))[:, -1])
                radius = np.where((left <= 0).any(axis=1), radius, ellipsoid)
        return _or_if_singular(0.0, radius, manipulator, poses)

    def form(self, manipulator: Manipulator, poses: Poses, side: str) -> ConvexForm:  # noqa: ARG002
        """min ln((τ_i^max − f_i ∓ g_i) / ‖r_i‖) >= ln b; λ_min(−½ ln AᵀA) of A = diag(1/t) D J⁻¹."""
        rows = _force_rows(manipulator, poses)
        limits = np.minimum(manipulator.actuator_limits().forces, UNLIMITED)[:, None]
        left = _positive(np.minimum(_forces_left(manipulator, poses), UNLIMITED) / limits) * limits
        with np.errstate(divide="ignore", invalid="ignore"):
            if self.ball == "box":
                room = np.log(left) - _row_logarithms(rows)[:, :, None]
                return forms.least_entry(room.reshape(len(rows), -1))
            gram = _gram(rows, left.min(axis=2))
        return forms.least_eigenvalue(-0.5 * forms.semidefinite_logarithm(gram))


class JointSpeed(Measure):
    """Greatest joint speed that a tool speed asks for, whichever way the tool moves: v max_i ‖row_i(J⁻¹)‖."""

    unit: ClassVar[str] = "m/s"
    sides: ClassVar[frozenset[str]] = frozenset({"at_most"})
    least: ClassVar[float] = 0.0
    needs: ClassVar[frozenset[str]] = frozenset({"sliding_joints"})

    speed: Annotated[quantities.Speed, Field(gt=0)]
    """The tool's speed v [m/s]."""

    def values(self, manipulator: Manipulator, poses: Poses) -> Array:
        """The joint speed [m/s] (n,)."""
        rows = manipulator.inverse_jacobian(poses)
        speeds: Array = self.speed * _norms(rows).max(axis=1)
        return speeds

    def form(self, manipulator: Manipulator, poses: Poses, side: str) -> ConvexForm:  # noqa: ARG002
        """max ln(v ‖row_i(J⁻¹)‖) <= ln b."""
        rows = manipulator.inverse_jacobian(poses)
        return forms.greatest_entry(np.log(self.speed) + _row_logarithms(rows))


class ToolSpeed(Measure):
    """Speed that the actuators can give the tool in every direction: min_i v_i^max / ‖row_i(J⁻¹)‖."""

    unit: ClassVar[str] = "m/s"
    sides: ClassVar[frozenset[str]] = frozenset({"at_least"})
    needs: ClassVar[frozenset[str]] = frozenset({"actuator_speeds"})

    def values(self, manipulator: Manipulator, poses: Poses) -> Array:
        """The tool's speed [m/s] (n,)."""
        rows = manipulator.inverse_jacobian(poses)
        with np.errstate(divide="ignore"):
            speeds = manipulator.actuator_limits().speeds / _norms(rows)
        least: Array = speeds.min(axis=1)
        return least

    def form(self, manipulator: Manipulator, poses: Poses, side: str) -> ConvexForm:  # noqa: ARG002
        """min ln(v_i^max / ‖row_i(J⁻¹)‖) >= ln b."""
        speeds = np.minimum(manipulator.actuator_limits().speeds, UNLIMITED)
        return forms.least_entry(np.log(speeds) - _row_logarithms(manipulator.inverse_jacobian(poses)))


class ActuatorForce(Measure):
    """Greatest actuator force that accelerations up to a and speeds up to v of the tool ask for.

      max_i  a ‖r_i‖ + f_i + max( g_i + v² λ⁺(Q_i),  −g_i + v² λ⁺(−Q_i) )

    with r_i = row i of D J⁻¹, ṗᵀ Q_i ṗ the force that a constant velocity ṗ asks of actuator i, g_i its load
    at rest (gravity), f_i its friction, and λ⁺ the greatest eigenvalue, or 0 where all are below it.
    Acceleration and velocity each have the direction that is worst for actuator i. From rest, v = 0:
    a ‖r_i‖ + |g_i| + f_i.
    """

    unit: ClassVar[str] = "N"
    sides: ClassVar[frozenset[str]] = frozenset({"at_most"})
    least: ClassVar[float] = 0.0
    needs: ClassVar[frozenset[str]] = frozenset({"joint_inertia"})

    acceleration: Annotated[quantities.Acceleration, Field(ge=0)]
    """The tool's greatest acceleration a [m/s^2]."""
    speed: Annotated[quantities.Speed, Field(ge=0)] = 0.0
    """The tool's greatest speed v [m/s]."""

    def values(self, manipulator: Manipulator, poses: Poses) -> Array:
        """The force [N] (n,)."""
        forces = _greatest_force(*self._forces(manipulator, poses))
        return _or_if_singular(np.inf, forces, manipulator, poses)

    def form(self, manipulator: Manipulator, poses: Poses, side: str) -> ConvexForm:  # noqa: ARG002
        """a ‖r_i‖ + f_i ± g_i + λ⁺(±v² Q_i) <= b for each actuator and sign."""
        pushes, rest, moving = forces = self._forces(manipulator, poses)
        n, m, d, _ = moving.shape
        parts = np.concatenate([pushes, rest, moving.reshape(n, -1)], axis=1)

        def within(y: Any, limit: Any) -> list[Any]:
            import cvxpy as cp

            constraints = []
            for sign in (1, -1):
                left = limit - y[:m] - sign * y[m : 2 * m]
                constraints.append(left >= 0)
                for i in range(m if self.speed else 0):
                    start = 2 * m + i * d * d
                    force = cp.reshape(y[start : start + d * d], (d, d), order="C")
                    constraints.append(sign * force << left[i] * np.eye(d))
            return constraints

        return forms.convex_size(parts, _greatest_force(*forces), within, np.zeros(n))

    def _forces(self, manipulator: Manipulator, poses: Poses) -> tuple[Array, Array, Array]:
        """a ‖r_i‖ + f_i (n, m), g_i (n, m), and v² Q_i (n, m, d, d), without entries at rest."""
        norms = _norms(_force_rows(manipulator, poses))
        pushes = self.acceleration * norms + manipulator.actuator_limits().friction
        with np.errstate(invalid="ignore"):
            rest = manipulator.rest_load(poses)
            if self.speed == 0:
                return pushes, rest, np.empty((*rest.shape, 0, 0))
            return pushes, rest, self.speed**2 * manipulator.velocity_forces(poses)


def _eigenvalues(matrices: Matrices) -> Array:
    from orthospec import kernels

    return kernels.symmetric_eigenvalues(matrices)


def _norms(matrices: Matrices) -> Array:
    """‖row_i‖ (n, m)."""
    from orthospec import kernels

    return kernels.row_norms(matrices)


def _inertia(manipulator: Manipulator, poses: Poses) -> Matrices:
    """G (n, d, d)."""
    with np.errstate(invalid="ignore", over="ignore"):
        return at_tool(manipulator.inverse_jacobian(poses), manipulator.joint_inertia(poses))


def _or_if_singular(worst: float, values: Array, manipulator: Manipulator, poses: Poses) -> Array:
    """The values, the worst one in the place of NaN at a parallel singularity."""
    if not isinstance(values, np.ndarray):  # Intervals are undefined there, and prove nothing.
        return values
    unknown = np.flatnonzero(np.isnan(values))
    if not len(unknown):
        return values
    inverse = manipulator.inverse_jacobian(poses)[unknown]
    with np.errstate(divide="ignore", invalid="ignore"):
        volume = _norms(inverse).prod(axis=1)
        singular = np.abs(np.linalg.det(inverse)) <= SINGULAR * volume
    found = values.copy()
    found[unknown[singular]] = worst
    return found


def _force_rows(manipulator: Manipulator, poses: Poses) -> Matrices:
    """D J⁻¹ (n, m, d): actuator forces for a unit of acceleration of each pose coordinate."""
    with np.errstate(invalid="ignore", over="ignore"):
        rows: Matrices = manipulator.joint_inertia(poses) @ manipulator.inverse_jacobian(poses)
    return rows


def _forces_left(manipulator: Manipulator, poses: Poses) -> Array:
    """τ_i^max − f_i ∓ g_i (n, m, 2): what is left of each actuator's force on either side."""
    limits = manipulator.actuator_limits()
    with np.errstate(invalid="ignore"):
        rest = manipulator.rest_load(poses)
        return (limits.forces - limits.friction)[:, None] + np.stack([-rest, rest], axis=2)


def _positive(part: Array) -> Array:
    """What is left of a force, as a part of its limit; below `WEAK` it goes on as an exponential.

    So its logarithm is smooth, and falls, where an actuator cannot hold the machine.
    """
    fading = WEAK * np.exp(np.clip(part / WEAK, -FADED, 1.0) - 1.0)
    return np.where(part < WEAK, fading, part)


def _gram(rows: Matrices, left: Array) -> Matrices:
    """AᵀA (n, d, d) of A = diag(1/t) D J⁻¹."""
    scaled = rows / left[:, :, None]
    gram: Matrices = np.swapaxes(scaled, 1, 2) @ scaled
    return gram


def _greatest_force(pushes: Array, rest: Array, moving: Array) -> Array:
    """max_i of pushes + max(g_i + λ⁺(M_i), −g_i + λ⁺(−M_i)) (n,), M_i of any size d >= 0."""
    n, m, d, _ = moving.shape
    least, greatest = np.zeros((n, m)), np.zeros((n, m))
    if d:
        spectrum = _eigenvalues(moving.reshape(n * m, d, d)).reshape(n, m, d)
        least, greatest = np.minimum(spectrum[:, :, 0], 0.0), np.maximum(spectrum[:, :, -1], 0.0)
    forces: Array = (pushes + np.maximum(rest + greatest, -rest - least)).max(axis=1)
    return forces


def _row_logarithms(matrices: Matrices) -> Array:
    """ln ‖row_i‖ (n, m); of a row that is 0 a very small number."""
    squares = np.einsum("nij,nij->ni", matrices, matrices)
    with np.errstate(divide="ignore"):
        return np.asarray(0.5 * np.log(squares + SMALL_ROW**2 * squares.sum(axis=1, keepdims=True)))

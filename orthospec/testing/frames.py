"""A machine seen in a turned frame: the same one, so what has no direction of its own stays as it was."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from orthospec.manipulators import Manipulator, Skeleton

if TYPE_CHECKING:
    from orthospec.arrays import Array, Flags, Joints, Matrices, Poses
    from orthospec.manipulators.base import ActuatorLimits


def turned(machine: Manipulator, turn: Array) -> Manipulator:
    """The machine whose poses and tool are told in axes turned by R (3, 3); for axes x, y, z."""
    made: Any = type(
        f"Turned{type(machine).__name__}",
        (_Turned,),
        {
            "__doc__": "The same machine in another frame.",
            "axes": machine.axes,
            "joint_units": machine.joint_units,
            "index_units": machine.index_units,
        },
    )()
    made._machine, made._turn = machine, turn
    seen: Manipulator = made
    return seen


class _Turned(Manipulator):
    _machine: Any = None
    _turn: Any = None

    def _own(self, poses: Poses) -> Poses:
        """The poses as the machine itself tells them: p = Rᵀ p'."""
        own = np.asarray(poses @ self._turn)
        own.flags.writeable = False
        return own

    def inverse_kinematics(self, poses: Poses) -> tuple[Joints, Flags]:
        """The same joints."""
        joints, reachable = self._machine.inverse_kinematics(self._own(poses))
        return joints, reachable

    def reach(self, poses: Poses) -> Mapping[str, Array]:
        """The same margins."""
        return dict(self._machine.reach(self._own(poses)))

    def inverse_jacobian(self, poses: Poses) -> Matrices:
        """J⁻¹ Rᵀ."""
        return np.asarray(self._machine.inverse_jacobian(self._own(poses)) @ self._turn.T)

    def compliance(self, poses: Poses) -> Array:
        """R C Rᵀ, of translations and of rotations."""
        both = np.kron(np.eye(2), self._turn)
        return np.asarray(both @ self._machine.compliance(self._own(poses)) @ both.T)

    def joint_inertia(self, poses: Poses) -> Matrices:
        """The same."""
        return np.asarray(self._machine.joint_inertia(self._own(poses)))

    def rest_load(self, poses: Poses) -> Joints:
        """The same."""
        return np.asarray(self._machine.rest_load(self._own(poses)))

    def velocity_forces(self, poses: Poses) -> Array:
        """R Q_i Rᵀ."""
        return np.asarray(self._turn @ self._machine.velocity_forces(self._own(poses)) @ self._turn.T)

    def actuator_limits(self) -> ActuatorLimits:
        """The same."""
        limits: ActuatorLimits = self._machine.actuator_limits()
        return limits

    def missing(self, what: str) -> tuple[str, ...]:
        """The same."""
        return tuple(self._machine.missing(what))

    def indices(self, joint_ranges: Array) -> Mapping[str, float]:
        """The same."""
        return dict(self._machine.indices(joint_ranges))

    def skeleton(self, poses: Poses) -> Skeleton:
        """Turned."""
        drawn = self._machine.skeleton(self._own(poses))
        return Skeleton(drawn.segments @ self._turn.T, drawn.radii, drawn.names)

"""A machine seen in a turned frame or in other units: the same one, so that its measures have to agree."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from orthospec.manipulators import Manipulator, Skeleton
from orthospec.manipulators.base import ActuatorLimits
from orthospec.quantities.units import parse_unit

if TYPE_CHECKING:
    from orthospec.arrays import Array, Flags, Joints, Matrices, Poses


class Units(NamedTuple):
    """How many new units of length, mass and time make one metre, kilogram and second."""

    length: float = 1.0
    mass: float = 1.0
    time: float = 1.0

    def of(self, unit: str) -> float:
        """By what a number in this unit is multiplied; angles are left as they are."""
        metres, kilograms, seconds, _ = parse_unit(unit).dimension
        return float(self.length**metres * self.mass**kilograms * self.time**seconds)


def turned(machine: Manipulator, turn: Array) -> Manipulator:
    """The machine whose poses and tool are told in axes turned by R (3, 3); for axes x, y, z."""
    return _seen(_Turned, machine, _turn=turn)


def in_units(machine: Manipulator, units: Units) -> Manipulator:
    """The machine whose poses, and all that it gives, are told in other units."""
    return _seen(_InUnits, machine, _units=units)


def axis_factors(machine: Manipulator, units: Units) -> Array:
    """By what each pose coordinate is multiplied (d,)."""
    return np.array([units.of("m" if axis in {"x", "y", "z"} else "rad") for axis in machine.axes])


def _seen(view: type[_View], machine: Manipulator, **how: Any) -> Manipulator:
    """A view with the machine's own axes and units."""
    names = ("axes", "joint_units", "index_units")
    own = {"__doc__": view.__doc__} | {name: getattr(machine, name) for name in names}
    made: Any = type(f"{view.__name__[1:]}{type(machine).__name__}", (view,), own)()
    made._machine = machine
    for name, value in how.items():
        setattr(made, name, value)
    seen: Manipulator = made
    return seen


class _View(Manipulator):
    """A machine through which another one is seen."""

    _machine: Any = None

    def _own(self, poses: Poses) -> Poses:
        """The poses as the machine itself tells them, read-only."""
        own = self._told(poses)
        own.flags.writeable = False
        return own

    def _told(self, poses: Poses) -> Poses:
        raise NotImplementedError

    def reach(self, poses: Poses) -> Mapping[str, Array]:
        """The same margins."""
        return dict(self._machine.reach(self._own(poses)))

    def missing(self, what: str) -> tuple[str, ...]:
        """The same."""
        return tuple(self._machine.missing(what))


class _Turned(_View):
    """The same machine in another frame."""

    _turn: Any = None

    def _told(self, poses: Poses) -> Poses:
        """p = Rᵀ p'."""
        return np.asarray(poses @ self._turn)

    def inverse_kinematics(self, poses: Poses) -> tuple[Joints, Flags]:
        """The same joints."""
        joints, reachable = self._machine.inverse_kinematics(self._own(poses))
        return joints, reachable

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

    def indices(self, joint_ranges: Array) -> Mapping[str, float]:
        """The same."""
        return dict(self._machine.indices(joint_ranges))

    def skeleton(self, poses: Poses) -> Skeleton:
        """Turned."""
        drawn = self._machine.skeleton(self._own(poses))
        return Skeleton(drawn.segments @ self._turn.T, drawn.radii, drawn.names)


class _InUnits(_View):
    """The same machine in other units."""

    _units: Any = None

    @property
    def _along(self) -> Array:
        return axis_factors(self, self._units)

    @property
    def _joints(self) -> Array:
        return np.array([self._units.of(unit) for unit in self.joint_units])

    @property
    def _forces(self) -> Array:
        """Of the actuators: with its joint's rate each is a power."""
        return np.asarray(self._units.of("N*m") / self._joints)

    def _told(self, poses: Poses) -> Poses:
        return np.asarray(poses / self._along)

    def inverse_kinematics(self, poses: Poses) -> tuple[Joints, Flags]:
        """Joints in m or rad."""
        joints, reachable = self._machine.inverse_kinematics(self._own(poses))
        return joints * self._joints, reachable

    def inverse_jacobian(self, poses: Poses) -> Matrices:
        """Joints over pose coordinates."""
        factors = self._joints[:, None] / self._along
        return np.asarray(self._machine.inverse_jacobian(self._own(poses)) * factors)

    def compliance(self, poses: Poses) -> Array:
        """Displacements over forces: m/N, rad/N, rad/(N*m)."""
        ways = np.repeat([self._units.length, 1.0], 3)
        factors = np.outer(ways, ways) / self._units.of("N*m")
        return np.asarray(self._machine.compliance(self._own(poses)) * factors)

    def joint_inertia(self, poses: Poses) -> Matrices:
        """Forces over accelerations of joints."""
        factors = np.outer(self._forces, self._units.time**2 / self._joints)
        return np.asarray(self._machine.joint_inertia(self._own(poses)) * factors)

    def rest_load(self, poses: Poses) -> Joints:
        """Forces."""
        return np.asarray(self._machine.rest_load(self._own(poses)) * self._forces)

    def velocity_forces(self, poses: Poses) -> Array:
        """Forces over squares of velocities."""
        speeds = self._along / self._units.time
        factors = self._forces[:, None, None] / np.outer(speeds, speeds)
        return np.asarray(self._machine.velocity_forces(self._own(poses)) * factors)

    def actuator_limits(self) -> ActuatorLimits:
        """Forces, speeds of joints, forces."""
        forces, speeds, friction = self._machine.actuator_limits()
        rates = self._joints / self._units.time
        return ActuatorLimits(forces * self._forces, speeds * rates, friction * self._forces)

    def indices(self, joint_ranges: Array) -> Mapping[str, float]:
        """Each in its unit."""
        given = self._machine.indices(joint_ranges / self._joints[:, None])
        return {name: value * self._units.of(self.index_units[name]) for name, value in given.items()}

    def skeleton(self, poses: Poses) -> Skeleton:
        """Lengths."""
        drawn = self._machine.skeleton(self._own(poses))
        return Skeleton(drawn.segments * self._units.length, drawn.radii * self._units.length, drawn.names)

"""What a machine is: the abstract `Manipulator`, and one file a machine."""

from orthospec.manipulators.base import ActuatorLimits, Manipulator, Skeleton

__all__ = ["ActuatorLimits", "Manipulator", "Skeleton"]

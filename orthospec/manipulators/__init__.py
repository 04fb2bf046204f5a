"""What a machine is: the abstract `Manipulator`, and one file a machine."""

from orthospec.manipulators.base import Manipulator, Skeleton

__all__ = ["Manipulator", "Skeleton"]

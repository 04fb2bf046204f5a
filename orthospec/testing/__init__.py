"""Conformance of a plugin to what orthospec expects of it, in one line of a test:

    check_manipulator(MyMachine(leg_length=0.4))
    check_measure(MyMeasure(force=100.0), MyMachine(leg_length=0.4))

Each promise of the contract is tried at many poses, reachable and not. What is broken is said with the pose,
what was found, what was expected and the way out, as a `Nonconformity`, which every test runner shows.
"""

from orthospec.testing.expectations import Nonconformity
from orthospec.testing.machines import check_manipulator
from orthospec.testing.measures import check_measure

__all__ = ["Nonconformity", "check_manipulator", "check_measure"]

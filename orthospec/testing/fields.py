"""What a machine computes over poses."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

import numpy as np

from orthospec.manipulators import Manipulator
from orthospec.testing.sampling import CLOSE

if TYPE_CHECKING:
    from orthospec.arrays import Array, Poses

Field = Callable[[Manipulator, "Poses"], "Array"]
"""Of a machine over poses, the poses first in what it gives."""


def fields_of(machine: Manipulator) -> Mapping[str, Field]:
    """What it computes over poses, by name."""
    found: dict[str, Field] = {
        "inverse_kinematics": lambda machine, poses: machine.inverse_kinematics(poses)[0],
        "inverse_jacobian": lambda machine, poses: machine.inverse_jacobian(poses),
        "reach": lambda machine, poses: np.stack(list(machine.reach(poses).values()), axis=1),
    }
    if not machine.missing("compliance") and offers(machine, "compliance"):
        found["compliance"] = lambda machine, poses: machine.compliance(poses)
    if not machine.missing("joint_inertia") and offers(machine, "joint_inertia"):
        found["joint_inertia"] = lambda machine, poses: machine.joint_inertia(poses)
        if offers(machine, "rest_load"):
            found["rest_load"] = lambda machine, poses: machine.rest_load(poses)
        if offers(machine, "velocity_forces"):
            found["velocity_forces"] = lambda machine, poses: machine.velocity_forces(poses)
    return found


def offers(machine: Manipulator, name: str) -> bool:
    """Whether its class has this optional method."""
    return getattr(type(machine), name) is not getattr(Manipulator, name)


def apart(alone: Array, together: Array, k: int) -> tuple[float, float] | None:
    """What a pose gives alone and in row k of a block, at an entry where the two are not the same.

    They are the same to rounding of the block's greatest number.
    """
    size = float(np.abs(together[np.isfinite(together)]).max(initial=0.0))
    wrong = ~np.isclose(alone, together[k], rtol=CLOSE, atol=CLOSE * size, equal_nan=True)
    return (float(alone[wrong][0]), float(together[k][wrong][0])) if wrong.any() else None

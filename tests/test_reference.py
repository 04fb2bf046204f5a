"""Stiffness and dynamics against programs that nobody here wrote: see ``reference/README.md``."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from orthospec.manipulators.linear_delta import LinearDelta
from orthospec.manipulators.orthoglide import Orthoglide

FOLDER = Path(__file__).parent / "reference"
CLASSES = {"orthoglide": Orthoglide, "linear_delta": LinearDelta}
CASES = ("orthoglide_puu", "orthoglide_prpar", "linear_delta_puu", "linear_delta_prpar")
BLOCKS = {"tt": (slice(3), slice(3)), "tr": (slice(3), slice(3, 6)), "rr": (slice(3, 6), slice(3, 6))}
ROUNDING = 2e-8
"""The stored numbers have nine digits."""


@cache
def reference(case: str) -> SimpleNamespace:
    """The machine, and each column of the stored rows as an array whose first axis is the pose."""
    stored = json.loads((FOLDER / f"{case}.json").read_text(encoding="utf-8"))
    keys = dict(stored["machine"])
    columns = zip(*stored["rows"], strict=True)
    arrays = {name: np.array(column) for name, column in zip(stored["columns"], columns, strict=True)}
    return SimpleNamespace(machine=CLASSES[keys.pop("use")].model_validate(keys), **arrays)


def symmetric(upper: np.ndarray) -> np.ndarray:
    found = np.empty((len(upper), 3, 3))
    rows, columns = np.triu_indices(3)
    found[:, rows, columns] = found[:, columns, rows] = upper
    return found


def error(found: np.ndarray, expected: np.ndarray) -> float:
    """The greatest over the poses of the difference's norm over the expected one's."""
    n = len(expected)
    size = np.linalg.norm(expected.reshape(n, -1), axis=1)
    return float(np.max(np.linalg.norm((found - expected).reshape(n, -1), axis=1) / size))


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("block", BLOCKS)
def test_compliance_is_that_of_the_frame_in_pynite(case: str, block: str) -> None:
    known = reference(f"{case}.stiffness")
    assert known.poses.shape == (200, 3)
    rows, columns = BLOCKS[block]
    found = known.machine.compliance(known.poses)[:, rows, columns]
    stored = getattr(known, block)
    expected = stored.reshape(-1, 3, 3) if block == "tr" else symmetric(stored)
    assert error(found, expected) < 1e-6


@pytest.mark.parametrize("case", CASES)
def test_jacobian_is_that_of_the_closed_loops_in_pinocchio(case: str) -> None:
    known = reference(f"{case}.dynamics")
    jacobian = known.jacobian.reshape(-1, 3, 3)
    assert known.machine.inverse_kinematics(known.poses)[1].all()
    assert error(np.linalg.inv(known.machine.inverse_jacobian(known.poses)), jacobian) < ROUNDING


@pytest.mark.parametrize("case", CASES)
def test_joint_inertia_is_that_of_the_closed_loops_in_pinocchio(case: str) -> None:
    known = reference(f"{case}.dynamics")
    assert known.joint_inertia.shape == (200, 6)
    assert error(known.machine.joint_inertia(known.poses), symmetric(known.joint_inertia)) < ROUNDING


@pytest.mark.parametrize("case", CASES)
def test_rest_load_is_what_pinocchio_needs_to_hold_the_machine_still(case: str) -> None:
    known = reference(f"{case}.dynamics")
    assert error(known.machine.rest_load(known.poses), known.rest_load) < ROUNDING


@pytest.mark.parametrize("case", CASES)
def test_actuator_forces_of_a_motion_are_those_of_pinocchios_inverse_dynamics(case: str) -> None:
    known = reference(f"{case}.dynamics")
    machine, poses, velocity = known.machine, known.poses, known.velocity
    sliders = np.einsum("nij,nj->ni", machine.inverse_jacobian(poses), known.acceleration)
    found = np.einsum("nij,nj->ni", machine.joint_inertia(poses), sliders) + machine.rest_load(poses)
    found += np.einsum("nj,nijk,nk->ni", velocity, machine.velocity_forces(poses), velocity)
    assert error(found, known.actuator_forces) < ROUNDING


@pytest.mark.parametrize("case", CASES)
def test_velocity_forces_carry_weight_in_the_motions_compared(case: str) -> None:
    """Otherwise the comparison above would not see them."""
    known = reference(f"{case}.dynamics")
    Q, velocity = known.machine.velocity_forces(known.poses), known.velocity
    forces = np.einsum("nj,nijk,nk->ni", velocity, Q, velocity)
    assert np.linalg.norm(forces, axis=1).max() > 0.1 * np.linalg.norm(known.actuator_forces, axis=1).max()

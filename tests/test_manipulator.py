"""What every machine does for its fields: a block is computed once, and nobody changes what others get."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pytest

from orthospec.errors import NoEnclosure
from orthospec.intervals import Boxes
from orthospec.manipulators.orthoglide import Orthoglide

POSES = np.random.default_rng(0).uniform(-0.05, 0.05, (20, 3))
POSES.flags.writeable = False


@pytest.fixture
def machine():
    return Orthoglide(leg_lengths=(0.3, 0.31, 0.32))


def test_a_block_is_computed_once_and_a_writeable_one_each_time(machine):
    assert machine.inverse_jacobian(POSES) is machine.inverse_jacobian(POSES)
    own = POSES.copy()
    before = machine.inverse_jacobian(own)
    own += 0.01
    assert np.abs(machine.inverse_jacobian(own) - before).max() > 1e-3


@pytest.mark.parametrize("field", ["inverse_jacobian", "reach", "inverse_kinematics", "closed_legs"])
def test_what_is_remembered_is_read_only(machine, field):
    found = getattr(machine, field)(POSES)
    parts = found.values() if field == "reach" else found if isinstance(found, tuple) else [found]
    for part in parts:
        with pytest.raises(ValueError, match="read-only"):
            part *= 0.5
    if field == "reach":
        with pytest.raises(TypeError, match="does not support item assignment"):
            found["mine"] = POSES[:, 0]


def test_over_boxes_too(machine):
    poses = Boxes(POSES, POSES + 1e-3).poses
    found = machine.inverse_jacobian(poses)
    with pytest.raises(NoEnclosure, match="others are given too"):
        found *= 0.5


def test_boxes_changed_in_place_are_computed_again(machine):
    own = Boxes(POSES, POSES + 1e-6).poses.copy()
    before = machine.inverse_jacobian(own)
    own[:, 0] = own[:, 0] + 0.01
    moved = np.array(POSES)
    moved[:, 0] += 0.01
    after, expected = machine.inverse_jacobian(own), machine.inverse_jacobian(moved)
    assert ((after.lo <= expected) & (expected <= after.hi)).all()
    assert np.abs(after.lo - before.lo).max() > 1e-3


@pytest.mark.parametrize(
    "copied", [Orthoglide.model_copy, copy.copy, copy.deepcopy], ids=["model_copy", "copy", "deepcopy"]
)
def test_a_copy_remembers_nothing(machine, copied):
    machine.inverse_jacobian(POSES)
    assert machine.geometry is not None
    other = copied(machine)
    assert other == machine
    assert not other._memory


@pytest.mark.parametrize("deep", [False, True])
def test_a_copy_with_other_lengths_is_the_machine_of_these(machine, deep):
    machine.inverse_jacobian(POSES)
    lengths = (0.4, 0.41, 0.42)
    other = machine.model_copy(update={"leg_lengths": lengths}, deep=deep)
    expected = Orthoglide(leg_lengths=lengths).inverse_jacobian(POSES)
    np.testing.assert_array_equal(other.inverse_jacobian(POSES), expected)


def test_another_process_is_sent_the_machine_without_its_blocks(machine):
    alone = len(pickle.dumps(machine))
    machine.inverse_jacobian(np.broadcast_to(0.0, (10_000, 3)))
    sent = pickle.dumps(machine)
    assert len(sent) < alone + 1000
    assert pickle.loads(sent).model_dump() == machine.model_dump()

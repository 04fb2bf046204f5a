"""What every machine does for its fields: a block is computed once, and nobody changes what others get."""

from __future__ import annotations

import copy
import pickle
from collections.abc import Callable, Mapping
from typing import Any, ClassVar

import numpy as np
import pytest

from orthospec.errors import NoEnclosure, PluginFault
from orthospec.intervals import Boxes
from orthospec.manipulators import Skeleton
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


class Given(Orthoglide):
    """An Orthoglide, of which a method gives something else."""

    index_units: ClassVar[Mapping[str, str]] = {**Orthoglide.index_units, "reserve": "1"}
    wrong: ClassVar[dict[str, Callable[[Any], Any]]] = {}

    def indices(self, joint_ranges):
        """One more than the machine that it is made of."""
        found = {**super().indices(joint_ranges), "reserve": 0.5}
        return self.wrong.get("indices", dict)(found)

    def skeleton(self, poses):
        """The same."""
        return self.wrong.get("skeleton", lambda drawn: drawn)(super().skeleton(poses))

    def reach_enclosure(self, boxes):
        """The same."""
        return self.wrong.get("reach_enclosure", dict)(super().reach_enclosure(boxes))


def _asked(machine, method):
    boxes = Boxes(POSES, POSES + 1e-3)
    argument = {"indices": np.zeros((3, 2)), "skeleton": POSES, "reach_enclosure": boxes}[method]
    return getattr(machine, method)(argument)


@pytest.mark.parametrize("method", ["indices", "skeleton", "reach_enclosure"])
def test_a_machine_may_add_to_what_another_class_gives(method):
    assert _asked(Given(leg_lengths=(0.3, 0.3, 0.3)), method)


@pytest.mark.parametrize(
    ("method", "wrong", "says"),
    [
        ("indices", lambda _: 5, "gave int, not a mapping"),
        ("indices", lambda one: one | {"extra": 1.0}, "gave 'extra', of which index_units knows no unit"),
        ("indices", lambda one: one | {"stroke": "long"}, "gave 'long' for 'stroke', not a number"),
        ("indices", lambda _: {"stroke": 1.0}, "gave no 'leg_length_total', which index_units names"),
        ("skeleton", lambda _: None, "gave NoneType, not a Skeleton"),
        (
            "skeleton",
            lambda one: Skeleton(one.segments[:, :1], one.radii, one.names),
            r"gave segments \(20, 1, 2, 3\), radii \(\d+,\) and \d+ names for 20 poses",
        ),
        ("reach_enclosure", lambda _: None, "gave NoneType, not a mapping"),
        ("reach_enclosure", lambda one: dict(list(one.items())[1:]), "gave no '.*', which reach has"),
        ("reach_enclosure", lambda one: {**one, "hole": POSES}, "gave 'hole', which reach has not"),
    ],
)
def test_what_a_machine_owes_and_does_not_give_is_its_fault(method, wrong, says, monkeypatch):
    monkeypatch.setitem(Given.wrong, method, wrong)
    with pytest.raises(PluginFault, match=f"plugin Given: {method} {says}"):
        _asked(Given(leg_lengths=(0.3, 0.3, 0.3)), method)


def test_a_machine_that_ends_the_program_is_its_fault(monkeypatch):
    def ends(_):
        raise SystemExit(7)

    monkeypatch.setitem(Given.wrong, "skeleton", ends)
    with pytest.raises(PluginFault, match="plugin Given: skeleton raised SystemExit: 7"):
        _asked(Given(leg_lengths=(0.3, 0.3, 0.3)), "skeleton")


def test_an_index_that_the_machine_cannot_know_may_be_left_out():
    machine = Orthoglide(leg_lengths=(0.3, 0.3, 0.3))
    assert "total_mass" in machine.index_units
    assert "total_mass" not in machine.indices(np.zeros((3, 2)))

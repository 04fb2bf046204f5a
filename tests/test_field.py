"""The field: four states of a node, failures told with their pose, plugins held to their contract."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np
import pytest
from pydantic import PrivateAttr

from orthospec.errors import PluginFault, UsageError
from orthospec.manipulators import Manipulator
from orthospec.manipulators.orthoglide import Orthoglide
from orthospec.measures import Demand, Level, Measure
from orthospec.measures.kinematic import ConditionNumber, VelocityTransmission
from orthospec.workspace import field
from orthospec.workspace.field import State, measured, node_states, together
from orthospec.workspace.grid import Grid

GRID = Grid((0.1,) * 3, (-6,) * 3, (12,) * 3, 3)
UNIT = Orthoglide(leg_lengths=(1.0, 1.0, 1.0))


class Scripted(Measure):
    """A stranger's measure that does as it is told, and remembers what it was handed."""

    unit: ClassVar[str] = "1"
    sides: ClassVar[frozenset[str]] = frozenset({"at_least", "at_most"})
    act: Any = None
    _seen: list[Any] = PrivateAttr(default_factory=list)

    def values(self, manipulator, poses):  # noqa: ARG002
        self._seen.append(poses)
        return self.act(poses)


class Counting(Manipulator):
    """A machine of J⁻¹ = I within |p| <= 0.5, which counts how often it is asked for that."""

    _calls: list[int] = PrivateAttr(default_factory=list)

    def inverse_kinematics(self, poses):
        return poses.copy(), np.linalg.norm(poses, axis=1) <= 0.5

    def reach(self, poses):
        return {"ball": 0.5 - np.linalg.norm(poses, axis=1)}

    def inverse_jacobian(self, poses):
        self._calls.append(len(poses))
        return np.tile(np.eye(3), (len(poses), 1, 1))

    def indices(self, joint_ranges):  # noqa: ARG002
        return {}

    def skeleton(self, poses):  # noqa: ARG002
        pytest.fail("nothing here draws the machine")


def scripted(act, name="mine", **bounds):
    return Demand(name, Scripted(act=act), bounds or {"at_most": 1.0}, place="s.yaml:9:3")


def norms(poses):
    return np.linalg.norm(poses, axis=1)


def poses_of(grid):
    return grid.poses(0, grid.nodes)


def test_a_node_is_unreachable_or_meets_or_violates():
    (states,), failures = node_states(UNIT, [scripted(norms, at_most=0.45)], GRID)
    poses = poses_of(GRID)
    reachable = UNIT.inverse_kinematics(poses)[1]
    expected = np.where(norms(poses) <= 0.45, State.MEETS, State.VIOLATES)
    expected[~reachable] = State.UNREACHABLE
    np.testing.assert_array_equal(states.ravel(), expected)
    assert set(expected) == {State.UNREACHABLE, State.MEETS, State.VIOLATES}
    assert failures == []


def test_nan_at_one_reachable_pose_is_one_failed_node_told_with_its_pose_and_place():
    def broken_at_the_origin(poses):
        return np.where(norms(poses) < 1e-9, np.nan, norms(poses))

    (states,), failures = node_states(UNIT, [scripted(broken_at_the_origin)], GRID)
    assert np.count_nonzero(states == State.FAILED) == 1
    assert states[6, 6, 6] == State.FAILED
    (failure,) = failures
    assert failure.measure == "mine"
    assert failure.pose == (0.0, 0.0, 0.0)
    assert failure.place == "s.yaml:9:3"


def test_nan_in_one_column_is_a_failure_too():
    def half(poses):
        return np.column_stack([norms(poses), np.where(norms(poses) < 1e-9, np.nan, norms(poses))])

    (states,), failures = node_states(UNIT, [scripted(half)], GRID)
    assert states[6, 6, 6] == State.FAILED
    assert len(failures) == 1


def test_infinity_violates_and_is_no_failure():
    def infinite(poses):
        return np.full(len(poses), np.inf)

    (states,), failures = node_states(UNIT, [scripted(infinite)], GRID)
    assert set(np.unique(states)) == {State.UNREACHABLE, State.VIOLATES}
    assert failures == []


def test_without_demands_the_reach_alone_is_told():
    (states,), failures = node_states(UNIT, [], GRID)
    reachable = UNIT.inverse_kinematics(poses_of(GRID))[1]
    np.testing.assert_array_equal(states.ravel(), np.where(reachable, State.MEETS, State.UNREACHABLE))
    assert failures == []


def raising(poses):
    raise ZeroDivisionError(f"{len(poses)} poses were too many")


def exiting(_):
    raise SystemExit(7)


@pytest.mark.parametrize(
    ("act", "says"),
    [
        (exiting, "raised SystemExit: 7"),
        (raising, "raised ZeroDivisionError: .* too many"),
        (lambda poses: np.zeros(len(poses) + 1), r"gave shape \(\d+,\) for \d+ poses"),
        (lambda poses: np.zeros((len(poses), 3)), r"gave shape \(\d+, 3\)"),
        (
            lambda poses: np.column_stack([np.full(len(poses), 2.0), np.ones(len(poses))]),
            "gave 2 as the least value and 1 as the greatest of one pose",
        ),
        (lambda _: 1.0, "gave float"),
        (lambda poses: np.ma.masked_less(np.ones(len(poses)), 0), "gave MaskedArray"),
        (lambda poses: [1.0] * len(poses), "gave list"),
        (lambda poses: np.zeros(len(poses), dtype=int), "not an array of floats"),
        (lambda _: None, "gave NoneType"),
    ],
)
def test_breaking_the_contract_is_the_plugins_fault_named_with_its_place(act, says):
    with pytest.raises(PluginFault, match=says) as fault:
        node_states(UNIT, [scripted(act)], GRID)
    assert fault.value.exit_code == 5
    assert fault.value.place == "s.yaml:9:3"
    assert "Scripted" in fault.value.plugin
    assert "mine" in fault.value.plugin
    assert str(fault.value).startswith("s.yaml:9:3: plugin ")


def test_an_error_raised_on_purpose_passes_through():
    def refuse(_):
        raise UsageError("give the payload")

    with pytest.raises(UsageError, match="payload"):
        measured(scripted(refuse), UNIT, np.zeros((1, 3)))


def test_measures_are_handed_whole_blocks_of_reachable_poses_read_only(monkeypatch):
    monkeypatch.setattr(field, "BLOCK", 500)
    demand = scripted(norms)
    node_states(UNIT, [demand], GRID)
    seen = demand.measure._seen
    everything = np.vstack(seen)
    np.testing.assert_array_equal(everything, poses_of(GRID)[UNIT.inverse_kinematics(poses_of(GRID))[1]])
    assert len(seen) <= -(-GRID.nodes // 500)
    assert all(0 < len(poses) <= 500 for poses in seen)
    assert not any(poses.flags.writeable for poses in seen)


def test_the_size_of_a_block_changes_nothing(monkeypatch):
    demands = [Demand("t", VelocityTransmission(), {"at_least": 0.5, "at_most": 2.0})]
    (whole,), _ = node_states(UNIT, demands, GRID)
    monkeypatch.setattr(field, "BLOCK", 77)
    (cut,), _ = node_states(UNIT, demands, GRID)
    np.testing.assert_array_equal(whole, cut)


def test_two_measures_cost_one_field_of_jacobians(monkeypatch):
    monkeypatch.setattr(field, "BLOCK", 600)
    machine = Counting()
    bounds = {"at_most": 2.0}
    demands = [Demand("t", VelocityTransmission(), bounds), Demand("c", ConditionNumber(), bounds)]
    node_states(machine, demands, GRID)
    reachable = np.count_nonzero(norms(poses_of(GRID)) <= 0.5)
    assert sum(machine._calls) == reachable
    assert len(machine._calls) <= -(-GRID.nodes // 600)


def test_levels_share_the_values_of_their_measure():
    demand = Demand("mine", Scripted(act=norms), {"at_most": 0.5}, (Level({"at_most": 0.3}),))
    states, _ = node_states(UNIT, [demand, demand.at(demand.levels[0])], GRID)
    assert len(demand.measure._seen) == 1
    assert np.count_nonzero(states[1] == State.MEETS) < np.count_nonzero(states[0] == State.MEETS)


def test_together_a_node_is_as_bad_as_its_worst_measure():
    one, two = (np.arange(4, dtype=np.uint8).reshape(1, 1, 4) for _ in range(2))
    reach = np.array([[[0, 1, 1, 1]]], dtype=np.uint8)
    np.testing.assert_array_equal(together([one, two]), one)
    np.testing.assert_array_equal(together([reach, one]), [[[0, 1, 2, 3]]])


def test_progress_ends_with_all_nodes(monkeypatch):
    monkeypatch.setattr(field, "BLOCK", 500)
    told = []
    node_states(UNIT, [], GRID, lambda *step: told.append(step))
    assert [done for _, done, _ in told] == sorted(done for _, done, _ in told)
    assert told[-1][1:] == (GRID.nodes, GRID.nodes)

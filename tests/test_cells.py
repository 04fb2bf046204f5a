"""States by whole cells are those of node after node, with few of the nodes measured."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import PrivateAttr

from orthospec.errors import PluginFault
from orthospec.manipulators import Manipulator
from orthospec.manipulators.linear_delta import LinearDelta
from orthospec.manipulators.orthoglide import Orthoglide
from orthospec.measures import Demand, Level, Measure
from orthospec.measures.elastic import Deflection
from orthospec.measures.kinematic import ConditionNumber, Manipulability, VelocityTransmission
from orthospec.workspace import cells
from orthospec.workspace.cells import grid_states
from orthospec.workspace.field import State, node_states
from orthospec.workspace.grid import Grid

UNIT = Orthoglide(leg_lengths=(1.0, 1.0, 1.0))
GRID = Grid((0.04,) * 3, (-27, -26, -25), (55, 50, 47), 3)
ELASTIC = Orthoglide.model_validate(
    {
        "leg_lengths": [0.31] * 3,
        "legs": {
            "kind": "PRPaR",
            "section": {"rectangle": {"height": 0.014, "width": 0.014}},
            "material": "aluminium",
            "spacing": 0.08,
        },
        "actuators": {"stiffness": 5e7},
    }
)
VELOCITY = Demand(
    "velocity",
    VelocityTransmission(),
    {"at_least": 0.5, "at_most": 2.0},
    (Level({"at_most": 1.7}), Level({"at_least": 0.8})),
)
CONDITION = Demand("condition", ConditionNumber(), {"at_most": 3.0})


class Scripted(Measure):
    """A stranger's measure, written for numbers and intervals or not, that counts its poses."""

    unit: ClassVar[str] = "1"
    sides: ClassVar[frozenset[str]] = frozenset({"at_least", "at_most"})
    act: Any = None
    _seen: list[int] = PrivateAttr(default_factory=list)

    def values(self, manipulator: Manipulator, poses: Any) -> Any:  # noqa: ARG002
        if isinstance(poses, np.ndarray):
            self._seen.append(len(poses))
        return self.act(poses)

    @property
    def poses(self) -> int:
        return sum(self._seen)


def scripted(act: Any, name: str = "mine", **bounds: float) -> Demand:
    return Demand(name, Scripted(act=act), bounds or {"at_most": 0.5}, place="s.yaml:9:3")


def norms(poses: Any) -> Any:
    return np.linalg.norm(poses, axis=1)


def number_only(poses: Any) -> Any:
    return np.array([float(row @ row) ** 0.5 for row in np.asarray(poses)])


def broken_near(place: float) -> Any:
    """NaN beside one plane, and there only by way of what is plain to see in intervals too."""

    def act(poses: Any) -> Any:
        with np.errstate(invalid="ignore"):
            return norms(poses) + 0.0 * np.sqrt(np.abs(poses[:, 0] - place) - 0.01)

    return act


@pytest.fixture(autouse=True)
def any_grid_is_large(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cells, "FEW", 0)
    monkeypatch.setattr(cells, "FINEST", 4)


def assert_as_node_after_node(manipulator: Manipulator, demands: Sequence[Demand], grid: Grid) -> None:
    expected, expected_failures = node_states(manipulator, demands, grid)
    found, failures = grid_states(manipulator, demands, grid)
    for one, other in zip(found, expected, strict=True):
        np.testing.assert_array_equal(one, other)
    assert sorted(failures, key=str) == sorted(expected_failures, key=str)


def asked(*demands: Demand) -> list[Demand]:
    return [*demands, *(demand.at(level) for demand in demands for level in demand.levels)]


class TestSame:
    def test_for_several_measures_and_levels_over_the_whole_reach(self) -> None:
        demands = asked(VELOCITY, CONDITION, Demand("volume", Manipulability(), {"at_least": 0.7}))
        assert_as_node_after_node(UNIT, demands, GRID)

    def test_for_an_elastic_measure(self) -> None:
        grid = Grid((0.012,) * 3, (-27, -26, -25), (50, 50, 50), 3)
        levels = (Level({"at_most": 7e-6}), Level({"at_most": 6e-6}))
        deflection = Demand("deflection", Deflection(force=100.0), {"at_most": 12e-6}, levels)
        assert_as_node_after_node(ELASTIC, asked(deflection, VELOCITY), grid)

    def test_for_joint_limits_and_another_machine(self) -> None:
        delta = LinearDelta.model_validate(
            {
                "leg_lengths": [0.9] * 3,
                "base_radius": 0.5,
                "platform_radius": 0.1,
                "joint_limits": {"min": -1.2},
            }
        )
        grid = Grid((0.05, 0.05, 0.05), (-12, -12, -20), (25, 25, 40), 3)
        assert_as_node_after_node(delta, asked(CONDITION, VELOCITY), grid)

    def test_in_the_plane(self) -> None:
        flat = Grid((0.01, 0.01), (-80, -60), (150, 130), 3)
        assert_as_node_after_node(UNIT, asked(VELOCITY), flat)

    def test_where_a_measure_fails(self) -> None:
        demands = [scripted(broken_near(0.2)), VELOCITY]
        states, failures = grid_states(UNIT, demands, GRID)
        assert (states[0] == State.FAILED).any()
        assert [failure.measure for failure in failures] == ["mine"]
        assert_as_node_after_node(UNIT, demands, GRID)

    def test_for_measures_of_which_nothing_is_known_over_boxes(self) -> None:
        small = Grid((0.1,) * 3, (-6,) * 3, (12,) * 3, 3)
        assert_as_node_after_node(UNIT, [scripted(number_only), VELOCITY, scripted(norms, "other")], small)
        assert_as_node_after_node(UNIT, [scripted(number_only)], small)

    def test_without_demands_the_reach(self) -> None:
        assert_as_node_after_node(UNIT, [], GRID)

    @settings(max_examples=25)
    @given(
        st.floats(-1.0, 1.0),
        st.sampled_from(["at_least", "at_most"]),
        st.tuples(*[st.integers(1, 23)] * 3),
        st.tuples(*[st.integers(-25, 5)] * 3),
    )
    def test_for_any_bound_and_grid(
        self, bound: float, side: str, shape: tuple[int, ...], first: tuple[int, ...]
    ) -> None:
        demand = scripted(lambda poses: poses[:, 0] * poses[:, 1] - poses[:, 2], **{side: bound})
        assert_as_node_after_node(UNIT, [demand], Grid((0.04,) * 3, first, shape, 3))

    @pytest.mark.parametrize("side", ["at_least", "at_most"])
    @pytest.mark.parametrize("bound", [0.4, 0.0])
    def test_where_nodes_stand_on_the_bound_itself(self, side: str, bound: float) -> None:
        grid = Grid((0.05,) * 3, (-8,) * 3, (17,) * 3, 3)
        assert_as_node_after_node(UNIT, [scripted(lambda poses: poses[:, 0], **{side: bound})], grid)


class TestSpared:
    def test_few_nodes_are_measured(self) -> None:
        demand = scripted(norms)
        grid = Grid((0.01,) * 3, (-32,) * 3, (64,) * 3, 3)
        (states,), _ = grid_states(UNIT, [demand], grid)
        assert np.isin(states, [State.MEETS, State.VIOLATES]).all()
        assert demand.measure.poses < 0.2 * grid.nodes

    def test_only_measures_that_are_open_are_measured(self) -> None:
        near, far = scripted(norms), scripted(lambda poses: 2.0 * norms(poses), "far", at_most=9.0)
        grid_states(UNIT, [near, far], Grid((0.01,) * 3, (-32,) * 3, (64,) * 3, 3))
        assert near.measure.poses > 0
        assert far.measure.poses == 0

    def test_small_grids_are_measured_whole(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr(cells, "FEW", 1 << 17)
        demand = scripted(norms)
        small = Grid((0.1,) * 3, (-3,) * 3, (7,) * 3, 3)
        grid_states(UNIT, [demand], small)
        assert demand.measure.poses == small.nodes


def test_progress_counts_all_nodes_to_the_end() -> None:
    told: list[tuple[str, int, int]] = []
    grid_states(UNIT, asked(VELOCITY), GRID, lambda *step: told.append(step))
    done = [done for _, done, _ in told]
    assert done == sorted(done)
    assert done[-1] == GRID.nodes
    assert {(name, of) for name, _, of in told} == {("grid", GRID.nodes)}


def test_a_measure_that_raises_is_named_with_its_place() -> None:
    def act(poses: Any) -> Any:
        if isinstance(poses, np.ndarray):
            raise ZeroDivisionError("none")
        return norms(poses)

    with pytest.raises(PluginFault, match="none"):
        grid_states(UNIT, [scripted(act)], GRID)

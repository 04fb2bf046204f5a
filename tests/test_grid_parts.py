"""The states of a grid in parts: the same from anyone and in any order."""

from __future__ import annotations

import pickle
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np
import pytest

from orthospec.measures.kinematic import ConditionNumber
from orthospec.optimise import grid_parts
from orthospec.optimise.grid_parts import GridStates, Part
from orthospec.optimise.space import DesignSpace, machine_of
from orthospec.spec import Design, Spec
from orthospec.workspace import cells
from orthospec.workspace.evaluate import evaluate
from orthospec.workspace.field import node_states
from orthospec.workspace.grid import Grid

SPEC = """\
orthospec: 1
variables: {leg: {min: 250 mm, max: 500 mm}}
manipulator: {use: orthoglide, leg_lengths: [leg, leg, leg]}
workspace: {size: [200 mm, 200 mm, 200 mm], divisions: 5}
measures:
  transmission: {use: velocity_transmission, at_least: 0.5, at_most: 2, levels: {at_most: [1.8]}}
  condition: {use: condition_number, at_most: 3}
"""
LEG = (0.31,)
GRID = Grid((0.03,) * 3, (-10, -9, -8), (21, 20, 19), 3)


class Backwards:
    """Helpers that are handed pickled parts, and hand over the last one's states first."""

    def __init__(self) -> None:
        self.parts: list[Part] = []

    def each(
        self,
        task: Any,
        space: DesignSpace,
        items: Sequence[Part],
        progress: Any = None,  # noqa: ARG002
    ) -> Iterator[tuple[int, Any]]:
        for number in reversed(range(len(items))):
            self.parts.append(items[number])
            there, item = pickle.loads(pickle.dumps((space, items[number])))
            yield number, task.work(there, item, None)


@pytest.fixture(scope="module")
def spec(spec_of: Callable[..., Spec]) -> Spec:
    return spec_of(SPEC)


@pytest.fixture(scope="module")
def design(spec: Spec) -> Design:
    return spec.design({"leg": LEG[0]})


@pytest.fixture(autouse=True)
def small_parts_worth_sharing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cells, "FEW", 0)
    monkeypatch.setattr(cells, "FINEST", 4)
    monkeypatch.setattr(grid_parts, "PART", 1000)
    monkeypatch.setattr(grid_parts, "WORTH_SHARING", -1.0)


def _asked(design: Design) -> list[Any]:
    demands = list(design.demands)
    return [*demands, *(demand.at(level) for demand in demands for level in demand.levels)]


def test_parts_from_others_in_any_order_give_the_states_of_the_whole(spec: Spec, design: Design) -> None:
    helpers, asked = Backwards(), _asked(design)
    found, failures = GridStates(DesignSpace(spec, helpers=helpers), LEG)(design.manipulator, asked, GRID)
    expected, _ = node_states(design.manipulator, asked, GRID)
    for one, other in zip(found, expected, strict=True):
        np.testing.assert_array_equal(one, other)
    assert len(helpers.parts) == 10
    assert not failures


def test_the_first_failure_is_the_same_in_any_order(
    spec: Spec, design: Design, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of a measure without bounds over a box there, which fails in many parts."""
    values = ConditionNumber.values

    def missing(self: Any, manipulator: Any, poses: Any) -> Any:
        found = values(self, manipulator, poses)
        return np.where(poses[:, 0] > -0.1, np.nan, found) if isinstance(poses, np.ndarray) else found

    monkeypatch.setattr(ConditionNumber, "values", missing)
    monkeypatch.setattr(cells, "CLEAR", np.inf)
    asked = _asked(design)
    _, expected = node_states(design.manipulator, asked, GRID)
    _, found = GridStates(DesignSpace(spec, helpers=Backwards()), LEG)(design.manipulator, asked, GRID)
    assert len(expected) == 1
    assert found == expected


def test_nobody_is_asked_to_help_with_what_is_soon_done(
    spec: Spec, design: Design, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(grid_parts, "WORTH_SHARING", 60.0)
    helpers = Backwards()
    GridStates(DesignSpace(spec, helpers=helpers), LEG)(design.manipulator, _asked(design), GRID)
    assert not helpers.parts


def test_progress_goes_up_to_all_nodes(spec: Spec, design: Design) -> None:
    told: list[tuple[str, int, int]] = []
    states_of = GridStates(DesignSpace(spec, helpers=Backwards()), LEG)
    states_of(design.manipulator, _asked(design), GRID, lambda *step: told.append(step))
    done = [nodes for _, nodes, _ in told]
    assert done == sorted(done)
    assert told[-1] == ("grid", GRID.nodes, GRID.nodes)


def test_an_evaluation_is_the_same_with_help(spec: Spec, design: Design) -> None:
    machine, helpers = machine_of(design), Backwards()
    shared = GridStates(DesignSpace(spec, helpers=helpers), LEG)
    setting = DesignSpace(spec).setting
    assert repr(evaluate(machine, setting, states_of=shared)) == repr(evaluate(machine, setting))
    assert helpers.parts

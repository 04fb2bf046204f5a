"""A field in slabs: the same numbers from anyone and in any order; what is kept is not made again."""

from __future__ import annotations

import pickle
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from orthospec.measures import Demand
from orthospec.optimise import slabs
from orthospec.optimise.cache import Cache
from orthospec.optimise.slabs import Slab, Slabs, measure_slab
from orthospec.optimise.space import DesignSpace, machine_of
from orthospec.spec import Design, Spec
from orthospec.workspace.cells import grid_states
from orthospec.workspace.evaluate import evaluate
from orthospec.workspace.field import fields, node_states
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
GRID = Grid((0.04,) * 3, (-8,) * 3, (17,) * 3, 3)
MANY = -(-GRID.nodes // 500)


class Backwards:
    """Helpers that hand over the last slab first, and count; Ctrl-C comes after ``stopped`` slabs."""

    def __init__(self, stopped: int | None = None) -> None:
        self.measured: list[Slab] = []
        self._stopped = stopped

    def each(
        self,
        task: Any,
        space: DesignSpace,
        items: Sequence[Slab],
        progress: Any = None,  # noqa: ARG002
    ) -> Iterator[tuple[int, Any]]:
        for number in reversed(range(len(items))):
            if len(self.measured) == self._stopped:
                raise KeyboardInterrupt
            self.measured.append(items[number])
            yield number, task.work(space, items[number], None)


@pytest.fixture(scope="module")
def spec(spec_of: Callable[..., Spec]) -> Spec:
    return spec_of(SPEC)


@pytest.fixture(scope="module")
def design(spec: Spec) -> Design:
    return spec.design({"leg": LEG[0]})


@pytest.fixture(autouse=True)
def small_slabs_worth_sharing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(slabs, "SLAB", 500)
    monkeypatch.setattr(slabs, "WORTH_SHARING", -1.0)


def _states(design: Design, demands: Sequence[Demand], *blocks: Any) -> list[bytes]:
    states, failures = node_states(design.manipulator, demands, GRID, None, *blocks)
    assert not failures
    return [state.tobytes() for state in states]


def test_slabs_from_others_in_any_order_give_the_states_of_the_whole_field(
    spec: Spec, design: Design
) -> None:
    helpers = Backwards()
    shared = Slabs(DesignSpace(spec, helpers=helpers), LEG)
    demands = [*design.demands, design.demands[0].at(design.demands[0].levels[0])]
    assert _states(design, demands, shared) == _states(design, demands)
    assert len(helpers.measured) == MANY - 1
    assert _states(design, [], shared) == _states(design, [])


def test_slabs_from_others_in_any_order_give_the_fields_bit_by_bit(spec: Spec, design: Design) -> None:
    shared = Slabs(DesignSpace(spec, helpers=Backwards()), LEG)
    whole = fields(design.manipulator, design.demands, GRID)
    found = fields(design.manipulator, design.demands, GRID, None, shared)
    assert list(found) == list(whole) == ["axis_x", "axis_y", "axis_z", "transmission", "condition"]
    assert all(found[name].tobytes() == whole[name].tobytes() for name in whole)


def test_nobody_is_asked_to_help_with_what_is_soon_done(
    spec: Spec, design: Design, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(slabs, "WORTH_SHARING", 60.0)
    helpers = Backwards()
    shared = Slabs(DesignSpace(spec, helpers=helpers), LEG)
    assert _states(design, design.demands, shared) == _states(design, design.demands)
    assert not helpers.measured


def test_ctrl_c_loses_no_slab_that_is_complete(spec: Spec, design: Design, tmp_path: Path) -> None:
    before = Cache(tmp_path)
    stopping = DesignSpace(spec, before, Backwards(stopped=3))
    with pytest.raises(KeyboardInterrupt):
        _states(design, design.demands, Slabs(stopping, LEG))
    assert (before.known, before.asked) == (0, MANY)
    after, helpers = Cache(tmp_path), Backwards()
    goes_on = Slabs(DesignSpace(spec, after, helpers), LEG)
    assert _states(design, design.demands, goes_on) == _states(design, design.demands)
    assert (after.known, after.asked) == (4, MANY)
    assert len(helpers.measured) == MANY - 5


def test_of_a_further_measure_only_its_own_values_are_computed(
    spec: Spec, design: Design, tmp_path: Path
) -> None:
    _states(design, design.demands[:1], Slabs(DesignSpace(spec, Cache(tmp_path)), LEG))
    helpers = Backwards()
    both = Slabs(DesignSpace(spec, Cache(tmp_path), helpers), LEG)
    assert _states(design, design.demands, both) == _states(design, design.demands)
    assert {slab.measures for slab in helpers.measured} == {("condition",)}


def test_a_field_too_large_to_keep_is_made_all_the_same(
    spec: Spec, design: Design, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(slabs, "MOST_KEPT", GRID.nodes - 1)
    shared = Slabs(DesignSpace(spec, Cache(tmp_path)), LEG)
    assert _states(design, design.demands, shared) == _states(design, design.demands)
    assert not list(tmp_path.rglob("*.field"))


def test_fields_do_not_fill_the_disk_before_the_end(
    spec: Spec, design: Design, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Cache.trim, "__defaults__", (20_000, ""))
    cache = Cache(tmp_path)
    cache.write("0" * 64, "x" * 50_000)
    space = DesignSpace(spec, cache)
    assert _states(design, design.demands, Slabs(space, LEG)) == _states(design, design.demands)
    assert 0 < sum(path.stat().st_size for path in tmp_path.rglob("*.field")) <= 20_000
    assert cache.read("0" * 64) is not None


def test_the_first_failure_is_the_same_in_any_order(spec: Spec, design: Design) -> None:
    def half_missing(manipulator: Any, demands: Any, grid: Grid, progress: Any) -> Iterator[Any]:
        for block in Slabs(DesignSpace(spec, helpers=Backwards()), LEG)(manipulator, demands, grid, progress):
            block.values["transmission"][::2] = np.nan
            yield block

    _, (failure,) = node_states(design.manipulator, design.demands, GRID, None, half_missing)
    poses = GRID.poses(0, GRID.nodes)
    first = poses[np.argmax(design.manipulator.inverse_kinematics(poses)[1])]
    assert (failure.measure, failure.pose) == ("transmission", tuple(first))


@pytest.mark.parametrize("known", [False, True])
def test_progress_goes_up_to_all_nodes(spec: Spec, design: Design, tmp_path: Path, known: bool) -> None:
    told: list[tuple[str, int, int]] = []
    shared = Slabs(DesignSpace(spec, Cache(tmp_path), Backwards()), LEG)
    if known:
        _states(design, design.demands, shared)
    node_states(design.manipulator, design.demands, GRID, lambda *step: told.append(step), shared)
    done = [nodes for _, nodes, _ in told]
    assert len(done) == MANY
    assert done == sorted(done)
    assert told[-1] == ("grid", GRID.nodes, GRID.nodes)


def test_a_slab_out_of_reach_has_no_values(spec: Spec) -> None:
    far = Grid((0.04,) * 3, (100,) * 3, (5,) * 3, 3)
    block = measure_slab(DesignSpace(spec), Slab(LEG, ("condition",), far, 25, 75))
    assert (block.start, block.reachable.tolist()) == (25, [False] * 50)
    assert block.values["condition"].shape == (0,)


def test_an_evaluation_is_the_same_with_help(spec: Spec, design: Design) -> None:
    machine, space = machine_of(design), DesignSpace(spec, helpers=Backwards())
    shared = partial(grid_states, blocks=Slabs(space, LEG))
    assert repr(evaluate(machine, space.setting, states_of=shared)) == repr(evaluate(machine, space.setting))


def test_a_space_takes_its_folder_to_other_processes_where_there_is_one(spec: Spec, tmp_path: Path) -> None:
    (tmp_path / "here").mkdir()
    (tmp_path / "gone").mkdir()
    here, gone = (
        pickle.dumps(DesignSpace(spec, Cache(tmp_path / name), Backwards())) for name in ("here", "gone")
    )
    (tmp_path / "gone").rmdir()
    there = pickle.loads(here)
    assert there.cache.folder == tmp_path / "here"
    assert there.helpers is None
    assert pickle.loads(gone).cache is None

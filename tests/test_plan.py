"""What a plan says of a run is what the run then does, and nothing is done for it."""

from __future__ import annotations

import re
import tracemalloc
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from orthospec.errors import PluginFault, UsageError
from orthospec.measures.kinematic import VelocityTransmission
from orthospec.optimise import evaluate_spec, remembering, solve
from orthospec.optimise.branch import hunt_branches
from orthospec.optimise.explore import explore
from orthospec.optimise.plan import Timed, plan
from orthospec.optimise.space import DesignSpace
from orthospec.optimise.workers import Here
from orthospec.show import plan_content, show_plan
from orthospec.spec import Spec, load_spec
from orthospec.workspace.cuboid import clusters
from orthospec.workspace.field import BLOCK, State, node_states
from orthospec.workspace.grid import Grid

SPECS = sorted((Path(__file__).parents[1] / "specs").glob("*.yaml"))
SPEC = """\
orthospec: 1
title: A small one
variables:
  leg: {min: 250 mm, max: 500 mm, start: 330 mm}
manipulator: {use: orthoglide, leg_lengths: [leg, leg, leg]}
workspace: {size: [200 mm, 200 mm, 200 mm], divisions: 8}
measures:
  transmission: {use: velocity_transmission, at_least: 0.5, at_most: 2, levels: {at_most: [1.8]}}
  condition: {use: condition_number, at_most: 5}
goals:
  length: {minimise: leg, goal: 300 mm}
optimise: {starts: 5}
proof: {slack: 1e-2, boxes: 20}
"""
FIXED = re.sub(r"(variables|goals):\n.*\n", "", SPEC).replace("leg, leg, leg", "0.33, 0.33, 0.33")
"""The same without variables."""


class _Counting:
    """Workers that count the items of each task."""

    def __init__(self) -> None:
        self.items: Counter[str] = Counter()

    def each(self, task: Any, space: Any, items: Sequence[Any], progress: Any = None) -> Iterator[Any]:
        self.items[task.work.__name__] += len(items)
        yield from Here().each(task, space, items, progress)


SpecOf = Callable[..., Spec]


def text(spec: Spec, width: int = 80, **asked: Any) -> str:
    return show_plan(spec, plan(spec, **asked), width=width, colour=False)


def test_a_search_does_what_was_planned(spec_of: SpecOf) -> None:
    spec, counting = spec_of(SPEC), _Counting()
    planned = plan(spec).searching
    assert planned is not None
    designs, refined, _, solved = hunt_branches(spec, counting).searched
    assert counting.items["start_at"] == designs == planned.starts == 5
    assert refined == planned.refined == 4
    assert 1 <= solved <= planned.solved == 3


@pytest.mark.parametrize(
    ("old", "new", "cuboids"),
    [
        ("", "", 5),
        ("  condition: {use: condition_number, at_most: 5}", "", 3),
        ("divisions: 4", "divisions: 4, together: false", 5),
    ],
)
def test_the_cuboids_that_are_proved_are_counted(spec_of: SpecOf, old: str, new: str, cuboids: int) -> None:
    spec, counting = spec_of(FIXED.replace("divisions: 8", "divisions: 4").replace(old, new)), _Counting()
    assert plan(spec).proofs == cuboids
    assert plan(replace(spec, proof=None)).proofs == 0
    solve(spec, workers=counting)
    assert counting.items["prove_cuboid"] == cuboids


@pytest.mark.parametrize("bounds", [1, 5])
def test_the_memory_of_a_grid_is_what_its_states_and_cubes_take(
    spec_of: SpecOf, bounds: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With small blocks of poses, so that these do not count."""
    monkeypatch.setattr("orthospec.workspace.field.BLOCK", 4096)
    levels = f", levels: {{at_most: [{', '.join(f'1.{k}' for k in range(1, bounds))}]}}" if bounds > 1 else ""
    one = re.sub(r"  condition: .*\n", "", FIXED).replace(", levels: {at_most: [1.8]}", levels)
    planned = plan(spec_of(one, "workspace.divisions=24"))
    (demand,) = planned.design.demands
    asked = [demand, *map(demand.at, demand.levels)]
    assert len(asked) == bounds
    tracemalloc.start()
    states, _ = node_states(planned.design.manipulator, asked, planned.grid)
    clusters(states[0] == State.MEETS)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert planned.memory == pytest.approx(peak, rel=0.25)


def test_the_grid_is_that_of_the_design(spec_of: SpecOf) -> None:
    spec = spec_of(FIXED)
    joint = evaluate_spec(spec).finding.evaluation.joint
    assert joint is not None
    assert sum(joint.nodes.values()) == plan(spec).grid.nodes


def test_the_time_is_that_of_poses_all_over_the_grid(
    spec_of: SpecOf, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen = []

    def values(self: Any, manipulator: Any, poses: Any) -> Any:  # noqa: ARG001
        seen.append(poses)
        return np.ones((len(poses), 2))

    monkeypatch.setattr(VelocityTransmission, "values", values)
    spec = spec_of(SPEC, "workspace.divisions=20")
    planned = plan(spec)
    assert planned.timed.poses == BLOCK < planned.grid.nodes
    # The Orthoglide's reach extends to its legs' length from the origin along each axis.
    for edge in (seen[0].min(axis=0), -seen[0].max(axis=0)):
        assert (edge < -0.2).all()
    assert Timed(100, 0.5).of(Grid((1.0,) * 3, (0,) * 3, (10, 10, 10), 3)) == 5.0


def test_what_is_kept_is_told_and_nothing_is_kept_for_it(spec_of: SpecOf, tmp_path: Path) -> None:
    folder = tmp_path / "kept"
    spec = spec_of(SPEC, "proof=false")
    assert (plan(spec, folder).kept, plan(spec, folder).steps) == (0, 5)
    assert not folder.exists()
    with remembering(Here(), folder) as workers:
        explore(DesignSpace(spec), workers)
    assert plan(spec, folder).kept == 5
    assert "5 of the 5 starts were measured before" in text(spec, cache=folder)
    assert plan(spec_of(SPEC, "proof=false", "optimise.starts=8"), folder).kept == 5
    alone = spec_of(FIXED, "proof=false")
    assert "was not measured before" in text(alone, cache=folder)
    with remembering(Here(), folder) as workers:
        evaluate_spec(alone, workers=workers)
    assert "The design was measured before" in text(alone, cache=folder)


def _catalogue(spec_of: SpecOf, choices: int) -> Spec:
    listed = ", ".join(f"{300 + k} mm" for k in range(choices))
    leg = f"variables.leg={{choices: [{listed}]}}"
    return spec_of(SPEC, leg, "variables.other={choices: [1, 2, 3, 4]}", "optimise.starts=2")


@pytest.mark.parametrize(
    ("choices", "said"),
    [
        (3, "12 combinations of choices, all searched"),
        (20, "the best 64 of 80 combinations of choices, screened on the coarse grid"),
    ],
)
def test_combinations_of_catalogues_are_counted(spec_of: SpecOf, choices: int, said: str) -> None:
    spec = _catalogue(spec_of, choices)
    printed = text(spec)
    assert said in " ".join(printed.split())
    assert f"leg    one of {choices}: 300" in printed
    assert plan(spec).steps == (12 if choices == 3 else 0)


def test_too_many_combinations_are_refused_as_a_run_does(spec_of: SpecOf) -> None:
    with pytest.raises(UsageError, match="4400 combinations"):
        plan(_catalogue(spec_of, 1100))


@pytest.mark.parametrize(("asked", "designs"), [(21, 21), (20, 15), (2, 3)])
def test_a_pareto_set_of_three_goals_has_the_points_of_a_triangle(
    spec_of: SpecOf, asked: int, designs: int
) -> None:
    more = "  even: {minimise: worst(condition), goal: 2}\n  near: {minimise: stroke, goal: 200 mm}\n"
    spec = spec_of(SPEC.replace("optimise:", f"{more}optimise:") + f"pareto: {{points: {asked}}}\n")
    assert plan(spec).front == designs
    assert f"pareto    up to {designs} designs" in text(spec)


def test_a_measure_that_fails_is_told_before_the_run(
    spec_of: SpecOf, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(VelocityTransmission, "values", lambda *_: 1 / 0)
    with pytest.raises(PluginFault, match="ZeroDivisionError"):
        plan(spec_of(SPEC))


def test_the_plan_in_words(spec_of: SpecOf) -> None:
    printed = re.sub(
        r"(less than|about) \d+ s,",
        "TIME,",
        text(spec_of(SPEC, "sweep={variable: leg, from: 0.3, to: 0.5, points: 3}")),
    )
    assert (
        printed
        == """\
A small one
  Nothing was run. This is what a run would do.

Design variables
  leg  250 ... 500 mm, from 330 mm

Search
  goals   length
  starts  5 designs on a coarse grid of 29 x 29 x 29 = 24389 nodes
  then    4 of them refined, up to 3 places solved to the end

Grid of the design found
  nodes   29 x 29 x 29 = 24389, over the machine's reach at the start
  step    25 x 25 x 25 mm
  memory  about 1 MB for its nodes
  time    TIME, by 16384 of its poses measured here

Measured and proved
  measures  transmission: velocity_transmission, at least 0.5 and at most 2
            condition: condition_number, at most 5
  levels    transmission: at most 1.8
  proof     within 1 %, over up to 5 cuboids, by up to 20 boxes each time
  limits    each thing that binds, with its price by solving again to either
            side
  sweep     3 designs, leg = 300 ... 500 mm, each on a grid of its own: less
            than 1 s

Plugins
  orthospec 0.1.0  orthoglide, condition_number, velocity_transmission

Kept from earlier runs
  Nothing: none of the starts was measured before.
"""
    )


@pytest.mark.parametrize("path", SPECS, ids=lambda path: path.stem)
def test_each_shipped_spec_has_a_plan_that_fits_a_terminal(path: Path) -> None:
    spec = load_spec(path, ["workspace.divisions=5"])
    planned = plan(spec)
    lines = show_plan(spec, planned, width=80, colour=False).splitlines()
    assert max(map(len, lines)) <= 80
    content = plan_content(spec, planned)
    assert content["grid"]["nodes"] == np.prod(content["grid"]["shape"])
    assert content["search"] is None or content["search"]["branches"] >= 1

"""What-if: the grid's scales under moved bounds, against the moved spec evaluated anew."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from orthospec.cli import app
from orthospec.errors import UsageError
from orthospec.optimise import evaluate_spec, remembering, slabs
from orthospec.optimise.what_if import know, read_moves
from orthospec.optimise.workers import Here
from orthospec.spec import load_spec
from orthospec.workspace import field

SPECS = Path(__file__).parents[1] / "specs"
AT = {"base": 1.5, "third": 1.5}


@pytest.fixture(scope="module")
def known():
    return know(load_spec(SPECS / "orthoglide-1x1x0.8.yaml", ["workspace.divisions=20"]), AT)


@pytest.mark.parametrize("moves", [("at_most=2.2",), ("at_least=0.6", "at_most=2.5"), ("at_most=1.2",)])
def test_a_moved_bound_gives_the_grid_scale_of_the_moved_spec(known, moves):
    texts = [f"transmission.{move}" for move in moves]
    answer = known.answer(read_moves(known.spec, AT, texts))
    settings = ["workspace.divisions=20", *(f"measures.{text}" for text in texts)]
    moved = evaluate_spec(load_spec(SPECS / "orthoglide-1x1x0.8.yaml", settings), AT).finding.evaluation
    assert answer.joint.after == pytest.approx(moved.joint.grid_scale)
    assert answer.measures["transmission"] == answer.joint


def test_several_questions_are_put_to_one_field(known):
    answers = [known.answer(read_moves(known.spec, AT, [f"transmission.at_most={at}"])) for at in (1.5, 2, 3)]
    assert len({answer.joint.before for answer in answers}) == 1
    after = [answer.joint.after for answer in answers]
    assert after == sorted(after)
    assert after[1] == answers[0].joint.before


def test_a_bound_that_the_spec_does_not_have_may_be_asked_for(known):
    settings = ["workspace.divisions=20", "measures.transmission.at_least="]
    spec = load_spec(SPECS / "orthoglide-1x1x0.8.yaml", settings)
    (move,) = read_moves(spec, AT, ["transmission.at_least=0.5"])
    assert move.before is None
    whole = known.answer(read_moves(known.spec, AT, ["transmission.at_least=0.5"]))
    answer = know(spec, AT).answer([move])
    assert answer.joint.after == whole.joint.before
    assert answer.joint.before >= answer.joint.after


def test_a_bound_that_no_machine_meets_is_refused_as_in_a_spec():
    spec = load_spec(SPECS / "orthoglide-1x1x0.8.yaml", ["measures.even={use: condition_number, at_most: 3}"])
    said = "--what-if even.at_most=0.5: condition_number is never below 1: no machine meets at_most 0.5"
    with pytest.raises(UsageError, match=re.escape(said)):
        read_moves(spec, AT, ["even.at_most=0.5"])


def test_a_measure_without_bounds_holds_wherever_it_is_in_reach():
    path, grid = SPECS / "orthoglide-1x1x0.8.yaml", "workspace.divisions=10"
    spec = load_spec(
        path, [grid, "measures.transmission={use: velocity_transmission, levels: {at_most: [2]}}"]
    )
    answer = know(spec, AT).answer(read_moves(spec, AT, ["transmission.at_most=2"]))
    reach = evaluate_spec(load_spec(path, [grid, "measures={}"]), AT).finding.evaluation.joint
    assert answer.joint.before == pytest.approx(reach.grid_scale)


def test_a_node_where_a_measure_failed_is_met_by_no_bound(known):
    def failed(block):
        values = block.values["transmission"].copy()
        if len(values):
            values[:, 0] = np.nan
        return replace(block, values={"transmission": values})

    (demand,) = known.design.demands
    most_alone = replace(known.design, demands=(replace(demand, bounds={"at_most": 2.0}),))
    nowhere = replace(known, design=most_alone, blocks=tuple(map(failed, known.blocks)), scales={})
    answer = nowhere.answer(read_moves(known.spec, AT, ["transmission.at_most=2.2"]))
    assert (answer.joint.before, answer.joint.after) == (0.0, 0.0)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("speed.at_most=2", "the measures are transmission"),
        ("transmission.at_best=2", "it knows at_least and at_most"),
        ("transmission.at_most", "MEASURE.SIDE=VALUE was expected"),
        ("transmission.at_most=2 mm", "--what-if transmission.at_most=2 mm: "),
    ],
)
def test_what_is_no_move_is_told(known, text, said):
    with pytest.raises(UsageError, match=said):
        read_moves(known.spec, AT, [text])


def test_the_command_prints_both_scales_and_json():
    command = ["evaluate", str(SPECS / "orthoglide-1x1x0.8.yaml"), "--set", "workspace.divisions=20"]
    command += ["--at", "base=1.5,third=1.5", "--what-if", "transmission.at_most=2.2"]
    printed = CliRunner().invoke(app, command)
    assert printed.exit_code == 0
    assert "transmission at most 2.2 instead of 2" in printed.stdout
    told = json.loads(CliRunner().invoke(app, [*command, "--json"]).stdout)
    assert told["joint"]["after"] > told["joint"]["before"] > 0.9


@pytest.fixture
def measured(monkeypatch):
    """How many poses measures were asked for on grids."""
    counts, measure = [], field.measured
    monkeypatch.setattr(
        field,
        "measured",
        lambda demand, machine, poses: counts.append(len(poses)) or measure(demand, machine, poses),
    )
    return counts


def test_a_field_that_is_kept_gives_the_same_answer_and_is_not_computed(tmp_path, measured):
    command = ["evaluate", str(SPECS / "orthoglide-1x1x0.8.yaml"), "--set", "workspace.divisions=20"]
    kept, asked = ["--cache", str(tmp_path / "kept")], ["--what-if", "transmission.at_most=2.2", "--json"]
    CliRunner().invoke(app, [*command, *kept, *asked])
    assert sum(measured) > 100_000
    measured.clear()
    known = CliRunner().invoke(app, [*command, *kept, *asked])
    assert not measured
    anew = CliRunner().invoke(app, [*command, "--cache", str(tmp_path / "other"), *asked])
    assert sum(measured) > 100_000
    assert known.stdout == anew.stdout
    measured.clear()
    again = ["--set", "measures.transmission.at_most=1.9", "--what-if", "transmission.at_least=0.6", "--json"]
    other = CliRunner().invoke(app, [*command, "--cache", str(tmp_path / "other"), *again])
    assert json.loads(other.stdout)["joint"]["before"] > 0
    assert not measured


def test_of_a_field_kept_in_part_or_damaged_only_the_rest_is_computed(tmp_path, measured, monkeypatch):
    monkeypatch.setattr(slabs, "SLAB", 10_000)
    spec = load_spec(SPECS / "orthoglide-1x1x0.8.yaml", ["workspace.divisions=10"])
    moves = read_moves(spec, AT, ["transmission.at_most=2.2"])

    def told():
        measured.clear()
        with remembering(Here(), tmp_path) as workers:
            return know(spec, AT, workers=workers).answer(moves), sum(measured)

    answer, whole = told()
    files = sorted(path for path in tmp_path.rglob("*.field"))
    assert len(files) > 3
    assert told() == (answer, 0)
    files[0].unlink()
    files[1].write_bytes(files[1].read_bytes()[:-1])
    again, part = told()
    assert again == answer
    assert 0 < part < whole
    assert told() == (answer, 0)


def test_the_command_writes_no_result(tmp_path):
    command = ["evaluate", str(SPECS / "orthoglide-1x1x0.8.yaml"), "--what-if", "transmission.at_most=2.2"]
    assert CliRunner().invoke(app, [*command, "-o", str(tmp_path / "out")]).exit_code == 2
    assert not (tmp_path / "out").exists()

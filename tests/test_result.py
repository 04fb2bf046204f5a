"""The result file: what it says, that it says it exactly, and how it comes to its folder."""

from __future__ import annotations

import dataclasses
import json
import math
import os
import signal
import zipfile
from pathlib import Path

import numpy as np
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from orthospec.errors import SpecError, UsageError
from orthospec.manipulators.orthoglide import Orthoglide
from orthospec.optimise import evaluate_spec
from orthospec.result import (
    Attainment,
    Finding,
    GoalOutcome,
    Limit,
    Note,
    PluginError,
    Search,
    compose,
    read_result,
    write_result,
)
from orthospec.show import show
from orthospec.spec import Spec, load_spec
from orthospec.spec.strict_yaml import LARGEST, parse
from orthospec.spec.writing import dump

SPEC = """\
orthospec: 1
title: A small one
variables:
  leg: {min: 250 mm, max: 500 mm, start: 310 mm}
manipulator:
  use: orthoglide
  leg_lengths: [leg, leg, leg]
workspace:
  size: [200 mm, 200 mm, 200 mm]
  divisions: 10
measures:
  transmission: {use: velocity_transmission, at_least: 0.5, at_most: 2, levels: {at_most: [1.5]}}
goals:
  legs: {minimise: leg, goal: 300 mm}
poses: {Q0: [0, 0, 0], far: [9, 9, 9]}
"""


@pytest.fixture(scope="module")
def spec(tmp_path_factory: pytest.TempPathFactory) -> Spec:
    path = tmp_path_factory.mktemp("spec") / "small.yaml"
    path.write_text(SPEC)
    return load_spec(path)


@pytest.fixture(scope="module")
def finding(spec: Spec) -> Finding:
    return evaluate_spec(spec).finding


def _full(spec: Spec, finding: Finding) -> Finding:
    return dataclasses.replace(
        finding,
        status="compromise",
        attainment=Attainment(0.01, {"legs": GoalOutcome(0.31, 0.3, 1.0, False)}),
        limits=(
            Limit("variable", "leg", "at_most", (), None, None),
            Limit("bound", "transmission", "at_least", ((0.1, 0.0, -0.0),), 0.0, 0.00265),
            Limit("bound", "transmission", "at_most", ((0.1, 0.1, 0.1),), 0.001, 0.00237),
        ),
        search=Search(8, 4, 3, 3, 12, None),
        sweep=(finding,),
        errors=(PluginError("condition", f"{spec.document.file}:12:3", "raised ValueError: no"),),
        notes=(Note("sweep", f"{spec.document.file}:30:1", "no machine"),),
    )


def test_keys_stand_in_the_order_of_the_contract(spec: Spec, finding: Finding) -> None:
    content = compose(spec, _full(spec, finding))
    assert list(content) == [
        "orthospec",
        "title",
        "status",
        "attainment",
        "variables",
        "manipulator",
        "indices",
        "joints",
        "workspace",
        "limits",
        "search",
        "sweep",
        "errors",
        "notes",
        "provenance",
    ]
    joint = ["scale", "grid_scale", "ties", "min", "max", "nodes"]
    transmission = content["workspace"]["measures"]["transmission"]
    assert list(content["workspace"]["joint"]) == joint
    assert list(transmission) == [*joint, "lowest", "highest", "levels", "poses"]
    assert list(transmission["levels"][0]) == ["at_most", *joint]
    assert transmission["poses"] == {"Q0": [1.0, 1.0], "far": None}
    assert list(content["sweep"][0]) == ["variables", "manipulator", "indices", "joints", "workspace"]


def test_what_has_no_content_is_left_out(spec: Spec, finding: Finding) -> None:
    content = compose(spec, dataclasses.replace(finding, attainment=None))
    assert not {"attainment", "limits", "search", "sweep", "errors", "notes", "pareto"} & set(content)
    assert set(content["manipulator"]) == {"use", "leg_lengths", "branch", "gravity"}
    assert set(content["provenance"]) == {"orthospec", "spec_sha256"}


def test_each_limit_has_all_its_keys_in_the_order_found_and_minus_zero_is_zero(
    spec: Spec, finding: Finding
) -> None:
    limits = compose(spec, _full(spec, finding))["limits"]
    assert [(limit["kind"], limit["gain"]) for limit in limits] == [
        ("variable", None),
        ("bound", 0.0),
        ("bound", 0.001),
    ]
    assert {tuple(limit) for limit in limits} == {("kind", "name", "side", "at", "gain", "cost")}
    assert math.copysign(1.0, limits[1]["at"][0][2]) == 1.0


def test_a_place_names_the_file_and_not_its_folder(spec: Spec, finding: Finding) -> None:
    (error,) = compose(spec, _full(spec, finding))["errors"]
    assert error == {"name": "condition", "place": "small.yaml:12:3", "message": "raised ValueError: no"}
    (note,) = compose(spec, _full(spec, finding))["notes"]
    assert note == {"name": "sweep", "place": "small.yaml:30:1", "message": "no machine"}


def test_numbers_that_are_not_finite_become_null(spec: Spec, finding: Finding) -> None:
    goals = {"legs": GoalOutcome(math.nan, 0.3, 1.0, False)}
    lost = dataclasses.replace(finding.evaluation, indices={"stroke": math.inf})
    content = compose(
        spec, dataclasses.replace(finding, evaluation=lost, attainment=Attainment(math.nan, goals))
    )
    assert content["indices"] == {"stroke": None}
    assert content["attainment"]["factor"] is None
    assert content["attainment"]["goals"]["legs"]["value"] is None


def test_each_measure_has_its_own_place_where_they_do_not_stand_together(tmp_path: Path) -> None:
    path = tmp_path / "apart.yaml"
    path.write_text(SPEC)
    apart = load_spec(path, ["workspace.together=false"])
    content = compose(apart, evaluate_spec(apart).finding)
    assert set(content["workspace"]) == {"measures"}
    assert set(content["workspace"]["measures"]["transmission"]["prescribed"]) == {"min", "max", "holds"}


def test_the_same_spec_gives_the_same_bytes(spec: Spec, finding: Finding) -> None:
    again = evaluate_spec(load_spec(Path(spec.document.file))).finding
    assert dump(compose(spec, finding)) == dump(compose(spec, again))


def test_no_time_or_folder_is_in_the_result(spec: Spec, finding: Finding) -> None:
    text = dump(compose(spec, _full(spec, finding)))
    assert str(Path(spec.document.file).parent) not in text
    assert os.uname().nodename not in text


NAMES = st.text(min_size=1, max_size=8).filter(lambda text: text.isprintable() and text != "<<")
PLAIN = st.recursive(
    st.floats(allow_nan=False, allow_infinity=False) | st.integers() | st.booleans() | st.none() | NAMES,
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(NAMES, inner, max_size=4),
    max_leaves=20,
)


@given(PLAIN)
def test_a_file_reads_back_exactly_by_two_readers(value: object) -> None:
    text = dump({"content": value})
    assert parse(text, "x").data == {"content": value}
    assert yaml.safe_load(text) == {"content": value}


@pytest.mark.parametrize("value", [1e-05, 1e16, 5e-324, 0.1 + 0.2, -1.7976931348623157e308])
def test_floats_keep_every_bit(value: float) -> None:
    text = dump({"value": value})
    assert yaml.safe_load(text)["value"] == parse(text, "x").data["value"] == value


def test_a_folder_is_written_and_read_back(spec: Spec, finding: Finding, tmp_path: Path) -> None:
    content = compose(spec, _full(spec, finding))
    folder = tmp_path / "runs" / "small"
    write_result(folder, spec, content, {"seconds": {"evaluate": 1.5}}, {"scale": np.arange(3.0)})
    assert sorted(path.name for path in folder.iterdir()) == [
        "fields.npz",
        "result.yaml",
        "run.log.json",
        "spec.yaml",
    ]
    assert [path.name for path in folder.parent.iterdir()] == ["small"]
    assert read_result(folder) == read_result(folder / "result.yaml") == content
    assert load_spec(folder / "spec.yaml").sha256() == content["provenance"]["spec_sha256"]
    assert json.loads((folder / "run.log.json").read_text()) == {"seconds": {"evaluate": 1.5}}
    assert np.load(folder / "fields.npz")["scale"].tolist() == [0.0, 1.0, 2.0]


def test_fields_stand_under_any_name_and_without_a_date(spec: Spec, finding: Finding, tmp_path: Path) -> None:
    fields = {"file": np.arange(3.0), "allow_pickle": np.full((2, 2), np.nan)}
    write_result(tmp_path / "any", spec, compose(spec, finding), {}, fields)
    with np.load(tmp_path / "any" / "fields.npz") as kept:
        assert kept.files == list(fields)
        for name, values in fields.items():
            assert np.array_equal(kept[name], values, equal_nan=True)
    with zipfile.ZipFile(tmp_path / "any" / "fields.npz") as archive:
        assert {one.date_time for one in archive.infolist()} == {(1980, 1, 1, 0, 0, 0)}


def test_a_long_sweep_is_read_back_though_no_spec_is_so_long(
    spec: Spec, finding: Finding, tmp_path: Path
) -> None:
    content = compose(spec, dataclasses.replace(finding, sweep=(finding,) * 600))
    write_result(tmp_path / "long", spec, content, {})
    assert (tmp_path / "long" / "result.yaml").stat().st_size > LARGEST
    assert read_result(tmp_path / "long") == content


def test_a_result_is_replaced_and_what_others_put_there_is_kept(
    spec: Spec, finding: Finding, tmp_path: Path
) -> None:
    write_result(tmp_path / "out", spec, compose(spec, _full(spec, finding)), {})
    (tmp_path / "out" / "notes.txt").write_text("mine")
    (tmp_path / "out" / "pictures").mkdir()
    write_result(tmp_path / "out", spec, compose(spec, finding), {})
    assert read_result(tmp_path / "out")["status"] == "evaluated"
    assert (tmp_path / "out" / "notes.txt").read_text() == "mine"
    assert (tmp_path / "out" / "pictures").is_dir()


def test_other_folders_and_files_are_refused(spec: Spec, finding: Finding, tmp_path: Path) -> None:
    (tmp_path / "mine.txt").write_text("")
    with pytest.raises(UsageError, match="holds other files and no result"):
        write_result(tmp_path, spec, compose(spec, finding), {})
    with pytest.raises(UsageError, match="there is a file of this name"):
        write_result(tmp_path / "mine.txt", spec, compose(spec, finding), {})
    (tmp_path / "empty").mkdir()
    write_result(tmp_path / "empty", spec, compose(spec, finding), {})
    assert read_result(tmp_path / "empty")["title"] == "A small one"


def test_a_fault_on_the_way_leaves_the_old_result(
    spec: Spec, finding: Finding, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "out"
    write_result(folder, spec, compose(spec, finding), {})
    before = (folder / "result.yaml").read_bytes()
    with pytest.raises(TypeError):
        write_result(folder, spec, compose(spec, _full(spec, finding)), {"not json": object()})

    rename = Path.rename

    def failing(self: Path, target: Path) -> Path:
        if self.name == "new":
            raise OSError(28, "No space left on device")
        return rename(self, target)

    monkeypatch.setattr(Path, "rename", failing)
    with pytest.raises(UsageError, match="cannot be written: no space left"):
        write_result(folder, spec, compose(spec, _full(spec, finding)), {})
    assert (folder / "result.yaml").read_bytes() == before
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


def test_what_stops_it_between_the_two_renames_leaves_the_old_result(
    spec: Spec, finding: Finding, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "out"
    write_result(folder, spec, compose(spec, finding), {})
    rename = Path.rename

    def stopped(self: Path, target: Path) -> Path:
        rename(self, target)
        raise KeyboardInterrupt

    monkeypatch.setattr(Path, "rename", stopped)
    with pytest.raises(KeyboardInterrupt):
        write_result(folder, spec, compose(spec, _full(spec, finding)), {})
    assert read_result(folder) == compose(spec, finding)
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


@pytest.mark.usefixtures("hears_ctrl_c")
def test_ctrl_c_between_the_two_renames_waits_until_both_are_done(
    spec: Spec, finding: Finding, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder, fresh = tmp_path / "out", compose(spec, _full(spec, finding))
    write_result(folder, spec, compose(spec, finding), {})
    rename = Path.rename

    def interrupted(self: Path, target: Path) -> Path:
        moved = rename(self, target)
        signal.raise_signal(signal.SIGINT)
        return moved

    monkeypatch.setattr(Path, "rename", interrupted)
    with pytest.raises(KeyboardInterrupt):
        write_result(folder, spec, fresh, {})
    assert read_result(folder) == fresh
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (None, "no such file or folder"),
        (SPEC, "this is a spec, not a result"),
        ("a: 1\n", "not a result; a result is a folder with result.yaml in it"),
        ("hello\n", "not a result"),
    ],
)
def test_what_is_no_result_is_named(text: str | None, said: str, tmp_path: Path) -> None:
    path = tmp_path / "x.yaml"
    if text is not None:
        path.write_text(text)
    with pytest.raises(UsageError, match=said):
        read_result(path)


def test_a_folder_without_a_result_is_named(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"no result\.yaml in this folder"):
        read_result(tmp_path)


def test_mistakes_in_a_result_have_places(spec: Spec, finding: Finding, tmp_path: Path) -> None:
    path = tmp_path / "result.yaml"
    text = dump(compose(spec, finding)).replace("status: evaluated", "status: fine")
    path.write_text(text.replace("holds: true", "holds: 3").replace("holds: false", "holds: 3"))
    with pytest.raises(SpecError) as caught:
        read_result(path)
    said = [str(mistake) for mistake in caught.value.mistakes]
    assert len(said) == 2
    assert said[0].startswith(f"{path}:3:9: ")
    assert "'attained', 'compromise'" in said[0]
    assert said[1].endswith("true or false was expected, 3 given")


def test_an_index_that_is_not_known_is_left_out_everywhere(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    known = Orthoglide.indices
    monkeypatch.setattr(
        Orthoglide,
        "indices",
        lambda self, ranges: {"leg_length_total": known(self, ranges)["leg_length_total"]},
    )
    path = tmp_path / "spec.yaml"
    path.write_text(SPEC + "sweep: {variable: leg, from: 300 mm, to: 320 mm, points: 2}\n")
    spec = load_spec(path, ["workspace.divisions=4"])
    content = compose(spec, evaluate_spec(spec).finding)
    assert list(content["indices"]) == ["leg_length_total"]
    assert [list(point["indices"]) for point in content["sweep"]] == [["leg_length_total"]] * 2
    text = show(content, width=80, colour=False, spec=spec)
    assert "leg_length_total" in text
    assert "stroke" not in text

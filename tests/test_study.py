"""Python in a few lines: run, evaluate, prove, look, save and open again."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import orthospec
from orthospec.errors import UsageError
from orthospec.report.subject import Subject
from orthospec.spec import Spec
from orthospec.study import Study, evaluate, open_study, run

SPEC = """
orthospec: 1
title: Short <legs>
variables: {leg: {min: 250 mm, max: 500 mm, start: 400 mm}}
manipulator: {use: orthoglide, leg_lengths: [leg, leg, leg]}
workspace: {size: [200 mm, 200 mm, 200 mm], divisions: 6}
measures: {transmission: {use: velocity_transmission, at_least: 0.5, at_most: 2}}
goals: {leg_length: {minimise: leg, goal: 300 mm}}
optimise: {starts: 1}
"""


@pytest.fixture(scope="module")
def spec(spec_of: Callable[..., Spec]) -> Spec:
    return spec_of(SPEC)


@pytest.fixture(scope="module")
def study(spec: Spec) -> Study:
    return run(spec)


def test_a_run_is_a_study_with_named_results(study: Study) -> None:
    assert study.status == "compromise"
    assert study.variables["leg"] == pytest.approx(0.3105828541, abs=1e-9)
    assert study.result.workspace.measures["transmission"].highest.value == pytest.approx(2)  # type: ignore[union-attr]
    assert study.manipulator.leg_lengths[0] == study.variables["leg"]  # type: ignore[attr-defined]
    assert study.outcome is not None


def test_an_evaluation_takes_values_and_may_be_proved(spec: Spec) -> None:
    plain = evaluate(spec, {"leg": 0.35})
    assert plain.variables == {"leg": 0.35}
    assert plain.result.workspace.prescribed.proof is None  # type: ignore[union-attr]
    proved = evaluate(spec, {"leg": 0.35}, prove=True)
    assert proved.result.workspace.prescribed.proof.verdict == "proved"  # type: ignore[union-attr]
    with pytest.raises(UsageError, match="arm: no variable of the spec; these are leg"):
        evaluate(spec, {"arm": 1.0})


def test_progress_is_told_where_it_is_asked_for(spec: Spec) -> None:
    told: list[tuple[str, int, int]] = []
    evaluate(spec, progress=lambda *what: told.append(what))
    assert any(done == whole for _, done, whole in told)


def test_a_saved_study_is_opened_again_the_same(study: Study, tmp_path: Path) -> None:
    folder = study.save(tmp_path / "result")
    assert {path.name for path in folder.iterdir()} == {
        "preview.html",
        "report.html",
        "result.yaml",
        "run.log.json",
        "spec.yaml",
    }
    again = open_study(folder)
    assert again.content == study.content
    assert again.report() == study.report() == (folder / "report.html").read_text()
    assert again.outcome is None
    with pytest.raises(UsageError, match="without its spec"):
        Study(study.content, None).save(tmp_path / "other")


def test_drawings_are_matplotlibs_with_their_numbers(study: Study) -> None:
    drawings = study.drawings()
    assert {"machine-top", "limits", "slice-transmission-at-most-xy", "convergence-lambda"} <= drawings.keys()
    assert drawings["limits"].figure.axes
    limits = drawings["limits"].data
    assert limits["gain of lambda by 1 % looser"][0] == study.result.limits[0].gain


def test_a_notebook_shows_the_status_and_tables_with_text_as_text(study: Study) -> None:
    shown = study._repr_html_()
    assert "Short &lt;legs&gt;" in shown
    assert "Best compromise" in shown
    assert "310.583 mm" in shown
    assert str(study).startswith("Short <legs>\n")


def test_the_command_line_writes_what_a_study_saves(study: Study, tmp_path: Path) -> None:
    from typer.testing import CliRunner

    from orthospec.cli import app

    path = tmp_path / "spec.yaml"
    path.write_text(SPEC)
    ran = CliRunner().invoke(app, ["run", str(path), "-o", str(tmp_path / "cli"), "--set", "proof=false"])
    assert ran.exit_code == 0, ran.stdout
    study.save(tmp_path / "python")
    for name in ("result.yaml", "report.html", "preview.html"):
        assert (tmp_path / "cli" / name).read_bytes() == (tmp_path / "python" / name).read_bytes(), name


def test_without_a_machine_it_says_so(study: Study) -> None:
    bare: Any = Study(study.content, None)
    assert Subject(bare).design is None
    with pytest.raises(UsageError, match="its spec or a plugin of it is not at hand"):
        _ = bare.manipulator


def test_the_names_are_the_packages_own() -> None:
    assert orthospec.run is run
    assert orthospec.open_study is open_study
    assert set(orthospec.__all__) >= {"Study", "run", "evaluate", "open_study", "load_spec"}

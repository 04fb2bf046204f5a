"""The commands: what they print where, their exit codes, and how little `check` imports."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest
from typer.testing import CliRunner

import orthospec.cli
import orthospec.optimise
import orthospec.result.files
from orthospec import registry
from orthospec.errors import PluginFault, UsageError
from orthospec.measures import Measure
from orthospec.optimise import Outcome, evaluate_spec
from orthospec.result import PluginError, Search, read_result
from orthospec.spec import load_spec

SPEC = """\
orthospec: 1
title: A small one
variables:
  leg: {min: 250 mm, max: 500 mm, start: 330 mm}
manipulator: {use: orthoglide, leg_lengths: [leg, leg, leg]}
workspace: {size: [200 mm, 200 mm, 200 mm], divisions: 8}
measures:
  transmission: {use: velocity_transmission, at_least: 0.5, at_most: 2}
goals:
  length: {minimise: leg, goal: 300 mm}
optimise: {starts: 1}
"""

runner = CliRunner()


@pytest.fixture
def spec(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "small.yaml"
    path.write_text(SPEC)
    return path


@pytest.fixture(autouse=True)
def quick_pages(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pages have tests of their own, and take a second each."""
    for page in ("report.report", "preview.preview", "study.study.report", "study.study.preview"):
        monkeypatch.setattr(f"orthospec.{page}", lambda one, _=None: f"<h1>{one.result.status}</h1>\n")


def _orthospec(*arguments: str, code: int = 0, text: str | None = None) -> Any:
    result = runner.invoke(orthospec.cli.app, list(arguments), input=text)
    assert result.exit_code == code, result.stdout + result.stderr
    return result


def _solving(monkeypatch: pytest.MonkeyPatch, **changes: Any) -> None:
    """Let `solve` give the start, with these fields changed: statuses without the work."""

    def solve(problem: Any, *, progress: Any, workers: Any) -> Outcome:  # noqa: ARG001
        progress("grid", 1, 2)
        outcome = evaluate_spec(problem)
        interrupted = changes.get("status") == "unfinished"
        return Outcome(replace(outcome.finding, **changes), {"seconds": {}}, interrupted)

    monkeypatch.setattr("orthospec.study.study.solve", solve)


def test_run_finds_the_legs_of_the_200_mm_cube(spec: Path) -> None:
    result = _orthospec("run", "small.yaml")
    assert "  leg  310.583 mm  within 250 ... 500 mm" in result.stdout.splitlines()
    assert result.stdout.endswith("\nWritten to runs/small\n")
    content = read_result(spec.parent / "runs" / "small")
    assert content["status"] == "compromise"
    assert content["variables"]["leg"] == pytest.approx(0.3105828541, rel=1e-6)
    shown = _orthospec("show", "runs/small").stdout
    assert result.stdout.removesuffix("\nWritten to runs/small\n") == shown
    log = json.loads((spec.parent / "runs" / "small" / "run.log.json").read_text())
    assert log["seconds"]["optimise"] > 0


@pytest.mark.parametrize(
    ("status", "code"),
    [("attained", 0), ("compromise", 0), ("infeasible", 3), ("unfinished", 4), ("failed", 5)],
)
def test_each_status_has_its_exit_code_and_leaves_a_result(
    spec: Path, monkeypatch: pytest.MonkeyPatch, status: str, code: int
) -> None:
    errors = (PluginError("bad", None, "raised"),) if status == "failed" else ()
    _solving(monkeypatch, status=status, errors=errors, search=Search(8, 4, 3, 3, 7, None))
    _orthospec("run", spec.name, "-o", "out", code=code)
    assert read_result(Path("out"))["status"] == status


class Scattered(Measure):
    """One where it is known, NaN at some poses in reach."""

    unit: ClassVar[str] = "1"
    sides: ClassVar[frozenset[str]] = frozenset({"at_least", "at_most"})

    def values(self, manipulator: Any, poses: Any) -> Any:  # noqa: ARG002
        return np.where(poses[:, 0] > 0.2, np.nan, 1.0)


@pytest.mark.parametrize("command", [["run"], ["evaluate"], ["evaluate", "--prove"]])
def test_a_measure_that_is_nan_at_some_poses_in_reach_is_5_where_every_bound_holds(
    command: list[str], spec: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(registry, "find_measure", lambda _: Scattered)
    spec.write_text(
        SPEC.replace("variables:\n  leg: {min: 250 mm, max: 500 mm, start: 330 mm}\n", "")
        .replace("leg, leg, leg", "0.33, 0.33, 0.33")
        .replace("minimise: leg", "minimise: stroke")
    )
    _orthospec(*command, spec.name, "-o", "out", code=5)
    found = read_result(Path("out"))
    assert found["workspace"]["prescribed"]["holds"]
    assert "gave NaN at the reachable pose" in found["errors"][0]["message"]


def test_a_sweep_past_designs_without_a_machine_is_no_fault_of_a_plugin(spec: Path) -> None:
    sweep = "sweep={variable: leg, from: -0.1, to: 0.3, points: 2}"
    _orthospec("evaluate", spec.name, "--set", sweep, "-o", "out")
    assert "no machine can be built" in read_result(Path("out"))["notes"][0]["message"]


def test_a_measure_that_is_nan_at_points_of_a_sweep_is_told_with_them(
    spec: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(registry, "find_measure", lambda _: Scattered)
    sweep = "sweep={variable: leg, from: 0.29, to: 0.4, points: 2}"
    _orthospec("evaluate", spec.name, "--set", sweep, "-o", "out", code=5)
    messages = [error["message"] for error in read_result(Path("out"))["errors"]]
    assert any(message.startswith("at leg = 0.4: gave NaN") for message in messages)


def test_json_is_all_that_stands_on_standard_output(spec: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    _solving(monkeypatch, status="compromise")
    result = _orthospec("run", spec.name, "--json")
    assert json.loads(result.stdout) == read_result(Path("runs/small"))
    assert result.stderr.endswith("written to runs/small\n")


def test_a_folder_in_the_way_is_refused_before_the_work(spec: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def never(*_: Any, **__: Any) -> Outcome:
        raise AssertionError("worked before it looked")

    monkeypatch.setattr("orthospec.study.study.solve", never)
    result = _orthospec("run", spec.name, "-o", str(spec.parent), code=2)
    assert "holds other files and no result" in result.stderr


def test_init_writes_a_spec_that_check_accepts_or_prints_it(spec: Path) -> None:
    written = _orthospec("init", "mine").stdout
    assert "Written to mine.yaml" in written
    assert (spec.parent / "orthospec.schema.json").exists()
    assert (
        _orthospec("check", "mine.yaml").stdout
        == "mine.yaml: ok (orthoglide, 1 variable, 1 measure, 1 goal)\n"
    )
    assert "mine.yaml is there already" in _orthospec("init", "mine", code=2).stderr
    assert "orthospec run 'My Machine.yaml'\n" in _orthospec("init", "My Machine").stdout
    printed = _orthospec("init", "-", "--machine", "linear_delta").stdout
    assert "$schema" not in printed
    assert _orthospec("check", "-", text=printed).stdout.startswith("-: ok (linear_delta")
    assert "did you mean 'orthoglide'?" in _orthospec("init", "--machine", "orthoglyde", code=2).stderr


def test_plan_tells_and_runs_nothing(spec: Path, tmp_path: Path) -> None:
    folder = tmp_path / "none"
    printed = _orthospec("plan", spec.name, "--cache", str(folder)).stdout
    assert printed.startswith("A small one\n  Nothing was run.")
    content = json.loads(_orthospec("plan", spec.name, "--json", "--set", "optimise.starts=6").stdout)
    assert content["search"]["starts"] == 6
    assert content["kept"]["steps"] == 6
    assert sorted(path.name for path in tmp_path.iterdir()) == ["small.yaml"]


def test_run_without_variables_evaluates_and_writes(spec: Path) -> None:
    text = SPEC.replace("  leg: {min: 250 mm, max: 500 mm, start: 330 mm}\n", "")
    spec.write_text(
        text.replace("leg, leg, leg", "0.33, 0.33, 0.33").replace("minimise: leg", "minimise: stroke")
    )
    _orthospec("run", spec.name)
    assert read_result(Path("runs/small"))["status"] == "evaluated"


def test_a_page_that_cannot_be_made_is_left_out_and_costs_nothing_else(
    spec: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(_: Any) -> str:
        raise ZeroDivisionError("no figure")

    monkeypatch.setattr("orthospec.study.study.report", broken)
    told = _orthospec("evaluate", spec.name, "-o", "out")
    assert "note: report.html is left out: ZeroDivisionError: no figure" in told.stderr
    assert sorted(path.name for path in Path("out").iterdir()) == [
        "preview.html",
        "result.yaml",
        "run.log.json",
        "spec.yaml",
    ]


@pytest.mark.parametrize("page", ["report", "preview"])
def test_ctrl_c_while_a_page_is_made_leaves_the_rest_of_the_result(
    page: str, spec: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def stopped(*_: Any) -> str:
        raise KeyboardInterrupt

    monkeypatch.setattr(f"orthospec.study.study.{page}", stopped)
    told = _orthospec("evaluate", spec.name, "-o", "out", code=4)
    assert f"note: stopped at {page}.html: this page, and any after it, is left out" in told.stderr
    assert "Written to out" in told.stdout
    made = {"report": [], "preview": ["report.html"]}[page]
    assert sorted(path.name for path in Path("out").iterdir()) == [
        *made,
        "result.yaml",
        "run.log.json",
        "spec.yaml",
    ]


@pytest.mark.usefixtures("hears_ctrl_c")
def test_ctrl_c_while_the_folder_is_written_waits_until_it_is(
    spec: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    dump = orthospec.result.files.dump

    def interrupted(content: Any) -> str:
        signal.raise_signal(signal.SIGINT)
        return dump(content)

    monkeypatch.setattr("orthospec.result.files.dump", interrupted)
    _orthospec("evaluate", spec.name, "-o", "out", code=4)
    assert read_result(Path("out"))["status"] == "evaluated"
    assert Path("out/preview.html").is_file()


def test_report_is_written_anew_where_it_is_wanted(spec: Path) -> None:
    _orthospec("evaluate", spec.name, "-o", "out")
    assert Path("out/report.html").read_text() == "<h1>evaluated</h1>\n"
    Path("out/report.html").unlink()
    assert _orthospec("report", "out").stdout == "Written to out/report.html\n"
    _orthospec("report", "out/result.yaml", "-o", "elsewhere/page.html")
    assert Path("elsewhere/page.html").read_text() == Path("out/report.html").read_text()
    told = _orthospec("report", "out", "--figures", "figures").stdout
    assert told.endswith(" files in figures\n")
    assert (Path("figures") / "tables.tex").is_file()
    assert "no such file or folder" in _orthospec("report", "missing", code=2).stderr
    assert "cannot be written" in _orthospec("report", "out", "-o", f"{spec.name}/page.html", code=2).stderr


def test_quiet_says_nothing_and_verbose_tells_times_and_versions(spec: Path) -> None:
    assert _orthospec("evaluate", spec.name, "--at", "leg=510 mm", "--resume", "-q").stderr == ""
    told = _orthospec("evaluate", spec.name, "--verbose").stderr
    assert "evaluate: " in told
    assert "with orthospec 0." in told
    assert "kernels for " in told


def test_check_gives_places_for_programs(spec: Path) -> None:
    bad = spec.with_name("bad.yaml")
    bad.write_text(SPEC.replace("use: orthoglide", "use: orthoglyde"))
    content = json.loads(_orthospec("check", spec.name, bad.name, "missing.yaml", "--json", code=2).stdout)
    assert [one["ok"] for one in content] == [True, False, False]
    (mistake,) = content[1]["mistakes"]
    assert (mistake["file"], mistake["line"]) == ("bad.yaml", 5)
    assert "did you mean 'orthoglide'" in mistake["message"]
    assert content[2]["mistakes"][0]["line"] == 0


def test_explain_gives_keys_and_units_for_programs() -> None:
    (entry,) = json.loads(_orthospec("explain", "deflection", "--json").stdout)
    assert (entry["kind"], entry["unit"], entry["sides"]) == ("measure", "m", ["at_most"])
    assert {"force", "wrench"} <= {key["name"] for key in entry["keys"]}


def test_preview_is_written_anew_where_it_is_wanted(spec: Path) -> None:
    _orthospec("evaluate", spec.name, "-o", "out")
    Path("out/preview.html").unlink()
    assert _orthospec("preview", "out").stdout == "Written to out/preview.html\n"
    _orthospec("preview", "out", "--with", "out", "-o", "both.html")
    assert Path("both.html").read_text() == Path("out/preview.html").read_text()
    assert "leave -o out" in _orthospec("preview", "out", "--live", "-o", "x.html", code=2).stderr
    assert "no such file or folder" in _orthospec("preview", "out", "--with", "missing", code=2).stderr


def test_evaluate_prints_and_writes_only_on_request(spec: Path) -> None:
    result = _orthospec("evaluate", spec.name, "--at", "leg=320 mm")
    assert "  leg  320 mm  within 250 ... 500 mm" in result.stdout.splitlines()
    assert [path.name for path in spec.parent.iterdir()] == ["small.yaml"]
    _orthospec("evaluate", spec.name, "-o", "out", "--set", "workspace.divisions=5")
    assert read_result(Path("out"))["variables"] == {"leg": 0.33}
    assert load_spec(Path("out/spec.yaml")).workspace.divisions == 5


def test_evaluate_of_a_design_that_does_not_hold_is_3(spec: Path) -> None:
    result = _orthospec("evaluate", spec.name, "--at", "leg=0.3", "--json", code=3)
    content = json.loads(result.stdout)
    assert content["status"] == "evaluated"
    assert not content["workspace"]["prescribed"]["holds"]


def test_a_design_outside_its_range_is_evaluated_with_a_note(spec: Path) -> None:
    result = _orthospec("evaluate", spec.name, "--at", "leg=600 mm")
    assert "note: leg = 0.6 is outside its range 0.25 ... 0.5" in result.stderr


@pytest.mark.parametrize(
    ("at", "said"),
    [
        ("bar=1", "the variables are leg"),
        ("leg", "NAME=VALUE of a variable was expected"),
        ("leg=", "--at leg=: "),
        ("leg=1 kilo", "unknown unit 'kilo'"),
        ("leg=0", "no machine can be built at leg = 0: leg_lengths.0: more than 0 was expected"),
    ],
)
def test_a_design_given_wrongly_is_2(spec: Path, at: str, said: str) -> None:
    assert said in _orthospec("evaluate", spec.name, "--at", at, code=2).stderr


def test_check_tells_what_each_spec_is_and_all_mistakes(spec: Path) -> None:
    Path("bad.yaml").write_text(SPEC.replace("at_most: 2", "atmost: 2").replace("divisions", "divsions"))
    result = _orthospec("check", "bad.yaml", "none.yaml", spec.name, code=2)
    assert result.stdout == "small.yaml: ok (orthoglide, 1 variable, 1 measure, 1 goal)\n"
    lines = result.stderr.splitlines()
    assert [line.split(": ")[0] for line in lines] == ["bad.yaml:6:45", "bad.yaml:8:61", "none.yaml"]


def test_a_variable_that_nothing_names_is_noted_by_check_and_in_the_result(spec: Path) -> None:
    spec.write_text(SPEC.replace("variables:\n", "variables:\n  lag: {min: 1, max: 2}\n"))
    place, said = "small.yaml:4:3", "variable 'lag' changes nothing"
    result = _orthospec("check", spec.name)
    assert result.stdout.startswith("small.yaml: ok (orthoglide, 2 variables")
    assert result.stderr.startswith(f"note: {place}: {said}")
    ((note,),) = (one["notes"] for one in json.loads(_orthospec("check", spec.name, "--json").stdout))
    assert note["message"].startswith(said)
    _orthospec("evaluate", spec.name, "-o", "out")
    (kept,) = read_result(Path("out"))["notes"]
    assert kept["place"] == place
    assert kept["message"].startswith(said)
    named = SPEC.replace("0.5", "lag / 2").replace("variables:\n", "variables:\n  lag: {min: 1, max: 2}\n")
    spec.write_text(named)
    assert not _orthospec("check", spec.name).stderr


def test_check_reads_standard_input_and_settings(spec: Path) -> None:
    assert "-: ok" in _orthospec("check", "-", text=spec.read_text()).stdout
    result = _orthospec("check", spec.name, "--set", "workspace.divisions=none", code=2)
    assert "--set workspace.divisions=none" in result.stderr


def test_show_tells_what_is_no_result(spec: Path) -> None:
    assert "this is a spec, not a result" in _orthospec("show", spec.name, code=2).stderr
    assert "no such file or folder" in _orthospec("show", "nowhere", code=2).stderr
    Path("empty.yaml").touch()
    said = "empty.yaml:1:1: the file is empty; a result is a folder with result.yaml in it"
    assert said in _orthospec("show", "empty.yaml", code=2).stderr


def test_show_needs_no_spec_beside_the_result(spec: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    _solving(monkeypatch, status="compromise")
    _orthospec("run", spec.name)
    Path("runs/small/spec.yaml").unlink()
    assert "  leg  0.33" in _orthospec("show", "runs/small/result.yaml").stdout.splitlines()
    assert json.loads(_orthospec("show", "runs/small", "--json").stdout)["variables"] == {"leg": 0.33}


def test_plugins_explain_and_schema_print() -> None:
    assert "orthoglide    orthospec" in _orthospec("plugins").stdout
    assert {one["name"] for one in json.loads(_orthospec("plugins", "--json").stdout)} >= {"orthoglide"}
    assert _orthospec("explain", "manipulability").stdout.startswith("manipulability\n")
    assert "did you mean 'orthoglide'?" in _orthospec("explain", "ortoglide", code=2).stderr
    assert "leg_lengths" in json.dumps(json.loads(_orthospec("schema").stdout))


def test_version_and_help() -> None:
    assert _orthospec("--version").stdout.startswith("orthospec 0.")
    text = _orthospec("--help").stdout
    commands = ["init", "run", "check", "plan", "evaluate", "show", "report", "preview", "export", "diff"]
    commands += ["plugins", "explain", "new-plugin", "schema"]
    listed = [line.split()[0] for line in text.partition("Commands:\n")[2].splitlines()]
    assert listed == commands
    assert "..." not in text.partition("Commands:\n")[2]
    for command in commands:
        assert "Usage:" in _orthospec(command, "-h").stdout


@pytest.mark.parametrize(
    ("error", "code", "said"),
    [
        (UsageError("no such thing"), 2, "no such thing"),
        (
            PluginFault("bad", "raised ValueError: no", "small.yaml:8:3"),
            5,
            "small.yaml:8:3: plugin bad: raised",
        ),
        (SystemExit(7), 5, "a plugin ended the program: SystemExit: 7"),
        (KeyboardInterrupt(), 4, "stopped before there was a result"),
        (KeyError("x"), 1, "fault in orthospec itself: KeyError: 'x' (test_cli.py:"),
    ],
)
def test_what_goes_wrong_has_its_exit_code_and_no_trace(
    spec: Path, monkeypatch: pytest.MonkeyPatch, error: BaseException, code: int, said: str
) -> None:
    def failing(*_: Any, **__: Any) -> Outcome:
        raise error

    monkeypatch.delenv("ORTHOSPEC_TRACEBACK", raising=False)
    monkeypatch.setattr("orthospec.study.study.solve", failing)
    result = _orthospec("run", spec.name, code=code)
    assert said in result.stderr
    assert "Traceback" not in result.stderr
    assert not Path("runs").exists()


def test_the_trace_of_a_fault_is_shown_on_request(spec: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def failing(*_: Any, **__: Any) -> Outcome:
        raise KeyError("x")

    monkeypatch.setenv("ORTHOSPEC_TRACEBACK", "1")
    monkeypatch.setattr("orthospec.study.study.solve", failing)
    assert "Traceback (most recent call last)" in _orthospec("run", spec.name, code=1).stderr


def _python(script: str, *arguments: str, **options: Any) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-P", "-c", script, *arguments]
    return subprocess.run(command, capture_output=True, text=True, timeout=60, check=False, **options)


MAIN = "import sys; from orthospec.cli import main; main()"
CHECK = f"""
import sys
sys.argv = ["orthospec", "check", sys.argv[1]]
try:
    {MAIN.partition("; ")[2]}
finally:
    heavy = {{"numpy", "scipy", "cvxpy", "clarabel", "rich", "matplotlib"}} & set(sys.modules)
    print(sorted(heavy))
"""


def test_check_imports_little(spec: Path) -> None:
    done = _python(CHECK, spec.name)
    assert done.stdout == "small.yaml: ok (orthoglide, 1 variable, 1 measure, 1 goal)\n[]\n", done.stderr


def test_check_of_a_machine_with_parts_imports_little() -> None:
    spec = Path(__file__).parents[1] / "specs" / "linear-delta-300.yaml"
    done = _python(CHECK, str(spec))
    assert done.stdout.splitlines()[-1] == "[]", done.stdout + done.stderr


def test_importing_orthospec_imports_nothing_heavy() -> None:
    script = """
import sys, orthospec
print(sorted({"numpy", "pydantic", "cvxpy", "yaml"} & set(sys.modules)))
assert set(orthospec.__all__) <= set(dir(orthospec)) and orthospec.__version__
for name in orthospec.__all__:
    assert getattr(orthospec, name).__name__ == name
"""
    done = _python(script)
    assert (done.returncode, done.stdout) == (0, "[]\n"), done.stderr
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        _ = orthospec.nothing  # type: ignore[attr-defined]


def test_a_reader_that_goes_away_is_no_error() -> None:
    reader, writer = os.pipe()
    os.close(reader)
    command = [sys.executable, "-P", "-c", MAIN, "schema"]
    done = subprocess.run(command, stdout=writer, stderr=subprocess.PIPE, text=True, timeout=60, check=False)
    os.close(writer)
    assert (done.returncode, done.stderr) == (0, "")


def test_letters_that_the_terminal_lacks_are_no_error() -> None:
    environment = {**os.environ, "PYTHONIOENCODING": "ascii"}
    done = subprocess.run(
        [sys.executable, "-P", "-c", MAIN, "explain", "condition_number"],
        capture_output=True,
        timeout=60,
        check=False,
        env=environment,
    )
    assert (done.returncode, done.stderr) == (0, b"")
    assert b"Condition number ?(J)" in done.stdout


TALKATIVE = f"""
import signal
from orthospec.show import progress
signal.signal(signal.SIGINT, signal.HANDLER)
progress.PLAIN = 0.0
{MAIN}
"""


@pytest.mark.parametrize(
    ("number", "handler"),
    [
        (signal.SIGINT, "default_int_handler"),
        (signal.SIGTERM, "default_int_handler"),
        (signal.SIGTERM, "SIG_IGN"),
    ],
)
def test_a_request_to_end_keeps_what_was_found(spec: Path, number: signal.Signals, handler: str) -> None:
    spec.write_text(SPEC.replace("starts: 1", "starts: 2000"))
    command = [sys.executable, "-P", "-c", TALKATIVE.replace("HANDLER", handler), "run", spec.name]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stderr is not None
        assert "designs on the coarse grid" in process.stderr.readline()
        process.send_signal(number)
        out, error = process.communicate(timeout=60)
    assert process.returncode == 4, error
    assert "Stopped before the end" in out
    assert read_result(Path("runs/small"))["status"] == "unfinished"


def test_fields_keeps_the_values_on_the_grid_beside_the_result(spec: Path) -> None:
    _orthospec("evaluate", "small.yaml", "--fields", "-o", "kept")
    with np.load(spec.parent / "kept" / "fields.npz") as kept:
        shape = tuple(len(kept[f"axis_{axis}"]) for axis in "xyz")
        assert kept["transmission"].shape == (*shape, 2)
        origin = tuple(int(np.flatnonzero(np.abs(kept[f"axis_{axis}"]) < 1e-12)[0]) for axis in "xyz")
        assert kept["transmission"][origin] == pytest.approx([1.0, 1.0])
        assert np.isnan(kept["transmission"][0, 0, 0]).all()


def test_ctrl_c_while_fields_are_made_leaves_the_rest_of_the_result(
    spec: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def stopped(*_: Any, **__: Any) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("orthospec.optimise.fields_of", stopped)
    told = _orthospec("evaluate", str(spec), "-o", "stopped", "--fields", code=4)
    assert "fields.npz is left out" in told.stderr
    assert {path.name for path in Path("stopped").iterdir()} == {
        "preview.html",
        "report.html",
        "result.yaml",
        "run.log.json",
        "spec.yaml",
    }


@pytest.mark.usefixtures("spec")
def test_fields_without_a_folder_says_what_to_add() -> None:
    assert "-o DIR" in _orthospec("evaluate", "small.yaml", "--fields", code=2).stderr


def test_diff_tells_what_differs_and_ends_with_0(spec: Path) -> None:
    (spec.parent / "other.yaml").write_text(
        SPEC.replace("at_most: 2}", "at_most: 2.5}").replace("500 mm", "0.5")
    )
    result = _orthospec("diff", "small.yaml", "other.yaml")
    assert "  transmission.at_most  2  2.5  +0.5  +25 %" in result.stdout.splitlines()
    assert result.stderr == ""
    assert "No difference in meaning" in _orthospec("diff", "small.yaml", "-", text=SPEC).stdout
    found = json.loads(_orthospec("diff", "--changed", "--json", "small.yaml", "other.yaml").stdout)
    assert [(row["what"], row["relative"]) for row in found["rows"]] == [
        ("measures.transmission.at_most", pytest.approx(0.25))
    ]
    assert json.loads(_orthospec("diff", "--json", "small.yaml", "small.yaml").stdout)["same"] is True


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["small.yaml", "out"], "small.yaml is a spec and out is a result"),
        (["out", "nowhere"], "nowhere: no such file or directory"),
        (["empty", "out"], "empty: no result.yaml in this folder"),
        (["small.yaml", "wrong.yaml"], "wrong.yaml:1:1: 'workspace' is missing"),
        (["small.yaml"], "two specs or two results were expected, 1 given"),
        (["small.yaml"] * 3, "two specs or two results were expected, 3 given"),
    ],
)
def test_diff_refuses_what_it_cannot_compare(spec: Path, arguments: list[str], said: str) -> None:
    (spec.parent / "wrong.yaml").write_text(
        SPEC.replace("workspace: {size: [200 mm, 200 mm, 200 mm], divisions: 8}\n", "")
    )
    (spec.parent / "empty").mkdir()
    _orthospec("evaluate", "small.yaml", "-o", "out", "--at", "leg=0.35")
    result = _orthospec("diff", *arguments, code=2)
    assert result.stdout == ""
    assert said in result.stderr


def test_diff_answers_git_for_what_is_new_gone_or_not_merged(
    spec: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    here, none = ["small.yaml", "0" * 40, "100644"], ["/dev/null", ".", "."]
    assert "+title: A small one" in _orthospec("diff", "small.yaml", *none, *here).stdout.splitlines()
    assert "-title: A small one" in _orthospec("diff", "small.yaml", *here, *none).stdout.splitlines()
    monkeypatch.setenv("GIT_DIFF_PATH_COUNTER", "1")
    assert _orthospec("diff", "small.yaml").stdout == "small.yaml: not merged yet\n\n"
    assert spec.exists()

"""The commands, in the order of the work. No arithmetic here; what is heavy is imported where it is used.

Results go to standard output, progress and messages to standard error; `orthospec.guard` has the exit codes.
"""

from __future__ import annotations

import functools
import json
import os
import shutil
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ParamSpec, TextIO

import typer

from orthospec.errors import OrthospecError, UsageError
from orthospec.guard import DONE, NOT_MET, PLUGIN, STOPPED, exit_code, say
from orthospec.threads import one_blas_thread

if TYPE_CHECKING:
    from orthospec.arrays import Array
    from orthospec.compare import Comparison, GitCall
    from orthospec.optimise import Outcome, Workers
    from orthospec.show import ProgressLine
    from orthospec.spec import Spec

WIDEST = 100
"""Longer lines are hard to read, however wide the terminal."""

app = typer.Typer(
    name="orthospec",
    add_completion=True,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    context_settings={"help_option_names": ["-h", "--help"]},
)
_Arguments = ParamSpec("_Arguments")

SpecFile = Annotated[str, typer.Argument(metavar="SPEC", help="The spec file; - reads standard input.")]
ResultPath = Annotated[Path, typer.Argument(metavar="RESULT", help="A result folder, or its result.yaml.")]
Settings = Annotated[
    list[str] | None,
    typer.Option(
        "--set", metavar="KEY=VALUE", help="Change the spec, like workspace.divisions=80; repeatable."
    ),
]
Fields = Annotated[
    bool, typer.Option("--fields", help="Keep the measures' values on the grid too, in fields.npz.")
]
Jobs = Annotated[
    int, typer.Option("--jobs", metavar="N", min=1, help="Do what is independent in N processes.")
]
On = Annotated[
    str | None,
    typer.Option("--on", metavar="URL", help="Do it on the workers of a Dask scheduler, tcp://HOST:8786."),
]
Folder = Annotated[
    Path | None,
    typer.Option("--cache", metavar="DIR", help="Keep what was done there; your cache folder if not given."),
]
Resume = Annotated[
    bool, typer.Option("--resume", help="Go on after a run that was stopped; tell what is done already.")
]
Json = Annotated[bool, typer.Option("--json", help="Print JSON for programs to read.")]


def main() -> None:
    """What the installed command calls."""
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="replace")
    one_blas_thread()
    app()


def _command(work: Callable[_Arguments, int]) -> Callable[_Arguments, None]:
    """Register a command: its exit code is what it gives back, or that of the error that it raises."""

    @functools.wraps(work)
    def guarded(*args: _Arguments.args, **kwargs: _Arguments.kwargs) -> None:
        raise typer.Exit(exit_code(lambda: work(*args, **kwargs)))

    name = work.__name__.replace("_", "-")
    return app.command(name)(guarded)


def _print(text: str) -> None:
    sys.stdout.write(text if text.endswith("\n") else text + "\n")


def _print_json(content: Any) -> None:
    _print(json.dumps(content, indent=2, ensure_ascii=False))


def _format(stream: TextIO) -> dict[str, Any]:
    """Width and colour for a stream."""
    plain = os.environ.get("NO_COLOR") or os.environ.get("TERM") == "dumb"
    width = min(shutil.get_terminal_size((80, 24)).columns, WIDEST)
    return {"width": width, "colour": stream.isatty() and not plain}


def _version(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import version

        typer.echo(f"orthospec {version('orthospec')}")
        raise typer.Exit


@app.callback()
def _orthospec(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    """Find the best dimensions of a parallel manipulator, from a spec file."""


@_command
def init(
    name: Annotated[
        str, typer.Argument(metavar="NAME", help="Writes NAME.yaml; - prints the spec instead.")
    ] = "spec",
    machine: Annotated[
        str, typer.Option("--machine", metavar="NAME", help="An installed manipulator; see `plugins`.")
    ] = "orthoglide",
) -> int:
    """Write a spec to start from, with every key explained.

    Beside it stands orthospec.schema.json, by which editors complete and check specs.
    """
    from orthospec.starter import starting_spec, write_start

    if name == "-":
        _print(starting_spec(machine, None))
        return DONE
    spec, schema = write_start(name, machine)
    _print(f"Written to {spec}, and to {schema} what editors complete it by")
    _print(f"Next: orthospec plan {spec}, orthospec run {spec}")
    return DONE


@_command
def run(
    spec: SpecFile,
    out: Annotated[
        Path | None,
        typer.Option(
            "-o", "--out", metavar="DIR", help="Result folder; runs/<name of the spec> if not given."
        ),
    ] = None,
    settings: Settings = None,
    fields: Fields = False,
    jobs: Jobs = 1,
    on: On = None,
    resume: Resume = False,
    cache: Folder = None,
    as_json: Json = False,
) -> int:
    """Find the best design and write a result folder.

    Without variables the one design of the spec is evaluated. Exit codes: 0 done, 2 wrong spec, 3 no design
    found in which every bound holds, 4 stopped, 5 a plugin failed.
    """
    from orthospec.optimise import solve
    from orthospec.result import check_destination
    from orthospec.show import ProgressLine
    from orthospec.spec import load_spec

    problem = load_spec(Path(spec), settings or [])
    folder = out or Path("runs") / ("stdin" if spec == "-" else Path(spec).stem)
    check_destination(folder)
    with _workers(jobs, on, cache, resume) as workers, ProgressLine(sys.stderr) as progress:
        outcome = solve(problem, progress=progress, workers=workers)
        kept = _fields(problem, outcome, progress, workers) if fields else None
    return _hand_over(problem, outcome, folder, kept, as_json)


@_command
def check(
    specs: Annotated[list[str], typer.Argument(metavar="SPEC", help="Spec files; - reads standard input.")],
    settings: Settings = None,
) -> int:
    """Check specs: all mistakes at once, with places."""
    from orthospec.spec import load_spec

    codes = {0}
    for spec in specs:
        try:
            problem = load_spec(Path(spec), settings or [])
        except OrthospecError as error:
            say(str(error))
            codes.add(error.exit_code)
        else:
            _print(f"{spec}: ok ({_in_a_line(problem)})")
    return max(codes)


@_command
def plan(
    spec: SpecFile,
    settings: Settings = None,
    cache: Annotated[
        Path | None,
        typer.Option("--cache", metavar="DIR", help="Where runs keep what was done; else your cache folder."),
    ] = None,
    as_json: Json = False,
) -> int:
    """Tell what a run would do, without running it."""
    from orthospec.optimise.plan import plan as planned
    from orthospec.show import plan_content, show_plan
    from orthospec.spec import load_spec

    problem = load_spec(Path(spec), settings or [])
    found = planned(problem, cache)
    if as_json:
        _print_json(plan_content(problem, found))
    else:
        _print(show_plan(problem, found, **_format(sys.stdout)))
    return DONE


@_command
def evaluate(
    spec: SpecFile,
    at: Annotated[
        str | None,
        typer.Option(
            "--at", metavar="NAME=VALUE,...", help="The design, like base=1.5,third=1.5; else the start."
        ),
    ] = None,
    settings: Settings = None,
    out: Annotated[
        Path | None, typer.Option("-o", "--out", metavar="DIR", help="Write a result folder too.")
    ] = None,
    fields: Fields = False,
    what_if: Annotated[
        list[str] | None,
        typer.Option(
            "--what-if",
            metavar="MEASURE.SIDE=VALUE",
            help="Only tell what another bound does to the cuboids on the grid; repeatable.",
        ),
    ] = None,
    prove: Annotated[
        bool, typer.Option("--prove", help="Prove it at every pose, as a run does for the design it finds.")
    ] = False,
    jobs: Jobs = 1,
    on: On = None,
    resume: Resume = False,
    cache: Folder = None,
    as_json: Json = False,
) -> int:
    """Measure one design: its cuboids, indices and extremes."""
    from orthospec.optimise import evaluate_spec, with_proof
    from orthospec.result import check_destination
    from orthospec.show import ProgressLine
    from orthospec.spec import ProofKeys, load_spec

    problem = load_spec(Path(spec), settings or [])
    values = problem.default_values() | _values(problem, at or "")
    if what_if:
        if out is not None or fields or prove:
            raise UsageError("--what-if prints its answer alone: leave -o, --fields and --prove out")
        with _workers(jobs, on, cache, resume) as workers, ProgressLine(sys.stderr) as progress:
            return _tell_what_if(problem, values, what_if, progress, workers, as_json)
    if out is not None:
        check_destination(out)
    elif fields:
        raise UsageError("--fields writes into a result folder: give one with -o DIR")
    with _workers(jobs, on, cache, resume) as workers, ProgressLine(sys.stderr) as progress:
        outcome = evaluate_spec(problem, values, progress=progress, workers=workers)
        if prove:
            keys = problem.proof or ProofKeys()
            outcome = with_proof(problem, outcome, keys, progress=progress, workers=workers)
        kept = _fields(problem, outcome, progress, workers) if fields else None
    return _hand_over(problem, outcome, out, kept, as_json)


@_command
def show(result: ResultPath, as_json: Json = False) -> int:
    """Print a result."""
    from orthospec.result import read_result, spec_of
    from orthospec.show import show as text

    content = read_result(result)
    if as_json:
        _print_json(content)
    else:
        _print(text(content, spec=spec_of(result), **_format(sys.stdout)))
    return DONE


@_command
def report(
    result: ResultPath,
    out: Annotated[
        Path | None,
        typer.Option(
            "-o", "--out", metavar="FILE", help="Where to write; report.html in the result's folder."
        ),
    ] = None,
    figures: Annotated[
        Path | None,
        typer.Option(
            "--figures",
            metavar="DIR",
            help="Write figures as SVG, PDF, PNG and CSV, and tables for LaTeX, too.",
        ),
    ] = None,
) -> int:
    """Write the report of a result anew, and its figures for papers."""
    from orthospec.report import report as page
    from orthospec.report import write_figures
    from orthospec.result import REPORT, write_page
    from orthospec.solution import read_solution

    solution = read_solution(result)
    file = out or (result if result.is_dir() else result.parent) / REPORT
    write_page(file, page(solution))
    _print(f"Written to {file}")
    if figures is not None:
        _print(f"{len(write_figures(solution, figures))} files in {figures}")
    return DONE


@_command
def preview(
    result: ResultPath,
    other: Annotated[
        Path | None,
        typer.Option(
            "--with", metavar="RESULT", help="Another result whose machine and cuboid to show in it."
        ),
    ] = None,
    live: Annotated[
        bool, typer.Option("--live", help="Show it in a browser, and follow the result until Ctrl-C.")
    ] = False,
    out: Annotated[
        Path | None,
        typer.Option(
            "-o", "--out", metavar="FILE", help="Where to write; preview.html in the result's folder."
        ),
    ] = None,
) -> int:
    """Write a scene of a result, to turn and move in a browser."""
    from orthospec.preview import preview as page
    from orthospec.preview import show_live
    from orthospec.result import PREVIEW, write_page
    from orthospec.solution import read_solution

    def made() -> str:
        return page(read_solution(result), None if other is None else read_solution(other))

    if live:
        if out is not None:
            raise UsageError("--live writes no file: leave -o out")
        show_live(made, result, _print)
        return DONE
    file = out or (result if result.is_dir() else result.parent) / PREVIEW
    write_page(file, made())
    _print(f"Written to {file}")
    return DONE


@_command
def export(
    result: ResultPath,
    files: Annotated[
        list[Path],
        typer.Argument(
            metavar="FILE...",
            help="By name: fields.nc, fields.zarr, fields.vti, cuboid.stl, largest.stl, workspace.stl,"
            " machine.glb, machine.xml (MuJoCo), designs.csv; or with more before it, as before-fields.nc.",
        ),
    ],
) -> int:
    """Write fields, surfaces, the machine or a table for others."""
    from orthospec.study import open_study

    for file in open_study(result).export(*files):
        _print(f"Written to {file}")
    return DONE


@_command
def diff(
    both: Annotated[
        list[str],
        typer.Argument(metavar="A B", help="Two specs, or two results; or what git gives a diff driver."),
    ],
    changed: Annotated[bool, typer.Option("--changed", help="Tell only what differs.")] = False,
    as_json: Json = False,
) -> int:
    """Compare two specs or two results by what they mean.

    Exit codes: 0 compared, whether they differ or not; 2 nothing to compare, or a spec with a result.
    """
    from orthospec.compare import compare, git_call, read_side

    call = git_call(both, os.environ)
    if call is not None:
        _tell_git(call, changed, as_json)
        return DONE
    if len(both) != 2:
        raise UsageError(f"two specs or two results were expected, {len(both)} given")
    a, b = (read_side(Path(one)) for one in both)
    _tell_difference(compare(a, b), changed, as_json)
    return DONE


@_command
def plugins(as_json: Json = False) -> int:
    """List the installed manipulators and measures."""
    from orthospec.show import installed, show_installed

    entries = installed()
    if as_json:
        _print_json(entries)
    else:
        _print(show_installed(entries, **_format(sys.stdout)))
    return DONE


@_command
def explain(
    name: Annotated[str, typer.Argument(metavar="NAME", help="A manipulator or measure, as specs name it.")],
) -> int:
    """Tell what a manipulator or measure is."""
    from orthospec.show import explain as text

    _print(text(name, **_format(sys.stdout)))
    return DONE


@_command
def new_plugin(
    name: Annotated[str, typer.Argument(metavar="NAME", help="Of the distribution and its new folder.")],
    machine: Annotated[
        bool, typer.Option("--manipulator", help="For a machine; a measure if left out.")
    ] = False,
) -> int:
    """Write a distribution to start a plugin from."""
    from orthospec.starter import write_plugin

    folder = write_plugin(name, "manipulator" if machine else "measure")
    _print(f"Written to {folder}")
    _print(f"Next: pip install './{folder}[test]', pytest {folder}, orthospec run {folder}/specs/try.yaml")
    return DONE


@_command
def schema() -> int:
    """Print the JSON Schema of spec files."""
    from orthospec.spec import schema as content

    _print_json(content())
    return DONE


@contextmanager
def _workers(jobs: int, on: str | None, cache: Path | None, resume: bool) -> Iterator[Workers]:
    """Whoever does the tasks, and keeps what was done for the next run."""
    from orthospec.optimise import hired, remembering

    with hired(jobs, on) as workers, remembering(workers, cache) as keeping:
        yield keeping
    if resume:
        say(f"resumed: {keeping.known} of {keeping.asked} steps were done already")


def _fields(
    spec: Spec, outcome: Outcome, progress: ProgressLine, workers: Workers
) -> dict[str, Array] | None:
    """What is asked for by --fields; none where the run was stopped, or is now, or a plugin failed."""
    from orthospec.optimise import fields_of

    if outcome.interrupted or outcome.finding.status == "failed":
        return None
    try:
        return fields_of(spec, outcome.finding.design, progress=progress, workers=workers)
    except KeyboardInterrupt:
        say("stopped before the fields were complete: fields.npz is left out")
        outcome.interrupted = True
        return None


def _hand_over(
    spec: Spec, outcome: Outcome, folder: Path | None, kept: dict[str, Array] | None, as_json: bool
) -> int:
    """Write, print, and say how it went."""
    from orthospec.result import compose, write_result
    from orthospec.show import show as text

    content = compose(spec, outcome.finding)
    if folder is not None:
        write_result(folder, spec, content, outcome.log, kept, _pages(spec, content, outcome.log))
    if as_json:
        _print_json(content)
    else:
        _print(text(content, spec=spec, **_format(sys.stdout)))
    if folder is not None:
        _tell_folder(folder, as_json)
    return _code_of(outcome)


def _pages(spec: Spec, content: dict[str, Any], log: dict[str, Any]) -> dict[str, str]:
    """The pages of a result folder; one that cannot be made is left out, and costs nothing else."""
    from orthospec.preview import preview
    from orthospec.report import report
    from orthospec.result import PREVIEW, REPORT
    from orthospec.solution import Solution

    solution = Solution(content, spec, log)
    pages = {}
    for name, make in {REPORT: report, PREVIEW: preview}.items():
        try:
            pages[name] = make(solution)
        except Exception as error:
            say(f"note: {name} is left out: {type(error).__name__}: {error}")
    return pages


def _tell_what_if(
    spec: Spec,
    values: dict[str, float],
    moves: list[str],
    progress: ProgressLine,
    workers: Workers,
    as_json: bool,
) -> int:
    from orthospec.optimise.what_if import know, read_moves
    from orthospec.show import show_what_if, what_if_content

    asked = read_moves(spec, values, moves)
    known = know(spec, values, progress=progress, workers=workers)
    answer = known.answer(asked)
    if as_json:
        _print_json(what_if_content(answer))
    else:
        _print(show_what_if(known, answer, **_format(sys.stdout)))
    return DONE


def _tell_difference(found: Comparison, changed: bool, as_json: bool) -> None:
    from orthospec.show import diff_content, show_diff

    if as_json:
        _print_json(diff_content(found, changed=changed))
    else:
        _print(show_diff(found, changed=changed, **_format(sys.stdout)))


def _tell_git(call: GitCall, changed: bool, as_json: bool) -> None:
    """Git stops at a driver that fails: what cannot be compared by meaning is told by its lines."""
    from orthospec.compare import compare, line_by_line, read_side

    if call.old is None and call.new is None:
        _print(f"{call.path}: not merged yet")
    elif call.old is None or call.new is None:
        _print(line_by_line(call))
    else:
        try:
            a = read_side(call.old, stands_for=call.path, name=call.old_name)
            b = read_side(call.new, stands_for=call.new_path or call.path, name=call.new_name)
            _tell_difference(compare(a, b), changed, as_json)
        except OrthospecError as error:
            _print(f"{error}\n{call.path}: compared by its lines instead\n{line_by_line(call)}")
    _print("")


def _tell_folder(folder: Path, as_json: bool) -> None:
    if as_json:
        say(f"written to {folder}")
    else:
        _print(f"\nWritten to {folder}")


def _code_of(outcome: Outcome) -> int:
    finding = outcome.finding
    if finding.status == "failed":
        return PLUGIN
    if outcome.interrupted or finding.status == "unfinished":
        return STOPPED
    if finding.status == "infeasible" or not finding.evaluation.holds:
        return NOT_MET
    return DONE


def _in_a_line(spec: Spec) -> str:
    counts = {"variable": len(spec.variables), "measure": len(spec.measures), "goal": len(spec.goals)}
    parts = [f"{count} {what}{'' if count == 1 else 's'}" for what, count in counts.items()]
    return ", ".join([spec.manipulator.use, *parts])


def _values(spec: Spec, text: str) -> dict[str, float]:
    """The values in ``base=1.5,third=310 mm``."""
    from orthospec.quantities.fields import resolve

    values = {}
    for part in filter(None, (part.strip() for part in text.split(","))):
        name, equals, value = (piece.strip() for piece in part.partition("="))
        if not equals or name not in spec.variables:
            known = ", ".join(spec.variables) or "none"
            raise UsageError(f"--at {part}: NAME=VALUE of a variable was expected; the variables are {known}")
        try:
            values[name] = resolve(value, None, {})
        except ValueError as error:
            raise UsageError(f"--at {part}: {error}") from None
        _warn_outside(spec, name, values[name])
    return values


def _warn_outside(spec: Spec, name: str, value: float) -> None:
    low, high, choices = (getattr(spec.variables[name], part) for part in ("min", "max", "choices"))
    if choices and value not in choices:
        say(f"note: {name} = {value:g} is not one of its choices {', '.join(f'{one:g}' for one in choices)}")
        return
    if not low <= value <= high:
        say(f"note: {name} = {value:g} is outside its range {low:g} ... {high:g}")

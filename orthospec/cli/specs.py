"""The commands on specs: begin one, run it, check it, plan it, evaluate a design."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from orthospec.cli.command import command, format_of, print_json, print_text
from orthospec.cli.options import Fields, Folder, Jobs, Json, On, Quiet, Resume, Settings, SpecFile, Verbose
from orthospec.errors import GridTooLarge, OrthospecError, SpecError, UsageError
from orthospec.guard import DONE, NOT_MET, PLUGIN, STOPPED, say

if TYPE_CHECKING:
    from orthospec.arrays import Array
    from orthospec.optimise import Workers
    from orthospec.show import ProgressLine
    from orthospec.spec import Spec
    from orthospec.study import Study


@command
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
        print_text(starting_spec(machine, None))
        return DONE
    spec, schema = write_start(name, machine)
    print_text(f"Written to {spec}, and to {schema} what editors complete it by")
    quoted = shlex.quote(str(spec))
    print_text(f"Next: orthospec plan {quoted}, orthospec run {quoted}")
    return DONE


@command
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
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> int:
    """Find the best design and write a result folder.

    Without variables the one design of the spec is evaluated. Exit codes: 0 done, 2 wrong spec, 3 no design
    found in which every bound holds, 4 stopped, 5 a plugin failed.
    """
    from orthospec import study as studies
    from orthospec.result import check_destination
    from orthospec.spec import load_spec

    problem = load_spec(Path(spec), settings or [])
    folder = out or Path("runs") / ("stdin" if spec == "-" else Path(spec).stem)
    check_destination(folder)
    with _workers(jobs, on, cache, resume and not quiet) as workers, _following(quiet) as progress:
        found = studies.run(problem, progress=progress, workers=workers)
        kept = _fields(found, progress, workers) if fields else None
    _tell_times(found, verbose)
    return _hand_over(found, folder, kept, as_json)


@command
def check(
    specs: Annotated[list[str], typer.Argument(metavar="SPEC", help="Spec files; - reads standard input.")],
    settings: Settings = None,
    as_json: Json = False,
) -> int:
    """Check specs: all mistakes at once, with places."""
    from orthospec.spec import load_spec

    codes, told = {0}, []
    for spec in specs:
        try:
            problem = load_spec(Path(spec), settings or [])
        except OrthospecError as error:
            codes.add(error.exit_code)
            told.append({"file": spec, "ok": False, "mistakes": _mistakes(spec, error), "notes": []})
            if not as_json:
                say(str(error))
        else:
            notes = problem.oddities()
            told.append({"file": spec, "ok": True, "mistakes": [], "notes": list(map(asdict, notes))})
            if not as_json:
                print_text(f"{spec}: ok ({_in_a_line(problem)})")
                for note in notes:
                    say(f"note: {note}")
    if as_json:
        print_json(told)
    return max(codes)


def _mistakes(spec: str, error: OrthospecError) -> list[dict[str, Any]]:
    """Each with its place, for editors and CI; line and column count from 1, 0 where there is no place."""
    if isinstance(error, SpecError):
        return [asdict(mistake) for mistake in error.mistakes]
    return [{"file": spec, "line": 0, "column": 0, "message": str(error)}]


@command
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
        print_json(plan_content(problem, found))
    else:
        print_text(show_plan(problem, found, **format_of(sys.stdout)))
    return DONE


@command
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
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> int:
    """Measure one design: its cuboids, indices and extremes."""
    from orthospec import study as studies
    from orthospec.result import check_destination
    from orthospec.spec import load_spec

    problem = load_spec(Path(spec), settings or [])
    values = problem.default_values() | _values(problem, at or "", quiet)
    if what_if:
        if out is not None or fields or prove:
            raise UsageError("--what-if prints its answer alone: leave -o, --fields and --prove out")
        with _workers(jobs, on, cache, resume and not quiet) as workers, _following(quiet) as progress:
            return _tell_what_if(problem, values, what_if, progress, workers, as_json)
    if out is not None:
        check_destination(out)
    elif fields:
        raise UsageError("--fields writes into a result folder: give one with -o DIR")
    with _workers(jobs, on, cache, resume and not quiet) as workers, _following(quiet) as progress:
        found = studies.evaluate(problem, values, prove=prove, progress=progress, workers=workers)
        kept = _fields(found, progress, workers) if fields else None
    _tell_times(found, verbose)
    return _hand_over(found, out, kept, as_json)


def _following(quiet: bool) -> ProgressLine:
    from orthospec.show import ProgressLine, Silence

    return Silence() if quiet else ProgressLine(sys.stderr)


def _tell_times(found: Study, verbose: bool) -> None:
    """What took how long, and what it was computed with."""
    if not verbose:
        return
    from importlib.metadata import version

    from orthospec.kernels import instruction_set

    for stage, seconds in found.log.get("seconds", {}).items():
        say(f"{stage}: {seconds:.2f} s")
    versions = ", ".join(
        f"{name} {version(name)}" for name in ("orthospec", "numpy", "scipy", "cvxpy", "clarabel")
    )
    python = ".".join(map(str, sys.version_info[:3]))
    say(f"with {versions}, Python {python}, kernels for {instruction_set()}")


@contextmanager
def _workers(jobs: int, on: str | None, cache: Path | None, resume: bool) -> Iterator[Workers]:
    """Whoever does the tasks, and keeps what was done for the next run."""
    from orthospec.optimise import hired, remembering

    with hired(jobs, on) as workers, remembering(workers, cache) as keeping:
        yield keeping
    if resume:
        say(f"resumed: {keeping.known} of {keeping.asked} steps were done already")


def _fields(found: Study, progress: ProgressLine, workers: Workers) -> dict[str, Array] | None:
    """What is asked for by --fields; none where the run was stopped, or is now, or a plugin failed."""
    from orthospec.optimise import fields_of

    outcome = found.outcome
    if outcome is None or outcome.interrupted or found.status == "failed" or found.spec is None:
        return None
    try:
        return fields_of(found.spec, outcome.finding.design, progress=progress, workers=workers)
    except KeyboardInterrupt:
        say("stopped before the fields were complete: fields.npz is left out")
        outcome.interrupted = True
        return None
    except GridTooLarge as error:
        say(f"fields.npz is left out: {error}")
        return None


def _hand_over(found: Study, folder: Path | None, kept: dict[str, Array] | None, as_json: bool) -> int:
    """Write, print, and say how it went."""
    from orthospec.show import show as text

    if folder is not None:
        found.save(folder, kept, told=lambda what: say(f"note: {what}"))
    if as_json:
        print_json(found.content)
    else:
        print_text(text(found.content, spec=found.spec, **format_of(sys.stdout)))
    if folder is not None:
        _tell_folder(folder, as_json)
    return _code_of(found)


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
        print_json(what_if_content(answer))
    else:
        print_text(show_what_if(known, answer, **format_of(sys.stdout)))
    return DONE


def _tell_folder(folder: Path, as_json: bool) -> None:
    if as_json:
        say(f"written to {folder}")
    else:
        print_text(f"\nWritten to {folder}")


def _code_of(found: Study) -> int:
    if found.status == "failed":
        return PLUGIN
    if found.outcome is None or found.outcome.interrupted or found.status == "unfinished":
        return STOPPED
    if found.status == "infeasible" or not found.outcome.finding.evaluation.holds:
        return NOT_MET
    return PLUGIN if found.outcome.finding.errors else DONE


def _in_a_line(spec: Spec) -> str:
    counts = {"variable": len(spec.variables), "measure": len(spec.measures), "goal": len(spec.goals)}
    parts = [f"{count} {what}{'' if count == 1 else 's'}" for what, count in counts.items()]
    return ", ".join([spec.manipulator.use, *parts])


def _values(spec: Spec, text: str, quiet: bool) -> dict[str, float]:
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
        if not quiet:
            _warn_outside(spec, name, values[name])
    return values


def _warn_outside(spec: Spec, name: str, value: float) -> None:
    low, high, choices = (getattr(spec.variables[name], part) for part in ("min", "max", "choices"))
    if choices and value not in choices:
        say(f"note: {name} = {value:g} is not one of its choices {', '.join(f'{one:g}' for one in choices)}")
        return
    if not low <= value <= high:
        say(f"note: {name} = {value:g} is outside its range {low:g} ... {high:g}")

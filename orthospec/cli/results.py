"""The commands on results: show them, draw them, hand them on, compare them."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from orthospec.cli.command import command, format_of, print_json, print_text
from orthospec.cli.options import Json, ResultPath
from orthospec.errors import OrthospecError, UsageError
from orthospec.guard import DONE

if TYPE_CHECKING:
    from orthospec.compare import Comparison, GitCall


@command
def show(result: ResultPath, as_json: Json = False) -> int:
    """Print a result."""
    from orthospec.result import read_result, spec_of
    from orthospec.show import show as text

    content = read_result(result)
    if as_json:
        print_json(content)
    else:
        print_text(text(content, spec=spec_of(result), **format_of(sys.stdout)))
    return DONE


@command
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
    print_text(f"Written to {file}")
    if figures is not None:
        print_text(f"{len(write_figures(solution, figures))} files in {figures}")
    return DONE


@command
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
        show_live(made, result, print_text)
        return DONE
    file = out or (result if result.is_dir() else result.parent) / PREVIEW
    write_page(file, made())
    print_text(f"Written to {file}")
    return DONE


@command
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
        print_text(f"Written to {file}")
    return DONE


@command
def diff(
    both: Annotated[
        list[str] | None,
        typer.Argument(metavar="A B", help="Two specs, or two results; or what git gives a diff driver."),
    ] = None,
    since: Annotated[
        str | None,
        typer.Option(
            "--since", metavar="REVISION", help="All specs and results that differ from a git revision."
        ),
    ] = None,
    changed: Annotated[bool, typer.Option("--changed", help="Tell only what differs.")] = False,
    markdown: Annotated[
        bool, typer.Option("--markdown", help="Write Markdown, for the comment on a pull request.")
    ] = False,
    as_json: Json = False,
) -> int:
    """Compare two specs or two results by what they mean.

    Exit codes: 0 compared, whether they differ or not; 2 nothing to compare, or a spec with a result.
    """
    from orthospec.compare import compare, git_call, read_side
    from orthospec.show import compared

    both = both or []
    if since is not None:
        if both:
            raise UsageError("--since compares the working tree with a revision: leave the files out")
        _tell_since(since, changed, markdown, as_json)
        return DONE
    call = git_call(both, os.environ)
    if call is not None:
        _tell_git(call, changed, as_json)
        return DONE
    if len(both) != 2:
        raise UsageError(f"two specs or two results were expected, {len(both)} given")
    a, b = (read_side(Path(one)) for one in both)
    if markdown:
        print_text(compared(compare(a, b), f"{a.name}, {b.name}"))
    else:
        _tell_difference(compare(a, b), changed, as_json)
    return DONE


def _tell_difference(found: Comparison, changed: bool, as_json: bool) -> None:
    from orthospec.show import diff_content, show_diff

    if as_json:
        print_json(diff_content(found, changed=changed))
    else:
        print_text(show_diff(found, changed=changed, **format_of(sys.stdout)))


def _tell_since(revision: str, changed: bool, markdown: bool, as_json: bool) -> None:
    from orthospec.compare import changed_since
    from orthospec.show import comment, diff_content, show_diff

    files = changed_since(revision)
    if markdown:
        print_text(comment(files, revision))
    elif as_json:
        print_json(
            [
                {"path": one.path, "said": one.said}
                | ({} if one.comparison is None else diff_content(one.comparison, changed=changed))
                for one in files
            ]
        )
    else:
        for one in files:
            known = one.comparison
            print_text(
                f"{one.path}: {one.said}\n"
                if known is None
                else show_diff(known, changed=changed, **format_of(sys.stdout)) + "\n"
            )


def _tell_git(call: GitCall, changed: bool, as_json: bool) -> None:
    """Git stops at a driver that fails: what cannot be compared by meaning is told by its lines."""
    from orthospec.compare import compare, line_by_line, read_side

    if call.old is None and call.new is None:
        print_text(f"{call.path}: not merged yet")
    elif call.old is None or call.new is None:
        print_text(line_by_line(call))
    else:
        try:
            a = read_side(call.old, stands_for=call.path, name=call.old_name)
            b = read_side(call.new, stands_for=call.new_path or call.path, name=call.new_name)
            _tell_difference(compare(a, b), changed, as_json)
        except OrthospecError as error:
            print_text(f"{error}\n{call.path}: compared by its lines instead\n{line_by_line(call)}")
    print_text("")

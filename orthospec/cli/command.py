"""What all commands share: how one is registered, and how it prints."""

from __future__ import annotations

import functools
import json
import os
import shutil
import sys
from collections.abc import Callable
from typing import Annotated, Any, ParamSpec, TextIO

import typer

from orthospec.guard import exit_code
from orthospec.interrupts import end_as_by_ctrl_c
from orthospec.threads import one_blas_thread

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


def main() -> None:
    """What the installed command calls."""
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="replace")
    one_blas_thread()
    end_as_by_ctrl_c()
    app()


def command(work: Callable[_Arguments, int]) -> Callable[_Arguments, None]:
    """Register a command: its exit code is what it gives back, or that of the error that it raises."""

    @functools.wraps(work)
    def guarded(*args: _Arguments.args, **kwargs: _Arguments.kwargs) -> None:
        raise typer.Exit(exit_code(lambda: work(*args, **kwargs)))

    name = work.__name__.replace("_", "-")
    return app.command(name)(guarded)


def print_text(text: str) -> None:
    """Text to standard output, its last line ended."""
    sys.stdout.write(text if text.endswith("\n") else text + "\n")


def print_json(content: Any) -> None:
    """The same for programs to read."""
    print_text(json.dumps(content, indent=2, ensure_ascii=False))


def format_of(stream: TextIO) -> dict[str, Any]:
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

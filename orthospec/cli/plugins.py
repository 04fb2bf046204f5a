"""The commands on plugins: what is installed, what it is, how to begin one, and the schema of it all."""

from __future__ import annotations

import sys
from typing import Annotated

import typer

from orthospec.cli.command import command, format_of, print_json, print_text
from orthospec.cli.options import Json
from orthospec.guard import DONE


@command
def plugins(as_json: Json = False) -> int:
    """List the installed manipulators and measures."""
    from orthospec.show import installed, show_installed

    entries = installed()
    if as_json:
        print_json(entries)
    else:
        print_text(show_installed(entries, **format_of(sys.stdout)))
    return DONE


@command
def explain(
    name: Annotated[str, typer.Argument(metavar="NAME", help="A manipulator or measure, as specs name it.")],
    as_json: Json = False,
) -> int:
    """Tell what a manipulator or measure is."""
    from orthospec.show import explain as text
    from orthospec.show import explained

    if as_json:
        print_json(explained(name))
        return DONE
    print_text(text(name, **format_of(sys.stdout)))
    return DONE


@command
def new_plugin(
    name: Annotated[str, typer.Argument(metavar="NAME", help="Of the distribution and its new folder.")],
    machine: Annotated[
        bool, typer.Option("--manipulator", help="For a machine; a measure if left out.")
    ] = False,
) -> int:
    """Write a distribution to start a plugin from."""
    from orthospec.starter import write_plugin

    folder = write_plugin(name, "manipulator" if machine else "measure")
    print_text(f"Written to {folder}")
    print_text(
        f"Next: pip install './{folder}[test]', pytest {folder}, orthospec run {folder}/specs/try.yaml"
    )
    return DONE


@command
def schema() -> int:
    """Print the JSON Schema of spec files."""
    from orthospec.spec import schema as content

    print_json(content())
    return DONE

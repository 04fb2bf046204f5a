"""Arguments and options that several commands have."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

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
Quiet = Annotated[bool, typer.Option("-q", "--quiet", help="Tell no progress and no notes; errors still.")]
Verbose = Annotated[bool, typer.Option("-v", "--verbose", help="Tell times and versions at the end.")]

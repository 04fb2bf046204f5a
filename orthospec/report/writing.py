"""Figures for papers: in hand, and as a folder, with the numbers behind them and tables."""

from __future__ import annotations

import csv
import io
import math
import os
import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from orthospec.errors import UsageError
from orthospec.report.canvas import style, written
from orthospec.report.latex import latex
from orthospec.report.palette import LIGHT
from orthospec.report.panels import figures
from orthospec.show.reading import read

if TYPE_CHECKING:
    from orthospec.report.panel import Panel
    from orthospec.solution import Solution

KINDS = ("svg", "pdf", "png")
TABLES = "tables.tex"


def drawings(solution: Solution) -> list[Panel]:
    """All figures of a solution, in the order of the page."""
    return figures(solution, read(solution.result, solution.spec)).every()


def write_figures(solution: Solution, folder: Path) -> list[Path]:
    """Write each figure as SVG, PDF and PNG, its data as CSV, and tables.tex; gives the files.

    Files of the same names are replaced, others are kept. Raises `UsageError` where it cannot be written.
    """
    if folder.exists() and not folder.is_dir():
        raise UsageError(f"{folder}: there is a file of this name; choose another folder")
    reading = read(solution.result, solution.spec)
    with style():
        every = figures(solution, reading).every()
        files = {name: content for one in every for name, content in _files(one)}
    files[TABLES] = latex(reading).encode()
    _put(folder, files)
    return [folder / name for name in files]


def _files(one: Panel) -> Iterator[tuple[str, bytes]]:
    for kind in KINDS:
        yield f"{one.name}.{kind}", written(one.draw(LIGHT), kind)
    yield f"{one.name}.csv", _csv(one).encode()


def _csv(one: Panel) -> str:
    """The numbers behind a figure; a cell is empty where nothing is known."""
    text = io.StringIO(newline="")
    rows = csv.writer(text, lineterminator="\n")
    rows.writerow(one.data)
    for row in zip(*one.data.values(), strict=True):
        rows.writerow(map(_cell, row))
    return text.getvalue()


def _cell(one: object) -> object:
    """Ten significant digits of a number, and nothing for what is not known."""
    if not isinstance(one, float):
        return one
    return "" if math.isnan(one) else f"{one:.10g}"


def _put(folder: Path, files: Mapping[str, bytes]) -> None:
    """All files are written before the first one is put in its place."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(prefix=".orthospec.", dir=folder) as scratch:
            for name, content in files.items():
                (Path(scratch) / name).write_bytes(content)
            for name in files:
                os.replace(Path(scratch) / name, folder / name)
    except OSError as error:
        raise UsageError(f"{folder}: cannot be written: {(error.strerror or str(error)).lower()}") from error

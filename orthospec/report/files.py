"""The figures of a report as files for papers: SVG, PDF and PNG, their numbers as CSV, tables for LaTeX."""

from __future__ import annotations

import csv
import io
from pathlib import Path
from typing import TYPE_CHECKING

from orthospec.errors import UsageError
from orthospec.report import style
from orthospec.report.drawings import drawings
from orthospec.report.latex import latex
from orthospec.report.subject import Subject
from orthospec.report.tables import tables

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from orthospec.report.drawing import Table
    from orthospec.solution import Solution

PRINTED = 300
"""Dots per inch of PNG files."""


def write_figures(solution: Solution, folder: Path) -> list[Path]:
    """Each figure as SVG, PDF and PNG beside a CSV of its numbers, and ``tables.tex``; the files written.

    Files of these names are replaced, others in the folder stay. The same bytes for the same solution and
    versions of the libraries. Raises `UsageError` where the folder cannot be written.
    """
    subject = Subject(solution)
    written = []
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with style.styled():
            for drawing in drawings(subject):
                for suffix, content in _printed(drawing.figure, drawing.name).items():
                    written.append(_write(folder / f"{drawing.name}.{suffix}", content))
                written.append(_write(folder / f"{drawing.name}.csv", _csv(drawing.table)))
        written.append(_write(folder / "tables.tex", latex(list(tables(subject))).encode()))
    except OSError as error:
        raise UsageError(f"{folder}: cannot be written: {(error.strerror or str(error)).lower()}") from error
    return written


def _printed(figure: Figure, name: str) -> dict[str, bytes]:
    pdf, png = io.BytesIO(), io.BytesIO()
    figure.savefig(pdf, format="pdf", metadata={"CreationDate": None, "Creator": None, "Producer": None})
    figure.savefig(png, format="png", dpi=PRINTED, facecolor="white", metadata={"Software": None})
    return {"svg": style.svg(figure, name).encode(), "pdf": pdf.getvalue(), "png": png.getvalue()}


def _csv(table: Table) -> bytes:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(table.head)
    writer.writerows(["" if one is None else one for one in row] for row in table.rows)
    return text.getvalue().encode()


def _write(path: Path, content: bytes) -> Path:
    fresh = path.with_name(f".{path.name}.new")
    fresh.write_bytes(content)
    fresh.replace(path)
    return path

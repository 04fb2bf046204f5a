"""The answer to a what-if, for people and for programs."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from orthospec.show.labels import labels
from orthospec.show.numbers import UNKNOWN, Numbers
from orthospec.show.page import Page
from orthospec.show.words import SIDES

if TYPE_CHECKING:
    from orthospec.optimise.what_if import Answer, Change, Known


def what_if_content(answer: Answer) -> dict[str, Any]:
    """The answer as plain content."""
    content = asdict(answer)
    return {"moved": list(content["moved"]), "joint": content["joint"], "measures": content["measures"]}


def show_what_if(known: Known, answer: Answer, *, width: int, colour: bool) -> str:
    """The answer in words."""
    page = Page(width=width, colour=colour)
    names = labels(known.spec, known.design.values)
    numbers = Numbers(max(known.spec.workspace.size) < 1.0)
    page.heading("What if")
    for move in answer.moved:
        unit = names.measures[move.measure].unit if move.measure in names.measures else UNKNOWN
        before = "no bound" if move.before is None else numbers.value(move.before, unit)
        page.sentence(
            f"{move.measure} {SIDES[move.side]} {numbers.value(move.after, unit)} instead of {before}"
        )
    page.heading("Scale of the largest cuboid, on the grid alone")
    changes: dict[str, Change] = {} if answer.joint is None else {"all measures together": answer.joint}
    changes |= {f"{name} alone": change for name, change in answer.measures.items()}
    page.table(
        ["", "before", "after"], [[k, f"{c.before:.6g}", f"{c.after:.6g}"] for k, c in changes.items()]
    )
    return str(page)

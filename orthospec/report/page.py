"""The report: one page of HTML that needs nothing else, for screens of any size and for paper."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from importlib.resources import files
from typing import TYPE_CHECKING

from orthospec.report import style
from orthospec.report.drawing import Drawing
from orthospec.report.drawings import drawings
from orthospec.report.style import escaped
from orthospec.report.subject import Subject
from orthospec.report.tables import Rows, tables
from orthospec.show import words
from orthospec.show.statements import Statement, statements

if TYPE_CHECKING:
    from orthospec.solution import Solution

HEADINGS = {
    "goals": "Goals",
    "design": "The design",
    "workspace": "Workspace",
    "measures": "Measures",
    "limits": "What limits it, and at what price",
    "conflict": "What conflicts, and what would have to give way",
    "choices": "Choices",
    "pareto": "Pareto set",
    "sweep": "Sweep",
    "search": "The search",
    "failures": "Failures",
    "asked": "What was asked",
    "provenance": "Where it comes from",
}
"""The sections, in order, by the names that ids in the page are made from."""
IN_SECTION = {
    "machine": "design",
    "goals": "goals",
    "prices": "limits",
    "pareto": "pareto",
    "sweep": "sweep",
    "cuboids": "workspace",
    "surfaces": "workspace",
    "convergence": "search",
}
"""Where each drawing stands; those of a measure stand with the measures."""


def report(solution: Solution) -> str:
    """The whole page: the same text for the same solution, on any day.

    It loads nothing, runs no script, and tells no time or place.
    """
    subject = Subject(solution)
    with style.styled():
        figures = {drawing.name: _figure(drawing) for drawing in drawings(subject)}
    sections = {name: "".join(_section(subject, name, figures)) for name in HEADINGS}
    shown = {name: body for name, body in sections.items() if body}
    title = subject.result.title or str(subject.result.manipulator["use"])
    return "\n".join(
        [
            "<!DOCTYPE html>",
            '<html lang="en">',
            "<head>",
            '<meta charset="utf-8">',
            '<meta name="viewport" content="width=device-width, initial-scale=1">',
            '<meta http-equiv="Content-Security-Policy" content="default-src \'none\';'
            " style-src 'unsafe-inline'; img-src data:\">",
            f"<title>{escaped(title)}</title>",
            f"<style>\n{files(__package__).joinpath('page.css').read_text(encoding='utf-8')}</style>",
            "</head>",
            "<body>",
            '<a class="skip" href="#content">To the content</a>',
            f"<header>\n<h1>{escaped(title)}</h1>\n{''.join(_status(subject))}</header>",
            _contents(shown),
            '<main id="content">',
            *(_headed(name, body) for name, body in shown.items()),
            "</main>",
            "</body>",
            "</html>",
            "",
        ]
    )


def summary(solution: Solution) -> str:
    """The status and the tables of goals, design and limits, to stand in another page: a notebook's, say."""
    subject = Subject(solution)
    shown = [rows for rows in tables(subject) if rows.name in ("goals", "variables", "measures", "limits")]
    title = subject.result.title or str(subject.result.manipulator["use"])
    parts = [f"<p><strong>{escaped(title)}</strong><br>{escaped(words.status(subject.result)[1])}</p>"]
    return "<div>" + "\n".join([*parts, *(_table(rows) for rows in shown)]) + "</div>"


def _status(subject: Subject) -> Iterator[str]:
    manner, said = words.status(subject.result)
    yield f'<p class="status {manner}">{escaped(said)}</p>\n'
    if subject.result.search is not None:
        yield f'<p class="muted">{escaped(words.searched(subject.result.search))}</p>\n'


def _contents(sections: Iterable[str]) -> str:
    links = "".join(f'<li><a href="#{name}">{escaped(HEADINGS[name])}</a></li>' for name in sections)
    return f'<nav aria-label="Contents"><ul>{links}</ul></nav>'


def _headed(name: str, body: str) -> str:
    heading = f'<h2 id="{name}">{escaped(HEADINGS[name])}</h2>'
    return f'<section aria-labelledby="{name}">\n{heading}\n{body}</section>'


def _section(subject: Subject, name: str, figures: dict[str, str]) -> Iterator[str]:
    for one in statements(subject.result, subject.known, subject.numbers):
        if one.section == name:
            yield _statement(one)
    for rows in tables(subject):
        if rows.section == name:
            yield _table(rows)
    for drawing, figure in figures.items():
        if IN_SECTION.get(drawing, "measures") == name:
            yield figure
    spec = subject.solution.spec
    if name == "asked" and spec is not None:
        source = f'<pre tabindex="0">{escaped(spec.source)}</pre>'
        yield f"<details><summary>The spec as it was run</summary>\n{source}</details>\n"


def _statement(one: Statement) -> str:
    manner = f' class="{one.manner}"' if one.manner else ""
    text = f"<span{manner}>{escaped(one.text)}</span>" if manner else escaped(one.text)
    return f"<p>{text}</p>\n"


def _table(rows: Rows) -> str:
    head = "".join(
        f'<th scope="col"{_class(k in rows.right)}>{escaped(text) or "<span class=muted>&nbsp;</span>"}</th>'
        for k, text in enumerate(rows.head)
    )
    body = "".join(_row(rows, row) for row in rows.rows)
    whole = f"<thead><tr>{head}</tr></thead>" if any(rows.head) else ""
    return (
        f'<div class="scroll" tabindex="0" role="region" aria-label="{escaped(rows.caption)}">'
        f"<table>{whole}<tbody>{body}</tbody></table></div>\n"
    )


def _row(rows: Rows, row: Sequence[str]) -> str:
    first, *rest = row
    cells = "".join(
        f"<td{_class(k in rows.right)}>{escaped(text)}</td>" for k, text in enumerate(rest, start=1)
    )
    manner = ' class="knee"' if first.endswith("knee") else ""
    return f'<tr{manner}><th scope="row">{escaped(first)}</th>{cells}</tr>'


def _class(right: bool) -> str:
    return ' class="number"' if right else ""


def _figure(drawing: Drawing) -> str:
    text = style.inline_svg(drawing.figure, drawing.name, drawing.words)
    for mark, hint in drawing.hints.items():
        said = f'class="mark" tabindex="0" role="img" aria-label="{escaped(hint)}"'
        opening = f'<g id="{drawing.name}-{mark}">'
        text = text.replace(opening, f"{opening[:-1]} {said}><title>{escaped(hint)}</title>", 1)
    if drawing.hints:  # What is inside an image cannot be reached by the keyboard.
        text = text.replace('<svg role="img"', '<svg role="group"', 1)
    caption = f"<figcaption>{escaped(drawing.caption)}</figcaption>"
    return f'<figure class="wide" id="figure-{drawing.name}">{text}{caption}</figure>\n'

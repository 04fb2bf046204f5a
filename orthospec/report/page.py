"""One self-contained page: what was asked, what came out, what limits it, and where it comes from.

No script, no request, no time and no path: the same bytes for the same result. Figures take their colours
from the style sheet, light or dark; in a narrow window they stand below each other, and tables scroll.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from orthospec.report import sections
from orthospec.report.asked import asked
from orthospec.report.canvas import inlined, style
from orthospec.report.palette import DARK, LIGHT, PAGE, properties
from orthospec.report.panels import Figures, figures
from orthospec.show import tables, words
from orthospec.show.reading import Reading, read

if TYPE_CHECKING:
    from orthospec.report.panel import Panel
    from orthospec.solution import Solution

_TEMPLATES = Path(__file__).parent / "templates"


@dataclass(frozen=True)
class Drawn:
    """A figure and its element."""

    panel: Panel
    svg: Any


def report(solution: Solution) -> str:
    """The whole page as HTML."""
    reading = read(solution.result, solution.spec)
    with style():
        content = _content(solution, reading, figures(solution, reading))
    return _rendered("report.html", content)


def summary(solution: Solution) -> str:
    """The status with the main tables, to stand in another page: a notebook's, say."""
    reading = read(solution.result, solution.spec)
    goals = [[one.name, one.value, one.goal, one.verdict] for one in tables.goals(reading)]
    measures = [
        [f"{name}, {row[0]}", *row[1:]]
        for name, record in reading.result.workspace.measures.items()
        for row in tables.measure(reading, name, record)
    ]
    limits = sections.limits(reading)
    every = [
        tables.Table(["goal", "value", "aimed at", ""], goals),
        tables.Table(["variable", "value", "range"], tables.variables(reading)),
        tables.Table(["measure", "value", ""], measures),
        *([limits["table"]] if limits else []),
    ]
    content = {"title": _title(reading), "status": words.status(reading.result)}
    return _rendered("summary.html", {**content, "tables": [one for one in every if one.rows]})


def _title(reading: Reading) -> str:
    return reading.result.title or str(reading.result.manipulator["use"])


def _rendered(template: str, content: dict[str, Any]) -> str:
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    environment = Environment(
        loader=FileSystemLoader(_TEMPLATES),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=StrictUndefined,
    )
    text: str = environment.get_template(template).render(content)
    return text.lstrip()


def style_sheet() -> str:
    """Colours for both schemes and for paper, then the rules."""
    light = f":root{{{properties(LIGHT)}--bad:#b3261e;--raised:#f5f6f8}}"
    dark = f":root{{{properties(DARK)}--bad:#ff8a80;--raised:#20252b}}"
    rules = (_TEMPLATES / "report.css").read_text(encoding="utf-8")
    schemes = f"{light}@media screen and (prefers-color-scheme:dark){{{dark}}}"
    return f":root{{color-scheme:light dark}}{schemes}\n{rules}"


def _content(solution: Solution, reading: Reading, shown: Figures) -> dict[str, Any]:
    from markupsafe import Markup

    def drawn(several: list[Panel]) -> list[Drawn]:
        return [Drawn(one, Markup(inlined(one.draw(PAGE), one.name))) for one in several]

    result, spec = reading.result, solution.spec
    alone = ("machine", "cuboids", "limits", "pareto", "sweep", "convergence")
    content: dict[str, Any] = {
        "style": Markup(style_sheet()),
        "title": _title(reading),
        "status": words.status(result),
        "searched": words.searched(result),
        "errors": [words.told(error) for error in result.errors],
        "notes": [words.told(note) for note in result.notes],
        "goals": sections.goals(reading),
        "variables": sections.variables(reading),
        "asked": asked(spec, reading) if spec else [],
        "spec": spec.source if spec else "",
        "machine_heading": tables.machine_heading(reading),
        "machine": tables.machine(reading),
        "places": sections.places(reading),
        "measures_heading": tables.measures_heading(reading),
        "measures": sections.measures(reading),
        "limits": sections.limits(reading),
        "card": sections.card(reading),
        "branches": tables.branches(reading),
        "pareto": sections.pareto(reading),
        "sweep": sections.sweep(reading),
        "drawn": {name: drawn(getattr(shown, name)) for name in alone},
        "fields": [{"title": one.title, "drawn": drawn(one.panels)} for one in shown.fields],
        "in_space": any(shown.in_space),
        "not_shown": shown.not_shown,
        "search": sections.search(reading),
        "provenance": sections.provenance(reading),
    }
    return {**content, "contents": _contents(content)}


def _contents(content: dict[str, Any]) -> list[tuple[str, str]]:
    """The sections that are there, in the page's order."""
    every = [
        ("failures", "Failures", content["errors"]),
        ("notes", "Notes", content["notes"]),
        ("found", "What came out", content["goals"] or content["variables"]),
        ("card", "What would have to give way", content["card"]),
        ("asked", "What was asked", True),
        ("machine", "Machine", True),
        ("workspace", "Workspace", True),
        ("measures", "Measures", content["measures"]),
        ("limits-section", content["limits"]["heading"] if content["limits"] else "", content["limits"]),
        ("choices", "Choices", content["branches"]),
        ("pareto", "Pareto set", content["pareto"]),
        ("sweep", "Sweep", content["sweep"]),
        ("fields", "Fields", content["fields"] or content["not_shown"]),
        ("search", "Search", content["search"]),
        ("provenance", "Provenance", True),
    ]
    return [(key, heading) for key, heading, there in every if there]

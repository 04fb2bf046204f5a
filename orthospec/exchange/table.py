"""All designs of a result as one table: the one found, of a Pareto set, of a sweep, and combinations."""

from __future__ import annotations

import csv
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from orthospec.report.subject import Subject

if TYPE_CHECKING:
    from orthospec.result.model import AttainmentRecord, DesignRecord
    from orthospec.solution import Solution


def write(solution: Solution, name: str, file: Path) -> None:  # noqa: ARG001
    """One row a design, SI, units in the head; a number reads back exactly, what is not known is empty."""
    rows = list(_rows(Subject(solution)))
    head = list(dict.fromkeys(key for row in rows for key in row))
    with file.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.DictWriter(stream, head, lineterminator="\n")
        writer.writeheader()
        writer.writerows({key: "" if value is None else value for key, value in row.items()} for row in rows)


def _rows(subject: Subject) -> Iterator[dict[str, Any]]:
    result = subject.result
    factor = result.attainment
    yield {"design": result.status, **_row(subject, result, factor)}
    for number, point in enumerate(result.pareto, start=1):
        yield {"design": f"pareto {number}", **_row(subject, point, point.attainment)}
    for number, swept in enumerate(result.sweep, start=1):
        yield {"design": f"sweep {number}", **_row(subject, swept, None)}
    branches = result.search.branches if result.search else []
    for number, one in enumerate(branches, start=1):
        yield {"design": f"choice {number}", **one.choices, "λ": one.factor}


def _row(subject: Subject, one: DesignRecord, attainment: AttainmentRecord | None) -> dict[str, Any]:
    workspace, design = one.workspace, subject.design
    of_indices = design.manipulator.index_units if design else {}
    of_measures = {demand.name: demand.measure.unit for demand in design.demands} if design else {}
    row: dict[str, Any] = dict(one.variables)
    row["λ"] = attainment.factor if attainment else None
    for name, goal in (attainment.goals if attainment else {}).items():
        row[f"goal {name}"] = goal.value
    for name, value in one.indices.items():
        row[_with_unit(name, of_indices.get(name, ""))] = value
    row["scale"] = workspace.joint.scale if workspace.joint else None
    row["holds"] = "" if workspace.prescribed is None else ("yes" if workspace.prescribed.holds else "no")
    for name, record in workspace.measures.items():
        for end, extreme in (("lowest", record.lowest), ("highest", record.highest)):
            row[_with_unit(f"{name} {end}", of_measures.get(name, ""))] = extreme.value if extreme else None
    return row


def _with_unit(name: str, unit: str) -> str:
    return f"{name} [{unit}]" if unit not in ("", "1", "?") else name

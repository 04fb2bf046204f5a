"""The sections of a report as plain data: rows, sentences and bars."""

from __future__ import annotations

from typing import Any

from orthospec.report.bars import beside_goal, in_range
from orthospec.result.model import LargestRecord, MeasureRecord, PrescribedRecord
from orthospec.show import tables, words
from orthospec.show.numbers import NOTHING
from orthospec.show.reading import Reading

MOST_POSES = 3
"""Of one limit that are listed."""


def goals(reading: Reading) -> list[tuple[tables.GoalRow, Any]]:
    """Each goal with its bar."""
    attainment = reading.result.attainment
    records = list(attainment.goals.values()) if attainment else []
    return [
        (
            row,
            beside_goal(one.value, one.goal, row.manner, f"{row.value}, aimed at {row.goal}, {row.verdict}"),
        )
        for row, one in zip(tables.goals(reading), records, strict=True)
    ]


def variables(reading: Reading) -> list[tuple[tuple[str, str, str], Any]]:
    """Each design variable, and where it stands."""
    found = []
    for row in tables.variables(reading):
        variable = reading.known.ranges.get(row[0])
        value, told = reading.result.variables[row[0]], f"{row[1]}, {row[2]}"
        found.append((row, in_range(value, variable, told) if variable else None))
    return found


def places(reading: Reading) -> list[dict[str, Any]]:
    """The prescribed and the largest cuboid of all measures together, or where each stands alone."""
    workspace = reading.result.workspace
    found = []
    if workspace.prescribed is not None:
        found.append({"title": "Prescribed cuboid", **_prescribed(reading, workspace.prescribed)})
    elif workspace.joint is not None:
        found.append({"title": "Prescribed cuboid", **_facts(words.NO_PLACE)})
    if workspace.joint is not None:
        found.append({"title": "Largest cuboid", **_largest(reading, workspace.joint)})
    else:
        found.append({"title": "Cuboids", **_facts("one for each measure: see below")})
    return found


def _facts(size: str, **more: Any) -> dict[str, Any]:
    return {"size": size, "holding": None, "low": "", "high": "", "sentences": [], "proof": None, **more}


def _prescribed(reading: Reading, place: PrescribedRecord) -> dict[str, Any]:
    numbers, axes = reading.numbers, reading.known.axes
    return _facts(
        tables.prescribed(reading, place),
        holding=words.holding(place),
        low=numbers.pose(place.min, axes),
        high=numbers.pose(place.max, axes),
        proof=tables.proof(reading, place.proof) if place.proof else None,
    )


def _largest(reading: Reading, one: LargestRecord) -> dict[str, Any]:
    numbers, axes = reading.numbers, reading.known.axes
    return _facts(
        tables.largest(reading, one),
        low=numbers.pose(one.min, axes) if one.min is not None else "",
        high=numbers.pose(one.max, axes) if one.max is not None else "",
        sentences=list(tables.on_the_grid(one)),
    )


def measures(reading: Reading) -> list[dict[str, Any]]:
    """What each measure comes to over its prescribed cuboid."""
    return [_measure(reading, name, one) for name, one in reading.result.workspace.measures.items()]


def _measure(reading: Reading, name: str, record: MeasureRecord) -> dict[str, Any]:
    asked_for = reading.known.measures.get(name)
    rows = [*tables.measure(reading, name, record)]
    rows += [(which, value, "") for which, value in tables.at_poses(reading, name, record)]
    return {
        "name": name,
        "title": words.asked(name, asked_for, reading.numbers) if asked_for else name,
        "rows": rows,
        "place": _prescribed(reading, record.prescribed) if record.prescribed else None,
    }


def limits(reading: Reading) -> dict[str, Any] | None:
    """What binds, and what one per cent is worth; None where nothing does."""
    result, known, numbers = reading.result, reading.known, reading.numbers
    if not result.limits:
        return None
    every = words.together(result.limits)
    priced = any(words.price(one) for one in every)
    rows = []
    for one in every:
        poses = list(dict.fromkeys(numbers.pose(pose, known.axes) for pose in one.at))
        more = f" and {len(poses) - MOST_POSES} more" if len(poses) > MOST_POSES else ""
        where = "; ".join(poses[:MOST_POSES]) + more or NOTHING
        rows.append([words.limiting(one, known, numbers), *(words.prices(one) if priced else ()), where])
    head = ["limit", *(("1 % looser", "1 % tighter") if priced else ()), "where it binds"]
    return {
        "heading": words.limits_heading(result),
        "table": tables.Table(head, rows),
        "words": [len(head) - 1],
        "free": words.reached_too(result.limits, known, numbers),
    }


def card(reading: Reading) -> dict[str, Any] | None:
    """What would have to give way; None where a design was found."""
    search = reading.result.search
    if search is None or search.card is None:
        return None
    ways = [(*words.way_out(one, reading.known, reading.numbers), one.place) for one in search.card.conflict]
    return {"said": words.conflict(search.card), "ways": ways, "others": words.ways_out(search.card)}


def pareto(reading: Reading) -> dict[str, Any] | None:
    """The Pareto set as a table; None without one."""
    front, search = reading.result.pareto, reading.result.search
    if not front:
        return None
    return {
        "heading": f"Pareto set: {words.counted(len(front), 'design')}",
        "said": words.searched_for_front(search.pareto) if search and search.pareto else "",
        "table": tables.pareto(reading),
    }


def sweep(reading: Reading) -> dict[str, Any] | None:
    """The sweep as a table; None without one."""
    if not reading.result.sweep:
        return None
    along = ", ".join(tables.varied(reading.result.sweep))
    return {"heading": f"Sweep along {along}", "table": tables.sweep(reading)}


def search(reading: Reading) -> dict[str, Any] | None:
    """The steps of the solve that was kept; None where nothing was searched."""
    search = reading.result.search
    if search is None:
        return None
    rows = [
        [
            str(one.subproblems),
            NOTHING if one.factor is None else f"{one.factor:.6g}",
            NOTHING if one.violation is None else f"{one.violation:.3g}",
        ]
        for one in search.steps
    ]
    return {"table": tables.Table(["subproblem", "λ", "violation"], rows) if rows else None}


def provenance(reading: Reading) -> list[tuple[str, str]]:
    """Versions, hashes and plugins."""
    known = reading.result.provenance
    rows = [("orthospec", str(known.get("orthospec", NOTHING)))]
    rows.append(("SHA-256 of the spec's content", str(known.get("spec_sha256", NOTHING))))
    source = known.get("from")
    if source:
        rows.append((f"machine from {source['path']}, SHA-256", str(source["sha256"])))
    rows += [(f"plugin {name}", str(version)) for name, version in (known.get("plugins") or {}).items()]
    return rows

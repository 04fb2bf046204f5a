"""The tables of a report: rows of text, as the terminal aligns them and a page sets them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from orthospec.report.subject import Subject
from orthospec.show import machine, words
from orthospec.show.numbers import NOTHING, UNKNOWN

if TYPE_CHECKING:
    from orthospec.result.model import DesignRecord, MeasureRecord, ParetoRecord


@dataclass(frozen=True)
class Rows:
    """One table."""

    name: str
    section: str
    caption: str
    head: Sequence[str]
    rows: Sequence[Sequence[str]]
    right: frozenset[int] = frozenset()
    """Columns of numbers."""


def tables(subject: Subject) -> Iterator[Rows]:
    """Those that have rows."""
    makers = (
        _goals,
        _variables,
        _machine,
        _measures,
        _limits,
        _conflict,
        _branches,
        _pareto,
        _sweep,
        _provenance,
    )
    for make in makers:
        rows = make(subject)
        if rows.rows:
            yield rows


def _goals(subject: Subject) -> Rows:
    attainment, rows = subject.result.attainment, []
    for name, goal in (attainment.goals if attainment else {}).items():
        aim = subject.known.goals.get(name)
        unit = aim.unit if aim else UNKNOWN
        gap = None if goal.value is None else abs(goal.value - goal.goal)
        verdict = "met" if goal.attained else f"missed by {subject.numbers.value(gap, unit)}"
        value, target = (subject.numbers.value(one, unit) for one in (goal.value, goal.goal))
        rows.append((name, value, target, words.weight(goal.weight, aim), verdict, aim.words if aim else ""))
    head = ("goal", "value", "aimed at", "weight", "", "asked")
    return Rows("goals", "goals", "Goals", head, rows, frozenset({1, 2, 3}))


def _variables(subject: Subject) -> Rows:
    rows = []
    for name, value in subject.result.variables.items():
        unit, range_ = subject.known.variables.get(name, UNKNOWN), subject.known.ranges.get(name)
        within = words.within(range_, unit, subject.numbers) if range_ else ""
        rows.append((name, subject.numbers.value(value, unit), within))
    return Rows("variables", "design", "Design variables", ("variable", "value", ""), rows, frozenset({1}))


def _machine(subject: Subject) -> Rows:
    known, numbers = subject.known, subject.numbers
    keys = {key: value for key, value in subject.result.manipulator.items() if key != "use"}
    rows = [
        ("machine", str(subject.result.manipulator["use"])),
        *machine.fields(keys, known.fields, numbers),
        *machine.tolerances(known.tolerances, known.fields, numbers),
        *machine.indices(subject.result.indices, known.indices, numbers),
    ]
    joints = subject.result.joints
    if joints is not None:
        units = (*known.joints, *[UNKNOWN] * len(joints.min))
        for k, (low, high, unit) in enumerate(zip(joints.min, joints.max, units, strict=False), start=1):
            rows.append((f"joint {k}", numbers.interval(low, high, unit)))
    return Rows("machine", "design", "The machine", ("", ""), rows)


def _measures(subject: Subject) -> Rows:
    rows = []
    for name, record in subject.result.workspace.measures.items():
        asked = subject.known.measures.get(name)
        unit = asked.unit if asked else UNKNOWN
        bound = words.bounds(subject.numbers, asked.bounds, unit) if asked else ""
        rows.append((name, *_ends(subject, record, unit), bound or NOTHING, _number(record.scale)))
        for level in record.levels:
            given = {side: getattr(level, side) for side in words.SIDES}
            said = words.bounds(subject.numbers, given, unit)
            rows.append((f"{name}, level", "", "", "", "", said, _number(level.scale)))
        for pose, values in record.poses.items():
            at = words.at_pose(subject.numbers, values, unit)
            rows.append((f"{name} at {pose}", at, "", "", "", "", ""))
    head = ("measure", "lowest", "at", "highest", "at", "bound", "own scale")
    return Rows(
        "measures", "measures", "Measures over the prescribed cuboid", head, rows, frozenset({1, 3, 6})
    )


def _ends(subject: Subject, record: MeasureRecord, unit: str) -> Iterator[str]:
    for extreme in (record.lowest, record.highest):
        yield subject.numbers.value(extreme.value if extreme else None, unit)
        yield subject.numbers.pose(extreme.at, subject.known.axes) if extreme else "out of reach"


def _number(value: float | None) -> str:
    return "" if value is None else f"{value:.6g}"


def _limits(subject: Subject) -> Rows:
    rows = []
    for limit in words.together(subject.result.limits):
        poses = list(dict.fromkeys(subject.numbers.pose(pose, subject.known.axes) for pose in limit.at))
        few = "; ".join(poses[:2]) + (f"; and {len(poses) - 2} more" if len(poses) > 2 else "")
        rows.append((words.limiting(limit, subject.known, subject.numbers), words.price(limit), few))
    conflict = subject.result.status == "infeasible"
    head = ("limit", "what one per cent is worth", "at")
    return Rows("limits", "conflict" if conflict else "limits", "Limits", head, rows)


def _conflict(subject: Subject) -> Rows:
    card = subject.result.search.card if subject.result.search else None
    rows = [
        (*words.way_out(one, subject.known, subject.numbers), one.place)
        for one in (card.conflict if card else [])
    ]
    return Rows("conflict", "conflict", "What would have to give way", ("condition", "", "in the spec"), rows)


def _branches(subject: Subject) -> Rows:
    search = subject.result.search
    branches = search.branches if search else []
    names = list(branches[0].choices) if branches else []
    rows = []
    for one in branches:
        told = [subject.numbers.value(one.choices[n], subject.known.variables.get(n, UNKNOWN)) for n in names]
        rows.append([*told, words.branch(one), words.behind(one, branches[0])])
    return Rows("choices", "choices", "Combinations of choices", (*names, "λ", ""), rows)


def _pareto(subject: Subject) -> Rows:
    front = subject.result.pareto
    goals = [
        n for n, g in (front[0].attainment.goals if front and front[0].attainment else {}).items() if g.weight
    ]
    names = list(front[0].variables) if front else []
    rows = [
        (f"{k} knee" if one.knee else f"{k}", *_design(subject, one, goals, names))
        for k, one in enumerate(front, start=1)
    ]
    head = ("design", *goals, *names)
    return Rows(
        "pareto", "pareto", "The designs of the Pareto set", head, rows, frozenset(range(1, len(head)))
    )


def _design(subject: Subject, one: ParetoRecord, goals: list[str], names: list[str]) -> Iterator[str]:
    known, numbers = subject.known, subject.numbers
    for name in goals:
        value = one.attainment.goals[name].value if one.attainment else None
        yield numbers.value(value, known.goals[name].unit if name in known.goals else UNKNOWN)
    for name in names:
        yield numbers.value(one.variables[name], known.variables.get(name, UNKNOWN))


def _sweep(subject: Subject) -> Rows:
    points = subject.result.sweep
    names = (
        [n for n in points[0].variables if len({p.variables.get(n) for p in points}) > 1] if points else []
    )
    head = [*names, "holds", "scale"]
    for name in points[0].workspace.measures if points else ():
        head += [f"{name} lowest", f"{name} highest"]
    rows = [_swept(subject, point, names) for point in points]
    return Rows("sweep", "sweep", "The points of the sweep", head, rows, frozenset(range(2, len(head))))


def _swept(subject: Subject, point: DesignRecord, names: list[str]) -> list[str]:
    known, numbers, workspace = subject.known, subject.numbers, point.workspace
    row = [numbers.value(point.variables.get(n), known.variables.get(n, UNKNOWN)) for n in names]
    row += [
        "yes" if words.holds(point) else "no",
        _number(workspace.joint.scale if workspace.joint else None),
    ]
    for name, record in workspace.measures.items():
        unit = known.measures[name].unit if name in known.measures else UNKNOWN
        row += [numbers.value(end.value if end else None, unit) for end in (record.lowest, record.highest)]
    return row


def _provenance(subject: Subject) -> Rows:
    told = subject.result.provenance
    rows = [("orthospec", str(told.get("orthospec", NOTHING)))]
    rows += [(f"plugin {name}", str(version)) for name, version in (told.get("plugins") or {}).items()]
    source = told.get("from")
    if source:
        rows.append(("machine from", f"{source['path']}, SHA-256 {source['sha256']}"))
    if "spec_sha256" in told:
        rows.append(("spec, SHA-256", str(told["spec_sha256"])))
    return Rows("provenance", "provenance", "Versions and hashes", ("", ""), rows)

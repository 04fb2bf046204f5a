"""The rows of a result: what text, page and papers have in common, cell by cell."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

from orthospec.result.model import (
    DesignRecord,
    Ends,
    LargestRecord,
    MeasureRecord,
    ParetoRecord,
    PrescribedRecord,
    ProofRecord,
)
from orthospec.show import machine as parts
from orthospec.show import words
from orthospec.show.labels import Field
from orthospec.show.numbers import UNKNOWN
from orthospec.show.reading import Reading


class Table(NamedTuple):
    """Rows under a head, whose first cell is empty where the first column are the rows' names."""

    head: Sequence[str]
    rows: Sequence[Sequence[str]]


class GoalRow(NamedTuple):
    """A goal: what came out beside what was aimed at, in words."""

    name: str
    value: str
    goal: str
    weight: str
    manner: str
    verdict: str
    words: str


def goals(reading: Reading) -> list[GoalRow]:
    """A row a goal, in the spec's order."""
    attainment, numbers, rows = reading.result.attainment, reading.numbers, []
    for name, goal in (attainment.goals if attainment else {}).items():
        aim, unit = reading.known.goals.get(name), reading.unit_of_goal(name)
        gap = None if goal.value is None else abs(goal.value - goal.goal)
        missed = "missed" if gap is None else f"missed by {numbers.value(gap, unit)}"
        rows.append(
            GoalRow(
                name,
                numbers.value(goal.value, unit),
                numbers.value(goal.goal, unit),
                words.weight(goal.weight, aim),
                "good" if goal.attained else "warn",
                "met" if goal.attained else missed,
                aim.words if aim else "",
            )
        )
    return rows


def variables(reading: Reading) -> list[tuple[str, str, str]]:
    """Name, value and range of each design variable."""
    rows = []
    for name, value in reading.result.variables.items():
        unit, range_ = reading.unit_of_variable(name), reading.known.ranges.get(name)
        within = words.within(range_, unit, reading.numbers) if range_ else ""
        rows.append((name, reading.numbers.value(value, unit), within))
    return rows


def machine_heading(reading: Reading) -> str:
    """Which machine it is, and which result it was taken from."""
    source = reading.result.provenance.get("from")
    return f"Machine: {reading.result.manipulator['use']}" + (f", from {source['path']}" if source else "")


def machine(reading: Reading) -> list[tuple[str, str]]:
    """What a drawing or an order needs: fields, tolerances, indices and the joints' ranges."""
    result, known, numbers = reading.result, reading.known, reading.numbers
    keys = {name: value for name, value in result.manipulator.items() if name != "use"}
    return [
        *parts.fields(keys, known.fields, numbers),
        *parts.tolerances(known.tolerances, known.fields, numbers),
        *parts.indices(result.indices, known.indices, numbers),
        *(_joints(reading, result.joints) if result.joints else ()),
    ]


def _joints(reading: Reading, joints: Ends) -> Iterator[tuple[str, str]]:
    """The range of each joint over the prescribed cuboid; equal ones in one line."""
    units = (*reading.known.joints, *[UNKNOWN] * len(joints.min))
    texts = [reading.numbers.interval(*end) for end in zip(joints.min, joints.max, units, strict=False)]
    for text in dict.fromkeys(texts):
        which = [str(k) for k, other in enumerate(texts, start=1) if other == text]
        yield f"joint{'s' if len(which) > 1 else ''} {', '.join(which)}", text


def prescribed(reading: Reading, place: PrescribedRecord) -> str:
    """Size of the prescribed cuboid where it stands, with its scale where that is another one."""
    size = reading.numbers.edges(place.min, place.max, reading.known.axes)
    return size if place.scale == 1 else f"{size},{words.scaled(place.scale)}"


def measures_heading(reading: Reading) -> str:
    """What the measures are told over."""
    return f"Measures over the prescribed cuboid{words.scaled(words.cuboid_scale(reading.result))}"


def largest(reading: Reading, one: LargestRecord) -> str:
    """Size and scale of a largest cuboid."""
    if one.min is None or one.max is None:
        return "none"
    return f"{reading.numbers.edges(one.min, one.max, reading.known.axes)}, scale {one.scale:.6g}"


def on_the_grid(one: LargestRecord) -> Iterator[str]:
    """What is known of a largest cuboid from the grid and from proof, a sentence each."""
    places = f" in {one.ties} places" if one.ties > 1 else ""
    yield f"on the grid alone: scale {one.grid_scale:.6g}{places}"
    yield f"nodes: {words.nodes(one.nodes)}"
    if one.proved is not None:
        yield f"proved of the scale: {words.between(one.proved)}"


def proof(reading: Reading, one: ProofRecord) -> tuple[str, str]:
    """In which manner, and with which words, a verdict is told."""
    at = None if one.at is None else reading.numbers.pose(one.at, reading.known.axes)
    for name, values in (one.machine or {}).items():
        units = reading.known.fields.get((name,), Field()).units or (UNKNOWN,)
        at = f"{at} with {name} {reading.numbers.several(values, units[0])}"
    return words.proof(one, at)


def measure(reading: Reading, name: str, record: MeasureRecord) -> Iterator[tuple[str, str, str]]:
    """Extremes of a measure over its prescribed cuboid, its own largest cuboid and those of its levels."""
    numbers, unit = reading.numbers, reading.unit_of_measure(name)
    for which, extreme in (("lowest", record.lowest), ("highest", record.highest)):
        at = f"at {numbers.pose(extreme.at, reading.known.axes)}" if extreme else "not known: out of reach"
        yield which, numbers.value(extreme.value if extreme else None, unit), at
    if record.scale is not None and record.grid_scale is not None:
        yield "own scale", f"{record.scale:.6g}", f"on the grid alone {record.grid_scale:.6g}"
        if record.proved is not None and reading.result.workspace.joint is None:
            yield "", "", f"proved {words.between(record.proved)}"
    for level in record.levels:
        bound = words.bounds(numbers, {side: getattr(level, side) for side in words.SIDES}, unit)
        yield f"scale, {bound}", f"{level.scale:.6g}", f"on the grid alone {level.grid_scale:.6g}"


def at_poses(reading: Reading, name: str, record: MeasureRecord) -> Iterator[tuple[str, str]]:
    """A measure's values at the named poses."""
    for pose, values in record.poses.items():
        yield f"at {pose}", words.at_pose(reading.numbers, values, reading.unit_of_measure(name))


def soft_goals(front: Sequence[ParetoRecord]) -> list[str]:
    """The goals that a Pareto set is about."""
    attainment = front[0].attainment if front else None
    return [name for name, goal in (attainment.goals if attainment else {}).items() if goal.weight]


def pareto(reading: Reading) -> Table:
    """One row a design: the goals, then the variables."""
    front, numbers = reading.result.pareto, reading.numbers
    soft, names, rows = soft_goals(front), list(front[0].variables), []
    for number, one in enumerate(front, start=1):
        values = one.attainment.goals if one.attainment else {}
        row = [numbers.value(values[name].value, reading.unit_of_goal(name)) for name in soft]
        row += [numbers.value(one.variables[name], reading.unit_of_variable(name)) for name in names]
        rows.append([f"{number} knee" if one.knee else f"{number}", *row])
    return Table(["", *soft, *names], rows)


def branches(reading: Reading) -> tuple[str, Table] | None:
    """What each combination of choices came to, with what was left out of them; None without catalogues."""
    search = reading.result.search
    if search is None or not search.branches:
        return None
    left_out = (search.combinations or 0) - len(search.branches)
    said = f"Of {search.combinations} combinations the {len(search.branches)} best on a coarse grid."
    names, rows = list(search.branches[0].choices), []
    for one in search.branches:
        values = [reading.numbers.value(one.choices[name], reading.unit_of_variable(name)) for name in names]
        rows.append([*values, words.branch(one), words.behind(one, search.branches[0])])
    return said if left_out else "", Table([*names, "λ", ""], rows)


def varied(sweep: Sequence[DesignRecord]) -> list[str]:
    """The variables that differ along a sweep."""
    return [name for name in sweep[0].variables if len({one.variables.get(name) for one in sweep}) > 1]


def sweep(reading: Reading) -> Table:
    """One row a value of what varies."""
    every = reading.result.sweep
    names, first = varied(every), every[0].workspace
    head = [*names, "holds", *(["scale"] if first.joint else [])]
    for name, record in first.measures.items():
        head += [f"{name} lowest", f"{name} highest", *(f"{name} at {pose}" for pose in record.poses)]
    return Table(head, [_swept(reading, one, names) for one in every])


def _swept(reading: Reading, one: DesignRecord, names: list[str]) -> list[str]:
    numbers, workspace = reading.numbers, one.workspace
    row = [numbers.value(one.variables.get(name), reading.unit_of_variable(name)) for name in names]
    row.append("yes" if words.holds(one) else "no")
    if workspace.joint is not None:
        row.append(f"{workspace.joint.scale:.6g}")
    for name, record in workspace.measures.items():
        unit = reading.unit_of_measure(name)
        ends = [end.value if end else None for end in (record.lowest, record.highest)]
        row += [numbers.value(end, unit) for end in ends]
        row += [words.at_pose(numbers, values, unit) for values in record.poses.values()]
    return row

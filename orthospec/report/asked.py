"""What a spec asks, in words."""

from __future__ import annotations

from typing import TYPE_CHECKING

from orthospec.show import words

if TYPE_CHECKING:
    from orthospec.show.reading import Reading
    from orthospec.spec import Spec

Asked = list[tuple[str, list[str]]]


def asked(spec: Spec, reading: Reading) -> Asked:
    """Headings with sentences; those that say nothing are left out."""
    every = [
        ("What must hold", _bounds(spec, reading)),
        ("What is aimed at", _goals(reading)),
        ("What may be chosen", _variables(reading)),
        ("What more is told", _more(spec, reading)),
    ]
    return [(heading, lines) for heading, lines in every if lines]


def _bounds(spec: Spec, reading: Reading) -> list[str]:
    numbers, known, workspace = reading.numbers, reading.known, spec.workspace
    size = numbers.edges([0.0] * len(workspace.size), workspace.size, known.axes)
    each = "" if workspace.together else ", one for each measure"
    lines = [f"a cuboid of {size}{each}, in reach everywhere"]
    if workspace.region is not None:
        ends = (numbers.pose(end, known.axes) for end in (workspace.region.min, workspace.region.max))
        lines.append(f"looked for from {' to '.join(ends)}")
    lines += [words.asked(name, one, numbers) for name, one in known.measures.items()]
    for name, off in known.tolerances.items():
        lines.append(f"for every machine whose {name} are off by no more than {numbers.value(off, 'm')}")
    return lines


def _goals(reading: Reading) -> list[str]:
    attainment, lines = reading.result.attainment, []
    for name, aim in reading.known.goals.items():
        goal = attainment.goals.get(name) if attainment else None
        told = f", to {reading.numbers.value(goal.goal, aim.unit)}" if goal else ""
        lines.append(f"{name}: {aim.words}{told}, {_weight(goal.weight if goal else None, aim.relative)}")
    return lines


def _weight(weight: float | None, relative: bool) -> str:
    if weight == 0:
        return "a hard bound"
    return "weight relative to the goal" if relative else f"weight {1.0 if weight is None else weight:.6g}"


def _variables(reading: Reading) -> list[str]:
    return [
        f"{name} {words.within(one, reading.unit_of_variable(name), reading.numbers)}"
        for name, one in reading.known.ranges.items()
    ]


def _more(spec: Spec, reading: Reading) -> list[str]:
    numbers, known = reading.numbers, reading.known
    lines = [f"values at {name} {numbers.pose(pose, known.axes)}" for name, pose in spec.poses.items()]
    if spec.sweep is not None:
        unit = reading.unit_of_variable(spec.sweep.variable)
        along = numbers.interval(spec.sweep.start, spec.sweep.stop, unit)
        lines.append(f"a sweep along {spec.sweep.variable}, {along}, {spec.sweep.points} points")
    if spec.pareto is not None:
        lines.append(f"a Pareto set of {spec.pareto} points")
    return lines

"""Which figures a solution has: what is known of it goes to each figure as arrays in the page's units."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from orthospec.errors import PluginFault
from orthospec.report.field_panels import SURFACE, Group, field_groups
from orthospec.report.fields import cuboid_of, fields
from orthospec.report.figures import cuboids, curves, fronts, limits, machine
from orthospec.report.panel import Panel, file_name, label
from orthospec.report.views import in_space
from orthospec.result.model import LargestRecord, MeasureRecord
from orthospec.show import tables, words

if TYPE_CHECKING:
    from orthospec.arrays import Array
    from orthospec.show.reading import Reading
    from orthospec.solution import Solution
    from orthospec.spec import Design

_SAME = 1e-5
"""Cuboids whose edges differ by less are drawn once [m]."""
MOST_LIMITS = 12
"""Limits with a bar; the table has all."""


@dataclass(frozen=True)
class Figures:
    """All figures of a report by what they are about; and sentences on what could not be drawn."""

    machine: list[Panel] = field(default_factory=list)
    limits: list[Panel] = field(default_factory=list)
    pareto: list[Panel] = field(default_factory=list)
    sweep: list[Panel] = field(default_factory=list)
    cuboids: list[Panel] = field(default_factory=list)
    fields: list[Group] = field(default_factory=list)
    convergence: list[Panel] = field(default_factory=list)
    not_shown: list[str] = field(default_factory=list)

    @property
    def in_space(self) -> list[Panel]:
        """The surfaces."""
        return [one for group in self.fields for one in group.panels if one.name.startswith(SURFACE)]

    def every(self) -> list[Panel]:
        """In the order of the page."""
        in_groups = [panel for group in self.fields for panel in group.panels]
        alone = (self.machine, self.limits, self.pareto, self.sweep, self.cuboids)
        return [*(panel for several in alone for panel in several), *in_groups, *self.convergence]


def figures(solution: Solution, reading: Reading) -> Figures:
    """The figures of a solution; without its spec those that need no machine."""
    design = solution.design
    shown, not_shown = fields(solution, design) if design else ([], [_WITHOUT])
    try:
        drawn = _machine(solution, reading, design) if design else []
    except PluginFault as fault:
        drawn = []
        not_shown.append(f"The machine is not drawn: {fault}.")
    return Figures(
        machine=drawn,
        limits=_limits(reading),
        pareto=_pareto(reading),
        sweep=_sweep(reading),
        cuboids=_cuboids(reading, design) if design else [],
        fields=[group for one in shown for group in field_groups(reading, one, design)] if design else [],
        convergence=_convergence(reading),
        not_shown=not_shown,
    )


_WITHOUT = (
    "Neither machine nor fields are drawn: its spec is not at hand, or a plugin of it is not installed."
)


def _machine(solution: Solution, reading: Reading, design: Design) -> list[Panel]:
    """The machine with its tool at the least corner of the cuboid, where parts do not cover each other."""
    names = list(reading.result.workspace.measures)
    cuboid = next(filter(None, (cuboid_of(solution, name) for name in [*names, ""])), None)
    if cuboid is None:
        return []
    axes = design.manipulator.axes
    poses = np.zeros((3, len(axes)))
    poses[:, : len(cuboid.low)] = np.stack([cuboid.low, cuboid.centre, cuboid.high])
    skeleton = design.manipulator.skeleton(poses)
    lengths = np.linalg.norm(np.diff(skeleton.segments, axis=2)[:, :, 0], axis=-1)
    if not np.isfinite(skeleton.segments[0]).all():
        return []
    drawing = machine.Drawing(
        segments=skeleton.segments[0],
        radii=skeleton.radii,
        names=skeleton.names,
        fixed=np.ptp(lengths, axis=0) <= 1e-9 * lengths.max(),
        low=in_space(cuboid.low, axes),
        high=in_space(cuboid.high, axes),
        box=f"prescribed cuboid{words.scaled(words.cuboid_scale(reading.result))}",
        numbers=reading.numbers,
    )
    return machine.panels(drawing)


def _limits(reading: Reading) -> list[Panel]:
    priced = [
        one for one in words.together(reading.result.limits) if not (one.gain is None and one.cost is None)
    ][:MOST_LIMITS]
    labels = [words.limiting(one, reading.known, reading.numbers) for one in priced]
    return [limits.panel_of(labels, [p.gain for p in priced], [p.cost for p in priced])] if priced else []


def _pareto(reading: Reading) -> list[Panel]:
    front = reading.result.pareto
    names = tables.soft_goals(front)
    if len(front) < 2 or len(names) < 2:
        return []
    labels, columns = [], []
    for name in names:
        values = [one.attainment.goals[name].value if one.attainment else None for one in front]
        factor, unit = reading.numbers.scale(reading.unit_of_goal(name), values)
        labels.append(label(name, unit))
        columns.append([np.nan if one is None else one * factor for one in values])
    table = tables.pareto(reading)
    says = [
        "Design "
        + ", ".join([row[0], *(f"{head} {cell}" for head, cell in zip(table.head[1:], row[1:], strict=True))])
        for row in table.rows
    ]
    return fronts.panels(fronts.Front(tuple(labels), np.array(columns).T, end_names(reading), says))


def end_names(reading: Reading) -> list[str]:
    """The number of each design of a Pareto set, and what it is: the best in a goal, or the knee."""
    front = reading.result.pareto
    found = []
    for number, one in enumerate(front, start=1):
        what = ["knee"] if one.knee else []
        what += [f"best {name}" for name in tables.soft_goals(front) if _is_best(reading, name, number - 1)]
        found.append(", ".join([str(number), *what[:1]]))
    return found


def _is_best(reading: Reading, name: str, k: int) -> bool:
    front, aim = reading.result.pareto, reading.known.goals.get(name)
    values = [one.attainment.goals[name].value if one.attainment else None for one in front]
    known = [one for one in values if one is not None]
    most = aim is not None and aim.words.startswith("maximise")
    return bool(known) and values[k] == (max(known) if most else min(known))


def _sweep(reading: Reading) -> list[Panel]:
    every = reading.result.sweep
    names = tables.varied(every) if len(every) > 1 else []
    if not names:
        return []
    numbers = reading.numbers
    values = [one.variables[names[0]] for one in every]
    factor, unit = numbers.scale(reading.unit_of_variable(names[0]), values)
    along = (label(names[0], unit), np.array(values) * factor)
    panels = []
    for name in every[0].workspace.measures:
        records = [one.workspace.measures[name] for one in every]
        lines = _lines_of(records)
        factor, unit = numbers.scale(
            reading.unit_of_measure(name), np.concatenate(list(lines.values())).tolist()
        )
        asked = reading.known.measures.get(name)
        bounds = [bound * factor for bound in (asked.bounds if asked else {}).values()]
        scaled = {key: line * factor for key, line in lines.items()}
        panels.append(
            curves.swept(f"sweep-{file_name(name)}", name, along, label(name, unit), scaled, bounds)
        )
    scales = [one.workspace.joint.scale if one.workspace.joint else None for one in every]
    if len({one for one in scales if one is not None}) > 1:
        line = {"largest cuboid": _array(scales)}
        panels.append(curves.swept("sweep-scale", "Scale of the largest cuboid", along, "scale", line, [1.0]))
    return panels


def _lines_of(records: list[MeasureRecord]) -> dict[str, Array]:
    lines = {
        "lowest in the cuboid": _array([one.lowest.value if one.lowest else None for one in records]),
        "highest in the cuboid": _array([one.highest.value if one.highest else None for one in records]),
    }
    for pose in records[0].poses:
        values = [one.poses.get(pose) or [None] for one in records]
        lines[f"at {pose}"] = _array([one[-1] for one in values])
        if any(len(one) > 1 for one in values):
            lines[f"at {pose}, lowest"] = _array([one[0] for one in values])
    return lines


def _array(values: list[float | None]) -> Array:
    return np.array([np.nan if one is None else one for one in values], dtype=float)


def _cuboids(reading: Reading, design: Design) -> list[Panel]:
    """Those of all measures together and of each alone, then those of the levels of each measure."""
    workspace, axes = reading.result.workspace, design.manipulator.axes
    factor, unit = reading.numbers.scale("m", [0.0])
    first = [_nested("all bounds together", workspace.joint, axes)]
    first += [_nested(f"{name} alone", one, axes) for name, one in workspace.measures.items()]
    panels = []
    if len({tuple(np.round((one.high - one.low) / _SAME)) for one in filter(None, first)}) > 1:
        panels.append(_nest("cuboids", "The largest cuboid of each measure", first, factor, unit))
    for name, record in workspace.measures.items():
        asked = reading.known.measures.get(name)
        levels = [
            _nested(_bounds(reading, name, {s: getattr(one, s) for s in words.SIDES}), one, axes)
            for one in record.levels
        ]
        if levels and asked:
            own = [_nested(_bounds(reading, name, asked.bounds), record, axes)]
            title = f"Cuboids of {name}, in one another"
            panels.append(_nest(f"cuboids-{file_name(name)}", title, [*own, *levels], factor, unit))
    return panels


def _bounds(reading: Reading, name: str, given: Mapping[str, float | None]) -> str:
    return words.bounds(reading.numbers, given, reading.unit_of_measure(name))


def _nest(name: str, title: str, every: list[cuboids.Nested | None], factor: float, unit: str) -> Panel:
    return cuboids.panel_of(name, title, [one for one in every if one], factor, unit)


def _nested(
    label: str, one: LargestRecord | MeasureRecord | None, axes: tuple[str, ...]
) -> cuboids.Nested | None:
    if one is None or one.min is None or one.max is None:
        return None
    return cuboids.Nested(label, in_space(one.min, axes), in_space(one.max, axes))


def _convergence(reading: Reading) -> list[Panel]:
    search = reading.result.search
    steps = search.steps if search else []
    if len(steps) < 2:
        return []
    return curves.converged(
        np.array([one.subproblems for one in steps]),
        _array([one.factor for one in steps]),
        _array([one.violation for one in steps]),
    )

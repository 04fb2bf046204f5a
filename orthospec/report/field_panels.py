"""The figures of one measure about its cuboid: slices and the surface of each of its bounds."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from orthospec.report.fields import Field, bound_surface, bounded_values, continued
from orthospec.report.figures import slices, surfaces
from orthospec.report.panel import Panel, file_name, label
from orthospec.show import words
from orthospec.show.numbers import UNKNOWN

if TYPE_CHECKING:
    from orthospec.show.reading import Reading
    from orthospec.spec import Design

_LENGTHS = ("x", "y", "z")
SURFACE = "surface-"
"""What the names of surfaces begin with."""


@dataclass(frozen=True)
class Group:
    """Figures that belong together: of one bound on one measure, of the cuboids of one measure."""

    title: str
    panels: list[Panel]


def field_groups(reading: Reading, one: Field, design: Design) -> Iterator[Group]:
    """The figures of each bound on a measure, or of its values where it has none."""
    demand = one.demand
    for side in demand.bounds or sorted(demand.measure.sides)[:1]:
        bound = demand.bounds.get(side)
        unit = reading.unit_of_measure(demand.name)
        said = words.bounds(reading.numbers, {side: bound}, unit)
        panels = list(_slices(reading, one, side, bound, said, design.manipulator.axes))
        shell = None if bound is None else _shell(reading, one, side, bound, said, design.manipulator.axes)
        title = f"{demand.name}: {said}" if said else demand.name
        yield Group(title, [*panels, *([shell] if shell else [])])


def _slices(
    reading: Reading, one: Field, side: str, bound: float | None, said: str, axes: tuple[str, ...]
) -> Iterator[Panel]:
    demand, name = one.demand, f"{file_name(one.demand.name)}-{side.replace('_', '-')}"
    grids = [(pair, lattice, bounded_values(lattice, demand.name, side)) for pair, lattice in one.planes]
    every = np.concatenate([values.ravel() for *_, values in grids])
    record = reading.result.workspace.measures.get(demand.name)
    ends = [end.value for end in (record.lowest, record.highest) if end] if record else []
    inside = [end for end in ends if end is not None]
    low, high = slices.range_of_colours(inside, bound, every)
    factor, unit = reading.numbers.scale(reading.unit_of_measure(demand.name), [low, high])
    for pair, lattice, values in grids:
        across, up = (axes[k] for k in pair)
        scales = [reading.numbers.scale(_unit(reading, k), [0.0]) for k in pair]
        others = [k for k in range(len(one.middle)) if k not in pair]
        numbers = reading.numbers
        at = ", ".join(
            f"{axes[k]} = {numbers.value(round(float(one.middle[k]), 7), _unit(reading, k))}" for k in others
        )
        low_corner, high_corner = (one.cuboid.low, one.cuboid.high) if one.cuboid else ((), ())
        box = None
        if one.cuboid is not None:
            corner = [float(low_corner[k]) * s for k, (s, _) in zip(pair, scales, strict=True)]
            edge = [float(high_corner[k] - low_corner[k]) * s for k, (s, _) in zip(pair, scales, strict=True)]
            box = ((corner[0], corner[1]), (edge[0], edge[1]))
        yield slices.panel_of(
            slices.Slice(
                name=f"slice-{name}-{across}{up}",
                title=f"{across}{up} plane" + (f" at {at}" if at else ""),
                across=lattice.axes[0] * scales[0][0],
                up=lattice.axes[1] * scales[1][0],
                labels=(label(across, scales[0][1]), label(up, scales[1][1])),
                label=label(demand.name, unit or "1"),
                values=values * factor,
                margin=continued(lattice.margin.reshape(values.shape)),
                box=box,
                bound=None if bound is None else bound * factor,
                side=side,
                ends=(low * factor, high * factor),
                equal=scales[0][1] == scales[1][1],
                bound_in_words=said,
            )
        )


def _unit(reading: Reading, k: int) -> str:
    return reading.known.axes[k] if k < len(reading.known.axes) else UNKNOWN


def _shell(
    reading: Reading, one: Field, side: str, bound: float, said: str, axes: tuple[str, ...]
) -> Panel | None:
    """The surface around all poses in reach at which a bound holds."""
    if one.space is None or one.cuboid is None or axes[:3] != _LENGTHS:
        return None
    surface = bound_surface(one.space, one.demand.name, side, bound)
    if surface is None:
        return None
    factor, unit = reading.numbers.scale("m", [0.0])
    return surfaces.panel_of(
        surfaces.Shell(
            name=f"{SURFACE}{file_name(one.demand.name)}-{side.replace('_', '-')}",
            title=f"Where {one.demand.name} is {said}",
            surface=surface,
            low=np.array(one.cuboid.low),
            high=np.array(one.cuboid.high),
            factor=factor,
            unit=unit,
        )
    )

"""All drawings of a solution."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial

from orthospec.report import charts, fields, machine
from orthospec.report.drawing import Drawing
from orthospec.report.subject import Subject


def drawings(subject: Subject) -> Iterator[Drawing]:
    """Those that the solution has something to show in, in the order of the page."""
    makers: list[Callable[[Subject], Drawing | None]] = [
        machine.views,
        charts.goals,
        charts.prices,
        charts.front,
        charts.sweep,
        fields.cuboids,
        *(partial(fields.slices, name=name) for name in subject.known.measures),
        fields.surfaces,
        charts.convergence,
    ]
    for make in makers:
        drawing = make(subject)
        if drawing is not None:
            yield drawing

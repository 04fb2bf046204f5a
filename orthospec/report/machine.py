"""The machine at work: views along the axes and one from the side, with the cuboid and its sizes."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from orthospec.report.drawing import Drawing, Table
from orthospec.report.projection import ALONG_AXES, EDGES, View, corners, from_side_and_above
from orthospec.report.style import BLUE, INK, MUTED, ORANGE, WIDTH
from orthospec.report.subject import Subject

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from orthospec.arrays import Array
    from orthospec.manipulators import Skeleton
    from orthospec.workspace.cuboid import Cuboid


def views(subject: Subject) -> Drawing | None:
    """The machine with its tool in the middle of the cuboid; faintly, at the cuboid's corners."""
    place, design = subject.place, subject.design
    if place is None or design is None:
        return None
    from matplotlib.figure import Figure

    machine = design.manipulator
    middle = machine.skeleton(place.poses(np.zeros((1, len(place.low))), len(machine.axes)))
    if not np.isfinite(middle.segments).all():
        return None
    figure = Figure(figsize=(WIDTH, 6.6), layout="constrained")
    for axes, view in zip(figure.subplots(2, 2).ravel(), (*ALONG_AXES, from_side_and_above()), strict=True):
        _draw(axes, subject, middle, place, view)
    size = subject.numbers.edges(place.low, place.high, ("m",) * len(place.low))
    rows = [
        [name, *ends.ravel().tolist(), float(radius)]
        for name, ends, radius in zip(middle.names, middle.segments[0], middle.radii, strict=True)
    ]
    head = ("segment", *(f"{axis}{end} [m]" for end in (1, 2) for axis in "xyz"), "radius [m]")
    return Drawing(
        "machine",
        f"The machine with its tool in the middle of the cuboid ({size}, orange).",
        f"Line drawing of the {subject.result.manipulator['use']} from above, from the front, from the right"
        f" and from the side; the prescribed cuboid of {size} is drawn in it.",
        figure,
        Table(head, rows),
    )


def _draw(axes: Axes, subject: Subject, skeleton: Skeleton, place: Cuboid, view: View) -> None:
    from matplotlib.collections import LineCollection

    segments = view.flat(subject.lengths(skeleton.segments[0]))
    order = np.argsort(view.nearness(skeleton.segments[0].mean(axis=1)), kind="stable")
    widths = 1.0 + 2.2 * skeleton.radii / skeleton.radii.max()
    slides = np.array([name.startswith(("slide", "rail", "base")) for name in skeleton.names])
    colours = np.where(slides, MUTED, BLUE)
    axes.add_collection(
        LineCollection(
            list(segments[order]), colors=list(colours[order]), linewidths=widths[order], capstyle="round"
        )
    )
    ends = segments.reshape(-1, 2)
    axes.plot(*ends.T, "o", color=INK, markersize=2.0)
    box = view.flat(subject.lengths(corners(place)))
    axes.add_collection(LineCollection([box[[a, b]] for a, b in EDGES], colors=ORANGE, linewidths=1.1))
    axes.plot(*view.flat(subject.lengths(corners(place).mean(axis=0))), "o", color=ORANGE, markersize=4)
    axes.set_title(view.name, loc="left")
    axes.set_aspect("equal")
    if view.name == "from the side":
        axes.set_axis_off()
        axes.autoscale_view()
        return
    right, up = ("xyz"[int(np.abs(row).argmax())] for row in view.rows[:2])
    axes.set_xlabel(f"{right} [{subject.length_unit}]")
    axes.set_ylabel(f"{up} [{subject.length_unit}]")
    _dimension(axes, box, ends)
    axes.margins(0.06)


def _dimension(axes: Axes, box: Array, ends: Array) -> None:
    """The cuboid's edges, as a drawing has them: beside it, with arrows."""
    low, high = box.min(axis=0), box.max(axis=0)
    off = 0.05 * float(np.ptp(np.vstack([ends, box]), axis=0).max())
    axes.update_datalim([low - 2.6 * off])  # room for the words beside the arrows
    arrow = {"arrowstyle": "<->", "color": INK, "linewidth": 0.8, "shrinkA": 0, "shrinkB": 0}
    if high[0] > low[0]:
        axes.annotate("", (low[0], low[1] - off), (high[0], low[1] - off), arrowprops=arrow)
        axes.annotate(
            f"{high[0] - low[0]:.6g}", ((low[0] + high[0]) / 2, low[1] - off), (0, -3),
            textcoords="offset points", ha="center", va="top", fontsize=7.5,
        )  # fmt: skip
    if high[1] > low[1]:
        axes.annotate("", (low[0] - off, low[1]), (low[0] - off, high[1]), arrowprops=arrow)
        axes.annotate(
            f"{high[1] - low[1]:.6g}", (low[0] - off, (low[1] + high[1]) / 2), (-3, 0),
            textcoords="offset points", ha="right", va="center", rotation=90, fontsize=7.5,
        )  # fmt: skip

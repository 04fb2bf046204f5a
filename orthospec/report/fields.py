"""The measures over the workspace: slices through the cuboid, surfaces of the bounds, nested cuboids."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import combinations
from typing import TYPE_CHECKING, Any

import numpy as np

from orthospec.measures.demand import bounded_side
from orthospec.report import style
from orthospec.report.drawing import Drawing, Table
from orthospec.report.projection import ALONG_AXES, EDGES, View, corners, from_side_and_above, shaded
from orthospec.report.style import BLUE, GREEN, MAP, MUTED, ORANGE, RED, SERIES, VIOLET, WIDTH
from orthospec.report.subject import Subject, cuboid_of
from orthospec.result.model import Ends
from orthospec.show import words
from orthospec.show.numbers import UNKNOWN
from orthospec.solution import Lattice, Surface, level_surface, sliced, workspace_surface
from orthospec.workspace.cuboid import Cuboid

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from orthospec.arrays import Array
    from orthospec.show.labels import Asked

NODES = 81
"""Along each edge of a slice."""
ROOM = 0.35
"""How far a slice goes beyond the cuboid, in parts of its longest edge."""
OF_SIDE = {"at_least": "lowest", "at_most": "highest"}


def slices(subject: Subject, name: str) -> Drawing | None:
    """One measure in the planes through the middle of the cuboid, with the bounds' contours."""
    place, design, asked = subject.place, subject.design, subject.known.measures[name]
    if place is None or design is None or len(place.low) < 2:
        return None
    side = bound_side(asked.bounds)
    box, planes = _around(place), list(combinations(range(len(place.low)), 2))
    parts = [sliced(design, box, np.array(place.centre), plane, NODES) for plane in planes]
    if not all(name in part.values for part in parts):
        return None
    values = [subject.told(asked.unit, _bounded(part, name, side))[0] for part in parts]
    unit = subject.told(asked.unit, list(asked.bounds.values()) or [0.0])[1]
    from matplotlib.figure import Figure

    figure = Figure(figsize=(WIDTH, 2.3), layout="constrained")
    every = style.panels(figure, 1, len(planes))
    low, high = _range(values, subject, asked)
    shown: Any = None
    for axes, part, one, plane in zip(every, parts, values, planes, strict=True):
        shown = _slice(axes, subject, part, one, plane, (low, high))
        _bounds(axes, subject, part, asked, name)
        _outline(axes, subject, place, plane)
    figure.colorbar(shown, ax=every, shrink=0.85, label=f"{name} [{unit}]" if unit else name, extend="both")
    bounds = words.bounds(subject.numbers, asked.bounds, asked.unit) or "no bound"
    rows = [
        row
        for part, plane in zip(parts, planes, strict=True)
        for row in _rows(part, _bounded(part, name, side), plane, place)
    ]
    axes_names = design.manipulator.axes[: len(place.low)]
    head = (
        *(f"{axis} [{u}]" for axis, u in zip(axes_names, subject.known.axes, strict=False)),
        f"{name} [{asked.unit}]",
    )
    return Drawing(
        f"slices-{name}",
        f"{name} ({asked.use}, its {OF_SIDE[side]} value over directions where it has two) through the"
        f" middle of the cuboid (orange). Red: the bound ({bounds}). Hatched: out of reach.",
        f"Maps of {name} in {words.counted(len(planes), 'plane')}:{_between(subject, name, asked)} {bounds}.",
        figure,
        Table(head, rows),
    )


def _between(subject: Subject, name: str, asked: Asked) -> str:
    record = subject.result.workspace.measures.get(name)
    if record is None or record.lowest is None or record.highest is None:
        return ""
    return (
        f" {subject.numbers.interval(record.lowest.value, record.highest.value, asked.unit)} over the cuboid;"
    )


def bound_side(bounds: Mapping[str, float]) -> str:
    """The side that is shown of a measure with two: the bounded one."""
    return "at_least" if "at_least" in bounds and "at_most" not in bounds else "at_most"


def _bounded(part: Lattice, name: str, side: str) -> Array:
    """The column of a measure that a bound of this side bounds, shaped as the lattice."""
    values = part.values[name]
    flat = values.reshape(-1, *values.shape[part.reachable.ndim :])
    return bounded_side(flat, side).reshape(part.reachable.shape)


def _around(place: Cuboid) -> Cuboid:
    room = ROOM * float(place.size.max())
    return Cuboid(tuple(x - room for x in place.low), tuple(x + room for x in place.high))


def _range(values: list[Array], subject: Subject, asked: Asked) -> tuple[float, float]:
    """What the colours span: most of the values, and the bounds well within."""
    known = np.concatenate([one[np.isfinite(one)] for one in values])
    low, high = np.percentile(known, [2, 90]) if len(known) else (0.0, 1.0)
    for bound in asked.bounds.values():
        told = float(subject.told(asked.unit, [bound])[0][0])
        low, high = min(low, told), max(high, told)
    return float(low), float(high if high > low else low + 1.0)


def _slice(
    axes: Axes,
    subject: Subject,
    part: Lattice,
    values: Array,
    plane: tuple[int, int],
    ends: tuple[float, float],
) -> Any:
    x, y = (_told_axis(subject, part, k, plane[k])[0] for k in (0, 1))
    shown = axes.pcolormesh(
        x, y, values.T, cmap=MAP, vmin=ends[0], vmax=ends[1], shading="nearest", rasterized=True
    )
    if np.isfinite(values).any():
        axes.contour(
            x, y, values.T, levels=np.linspace(*ends, 8)[1:-1], colors="white", linewidths=0.4, alpha=0.7
        )
    if not part.reachable.all():
        axes.contourf(
            x, y, part.reachable.T.astype(float), levels=[-0.5, 0.5], colors="none", hatches=["////"]
        )
    names = subject.design.manipulator.axes if subject.design else ()
    for label, k in ((axes.set_xlabel, 0), (axes.set_ylabel, 1)):
        unit = _told_axis(subject, part, k, plane[k])[1]
        label(f"{names[plane[k]]} [{unit}]")
    axes.set_aspect("equal" if all(subject.known.axes[k] == "m" for k in plane) else "auto")
    axes.tick_params(labelsize=7)
    return shown


def _told_axis(subject: Subject, part: Lattice, k: int, axis: int) -> tuple[Array, str]:
    return subject.told(subject.known.axes[axis], part.axes[k])


def _bounds(axes: Axes, subject: Subject, part: Lattice, asked: Asked, name: str) -> None:
    for side, bound in asked.bounds.items():
        values = _bounded(part, name, side)
        if np.isfinite(values).any() and np.nanmin(values) < bound < np.nanmax(values):
            x, y = (subject.lengths(axis) for axis in part.axes)
            style = "-" if side == "at_most" else "--"
            axes.contour(x, y, values.T, levels=[bound], colors=RED, linewidths=1.4, linestyles=style)


def _outline(axes: Axes, subject: Subject, place: Cuboid, plane: tuple[int, int]) -> None:
    from matplotlib.patches import Rectangle

    low = subject.lengths(np.array([place.low[k] for k in plane]))
    size = subject.lengths(np.array([place.size[k] for k in plane]))
    axes.add_patch(Rectangle((low[0], low[1]), size[0], size[1], fill=False, edgecolor=ORANGE, linewidth=1.6))


def _rows(part: Lattice, values: Array, plane: tuple[int, int], place: Cuboid) -> list[list[float]]:
    """Pose and value at each node of a slice that is in reach."""
    poses = np.tile(place.centre, (part.reachable.size, 1))
    for k, axis in zip(plane, np.meshgrid(*part.axes, indexing="ij"), strict=True):
        poses[:, k] = axis.ravel()
    found: list[list[float]] = np.column_stack([poses, values.ravel()])[part.reachable.ravel()].tolist()
    return found


def surfaces(subject: Subject) -> Drawing | None:
    """The workspace, and in it where each bound is reached, with the cuboid."""
    lattice, place, design = subject.lattice, subject.place, subject.design
    if lattice is None or place is None or design is None or lattice.margin.ndim != 3:
        return None
    whole = workspace_surface(lattice)
    if whole is None:
        return None
    bounds = [(d.name, side, bound) for d in design.demands for side, bound in d.bounds.items()]
    told = [(_label(subject, *one), _bound_surface(lattice, *one)) for one in bounds]
    found = [("out of reach", whole), *((label, s) for label, s in told if s is not None)]
    from matplotlib.figure import Figure

    columns = min(len(found), 3)
    rows = -(-len(found) // columns)
    figure = Figure(figsize=(WIDTH, 2.6 * rows), layout="constrained")
    view = from_side_and_above()
    every = style.panels(figure, rows, columns)
    for axes, (k, (label, surface)) in zip(every, enumerate(found), strict=False):
        _surface(axes, subject, surface, place, view, MUTED if k == 0 else (BLUE, GREEN, VIOLET)[k % 3])
        axes.set_title(label, loc="left", fontsize=8)
    for axes in every:
        axes.set_axis_off()
    size = subject.numbers.edges(place.low, place.high, ("m",) * 3)
    rows_ = [(label, len(s.vertices), len(s.triangles)) for label, s in found]
    return Drawing(
        "surfaces",
        "Where the reach ends, and where each bound is reached, with the cuboid (orange) in it.",
        f"Surfaces in space around the cuboid of {size}: {', '.join(label for label, _ in found)}.",
        figure,
        Table(("surface", "vertices", "triangles"), rows_),
    )


def _label(subject: Subject, name: str, side: str, bound: float) -> str:
    unit = subject.known.measures[name].unit if name in subject.known.measures else UNKNOWN
    return f"{name}: {words.SIDES[side]} {subject.numbers.value(bound, unit)}"


def _bound_surface(lattice: Lattice, name: str, side: str, bound: float) -> Surface | None:
    if name not in lattice.values:
        return None
    values = _bounded(lattice, name, side)
    return level_surface(lattice.axes, values, bound)


def _surface(axes: Axes, subject: Subject, surface: Surface, place: Cuboid, view: View, colour: str) -> None:
    """Drawn as a picture, from the far triangles to the near: thousands of shapes would not be a page."""
    from matplotlib.collections import LineCollection, PolyCollection
    from matplotlib.colors import to_rgb

    triangles, light = shaded(surface, view)
    shades = 1 - (1 - np.array(to_rgb(colour))) * (0.75 - 0.5 * light[:, None])
    shades = np.column_stack([shades, np.ones(len(shades))])
    axes.add_collection(
        PolyCollection(
            list(subject.lengths(triangles)), facecolors=shades,
            edgecolors=shades,
            linewidths=0.4,
            rasterized=True,
        )
    )  # fmt: skip
    box = view.flat(subject.lengths(corners(place)))
    axes.add_collection(LineCollection([box[[a, b]] for a, b in EDGES], colors=ORANGE, linewidths=1.3))
    axes.set_aspect("equal")
    axes.autoscale_view()


def cuboids(subject: Subject) -> Drawing | None:
    """The prescribed cuboid, the largest ones and those of the levels, one in the other."""
    found = nested(subject)
    if len(found) < 2 or len(found[0][1].low) < 2:
        return None
    from matplotlib.figure import Figure

    space = len(found[0][1].low) == 3
    figure = Figure(figsize=(WIDTH, 2.9), layout="constrained")
    every = style.panels(figure, 1, 3 if space else 1)
    for axes, view in zip(every, ALONG_AXES, strict=False):
        for k, (label, cuboid, _) in enumerate(found):
            flat = view.flat(subject.lengths(corners(cuboid)))
            low, high = flat.min(axis=0), flat.max(axis=0)
            axes.plot(
                [low[0], high[0], high[0], low[0], low[0]], [low[1], low[1], high[1], high[1], low[1]],
                color=ORANGE if k == 0 else SERIES[(k - 1) % 5], linewidth=2.2 if k == 0 else 1.1,
                linestyle="-" if k < 2 else "--", label=label,
            )  # fmt: skip
        right, up = ("xyz"[int(np.abs(row).argmax())] for row in view.rows[:2])
        axes.set_xlabel(f"{right} [{subject.length_unit}]")
        axes.set_ylabel(f"{up} [{subject.length_unit}]")
        axes.set_aspect("equal")
        axes.margins(0.08)
    handles, labels = every[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower left", ncols=2)
    rows: list[list[float | str | None]] = [[label, *c.low, *c.high, scale] for label, c, scale in found]
    names = "xyz"[: len(found[0][1].low)]
    head = ("cuboid", *(f"{axis} {end} [m]" for end in ("min", "max") for axis in names), "scale")
    said = "; ".join(f"{label}, scale {scale:.4g}" for label, _, scale in found)
    return Drawing(
        "cuboids",
        "The cuboids, one in the other.",
        f"Outlines of cuboids: {said}.",
        figure,
        Table(head, rows),
    )


def nested(subject: Subject) -> list[tuple[str, Cuboid, float]]:
    """What is known of cuboids, with words, ends and scales; the prescribed one first."""
    workspace = subject.result.workspace
    found = [] if subject.place is None else [("prescribed", subject.place, 1.0)]
    if workspace.joint is not None:
        found += _one(
            "largest for all measures", workspace.joint.min, workspace.joint.max, workspace.joint.scale
        )
    for name, record in workspace.measures.items():
        asked = subject.known.measures.get(name)
        for level in record.levels:
            given = {side: getattr(level, side) for side in words.SIDES}
            bound = words.bounds(subject.numbers, given, asked.unit if asked else UNKNOWN)
            found += _one(f"{name} {bound}", level.min, level.max, level.scale)
    return _distinct(found)


def _distinct(found: list[tuple[str, Cuboid, float]]) -> list[tuple[str, Cuboid, float]]:
    """Without those that stand where one before them does."""
    kept: list[tuple[str, Cuboid, float]] = []
    for one in found:
        ends = np.array([one[1].low, one[1].high])
        if not any(np.allclose(ends, [c.low, c.high], rtol=0, atol=1e-4 * c.size.max()) for _, c, _ in kept):
            kept.append(one)
    return kept


def _one(label: str, low: Any, high: Any, scale: float) -> list[tuple[str, Cuboid, float]]:
    cuboid = None if not low or not high else cuboid_of(Ends(min=list(low), max=list(high)))
    return [] if cuboid is None else [(label, cuboid, scale)]

"""Curves: along a sweep, and how the search came to its end."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from orthospec.report.canvas import panel
from orthospec.report.panel import Panel

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from orthospec.arrays import Array
    from orthospec.report.palette import Palette

_DASHES = ("-", (0, (5, 1.5)), (0, (2, 1)), (0, (6, 1.5, 1, 1.5)))
_MARKS = ("o", "s", "^", "D")


def swept(
    name: str,
    title: str,
    along: tuple[str, Array],
    label: str,
    lines: Mapping[str, Array],
    bounds: Sequence[float],
) -> Panel:
    """Values along a variable, labelled; bounds as lines across."""
    ends = "; ".join(
        f"{key} from {line[0]:.4g} to {line[-1]:.4g}" for key, line in lines.items() if len(line)
    )
    _, bracket, unit = label.partition(" [")
    columns = {f"{key}{bracket}{unit}": line for key, line in lines.items()}
    return Panel(
        name,
        title,
        f"{title}, along {along[0]} from {along[1][0]:.4g} to {along[1][-1]:.4g}: {ends}.",
        lambda palette: _swept(along, label, lines, bounds, palette),
        {along[0]: along[1], **columns},
    )


def _swept(
    along: tuple[str, Array],
    label: str,
    lines: Mapping[str, Array],
    bounds: Sequence[float],
    palette: Palette,
) -> Figure:
    figure, axes = panel(palette, 3.8, 2.9, margins=(0.66, 0.5, 0.12, 0.12 + 0.17 * len(lines)))
    for bound in bounds:
        axes.axhline(bound, color=palette.muted, linewidth=0.9, linestyle=(0, (2, 2)))
    for k, (name, line) in enumerate(lines.items()):
        _line(axes, figure, k, name, (along[1], line), palette)
    axes.set(xlabel=along[0], ylabel=label)
    _rules(axes, palette)
    return figure


def _line(
    axes: Axes, figure: Figure, k: int, name: str, points: tuple[Array, Array], palette: Palette
) -> None:
    from matplotlib.lines import Line2D

    colour = palette.cycle[k % 6]
    manner: dict[str, Any] = {"color": colour, "linestyle": _DASHES[k % 4], "marker": _MARKS[k % 4]}
    axes.plot(*points, **manner, markersize=3.4)
    height = 1 - (0.13 + 0.17 * k) / float(figure.get_figheight())
    # An artist of the figure: among the axes' own lines it would be one of those that they make room for.
    figure.add_artist(Line2D([0.17, 0.24], [height, height], **manner, markersize=3.4))
    figure.text(0.26, height, name, color=palette.ink, fontsize=8, va="center")


def _rules(axes: Axes, palette: Palette) -> None:
    axes.grid(visible=True, color=palette.rule, linewidth=0.6)
    axes.set_axisbelow(True)
    axes.margins(0.04)


def converged(subproblems: Array, factors: Array, violations: Array) -> list[Panel]:
    """λ by subproblem, and the violation where there was any."""
    columns = {"subproblem": subproblems, "lambda": factors, "violation": violations}
    ended = f"after {int(subproblems[-1])} subproblems λ is {factors[-1]:.6g}"
    least = violations[-1]
    panels = [
        Panel(
            "convergence-lambda",
            "λ by subproblem",
            f"λ by subproblem: it begins at {factors[0]:.6g}; {ended}.",
            lambda palette: _steps(subproblems, factors, "λ", palette),
            columns,
        )
    ]
    if not (violations > 0).any():
        return panels
    return [
        *panels,
        Panel(
            "convergence-violation",
            "Violation of the bounds by subproblem",
            f"The greatest part by which a bound is missed, by subproblem: {violations[0]:.3g} at first, "
            f"{least:.3g} at the end.",
            lambda palette: _violations(subproblems, violations, palette),
            columns,
        ),
    ]


def _steps(subproblems: Array, values: Array, label: str, palette: Palette) -> Figure:
    figure, axes = panel(palette, 3.4, 2.3, margins=(0.75, 0.5, 0.12, 0.12))
    axes.plot(subproblems, values, color=palette.first, marker="o", markersize=4)
    axes.set(xlabel="subproblem", ylabel=label)
    _whole(axes)
    _rules(axes, palette)
    return figure


_LEAST = 1e-12
"""Violations below this are drawn there: nothing on a logarithm."""


def _violations(subproblems: Array, violations: Array, palette: Palette) -> Figure:
    figure = _steps(subproblems, np.maximum(violations, _LEAST), "violation", palette)
    (axes,) = figure.axes
    axes.set_yscale("log")
    axes.set_ylim(_LEAST / 3, max(float(violations.max()) * 3, 1e-8))
    axes.set_yticks([_LEAST, *(10.0**k for k in range(-9, 4, 3) if 10.0**k < axes.get_ylim()[1])])
    axes.set_yticklabels(["none", *(f"1e{k}" for k in range(-9, 4, 3) if 10.0**k < axes.get_ylim()[1])])
    axes.minorticks_off()
    return figure


def _whole(axes: Axes) -> None:
    from matplotlib.ticker import MaxNLocator

    axes.xaxis.set_major_locator(MaxNLocator(6, integer=True))

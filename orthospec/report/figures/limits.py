"""What one per cent of each limit is worth, to either side."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from orthospec.report.canvas import panel
from orthospec.report.panel import Panel

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from orthospec.report.palette import Palette


def panel_of(labels: Sequence[str], gains: Sequence[float | None], costs: Sequence[float | None]) -> Panel:
    """Bars to the left for what 1 % looser gains, to the right for what 1 % tighter costs."""
    told = "; ".join(
        f"{label}: gain {_word(gain)}, cost {_word(cost)}"
        for label, gain, cost in zip(labels, gains, costs, strict=True)
    )
    return Panel(
        "limits",
        "What 1 % of each limit is worth in λ",
        f"{told}.",
        lambda palette: _draw(labels, gains, costs, palette),
        {
            "limit": list(labels),
            "gain of lambda by 1 % looser": [_cell(one) for one in gains],
            "cost of lambda by 1 % tighter": [_cell(one) for one in costs],
        },
    )


def _word(price: float | None) -> str:
    return "not known" if price is None else f"{price:.3g}"


def _cell(price: float | None) -> object:
    return "" if price is None else price


def _draw(
    labels: Sequence[str], gains: Sequence[float | None], costs: Sequence[float | None], palette: Palette
) -> Figure:
    rows = len(labels)
    figure, axes = panel(palette, 4.9, 0.44 * rows + 0.8, margins=(0.12, 0.46, 0.12, 0.3))
    most = max((abs(one) for one in (*gains, *costs) if one is not None), default=0.0) or 1.0
    places = np.arange(rows)[::-1]
    for values, sign, colour, hatch in ((gains, -1, palette.third, "///"), (costs, 1, palette.second, "")):
        known = [sign * (one or 0.0) for one in values]
        axes.barh(
            places - 0.16,
            known,
            height=0.34,
            color="none" if hatch else colour,
            edgecolor=colour,
            hatch=hatch,
        )
        for y, value, one in zip(places, known, values, strict=True):
            text = "no design found" if one is None else f"{one:.3g}" if one else ""
            axes.text(
                value + sign * 0.015 * most,
                y - 0.16,
                text,
                color=palette.ink,
                fontsize=8,
                ha="left" if sign > 0 else "right",
                va="center",
            )
    for y, label in zip(places, labels, strict=True):
        axes.text(-1.24 * most, y + 0.2, label, color=palette.ink, fontsize=8.5, va="center")
    axes.axvline(0, color=palette.muted, linewidth=0.8)
    axes.set(xlim=(-1.25 * most, 1.25 * most), ylim=(-0.55, rows - 0.45), xlabel="change of λ")
    axes.set_yticks([])
    axes.spines["left"].set_visible(False)
    ticks = [tick for tick in axes.get_xticks() if abs(tick) <= 1.25 * most]
    axes.set_xticks(ticks, [f"{tick:+.3g}" if tick else "0" for tick in ticks])
    for x, text, side in ((-0.02, "◂ 1 % looser gains", "right"), (0.02, "1 % tighter costs ▸", "left")):
        axes.text(x * most, rows - 0.42, text, color=palette.muted, fontsize=8, ha=side, va="bottom")
    return figure

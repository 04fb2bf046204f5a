"""What a fit is for: rows of goals over a design, the scale and extremes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

import numpy as np

from orthospec.workspace.conditions import Extreme
from orthospec.workspace.layout import Point
from orthospec.workspace.machine import Machine

if TYPE_CHECKING:
    from orthospec.arrays import Array

NEAR = 0.5
"""A row this far below the factor, or a bound, takes no part in a step."""
BUMP = 1e-6
"""Relative change of an extreme that shows which rows want it worse."""


class Objective(Protocol):
    """Rows g <= on_factor·factor + on_slack·slack, g smooth in the design, μ and the extremes."""

    @property
    def extremes(self) -> tuple[Extreme, ...]:
        """The extremes that the rows depend on."""

    @property
    def on_factor(self) -> Array:
        """(r,), 0 for a hard row."""

    @property
    def on_slack(self) -> Array:
        """(r,), 0 for a soft row."""

    def rows(self, machine: Machine, point: Point) -> Array:
        """g (r,)."""


def wanted_worse(objective: Objective, machine: Machine, point: Point) -> frozenset[Extreme]:
    """The extremes that a row wants worse which has a part in the next step: they need a row of their own.

    Which these are hangs on where the step begins: past its turning point a goal wants the contrary.
    ``match`` has a row for each side, of which one is idle. Held from both sides an extreme could not move
    but with the pose where it is now: where several tie, all directions but a few are blocked.
    """
    if not objective.extremes:
        return frozenset()
    g, soft, hard = objective.rows(machine, point), objective.on_factor, objective.on_slack
    with np.errstate(divide="ignore", invalid="ignore"):
        factors, excesses = np.where(soft > 0, g / soft, -np.inf), np.where(hard > 0, g / hard, -np.inf)
    acts = (factors >= factors.max() - NEAR) & (soft > 0) | (excesses >= -NEAR) & (hard > 0)
    found = set()
    for k, extreme in enumerate(objective.extremes):
        moved = point.extremes.copy()
        moved[k] += extreme.sign * BUMP * (abs(moved[k]) or 1.0)
        falls = objective.rows(machine, point._replace(extremes=moved)) < g
        if (acts & falls).any():
            found.add(extreme)
    return frozenset(found)

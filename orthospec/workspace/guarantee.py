"""What is guaranteed of a cuboid: the verdict over it, and how far from the largest possible it can be.

The verdict is that of `orthospec.workspace.proof` on all conditions together. The scale of a largest cuboid
is enclosed from below by a smaller one about the same centre in which everything holds without any slack, and
from above by a larger one that fits nowhere (`orthospec.workspace.placements`): of the machine as it is
designed, whatever its tolerances.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from orthospec.measures.demand import ROUNDING
from orthospec.workspace.cuboid import Cuboid
from orthospec.workspace.machine import Machine
from orthospec.workspace.placements import none_fits
from orthospec.workspace.proof import Budget, Claim, Verdict, prove

if TYPE_CHECKING:
    from orthospec.arrays import Array

PARTS = (1e-6, 1e-4, 1e-2, 1e-1)
"""By which parts a cuboid is made smaller, or larger, until a proof succeeds."""


@dataclass(frozen=True)
class Proof:
    """What is known of all conditions over a cuboid together."""

    verdict: Verdict
    slack: float
    boxes: int
    excess: float | None
    """The greatest excess that is not ruled out, relative; None where nothing is known."""
    condition: str | None = None
    """What decides the verdict where it is not *proved*: a bound or a condition of the reach."""
    at: tuple[float, ...] | None = None
    """The pose that refutes it."""
    why: str | None = None
    """Why nothing is known of a measure over boxes."""
    machine: Mapping[str, tuple[float, ...]] | None = None
    """The toleranced numbers of the machine that is refuted; None where it is the nominal one."""
    nominal: Verdict | None = None
    """What is known of the nominal machine alone; None without tolerances."""

    @property
    def refutes_design(self) -> bool:
        """Whether the machine as it is designed has a pose at which something does not hold."""
        return self.verdict == "refuted" and self.machine is None


@dataclass(frozen=True)
class Bracket:
    """Proved ends of the scale of the largest cuboid; None where there is no proof."""

    least: float | None
    most: float | None
    larger: Cuboid | None = None
    """One above the scale that seems to fit, met while its upper end was sought."""


def proof_within(
    machine: Machine, cuboid: Cuboid, slack: float, boxes: int, tolerances: Mapping[str, float]
) -> Proof:
    """`proof_over` of a machine and, unless it is refuted already, of all those within the tolerances."""
    own = proof_over(machine, cuboid, slack, boxes)
    if not tolerances:
        return own
    every = own if own.verdict == "refuted" else proof_over(machine, cuboid, slack, boxes, tolerances)
    spent = own.boxes if every is own else own.boxes + every.boxes
    return replace(every, boxes=spent, nominal=own.verdict)


def proof_over(
    machine: Machine,
    cuboid: Cuboid,
    slack: float,
    boxes: int,
    tolerances: Mapping[str, float] | None = None,
) -> Proof:
    """Whether the reach and all bounds hold at every pose of a cuboid, within the slack."""
    claims = prove(machine, cuboid, slack=slack, budget=Budget(boxes=boxes), tolerances=tolerances)
    worst = max(claims, key=_gravity)
    # Conditions on one measure share their boxes.
    spent = {(c.condition.kind, c.condition.name if c.condition.kind == "bound" else ""): c for c in claims}
    excess = float(worst.excess) if np.isfinite(worst.excess) else None
    return Proof(
        worst.verdict,
        slack,
        sum(claim.boxes for claim in spent.values()),
        excess,
        None if worst.verdict == "proved" else _name(worst),
        worst.at,
        worst.why,
        worst.machine,
    )


def _gravity(claim: Claim) -> tuple[int, float]:
    return ("proved", "undecided", "refuted").index(claim.verdict), claim.excess


def _name(claim: Claim) -> str:
    condition = claim.condition
    return f"{condition.name}: {condition.side}" if condition.side else condition.name


def bracket(
    machine: Machine, size: Array, cuboid: Cuboid, scale: float, region: Cuboid | None, boxes: int
) -> Bracket:
    """Proved ends around the scale of a largest cuboid; each attempt may take so many boxes."""

    def holds(part: float) -> bool:
        smaller = Cuboid.around(np.array(cuboid.centre), (1 - part) * scale * size)
        return proof_over(machine, smaller, 0.0, boxes).verdict == "proved"

    larger: Cuboid | None = None

    def fits_nowhere(part: float) -> bool:
        nonlocal larger
        found = none_fits(machine, (1 + part) * scale * size, region, boxes, cuboid)
        larger = larger or found.fits
        return found.excluded

    below, above = _least_part(holds), _least_part(fits_nowhere)
    # The corners of what was proved are rounded, and a scale is told to a little less than these allow.
    least = None if below is None else (1 - below) * scale * (1 - ROUNDING)
    most = None if above is None else (1 + above) * scale * (1 + ROUNDING)
    if region is not None:
        room = float(np.min(region.size / size)) * (1 + ROUNDING)
        most = room if most is None else min(most, room)
    return Bracket(least, most, larger)


def _least_part(proved: Callable[[float], bool]) -> float | None:
    """The least part that is proved: the finest, or else the last one from the coarsest on.

    Each attempt that fails may take all its boxes, so that there are two of these at most.
    """
    finest, *coarser = PARTS
    if proved(finest):
        return finest
    found = None
    for part in reversed(coarser):
        if not proved(part):
            break
        found = part
    return found

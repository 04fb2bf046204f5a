"""Proof that bounds and reach hold at every pose of a cuboid, by branch and bound over boxes.

Each box gets verified bounds on how far every condition may be exceeded in it (`Measure.enclosure`,
`Manipulator.reach_enclosure`). Where that is not within the slack, the box is cut in two across its longest
edge, of several the one along which the value changes most. A condition is

    proved      in all boxes it is exceeded by no more than the slack
    refuted     at a pose that was found, the worst nearby, it is exceeded by more, in plain arithmetic
    undecided   the budget was spent before either, or the measure has no enclosure

With tolerances it is asked of all machines within them (`tolerances`), whose numbers are coordinates too.
What an excess is relative to, and which conditions have slack, stands in `proof_cases`.
"""

from __future__ import annotations

import time
import traceback
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import numpy as np

from orthospec.errors import RAISED, OrthospecError
from orthospec.intervals import Boxes
from orthospec.intervals.refusal import line_of
from orthospec.measures.demand import ROUNDING
from orthospec.workspace.conditions import Condition
from orthospec.workspace.critical import lattice
from orthospec.workspace.cuboid import Cuboid
from orthospec.workspace.machine import Machine
from orthospec.workspace.proof_cases import Case, cases_of
from orthospec.workspace.tolerances import Family

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from orthospec.arrays import Array, Flags

BATCH = 4096
"""Most boxes at a time."""
CORNERS = 65_536
"""Most corners of boxes at a time, at which eigenvalues are asked."""
MATTERS = 0.01
"""A coordinate that changes a value by less than this part of what another one does matters little."""
LONGER = 4.0
"""By so much an edge along such a coordinate may be longer."""
TRIALS, SHORT, SAME = 6, 2.0**-6, 1e-10
"""Boxes that are tried, their edges beside the cuboid's, and what changes their bounds by less is idle."""
SAMPLES, MOST_CORNERS = 64, 6
"""Points at which what is proved is looked at too, and of so many coordinates the corners."""
IDLE = 1024.0
"""By so much an edge along an idle coordinate may be longer."""
ALIKE = 0.9
"""Edges of this part of the longest one count as long."""
FEW = 8
"""So few boxes are cut across several coordinates at once."""
FINEST = 2.0**-40
"""Boxes are cut down to this part of the cuboid's edge."""
RISE = 1e-14
"""A pose is worse by more than this, or on a plateau the worst one would be where rounding has it."""
CLIMB = 40
"""Halvings of the step by which the worst pose near one that refutes is looked for."""

Verdict = Literal["proved", "refuted", "undecided"]


@dataclass(frozen=True)
class Budget:
    """When to stop: undecided then. Only a count of boxes gives the same verdict on any day."""

    boxes: int = 200_000
    seconds: float | None = None


@dataclass(frozen=True)
class Claim:
    """What is known of one condition over a whole cuboid."""

    condition: Condition
    verdict: Verdict
    boxes: int
    """How many boxes were looked at, together with the other conditions on the same measure."""
    excess: float
    """By how much it is exceeded at most: proved; where it is refuted, at the pose that was found."""
    at: tuple[float, ...] | None = None
    """The pose that refutes it."""
    machine: Mapping[str, tuple[float, ...]] | None = None
    """The numbers of the machine that is refuted there, by toleranced field; None without tolerances."""
    why: str | None = None
    """Why nothing is known of its measure over boxes."""


def prove(
    machine: Machine,
    cuboid: Cuboid,
    *,
    slack: float,
    budget: Budget | None = None,
    tolerances: Mapping[str, float] | None = None,
) -> list[Claim]:
    """One claim for each reach condition and each bound, in the order of `conditions_of`.

    ``tolerances`` of the machine's `toleranced` fields make it a claim on all machines within them.
    """
    budget, family = budget or Budget(), Family(machine.manipulator, tolerances or {})
    start, demands = family.whole(cuboid), tuple(machine.demands.values())
    stop = None if budget.seconds is None else time.monotonic() + budget.seconds
    claims: list[Claim] = []
    for case in cases_of(family, demands, start, slack):
        out_of_reach = any(claim.verdict == "refuted" for claim in claims if claim.condition.kind == "joint")
        claims += _Search(family, case, start, 0 if out_of_reach else budget.boxes, stop).run()
    return claims


class _Search:
    """Branch and bound for the conditions of one case."""

    def __init__(self, family: Family, case: Case, start: Boxes, most: int, stop: float | None) -> None:
        self._family, self._case, self._start, self._most, self._stop = family, case, start, most, stop
        self._finest = FINEST * (start.hi - start.lo)[0]
        self._boxes = 0
        self._worst: dict[int, Array] = {}
        """Where each claim is refuted (d,)."""
        self._claims = [Claim(c, "undecided", 0, np.inf) for c in case.conditions]

    def run(self) -> list[Claim]:
        """The claims, when nothing is open or the budget is spent."""
        proved = np.full(len(self._claims), -np.inf)
        waiting = [(self._start, np.full((len(self._claims), 1), np.inf))]
        stuck = self._claims == []
        try:
            while waiting and not stuck and self._may_go_on(len(waiting[0][0])):
                boxes, _ = waiting.pop(0)
                self._boxes += len(boxes)
                excess = self._case.over(boxes)
                is_open = ~(excess <= self._case.slack[:, None])
                np.maximum(proved, np.where(is_open, -np.inf, excess).max(axis=1), out=proved)
                is_open &= self._is_wanted()[:, None]
                left: Flags = np.any(is_open, axis=0)
                if left.any():
                    rest, excess = boxes[left], excess[:, left]
                    parts, excess = self._cut(rest, excess, self._changes(rest, excess, is_open[:, left]))
                    stuck = bool((parts.hi - parts.lo <= 2 * self._finest).all(axis=1).any())
                    waiting += _batches(parts, excess)
            if not waiting:
                self._judged(self._samples())
            self._climb()
        except RAISED as error:
            return [replace(claim, boxes=self._boxes, why=_reason(error)) for claim in self._claims]
        return self._settled(proved, waiting)

    @cached_property
    def _edges(self) -> Array:
        """What the edges of boxes are long beside (d,)."""
        edges = (self._start.hi - self._start.lo)[0]
        found = np.where(edges > 0, edges, 1.0)
        # Tolerances are short beside the cuboid, and so little of a box's excess comes from them.
        axes = len(self._family.nominal.axes)
        found[axes:] = edges[:axes].max()
        return np.where(self._is_idle(), IDLE * found, found)

    def _samples(self) -> Array:
        """Points all over (k, d): what an enclosure says of all of them and is not so of one is no proof."""
        lo, edges = self._start.lo[0], (self._start.hi - self._start.lo)[0]
        d = len(lo)
        corners = lattice(2, d) + 0.5 if d <= MOST_CORNERS else np.zeros((0, d))
        return np.asarray(lo + np.vstack([corners, _scattered(SAMPLES, d)]) * edges)

    def _is_idle(self) -> Flags:
        """Along which coordinates long boxes have the same bounds as short ones (d,): no cut there helps."""
        lo, edges = self._start.lo[0], (self._start.hi - self._start.lo)[0]
        d = len(lo)
        low = np.tile(lo + _scattered(TRIALS, d) * (1 - SHORT) * edges, (1 + d, 1, 1))
        high = low + SHORT * edges
        for k in range(d):
            low[1 + k, :, k], high[1 + k, :, k] = lo[k], lo[k] + edges[k]
        excess = self._case.over(Boxes(low.reshape(-1, d), high.reshape(-1, d))).reshape(-1, 1 + d, TRIALS)
        with np.errstate(invalid="ignore"):
            apart = np.abs(excess[:, 1:] - excess[:, :1])
        return np.asarray((apart <= SAME * np.maximum(np.abs(excess[:, :1]), 1.0)).all(axis=(0, 2)))

    def _may_go_on(self, more: int) -> bool:
        """Within the budget, and not out of reach: beyond it there is little to prove."""
        in_time = self._stop is None or time.monotonic() < self._stop
        wanted = self._is_wanted()
        within = wanted.all() or self._case.conditions[0].kind == "bound"
        return bool(in_time and within and wanted.any() and self._boxes + more <= self._most)

    def _is_wanted(self) -> Flags:
        return np.array([claim.verdict != "refuted" for claim in self._claims])

    def _cut(self, boxes: Boxes, excess: Array, changes: Array) -> tuple[Boxes, Array]:
        """Each box in two; a few boxes more often, since a round costs the same for one box as for many."""
        rounds = boxes.lo.shape[1] if len(boxes) <= FEW else 1
        for _ in range(rounds):
            half = (boxes.hi - boxes.lo) / 2
            along = _across(changes, half / self._edges, half > self._finest)
            boxes, excess = boxes.halves(along), np.tile(excess, 2)
            changes = np.tile(changes, (2, 1))
        return boxes, excess

    def _changes(self, boxes: Boxes, excess: Array, is_open: Flags) -> Array:
        """How much the worst open condition changes along each edge (n, d); notes what is refuted there."""
        n, d = boxes.lo.shape
        rows = np.arange(n)
        worst = np.where(is_open, np.nan_to_num(excess, nan=np.inf), -np.inf).argmax(axis=0)
        centres, half = boxes.centres, (boxes.hi - boxes.lo) / 2
        steps = half[:, None, :] * np.concatenate([np.eye(d), -np.eye(d)])
        around = self._judged((centres[:, None, :] + steps).reshape(-1, d)).reshape(-1, n, 2, d)
        with np.errstate(invalid="ignore"):
            changes = around[:, :, 0] - around[:, :, 1]
        for change in changes[is_open.any(axis=1)]:
            self._judged(np.where(np.nan_to_num(change) >= 0, boxes.hi, boxes.lo))
        return np.asarray(changes[worst, rows])

    def _judged(self, points: Array) -> Array:
        """The excess at points of the whole (k, n), and a claim refuted where one is too great."""
        points = np.clip(points, self._start.lo, self._start.hi)
        excess = self._case.at(points)
        for k, row in enumerate(excess):
            known = np.where(np.isnan(row), -np.inf, row)
            # What is worse by rounding alone would be another pose or machine on another processor.
            i = int((known >= known.max() - RISE).argmax())
            claim, found = self._claims[k], float(known[i])
            refuted = found > self._case.slack[k] + ROUNDING
            if refuted and (claim.verdict != "refuted" or found > claim.excess + RISE):
                _, (pose,) = self._family.at(points[i : i + 1])
                at, numbers = tuple(map(float, pose)), self._family.named(points[i]) or None
                self._worst[k] = points[i]
                self._claims[k] = replace(claim, verdict="refuted", excess=found, at=at, machine=numbers)
        return excess

    def _climb(self) -> None:
        """From each point that refutes to the worst one nearby: it tells more, and a search may mind it."""
        d = self._start.lo.shape[1]
        star = np.concatenate([np.eye(d), -np.eye(d)]) * (self._start.hi - self._start.lo) / 2
        for k in list(self._worst):
            for halvings in np.repeat(np.arange(CLIMB), d):
                self._judged(self._worst[k] + star * 0.5**halvings)

    def _settled(self, proved: Array, waiting: Sequence[tuple[Boxes, Array]]) -> list[Claim]:
        left = np.concatenate([excess for _, excess in waiting], axis=1) if waiting else None
        found = []
        for k, claim in enumerate(self._claims):
            if claim.verdict == "refuted":
                settled = claim
            else:
                rest = np.array([]) if left is None else left[k][~(left[k] <= self._case.slack[k])]
                worst = float(np.max(np.append(np.where(np.isnan(rest), np.inf, rest), proved[k])))
                verdict: Verdict = "undecided" if len(rest) else "proved"
                settled = replace(claim, verdict=verdict, excess=worst)
            found.append(replace(settled, boxes=self._boxes))
        return found


def _scattered(count: int, d: int) -> Array:
    """Points (count, d) of [0, 1) without an order."""
    return np.asarray(np.modf(np.sqrt(np.arange(1, count + 1)[:, None] * 2 + np.arange(d)))[0])


def _across(change: Array, length: Array, can_be_cut: Flags) -> NDArray[np.intp]:
    """The coordinate (n,) to cut: of the longest ones that of the greatest change.

    What an enclosure is too wide by grows with the square of the edges, so that long thin boxes do not pay.
    Along a coordinate that does not matter to the value an edge may stay longer, but still has its share.
    """
    size = np.where(np.isfinite(change), np.abs(change), np.inf)
    matters = size >= MATTERS * size.max(axis=1, keepdims=True)
    length = np.where(can_be_cut, np.where(matters, length, length / LONGER), 0.0)
    longest = length >= ALIKE * length.max(axis=1, keepdims=True)
    return np.asarray(np.where(longest & can_be_cut, size, -1.0).argmax(axis=1))


def _batches(boxes: Boxes, excess: Array) -> list[tuple[Boxes, Array]]:
    size = min(BATCH, CORNERS >> boxes.lo.shape[1])
    cuts = range(0, len(boxes), size)
    return [(boxes[i : i + size], excess[:, i : i + size]) for i in cuts]


def _reason(error: BaseException) -> str:
    """The error's own words, or what a plugin raised and where."""
    if isinstance(error, OrthospecError):
        return str(error)
    numpy = str(Path(np.__file__).parent)
    frames = list(traceback.walk_tb(error.__traceback__))
    frame, number = [one for one in frames if not one[0].f_code.co_filename.startswith(numpy)][-1]
    return f"{line_of(frame, number)}: {type(error).__name__}: {error}"

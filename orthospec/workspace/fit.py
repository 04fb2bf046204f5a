"""Fitting cuboids into a design, and a design around cuboids: the problem that polish and goals share.

Variables are the design's (none for polish), each cuboid's centre, where asked the scale μ, and the extremes
that goals are about. Each condition must hold at every critical point p = centre + μ·size∘u of its cuboid;
the points are found anew, over the whole cuboid, at every trial and join.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from orthospec.composite.subproblem import Block, HalfLines, Rows, Step
from orthospec.composite.template import Template
from orthospec.composite.trust_region import Assessment
from orthospec.errors import UnbuildableDesign
from orthospec.workspace.conditions import Condition, Extreme, Sample, conditions_of
from orthospec.workspace.critical import NODES, find_peaks, lattice, worst_points
from orthospec.workspace.cuboid import Cuboid
from orthospec.workspace.drift import INSIDE, Box, moving_curvature
from orthospec.workspace.forms import Forms, inside_of
from orthospec.workspace.layout import Layout, Limits, Point
from orthospec.workspace.machine import Machine
from orthospec.workspace.objective import Objective, wanted_worse

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from orthospec.arrays import Array, Poses

RELEVANT = 0.5
"""A condition enters the subproblem at its worst point, and where its excess is above minus this."""
NEGLIGIBLE = 1e-6
"""A multiplier below this part of the greatest moves nothing."""
SAME = 1e-3
"""Critical points nearer than this (as a part of the cuboid) are one, the newest."""


@dataclass(frozen=True)
class Group:
    """Demands that share one cuboid (all of them, or one each), and the centre it starts from."""

    names: tuple[str, ...]
    centre: tuple[float, ...]


@dataclass(frozen=True)
class _Chosen:
    """One term at some of its group's slots: as numbers, or as a convex form; ``sign`` −1 reverses it."""

    group: int
    term: Condition | Extreme
    at: NDArray[np.intp]
    form: Template | None = None
    sign: float = 1.0


@dataclass(frozen=True)
class _Selection:
    """What w is made of: the terms as numbers, those as convex forms, and the slots that both refer to."""

    numbers: tuple[_Chosen, ...]
    forms: tuple[_Chosen, ...]
    slots: tuple[Array, ...]


class FitProblem:
    """A `Problem` of the trust region: cuboids, and the design around them.

    ``build`` maps a scaled design to its `Machine`, or raises UnbuildableDesign; ``start`` is a scaled design
    and a scale. ``relaxed`` loosens conditions by so much, which is how a price is found. ``pinned`` (n, d)
    are poses at which peaks are known to be that no lattice shows. ``forms`` have been compiled for others of
    the same demands.
    """

    def __init__(
        self,
        build: Callable[[Array], Machine],
        size: Array,
        groups: Sequence[Group],
        objective: Objective,
        limits: Limits,
        start: tuple[Array, float],
        relaxed: Mapping[Condition, float] | None = None,
        pinned: Array | None = None,
        forms: Forms | None = None,
    ) -> None:
        self.pinned = np.zeros((0, len(size))) if pinned is None else pinned[:, : len(size)]
        self.size, self.groups, self.lattice = size, tuple(groups), NODES
        self._build, self._objective, self._relaxed = build, objective, dict(relaxed or {})
        self._built: tuple[bytes, Machine] | None = None
        self._forms = forms or Forms()
        centres = np.array([group.centre for group in groups])
        if limits.scale is None:
            centres = np.clip(centres, *limits.centres(size))
        self.layout = Layout(size, centres, limits, objective.extremes)
        machine = self.machine(start[0])
        probe = np.zeros((1, len(machine.manipulator.axes)))
        self._conditions = [
            conditions_of(machine.manipulator, [machine.demands[name] for name in group.names], probe)
            for group in groups
        ]
        self.slots = [lattice(3, len(size)) for _ in groups]
        if objective.extremes:
            first = self._survey(machine, Point(start[0], centres, start[1], np.zeros(0)))[1]
            self.layout = self.layout.with_reference(np.where(np.isfinite(first), first, 1.0))
        self.start = self.layout.pack(Point(start[0], centres, start[1], np.array(self.layout.reference)))
        self.lower, self.upper = self.layout.box()
        self.scale = np.ones(len(self.lower))
        self.has_factor = bool((objective.on_factor > 0).any())

    def cuboids(self, x: Array) -> list[Cuboid]:
        """The cuboid of each group at x."""
        point = self.layout.unpack(x)
        return [Cuboid.around(centre, point.scale * self.size) for centre in point.centres]

    def machine(self, design: Array) -> Machine:
        """The machine of a scaled design; the last one is remembered."""
        key = design.tobytes()
        if self._built is None or self._built[0] != key:
            self._built = (key, self._build(design))
        return self._built[1]

    # What a point is worth.

    def assess(self, x: Array) -> Assessment:
        """Judge x over the whole of its cuboids; the critical points found join."""
        hopeless = Assessment(x, np.inf, np.inf)
        point = self.layout.unpack(x)
        try:
            machine = self.machine(point.design)
        except UnbuildableDesign:
            return hopeless
        violation, extremes = self._survey(machine, point)
        point = point._replace(extremes=extremes)
        if not np.isfinite([violation, *extremes]).all():
            return hopeless
        g, soft = self._objective.rows(machine, point), self._objective.on_factor
        hard = self._objective.on_slack
        factor = float(np.max(g[soft > 0] / soft[soft > 0])) if self.has_factor else 0.0
        rows = [0.0, violation, *(g[hard > 0] / hard[hard > 0]), *self.layout.limits.rows(self.size, point)]
        if not np.isfinite([factor, *rows]).all():
            return hopeless
        return Assessment(self.layout.pack(point), factor, max(rows))

    def _survey(self, machine: Machine, point: Point) -> tuple[float, Array]:
        """The worst excess over all cuboids, and the extremes; near-worst points join the slots."""
        worst, extremes = -np.inf, np.full(len(self._objective.extremes), -np.inf)
        for g, conditions in enumerate(self._conditions):
            mine = self._extremes_of(g)
            functions, known = self._functions(machine, point, g), self._known(point, g)
            peaks = find_peaks(functions, len(self.size), known, self.lattice)
            greatest = peaks.greatest(len(conditions) + len(mine))
            worst = max(worst, float(greatest[: len(conditions)].max(initial=-np.inf)))
            extremes[mine] = np.maximum(extremes[mine], greatest[len(conditions) :])
            for u in peaks.u[np.isfinite(peaks.value)]:
                apart = np.abs(self.slots[g] - u).max(axis=1) > SAME
                self.slots[g] = np.vstack([self.slots[g][apart], u])
        return worst, np.array([e.sign for e in self._objective.extremes]) * extremes

    def _functions(self, machine: Machine, point: Point, g: int) -> Callable[[Array], Array]:
        """Rows of group g, conditions then extremes, as functions of u."""

        def functions(u: Array) -> Array:
            sample = Sample(machine, self._poses(machine, [point], g, u))
            return sample.rows(self._conditions[g], self._asked(g), self._relaxed)

        return functions

    def _extremes_of(self, g: int) -> list[int]:
        """Numbers of the extremes that group g decides: those of its measures, and of all joints."""
        names = self.groups[g].names
        return [k for k, e in enumerate(self._objective.extremes) if isinstance(e.of, int) or e.of in names]

    def _asked(self, g: int) -> list[Extreme]:
        return [self._objective.extremes[k] for k in self._extremes_of(g)]

    def _poses(self, machine: Machine, points: Sequence[Point], g: int, u: Array) -> Poses:
        """Poses (v·s, d) at u (s, d) of group g's cuboid at each of v points, read-only."""
        centres = np.array([point.centres[g] for point in points])
        scales = np.array([point.scale for point in points])
        spread = centres[:, None, :] + scales[:, None, None] * self.size * u
        poses = np.zeros((len(points) * len(u), len(machine.manipulator.axes)))
        poses[:, : u.shape[1]] = spread.reshape(-1, u.shape[1])
        poses.flags.writeable = False
        return poses

    def _known(self, point: Point, g: int) -> Array:
        """Where to look for critical points beside the lattice: those of before, and the pinned poses."""
        u = (self.pinned - point.centres[g]) / (point.scale * self.size)
        return np.vstack([self.slots[g], u[(np.abs(u) <= 0.5).all(axis=1)]])

    # The subproblem at a point.

    def rows(self, x: Array) -> Rows:
        """Which terms enter at which slots: numbers, placement and objective as half-lines, then forms."""
        point = self.layout.unpack(x)
        machine = self.machine(point.design)
        chosen = [part for g in range(len(self.groups)) for part in self._choose(machine, point, g)]
        numbers = tuple(part for part in chosen if part.form is None)
        count = sum(len(part.at) for part in numbers) + len(self.layout.limits.rows(self.size, point))
        on_factor = np.concatenate([np.zeros(count), self._objective.on_factor])
        on_slack = np.concatenate([np.ones(count), self._objective.on_slack])
        forms, blocks = [], []
        stop = len(on_factor)
        for part in chosen:
            if part.form is not None:
                forms.append(part)
                blocks.append(Block(part.form, stop, len(part.at)))
                stop = blocks[-1].stop
        selection = _Selection(numbers, tuple(forms), tuple(self.slots))
        return Rows(tuple(blocks), HalfLines(0, on_factor, on_slack), selection)

    def _choose(self, machine: Machine, point: Point, g: int) -> Iterator[_Chosen]:
        terms: list[Condition | Extreme] = [*self._conditions[g], *self._asked(g)]
        values = self._functions(machine, point, g)(self.slots[g])
        for k, e in enumerate(self._extremes_of(g), start=len(self._conditions[g])):
            values[k] = self._gap(e, values[k], point)
        keep = worst_points(values, self.slots[g])
        self.slots[g], values = self.slots[g][keep], values[:, keep]
        worse = wanted_worse(self._objective, machine, point)
        for term, row in zip(terms, values, strict=True):
            if row.max() == -np.inf:  # A bound that holds by any factor at every slot needs no row.
                continue
            at = np.union1d(np.flatnonzero(row > -RELEVANT), row.argmax())
            yield _Chosen(g, term, at, self._template(machine, term, point, g))
            if isinstance(term, Extreme) and term in worse:
                yield _Chosen(g, term, np.array([row.argmax()]), sign=-1.0)

    def _gap(self, e: int, signed: Array, point: Point) -> Array:
        """How far values (signed as `Sample.rows` gives them) exceed their extreme, in its unit."""
        extreme = self._objective.extremes[e].sign * point.extremes[e]
        return np.asarray((signed - extreme) / self.layout.unit[e])

    def _template(self, machine: Machine, term: Condition | Extreme, point: Point, g: int) -> Template | None:
        """The convex form of a measure's side, where it has one and its bound is positive."""
        if isinstance(term.of, int) or term.of not in machine.demands or term.side is None:
            return None
        if self._bound(machine, term, point) <= 0:
            return None
        pose = self._poses(machine, [point], g, np.zeros((1, len(self.size))))
        return self._forms.template(machine, term.of, term.side, pose)

    def _bound(self, machine: Machine, term: Condition | Extreme, point: Point) -> float:
        if isinstance(term, Extreme):
            return float(point.extremes[self._objective.extremes.index(term)])
        bound = machine.demands[term.name].bounds[str(term.side)]
        sign = 1.0 if term.side == "at_most" else -1.0
        return bound * float(np.exp(sign * self._relaxed.get(term, 0.0)))

    def smooth(self, points: Array, rows: Rows) -> Array:
        """Each x's w (n, k): numbers, placement, objective, then (inside, bound, ln bound) of each form."""
        last = max(rows.half_lines.stop, *(block.stop for block in rows.blocks), 0)
        w = np.full((len(points), last), np.nan)
        unpacked = [self.layout.unpack(x) for x in points]
        designs: dict[bytes, list[int]] = {}
        for i, point in enumerate(unpacked):
            designs.setdefault(point.design.tobytes(), []).append(i)
        for same in designs.values():
            try:
                machine = self.machine(unpacked[same[0]].design)
            except UnbuildableDesign:
                continue
            w[same] = self._w(machine, [unpacked[i] for i in same], rows.selection)
        return w

    def _w(self, machine: Machine, points: Sequence[Point], selection: _Selection) -> Array:
        # One read-only block for numbers and forms: the machine computes it once.
        poses = [self._poses(machine, points, g, slots) for g, slots in enumerate(selection.slots)]
        parts = self._numbers(machine, points, selection, poses)
        parts.append(np.array([self.layout.limits.rows(self.size, point) for point in points]))
        parts.append(np.array([self._objective.rows(machine, point) for point in points]))
        parts += self._insides(machine, points, selection, poses)
        return np.concatenate([part.reshape(len(points), -1) for part in parts], axis=1)

    def _numbers(
        self, machine: Machine, points: Sequence[Point], selection: _Selection, poses: Sequence[Poses]
    ) -> list[Array]:
        parts = []
        for g, slots in enumerate(selection.slots):
            mine = [part for part in selection.numbers if part.group == g]
            conditions = [part.term for part in mine if isinstance(part.term, Condition)]
            asked = [part.term for part in mine if isinstance(part.term, Extreme)]
            sample = Sample(machine, poses[g])
            values = sample.rows(conditions, asked, self._relaxed)
            for part, value in zip(mine, values.reshape(-1, len(points), len(slots)), strict=True):
                if isinstance(part.term, Extreme):
                    e = self._objective.extremes.index(part.term)
                    value = np.array([self._gap(e, v, p) for v, p in zip(value, points, strict=True)])
                parts.append(part.sign * value[:, part.at])
        return parts

    def _insides(
        self, machine: Machine, points: Sequence[Point], selection: _Selection, poses: Sequence[Poses]
    ) -> list[Array]:
        parts = []
        for part in selection.forms:
            given = inside_of(machine, str(part.term.of), str(part.term.side), poses[part.group])
            inside = given.reshape(len(points), len(selection.slots[part.group]), -1)[:, part.at]
            bound = np.array([self._bound(machine, part.term, point) for point in points])
            with np.errstate(divide="ignore", invalid="ignore"):
                pair = np.stack([bound, np.log(bound)], axis=-1)
            spread = np.broadcast_to(pair[:, None, :], (*inside.shape[:2], 2))
            parts.append(np.concatenate([inside, spread], axis=2))
        return parts

    def drift(self, x: Array, rows: Rows, step: Step) -> Array:
        """Curvature from critical points that move with x: see `orthospec.workspace.drift`."""
        selection: _Selection = rows.selection
        total = np.zeros((len(x), len(x)))
        box = Box(self.lower, self.upper, self.scale)
        for g, slots in enumerate(selection.slots):
            weights = self._pressures(rows, step, g)
            moving = (weights != 0).any(axis=0) & (np.abs(slots) < 0.5 - INSIDE).any(axis=1)
            if moving.any():
                values = partial(self._excesses, g)
                total += moving_curvature(values, weights[:, moving], slots[moving], x, box)
        return total

    def _pressures(self, rows: Rows, step: Step, g: int) -> Array:
        """The multiplier (k, s) of each condition and extreme of group g at each slot, in its excess."""
        selection: _Selection = rows.selection
        terms = [*self._conditions[g], *self._asked(g)]
        weights = np.zeros((len(terms), len(selection.slots[g])))
        for chosen, share in _shares(rows, step):
            if chosen.group == g:
                weights[terms.index(chosen.term), chosen.at] += chosen.sign * share
        weights[np.abs(weights) < NEGLIGIBLE * np.abs(weights).max(initial=0.0)] = 0.0
        return weights

    def _excesses(self, g: int, x: Array, u: Array) -> Array:
        """Rows of group g at points u of x as they enter the subproblem, each but for a constant."""
        point = self.layout.unpack(x)
        try:
            machine = self.machine(point.design)
        except UnbuildableDesign:
            return np.full((len(self._conditions[g]) + len(self._asked(g)), len(u)), np.nan)
        values = self._functions(machine, point, g)(u)
        for k, e in enumerate(self._extremes_of(g), start=len(self._conditions[g])):
            extreme = self._objective.extremes[e]
            ratio = self._template(machine, extreme, point, g) is not None
            with np.errstate(invalid="ignore", divide="ignore"):
                values[k] = (
                    extreme.sign * np.log(extreme.sign * values[k])
                    if ratio
                    else values[k] / self.layout.unit[e]
                )
        return values

    # What an answer says of the conditions.

    def critical(self, x: Array, within: float) -> dict[Condition, list[tuple[float, ...]]]:
        """The poses where each condition is within so much of its bound, or exceeds it, the worst first."""
        point = self.layout.unpack(x)
        machine = self.machine(point.design)
        self._survey(machine, point)
        found: dict[Condition, list[tuple[float, ...]]] = {}
        for g, conditions in enumerate(self._conditions):
            values = self._functions(machine, point, g)(self.slots[g])
            poses = self._poses(machine, [point], g, self.slots[g])
            for condition, row in zip(conditions, values, strict=False):
                near = [k for k in np.argsort(-row, kind="stable") if row[k] >= -within]
                found.setdefault(condition, []).extend(tuple(map(float, poses[k])) for k in near)
        return found

    def shares(self, rows: Rows, step: Step) -> dict[Condition, float]:
        """The part of the pressure on the slack that each condition has."""
        found: dict[Condition, float] = {}
        for chosen, share in _shares(rows, step):
            if isinstance(chosen.term, Condition):
                found[chosen.term] = found.get(chosen.term, 0.0) + float(share.sum())
        return found


def _shares(rows: Rows, step: Step) -> Iterator[tuple[_Chosen, Array]]:
    """What each term has of the pressure on the slack at each of its slots."""
    at, forms = 0, rows.half_lines.stop
    for chosen in rows.selection.numbers:
        yield chosen, step.shares[at : at + len(chosen.at)]
        at += len(chosen.at)
    for chosen in rows.selection.forms:
        yield chosen, step.shares[forms : forms + len(chosen.at)]
        forms += len(chosen.at)

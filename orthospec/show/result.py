"""A result as a person reads it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from orthospec.result import Result
from orthospec.result.model import (
    DesignRecord,
    Ends,
    LargestRecord,
    MeasureRecord,
    PrescribedRecord,
    ProofRecord,
)
from orthospec.show import machine, words
from orthospec.show.labels import Field, Labels, labels
from orthospec.show.numbers import UNKNOWN, Numbers
from orthospec.show.page import Page

if TYPE_CHECKING:
    from orthospec.spec import Spec

MOST_POSES = 4
"""Poses of one limit that are listed; a symmetric machine has many alike."""


def show(content: Mapping[str, Any], *, width: int, colour: bool, spec: Spec | None = None) -> str:
    """The text of a result; with its spec, units, bounds and the goals' words are in it too."""
    result = Result.model_validate(content)
    known = labels(spec, result.variables)
    page = Page(width=width, colour=colour)
    _Writer(page, result, known, Numbers(is_small(result, known))).write()
    return str(page)


def is_small(result: Result, known: Labels) -> bool:
    """Whether the prescribed cuboid is smaller than a metre."""
    size = list(known.size)
    places = [result.workspace.prescribed, *(one.prescribed for one in result.workspace.measures.values())]
    for place in places:
        if place is not None and not size:
            size = [(b or 0.0) - (a or 0.0) for a, b in zip(place.min, place.max, strict=True)]
    return bool(size) and max(size) < 1.0


@dataclass(frozen=True)
class _Writer:
    page: Page
    result: Result
    known: Labels
    numbers: Numbers

    def write(self) -> None:
        self._status()
        self._goals()
        self._variables()
        self._machine()
        self._workspace()
        self._measures()
        self._limits()
        self._card()
        self._branches()
        self._pareto()
        self._sweep()
        self._errors()

    def _status(self) -> None:
        self.page.heading(self.result.title or str(self.result.manipulator["use"]))
        manner, said = words.status(self.result)
        self.page.sentence(said, manner=manner)
        if self.result.search is not None:
            self.page.sentence(words.searched(self.result.search))

    def _goals(self) -> None:
        attainment = self.result.attainment
        if attainment is None:
            return
        self.page.heading("Goals")
        rows = [tuple(self.page.paint(head, "dim") for head in ("", "value", "aimed at", "weight", "", ""))]
        for name, goal in attainment.goals.items():
            aim = self.known.goals.get(name)
            unit = aim.unit if aim else UNKNOWN
            weight = words.weight(goal.weight, aim)
            value, target = self.numbers.value(goal.value, unit), self.numbers.value(goal.goal, unit)
            gap = None if goal.value is None else abs(goal.value - goal.goal)
            missed = "missed" if gap is None else f"missed by {self.numbers.value(gap, unit)}"
            verdict = self.page.paint("met", "good") if goal.attained else self.page.paint(missed, "warn")
            rows.append((name, value, target, weight, verdict, aim.words if aim else ""))
        self.page.rows(rows, right=frozenset({1, 2, 3}))

    def _variables(self) -> None:
        if not self.result.variables:
            return
        self.page.heading("Design variables")
        rows = []
        for name, value in self.result.variables.items():
            unit, range_ = self.known.variables.get(name, UNKNOWN), self.known.ranges.get(name)
            within = words.within(range_, unit, self.numbers) if range_ else ""
            rows.append((name, self.numbers.value(value, unit), within))
        self.page.rows(rows, right=frozenset({1}))

    def _machine(self) -> None:
        keys = dict(self.result.manipulator)
        source = self.result.provenance.get("from")
        self.page.heading(f"Machine: {keys.pop('use')}" + (f", from {source['path']}" if source else ""))
        fields = machine.fields(keys, self.known.fields, self.numbers)
        indices = machine.indices(self.result.indices, self.known.indices, self.numbers)
        joints = self._joints(self.result.joints) if self.result.joints else ()
        off = machine.tolerances(self.known.tolerances, self.known.fields, self.numbers)
        self.page.rows([*fields, *off, *indices, *joints])

    def _joints(self, joints: Ends) -> Iterator[tuple[str, str]]:
        """The range of each joint over the prescribed cuboid; equal ones in one line."""
        units = (*self.known.joints, *[UNKNOWN] * len(joints.min))
        texts = [self.numbers.interval(*end) for end in zip(joints.min, joints.max, units, strict=False)]
        for text in dict.fromkeys(texts):
            which = [str(k) for k, other in enumerate(texts, start=1) if other == text]
            yield f"joint{'s' if len(which) > 1 else ''} {', '.join(which)}", text

    def _workspace(self) -> None:
        workspace = self.result.workspace
        if workspace.joint is None:
            return
        self.page.heading("Workspace")
        if workspace.prescribed is not None:
            self._prescribed(workspace.prescribed)
        else:
            self.page.sentence("prescribed cuboid: no place was found for it", manner="bad")
        self._largest(workspace.joint)

    def _prescribed(self, place: PrescribedRecord, indent: int = 2) -> None:
        size = self.numbers.edges(place.min, place.max, self.known.axes)
        verdict = ("every bound holds", "good") if place.holds else ("not every bound holds", "bad")
        text = f"{size}, {self.page.paint(*verdict)}"
        self.page.rows([("prescribed cuboid", text)], indent=indent)
        self._corners(place, indent + 2)
        self._proof(place.proof, indent + 2)

    def _proof(self, proof: ProofRecord | None, indent: int) -> None:
        if proof is None:
            return
        at = None if proof.at is None else self.numbers.pose(proof.at, self.known.axes)
        for name, values in (proof.machine or {}).items():
            units = self.known.fields.get((name,), Field()).units or (UNKNOWN,)
            at = f"{at} with {name} {self.numbers.several(values, units[0])}"
        manner, said = words.proof(proof, at)
        self.page.sentence(said, manner=manner, indent=indent)

    def _largest(self, largest: LargestRecord) -> None:
        if largest.min is None or largest.max is None:
            self.page.rows([("largest cuboid   ", "none")])
        else:
            size = self.numbers.edges(largest.min, largest.max, self.known.axes)
            self.page.rows([("largest cuboid   ", f"{size}, scale {largest.scale:.6g}")])
            self._corners(Ends(min=list(largest.min), max=list(largest.max)), 4)
        places = f" in {largest.ties} places" if largest.ties > 1 else ""
        self.page.sentence(f"on the grid alone: scale {largest.grid_scale:.6g}{places}", indent=4)
        self.page.sentence(f"nodes: {words.nodes(largest.nodes)}", indent=4)
        if largest.proved is not None:
            self.page.sentence(f"proved of the scale: {words.between(largest.proved)}", indent=4)

    def _corners(self, ends: Ends, indent: int) -> None:
        for label, corner in (("from", ends.min), ("to  ", ends.max)):
            self.page.rows([(label, self.numbers.pose(corner, self.known.axes))], indent=indent)

    def _measures(self) -> None:
        if not self.result.workspace.measures:
            return
        self.page.heading("Measures over the prescribed cuboid")
        for name, record in self.result.workspace.measures.items():
            asked = self.known.measures.get(name)
            unit = asked.unit if asked else UNKNOWN
            self.page.sentence(words.asked(name, asked, self.numbers) if asked else name)
            self.page.rows(list(self._measure(record, unit)), indent=4)
            self.page.rows(list(self._poses(record, unit)), indent=4)
            if record.prescribed is not None:
                self._prescribed(record.prescribed, indent=4)

    def _measure(self, record: MeasureRecord, unit: str) -> Iterator[tuple[str, ...]]:
        numbers = self.numbers
        for name, extreme in (("lowest", record.lowest), ("highest", record.highest)):
            at = f"at {numbers.pose(extreme.at, self.known.axes)}" if extreme else "not known: out of reach"
            yield name, numbers.value(extreme.value if extreme else None, unit), at
        if record.scale is not None and record.grid_scale is not None:
            yield "own scale", f"{record.scale:.6g}", f"on the grid alone {record.grid_scale:.6g}"
            if record.proved is not None and self.result.workspace.joint is None:
                yield "", "", f"proved {words.between(record.proved)}"
        for level in record.levels:
            bound = words.bounds(numbers, {side: getattr(level, side) for side in words.SIDES}, unit)
            yield f"scale, {bound}", f"{level.scale:.6g}", f"on the grid alone {level.grid_scale:.6g}"

    def _poses(self, record: MeasureRecord, unit: str) -> Iterator[tuple[str, str]]:
        for name, values in record.poses.items():
            yield f"at {name}", words.at_pose(self.numbers, values, unit)

    def _limits(self) -> None:
        if not self.result.limits:
            return
        search = self.result.search
        conflict = self.result.status == "infeasible" or bool(search and search.conflicts)
        self.page.heading("What conflicts" if conflict else "What limits the design")
        for limit in words.together(self.result.limits):
            self.page.sentence(words.limiting(limit, self.known, self.numbers))
            poses = list(dict.fromkeys(self.numbers.pose(pose, self.known.axes) for pose in limit.at))
            for pose in poses[:MOST_POSES]:
                self.page.sentence(f"at {pose}", indent=4)
            if len(poses) > MOST_POSES:
                self.page.sentence(f"and at {len(poses) - MOST_POSES} more", indent=4)
            self.page.sentence(words.price(limit), indent=4)
        free = [words.limiting(one, self.known, self.numbers) for one in words.free(self.result.limits)]
        if free:
            self.page.sentence(f"reached too, without gain or cost: {'; '.join(free)}")

    def _card(self) -> None:
        """The conflict taken apart: each condition, its place, and by how much it would have to give way."""
        card = self.result.search.card if self.result.search else None
        if card is None:
            return
        if card.conflict:
            few = "; without any one of them a design was found" if card.irreducible else ""
            self.page.heading("What would have to give way")
            self.page.sentence(f"These cannot all hold{few}.")
        for one in card.conflict:
            said, way = words.way_out(one, self.known, self.numbers)
            self.page.sentence(f"{said} ({one.place})")
            self.page.sentence(way, indent=4)
        self.page.sentence(words.ways_out(card))

    def _pareto(self) -> None:
        """The Pareto set, one row a design: the goals, then the variables."""
        front = self.result.pareto
        if not front:
            return
        self.page.heading(f"Pareto set: {words.counted(len(front), 'design')}")
        search = self.result.search
        if search is not None and search.pareto is not None:
            self.page.sentence(words.searched_for_front(search.pareto))
        soft = [
            n for n, goal in (front[0].attainment.goals if front[0].attainment else {}).items() if goal.weight
        ]
        names = list(front[0].variables)
        rows = []
        for number, one in enumerate(front, start=1):
            goals = one.attainment.goals if one.attainment else {}
            units = {n: self.known.goals[n].unit if n in self.known.goals else UNKNOWN for n in soft}
            row = [self.numbers.value(goals[n].value, units[n]) for n in soft]
            row += [self.numbers.value(one.variables[n], self.known.variables.get(n, UNKNOWN)) for n in names]
            rows.append([f"{number} knee" if one.knee else f"{number}", *row])
        self.page.table(["", *soft, *names], rows)

    def _branches(self) -> None:
        """What each combination of choices came to."""
        search = self.result.search
        if search is None or not search.branches:
            return
        self.page.heading("Choices")
        left_out = (search.combinations or 0) - len(search.branches)
        if left_out:
            self.page.sentence(
                f"Of {search.combinations} combinations the {len(search.branches)} best on a coarse grid."
            )
        names = list(search.branches[0].choices)
        rows = []
        for one in search.branches:
            values = [self.numbers.value(one.choices[n], self.known.variables.get(n, UNKNOWN)) for n in names]
            rows.append([*values, words.branch(one), words.behind(one, search.branches[0])])
        self.page.table([*names, "λ", ""], rows)

    def _sweep(self) -> None:
        sweep = self.result.sweep
        if not sweep:
            return
        names = [n for n in sweep[0].variables if len({one.variables.get(n) for one in sweep}) > 1]
        self.page.heading(f"Sweep along {', '.join(names)}")
        head = [*names, "holds", *(["scale"] if sweep[0].workspace.joint else [])]
        for name, record in sweep[0].workspace.measures.items():
            head += [f"{name} lowest", f"{name} highest", *(f"{name} at {pose}" for pose in record.poses)]
        self.page.table(head, [self._swept(one, names) for one in sweep])

    def _swept(self, one: DesignRecord, names: list[str]) -> list[str]:
        numbers, workspace = self.numbers, one.workspace
        row = [numbers.value(one.variables.get(n), self.known.variables.get(n, UNKNOWN)) for n in names]
        row.append("yes" if words.holds(one) else "no")
        if workspace.joint is not None:
            row.append(f"{workspace.joint.scale:.6g}")
        for name, record in workspace.measures.items():
            unit = self.known.measures[name].unit if name in self.known.measures else UNKNOWN
            ends = [end.value if end else None for end in (record.lowest, record.highest)]
            row += [numbers.value(end, unit) for end in ends]
            row += [words.at_pose(numbers, values, unit) for values in record.poses.values()]
        return row

    def _errors(self) -> None:
        if not self.result.errors:
            return
        self.page.heading("Failures")
        for error in self.result.errors:
            place = f" ({error.place})" if error.place else ""
            self.page.sentence(f"{error.name}{place}: {error.message}", manner="bad")

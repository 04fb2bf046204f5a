"""A result as a person reads it in a terminal."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from orthospec.result.model import Ends, LargestRecord, PrescribedRecord
from orthospec.show import tables, words
from orthospec.show.page import Page
from orthospec.show.reading import Reading, read

if TYPE_CHECKING:
    from orthospec.spec import Spec

MOST_POSES = 4
"""Poses of one limit that are listed; a symmetric machine has many alike."""


def show(content: Mapping[str, Any], *, width: int, colour: bool, spec: Spec | None = None) -> str:
    """The text of a result; with its spec, units, bounds and the goals' words are in it too."""
    page = Page(width=width, colour=colour)
    _Writer(page, read(content, spec)).write()
    return str(page)


@dataclass(frozen=True)
class _Writer:
    page: Page
    reading: Reading

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
        self._told()

    def _status(self) -> None:
        result = self.reading.result
        self.page.heading(result.title or str(result.manipulator["use"]))
        manner, said = words.status(result)
        self.page.sentence(said, manner=manner)
        self.page.sentence(words.searched(result))

    def _goals(self) -> None:
        if self.reading.result.attainment is None:
            return
        self.page.heading("Goals")
        rows = [tuple(self.page.paint(head, "dim") for head in ("", "value", "aimed at", "weight", "", ""))]
        for goal in tables.goals(self.reading):
            verdict = self.page.paint(goal.verdict, goal.manner)
            rows.append((goal.name, goal.value, goal.goal, goal.weight, verdict, goal.words))
        self.page.rows(rows, right=frozenset({1, 2, 3}))

    def _variables(self) -> None:
        if self.reading.result.variables:
            self.page.heading("Design variables")
            self.page.rows(tables.variables(self.reading), right=frozenset({1}))

    def _machine(self) -> None:
        self.page.heading(tables.machine_heading(self.reading))
        self.page.rows(tables.machine(self.reading))

    def _workspace(self) -> None:
        workspace = self.reading.result.workspace
        if workspace.joint is None:
            return
        self.page.heading("Workspace")
        if workspace.prescribed is not None:
            self._prescribed(workspace.prescribed)
        else:
            self.page.sentence(words.NO_PLACE, manner="bad")
        self._largest(workspace.joint)

    def _prescribed(self, place: PrescribedRecord, indent: int = 2) -> None:
        manner, verdict = words.holding(place)
        size = tables.prescribed(self.reading, place)
        self.page.rows([("prescribed cuboid", f"{size}, {self.page.paint(verdict, manner)}")], indent=indent)
        self._corners(place, indent + 2)
        if place.proof is not None:
            manner, said = tables.proof(self.reading, place.proof)
            self.page.sentence(said, manner=manner, indent=indent + 2)

    def _largest(self, largest: LargestRecord) -> None:
        self.page.rows([("largest cuboid   ", tables.largest(self.reading, largest))])
        if largest.min is not None and largest.max is not None:
            self._corners(Ends(min=list(largest.min), max=list(largest.max)), 4)
        for said in tables.on_the_grid(largest):
            self.page.sentence(said, indent=4)

    def _corners(self, ends: Ends, indent: int) -> None:
        for label, corner in (("from", ends.min), ("to  ", ends.max)):
            at = self.reading.numbers.pose(corner, self.reading.known.axes)
            self.page.rows([(label, at)], indent=indent)

    def _measures(self) -> None:
        measures, known = self.reading.result.workspace.measures, self.reading.known.measures
        if measures:
            self.page.heading(tables.measures_heading(self.reading))
        for name, record in measures.items():
            asked = known.get(name)
            self.page.sentence(words.asked(name, asked, self.reading.numbers) if asked else name)
            self.page.rows(list(tables.measure(self.reading, name, record)), indent=4)
            self.page.rows(list(tables.at_poses(self.reading, name, record)), indent=4)
            if record.prescribed is not None:
                self._prescribed(record.prescribed, indent=4)

    def _limits(self) -> None:
        result, known, numbers = self.reading.result, self.reading.known, self.reading.numbers
        if not result.limits:
            return
        self.page.heading(words.limits_heading(result))
        for limit in words.together(result.limits):
            self.page.sentence(words.limiting(limit, known, numbers))
            poses = list(dict.fromkeys(numbers.pose(pose, known.axes) for pose in limit.at))
            for pose in poses[:MOST_POSES]:
                self.page.sentence(f"at {pose}", indent=4)
            if len(poses) > MOST_POSES:
                self.page.sentence(f"and at {len(poses) - MOST_POSES} more", indent=4)
            self.page.sentence(words.price(limit), indent=4)
        free = words.reached_too(result.limits, known, numbers)
        if free:
            self.page.sentence(free)

    def _card(self) -> None:
        """The conflict taken apart: each condition, its place, and by how much it would have to give way."""
        search = self.reading.result.search
        card = search.card if search else None
        if card is None:
            return
        if card.conflict:
            self.page.heading("What would have to give way")
            self.page.sentence(words.conflict(card))
        for one in card.conflict:
            said, way = words.way_out(one, self.reading.known, self.reading.numbers)
            self.page.sentence(f"{said} ({one.place})")
            self.page.sentence(way, indent=4)
        self.page.sentence(words.ways_out(card))

    def _pareto(self) -> None:
        """The Pareto set, one row a design."""
        front, search = self.reading.result.pareto, self.reading.result.search
        if not front:
            return
        self.page.heading(f"Pareto set: {words.counted(len(front), 'design')}")
        if search is not None and search.pareto is not None:
            self.page.sentence(words.searched_for_front(search.pareto))
        self.page.table(*tables.pareto(self.reading))

    def _branches(self) -> None:
        """What each combination of choices came to."""
        told = tables.branches(self.reading)
        if told is None:
            return
        said, table = told
        self.page.heading("Choices")
        if said:
            self.page.sentence(said)
        self.page.table(*table)

    def _sweep(self) -> None:
        sweep = self.reading.result.sweep
        if sweep:
            self.page.heading(f"Sweep along {', '.join(tables.varied(sweep))}")
            self.page.table(*tables.sweep(self.reading))

    def _told(self) -> None:
        """What failed, and what was done otherwise than asked for."""
        result = self.reading.result
        for heading, several, manner in (("Failures", result.errors, "bad"), ("Notes", result.notes, "")):
            if several:
                self.page.heading(heading)
            for one in several:
                self.page.sentence(words.told(one), manner=manner)

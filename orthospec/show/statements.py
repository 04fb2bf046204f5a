"""The sentences about a result that stand beside its tables, by the section they belong to."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

from orthospec.show import words
from orthospec.show.labels import Field, Labels
from orthospec.show.numbers import UNKNOWN, Numbers

if TYPE_CHECKING:
    from orthospec.result import Result
    from orthospec.result.model import LargestRecord, PrescribedRecord


@dataclass(frozen=True)
class Statement:
    """A sentence."""

    section: str
    text: str
    manner: str = ""
    """good, warn or bad; nothing for what is just so."""


def statements(result: Result, known: Labels, numbers: Numbers) -> Iterator[Statement]:
    """What is to be said, in order."""
    yield from _asked(known, numbers)
    yield from _workspace(result, known, numbers)
    yield from _limits(result, known, numbers)
    yield from _search(result)
    for error in result.errors:
        place = f" ({error.place})" if error.place else ""
        yield Statement("failures", f"{error.name}{place}: {error.message}", "bad")


def _asked(known: Labels, numbers: Numbers) -> Iterator[Statement]:
    if known.size:
        nothing = (0.0,) * len(known.size)
        yield Statement(
            "asked", f"A cuboid of {numbers.edges(nothing, known.size, known.axes)}, in which holds:"
        )
    for name, measure in known.measures.items():
        yield Statement("asked", words.asked(name, measure, numbers))
    for name, aim in known.goals.items():
        yield Statement("asked", f"goal {name}: {aim.words}")


def _workspace(result: Result, known: Labels, numbers: Numbers) -> Iterator[Statement]:
    workspace = result.workspace
    if workspace.joint is None:
        for name, record in workspace.measures.items():
            if record.prescribed is not None:
                yield from _prescribed(record.prescribed, known, numbers, f"The cuboid of {name}")
        return
    if workspace.prescribed is None:
        yield Statement("workspace", "No place was found for the prescribed cuboid.", "bad")
    else:
        yield from _prescribed(workspace.prescribed, known, numbers, "The prescribed cuboid")
    yield from _largest(workspace.joint, known, numbers)


def _prescribed(place: PrescribedRecord, known: Labels, numbers: Numbers, what: str) -> Iterator[Statement]:
    corners = [numbers.pose(end, known.axes) for end in (place.min, place.max)]
    size = numbers.edges(place.min, place.max, known.axes)
    yield Statement("workspace", f"{what}, {size}, stands from {corners[0]} to {corners[1]}.")
    verdict = ("Every bound holds in it.", "good") if place.holds else ("Not every bound holds in it.", "bad")
    yield Statement("workspace", *verdict)
    if place.proof is not None:
        at = None if place.proof.at is None else numbers.pose(place.proof.at, known.axes)
        for name, values in (place.proof.machine or {}).items():
            units = known.fields.get((name,), Field()).units or (UNKNOWN,)
            at = f"{at} with {name} {numbers.several(values, units[0])}"
        manner, said = words.proof(place.proof, at)
        yield Statement("workspace", f"{said[:1].upper()}{said[1:]}.", manner)


def _largest(largest: LargestRecord, known: Labels, numbers: Numbers) -> Iterator[Statement]:
    if largest.min is None or largest.max is None:
        yield Statement("workspace", "No cuboid was found in which everything holds.", "bad")
        return
    size = numbers.edges(largest.min, largest.max, known.axes)
    corners = [numbers.pose(end, known.axes) for end in (largest.min, largest.max)]
    yield Statement(
        "workspace",
        f"The largest cuboid of these proportions in which everything holds is {size}, {largest.scale:.6g}"
        f" times the prescribed one, from {corners[0]} to {corners[1]}.",
    )
    if largest.proved is not None:
        yield Statement("workspace", f"Proved of that scale: {words.between(largest.proved)}.", "good")
    yield Statement("workspace", f"Nodes of the grid: {words.nodes(largest.nodes)}.")


def _limits(result: Result, known: Labels, numbers: Numbers) -> Iterator[Statement]:
    free = [words.limiting(one, known, numbers) for one in words.free(result.limits)]
    if free:
        yield Statement("limits", f"Reached too, without gain or cost: {'; '.join(free)}.")
    card = result.search.card if result.search else None
    if card is not None:
        if card.conflict:
            few = "; without any one of them a design was found" if card.irreducible else ""
            yield Statement("conflict", f"These cannot all hold{few}.")
        if words.ways_out(card):
            yield Statement("conflict", words.ways_out(card))


def _search(result: Result) -> Iterator[Statement]:
    search = result.search
    if search is None:
        return
    yield Statement("search", words.searched(search))
    if search.subproblems:
        yield Statement(
            "search", f"The solve that was kept took {words.counted(search.subproblems, 'subproblem')}."
        )
    left_out = (search.combinations or 0) - len(search.branches)
    if search.branches and left_out:
        few = f"Of {search.combinations} combinations the {len(search.branches)} best on a coarse grid."
        yield Statement("choices", few)
    if search.pareto is not None:
        yield Statement("pareto", words.searched_for_front(search.pareto))

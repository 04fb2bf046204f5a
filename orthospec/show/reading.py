"""A result with what its names mean: what its texts, its page and its tables for papers are read from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from orthospec.result import Result
from orthospec.show.labels import Labels, labels
from orthospec.show.numbers import UNKNOWN, Numbers

if TYPE_CHECKING:
    from orthospec.spec import Spec


@dataclass(frozen=True)
class Reading:
    """One result, the units and words of its names, and how numbers are written."""

    result: Result
    known: Labels
    numbers: Numbers

    def unit_of_variable(self, name: str) -> str:
        """As the spec has it."""
        return self.known.variables.get(name, UNKNOWN)

    def unit_of_goal(self, name: str) -> str:
        """Of its value and of what is aimed at."""
        return self.known.goals[name].unit if name in self.known.goals else UNKNOWN

    def unit_of_measure(self, name: str) -> str:
        """Of its values and bounds."""
        return self.known.measures[name].unit if name in self.known.measures else UNKNOWN


def read(content: Mapping[str, Any] | Result, spec: Spec | None) -> Reading:
    """The reading of a result; with its spec, units, bounds and the goals' words are known too."""
    result = content if isinstance(content, Result) else Result.model_validate(content)
    known = labels(spec, result.variables)
    return Reading(result, known, Numbers(is_small(result, known)))


def is_small(result: Result, known: Labels) -> bool:
    """Whether the prescribed cuboid is smaller than a metre."""
    size = list(known.size)
    places = [result.workspace.prescribed, *(one.prescribed for one in result.workspace.measures.values())]
    for place in places:
        if place is not None and not size:
            size = [(b or 0.0) - (a or 0.0) for a, b in zip(place.min, place.max, strict=True)]
    return bool(size) and max(size) < 1.0

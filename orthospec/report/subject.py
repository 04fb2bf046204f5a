"""`Subject`: a solution as figures and tables are made from it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from orthospec.errors import OrthospecError
from orthospec.result.model import Ends
from orthospec.show import words
from orthospec.show.labels import Labels, labels
from orthospec.show.numbers import UNKNOWN, Numbers, in_unit
from orthospec.show.reading import is_small
from orthospec.solution import Lattice, Solution, sampled
from orthospec.workspace.cuboid import Cuboid

if TYPE_CHECKING:
    from collections.abc import Mapping

    from orthospec.arrays import Array
    from orthospec.result.model import Result
    from orthospec.spec import Design

NODES = 27
"""Nodes of the lattice along its longest edge, for surfaces."""


@dataclass(frozen=True)
class Subject:
    """A solution, what its names mean, and how its numbers are told."""

    solution: Solution

    @property
    def result(self) -> Result:
        """The content as records."""
        return self.solution.result

    @property
    def design(self) -> Design | None:
        """The machine and what is demanded of it, where these are known."""
        return self.solution.design

    @cached_property
    def known(self) -> Labels:
        """Units and words of the names in it."""
        return labels(self.solution.spec, self.result.variables)

    @cached_property
    def numbers(self) -> Numbers:
        """How its numbers are written."""
        return Numbers(is_small(self.result, self.known))

    def told(self, unit: str, values: Array | list[float]) -> tuple[Array, str]:
        """SI numbers in the unit that they are told in, and its name."""
        shown = self.numbers.shown(unit, list(np.ravel(np.asarray(values, dtype=float))))
        return in_unit(np.asarray(values, dtype=float), shown), shown

    def lengths(self, values: Array) -> Array:
        """Metres as lengths are told here."""
        return self.told("m", values)[0]

    @cached_property
    def place(self) -> Cuboid | None:
        """The prescribed cuboid where it stands; the largest one where no place was found for it."""
        workspace = self.result.workspace
        alone = [one.prescribed for one in workspace.measures.values()]
        for ends in (workspace.prescribed, *alone, workspace.joint):
            if ends is not None and ends.min and ends.max:
                return cuboid_of(Ends(min=list(ends.min), max=list(ends.max)))
        return None

    @cached_property
    def lattice(self) -> Lattice | None:
        """The reach, coarsely; None without a machine, or without an end of its reach."""
        spec = self.solution.spec
        if self.design is None or spec is None:
            return None
        try:
            alone = replace(self.design, demands=())
            return sampled(alone, spec.workspace.region, np.array(spec.workspace.size), NODES)
        except OrthospecError:
            return None


def cuboid_of(ends: Ends) -> Cuboid | None:
    """The cuboid between two corners; None where they are not known."""
    if None in (*ends.min, *ends.max):
        return None
    return Cuboid(
        tuple(float(x) for x in ends.min if x is not None), tuple(float(x) for x in ends.max if x is not None)
    )


def bound_side(bounds: Mapping[str, float]) -> str:
    """The side that is shown of a measure with two: the bounded one."""
    return "at_least" if "at_least" in bounds and "at_most" not in bounds else "at_most"


def nested(subject: Subject) -> list[tuple[str, Cuboid, float]]:
    """What is known of cuboids, with words, ends and scales; the prescribed one first."""
    workspace = subject.result.workspace
    scale = words.cuboid_scale(subject.result)
    found = [] if subject.place is None else [("prescribed", subject.place, scale)]
    if workspace.joint is not None:
        found += _one(
            "largest for all measures", workspace.joint.min, workspace.joint.max, workspace.joint.scale
        )
    for name, record in workspace.measures.items():
        asked = subject.known.measures.get(name)
        for level in record.levels:
            given = {side: getattr(level, side) for side in words.SIDES}
            bound = words.bounds(subject.numbers, given, asked.unit if asked else UNKNOWN)
            found += _one(f"{name} {bound}", level.min, level.max, level.scale)
    return _distinct(found)


def _distinct(found: list[tuple[str, Cuboid, float]]) -> list[tuple[str, Cuboid, float]]:
    """Without those that stand where one before them does."""
    kept: list[tuple[str, Cuboid, float]] = []
    for one in found:
        ends = np.array([one[1].low, one[1].high])
        if not any(np.allclose(ends, [c.low, c.high], rtol=0, atol=1e-4 * c.size.max()) for _, c, _ in kept):
            kept.append(one)
    return kept


def _one(label: str, low: Any, high: Any, scale: float) -> list[tuple[str, Cuboid, float]]:
    cuboid = None if not low or not high else cuboid_of(Ends(min=list(low), max=list(high)))
    return [] if cuboid is None else [(label, cuboid, scale)]

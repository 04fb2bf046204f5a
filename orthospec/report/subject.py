"""`Subject`: a solution as figures and tables are made from it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from orthospec.errors import OrthospecError
from orthospec.result.model import Ends
from orthospec.show.labels import Labels, labels
from orthospec.show.numbers import Numbers, in_unit
from orthospec.show.result import is_small
from orthospec.solution import Lattice, Solution, sampled
from orthospec.workspace.cuboid import Cuboid

if TYPE_CHECKING:
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

    @property
    def length_unit(self) -> str:
        """mm or m."""
        return "mm" if self.numbers.millimetres else "m"

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
        """The measures around the reach, coarsely; None without a machine, or without an end of its reach."""
        spec = self.solution.spec
        if self.design is None or spec is None:
            return None
        try:
            return sampled(self.design, spec.workspace.region, np.array(spec.workspace.size), NODES)
        except OrthospecError:
            return None


def cuboid_of(ends: Ends) -> Cuboid | None:
    """The cuboid between two corners; None where they are not known."""
    if None in (*ends.min, *ends.max):
        return None
    return Cuboid(
        tuple(float(x) for x in ends.min if x is not None), tuple(float(x) for x in ends.max if x is not None)
    )

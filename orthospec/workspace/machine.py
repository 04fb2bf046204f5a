"""A design as the workspace sees it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from orthospec.manipulators import Manipulator
from orthospec.measures import Demand


@dataclass(frozen=True)
class Machine:
    """A manipulator and what is demanded of it, by the spec's names."""

    manipulator: Manipulator
    demands: Mapping[str, Demand]

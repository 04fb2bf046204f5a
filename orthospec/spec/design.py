"""A spec's parts with all units resolved: what the later stages work with."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, TypeAlias

from orthospec.quantities import Expression

if TYPE_CHECKING:
    from orthospec.manipulators import Manipulator
    from orthospec.measures import Demand

Sense: TypeAlias = Literal["minimise", "maximise", "match"]


@dataclass(frozen=True)
class Variable:
    """A design variable: its range and start in SI units, or the values of a catalogue."""

    min: float
    max: float
    start: float
    choices: tuple[float, ...] = ()
    """The catalogue's values, the least first; empty where it varies continuously."""


@dataclass(frozen=True)
class Region:
    """A box of poses, by axis."""

    min: tuple[float, ...]
    max: tuple[float, ...]


@dataclass(frozen=True)
class Workspace:
    """The prescribed cuboid; its size spans the first axes of the pose."""

    size: tuple[float, ...]
    divisions: int
    region: Region | None
    """Where to look; None: the reach."""
    together: bool
    """One cuboid for all measures, or one for each."""


@dataclass(frozen=True)
class Sweep:
    """Evaluate at ``points`` values of one variable, both ends included."""

    variable: str
    start: float
    stop: float
    points: int


@dataclass(frozen=True)
class Goal:
    """``minimise``: f − wλ <= goal; ``maximise``: f + wλ >= goal; ``match``: |f − goal| <= wλ."""

    name: str
    sense: Sense
    expression: Expression
    goal: float
    weight: float
    place: str
    """``FILE:LINE:COLUMN`` of the goal, for messages."""


@dataclass(frozen=True)
class Design:
    """The problem at one set of values of the variables: a machine and what is asked of it."""

    values: Mapping[str, float]
    manipulator: Manipulator
    demands: tuple[Demand, ...]
    goals: tuple[Goal, ...]

"""The records that a run hands over: one design, what was measured of it, and how it was found."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, TypeAlias

if TYPE_CHECKING:
    from orthospec.spec import Design
    from orthospec.workspace.evaluate import Evaluation

Status: TypeAlias = Literal["attained", "compromise", "infeasible", "evaluated", "unfinished", "failed"]


@dataclass(frozen=True)
class GoalOutcome:
    """One goal at the design found."""

    value: float
    goal: float
    weight: float
    attained: bool


@dataclass(frozen=True)
class Attainment:
    """How far the goals are met."""

    factor: float | None
    """λ: every goal is met up to its weight times λ; None where all weights are 0."""
    goals: Mapping[str, GoalOutcome]


@dataclass(frozen=True)
class Limit:
    """One thing that holds the design back, and what one per cent of it is worth."""

    kind: Literal["bound", "joint", "variable", "goal"]
    name: str
    side: str | None
    at: tuple[tuple[float, ...], ...]
    """The poses where it binds; none for a variable or a goal."""
    gain: float | None
    """By how much λ falls when this alone is loosened by 1 %."""
    cost: float | None
    """By how much λ rises when this alone is tightened by 1 %."""


@dataclass(frozen=True)
class Search:
    """What was searched; nothing here depends on the machine's load."""

    designs: int
    """Designs measured on the coarse grid."""
    starts: int
    """Local solves."""
    subproblems: int
    """Convex subproblems of the solve that was kept."""
    least_violation: float | None
    """Of the best point found; None where everything holds."""
    conflicts: tuple[str, ...] = ()
    """Sentences that name what conflicts, where no design was found."""


@dataclass(frozen=True)
class PluginError:
    """A plugin that failed."""

    name: str
    place: str | None
    """``FILE:LINE:COLUMN`` in the spec."""
    message: str


@dataclass(frozen=True)
class Finding:
    """One design with all that is known of it."""

    status: Status
    design: Design
    evaluation: Evaluation
    attainment: Attainment | None = None
    limits: tuple[Limit, ...] = ()
    search: Search | None = None
    sweep: tuple[Finding, ...] = ()
    errors: tuple[PluginError, ...] = ()

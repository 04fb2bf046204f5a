"""The records that a run hands over: one design, what was measured of it, and how it was found."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, TypeAlias

if TYPE_CHECKING:
    from orthospec.spec import Design
    from orthospec.workspace.evaluate import Evaluation

Status: TypeAlias = Literal["attained", "compromise", "infeasible", "evaluated", "unfinished", "failed"]

FURTHEST = 1e4
"""An end of a variable's range is loosened by no more than so many ranges."""


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
class Branch:
    """One combination of a spec's catalogues, and the best that was found with it."""

    choices: Mapping[str, float]
    found: bool
    """Whether a design was found in which every bound holds."""
    factor: float | None
    """Its λ; None where there is none."""
    least_violation: float | None
    """Of the best point, where no design was found and there was a start."""
    cost: float | None = None
    """By how much λ rises with it instead of the one that is best; None where either has none."""


@dataclass(frozen=True)
class Culprit:
    """One condition of a conflict, and how far it alone would have to give way."""

    kind: Literal["bound", "joint", "variable", "goal"]
    name: str
    side: str | None
    place: str
    """``FILE:LINE:COLUMN`` in the spec."""
    value: float | None
    """As the spec has it, in SI; None where the machine's reach knows it alone."""
    needed: float | None
    """The nearest value with which a design was found, all else held."""
    by: float | None
    """How far that is: a part of the bound, of the variable's range; None where none was found."""
    sought: bool = True
    """Whether that was looked for: not where the run was stopped before."""


@dataclass(frozen=True)
class Card:
    """Why no design was found: conditions that cannot hold together, the cheapest to loosen first."""

    culprits: tuple[Culprit, ...]
    irreducible: bool
    """Whether a design was found without each one of them, the others held."""
    together: float | None
    """The least part by which all of them must be loosened at once."""
    scale: float | None
    """The scale of the largest cuboid in which everything holds as it is."""


@dataclass(frozen=True)
class FrontSearch:
    """What was searched for a Pareto set."""

    branches: int
    """Combinations of choices that were searched for each goal alone."""
    met: int
    """Points met, of all branches together."""
    left_out: int
    """Points of branches that were not sought: another branch is better there, whatever they come to."""


@dataclass(frozen=True)
class Taken:
    """Where a solve stood after so many subproblems."""

    subproblems: int
    factor: float
    """λ."""
    violation: float
    """The greatest part by which a bound is missed."""


@dataclass(frozen=True)
class Search:
    """What was searched; nothing here depends on the machine's load."""

    designs: int
    """Designs measured on the coarse grid."""
    refined: int
    """The better ones of them, each refined by a few subproblems."""
    distinct: int
    """Places that these lead to."""
    starts: int
    """The best of these places, solved to the end."""
    subproblems: int
    """Convex subproblems of the solve that was kept."""
    least_violation: float | None
    """Of the best point found; None where everything holds."""
    conflicts: tuple[str, ...] = ()
    """Sentences that name what conflicts, where no design was found."""
    card: Card | None = None
    """The conflict taken apart, where no design was found."""
    combinations: int = 1
    """Of the catalogues' choices."""
    branches: tuple[Branch, ...] = ()
    """Those that were searched, the best first; none where the spec has no catalogue."""
    front: FrontSearch | None = None
    """For a Pareto set, where the spec has catalogues."""
    steps: tuple[Taken, ...] = ()
    """Of the solve that was kept, those that were taken."""


@dataclass(frozen=True)
class PluginError:
    """A plugin that failed."""

    name: str
    place: str | None
    """``FILE:LINE:COLUMN`` in the spec."""
    message: str


@dataclass(frozen=True)
class Note:
    """What was done otherwise than asked for, though nothing failed."""

    about: str
    """The key of the spec."""
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
    notes: tuple[Note, ...] = ()
    pareto: tuple[Finding, ...] = ()
    is_knee: bool = False
    """Whether it is the knee of a Pareto set."""

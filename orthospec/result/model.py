"""The result file, format 1, as classes: what a reader may count on. SI; null where nothing is known."""

from __future__ import annotations

from typing import Annotated, Any, TypeAlias

from pydantic import BaseModel, ConfigDict, Field

from orthospec.result.records import Status

Pose: TypeAlias = list[float]


class _Record(BaseModel):
    """Keys that are not known here are passed over, so that files of later versions can be read."""

    model_config = ConfigDict(frozen=True, strict=True, defer_build=True)


class GoalRecord(_Record):
    """One goal at the design found."""

    value: float | None
    goal: float
    weight: float
    attained: bool


class AttainmentRecord(_Record):
    """How far the goals are met."""

    factor: float | None
    """λ; null where all weights are 0."""
    goals: dict[str, GoalRecord]


class Ends(_Record):
    """Least and greatest coordinates, or joint values."""

    min: list[float | None]
    max: list[float | None]


class ProofRecord(_Record):
    """What is proved of a cuboid: the reach and each bound, at every pose."""

    verdict: str
    """proved, refuted or undecided."""
    slack: float
    """By which part of a bound it may be exceeded."""
    boxes: int
    """How many boxes of poses were looked at."""
    excess: float | None = None
    """The greatest that is not ruled out, as a part of the bound."""
    at: Pose | None = None
    """The pose that refutes it."""
    machine: dict[str, list[float]] | None = None
    """The numbers of the machine within its tolerances that is refuted; left out of the one designed."""
    nominal: str | None = None
    """The verdict on the machine as it is designed, where the first one is for all within its tolerances."""
    condition: str | None = None
    """What is refuted or undecided."""
    why: str | None = None
    """Why nothing is known of it over boxes."""


class BracketRecord(_Record):
    """Proved ends of the scale of a largest cuboid; null where there is no proof."""

    least: float | None
    """A cuboid of this scale holds everywhere, without any slack."""
    most: float | None
    """No larger one fits anywhere."""


class PrescribedRecord(Ends):
    """The prescribed cuboid where it stands."""

    scale: float = 1.0
    """Of the prescribed size; in the file where it is another one."""
    holds: bool
    """Whether the reach and every bound hold everywhere in it."""
    proof: ProofRecord | None = None


class LargestRecord(_Record):
    """The largest cuboid of the prescribed proportions."""

    scale: float
    """Polished μ."""
    grid_scale: float
    """The metric on the grid alone."""
    ties: int
    """Grid placements of that size."""
    min: Pose | None
    """Least coordinates of the polished cuboid."""
    max: Pose | None
    """Greatest coordinates of the polished cuboid."""
    nodes: dict[str, int]
    """How many nodes meet, violate, are unreachable, failed."""
    proved: BracketRecord | None = None
    proof: ProofRecord | None = None
    """Over the polished cuboid."""


class LevelRecord(LargestRecord):
    """A further bound, with the largest cuboid under it."""

    at_least: float | None = None
    at_most: float | None = None


class ValueRecord(_Record):
    """A measure's value and where it is found."""

    value: float | None
    at: Pose


class MeasureRecord(_Record):
    """One measure; with bounds it has the keys of `LargestRecord` too, standing alone `prescribed`."""

    scale: float | None = None
    grid_scale: float | None = None
    min: Pose | None = None
    """Least coordinates of its own largest cuboid."""
    max: Pose | None = None
    proved: BracketRecord | None = None
    proof: ProofRecord | None = None
    lowest: ValueRecord | None = None
    """Over the prescribed cuboid; null where that leaves the reach."""
    highest: ValueRecord | None = None
    levels: list[LevelRecord] = []
    poses: dict[str, list[float | None] | None] = {}
    """Values at the named poses."""
    prescribed: PrescribedRecord | None = None


class WorkspaceRecord(_Record):
    """The cuboids."""

    prescribed: PrescribedRecord | None = None
    joint: LargestRecord | None = None
    """All measures together."""
    measures: dict[str, MeasureRecord] = {}


class LimitRecord(_Record):
    """One thing that holds the design back."""

    kind: str
    """bound, joint, variable or goal."""
    name: str
    side: str | None = None
    at: list[Pose] = []
    gain: float | None = None
    """By how much λ falls when this alone is loosened by 1 %."""
    cost: float | None = None
    """By how much λ rises when this alone is tightened by 1 %."""


class CulpritRecord(_Record):
    """One condition of a conflict."""

    kind: str
    """bound, joint, variable or goal."""
    name: str
    side: str | None = None
    place: str
    """FILE:LINE:COLUMN in the spec."""
    value: float | None = None
    """As the spec has it."""
    needed: float | None = None
    """The nearest value with which a design was found, all else held."""
    by: float | None = None
    """How far that is, as a part of the bound or of the variable's range; null where none was found.

    Not in the file where the run was stopped before it was known.
    """


class CardRecord(_Record):
    """Why no design was found: conditions that cannot hold together, the cheapest to loosen first."""

    conflict: list[CulpritRecord] = []
    irreducible: bool = False
    """Whether a design was found without each one of them, the others held."""
    together: float | None = None
    """The least part by which all of them must be loosened at once."""
    scale: float | None = None
    """The scale of the largest cuboid in which everything holds as it is."""


class BranchRecord(_Record):
    """One combination of the catalogues' choices, and the best found with it."""

    choices: dict[str, float]
    found: bool
    """Whether a design was found in which every bound holds."""
    factor: float | None = None
    """Its λ; null where there is none."""
    cost: float | None = None
    """By how much λ rises with it instead of the best one."""
    least_violation: float | None = None


class FrontSearchRecord(_Record):
    """What was searched for a Pareto set over catalogues."""

    branches: int
    """Combinations of choices that were searched for each goal alone."""
    met: int
    """Points met, of all branches together."""
    left_out: int
    """Points of branches that were not sought: another branch is better there, whatever they come to."""


class StepRecord(_Record):
    """Where a solve stood after so many subproblems."""

    subproblems: int
    factor: float | None
    """λ."""
    violation: float | None
    """The greatest part by which a bound is missed."""


class SearchRecord(_Record):
    """What was searched."""

    designs: int
    """Measured on the coarse grid."""
    refined: int | None = None
    """The better ones, by a few subproblems each."""
    distinct: int | None = None
    """Places that these lead to."""
    starts: int
    """The best places, solved to the end."""
    subproblems: int
    """Of the solve that was kept."""
    steps: list[StepRecord] = []
    """Those of that solve that were taken."""
    least_violation: float | None = None
    conflicts: list[str] = []
    card: CardRecord | None = None
    combinations: int | None = None
    """Of the catalogues' choices, searched or not."""
    branches: list[BranchRecord] = []
    """Those that were searched, the best first."""
    pareto: FrontSearchRecord | None = None


class ErrorRecord(_Record):
    """A plugin that failed, or a pose where a measure could not be computed."""

    name: str
    place: str | None = None
    message: str


class NoteRecord(_Record):
    """What was done otherwise than asked for, though nothing failed: a coarser grid, a point left out."""

    name: str
    """The key of the spec that it is about."""
    place: str | None = None
    message: str


class DesignRecord(_Record):
    """One design and what was measured of it."""

    variables: dict[str, float] = {}
    manipulator: dict[str, Any]
    """The machine's name under `use`, and its fields."""
    indices: dict[str, float | None] = {}
    joints: Ends | None = None
    """Range of each joint over the prescribed cuboid."""
    workspace: WorkspaceRecord
    limits: list[LimitRecord] = []


class ParetoRecord(DesignRecord):
    """A design of a Pareto set; prices are parts of the goals' ranges over the set."""

    knee: bool = False
    """Whether it stands out furthest."""
    attainment: AttainmentRecord | None = None
    """By the spec's own goals and weights."""


class Result(DesignRecord):
    """A whole result file."""

    orthospec: Annotated[int, Field(ge=1, le=1)]
    title: str | None = None
    status: Status
    attainment: AttainmentRecord | None = None
    search: SearchRecord | None = None
    pareto: list[ParetoRecord] = []
    sweep: list[DesignRecord] = []
    errors: list[ErrorRecord] = []
    notes: list[NoteRecord] = []
    provenance: dict[str, Any] = {}

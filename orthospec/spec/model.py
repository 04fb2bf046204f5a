"""The spec file, format 1: its keys as frozen classes, checked for form alone.

What depends on other parts of the file (units of bounds, names in expressions, a plugin's own keys) is kept
as written, and resolved in `orthospec.spec.resolve`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, Literal, TypeAlias, TypeVar

from pydantic import BeforeValidator, ConfigDict, Field, StrictBool, StrictInt, StrictStr
from pydantic_core import core_schema

from orthospec.described import Described
from orthospec.quantities.fields import Number, json_schema, read, shown

if TYPE_CHECKING:
    from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler
    from pydantic.json_schema import JsonSchemaValue


class _AmountMarker:
    """A number, quantity or expression, kept as written: its unit is known elsewhere."""

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> core_schema.CoreSchema:
        return core_schema.no_info_plain_validator_function(self._check)

    def __get_pydantic_json_schema__(
        self, schema: core_schema.CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        return json_schema(None)

    def _check(self, given: Any) -> Any:
        read(given, None)
        return given


def _formula(given: object) -> str:
    if isinstance(given, str):
        return given
    raise ValueError(f"an expression was expected, {shown(given)} given")


def _format(given: object) -> int:
    if given == 1 and type(given) is int:
        return 1
    raise ValueError(f"this version reads specs of format 1, written 'orthospec: 1'; {shown(given)} given")


def _none_is_empty(given: object) -> object:
    return {} if given is None else given


Amount: TypeAlias = Annotated[int | float | str, _AmountMarker()]
Formula: TypeAlias = Annotated[str, BeforeValidator(_formula, json_schema_input_type=str)]
Count: TypeAlias = Annotated[StrictInt, Field(ge=1)]
PerAxis: TypeAlias = Annotated[tuple[Amount, ...], Field(min_length=1)]
_Entry = TypeVar("_Entry")
Named: TypeAlias = Annotated[dict[str, _Entry], BeforeValidator(_none_is_empty)]
"""Entries under names of the user's; a section with nothing in it is an empty one."""


class _Keys(Described):
    model_config = ConfigDict(frozen=True, extra="forbid")


class _PluginKeys(Described):
    model_config = ConfigDict(frozen=True, extra="allow")


class VariableKeys(_Keys):
    """A design variable: a range, or a catalogue of choices."""

    min: Amount | None = None
    """Least value: number (SI) or quantity."""
    max: Amount | None = None
    """Greatest value."""
    start: Amount | None = None
    """Where to begin, and what `evaluate` takes; the middle where it is left out."""
    choices: Annotated[tuple[Amount, ...], Field(min_length=1)] | None = None
    """The values of a catalogue, instead of min and max."""


class ManipulatorKeys(_PluginKeys):
    """The machine; the keys beside these are its own fields."""

    use: StrictStr | None = None
    """The name of an installed manipulator."""
    from_: Annotated[StrictStr | None, Field(alias="from")] = None
    """A result file whose machine is taken, instead of use: its path, relative to the spec's own.

    The keys beside it add to the solved machine and change nothing of it.
    """
    tolerance: dict[str, Amount] | None = None
    """How far each number of a field may be off when the machine is built, by field; proofs allow for it."""


class RegionKeys(_Keys):
    """A box of poses, one number for each axis of the size."""

    min: PerAxis
    """Least coordinates [m]."""
    max: PerAxis
    """Greatest coordinates [m]."""


class WorkspaceKeys(_Keys):
    """The prescribed cuboid, and where and how finely to look for it."""

    size: Annotated[tuple[Amount, ...], Field(min_length=2, max_length=3)]
    """Lengths of the prescribed cuboid's edges along the pose axes [m]."""
    divisions: Count = 20
    """Steps of the grid along each edge of the cuboid."""
    region: RegionKeys | None = None
    """Where to look; the machine's whole reach where it is left out."""
    together: StrictBool = True
    """One cuboid for all measures; false: one for each."""
    orientation: Any = None
    """Orientations of the platform over the cuboid."""


class LevelKeys(_Keys):
    """Further bounds by side, each reported with a cuboid of its own; they bind nothing."""

    at_least: Annotated[tuple[Amount, ...], Field(min_length=1)] | None = None
    """Lower bounds, in the measure's unit."""
    at_most: Annotated[tuple[Amount, ...], Field(min_length=1)] | None = None
    """Upper bounds, in the measure's unit."""


class MeasureKeys(_PluginKeys):
    """A measure and its bounds; the keys beside these are its own fields."""

    use: StrictStr
    """The name of an installed measure."""
    at_least: Amount | None = None
    """Lower bound at every pose of the prescribed cuboid, in the measure's unit."""
    at_most: Amount | None = None
    """Upper bound at every pose of the prescribed cuboid, in the measure's unit."""
    levels: LevelKeys | None = None
    """Further bounds, reported with a cuboid each; they bind nothing."""


class GoalKeys(_Keys):
    """One of minimise, maximise and match of an expression, with the value aimed at."""

    model_config = ConfigDict(
        json_schema_extra={"oneOf": [{"required": [sense]} for sense in ("minimise", "maximise", "match")]}
    )

    minimise: Formula | None = None
    """What is to be at most the goal: an expression over variables, indices, scale, worst(measure) ..."""
    maximise: Formula | None = None
    """What is to be at least the goal."""
    match: Formula | None = None
    """What is to equal the goal."""
    goal: Amount
    """The value aimed at."""
    weight: Amount | None = None
    """Slack for one unit of λ, 1 by default (match: 0); relative is |goal|; 0 makes the goal a hard bound."""


class SweepKeys(_Keys):
    """Evaluate designs along one variable."""

    variable: StrictStr
    """The variable's name."""
    from_: Annotated[Amount, Field(alias="from")]
    """First value."""
    to: Amount
    """Last value."""
    points: Annotated[StrictInt, Field(ge=2)] = 25
    """How many designs, both ends included."""


class OptimiseKeys(_Keys):
    """How the optimiser searches."""

    starts: Count = 8
    """How many starting designs are tried."""
    seed: Annotated[StrictInt, Field(ge=0)] = 0
    """Chooses the starting designs."""


class ParetoKeys(_Keys):
    """A set of designs none of which is better than another in all goals."""

    points: Annotated[StrictInt, Field(ge=2)] = 21
    """How many designs to look for."""


class ProofKeys(_Keys):
    """A proof that the bounds hold between the grid's nodes too."""

    slack: Annotated[Number, Field(gt=0)] = 1e-3
    """Relative slack on the bounds."""
    boxes: Count = 50_000
    """Most boxes of poses, or of placements, that one proof may take."""


class SpecKeys(_Keys):
    """A design problem: what may vary, which machine, which cuboid, what must hold, what is aimed at."""

    orthospec: Annotated[Literal[1], BeforeValidator(_format, json_schema_input_type=Literal[1])]
    """Version of the spec's format."""
    title: StrictStr | None = None
    """One line to tell the problem by."""
    notes: Any = None
    """Anything; never interpreted."""
    variables: Named[VariableKeys] = {}
    """The design variables by name; without them the spec is only evaluated."""
    manipulator: ManipulatorKeys
    """The machine."""
    workspace: WorkspaceKeys
    """The prescribed cuboid."""
    measures: Named[MeasureKeys] = {}
    """What must hold at every pose of the cuboid, under names of your own; without them the reach alone."""
    goals: Named[GoalKeys] = {}
    """What is aimed at, under names of your own."""
    poses: Named[PerAxis] = {}
    """Named poses at which every measure is reported: coordinates [m, rad] along the machine's axes."""
    sweep: SweepKeys | None = None
    """Evaluate along one variable."""
    optimise: OptimiseKeys = OptimiseKeys()
    """How many starts are tried, and which."""
    pareto: ParetoKeys | None = None
    """Look for a Pareto set."""
    proof: ProofKeys | Literal[False] = ProofKeys()
    """Prove the bounds; false leaves it out."""

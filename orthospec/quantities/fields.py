"""Field types with a unit: SI floats in a class; number, quantity or expression in a spec.

>>> class Bar(BaseModel):
...     length: Annotated[Length, Field(gt=0)]
...     inertia: Annotated[float, Quantity("kg*m^2")] = 0.0
>>> Bar.model_validate({"length": "2 * base"}, context={"variables": {"base": 0.5}}).length
1.0

The variables' values come as validation context; without them an expression is computed if it names none.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Annotated, Any, TypeAlias

from pydantic_core import core_schema

from orthospec.quantities.expressions import Expression, expression
from orthospec.quantities.units import UnitError, kind, parse_unit

if TYPE_CHECKING:
    from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler
    from pydantic.json_schema import JsonSchemaValue

_NUMBER = r"[-+]?(?>(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d{1,3})?)"
_QUANTITY = re.compile(rf"\s*({_NUMBER})(\s*)([^\W\d_].*|[%°].*|1/.*)", re.DOTALL)


def read(given: object, unit: str | None) -> float | Expression:
    """A number, quantity or expression as an SI float or a parsed expression; no ``unit``: any will do."""
    if isinstance(given, str):
        return _read_text(given, unit)
    if isinstance(given, bool) or not isinstance(given, int | float):
        raise ValueError(f"{expected(unit)} was expected, {shown(given)} given")
    if not _is_finite(given):
        raise ValueError(f"{expected(unit)} was expected, {given} is not finite")
    return float(given)


def resolve(given: object, unit: str | None, variables: Mapping[str, float]) -> float:
    """`read`, with an expression computed at these values of the variables."""
    reading = read(given, unit)
    return reading.value(variables) if isinstance(reading, Expression) else reading


def is_quantity(text: str) -> bool:
    """Whether a string is one number, a space and a unit, well formed or not; else it is an expression."""
    return _QUANTITY.fullmatch(text) is not None


def expected(unit: str | None) -> str:
    """What a place with this unit wants, in words: "a length [m]"."""
    if unit is None or unit == "1":
        return "a number"
    return f"{kind(unit)} [{unit}]"


def shown(given: object) -> str:
    """A value as the spec's author wrote it."""
    if given is None:
        return "nothing"
    if isinstance(given, bool):
        return str(given).lower()
    if isinstance(given, Mapping):
        return "a mapping"
    if isinstance(given, list | tuple):
        return "a list"
    return f"'{given}'" if isinstance(given, str) else str(given)


@lru_cache(maxsize=4096)
def _read_text(text: str, unit: str | None) -> float | Expression:
    match = _QUANTITY.fullmatch(text)
    if match is None:
        return expression(text)
    number, gap, name = match[1], match[2], match[3].rstrip()
    try:
        given = parse_unit(name)
    except UnitError as error:
        is_name = name.isidentifier() and not str(error).endswith("?")
        product = f"; a product is written '{number} * {name}'" if is_name else ""
        raise UnitError(f"'{text}': {error}{product}") from None
    if not gap:
        raise UnitError(f"'{text}': a space is missing between number and unit, '{number} {name}'")
    if unit is not None and parse_unit(unit).dimension != given.dimension:
        raise UnitError(f"{text} is {kind(name)}, {expected(unit)} was expected")
    value = given.to_si(number)
    if not math.isfinite(value):
        raise UnitError(f"{text} is too large")
    return value


def _is_finite(number: float) -> bool:
    try:
        return math.isfinite(number)
    except OverflowError:
        return False


@dataclass(frozen=True)
class Quantity:
    """Annotates a float with its unit: ``Annotated[float, Quantity("kg*m^2")]``."""

    unit: str

    def __post_init__(self) -> None:
        """Refuse a unit that is not in the table as early as the class is written."""
        parse_unit(self.unit)

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> core_schema.CoreSchema:
        """A float before which number, quantity and expression are resolved."""
        number = core_schema.float_schema(allow_inf_nan=False)
        return core_schema.with_info_before_validator_function(self._resolve, number)

    def __get_pydantic_json_schema__(
        self, schema: core_schema.CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        """A number in SI, or a string that is a quantity or an expression."""
        return json_schema(self.unit, handler(schema))

    def _resolve(self, given: object, info: core_schema.ValidationInfo) -> float:
        return resolve(given, self.unit, (info.context or {}).get("variables", {}))


_BOUNDS = {"gt": "exclusiveMinimum", "ge": "minimum", "lt": "exclusiveMaximum", "le": "maximum"}


def json_schema(unit: str | None, number: JsonSchemaValue | None = None) -> JsonSchemaValue:
    """The JSON schema of a number, quantity or expression."""
    bounded = {_BOUNDS.get(key, key): value for key, value in (number or {"type": "number"}).items()}
    example = {None: "10 mm", "1": "50 %"}.get(unit, f"1 {unit}")
    text = {
        "type": "string",
        "description": f"a quantity like '{example}', or an expression over the variables",
    }
    return {"anyOf": [bounded, text]} | ({} if unit is None else {"x-unit": unit})


Number: TypeAlias = Annotated[float, Quantity("1")]
Length: TypeAlias = Annotated[float, Quantity("m")]
Area: TypeAlias = Annotated[float, Quantity("m^2")]
SecondMoment: TypeAlias = Annotated[float, Quantity("m^4")]
Angle: TypeAlias = Annotated[float, Quantity("rad")]
Time: TypeAlias = Annotated[float, Quantity("s")]
Frequency: TypeAlias = Annotated[float, Quantity("Hz")]
Mass: TypeAlias = Annotated[float, Quantity("kg")]
Inertia: TypeAlias = Annotated[float, Quantity("kg*m^2")]
Density: TypeAlias = Annotated[float, Quantity("kg/m^3")]
Speed: TypeAlias = Annotated[float, Quantity("m/s")]
AngularSpeed: TypeAlias = Annotated[float, Quantity("rad/s")]
Acceleration: TypeAlias = Annotated[float, Quantity("m/s^2")]
Force: TypeAlias = Annotated[float, Quantity("N")]
Torque: TypeAlias = Annotated[float, Quantity("N*m")]
Pressure: TypeAlias = Annotated[float, Quantity("Pa")]
Stiffness: TypeAlias = Annotated[float, Quantity("N/m")]
RotationalStiffness: TypeAlias = Annotated[float, Quantity("N*m/rad")]

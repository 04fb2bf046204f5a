"""What bars are made of, as keys of a spec: sections and materials.

    section: {round: {diameter: 20 mm, wall: 2 mm}}   # or rectangle, given, compliance, or the word rigid
    material: {E: 70 GPa, nu: 0.33, density: 2700}    # or a name of the table, such as steel

A material may be given in part: what is not there is asked for where a measure needs it.
"""

from __future__ import annotations

import difflib
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self, TypeAlias

from pydantic import (
    ConfigDict,
    Field,
    GetJsonSchemaHandler,
    SerializerFunctionWrapHandler,
    field_validator,
    model_serializer,
    model_validator,
)

from orthospec.arrays import np
from orthospec.described import Described
from orthospec.mechanics import bars, materials, sections
from orthospec.quantities import Area, Density, Length, Number, Pressure, SecondMoment

if TYPE_CHECKING:
    from pydantic.json_schema import JsonSchemaValue
    from pydantic_core import CoreSchema

PositiveLength: TypeAlias = Annotated[Length, Field(gt=0)]
PositiveSecondMoment: TypeAlias = Annotated[SecondMoment, Field(gt=0)]
PositivePressure: TypeAlias = Annotated[Pressure, Field(gt=0)]
Row: TypeAlias = tuple[Number, Number, Number, Number, Number, Number]
Rows: TypeAlias = tuple[Row, Row, Row, Row, Row, Row]
Needed: TypeAlias = Literal["compliance", "mass"]

PART = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)
"""How the classes of all parts take their keys."""

_NO_COMPLIANCE = ((0.0,) * 6,) * 6
_ONE_OF_FOUR = "one of 'round', 'rectangle', 'given' and 'compliance' was expected, or the word 'rigid'"


class Round(Described):
    """A round bar or tube."""

    model_config = PART

    diameter: PositiveLength
    """Outer diameter [m]."""
    wall: PositiveLength | None = None
    """Thickness of a tube's wall [m]; none: solid."""

    @model_validator(mode="after")
    def _has_hollow(self) -> Self:
        self.properties()
        return self

    def properties(self) -> sections.Section:
        """Area, second moments and torsion constant."""
        return sections.circle(diameter=self.diameter, wall=self.wall)


class Rectangle(Described):
    """A rectangular bar or tube; z is normal to the plane of a parallelogram, y lies in it."""

    model_config = PART

    height: PositiveLength
    """Outer size along z of the bar's frame [m]."""
    width: PositiveLength
    """Outer size along y of the bar's frame [m]."""
    wall: PositiveLength | None = None
    """Thickness of a tube's wall [m]; none: solid."""

    @model_validator(mode="after")
    def _has_hollow(self) -> Self:
        self.properties()
        return self

    def properties(self) -> sections.Section:
        """Area, second moments and torsion constant."""
        return sections.rectangle(height=self.height, width=self.width, wall=self.wall)


class Given(Described):
    """A section of any other shape."""

    model_config = PART

    A: Annotated[Area, Field(gt=0)]
    """Area [m^2]."""
    Iy: PositiveSecondMoment
    """Second moment of area about y of the bar's frame, the integral of z^2 [m^4]."""
    Iz: PositiveSecondMoment
    """Second moment of area about z of the bar's frame, the integral of y^2 [m^4]."""
    J: PositiveSecondMoment
    """Torsion constant [m^4]."""

    def properties(self) -> sections.Section:
        """Area, second moments and torsion constant."""
        return sections.Section(area=self.A, Iy=self.Iy, Iz=self.Iz, J=self.J)


class Section(Described):
    """A bar's cross-section, or the bar's compliance itself; the word `rigid` stands for none at all."""

    model_config = PART

    round: Round | None = None
    """A round bar or tube."""
    rectangle: Rectangle | None = None
    """A rectangular bar or tube."""
    given: Given | None = None
    """A section of any other shape."""
    compliance: Rows | None = None
    """6 x 6, of a bar's loaded end in its frame (x y z rx ry rz), from FEA for example [m/N, rad/(N*m)]."""

    @model_validator(mode="before")
    @classmethod
    def _reads_rigid(cls, given: Any) -> Any:
        if isinstance(given, str):
            if given != "rigid":
                raise ValueError(f"{_ONE_OF_FOUR}; '{given}' given")
            return {"compliance": _NO_COMPLIANCE}
        return given

    @model_serializer(mode="wrap")
    def _writes_rigid(self, write: SerializerFunctionWrapHandler) -> Any:
        return "rigid" if self.compliance == _NO_COMPLIANCE else write(self)

    @classmethod
    def __get_pydantic_json_schema__(
        cls, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        """The mapping, or the word."""
        mapping = super().__get_pydantic_json_schema__(schema, handler)
        return {"anyOf": [mapping, {"const": "rigid", "description": "no compliance"}]}

    @field_validator("compliance")
    @classmethod
    def _is_compliance(cls, rows: Rows | None) -> Rows | None:
        if rows is None or rows == _NO_COMPLIANCE:
            return rows
        matrix = np.array(rows)
        if not bars.is_symmetric(matrix):
            raise ValueError("a compliance is symmetric, and this matrix is not")
        if not bars.is_compliance(matrix):
            raise ValueError("a compliance has no negative eigenvalue, and this has")
        return rows

    @model_validator(mode="after")
    def _is_one(self) -> Self:
        named = [name for name in type(self).model_fields if getattr(self, name) is not None]
        if len(named) != 1:
            given = " and ".join(f"'{name}'" for name in named) or "nothing"
            raise ValueError(f"{_ONE_OF_FOUR}; {given} given")
        return self

    def properties(self) -> sections.Section | None:
        """Area, second moments and torsion constant; None where the compliance itself is given."""
        shape = self.round or self.rectangle or self.given
        return None if shape is None else shape.properties()


class Material(Described):
    """A material; in its place a name of the table stands for all of its values."""

    model_config = PART

    E: PositivePressure | None = None
    """Young's modulus [Pa]."""
    G: PositivePressure | None = None
    """Shear modulus [Pa]; either this or nu."""
    nu: Annotated[Number, Field(gt=-1, le=0.5)] | None = None
    """Poisson's ratio [1]; either this or G."""
    density: Annotated[Density, Field(gt=0)] | None = None
    """Density [kg/m^3]."""
    yield_strength: Annotated[PositivePressure | None, Field(alias="yield")] = None
    """Yield strength [Pa]."""

    @model_validator(mode="before")
    @classmethod
    def _reads_name(cls, given: Any) -> Any:
        if not isinstance(given, str):
            return given
        if given not in materials.TABLE:
            close = difflib.get_close_matches(given.lower(), materials.TABLE, n=1)
            meant = f"did you mean '{close[0]}'? " if close else ""
            raise ValueError(f"unknown material '{given}'; {meant}known here: {', '.join(materials.TABLE)}")
        known = materials.TABLE[given]
        return {"E": known.E, "G": known.G, "density": known.density, "yield": known.yield_strength}

    @model_serializer(mode="wrap")
    def _writes_keys(self, write: SerializerFunctionWrapHandler) -> dict[str, Any]:
        return {"yield" if key == "yield_strength" else key: value for key, value in write(self).items()}

    @classmethod
    def __get_pydantic_json_schema__(
        cls, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        """The mapping, or a name of the table."""
        mapping = super().__get_pydantic_json_schema__(schema, handler)
        return {"anyOf": [mapping, {"enum": list(materials.TABLE)}]}

    @model_validator(mode="after")
    def _has_one_shear_modulus(self) -> Self:
        if self.G is not None and self.nu is not None:
            raise ValueError("'G' or 'nu' was expected, both given: each follows from the other")
        return self

    def missing(self, what: Needed) -> tuple[str, ...]:
        """The keys to give before a bar's compliance or mass is known."""
        if what == "mass":
            return () if self.density is not None else ("density",)
        has_shear_modulus = self.G is not None or self.nu is not None
        return (*(() if self.E is not None else ("E",)), *(() if has_shear_modulus else ("G",)))

    def properties(self) -> materials.Material | None:
        """What a compliance is computed from; None where it is not complete."""
        E, G = self.E, self.G
        if E is not None and self.nu is not None:
            G = materials.shear_modulus(E, nu=self.nu)
        return None if E is None or G is None else materials.Material(E, G, self.density, self.yield_strength)

"""The parts that machines are built from, as keys of a spec: legs, feet, actuators, masses.

    legs: {kind: PRPaR, section: {round: {diameter: 20 mm, wall: 2 mm}}, material: aluminium, spacing: 80 mm}
    feet: {length: 60 mm, section: {rectangle: {height: h, width: w}}, material: steel}
    actuators: {force: 500 N, stiffness: 20 N/um, mass: 1.5 kg, speed: 2 m/s}
    platform: {mass: 2 kg}

Any key may be left out: `missing` names those to give before a quantity can be had.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, Literal, Self, TypeAlias

from pydantic import BeforeValidator, Field, model_validator

from orthospec.arrays import np
from orthospec.described import Described
from orthospec.manipulators.stock import PART, Material, Needed, PositiveLength, Section
from orthospec.mechanics import bars
from orthospec.quantities import Force, Length, Mass, Speed, Stiffness

if TYPE_CHECKING:
    from orthospec.arrays import Array

SomeMass: TypeAlias = Annotated[Mass, Field(ge=0)]


class Legs(Described):
    """The legs of a machine, all of one kind; a PRPaR leg is a parallelogram of two bars."""

    model_config = PART

    kind: Literal["PUU", "PRPaR"] = "PUU"
    """The joints of a chain: universal joints at both ends of one bar, or a parallelogram between hinges."""
    section: Section | None = None
    """Section of a leg's bar."""
    material: Material | None = None
    """Material of a leg's bar."""
    spacing: PositiveLength | None = None
    """Distance of the two bars of a parallelogram [m]; of no effect on a PUU leg."""
    offset: Length = 0.0
    """Distance of the tool point from the legs' ends on the platform, along the slides [m]."""
    mass: SomeMass | None = None
    """Mass of one bar [kg], in place of density times area times length."""

    @model_validator(mode="after")
    def _says_how_many_bars(self) -> Self:
        if self.spacing is not None and "kind" not in self.model_fields_set:
            raise ValueError("'spacing' is of the two bars of a PRPaR leg: give 'kind' too, PRPaR or PUU")
        return self

    def bar_compliance(self, length: float | Array) -> Array | None:
        """C (..., 6, 6) of one bar in its own frame; zeros where it is rigid, None where it is not known."""
        return _compliance(self, length)

    def bar_mass(self, length: float) -> float | None:
        """The mass of one bar [kg]; None where it is not known."""
        return _mass(self, length)

    def missing(self, what: Needed) -> tuple[str, ...]:
        """The keys to give before the legs' compliance or mass is known; () when it is."""
        wants_spacing = what == "compliance" and self.kind == "PRPaR" and self.spacing is None
        return (*_missing(self, what, "legs"), *(["legs.spacing"] if wants_spacing else []))


class Feet(Described):
    """The bars that lead from the carriages to the legs."""

    model_config = PART

    length: PositiveLength
    """From the carriage to the end of the leg [m]."""
    section: Section | None = None
    """Section of a foot."""
    material: Material | None = None
    """Material of a foot."""
    mass: SomeMass | None = None
    """Mass of one foot [kg], in place of density times area times length."""

    def bar_compliance(self) -> Array | None:
        """C (6, 6) of one foot in its own frame; zeros where it is rigid, None where it is not known."""
        return _compliance(self, self.length)

    def bar_mass(self) -> float | None:
        """The mass of one foot [kg]; None where it is not known."""
        return _mass(self, self.length)

    def missing(self, what: Needed) -> tuple[str, ...]:
        """The keys to give before the feet's compliance or mass is known; () when it is."""
        return _missing(self, what, "feet")


def _reads_rigid(given: Any) -> Any:
    if isinstance(given, str):
        if given != "rigid":
            raise ValueError(f"'rigid' or a mapping with 'length' was expected, '{given}' given")
        return None
    return given


FeetOrRigid: TypeAlias = Annotated[
    Feet | None, BeforeValidator(_reads_rigid, json_schema_input_type=Feet | Literal["rigid"] | None)
]
"""The type of a machine's field: `rigid` is None, carriages that carry the legs themselves."""


class Actuators(Described):
    """What drives the slides, each the same."""

    model_config = PART

    force: Annotated[Force, Field(gt=0)] | None = None
    """Greatest force [N]; no limit where none is given."""
    stiffness: Annotated[Stiffness, Field(gt=0)] | None = None
    """Stiffness along the slide, of screw, bearings and control [N/m]."""
    mass: SomeMass | None = None
    """What moves with a slider, without foot and leg [kg]."""
    speed: Annotated[Speed, Field(gt=0)] | None = None
    """Greatest speed [m/s]; no limit where none is given."""
    friction: Annotated[Force, Field(ge=0)] | None = None
    """Coulomb friction, which takes its part of the force; none where none is given [N]."""


class Body(Described):
    """A rigid body that moves with the tool: platform, tool or payload."""

    model_config = PART

    mass: SomeMass
    """Mass [kg]."""


def _compliance(bar: Legs | Feet, length: float | Array) -> Array | None:
    if bar.section is not None and bar.section.compliance is not None:
        given = np.array(bar.section.compliance)
        return np.asarray((given + given.T) / 2)
    section = bar.section.properties() if bar.section else None
    material = bar.material.properties() if bar.material else None
    return None if section is None or material is None else bars.cantilever(section, material, length)


def _mass(bar: Legs | Feet, length: float) -> float | None:
    if bar.mass is not None:
        return bar.mass
    section = bar.section.properties() if bar.section else None
    density = bar.material.density if bar.material else None
    return None if section is None or density is None else density * section.area * length


def _missing(bar: Legs | Feet, what: Needed, at: str) -> tuple[str, ...]:
    if what == "mass" and bar.mass is not None:
        return ()
    if bar.section is not None and bar.section.compliance is not None:
        return (f"{at}.mass",) if what == "mass" else ()
    section = () if bar.section else (f"{at}.section",)
    if bar.material is None:
        return (*section, f"{at}.material")
    return (*section, *(f"{at}.material.{key}" for key in bar.material.missing(what)))

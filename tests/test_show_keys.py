"""The keys of a class at any depth, with units, defaults and the words that may stand in their place."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, Field

from orthospec.manipulators.orthoglide import Orthoglide
from orthospec.quantities import Force, Length, Quantity
from orthospec.show.keys import keys_of


class _Bar(BaseModel):
    length: Length
    inertia: Annotated[float, Quantity("kg*m^2")] = 0.5


class _Node(BaseModel):
    weight: Annotated[tuple[Length, Force], Field(description="How much.")]
    bar: _Bar | None = None
    inside: _Node | None = None


def test_keys_have_units_and_defaults_at_any_depth_and_a_class_within_itself_ends() -> None:
    keys = {".".join(key.path): key for key in keys_of(_Node).every()}
    assert list(keys) == ["weight", "bar", "bar.length", "bar.inertia", "inside"]
    assert keys["weight"].units == ("m", "N")
    assert keys["weight"].required
    assert keys["bar"].units == ()
    assert keys["bar.inertia"].units == ("kg*m^2",)
    assert keys["bar.inertia"].default == 0.5
    assert not keys["bar.inertia"].required


def test_every_key_of_a_machine_has_a_meaning_and_its_numbers_a_unit() -> None:
    keys = {".".join(key.path): key for key in keys_of(Orthoglide).every()}
    assert [name for name, key in keys.items() if not key.meaning] == []
    without = [name for name, key in keys.items() if not (key.units or key.part or key.words)]
    assert without == ["branch"]
    assert keys["feet.material.yield"].units == ("Pa",)
    assert keys["feet"].words == keys["legs.section"].words == ("rigid",)
    assert "steel" in keys["legs.material"].words
    assert keys["legs.kind"].words == ("PUU", "PRPaR")


def test_the_same_part_in_two_places_is_known_for_the_same() -> None:
    keys = {".".join(key.path): key.part for key in keys_of(Orthoglide).every() if key.part}
    assert keys["legs.section"].text == keys["feet.section"].text
    assert keys["legs.section"].text != keys["legs.material"].text

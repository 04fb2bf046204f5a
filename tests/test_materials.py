"""The table of materials: complete, in SI, and elastically possible."""

from __future__ import annotations

import pytest

from orthospec.mechanics.materials import TABLE, Material, shear_modulus


def test_the_table_has_the_usual_materials_of_machines():
    assert set(TABLE) == {"steel", "aluminium", "titanium", "carbon"}


@pytest.mark.parametrize(
    ("name", "E", "density"),
    [("steel", 210e9, 7850), ("aluminium", 70e9, 2700), ("titanium", 113.8e9, 4430), ("carbon", 135e9, 1600)],
)
def test_values_are_those_of_their_sources(name, E, density):
    assert TABLE[name].E == E
    assert TABLE[name].density == density


@pytest.mark.parametrize(("name", "G"), [("steel", 81e9), ("aluminium", 27e9), ("titanium", 44e9)])
def test_shear_moduli_are_near_the_printed_ones(name, G):
    assert pytest.approx(G, rel=0.04) == TABLE[name].G


def test_the_composite_is_softer_in_shear_than_any_isotropic_material_and_does_not_yield():
    carbon = TABLE["carbon"]
    assert carbon.G < carbon.E / 3
    assert carbon.yield_strength is None


def test_the_table_cannot_be_changed():
    with pytest.raises(TypeError):
        TABLE["wood"] = Material(11e9, 0.7e9)  # type: ignore[index]


def test_shear_modulus_of_an_incompressible_material_is_a_third_of_E():
    assert shear_modulus(3.0, nu=0.5) == 1.0

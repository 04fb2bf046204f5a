"""Parts as keys of a spec: what is read, what is written again, what is missing, how mistakes are told."""

from __future__ import annotations

import subprocess
import sys

import jsonschema
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import BaseModel, ConfigDict, ValidationError

from orthospec.manipulators.parts import Actuators, Body, Feet, FeetOrRigid, Legs
from orthospec.manipulators.stock import Material, Section
from orthospec.mechanics import bars, materials, sections
from orthospec.spec.wording import problems

TUBE = {"round": {"diameter": 0.02, "wall": 0.002}}
FEA = bars.cantilever(sections.circle(diameter=0.02), materials.TABLE["steel"], 0.3).tolist()


class Machine(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")

    legs: Legs = Legs()
    feet: FeetOrRigid = None
    actuators: Actuators = Actuators()
    platform: Body | None = None


SCHEMA = jsonschema.Draft202012Validator(Machine.model_json_schema())


def machine(variables=None, **keys):
    return Machine.model_validate(keys, context={"variables": variables or {}})


def mistakes(**keys):
    with pytest.raises(ValidationError) as refused:
        machine(**keys)
    return {problem.path: problem.message for problem in problems(refused.value, keys, Machine)}


positive = st.floats(1e-3, 1e3)
shapes = st.one_of(
    st.just("rigid"),
    st.fixed_dictionaries({"round": st.fixed_dictionaries({"diameter": positive})}),
    st.fixed_dictionaries(
        {"rectangle": st.fixed_dictionaries({"height": positive, "width": positive, "wall": st.just(1e-4)})}
    ),
    st.fixed_dictionaries({"given": st.fixed_dictionaries(dict.fromkeys(("A", "Iy", "Iz", "J"), positive))}),
    st.fixed_dictionaries({"compliance": st.just(FEA)}),
)
stuffs = st.one_of(
    st.sampled_from(sorted(materials.TABLE)),
    st.fixed_dictionaries({}, optional={"E": positive, "nu": st.floats(-0.9, 0.5), "yield": positive}),
    st.fixed_dictionaries({"G": positive, "density": positive}),
)
offsets = st.floats(-1, 1)
bar_keys = {"section": shapes, "material": stuffs, "mass": st.floats(0, 10)}
machines = st.fixed_dictionaries(
    {},
    optional={
        "legs": st.fixed_dictionaries({}, optional={**bar_keys, "kind": st.just("PUU"), "offset": offsets})
        | st.fixed_dictionaries(
            {"kind": st.just("PRPaR")}, optional={**bar_keys, "spacing": positive, "offset": offsets}
        ),
        "feet": st.just("rigid") | st.fixed_dictionaries({"length": positive}, optional=bar_keys),
        "actuators": st.fixed_dictionaries(
            {}, optional=dict.fromkeys(("force", "stiffness", "mass", "speed", "friction"), positive)
        ),
        "platform": st.fixed_dictionaries({"mass": positive}),
    },
)


class TestReading:
    @given(machines)
    def test_what_is_written_is_read_as_the_same(self, keys):
        made = machine(**keys)
        for written in (made.model_dump(), made.model_dump(mode="json", exclude_none=True)):
            assert machine(**written) == made

    def test_the_schema_is_one(self):
        jsonschema.Draft202012Validator.check_schema(SCHEMA.schema)

    @given(machines)
    def test_the_schema_accepts_what_is_accepted(self, keys):
        SCHEMA.validate(keys)

    @pytest.mark.parametrize(
        "keys",
        [
            {"legs": {"section": "soft"}},
            {"legs": {"section": {"rond": {"diameter": 1}}}},
            {"legs": {"material": "stel"}},
            {"feet": "soft"},
        ],
    )
    def test_the_schema_refuses_wrong_words(self, keys):
        with pytest.raises(jsonschema.ValidationError):
            SCHEMA.validate(keys)

    def test_each_part_alone_is_read_again(self):
        for part in (
            Section.model_validate("rigid"),
            Section.model_validate(TUBE),
            Material.model_validate("steel"),
            Feet(length=0.1),
            Actuators(force=1.0),
        ):
            assert type(part).model_validate(part.model_dump()) == part

    def test_expressions_and_quantities_are_resolved(self):
        legs = machine(
            {"h": 0.03, "mu": 2.0},
            legs={
                "section": {"rectangle": {"height": "h * mu", "width": "h / mu", "wall": "1 mm"}},
                "material": {"E": "70 GPa", "nu": 0.33, "density": 2700},
                "mass": "200 g",
            },
        ).legs
        assert legs.section.properties() == sections.rectangle(height=0.06, width=0.015, wall=0.001)
        assert pytest.approx(70e9 / 2.66) == legs.material.properties().G
        assert legs.mass == 0.2

    @pytest.mark.parametrize("name", sorted(materials.TABLE))
    def test_a_name_stands_for_the_values_of_the_table(self, name):
        assert Material.model_validate(name).properties() == materials.TABLE[name]

    def test_rigid_feet_are_no_feet(self):
        assert machine(feet="rigid").feet is None
        assert machine(feet=None).feet is None

    def test_rigid_is_written_as_the_word(self):
        made = machine(legs={"section": "rigid"})
        assert made.model_dump(exclude_none=True)["legs"]["section"] == "rigid"


class TestBars:
    def test_compliance_and_mass_of_a_tube(self):
        legs = Legs.model_validate({"section": TUBE, "material": "aluminium"})
        tube, aluminium = sections.circle(diameter=0.02, wall=0.002), materials.TABLE["aluminium"]
        np.testing.assert_array_equal(legs.bar_compliance(0.5), bars.cantilever(tube, aluminium, 0.5))
        assert legs.bar_mass(0.5) == pytest.approx(2700 * tube.area * 0.5)

    def test_feet_know_their_length(self):
        feet = Feet.model_validate({"length": 0.1, "section": TUBE, "material": "steel"})
        legs = Legs.model_validate({"section": TUBE, "material": "steel"})
        np.testing.assert_array_equal(feet.bar_compliance(), legs.bar_compliance(0.1))
        assert feet.bar_mass() == legs.bar_mass(0.1)

    def test_a_mass_given_stands_in_place_of_the_computed_one(self):
        legs = Legs.model_validate({"section": TUBE, "material": "steel", "mass": 0.0})
        assert legs.bar_mass(0.5) == 0.0

    def test_a_compliance_given_is_taken_as_it_is_at_any_length(self):
        legs = Legs.model_validate({"section": {"compliance": FEA}})
        np.testing.assert_array_equal(legs.bar_compliance(0.1), FEA)
        np.testing.assert_array_equal(legs.bar_compliance(9.0), FEA)

    def test_rigid_bars_have_no_compliance(self):
        np.testing.assert_array_equal(
            Legs.model_validate({"section": "rigid"}).bar_compliance(1.0), np.zeros((6, 6))
        )


class TestMissing:
    @pytest.mark.parametrize(
        ("keys", "compliance", "mass"),
        [
            ({}, ("legs.section", "legs.material"), ("legs.section", "legs.material")),
            ({"section": TUBE}, ("legs.material",), ("legs.material",)),
            ({"material": "steel"}, ("legs.section",), ("legs.section",)),
            ({"section": TUBE, "material": "steel"}, (), ()),
            ({"section": TUBE, "material": {"E": 1, "nu": 0}}, (), ("legs.material.density",)),
            ({"section": TUBE, "material": {"density": 1}}, ("legs.material.E", "legs.material.G"), ()),
            ({"section": TUBE, "material": {"G": 1, "density": 1}}, ("legs.material.E",), ()),
            ({"section": "rigid"}, (), ("legs.mass",)),
            ({"section": {"compliance": FEA}, "mass": 1}, (), ()),
            ({"mass": 1}, ("legs.section", "legs.material"), ()),
            ({"kind": "PRPaR", "section": TUBE, "material": "steel"}, ("legs.spacing",), ()),
            ({"kind": "PRPaR", "section": "rigid", "spacing": 0.1, "mass": 0}, (), ()),
        ],
    )
    def test_what_is_missing_is_named_by_its_key(self, keys, compliance, mass):
        legs = Legs.model_validate(keys)
        assert legs.missing("compliance") == compliance
        assert legs.missing("mass") == mass

    def test_feet_name_theirs(self):
        feet = Feet.model_validate({"length": 0.1, "section": TUBE})
        assert feet.missing("compliance") == ("feet.material",)
        assert Feet.model_validate({"length": 0.1, "section": "rigid"}).missing("mass") == ("feet.mass",)

    @given(machines)
    def test_nothing_is_missing_exactly_where_it_can_be_computed(self, keys):
        legs = machine(**keys).legs
        bar_missing = set(legs.missing("compliance")) - {"legs.spacing"}
        assert (legs.bar_compliance(0.3) is None) == bool(bar_missing)
        assert (legs.bar_mass(0.3) is None) == bool(legs.missing("mass"))


ONE_OF_FOUR = "one of 'round', 'rectangle', 'given' and 'compliance' was expected, or the word 'rigid'; "
SKEW = [list(range(6))] * 6
GAINS = [[1, 2, 0, 0, 0, 0], [2, 1, 0, 0, 0, 0], *([0] * 6 for _ in range(4))]


class TestMistakes:
    @pytest.mark.parametrize(
        ("section", "path", "message"),
        [
            ("rigd", (), ONE_OF_FOUR + "'rigd' given"),
            ({}, (), ONE_OF_FOUR + "nothing given"),
            ({**TUBE, "compliance": FEA}, (), ONE_OF_FOUR + "'round' and 'compliance' given"),
            ({"rond": {}}, ("rond",), "unknown key 'rond'; did you mean 'round'?"),
            ({"round": {}}, ("round",), "'diameter' is missing: Outer diameter [m]"),
            ({"round": 5}, ("round",), "a mapping was expected, 5 given"),
            ({"compliance": [[0] * 6] * 5}, ("compliance",), "6 values were expected, 5 given"),
            ({"compliance": [[0] * 6] * 5 + [[0] * 5]}, ("compliance", 5), "6 values were expected, 5 given"),
            ({"compliance": SKEW}, ("compliance",), "a compliance is symmetric, and this matrix is not"),
            (
                {"compliance": GAINS},
                ("compliance",),
                "a compliance has no negative eigenvalue, and this has",
            ),
        ],
    )
    def test_in_a_section_is_told_at_its_key(self, section, path, message):
        assert mistakes(legs={"section": section}) == {("legs", "section", *path): message}

    @pytest.mark.parametrize(
        ("key", "value", "message"),
        [
            ("wal", 1, "unknown key 'wal'; did you mean 'wall'?"),
            ("diameter", "-1 m", "more than 0 was expected, '-1 m' is -1"),
            ("diameter", "3 kg", "3 kg is a mass, a length [m] was expected"),
        ],
    )
    def test_in_a_shape_is_told_at_its_key(self, key, value, message):
        tube = {"diameter": 1, key: value}
        assert mistakes(legs={"section": {"round": tube}}) == {("legs", "section", "round", key): message}

    def test_a_wall_without_hollow_is_told_at_the_section(self):
        found = mistakes(feet={"length": 1, "section": {"round": {"diameter": 0.02, "wall": 0.01}}})
        assert list(found) == [("feet", "section", "round")]
        assert "a wall of 0.01 m does not fit" in found["feet", "section", "round"]

    @pytest.mark.parametrize(
        ("material", "path", "message"),
        [
            (
                "stel",
                (),
                "unknown material 'stel'; did you mean 'steel'? "
                "known here: steel, aluminium, titanium, carbon",
            ),
            (
                {"E": 1, "G": 1, "nu": 0},
                (),
                "'G' or 'nu' was expected, both given: each follows from the other",
            ),
            ({"yeld": 1}, ("yeld",), "unknown key 'yeld'; did you mean 'yield'?"),
            ({"yield": 0}, ("yield",), "more than 0 was expected, 0 given"),
            ({"nu": 0.7}, ("nu",), "0.5 or less was expected, 0.7 given"),
        ],
    )
    def test_in_a_material_is_told_at_its_key(self, material, path, message):
        assert mistakes(legs={"material": material}) == {("legs", "material", *path): message}

    def test_of_a_spacing_without_a_kind_is_told(self):
        message = "'spacing' is of the two bars of a PRPaR leg: give 'kind' too, PRPaR or PUU"
        assert mistakes(legs={"spacing": 0.1}) == {("legs",): message}
        assert machine(legs={"spacing": 0.1, "kind": "PUU"}).legs.spacing == 0.1

    def test_of_several_parts_are_told_at_once(self):
        assert mistakes(
            legs={"kind": "PUS", "spacing": 0},
            feet="soft",
            actuators={"force": "3 m", "friction": -1},
            platform={},
        ) == {
            ("legs", "kind"): "'PUU' or 'PRPaR' was expected, 'PUS' given",
            ("legs", "spacing"): "more than 0 was expected, 0 given",
            ("feet",): "'rigid' or a mapping with 'length' was expected, 'soft' given",
            ("actuators", "force"): "3 m is a length, a force [N] was expected",
            ("actuators", "friction"): "0 or more was expected, -1 given",
            ("platform",): "'mass' is missing: Mass [kg]",
        }


def test_importing_the_parts_does_not_import_numpy():
    code = "import sys, orthospec.manipulators.parts; sys.exit('numpy' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0

"""A machine's parts in words: one row each, in units of drawings, without what is at its default."""

from __future__ import annotations

import pytest

from orthospec.show import show
from orthospec.show.labels import Field
from orthospec.show.machine import fields
from orthospec.show.numbers import Numbers
from orthospec.spec import load_spec

PARTS = """\
orthospec: 1
variables:
  height: {min: 20 mm, max: 60 mm}
  stiffness: {min: 1e7, max: 1e8}
manipulator:
  use: orthoglide
  leg_lengths: [0.31, 0.31, 0.31]
  legs: {kind: PUU, section: {rectangle: {height: height, width: 20 mm}}, material: steel, mass: 300 g}
  feet: {length: 0.06, mass: 0.5, section: {compliance: MATRIX}}
  actuators: {force: 0.5 kN, stiffness: stiffness, mass: 1}
  gravity: [0, 0, -9.81 m/s^2]
workspace: {size: [200 mm, 200 mm, 200 mm]}
measures:
  cutting: {use: deflection, wrench: [0, 0, -100, 0, 0, 2], at_most: 15 um}
  quick: {use: acceleration, at_least: 20}
goals:
  mass: {minimise: total_mass, goal: 9000 g, weight: relative}
  sag: {minimise: worst(cutting), goal: 10 um}
  drive: {minimise: stiffness, goal: 30 N/um}
""".replace("MATRIX", str([[1e-9 * (i == j) for j in range(6)] for i in range(6)]))


@pytest.fixture(scope="module")
def parts(tmp_path_factory: pytest.TempPathFactory) -> str:
    """A machine with parts in words, as the terminal has it."""
    path = tmp_path_factory.mktemp("parts") / "spec.yaml"
    path.write_text(PARTS)
    spec = load_spec(path)
    design = spec.design({"height": 0.042, "stiffness": 2.5e7})
    keys = design.manipulator.model_dump(mode="json", by_alias=True, exclude_none=True)
    measured = {"lowest": {"value": 2e-6, "at": [0, 0, 0]}, "highest": {"value": 1.5e-5, "at": [0, 0, 0]}}
    goals = {
        name: {"value": value, "goal": 1.0, "weight": 9.0, "attained": True}
        for name, value in (("mass", 8.5), ("sag", 1.5e-5), ("drive", 2.5e7))
    }
    content = {
        "orthospec": 1,
        "status": "attained",
        "attainment": {"factor": -0.1, "goals": goals},
        "variables": dict(design.values),
        "manipulator": {"use": "orthoglide", **keys},
        "indices": {
            "total_mass": 8.5,
            "leg_1_mass": 0.3,
            "leg_2_mass": 0.3,
            "leg_3_mass": 0.3,
            "stroke": None,
        },
        "workspace": {"prescribed": None, "measures": {"cutting": measured, "quick": {}}},
        "provenance": {"from": {"path": "solved/result.yaml", "sha256": "00"}},
    }
    return show(content, width=80, colour=False, spec=spec)


def test_parts_are_rows_in_the_units_of_drawings_and_of_the_spec(parts: str) -> None:
    for line in (
        "Machine: orthoglide, from solved/result.yaml",
        "  leg_lengths                3 x 310 mm",
        "  gravity                    0  0  -9.81 m/s^2",
        "  legs                       kind PUU, mass 300 g",
        "  legs.section.rectangle     height 42 mm, width 20 mm",
        "  legs.material              steel: E 210 GPa, G 80.7692 GPa, density 7850",
        "                             kg/m^3, yield 355 MPa",
        "  feet                       length 60 mm, mass 0.5 kg",
        "  feet.section               compliance 6 x 6 matrix",
        "  actuators                  force 0.5 kN, stiffness 25 N/um, mass 1 kg",
        "  leg_1_mass ... leg_3_mass  3 x 0.3 kg",
        "  stroke                     -",
    ):
        assert line in parts.splitlines()


def test_what_is_at_its_default_is_left_out(parts: str) -> None:
    for name in ("branch", "friction", "offset", "ball", "joint_limits"):
        assert name not in parts


def test_numbers_are_told_in_the_unit_that_the_spec_gives_them_in(parts: str) -> None:
    lines = [" ".join(line.split()) for line in parts.splitlines()]
    for line in (
        "height 42 mm within 20 ... 60 mm",
        "stiffness 25 N/um within 10 ... 100 N/um",
        "mass 8500 g 1000 g relative met minimise total_mass",
        "sag 15 um 1e+06 um 9 met minimise worst(cutting)",
        "drive 25 N/um 1e-06 N/um 9 met minimise stiffness",
        "cutting: deflection, wrench 0 0 -100 N 0 0 2 N*m, at most 15 um",
        "quick: acceleration, at least 20 m/s^2",
        "highest 15 um at (0.000, 0.000, 0.000) mm",
    ):
        assert line in lines


def test_small_lengths_of_parts_are_in_millimetres_in_a_text_in_metres_too() -> None:
    known: dict[tuple[str, ...], Field] = {(name,): Field(units=("m",)) for name in ("wall", "length")}
    rows = dict(fields({"wall": 0.002, "length": 1.5}, known, Numbers(millimetres=False)))
    assert rows == {"wall": "2 mm", "length": "1.5 m"}

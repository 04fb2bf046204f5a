"""Fields are described as pydantic itself would, but their source is read only when that is asked for."""

from __future__ import annotations

import importlib
import subprocess
import sys
from pathlib import Path
from typing import Annotated

import pytest
from pydantic import BaseModel, ConfigDict, Field

from orthospec.described import Described, description
from orthospec.manipulators.orthoglide import Orthoglide
from orthospec.spec.model import SpecKeys

OWN = ConfigDict(use_attribute_docstrings=True)


class Bar(Described):
    """A bar."""

    length: float
    """Its length [m].

    From joint to joint.
    """
    section: Annotated[float, Field(alias="area")] = 1.0
    """Its section [m^2]."""
    told: Annotated[float, Field(description="Told beside.")] = 0.0
    """Told below."""
    silent: float = 0.0


class Leg(Bar):
    bars: tuple[Bar, ...] = ()
    """What it is made of."""
    length: float = 2.0
    """Its reach [m]."""


class OwnBar(BaseModel):
    """A bar."""

    model_config = OWN

    length: float
    """Its length [m].

    From joint to joint.
    """
    section: Annotated[float, Field(alias="area")] = 1.0
    """Its section [m^2]."""
    told: Annotated[float, Field(description="Told beside.")] = 0.0
    """Told below."""
    silent: float = 0.0


class OwnLeg(OwnBar):
    bars: tuple[OwnBar, ...] = ()
    """What it is made of."""
    length: float = 2.0
    """Its reach [m]."""


@pytest.mark.parametrize(("ours", "own"), [(Bar, OwnBar), (Leg, OwnLeg)])
def test_the_schema_is_that_of_pydantic(ours: type[BaseModel], own: type[BaseModel]) -> None:
    expected = own.model_json_schema()
    assert "From joint to joint." in str(expected) + str(own.model_fields)
    text = repr(expected).replace("OwnBar", "Bar").replace("OwnLeg", "Leg")
    assert repr(ours.model_json_schema()) == text


@pytest.mark.parametrize("name", list(OwnLeg.model_fields))
def test_a_field_says_what_pydantic_has_it_say(name: str) -> None:
    assert description(Leg, name) == OwnLeg.model_fields[name].description
    assert description(OwnLeg, name) == OwnLeg.model_fields[name].description


def test_a_class_in_a_function_is_found() -> None:
    class Local(Described):
        force: float
        """In there [N]."""

    assert description(Local, "force") == "In there [N]."
    assert Local.model_json_schema()["properties"]["force"]["description"] == "In there [N]."


def test_a_module_that_is_edited_and_loaded_anew_says_what_it_says_now(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(tmp_path)
    for text in ("Mass [kg].", "All of the mass [kg]."):
        lines = ["from orthospec.described import Described", "class Platform(Described):", "    mass: float"]
        source = "\n".join([*lines, f"    '{text}'\n"])
        (tmp_path / "edited_machine.py").write_text(source, encoding="utf-8")
        sys.modules.pop("edited_machine", None)
        importlib.invalidate_caches()
        assert description(importlib.import_module("edited_machine").Platform, "mass") == text
    del sys.modules["edited_machine"]


def test_without_a_source_nothing_is_said() -> None:
    scope = {"Described": Described, "__name__": "nowhere"}
    exec("class Gone(Described):\n    force: float\n    'A force.'\n", scope)
    assert description(scope["Gone"], "force") is None
    assert "description" not in scope["Gone"].model_json_schema()["properties"]["force"]


@pytest.mark.parametrize("made_of", [SpecKeys, Orthoglide])
def test_every_key_of_a_spec_is_described(made_of: type[BaseModel]) -> None:
    assert all(description(made_of, name) for name in made_of.model_fields)


def test_no_source_is_read_before_it_is_asked_for() -> None:
    program = """
import inspect
inspect.getsource = inspect.getsourcelines = inspect.findsource = lambda *_: 1 / 0
import orthospec.manipulators.orthoglide, orthospec.measures.elastic, orthospec.result, orthospec.spec
"""
    subprocess.run([sys.executable, "-P", "-c", program], check=True, capture_output=True)

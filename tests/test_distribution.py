"""The distribution that `orthospec new-plugin` writes: whole, passing, and never over something."""

from __future__ import annotations

import importlib.util
import sys
import tomllib
from pathlib import Path
from types import ModuleType

import pytest

from orthospec.errors import UsageError
from orthospec.manipulators import Manipulator
from orthospec.measures import Measure
from orthospec.starter import write_plugin

BASES = {"measure": Measure, "manipulator": Manipulator}


def imported(path: Path, name: str, monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    monkeypatch.setitem(sys.modules, name, module)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize("kind", BASES)
def test_its_tests_pass_as_they_are_written(
    kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    folder = write_plugin("own-speed_2", kind)  # type: ignore[arg-type]
    package = imported(folder / "src" / "own_speed_2" / "__init__.py", "own_speed_2", monkeypatch)
    assert issubclass(package.OwnSpeed2, BASES[kind])
    tests = imported(folder / "tests" / "test_own_speed_2.py", "test_own_speed_2", monkeypatch)
    ran = [name for name in dir(tests) if name.startswith("test_")]
    for name in ran:
        getattr(tests, name)()
    assert len(ran) == 2


@pytest.mark.parametrize("kind", BASES)
def test_its_entry_point_names_its_class(kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    folder = write_plugin("own_speed", kind)  # type: ignore[arg-type]
    project = tomllib.loads((folder / "pyproject.toml").read_text())["project"]
    assert project["name"] == "own-speed"
    assert project["entry-points"] == {f"orthospec.{kind}s": {"own_speed": "own_speed:OwnSpeed"}}
    assert "use: own_speed" in (folder / "specs" / "try.yaml").read_text()
    assert not any("$" in path.read_text() for path in folder.rglob("*") if path.is_file())


@pytest.mark.parametrize("name", ["Tool", "../away", "a--b", "", "1st", "a b", "a."])
def test_a_name_that_is_none_is_refused(name: str) -> None:
    with pytest.raises(UsageError, match="lower-case letters, digits and single - or _"):
        write_plugin(name, "measure")


@pytest.mark.parametrize(
    ("name", "taken"),
    [
        ("class", "a word of Python"),
        ("json", "a module that is there already"),
        ("numpy", "a module that is there already"),
        ("deflection", "an installed machine or measure"),
    ],
)
def test_a_name_that_is_taken_is_refused(name: str, taken: str) -> None:
    with pytest.raises(UsageError, match=f"'{name}' is {taken}: give another name"):
        write_plugin(name, "measure")


def test_what_is_there_is_left_as_it_is(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    write_plugin("mine", "measure")
    readme = Path("mine/README.md")
    readme.write_text("changed")
    with pytest.raises(UsageError, match="mine is there already"):
        write_plugin("mine", "manipulator")
    assert readme.read_text() == "changed"

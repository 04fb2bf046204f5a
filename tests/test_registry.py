"""Plugins by entry point: distributions made up in a folder on the path."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

from orthospec import registry
from orthospec.errors import PluginFault, UsageError
from orthospec.manipulators.orthoglide import Orthoglide
from orthospec.measures import Measure

CLEARANCE = """
from orthospec.measures import Measure

class Clearance(Measure):
    unit = "m"
    sides = frozenset({"at_least"})

    def values(self, manipulator, poses):
        return poses[:, 0]

class Unfinished(Measure):
    unit = "m"
    sides = frozenset()

class Undeclared(Measure):
    def values(self, manipulator, poses):
        return poses[:, 0]

not_a_class = 3
"""


def install(folder: Path, distribution: str, entries: dict[str, str], version: str = "1.0") -> None:
    """Write the metadata of a distribution whose measures are ``entries``, as an installer would."""
    info = folder / f"{distribution.replace('-', '_')}-{version}.dist-info"
    info.mkdir(parents=True)
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {distribution}\nVersion: {version}\n")
    lines = [f"{name} = {target}" for name, target in entries.items()]
    (info / "entry_points.txt").write_text("[orthospec.measures]\n" + "\n".join(lines) + "\n")


@pytest.fixture
def site(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder on the path, with the module of a plugin in it."""
    (tmp_path / "made_up_clearance.py").write_text(CLEARANCE)
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.delitem(sys.modules, "made_up_clearance", raising=False)
    return tmp_path


def test_the_builtins_come_through_the_entry_points() -> None:
    assert registry.find_manipulator("orthoglide") is Orthoglide
    assert issubclass(registry.find_measure("condition_number"), Measure)
    assert registry.distribution_of(registry.MEASURES, "condition_number").distribution == "orthospec"


def test_an_outside_measure_is_found_beside_the_builtins(site: Path) -> None:
    install(site, "made-up", {"clearance": "made_up_clearance:Clearance"}, version="2.1")
    assert registry.find_measure("clearance").__name__ == "Clearance"
    owner = registry.distribution_of(registry.MEASURES, "clearance")
    assert (owner.distribution, owner.version) == ("made-up", "2.1")
    assert owner in registry.installed()
    assert registry.find_measure("condition_number")


def test_an_unknown_name_lists_the_installed_ones() -> None:
    message = "unknown measure 'condition_numer'; did you mean 'condition_number'? installed: acceleration, "
    with pytest.raises(UsageError, match=re.escape(message)):
        registry.find_measure("condition_numer")
    with pytest.raises(UsageError, match=r"unknown manipulator 'hexaglide'; .*installed: .*orthoglide"):
        registry.find_manipulator("hexaglide")


def test_two_owners_of_a_name_are_an_error_only_where_it_is_used(site: Path) -> None:
    install(site / "one", "first-owner", {"clearance": "made_up_clearance:Clearance"})
    install(site / "two", "second-owner", {"clearance": "made_up_clearance:Clearance"})
    sys.path[:0] = [str(site / "one"), str(site / "two")]
    with pytest.raises(UsageError, match="'clearance' is provided by first-owner and second-owner"):
        registry.find_measure("clearance")
    assert registry.names(registry.MEASURES).count("clearance") == 1
    assert len([entry for entry in registry.installed() if entry.name == "clearance"]) == 2
    assert registry.find_measure("condition_number")


def test_a_distribution_found_twice_is_one_owner_the_first_on_the_path(site: Path) -> None:
    install(site / "one", "made-up", {"clearance": "made_up_clearance:Clearance"}, version="2.0")
    install(site / "two", "made_up", {"clearance": "made_up_clearance:Clearance"}, version="1.0")
    sys.path[:0] = [str(site / "one"), str(site / "two")]
    assert registry.distribution_of(registry.MEASURES, "clearance").version == "2.0"


@pytest.mark.parametrize(
    ("target", "what"),
    [
        (
            "made_up_missing:Clearance",
            "cannot be loaded: ModuleNotFoundError: No module named 'made_up_missing'",
        ),
        ("made_up_clearance:Nothing", "cannot be loaded: AttributeError"),
        ("made_up_clearance:not_a_class", "is not a Measure class"),
        ("orthospec.manipulators.orthoglide:Orthoglide", "is not a Measure class"),
        ("made_up_clearance:Unfinished", "does not define values"),
        ("made_up_clearance:Undeclared", "does not declare unit, sides"),
    ],
)
def test_a_broken_plugin_is_named_and_the_rest_works(site: Path, target: str, what: str) -> None:
    install(site, "made-up", {"clearance": target})
    with pytest.raises(PluginFault, match=rf"plugin clearance: {re.escape(target)} of made-up {what}"):
        registry.find_measure("clearance")
    assert registry.find_measure("condition_number")


def test_listing_loads_no_plugin() -> None:
    program = "import sys; from orthospec import registry; registry.installed(); print(*sys.modules)"
    modules = subprocess.run(
        [sys.executable, "-P", "-c", program], capture_output=True, text=True, check=True
    ).stdout
    assert "orthospec.registry" in modules
    assert not {"orthospec.measures", "orthospec.manipulators", "numpy", "cvxpy"} & set(modules.split())

"""The docs: each page is in the navigation, each command in them exists, each public name is documented."""

from __future__ import annotations

import importlib
import inspect
import re
import shlex
from pathlib import Path
from typing import Any

import pytest
import typer
import yaml

import orthospec
from orthospec.cli import app
from orthospec.quantities.fields import resolve

ROOT = Path(__file__).parents[1]
PAGES = [
    ROOT / "README.md",
    *sorted((ROOT / "docs").rglob("*.md")),
    *sorted(ROOT.glob("plugins/*/README.md")),
]


def site() -> Any:
    path = ROOT / "docs" / "hooks.py"
    spec = importlib.util.spec_from_file_location("docs_hooks", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_each_page_is_in_the_navigation_and_each_entry_is_there() -> None:
    text = (ROOT / "mkdocs.yml").read_text(encoding="utf-8")
    named = set(re.findall(r": ([\w/-]+\.md)$", text, re.MULTILINE))
    here = {str(path.relative_to(ROOT / "docs")) for path in (ROOT / "docs").rglob("*.md")}
    assert named == here | {
        "index.md",
        *(name for name in site().generated() if name.startswith("reference/")),
    }
    assert yaml.safe_load(text.split("markdown_extensions")[0])["strict"] is True


def commands() -> list[tuple[str, str]]:
    found = []
    for page in PAGES:
        for block in re.findall(r"```sh\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL):
            lines = [line for line in block.splitlines() if line.startswith("orthospec ")]
            found += [(f"{page.name}: {line}", line) for line in lines]
    return found


@pytest.mark.parametrize("line", [pytest.param(line, id=name) for name, line in commands()])
def test_each_command_in_the_pages_is_one_with_these_options(line: str) -> None:
    words = shlex.split(line.partition(" > ")[0].partition(" | ")[0])
    group = typer.main.get_command(app)
    command = group.commands[words[1]]  # type: ignore[attr-defined]
    context = command.make_context(words[1], words[2:], resilient_parsing=False)
    for value in (context.params.get("at") or "").split(","):
        resolve(value.partition("=")[2] or 0, None, {})


def test_the_first_minutes_take_commands_that_there_are() -> None:
    script = (ROOT / ".ci" / "first-minutes").read_text(encoding="utf-8")
    lines = re.findall(r'"\$bin/orthospec" (.*)$', script, re.MULTILINE)
    assert [line.split()[0] for line in lines] == ["run", "init", "check", "run", "run", "diff"]
    group = typer.main.get_command(app)
    for line in lines:
        name, *words = shlex.split(line)
        group.commands[name].make_context(name, words)  # type: ignore[attr-defined]


def test_the_reference_tells_every_command_key_machine_and_measure() -> None:
    pages = site().generated()
    for name in typer.main.get_command(app).commands:  # type: ignore[attr-defined]
        assert f"## orthospec {name}\n" in pages["reference/commands.md"]
    for key in ("variables", "manipulator", "workspace", "measures", "goals", "pareto", "proof"):
        assert f"| `{key}` |" in pages["reference/keys.md"]
    for name in ("orthoglide", "linear_delta", "deflection", "velocity_transmission", "acceleration"):
        assert f"## {name}\n" in pages["reference/plugins.md"]
    assert "| `leg_lengths` | m | Lengths of the legs" in pages["reference/plugins.md"]
    for name in orthospec.__all__:
        assert f"::: orthospec.{name}\n" in pages["reference/python.md"]


def test_no_picture_loads_anything() -> None:
    for path in (ROOT / "docs" / "screens").glob("*.svg"):
        assert not re.search(
            r"url\(['\"]?https?:|@import|href=['\"]https?:", path.read_text(encoding="utf-8")
        )


def public() -> list[tuple[str, object]]:
    found: list[tuple[str, object]] = [(name, getattr(orthospec, name)) for name in orthospec.__all__]
    for module in site().MODULES:
        one = importlib.import_module(f"orthospec.{module}")
        names = getattr(one, "__all__", [name for name in vars(one) if not name.startswith("_")])
        found += [(f"{module}.{name}", getattr(one, name)) for name in names]
    ours = [
        (name, one) for name, one in found if (getattr(one, "__module__", None) or "").startswith("orthospec")
    ]
    return [(name, one) for name, one in ours if inspect.isclass(one) or inspect.isfunction(one)]


@pytest.mark.parametrize(("name", "one"), [pytest.param(*case, id=case[0]) for case in public()])
def test_every_public_name_and_its_public_methods_are_documented(name: str, one: Any) -> None:
    assert (one.__doc__ or "").strip(), name
    if inspect.isclass(one):
        own = [
            value for key, value in vars(one).items() if not key.startswith("_") and inspect.isfunction(value)
        ]
        assert all(inspect.getdoc(value) for value in own), name

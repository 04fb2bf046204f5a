"""A distribution to start a plugin from: it installs and passes as it is written, and is then changed."""

from __future__ import annotations

import importlib.util
import keyword
import re
import shutil
import sys
from importlib.resources import files
from pathlib import Path
from string import Template
from typing import Literal, TypeAlias

from orthospec import registry
from orthospec.errors import UsageError

Kind: TypeAlias = Literal["measure", "manipulator"]
_NAME = re.compile(r"[a-z][a-z0-9]*([-_][a-z0-9]+)*")


def write_plugin(name: str, kind: Kind) -> Path:
    """Write a distribution of this name into a new folder beside; the folder.

    A name is lower-case words with - or _ between them. Raises `UsageError` for another one, where there is
    such a folder, or where it cannot be written: then nothing is left of it.
    """
    if not _NAME.fullmatch(name):
        raise UsageError(
            f"'{name}': lower-case letters, digits and single - or _ were expected, as in joint-error"
        )
    module = name.replace("-", "_")
    taken = _taken(module)
    if taken:
        raise UsageError(f"'{name}' is {taken}: give another name")
    folder = Path(name)
    if folder.exists():
        raise UsageError(f"{folder} is there already: give another name, or remove it first")
    words = {
        "distribution": name.replace("_", "-"),
        "module": module,
        "class_name": "".join(word.capitalize() for word in module.split("_")),
        "kind": kind,
    }
    try:
        for path, template in _files(module, kind).items():
            file = folder / path
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(_filled(template, words) if template else "", encoding="utf-8")
    except OSError as error:
        shutil.rmtree(folder, ignore_errors=True)
        raise UsageError(f"{folder}: cannot be written: {(error.strerror or str(error)).lower()}") from None
    return folder


def _taken(module: str) -> str:
    """By what a name is taken; nothing where it is free for a module and for a machine or measure."""
    if keyword.iskeyword(module):
        return "a word of Python"
    if module in sys.stdlib_module_names or importlib.util.find_spec(module) is not None:
        return "a module that is there already"
    if any(module in registry.names(group) for group in (registry.MEASURES, registry.MANIPULATORS)):
        return "an installed machine or measure"
    return ""


def _files(module: str, kind: Kind) -> dict[str, str]:
    """The template of each file; nothing for one that is empty."""
    return {
        "pyproject.toml": "pyproject.toml",
        "README.md": "README.md",
        f"src/{module}/__init__.py": f"{kind}.py",
        f"src/{module}/py.typed": "",
        f"tests/test_{module}.py": f"{kind}_test.py",
        "specs/try.yaml": f"{kind}.yaml",
    }


def _filled(template: str, words: dict[str, str]) -> str:
    text = files(__package__).joinpath("plugin", f"{template}.txt").read_text(encoding="utf-8")
    return Template(text).substitute(words)

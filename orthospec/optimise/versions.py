"""What code is at work: versions, and the bytes of the files themselves.

A version alone does not tell an installation that its owner is editing from the one that was released.
"""

from __future__ import annotations

import hashlib
import re
import sys
from collections.abc import Iterator
from contextlib import suppress
from functools import lru_cache
from importlib import metadata
from pathlib import Path
from types import ModuleType

from orthospec.spec import Spec

ITSELF = "orthospec"
LIBRARIES = (ITSELF, "numpy", "scipy", "clarabel", "cvxpy")
"""What results depend on beside plugins; a release of orthospec may differ in its compiled kernels alone."""
_OWN = frozenset({".py", ".c", ".h", ".inc"})
"""What decides a result in orthospec itself; what is compiled is told by its source, for any compiler."""


def fingerprint(spec: Spec) -> str:
    """A hash of all code that has a part in a spec's result: orthospec, its libraries, the plugins used."""
    classes = [spec.manipulator.made_of, *(plan.blueprint.made_of for plan in spec.measures)]
    packages = {ITSELF, *(made_of.__module__.partition(".")[0] for made_of in classes)}
    plugins = [f"{plugin.distribution} {plugin.version}" for plugin in spec.plugins]
    required = sorted({line for plugin in spec.plugins for line in _required(plugin.distribution)})
    lines = [*_versions(), *plugins, *required, *map(_hash_of, sorted(packages))]
    return hashlib.sha256("\n".join(lines).encode()).hexdigest()


@lru_cache(maxsize=1)
def _versions() -> tuple[str, ...]:
    python = ".".join(map(str, sys.version_info[:2]))
    return (f"python {python}", *(f"{name} {metadata.version(name)}" for name in LIBRARIES))


@lru_cache(maxsize=64)
def _required(distribution: str) -> tuple[str, ...]:
    """The distributions that a plugin's own says it needs, those of extras aside, in their versions here."""
    if distribution == ITSELF:
        return ()  # LIBRARIES has those that count.
    found = []
    for requirement in metadata.requires(distribution) or ():
        name = re.match(r"[\w.-]+", requirement)
        if name is not None and not re.search(r"\bextra\s*==", requirement):
            with suppress(metadata.PackageNotFoundError):  # for another system
                found.append(f"{name[0]} {metadata.version(name[0])}")
    return tuple(found)


@lru_cache(maxsize=64)
def _hash_of(package: str) -> str:
    """A hash of a package, file by file, data too; of its name alone where it has none."""
    total = hashlib.sha256(package.encode())
    for name, path in sorted(_files(sys.modules.get(package))):
        total.update(f"{name} {hashlib.sha256(path.read_bytes()).hexdigest()}\n".encode())
    return total.hexdigest()


def _files(module: ModuleType | None) -> Iterator[tuple[str, Path]]:
    """All that lies in a package but caches, with the name that it has there; a module is its own file."""
    if module is None:
        return
    for folder in getattr(module, "__path__", ()):
        for path in Path(folder).rglob("*"):
            name = path.relative_to(folder)
            if path.is_file() and not _is_cache(name) and (module.__name__ != ITSELF or path.suffix in _OWN):
                yield name.as_posix(), path
    if not hasattr(module, "__path__") and module.__file__ is not None:
        yield Path(module.__file__).name, Path(module.__file__)


def _is_cache(name: Path) -> bool:
    return name.suffix == ".pyc" or any(part == "__pycache__" or part.startswith(".") for part in name.parts)

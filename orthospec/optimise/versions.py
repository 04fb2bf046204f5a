"""What code is at work: versions, and the bytes of the files themselves.

A version alone does not tell an installation that its owner is editing from the one that was released.
"""

from __future__ import annotations

import hashlib
import sys
from collections.abc import Iterator
from functools import lru_cache
from importlib import metadata
from pathlib import Path
from types import ModuleType

from orthospec.spec import Spec

LIBRARIES = ("orthospec", "numpy", "scipy", "clarabel", "cvxpy")
"""What results depend on beside plugins; a release of orthospec may differ in its compiled kernels alone."""
_CODE = frozenset({".py", ".c", ".h", ".inc"})
"""What is compiled is told by its source where that is at hand: its own bytes depend on the compiler."""


def fingerprint(spec: Spec) -> str:
    """A hash of all code that has a part in a spec's result: orthospec, its libraries, the plugins used."""
    classes = [spec.manipulator.made_of, *(plan.blueprint.made_of for plan in spec.measures)]
    packages = {"orthospec", *(made_of.__module__.partition(".")[0] for made_of in classes)}
    plugins = [f"{plugin.distribution} {plugin.version}" for plugin in spec.plugins]
    lines = [*_versions(), *plugins, *map(_hash_of, sorted(packages))]
    return hashlib.sha256("\n".join(lines).encode()).hexdigest()


@lru_cache(maxsize=1)
def _versions() -> tuple[str, ...]:
    python = ".".join(map(str, sys.version_info[:2]))
    return (f"python {python}", *(f"{name} {metadata.version(name)}" for name in LIBRARIES))


@lru_cache(maxsize=64)
def _hash_of(package: str) -> str:
    """A hash of a package's code, file by file; of its name alone where it has none."""
    total = hashlib.sha256(package.encode())
    for name, path in sorted(_files(sys.modules.get(package))):
        total.update(f"{name} {hashlib.sha256(path.read_bytes()).hexdigest()}\n".encode())
    return total.hexdigest()


def _files(module: ModuleType | None) -> Iterator[tuple[str, Path]]:
    for folder in getattr(module, "__path__", ()):
        for path in Path(folder).rglob("*"):
            if path.suffix in _CODE:
                yield path.relative_to(folder).as_posix(), path
    if module is not None and not hasattr(module, "__path__") and module.__file__ is not None:
        yield Path(module.__file__).name, Path(module.__file__)

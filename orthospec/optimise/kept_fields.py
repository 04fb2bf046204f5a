"""Values of a design's measures on the grid, kept for bounds other than those they were computed for."""

from __future__ import annotations

import json
import zipfile
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from orthospec.optimise.cache import Cache, sha256_of
from orthospec.optimise.plain import encode
from orthospec.optimise.space import DesignSpace
from orthospec.optimise.versions import fingerprint
from orthospec.workspace.grid import Grid

if TYPE_CHECKING:
    from orthospec.arrays import Array

_BOUNDS = frozenset({"at_least", "at_most", "levels"})


class KeptFields:
    """The `KeptValues` of one design, beside the other results of a cache."""

    def __init__(self, cache: Cache, space: DesignSpace, values: Sequence[float]) -> None:
        content = space.spec.canonical()
        self._cache, self._measures = cache, content["measures"]
        self._common = [content["manipulator"], dict(zip(space.spec.variables, values, strict=True))]
        self._common.append(fingerprint(space.spec))

    def read(self, measure: str, grid: Grid) -> Array | None:
        """The values at the reachable nodes; None where none, or none sound, are kept."""
        try:
            with self._path(measure, grid).open("rb") as file, np.load(file, allow_pickle=False) as kept:
                return np.asarray(kept["values"])
        except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile):
            return None

    def write(self, measure: str, grid: Grid, values: Array) -> None:
        """Keep them; a full disk only means that they are not kept."""
        path = self._path(measure, grid)
        with suppress(OSError), self._cache.replacing(path) as fresh, fresh.open("wb") as file:
            np.savez(file, values=values)

    def _path(self, measure: str, grid: Grid) -> Path:
        own = {key: value for key, value in self._measures[measure].items() if key not in _BOUNDS}
        return self._cache.path(sha256_of(json.dumps([*self._common, own, encode(grid)])), "npz")

"""Values of a design's measures on the grid, kept for bounds other than those they were computed for."""

from __future__ import annotations

import json
import os
import zlib
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from orthospec.optimise.cache import Cache, own_keys, sha256_of
from orthospec.optimise.plain import encode
from orthospec.optimise.versions import fingerprint
from orthospec.workspace.field import Block
from orthospec.workspace.grid import Grid, make_grid

if TYPE_CHECKING:
    from orthospec.manipulators import Manipulator
    from orthospec.optimise.space import DesignSpace

_HEAD = 64
"""Bytes before the values, which stand where a processor likes to read them."""


class KeptFields:
    """The fields of one design, measure by measure and slab by slab, beside the other results of a cache.

    A file has a line with a sum of all that follows, the kind of the values and their number; the values,
    column by column as bounds are compared; and the reach, a bit a node. It is read whole, not mapped: for
    the sum all of it is read anyway, and a map would hold a file open for each slab.
    """

    def __init__(self, cache: Cache, space: DesignSpace, values: Sequence[float]) -> None:
        content = space.spec.canonical()
        self._cache, self._measures, self._setting = cache, content["measures"], space.setting
        design = dict(zip(space.spec.variables, values, strict=True))
        self._common = [content["manipulator"], design, fingerprint(space.spec)]

    def grid(self, manipulator: Manipulator) -> Grid:
        """The design's grid: looking for the end of its reach takes longer than to read a field."""
        setting = self._setting
        key = self._key("grid", encode(setting.size), setting.divisions, encode(setting.region))
        return self._cache.kept(
            key, Grid, lambda: make_grid(manipulator, setting.size, setting.divisions, setting.region)
        )

    def read(self, measure: str, grid: Grid, start: int, stop: int) -> Block | None:
        """The measure at the nodes start ... stop − 1; None where none, or none sound, are kept."""
        path = self._path(measure, grid, start, stop)
        try:
            data = path.read_bytes()
            if int(data[:8], 16) != zlib.crc32(memoryview(data)[8:]):
                return None
        except (OSError, ValueError):
            return None
        with suppress(OSError):
            os.utime(path)
        kind, *shape = data[8:_HEAD].decode().split()
        count = int(np.prod(list(map(int, shape))))
        values = np.frombuffer(data, kind, count, _HEAD).reshape(tuple(map(int, shape)), order="F")
        reachable = np.unpackbits(np.frombuffer(data, np.uint8, offset=_HEAD + values.nbytes))
        return Block(start, reachable[: stop - start].view(bool), {measure: values})

    def write(self, block: Block, grid: Grid) -> None:
        """Keep each measure of a block; a full disk only means that it is not kept."""
        for measure, values in block.values.items():
            shape = " ".join(map(str, values.shape))
            text = f" {values.dtype.str} {shape}".ljust(_HEAD - 9) + "\n"
            rest = text.encode() + values.tobytes("F") + np.packbits(block.reachable).tobytes()
            path = self._path(measure, grid, block.nodes.start, block.nodes.stop)
            with suppress(OSError), self._cache.replacing(path) as fresh:
                fresh.write_bytes(f"{zlib.crc32(rest):08x}".encode() + rest)

    def _path(self, measure: str, grid: Grid, start: int, stop: int) -> Path:
        own = own_keys(self._measures[measure])
        return self._cache.path(self._key(own, encode(grid), start, stop), "field")

    def _key(self, *parts: Any) -> str:
        return sha256_of(json.dumps([*self._common, *parts]))

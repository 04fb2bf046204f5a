"""The design space of a spec: scaled variables in [0, 1], and the designs they stand for."""

from __future__ import annotations

import pickle
from collections.abc import Mapping
from dataclasses import replace
from functools import cached_property, lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from orthospec.optimise.cache import Cache, cache_there
from orthospec.optimise.kept_forms import KeptForms
from orthospec.spec import Design, Spec
from orthospec.workspace.cuboid import Cuboid
from orthospec.workspace.evaluate import Setting
from orthospec.workspace.forms import Forms
from orthospec.workspace.machine import Machine

if TYPE_CHECKING:
    from orthospec.arrays import Array
    from orthospec.optimise.workers import Workers

REMEMBERED = 64
"""Designs kept: difference quotients and the rows of a goal ask for the same ones again."""


class DesignSpace:
    """Maps scaled designs z (k,) to designs; building one raises UnbuildableDesign where there is none.

    Only what varies continuously has a place in z: a catalogue is searched branch by branch.

    It is what every task is handed: a worker process unpacks the space of a spec once, and keeps it.
    """

    def __init__(
        self,
        spec: Spec,
        cache: Cache | None = None,
        helpers: Workers | None = None,
        forms: Forms | None = None,
    ) -> None:
        self.spec, self.setting = spec, setting_of(spec)
        self.cache = cache
        """Where fields are kept."""
        self.helpers = helpers
        """Who does parts of a task that is done in this process."""
        varying = {name: v for name, v in spec.variables.items() if not v.choices and v.min < v.max}
        self.names = tuple(varying)
        self.low = np.array([v.min for v in varying.values()], dtype=float)
        self.high = np.array([v.max for v in varying.values()], dtype=float)
        self.forms = forms or Forms(None if cache is None else KeptForms(cache, spec))
        """Compiled once, for all fits."""
        self._kept: DesignSpace | None = None
        self._remembered = lru_cache(REMEMBERED)(self._build)

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickled as its spec, which stands without any file, and its folder; helpers stay where they are."""
        return _unpacked, (self._packed, None if self.cache is None else self.cache.folder)

    @cached_property
    def _packed(self) -> bytes:
        return pickle.dumps(self.spec)

    def kept_in(self, cache: Cache) -> DesignSpace:
        """The same space, its fields and forms kept."""
        if self._kept is None or self._kept.cache is not cache:
            self._kept = DesignSpace(self.spec, cache, self.helpers)
        return self._kept

    def helped_by(self, helpers: Workers) -> DesignSpace:
        """The same space, for a task that shares out its parts."""
        return DesignSpace(self.spec, self.cache, helpers, self.forms)

    def within(self, low: Array, high: Array) -> DesignSpace:
        """The space of the same problem between two scaled designs, (k,) each, in or beyond this one."""
        ends = zip(self.names, *(self._plain(z) for z in (low, high)), strict=True)
        variables = {name: replace(self.spec.variables[name], min=a, max=b) for name, a, b in ends}
        spec = replace(self.spec, variables={**self.spec.variables, **variables})
        return DesignSpace(spec, self.cache, self.helpers, self.forms)

    def _plain(self, z: Array) -> list[float]:
        """The values of what varies, exact at both ends."""
        return [float(x) for x in np.where(z == 1.0, self.high, self.low + z * (self.high - self.low))]

    def values(self, z: Array) -> dict[str, float]:
        """All variables' values, exact at both ends of their ranges; a catalogue's is its start."""
        return self.spec.default_values() | dict(zip(self.names, self._plain(z), strict=True))

    def scaled(self, values: Mapping[str, float]) -> Array:
        """Z of these values."""
        x = np.array([values[name] for name in self.names], dtype=float)
        return np.asarray((x - self.low) / (self.high - self.low))

    def design(self, z: Array) -> Design:
        """The design at z."""
        return self._remembered(np.asarray(z, dtype=float).tobytes())

    def machine(self, z: Array) -> Machine:
        """The design at z as the workspace sees it."""
        return machine_of(self.design(z))

    def _build(self, key: bytes) -> Design:
        return self.spec.design(self.values(np.frombuffer(key)))


@lru_cache(maxsize=4)
def _unpacked(packed: bytes, folder: Path | None) -> DesignSpace:
    return DesignSpace(pickle.loads(packed), None if folder is None else cache_there(folder))


def machine_of(design: Design) -> Machine:
    """A design's manipulator and demands."""
    return Machine(design.manipulator, {demand.name: demand for demand in design.demands})


def setting_of(spec: Spec) -> Setting:
    """The spec's workspace."""
    asked = spec.workspace
    region = Cuboid(asked.region.min, asked.region.max) if asked.region is not None else None
    return Setting(np.array(asked.size), asked.divisions, region, asked.together, dict(spec.poses))

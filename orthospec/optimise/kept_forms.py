"""Compiled forms, kept for other runs: a run that finds all of its forms does without cvxpy's import."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import TYPE_CHECKING

from orthospec.composite.template import Template
from orthospec.optimise.cache import Cache, sha256_of
from orthospec.optimise.plain import decode, encode
from orthospec.optimise.versions import fingerprint

if TYPE_CHECKING:
    from orthospec.spec import Spec

_NUMBERS = frozenset({"at_least", "at_most", "levels"})
"""Keys of a measure that its forms do not depend on."""


class KeptForms:
    """The forms of a spec's measures, in a cache under a name that tells all that they depend on."""

    def __init__(self, cache: Cache, spec: Spec) -> None:
        self._cache, self._spec = cache, spec

    def __call__(
        self, measure: str, side: str, shape: tuple[int, ...], compiled: Callable[[], Template]
    ) -> Template:
        """The form of a side as it is kept, else compiled, and kept."""
        key = self._key(measure, side, shape)
        try:
            known = decode(self._cache.read(key), [Template])
        except ValueError:
            known = None
        if isinstance(known, Template):
            return known
        made = compiled()
        self._cache.write(key, encode(made))
        return made

    def _key(self, measure: str, side: str, shape: tuple[int, ...]) -> str:
        content = self._spec.canonical()
        own = {key: value for key, value in content["measures"][measure].items() if key not in _NUMBERS}
        parts = ["form", fingerprint(self._spec), content["manipulator"]["use"], own, side, list(shape)]
        return sha256_of(json.dumps(parts, ensure_ascii=False))

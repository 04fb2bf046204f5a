"""Compiled forms, kept for other runs: a run that finds all of its forms does without cvxpy's import."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import TYPE_CHECKING

from orthospec.composite.template import Template
from orthospec.optimise.cache import Cache, own_keys, sha256_of
from orthospec.optimise.versions import fingerprint

if TYPE_CHECKING:
    from orthospec.spec import Spec


class KeptForms:
    """The forms of a spec's measures, in a cache under a name that tells all that they depend on."""

    def __init__(self, cache: Cache, spec: Spec) -> None:
        self._cache, self._spec = cache, spec

    def __call__(
        self, measure: str, side: str, shape: tuple[int, ...], compiled: Callable[[], Template]
    ) -> Template:
        """The form of a side as it is kept, else compiled, and kept."""
        content = self._spec.canonical()
        own = own_keys(content["measures"][measure])
        parts = ["form", fingerprint(self._spec), content["manipulator"]["use"], own, side, list(shape)]
        return self._cache.kept(sha256_of(json.dumps(parts, ensure_ascii=False)), Template, compiled)

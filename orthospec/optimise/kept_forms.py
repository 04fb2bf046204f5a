"""Compiled forms, kept for other runs: a run that finds all of its forms does without cvxpy's import."""

from __future__ import annotations

import hashlib
import json
import marshal
from collections.abc import Callable
from types import FunctionType
from typing import TYPE_CHECKING, Any

from orthospec.composite.template import Template
from orthospec.optimise.cache import Cache, own_keys, sha256_of
from orthospec.optimise.versions import fingerprint

if TYPE_CHECKING:
    from orthospec.measures import ConvexForm
    from orthospec.spec import Spec

WITHOUT_REFERENCES = 2
"""Marshal's version whose bytes do not depend on who else has the same constants."""
_PLAIN = (bool, int, float, str, type(None))


class KeptForms:
    """The forms of a spec's measures, in a cache under a name that tells all that they depend on."""

    def __init__(self, cache: Cache, spec: Spec) -> None:
        self._cache, self._spec = cache, spec

    def __call__(
        self, measure: str, side: str, form: ConvexForm, compiled: Callable[[], Template]
    ) -> Template:
        """The form of a side as it is kept, else compiled, and kept.

        What ``holds`` states depends on its code alone where it has no data of its own, else on the keys of
        the measure and the machine too, which it may have got them from.
        """
        stated = code_of(form.holds) or self._keys_of(measure, side)
        parts = ["form", fingerprint(self._spec), stated, list(form.inside.shape[1:])]
        return self._cache.kept(sha256_of(json.dumps(parts, ensure_ascii=False)), Template, compiled)

    def _keys_of(self, measure: str, side: str) -> list[Any]:
        content = self._spec.canonical()
        return [content["manipulator"]["use"], own_keys(content["measures"][measure]), side]


def code_of(function: object) -> str | None:
    """A hash of a function's code and of the functions and plain values that it takes from around it.

    None where it takes anything else: a method, or what has defaults or an object in it.
    """
    if not isinstance(function, FunctionType) or function.__defaults__ or function.__kwdefaults__:
        return None
    total = hashlib.sha256(
        f"{function.__module__}\n".encode() + marshal.dumps(function.__code__, WITHOUT_REFERENCES)
    )
    for cell in function.__closure__ or ():
        inside = cell.cell_contents
        own = repr(inside) if type(inside) in _PLAIN else code_of(inside)
        if own is None:
            return None
        total.update(f"\n{own}".encode())
    return total.hexdigest()

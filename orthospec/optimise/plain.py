"""Plain data as JSON and back: frozen dataclasses, tuples, mappings, arrays, numbers, text.

What comes back is equal to what went in, to the last bit of a float, and nothing but data is ever made of a
file: only classes that the reader names, by their fields.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

_KIND = "is"
_ARRAY, _MAPPING = "array", "mapping"


def encode(value: Any) -> Any:
    """A value as JSON can write it; TypeError for what is no plain data."""
    if isinstance(value, np.generic):
        value = value.item()
    if value is None or isinstance(value, bool | int | float | str):
        return value
    if isinstance(value, tuple):
        return [encode(part) for part in value]
    if isinstance(value, Mapping):
        return {_KIND: _MAPPING, "items": [[encode(key), encode(part)] for key, part in value.items()]}
    if isinstance(value, np.ndarray):
        return {
            _KIND: _ARRAY,
            "type": value.dtype.str,
            "shape": list(value.shape),
            "all": value.ravel().tolist(),
        }
    if is_dataclass(value) and not isinstance(value, type):
        parts = {field.name: encode(getattr(value, field.name)) for field in fields(value)}
        return {_KIND: type(value).__name__, **parts}
    raise TypeError(f"{type(value).__name__} is no plain data")


def decode(content: Any, classes: Iterable[type]) -> Any:
    """The value; ValueError for content that `encode` does not write of these classes."""
    try:
        return _decode(content, {made_of.__name__: made_of for made_of in classes})
    except (KeyError, TypeError, AttributeError) as error:
        raise ValueError(f"not plain data of these classes: {error}") from None


def _decode(content: Any, classes: Mapping[str, type]) -> Any:
    if isinstance(content, list):
        return tuple(_decode(part, classes) for part in content)
    if not isinstance(content, dict):
        return content
    parts = dict(content)
    kind = parts.pop(_KIND)
    if kind == _ARRAY:
        return np.array(parts["all"], dtype=np.dtype(parts["type"])).reshape(parts["shape"])
    if kind == _MAPPING:
        return {_decode(key, classes): _decode(part, classes) for key, part in parts["items"]}
    return classes[kind](**{name: _decode(part, classes) for name, part in parts.items()})

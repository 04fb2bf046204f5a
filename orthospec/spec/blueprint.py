"""A plugin's class with its keys as the spec gives them: built anew for each set of the variables' values."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from pydantic import BaseModel, ValidationError

from orthospec.errors import RAISED, PluginFault
from orthospec.spec.document import Path
from orthospec.spec.wording import Problem, problems

Built = TypeVar("Built", bound=BaseModel)


class Refused(Exception):
    """The class's validators refuse these keys at these values."""

    def __init__(self, found: list[Problem]) -> None:
        """Keep the problems, each at its path within the plugin's keys."""
        self.problems = found
        super().__init__(
            "; ".join(f"{'.'.join(map(str, one.path))}: {one.message}".removeprefix(": ") for one in found)
        )


@dataclass(frozen=True)
class Blueprint(Generic[Built]):
    """What `use` names, and the keys beside it."""

    use: str
    made_of: type[Built]
    keys: Mapping[str, Any]
    path: Path
    place: str
    """``FILE:LINE:COLUMN``, for messages."""

    def build(self, values: Mapping[str, float]) -> Built:
        """The machine or measure at these values of the variables; raises `Refused` or `PluginFault`."""
        try:
            return self.made_of.model_validate(self.keys, context={"variables": values})
        except ValidationError as error:
            raise Refused(problems(error, self.keys, self.made_of, values)) from None
        except RAISED as error:
            raise PluginFault(self.use, f"{type(error).__name__}: {error}", self.place) from error


def booleans_as_numbers(keys: Any, built: Any, path: Path = ()) -> list[Path]:
    """Where true or false was given and a number was made of it: pydantic takes true for 1."""
    if isinstance(keys, bool):
        return [path] if isinstance(built, int | float) and not isinstance(built, bool) else []
    if isinstance(keys, Mapping) and isinstance(built, Mapping):
        steps: Any = [(key, inner, built.get(key)) for key, inner in keys.items()]
    elif isinstance(keys, list) and isinstance(built, list | tuple) and len(keys) == len(built):
        steps = [(i, inner, made) for i, (inner, made) in enumerate(zip(keys, built, strict=True))]
    else:
        return []
    return [found for key, inner, made in steps for found in booleans_as_numbers(inner, made, (*path, key))]

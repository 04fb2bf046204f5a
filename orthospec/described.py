"""Models whose keys are described by the docstrings below them, which are read when they are asked for.

pydantic's own ``use_attribute_docstrings`` reads the source of a class as the class is made, which is a
quarter of what `orthospec check` takes.
"""

from __future__ import annotations

import ast
import inspect
import sys
from collections.abc import Iterator, Mapping
from functools import lru_cache
from itertools import pairwise
from types import MappingProxyType
from typing import TYPE_CHECKING

from pydantic import BaseModel, ConfigDict, GetJsonSchemaHandler

if TYPE_CHECKING:
    from pydantic.json_schema import JsonSchemaValue
    from pydantic_core import CoreSchema


class Described(BaseModel):
    """A model whose JSON Schema has the fields' docstrings in it; pydantic builds it at its first use."""

    model_config = ConfigDict(defer_build=True)

    @classmethod
    def __get_pydantic_json_schema__(
        cls, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        """The model's, with its fields described."""
        found = handler(schema)
        properties = handler.resolve_ref_schema(found)["properties"]
        for key, name in names_by_key(cls).items():
            if (text := description(cls, name)) and key in properties:
                properties[key]["description"] = text
        return found


def names_by_key(made_of: type[BaseModel]) -> dict[str, str]:
    """The fields of a model by the keys that stand for them in a file."""
    return {field.alias or name: name for name, field in made_of.model_fields.items()}


def description(made_of: type[BaseModel], name: str) -> str | None:
    """What a field of a model says of itself: its description, else its docstring; None where it has none."""
    told = made_of.model_fields[name].description
    owners = (base for base in made_of.__mro__ if name in inspect.get_annotations(base))
    return told or next((text for owner in owners if (text := _docstrings(owner).get(name))), None)


def _docstrings(made_of: type) -> Mapping[str, str]:
    """The docstrings below the names of a class; none where its source is not at hand."""
    try:
        source = inspect.getsource(sys.modules[made_of.__module__])
        return _docstrings_in(source).get(made_of.__qualname__, {})
    except (KeyError, OSError, TypeError, SyntaxError):
        return {}


@lru_cache
def _docstrings_in(source: str) -> Mapping[str, Mapping[str, str]]:
    """Those of each class of a module; by its source, for a module may be loaded anew."""
    return MappingProxyType(dict(_classes(ast.parse(source), "")))


def _classes(tree: ast.AST, prefix: str) -> Iterator[tuple[str, Mapping[str, str]]]:
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.ClassDef):
            yield f"{prefix}{node.name}", dict(_described(node))
            yield from _classes(node, f"{prefix}{node.name}.")
        elif isinstance(node, ast.FunctionDef):
            yield from _classes(node, f"{prefix}{node.name}.<locals>.")
        else:
            yield from _classes(node, prefix)


def _described(made_of: ast.ClassDef) -> Iterator[tuple[str, str]]:
    for field, below in pairwise(made_of.body):
        match field, below:
            case (
                ast.AnnAssign(target=ast.Name(id=name)),
                ast.Expr(value=ast.Constant(value=str(text))),
            ):
                yield name, inspect.cleandoc(text)

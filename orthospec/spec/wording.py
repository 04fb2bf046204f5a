"""pydantic's errors in the words of the spec's author: where, what is wrong, what was expected."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Iterable, Mapping
from typing import Any, NamedTuple, get_args, get_origin

from pydantic import BaseModel, ValidationError

from orthospec.described import description, names_by_key
from orthospec.quantities.fields import resolve, shown
from orthospec.spec.document import Path


class Problem(NamedTuple):
    """One thing wrong with a part of a document, at a path within that part."""

    path: Path
    message: str
    at_key: bool = False
    kind: str = ""
    """pydantic's name for it."""


_COMPARISONS = frozenset({"greater_than", "greater_than_equal", "less_than", "less_than_equal"})
ABOUT_VALUES = _COMPARISONS | {"value_error", "assertion_error"}
"""The kinds of problem that other values of the variables may not have."""


def problems(
    error: ValidationError, data: Any, model: type[BaseModel], variables: Mapping[str, float] | None = None
) -> list[Problem]:
    """Each error once, at the path that the author wrote; alternatives that all failed are one problem."""
    found: dict[Path, list[Problem]] = {}
    for one in error.errors(include_url=False):
        problem = _problem(one, _written(one["loc"], data, one["type"]), data, model)
        if problem.kind in _COMPARISONS:
            computed = _computed(_at(data, problem.path), variables or {})
            problem = problem._replace(message=problem.message + computed)
        here = found.setdefault(problem.path, [])
        if problem.message not in (other.message for other in here):
            here.append(problem)
    merged = [problem for several in found.values() for problem in _merged(several)]
    return [problem for problem in merged if not _is_other_alternative(problem, merged)]


def did_you_mean(name: object, known: Iterable[str]) -> str:
    """The end of a sentence about an unknown name: the closest known one, or all of them."""
    if str(name)[:1].isdigit():  # The rest of 1,000 mm or 600,5 mm.
        return "; a comma ends an entry: write 1000, and 600.5"
    known = list(known)
    close = difflib.get_close_matches(str(name), known, n=1)
    if close:
        return f"; did you mean '{close[0]}'?"
    return f"; known here: {', '.join(known)}" if known else ""


def _merged(several: list[Problem]) -> list[Problem]:
    """The alternatives of a union failed at one place; missing keys of one mapping stay apart."""
    apart = [problem for problem in several if problem.kind == "missing"]
    rest = [problem for problem in several if problem.kind != "missing"]
    if rest:
        apart.append(rest[0]._replace(message="; or ".join(problem.message for problem in rest)))
    return apart


def _is_other_alternative(problem: Problem, others: list[Problem]) -> bool:
    """Of a union's alternatives, the one that fits so far that its parts could be looked at is meant."""
    depth = len(problem.path)
    below = (other for other in others if len(other.path) > depth and other.path[:depth] == problem.path)
    return problem.kind != "missing" and any(below)


def _written(location: tuple[str | int, ...], data: Any, kind: str) -> Path:
    """The location without the tags of unions, which no document has."""
    path: Path = ()
    for step in location:
        if isinstance(data, Mapping) and step in data:
            path, data = (*path, step), data[step]
        elif isinstance(data, list) and isinstance(step, int):
            path, data = (*path, step), data[step] if step < len(data) else None
    missing = kind == "missing" and isinstance(data, Mapping)
    return (*path, location[-1]) if missing else path


def _problem(one: Any, path: Path, data: Any, model: type[BaseModel]) -> Problem:
    kind, context = one["type"], one.get("ctx") or {}
    if kind == "missing":
        return _missing(path, data, model)
    if kind == "extra_forbidden":
        message = f"unknown key '{path[-1]}'{did_you_mean(path[-1], known_keys(model, path[:-1]))}"
        return Problem(path, message, at_key=True, kind=kind)
    if kind in ("value_error", "assertion_error"):
        return Problem(path, str(context["error"]), kind=kind)
    say = _SAYINGS.get(kind)
    if say is None:
        return Problem(
            path, f"{one['msg'][:1].lower()}{one['msg'][1:]}, {shown(one['input'])} given", kind=kind
        )
    given = f", {context['actual_length']} given" if kind in ("too_short", "too_long") else ""
    if kind not in _COMPARISONS:
        given = given or f", {shown(one['input'])} given"
    return Problem(path, say(context) + given, kind=kind)


def _missing(path: Path, data: Any, model: type[BaseModel]) -> Problem:
    if isinstance(path[-1], int):
        return _too_few(path, data, model)
    name = str(path[-1])
    owner = _model(model, path[:-1])
    names = names_by_key(owner) if owner else {}
    told = description(owner, names[name]) if owner and name in names else None
    about = f": {told.splitlines()[0].rstrip('.')}" if told else ""
    return Problem(path[:-1], f"'{name}' is missing{about}", at_key=True, kind="missing")


def _too_few(path: Path, data: Any, model: type[BaseModel]) -> Problem:
    parent = path[:-1]
    field = _field(model, parent)
    wanted = _tuple_length(field.annotation) if field else 0
    given = len(_at(data, parent))
    return Problem(parent, f"{wanted} values were expected, {given} given", kind="missing")


def _computed(raw: Any, variables: Mapping[str, float]) -> str:
    """What was given where a number is out of bounds; of an expression or quantity also its value."""
    try:
        value = resolve(raw, None, variables)
    except ValueError:
        return f", {shown(raw)} given"
    return f", '{raw}' is {value:g}" if isinstance(raw, str) else f", {value:g} given"


def _values(count: int) -> str:
    return f"{count} value{'s' if count > 1 else ''}"


def _in_yaml(expected: str) -> str:
    return {"True": "true", "False": "false"}.get(expected, expected)


_SAYINGS: dict[str, Callable[[Mapping[str, Any]], str]] = {
    "greater_than": lambda c: f"more than {c['gt']:g} was expected",
    "greater_than_equal": lambda c: f"{c['ge']:g} or more was expected",
    "less_than": lambda c: f"less than {c['lt']:g} was expected",
    "less_than_equal": lambda c: f"{c['le']:g} or less was expected",
    "too_short": lambda c: f"{_values(c['min_length'])} or more were expected",
    "too_long": lambda c: f"{_values(c['max_length'])} were expected at most",
    "literal_error": lambda c: f"{_in_yaml(c['expected'])} was expected",
    **dict.fromkeys(("int_type", "int_parsing", "int_from_float"), lambda _: "a whole number was expected"),
    **dict.fromkeys(("float_type", "float_parsing", "finite_number"), lambda _: "a number was expected"),
    **dict.fromkeys(("bool_type", "bool_parsing"), lambda _: "true or false was expected"),
    **dict.fromkeys(("string_type",), lambda _: "a text was expected"),
    **dict.fromkeys(("list_type", "tuple_type"), lambda _: "a list [ ... ] was expected"),
    **dict.fromkeys(("dict_type", "model_type", "model_attributes_type"), lambda _: "a mapping was expected"),
}  # fmt: skip


def known_keys(model: type[BaseModel], path: Path) -> list[str]:
    """The keys that a model knows at a path."""
    here = _model(model, path)
    return list(names_by_key(here)) if here else []


def _model(model: type[BaseModel], path: Path) -> type[BaseModel] | None:
    if not path:
        return model
    field = _field(model, path)
    return _inner_model(field.annotation) if field else None


def _field(model: type[BaseModel], path: Path) -> Any:
    """The field at a path through nested models; None where there is none."""
    here: type[BaseModel] | None = model
    field = None
    for step in path:
        if isinstance(step, int) or here is None:
            continue
        names = names_by_key(here)
        if step in names:
            field = here.model_fields[names[step]]
            here = _inner_model(field.annotation)
        elif field is None:
            return None
    return field


def _tuple_length(annotation: Any) -> int:
    arguments = get_args(annotation)
    if get_origin(annotation) is tuple:
        return len(arguments)
    return max((_tuple_length(argument) for argument in arguments), default=0)


def _inner_model(annotation: Any) -> type[BaseModel] | None:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    inner = (_inner_model(argument) for argument in get_args(annotation))
    return next((model for model in inner if model is not None), None)


def _at(data: Any, path: Path) -> Any:
    for step in path:
        try:
            data = data[step]
        except (KeyError, IndexError, TypeError):
            return None
    return data

"""Expressions over the design variables: numbers, names, ``+ - * / **``, parentheses and a few functions.

>>> Expression("max(base, third) / 2").value({"base": 1.0, "third": 3.0})
1.5

The text is parsed to a syntax tree of which only the listed nodes are let through, and computed with floats.
Nothing else can run, and nothing can run for long.
"""

from __future__ import annotations

import ast
import difflib
import math
import operator
import re
from collections.abc import Callable, Iterable, Mapping
from functools import lru_cache
from typing import Any, Final, NamedTuple, TypeAlias

from orthospec.errors import OrthospecError


class ExpressionError(OrthospecError, ValueError):
    """An expression that cannot be read, or that has no value where it is asked for one."""

    exit_code = 2


class Extreme(NamedTuple):
    """``worst(transmission)``: a goal's call of a measure by its name."""

    kind: str
    measure: str


Names: TypeAlias = Mapping[str, float]
Extremes: TypeAlias = Mapping[tuple[str, str], float]
_Node: TypeAlias = Callable[[Names, Extremes], float]

_FUNCTIONS: Final[dict[str, tuple[Callable[..., float], int, int]]] = {
    "sqrt": (math.sqrt, 1, 1),
    "sin": (math.sin, 1, 1),
    "cos": (math.cos, 1, 1),
    "exp": (math.exp, 1, 1),
    "log": (math.log, 1, 1),
    "min": (min, 2, 50),
    "max": (max, 2, 50),
}
_OPERATORS: Final[dict[type[ast.operator], Callable[[float, float], float]]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: math.pow,
}
WORDS: Final = frozenset({*_FUNCTIONS, "pi"})
"""The words of the language, which no variable may have as its name."""
GOAL_CALLS: Final = frozenset({"lowest", "highest", "worst"})
"""The calls that goals know beside them; their argument is a measure's name."""

_LONGEST, _DEEPEST = 1000, 100
_TOKEN = re.compile(r"\s+|(?P<number>(?>(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?))|[^\W\d]\w*|\*\*|[-+*/(),]")
_NO_VALUE = {
    ZeroDivisionError: "division by zero",
    OverflowError: "the result is too large",
    ValueError: "a root, logarithm or power that does not exist",
}


class Expression:
    """One parsed expression; ``calls`` are the calls on measures that are known where it stands."""

    __slots__ = ("_calls", "_node", "extremes", "names", "text")

    def __init__(self, text: str, calls: Iterable[str] = frozenset()) -> None:
        """Read the text, or raise `ExpressionError`."""
        builder = _Builder(frozenset(calls))
        tree = _parse(text)
        self._node = builder.build(tree, 0)
        self._calls = builder.calls
        self.text: Final = ast.unparse(tree)
        """The expression as a normal form writes it."""
        self.names: Final = frozenset(builder.names)
        """The names that it needs a value for."""
        self.extremes: Final = frozenset(builder.extremes)
        """The extremes of measures that it needs a value for."""

    def value(self, names: Names, extremes: Extremes | None = None) -> float:
        """The value, always finite; `ExpressionError` where there is none."""
        try:
            value = self._node(names, extremes or {})
        except KeyError as unknown:
            raise ExpressionError(unknown_name(unknown.args[0], names)) from None
        except (ZeroDivisionError, OverflowError, ValueError) as error:
            raise self._without_value(_NO_VALUE[type(error)], names) from None
        if not math.isfinite(value):
            raise self._without_value(_NO_VALUE[OverflowError], names)
        return value

    def _without_value(self, reason: str, names: Names) -> ExpressionError:
        at = ", ".join(f"{name} = {names[name]:.6g}" for name in sorted(self.names))
        return ExpressionError(f"'{self.text}' has no value{' at ' + at if at else ''}: {reason}")

    def __repr__(self) -> str:
        """The call that makes it."""
        return f"Expression({self.text!r})"

    def __eq__(self, other: object) -> bool:
        """Equal in normal form."""
        return isinstance(other, Expression) and other.text == self.text and other._calls == self._calls

    def __hash__(self) -> int:
        """By normal form."""
        return hash((self.text, self._calls))

    def __reduce__(self) -> tuple[type[Expression], tuple[str, frozenset[str]]]:
        """Read again in the other process: functions cannot be pickled."""
        return Expression, (self.text, self._calls)


@lru_cache(maxsize=4096)
def expression(text: str) -> Expression:
    """`Expression` over names alone, parsed once for each text."""
    return Expression(text)


def unknown_name(name: str, known: Iterable[str]) -> str:
    """The sentence about a name that is not among the known ones."""
    known = sorted(known)
    close = difflib.get_close_matches(name, known, n=1)
    if close:
        return f"unknown name '{name}'; did you mean '{close[0]}'?"
    return f"unknown name '{name}'; " + (
        f"known here: {', '.join(known)}" if known else "no names are known here"
    )


def _parse(text: str) -> ast.expr:
    if len(text) > _LONGEST:
        raise ExpressionError(f"an expression of {len(text)} characters; at most {_LONGEST} are read")
    _check_tokens(text)
    try:
        return ast.parse(" ".join(text.split()), mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        raise ExpressionError(f"'{text}' is not an expression: {_why_not(text)}") from None


def _check_tokens(text: str) -> None:
    position = 0
    while position < len(text):
        token = _TOKEN.match(text, position)
        if token is None:
            hint = "; a power is written **" if text[position] == "^" else ""
            raise ExpressionError(
                f"'{text}' is not an expression: '{text[position]}' has no meaning here{hint}"
            )
        position = token.end()
        if token["number"] and text[position : position + 1].isidentifier():
            raise ExpressionError(
                f"'{text}' is not an expression: write * after {token['number']} for a product"
            )


def _why_not(text: str) -> str:
    if not text.strip():
        return "it is empty"
    if text.count("(") != text.count(")"):
        return "a parenthesis is not closed" if text.count("(") > text.count(")") else "a ')' has no '('"
    return "an operator or a value is missing"


class _Builder:
    """Turns a syntax tree into nested functions, noting the names on the way."""

    def __init__(self, calls: frozenset[str]) -> None:
        self.calls = calls
        self.names: set[str] = set()
        self.extremes: set[Extreme] = set()

    def build(self, tree: ast.expr, depth: int) -> _Node:
        if depth > _DEEPEST:
            raise ExpressionError(f"the expression is nested more than {_DEEPEST} deep")
        match tree:
            case ast.Constant(value=int() | float() as number) if not isinstance(number, bool):
                return self._constant(number)
            case ast.Name(id="pi"):
                return self._constant(math.pi)
            case ast.Name(id=name):
                self.names.add(name)
                return lambda names, _: names[name]
            case ast.UnaryOp(op=ast.USub(), operand=inner):
                negated = self.build(inner, depth + 1)
                return lambda names, extremes: -negated(names, extremes)
            case ast.UnaryOp(op=ast.UAdd(), operand=inner):
                return self.build(inner, depth + 1)
            case ast.BinOp(op=op) if type(op) in _OPERATORS:
                return self._binary(tree, _OPERATORS[type(op)], depth)
            case ast.Call(func=ast.Name(id=name), keywords=[]):
                return self._call(name, tree.args, depth)
        raise ExpressionError(
            f"'{ast.unparse(tree)}' is not allowed: an expression has numbers, names, + - * / **, "
            f"parentheses and {', '.join(sorted(WORDS))}"
        )

    def _constant(self, number: float) -> _Node:
        try:
            value = float(number)
        except OverflowError:
            value = math.inf
        if not math.isfinite(value):
            raise ExpressionError("a number in the expression is too large")
        return lambda _, __: value

    def _binary(self, tree: ast.BinOp, apply: Callable[[float, float], float], depth: int) -> _Node:
        left, right = self.build(tree.left, depth + 1), self.build(tree.right, depth + 1)
        return lambda names, extremes: apply(left(names, extremes), right(names, extremes))

    def _call(self, name: str, args: list[ast.expr], depth: int) -> _Node:
        if name in self.calls:
            return self._extreme(name, args)
        if name in GOAL_CALLS:
            raise ExpressionError(f"{name}() can stand in a goal only")
        if name not in _FUNCTIONS:
            raise ExpressionError(
                unknown_name(name, {*_FUNCTIONS, *self.calls}).replace("name", "function", 1)
            )
        function, least, most = _FUNCTIONS[name]
        if not least <= len(args) <= most:
            wanted = "one value" if most == 1 else "two values or more"
            raise ExpressionError(f"{name}() takes {wanted}, {len(args)} given")
        inner: list[Any] = [self.build(arg, depth + 1) for arg in args]
        return lambda names, extremes: function(*[node(names, extremes) for node in inner])

    def _extreme(self, name: str, args: list[ast.expr]) -> _Node:
        match args:
            case [ast.Name(id=measure)]:
                key = Extreme(name, measure)
                self.extremes.add(key)
                return lambda _, extremes: extremes[key]
        raise ExpressionError(f"{name}() takes the name of one measure, like {name}(transmission)")

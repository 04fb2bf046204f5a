"""The smooth pieces of an expression with ``max`` and ``min`` in it.

``a + max(b, c)`` is the greatest of ``a + b`` and ``a + c``: a solver that is given both sees no kink where
they are equal. A ``max`` counts where the expression rises with it, a ``min`` where it falls, through sums,
differences, constant factors and rising functions; elsewhere it stays as it is.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from functools import lru_cache
from itertools import product
from typing import Final, Literal, TypeAlias

from orthospec.quantities.expressions import GOAL_CALLS, Expression

Split: TypeAlias = Literal["max", "min"]

MOST: Final = 64
"""Most pieces; what would make more of them stays whole."""
_OTHER: Final[dict[str, Split]] = {"max": "min", "min": "max"}
_RISING: Final = frozenset({"sqrt", "exp", "log"})


@lru_cache(maxsize=256)
def pieces(expression: Expression, split: Split) -> tuple[Expression, ...]:
    """Expressions of which this goal's expression is the greatest ("max") or the least ("min").

    >>> [piece.text for piece in pieces(Expression("2 * max(a, b) - min(c, d)"), "max")]
    ['2 * a - c', '2 * a - d', '2 * b - c', '2 * b - d']
    """
    found = list(_split(ast.parse(expression.text, mode="eval").body, split))
    if len(found) == 1:
        return (expression,)
    return tuple(Expression(ast.unparse(tree), GOAL_CALLS) for tree in found)


def _split(tree: ast.expr, split: Split) -> Iterator[ast.expr]:
    match tree:
        case ast.Call(func=ast.Name(id=name), args=args) if name == split:
            for arg in args:
                yield from _split(arg, split)
        case ast.Call(func=ast.Name(id=name), args=[arg]) if name in _RISING:
            for inner in _split(arg, split):
                yield ast.Call(tree.func, [inner], [])
        case ast.UnaryOp(op=ast.USub(), operand=arg):
            for inner in _split(arg, _OTHER[split]):
                yield ast.UnaryOp(tree.op, inner)
        case ast.BinOp(op=ast.Add() | ast.Sub()):
            right = split if isinstance(tree.op, ast.Add) else _OTHER[split]
            yield from _pairs(tree, list(_split(tree.left, split)), list(_split(tree.right, right)))
        case ast.BinOp(op=ast.Mult(), left=factor) if (sign := _sign(factor)) is not None:
            yield from _pairs(tree, [factor], list(_split(tree.right, split if sign else _OTHER[split])))
        case ast.BinOp(op=ast.Mult() | ast.Div(), right=factor) if (sign := _sign(factor)) is not None:
            yield from _pairs(tree, list(_split(tree.left, split if sign else _OTHER[split])), [factor])
        case _:
            yield tree


def _pairs(tree: ast.BinOp, left: list[ast.expr], right: list[ast.expr]) -> Iterator[ast.expr]:
    if len(left) * len(right) > MOST:
        yield tree
        return
    for a, b in product(left, right):
        yield ast.BinOp(a, tree.op, b)


def _sign(tree: ast.expr) -> bool | None:
    """Whether a constant is positive; None where the tree is no constant."""
    match tree:
        case ast.Constant(value=int() | float() as number):
            return number >= 0
        case ast.UnaryOp(op=ast.USub(), operand=ast.Constant(value=int() | float() as number)):
            return number < 0
    return None

"""Arithmetic of pairs lo <= hi of arrays, rounded outward.

Each operation of IEEE 754 is off by half a unit in the last place at most, and its result is moved by one to
two units. Functions of the mathematical library are taken to be off by `LIBRARY` such units at most.

An end may be infinite. Both are NaN where the quantity may be undefined somewhere in the box (a root of what
may be negative, 0/0): NaN spreads, and no bound is proved from it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from orthospec.intervals.rounding import LIBRARY, TINIEST, ULP

if TYPE_CHECKING:
    from orthospec.arrays import Array, Flags

    Ends: TypeAlias = tuple[Array, Array]

NEAR = 1e-14
"""A turning point of sin this near, in turns and relative, is taken to lie inside."""


def outward(lo: Array, hi: Array, ulps: float = 1.0) -> Ends:
    """Moved apart by at least so many units in the last place each."""
    step = ulps * ULP
    return lo - (np.abs(lo) * step + TINIEST), hi + (np.abs(hi) * step + TINIEST)


def straddles(x: Ends) -> Flags:
    """Whether 0 may be in it."""
    return np.asarray(~((x[0] > 0) | (x[1] < 0)))


def add(x: Ends, y: Ends) -> Ends:
    """x + y."""
    return outward(x[0] + y[0], x[1] + y[1])


def subtract(x: Ends, y: Ends) -> Ends:
    """x − y."""
    return outward(x[0] - y[1], x[1] - y[0])


def negative(x: Ends) -> Ends:
    """−x, exact."""
    return -x[1], -x[0]


def multiply(x: Ends, y: Ends) -> Ends:
    """x y."""
    if x[0] is x[1]:
        x, y = y, x
    if y[0] is y[1]:
        return outward(*_least_and_greatest(x[0] * y[0], x[1] * y[0]))
    low = _least_and_greatest(x[0] * y[0], x[0] * y[1])
    high = _least_and_greatest(x[1] * y[0], x[1] * y[1])
    return outward(np.minimum(low[0], high[0]), np.maximum(low[1], high[1]))


def divide(x: Ends, y: Ends) -> Ends:
    """x / y: anything where y may be 0, undefined where both may be."""
    low = _least_and_greatest(x[0] / y[0], x[0] / y[1])
    high = _least_and_greatest(x[1] / y[0], x[1] / y[1])
    lo, hi = outward(np.minimum(low[0], high[0]), np.maximum(low[1], high[1]))
    zero = straddles(y)
    if zero.any():
        undefined = straddles(x) | np.isnan(y[0])
        lo = np.where(zero, np.where(undefined, np.nan, -np.inf), lo)
        hi = np.where(zero, np.where(undefined, np.nan, np.inf), hi)
    return lo, hi


def minimum(x: Ends, y: Ends) -> Ends:
    """min(x, y), exact."""
    return np.minimum(x[0], y[0]), np.minimum(x[1], y[1])


def maximum(x: Ends, y: Ends) -> Ends:
    """max(x, y), exact."""
    return np.maximum(x[0], y[0]), np.maximum(x[1], y[1])


def absolute(x: Ends) -> Ends:
    """|x|, exact."""
    least, greatest = _least_and_greatest(np.abs(x[0]), np.abs(x[1]))
    return np.where((x[0] < 0) & (x[1] > 0), 0.0, least), greatest


def square(x: Ends) -> Ends:
    """x², not negative."""
    least, greatest = absolute(x)
    return _not_negative(outward(least * least, greatest * greatest))


def sqrt(x: Ends) -> Ends:
    """√x, undefined where x may be negative."""
    lo, hi = _not_negative(outward(np.sqrt(x[0]), np.sqrt(x[1])))
    return _undefined(lo, hi, ~(x[0] >= 0))


def power(x: Ends, exponent: float) -> Ends:
    """x to a constant power: any x for a whole power, x >= 0 for others."""
    if exponent == 0:
        return np.ones_like(x[0]), np.ones_like(x[1])
    if exponent < 0:
        one = np.ones(())
        return divide((one, one), power(x, -exponent))
    whole = float(exponent).is_integer()
    base = absolute(x) if whole and exponent % 2 == 0 else x
    lo, hi = outward(np.power(base[0], exponent), np.power(base[1], exponent), LIBRARY)
    if whole and exponent % 2 == 1:
        return lo, hi
    lo, hi = _not_negative((lo, hi))
    return (lo, hi) if whole else _undefined(lo, hi, ~(x[0] >= 0))


def exp(x: Ends) -> Ends:
    """The exponential."""
    return _not_negative(outward(np.exp(x[0]), np.exp(x[1]), LIBRARY))


def log(x: Ends) -> Ends:
    """The natural logarithm, undefined where x may be negative."""
    lo, hi = outward(np.log(x[0]), np.log(x[1]), LIBRARY)
    return _undefined(lo, hi, ~(x[0] >= 0))


def arctan(x: Ends) -> Ends:
    """The inverse tangent."""
    return outward(np.arctan(x[0]), np.arctan(x[1]), LIBRARY)


def arcsin(x: Ends) -> Ends:
    """The inverse sine, undefined where x may be outside of −1 to 1."""
    lo, hi = outward(np.arcsin(x[0]), np.arcsin(x[1]), LIBRARY)
    return _undefined(lo, hi, ~((x[0] >= -1) & (x[1] <= 1)))


def arccos(x: Ends) -> Ends:
    """The inverse cosine, undefined where x may be outside of −1 to 1."""
    lo, hi = _not_negative(outward(np.arccos(x[1]), np.arccos(x[0]), LIBRARY))
    return _undefined(lo, hi, ~((x[0] >= -1) & (x[1] <= 1)))


def sinh(x: Ends) -> Ends:
    """The hyperbolic sine."""
    return outward(np.sinh(x[0]), np.sinh(x[1]), LIBRARY)


def cosh(x: Ends) -> Ends:
    """The hyperbolic cosine."""
    least, greatest = absolute(x)
    lo, hi = outward(np.cosh(least), np.cosh(greatest), LIBRARY)
    return np.maximum(lo, 1.0), hi


def tanh(x: Ends) -> Ends:
    """The hyperbolic tangent."""
    lo, hi = outward(np.tanh(x[0]), np.tanh(x[1]), LIBRARY)
    return np.maximum(lo, -1.0), np.minimum(hi, 1.0)


def sin(x: Ends) -> Ends:
    """The sine."""
    return _wave(np.sin, x, 0.25)


def cos(x: Ends) -> Ends:
    """The cosine."""
    return _wave(np.cos, x, 0.0)


def total(x: Ends, axis: int | tuple[int, ...] | None, keepdims: bool = False) -> Ends:
    """The sum, in whatever order it is taken: n terms are off by n units of Σ|x| at most."""
    sums = [end.sum(axis=axis, keepdims=keepdims) for end in x]
    sizes = [np.abs(end).sum(axis=axis, keepdims=keepdims) for end in x]
    terms = max(1, x[0].size // max(1, sums[0].size))
    lo, hi = sums[0] - terms * ULP * sizes[0], sums[1] + terms * ULP * sizes[1]
    lo, hi = outward(lo, hi)
    return np.where((x[0] >= 0).all(axis=axis, keepdims=keepdims), np.maximum(lo, 0.0), lo), hi


def hull(x: Ends, y: Ends) -> Ends:
    """The least interval around both."""
    return np.minimum(x[0], y[0]), np.maximum(x[1], y[1])


def _wave(wave: Callable[[Array], Array], x: Ends, crest: float) -> Ends:
    """sin or cos, with a crest at so many turns and a trough half a turn on."""
    turns = [end / (2 * np.pi) for end in x]
    margin = NEAR * (1 + np.maximum(np.abs(turns[0]), np.abs(turns[1])))

    def passes(at: float) -> Flags:
        first = np.ceil(turns[0] - at - margin)
        return np.asarray(~(first > turns[1] - at + margin))

    lo, hi = outward(*_least_and_greatest(wave(x[0]), wave(x[1])), LIBRARY)
    lo = np.where(passes(crest + 0.5), -1.0, np.maximum(lo, -1.0))
    hi = np.where(passes(crest), 1.0, np.minimum(hi, 1.0))
    return _undefined(lo, hi, ~(np.isfinite(x[0]) & np.isfinite(x[1])))


def _least_and_greatest(a: Array, b: Array) -> Ends:
    return np.minimum(a, b), np.maximum(a, b)


def _not_negative(x: Ends) -> Ends:
    return np.maximum(x[0], 0.0), x[1]


def _undefined(lo: Array, hi: Array, where: Flags) -> Ends:
    if not where.any():
        return lo, hi
    return np.where(where, np.nan, lo), np.where(where, np.nan, hi)

"""NumPy's elementwise functions on intervals, each on the ends and on the mean-value forms."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from orthospec.intervals import ends, functions, fused, linear
from orthospec.intervals.interval import PLAIN, Interval, Undecided, as_interval
from orthospec.intervals.linear import Linear
from orthospec.intervals.refusal import check_plain, refuse
from orthospec.intervals.rounding import ULP

if TYPE_CHECKING:
    from orthospec.intervals.ends import Ends


def call_ufunc(ufunc: np.ufunc, method: str, inputs: tuple[Any, ...], kwargs: dict[str, Any]) -> Any:
    """What a ufunc, or its reduction, comes to."""
    out = kwargs.pop("out", None)
    table: Mapping[np.ufunc, Callable[..., Any]] = _TABLE if method == "__call__" else functions.REDUCTIONS
    plain = kwargs.get("where", True) is True and "initial" not in kwargs
    if ufunc not in table or method not in {"__call__", "reduce"} or not plain:
        raise refuse(f"np.{ufunc.__name__}" + ("" if method == "__call__" else f".{method}"), PLAIN)
    check_plain(kwargs.get("dtype"))
    kwargs = {key: kwargs[key] for key in ("axis", "keepdims") if key in kwargs}
    if method == "reduce":
        kwargs.setdefault("axis", 0)
    with np.errstate(all="ignore"):
        found = table[ufunc](*inputs, **kwargs)
    if out is None or isinstance(out[0], Undecided):
        return found
    if not isinstance(out[0], Interval):
        raise refuse("an array of numbers, changed in place,", "write a = a + b in place of a += b")
    out[0][...] = found
    return out[0]


def add(x: Any, y: Any) -> Interval:
    """x + y."""
    return fused.add(as_interval(x), as_interval(y))


def subtract(x: Any, y: Any) -> Interval:
    """x − y."""
    return add(x, negative(y))


def negative(x: Any) -> Interval:
    """−x."""
    a = as_interval(x)
    if a.is_exact:
        return as_interval(-a.lo)
    return Interval(*ends.negative(a.ends), a.form and linear.negative(a.form))


def multiply(x: Any, y: Any) -> Interval:
    """The product entry by entry."""
    if x is y:
        return square(x)
    return fused.multiply(as_interval(x), as_interval(y))


def divide(x: Any, y: Any) -> Interval:
    """x / y."""
    a, b = as_interval(x), as_interval(y)
    form = None
    if d := fused.coordinates(a, b):
        form = fused.multiply(a, _reciprocal(b, d)).form_over(d)
        if b.is_exact:  # 1/b was rounded.
            form = form._replace(r=form.r + (np.abs(form.c) + form.spread) * ULP)
    return _joined(ends.divide(a.ends, b.ends), form)


def maximum(x: Any, y: Any) -> Interval:
    """The greater."""
    a, b = as_interval(x), as_interval(y)
    return functions.chosen(a.lo >= b.hi, b.lo >= a.hi, a, b, ends.maximum(a.ends, b.ends))


def minimum(x: Any, y: Any) -> Interval:
    """The less."""
    a, b = as_interval(x), as_interval(y)
    return functions.chosen(a.hi <= b.lo, b.hi <= a.lo, a, b, ends.minimum(a.ends, b.ends))


def absolute(x: Interval) -> Interval:
    """The magnitude."""
    return functions.chosen(x.lo >= 0, x.hi <= 0, x, negative(x), ends.absolute(x.ends))


def square(x: Interval) -> Interval:
    """x²."""
    return _smooth(ends.square, lambda c: c * c, lambda c: 2 * c, lambda _: (1.0, 1.0))(x)


def power(x: Any, exponent: Any) -> Interval:
    """x to a power that is one number."""
    if isinstance(exponent, Interval) or np.ndim(exponent) > 0:
        raise refuse("a power", "take one number as the exponent, or np.exp(exponent * np.log(base))")
    p = float(exponent)
    if p in (1.0, 2.0):
        return x * 1.0 if p == 1 else square(x)
    return _smooth(
        lambda x: ends.power(x, p),
        lambda c: np.power(c, p),
        lambda c: p * np.power(c, p - 1),
        lambda h: ends.multiply(ends.power(h, p - 2), _constant(p * (p - 1) / 2)),
    )(x)


def hypot(x: Any, y: Any) -> Any:
    """The length of (x, y)."""
    return np.sqrt(np.square(x) + np.square(y))


def tan(x: Interval) -> Any:
    """The tangent."""
    return np.sin(x) / np.cos(x)


def arctan2(y: Any, x: Any) -> Interval:
    """The angle of (x, y), −π to π: any where y may have both signs at an x that is not positive."""
    a, b = as_interval(y), as_interval(x)
    right, beside = np.arctan(a / b), np.arctan(b / a)
    half_turn = np.where(np.isnan(a.lo + b.lo), np.nan, np.nextafter(np.pi, 4.0))
    cases = ((b.lo > 0, right), (a.lo > 0, _QUARTER - beside), (a.hi < 0, -_QUARTER - beside))
    return functions.first_of(cases, (-half_turn, half_turn))


def sign(x: Interval) -> Interval:
    """−1, 0 or 1."""
    return Interval(np.sign(x.lo), np.sign(x.hi))


def _smooth(
    on_ends: Callable[[Ends], Ends],
    value: Callable[[Any], Any],
    slope: Callable[[Any], Any],
    bend: Callable[[Ends], Any],
) -> Callable[[Interval], Interval]:
    """A function with its derivative, and with the range of half its second derivative."""

    def apply(x: Interval) -> Interval:
        found = on_ends(x.ends)
        form = x.form
        if form is None:
            return Interval(*found)
        around = np.minimum(x.lo, form.c), np.maximum(x.hi, form.c)
        bends = bend(around)
        return _joined(found, linear.taylor(form, x.ends, value(form.c), slope(form.c), bends))

    return apply


def _reciprocal(x: Interval, d: int) -> Interval:
    """1/x, rounded where x are numbers."""
    if x.is_exact:
        return as_interval(1.0 / x.lo)
    form = x.form_over(d)
    around = np.minimum(x.lo, form.c), np.maximum(x.hi, form.c)
    c = form.c
    bend = ends.divide(_constant(1.0), ends.power(around, 3))
    inverse = linear.taylor(form, x.ends, 1.0 / c, -1.0 / (c * c), bend)
    return Interval(*ends.divide(_constant(1.0), x.ends), inverse)


def _constant(value: float) -> Ends:
    one = np.asarray(value)
    return one, one


def _joined(found: Ends, form: Linear | None) -> Interval:
    return Interval(*found, form).narrowed()


def _comparison(surely: Callable[..., Any], surely_not: Callable[..., Any]) -> Callable[..., Undecided]:
    def compare(x: Any, y: Any) -> Undecided:
        a, b = as_interval(x), as_interval(y)
        return Undecided(np.asarray(surely(a, b)), np.asarray(~surely_not(a, b)))

    return compare


def _kind(surely: Callable[[Interval], Any], surely_not: Callable[[Interval], Any]) -> Callable[..., Any]:
    return lambda x: Undecided(np.asarray(surely(x)), np.asarray(~surely_not(x)))


def _logic(on: Callable[..., Any]) -> Callable[..., Undecided]:
    def apply(*truths: Any) -> Undecided:
        parts = [t if isinstance(t, Undecided) else Undecided(np.asarray(t), np.asarray(t)) for t in truths]
        return Undecided(on(*(p.surely for p in parts)), on(*(p.possibly for p in parts)))

    return apply


def _invert(x: Undecided) -> Undecided:
    return Undecided(~x.possibly, ~x.surely)


def _unknown(x: Interval) -> Any:
    return np.zeros(x.shape, dtype=bool)


_QUARTER = Interval(np.asarray(np.pi / 2), np.asarray(np.nextafter(np.pi / 2, 2.0)))
_LESS = (lambda a, b: a.hi < b.lo, lambda a, b: a.lo >= b.hi)
_LESS_EQUAL = (lambda a, b: a.hi <= b.lo, lambda a, b: a.lo > b.hi)


def _apart(a: Interval, b: Interval) -> Any:
    return (a.hi < b.lo) | (a.lo > b.hi)


def _same(a: Interval, b: Interval) -> Any:
    return (a.lo == b.hi) & (a.hi == b.lo)


_TABLE: Mapping[np.ufunc, Callable[..., Any]] = {
    np.add: add,
    np.subtract: subtract,
    np.multiply: multiply,
    np.divide: divide,
    np.negative: negative,
    np.positive: lambda x: x.copy(),
    np.conjugate: lambda x: x.copy(),
    np.absolute: absolute,
    np.fabs: absolute,
    np.square: square,
    np.power: power,
    np.float_power: power,
    np.reciprocal: lambda x: divide(1.0, x),
    np.maximum: maximum,
    np.minimum: minimum,
    np.hypot: hypot,
    np.sign: sign,
    np.tan: tan,
    np.deg2rad: lambda x: multiply(x, np.pi / 180),
    np.matmul: functions.matmul,
    np.sqrt: _smooth(
        ends.sqrt,
        np.sqrt,
        lambda c: 0.5 / np.sqrt(c),
        lambda h: (-0.125 / (h[0] * np.sqrt(h[0])), np.zeros_like(h[0])),
    ),
    np.exp: _smooth(ends.exp, np.exp, np.exp, lambda h: (np.zeros_like(h[1]), 0.5 * np.exp(h[1]))),
    np.log: _smooth(ends.log, np.log, lambda c: 1 / c, lambda h: (-0.5 / (h[0] * h[0]), np.zeros_like(h[0]))),
    np.sin: _smooth(ends.sin, np.sin, np.cos, lambda h: ends.multiply(ends.sin(h), _constant(-0.5))),
    np.cos: _smooth(
        ends.cos, np.cos, lambda c: -np.sin(c), lambda h: ends.multiply(ends.cos(h), _constant(-0.5))
    ),
    np.arctan: _smooth(
        ends.arctan, np.arctan, lambda c: 1 / (1 + c * c), lambda h: (np.full_like(h[0], -0.325), 0.325)
    ),
    np.arctan2: arctan2,
    np.arcsin: _smooth(
        ends.arcsin,
        np.arcsin,
        lambda c: 1 / np.sqrt((1 - c) * (1 + c)),
        lambda h: tuple(end / (2 * np.power((1 - end) * (1 + end), 1.5)) for end in h),
    ),
    np.arccos: _smooth(
        ends.arccos,
        np.arccos,
        lambda c: -1 / np.sqrt((1 - c) * (1 + c)),
        lambda h: tuple(-end / (2 * np.power((1 - end) * (1 + end), 1.5)) for end in h[::-1]),
    ),
    np.sinh: _smooth(ends.sinh, np.sinh, np.cosh, lambda h: (0.5 * np.sinh(h[0]), 0.5 * np.sinh(h[1]))),
    np.cosh: _smooth(ends.cosh, np.cosh, np.sinh, lambda h: ends.multiply(ends.cosh(h), _constant(0.5))),
    np.tanh: _smooth(
        ends.tanh,
        np.tanh,
        lambda c: 1 - np.tanh(c) ** 2,
        lambda h: (np.full_like(h[0], -0.385), np.full_like(h[1], 0.385)),
    ),
    np.less: _comparison(*_LESS),
    np.less_equal: _comparison(*_LESS_EQUAL),
    np.greater: lambda x, y: _comparison(*_LESS)(y, x),
    np.greater_equal: lambda x, y: _comparison(*_LESS_EQUAL)(y, x),
    np.equal: _comparison(_same, _apart),
    np.not_equal: _comparison(_apart, _same),
    np.isfinite: _kind(
        lambda x: np.isfinite(x.lo) & np.isfinite(x.hi), lambda x: (x.lo == np.inf) | (x.hi == -np.inf)
    ),
    np.isinf: _kind(
        lambda x: (x.lo == np.inf) | (x.hi == -np.inf), lambda x: np.isfinite(x.lo) & np.isfinite(x.hi)
    ),
    np.isnan: _kind(_unknown, lambda x: ~np.isnan(x.lo)),
    np.bitwise_and: _logic(np.logical_and),
    np.bitwise_or: _logic(np.logical_or),
    np.logical_and: _logic(np.logical_and),
    np.logical_or: _logic(np.logical_or),
    np.invert: _invert,
    np.logical_not: _invert,
}

"""NumPy's functions of whole arrays on intervals: sums and products of arrays, and choices."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from orthospec.intervals import ends, fused, linear, rearranging
from orthospec.intervals.interval import PLAIN, Interval, Undecided, as_interval
from orthospec.intervals.linear import Linear
from orthospec.intervals.refusal import check_plain, refuse
from orthospec.intervals.rounding import ULP

if TYPE_CHECKING:
    from orthospec.arrays import Array
    from orthospec.intervals.ends import Ends


def call_function(func: Callable[..., Any], args: tuple[Any, ...], kwargs: dict[str, Any]) -> Any:
    """What a function of NumPy comes to."""
    from orthospec.intervals import linalg

    found = _TABLE.get(func) or linalg.TABLE.get(func)
    name = f"np.{'linalg.' if 'linalg' in func.__module__ else ''}{func.__name__}"
    if found is None:
        raise refuse(name, PLAIN)
    with np.errstate(all="ignore"):
        try:
            return found(*args, **kwargs)
        except TypeError as error:  # Arguments that it does not know: never passed over in silence.
            raise refuse(f"{name} with these arguments", PLAIN) from error


# Sums and products.


def total(x: Any, axis: Any = None, dtype: Any = None, out: Any = None, keepdims: bool = False) -> Interval:
    """The sum along axes."""
    check_plain(dtype, out)
    axes = tuple(range(x.ndim)) if axis is None else tuple(int(a) % x.ndim for a in np.atleast_1d(axis))
    found = ends.total(x.ends, axes, keepdims)
    if x.form is None:
        return Interval(*found)
    terms = int(np.prod([x.shape[a] for a in axes]))
    form = linear.linear(x.form, lambda part: part.sum(axis=axes, keepdims=keepdims), terms)
    return Interval(*found, form).narrowed()


def _mean(x: Interval, axis: Any = None, dtype: Any = None, out: Any = None, keepdims: bool = False) -> Any:
    sums = total(x, axis, dtype, out, keepdims)
    return sums / (x.size / max(1, sums.size))


def _prod(x: Interval, axis: Any = None, dtype: Any = None, out: Any = None, keepdims: bool = False) -> Any:
    check_plain(dtype, out)
    if axis is None:
        x, axis = x.reshape(-1), 0
    found: Any = np.ones(())
    for part in rearranging.moveaxis(x, axis, 0):
        found = found * part
    return np.expand_dims(found, axis) if keepdims else found


def matmul(a: Any, b: Any) -> Any:
    """The matrix product, of one axis or more each."""
    left, right = "...ij", "...jk"
    if np.ndim(a) == 1:
        left = "j"
    if np.ndim(b) == 1:
        right = "j"
    out = "..." * (left != "j" or right != "j") + "i" * (left != "j") + "k" * (right != "j")
    return einsum(f"{left},{right}->{out}", a, b)


def einsum(subscripts: Any, *operands: Any, out: Any = None, optimize: Any = None) -> Interval:  # noqa: ARG001
    """Sums of products of one or two arrays, in NumPy's notation."""
    check_plain(None, out)
    if not isinstance(subscripts, str) or len(operands) > 2:
        raise refuse("np.einsum of more than two arrays", "take them two at a time")
    inputs, arrow, result = subscripts.replace(" ", "").partition("->")
    if not arrow:
        letters = inputs.replace(",", "").replace("...", "")
        result = "..." * ("..." in inputs) + "".join(sorted(s for s in set(letters) if letters.count(s) == 1))
    names = inputs.split(",")
    if len(operands) == 1:
        return _sum_over(names[0], result, as_interval(operands[0]))
    if operands[0] is operands[1] and names[0] == names[1]:
        squares: Any = np.square(operands[0])
        return _sum_over(names[0], result, squares)
    return fused.contract(names[0], names[1], result, as_interval(operands[0]), as_interval(operands[1]))


def _sum_over(name: str, out: str, x: Interval) -> Interval:
    sizes = _sizes((name, x))
    terms = int(np.prod([sizes[s] for s in set(name) & set(sizes) if s not in out]))
    found: list[Array] = [np.einsum(f"{name}->{out}", end) for end in x.ends]
    errors = [np.einsum(f"{name}->{out}", np.abs(end)) * (terms * ULP) for end in x.ends]
    lo, hi = ends.outward(found[0] - errors[0], found[1] + errors[1])
    if bool((x.lo >= 0).all()):
        lo = np.maximum(lo, 0.0)
    form = x.form
    if form is not None:
        form = linear.linear(form, lambda part: _einsum_tail(name, out, part, x.ndim), terms)
    sums = Interval(lo, hi, form).narrowed()
    if terms == 1:  # NumPy gives a view.
        sums.make_read_only()
    return sums


def _einsum_tail(name: str, out: str, part: Array, own: int) -> Array:
    tail = "Z" * (part.ndim - own)
    return np.asarray(np.einsum(f"{name}{tail}->{out}{tail}", part))


def _sizes(*named: tuple[str, Interval]) -> dict[str, int]:
    """Lengths of the named axes; what is left out by ... is not summed over."""
    sizes: dict[str, int] = {}
    for name, x in named:
        before, _, after = name.partition("...")
        sizes.update(zip(before, x.shape, strict=False))
        sizes.update(zip(after[::-1], x.shape[::-1], strict=False))
    return sizes


def _trace(x: Interval, offset: int = 0, axis1: int = 0, axis2: int = 1) -> Any:
    return total(rearranging.diagonal(x, offset, axis1, axis2), axis=-1)


def _cross(a: Any, b: Any, *, axis: int = -1) -> Any:
    x, y = (rearranging.moveaxis(as_interval(v), axis, 0) for v in (a, b))
    parts = [x[i] * y[j] - x[j] * y[i] for i, j in ((1, 2), (2, 0), (0, 1))]
    return np.stack(parts, axis=axis)


def _dot(a: Any, b: Any) -> Any:
    if np.ndim(a) == 0 or np.ndim(b) == 0:
        return a * b
    if np.ndim(a) > 2 or np.ndim(b) > 2:
        raise refuse("np.dot of stacked matrices", "write a @ b")
    return matmul(a, b)


def _outer(a: Any, b: Any) -> Any:
    if np.ndim(a) != 1 or np.ndim(b) != 1:
        raise refuse("np.outer of stacked vectors", "write a[..., :, None] * b[..., None, :]")
    return einsum("i,j->ij", a, b)


# Choices.


def chosen(first: Any, second: Any, a: Interval, b: Interval, otherwise: Ends) -> Interval:
    """a where ``first`` holds, b where ``second`` does, elsewhere an interval."""
    d = fused.coordinates(a, b)
    form = None
    if d:
        other = linear.flat(otherwise, d)
        parts = [a.form_over(d), b.form_over(d), other]
        shape = other.c.shape
        first, second = np.broadcast_to(first, shape), np.broadcast_to(second, shape)
        c, r = (np.where(first, x, np.where(second, y, z)) for x, y, z in
                ((p[0] for p in parts), (p[2] for p in parts)))  # fmt: skip
        g = np.where(first[..., None], parts[0].g, np.where(second[..., None], parts[1].g, other.g))
        form = Linear(c, g, r)
    return Interval(*otherwise, form).narrowed()


def first_of(cases: Sequence[tuple[Any, Interval]], otherwise: Ends) -> Interval:
    """Of each entry the first of several that is sure, each with where it is; elsewhere an interval."""
    found = Interval(*otherwise)
    for sure, x in reversed(cases):
        lo, hi = (np.where(sure, own, other) for own, other in zip(x.ends, found.ends, strict=True))
        found = chosen(sure, ~sure, x, found, (lo, hi))
    return found


def _where(condition: Any, x: Any, y: Any) -> Interval:
    a, b = as_interval(x), as_interval(y)
    if not isinstance(condition, Undecided):
        condition = Undecided(np.asarray(condition, dtype=bool), np.asarray(condition, dtype=bool))
    first, second = condition.surely, ~condition.possibly
    around = ends.hull(a.ends, b.ends)
    picked = [
        np.where(first, p, np.where(second, q, either))
        for p, q, either in zip(a.ends, b.ends, around, strict=True)
    ]
    return chosen(first, second, a, b, (picked[0], picked[1]))


def _clip(x: Any, a_min: Any = None, a_max: Any = None, *, min: Any = None, max: Any = None) -> Any:
    least, most = (a_min if min is None else min), (a_max if max is None else max)
    found = x if least is None else np.maximum(x, least)
    return found if most is None else np.minimum(found, most)


def _extreme(reduce: Callable[..., Any], of_two: Callable[..., Any]) -> Callable[..., Interval]:
    def apply(x: Interval, axis: Any = None, out: Any = None, keepdims: bool = False) -> Interval:
        check_plain(None, out)
        if x.form is not None and isinstance(axis, int) and not keepdims:
            first: Any
            first, *others = rearranging.moveaxis(x, axis, 0)
            for other in others:
                first = of_two(first, other)
            return as_interval(first)
        lo, hi = (np.asarray(reduce(end, axis=axis, keepdims=keepdims)) for end in x.ends)
        return Interval(lo, hi)

    return apply


def _like(make: Callable[..., Any]) -> Callable[..., Any]:
    def apply(x: Any, *args: Any, **kwargs: Any) -> Any:
        if not isinstance(x, Interval):
            return make(np.zeros(x.shape), *args, **kwargs)
        number = make(x.lo, *args, **kwargs)
        check_plain(number.dtype)
        return Interval(number, number.copy())

    return apply


def _truths(name: str) -> Callable[..., Any]:
    return lambda x, axis=None, **kwargs: getattr(x, name)(axis=axis, **kwargs)


REDUCTIONS: Mapping[np.ufunc, Callable[..., Any]] = {
    np.add: total,
    np.multiply: _prod,
    np.maximum: _extreme(np.max, np.maximum),
    np.minimum: _extreme(np.min, np.minimum),
    np.logical_and: _truths("all"),
    np.logical_or: _truths("any"),
}

_TABLE: Mapping[Callable[..., Any], Callable[..., Any]] = {
    **rearranging.TABLE,
    np.sum: total,
    np.mean: _mean,
    np.prod: _prod,
    np.einsum: einsum,
    np.dot: _dot,
    np.outer: _outer,
    np.cross: _cross,
    np.trace: _trace,
    np.where: _where,
    np.clip: _clip,
    np.max: _extreme(np.max, np.maximum),
    np.min: _extreme(np.min, np.minimum),
    np.amax: _extreme(np.max, np.maximum),
    np.amin: _extreme(np.min, np.minimum),
    np.all: _truths("all"),
    np.any: _truths("any"),
    np.zeros_like: _like(np.zeros_like),
    np.ones_like: _like(np.ones_like),
    np.full_like: _like(np.full_like),
    np.empty_like: _like(np.zeros_like),
    np.shape: lambda x: x.shape,
    np.ndim: lambda x: x.ndim,
    np.size: lambda x: x.size,
}

"""NumPy's functions that only rearrange the entries of intervals.

Most are asked to rearrange the entries' numbers, and the entries follow.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from orthospec.intervals.interval import Interval, as_interval
from orthospec.intervals.linear import Linear
from orthospec.intervals.refusal import check_plain, refuse

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from orthospec.arrays import Array


def rearranged(arrays: Sequence[Interval], arrange: Callable[[list[NDArray[np.intp]]], Any]) -> Interval:
    """The entries of the arrays, where ``arrange`` puts their numbers; −1 stands for 0."""
    starts = np.cumsum([0, *(a.size for a in arrays)])
    numbers = [np.arange(s, s + a.size).reshape(a.shape) for s, a in zip(starts, arrays, strict=False)]
    where = arrange(numbers)
    d = max(a.coordinates for a in arrays)

    def gathered(parts: Sequence[Array], tail: tuple[int, ...]) -> Array:
        flat = [part.reshape(-1, *tail) for part in parts] + [np.zeros((1, *tail))]
        return np.asarray(np.concatenate(flat)[where])

    form = None
    if d:
        forms = [a.form_over(d) for a in arrays]
        form = Linear(
            gathered([f.c for f in forms], ()),
            gathered([f.g for f in forms], (d,)),
            gathered([f.r for f in forms], ()),
        )
    return Interval(gathered([a.lo for a in arrays], ()), gathered([a.hi for a in arrays], ()), form)


def _one(func: Callable[..., Any]) -> Callable[..., Any]:
    """NumPy gives views for many of these, and to write to one changes its array: here it is refused."""

    def apply(x: Interval, *args: Any, **kwargs: Any) -> Interval:
        found = rearranged([x], lambda numbers: func(numbers[0], *args, **kwargs))
        if func in _VIEWING:
            found.make_read_only()
        return found

    return apply


def _many(func: Callable[..., Any]) -> Callable[..., Any]:
    def apply(arrays: Any, *args: Any, dtype: Any = None, out: Any = None, **kwargs: Any) -> Interval:
        check_plain(dtype, out)
        parts = [as_interval(a) for a in arrays]
        return rearranged(parts, lambda numbers: func(numbers, *args, **kwargs))

    return apply


def _pad(x: Interval, pad_width: Any, mode: str = "constant") -> Interval:
    if mode != "constant":
        raise refuse(f"np.pad with mode={mode!r}", "put the parts together with np.concatenate")
    return rearranged([x], lambda numbers: np.pad(numbers[0], pad_width, constant_values=-1))


def _on_parts(x: Interval, on: Callable[[Array, int], Array]) -> Interval:
    """``on`` moves the axes of an array that has so many axes of its own, or one more at the end."""
    n, form = x.ndim, x.form
    if form is not None:
        form = Linear(on(form.c, n), on(form.g, n), on(form.r, n))
    return Interval(on(x.lo, n), on(x.hi, n), form)


def swapaxes(x: Interval, axis1: int, axis2: int) -> Interval:
    """Two axes exchanged, as views."""
    return _on_parts(x, lambda part, n: np.swapaxes(part, axis1 % n, axis2 % n))


def moveaxis(x: Interval, source: Any, destination: Any) -> Interval:
    """Axes moved elsewhere, as views."""

    def on(part: Array, n: int) -> Array:
        return np.moveaxis(
            part, *(tuple(int(i) % n for i in np.atleast_1d(s)) for s in (source, destination))
        )

    return _on_parts(x, on)


def _transpose(x: Interval, axes: Any = None) -> Interval:
    order = tuple(range(x.ndim))[::-1] if axes is None else tuple(int(a) % x.ndim for a in axes)
    return _on_parts(x, lambda part, n: np.transpose(part, (*order, *range(n, part.ndim))))


def diagonal(x: Interval, offset: int = 0, axis1: int = 0, axis2: int = 1) -> Interval:
    """The diagonal of two axes, as the last axis."""
    found = rearranged([x], lambda numbers: np.diagonal(numbers[0], offset, axis1, axis2))
    found.make_read_only()
    return found


_REARRANGING = (
    np.reshape, np.ravel, np.squeeze, np.expand_dims, np.broadcast_to, np.roll, np.flip, np.repeat, np.tile,
    np.take, np.rot90,
)  # fmt: skip
_VIEWING = (np.reshape, np.ravel, np.squeeze, np.expand_dims, np.broadcast_to, np.flip, np.rot90)
_JOINING = (np.stack, np.concatenate, np.hstack, np.vstack, np.column_stack, np.dstack)

TABLE: Mapping[Callable[..., Any], Callable[..., Any]] = {
    **{func: _one(func) for func in _REARRANGING},
    **{func: _many(func) for func in _JOINING},
    np.pad: _pad,
    np.swapaxes: swapaxes,
    np.moveaxis: moveaxis,
    np.transpose: _transpose,
    np.diagonal: diagonal,
    np.copy: lambda x: x.copy(),
}

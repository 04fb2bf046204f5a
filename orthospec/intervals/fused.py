"""Sums and products of intervals in C, ends and mean-value forms in one pass; `twin` is the plain NumPy."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from orthospec.intervals.interval import Interval, known_of, of_rows
from orthospec.kernels.intervals import add_intervals, contract_intervals, multiply_intervals

if TYPE_CHECKING:
    from collections.abc import Mapping


def add(a: Interval, b: Interval) -> Interval:
    """a + b."""
    if a.is_exact:
        a, b = b, a
    d = coordinates(a, b)
    return of_rows(add_intervals(known_of(a), known_of(b), _shape(a, b), d))


def multiply(a: Interval, b: Interval) -> Interval:
    """a b, entry by entry."""
    d = coordinates(a, b)
    return of_rows(multiply_intervals(known_of(a), known_of(b), _shape(a, b), d))


def contract(left: str, right: str, out: str, a: Interval, b: Interval) -> Interval:
    """Sums of products in the notation of `numpy.einsum`: ``left,right->out``."""
    a_axes, b_axes, axes = _numbered(left, right, out, a.ndim, b.ndim)
    extents = [1] * axes
    for x, numbers in ((a, a_axes), (b, b_axes)):
        for extent, number in zip(x.shape, numbers, strict=True):
            if number < axes and extent != 1:
                extents[number] = extent
    rows = contract_intervals(known_of(a), a_axes, known_of(b), b_axes, tuple(extents), coordinates(a, b))
    return of_rows(rows)


def coordinates(a: Interval, b: Interval) -> int:
    """Of the box that the forms of both belong to; 0 where neither has one."""
    return a.coordinates or b.coordinates


def _shape(a: Interval, b: Interval) -> tuple[int, ...]:
    return a.shape if a.shape == b.shape else np.broadcast_shapes(a.shape, b.shape)


@lru_cache(maxsize=512)
def _numbered(left: str, right: str, out: str, a_ndim: int, b_ndim: int) -> tuple[bytes, bytes, int]:
    """Which axis of the result, or beyond, each axis of both runs over, and how many the result has."""
    spread = max(_spread(left, a_ndim), _spread(right, b_ndim))
    names = [_named(name, ndim, spread) for name, ndim in ((left, a_ndim), (right, b_ndim))]
    result = _named(out, len(out.replace("...", "")) + spread, spread)
    unknown = set(result) - {*names[0], *names[1]}
    if unknown or len(set(result)) < len(result) or (spread and "..." not in out):
        raise ValueError(f"einsum: {left},{right}->{out} names other axes in its result than in its arrays")
    numbers: Mapping[str, int] = {
        name: number for number, name in enumerate(dict.fromkeys((*result, *names[0], *names[1])))
    }
    a, b = (bytes(numbers[name] for name in each) for each in names)
    return a, b, len(result)


def _spread(name: str, ndim: int) -> int:
    """How many axes the dots stand for."""
    left = ndim - len(name.replace("...", ""))
    if left < 0 or (left and "..." not in name):
        raise ValueError(f"einsum: {name} does not fit an array of {ndim} axes")
    return left


def _named(name: str, ndim: int, spread: int) -> list[str]:
    """A name for each axis: its letter, or a number for those that dots stand for, counted from the last."""
    before, _, after = name.partition("...")
    dots = ndim - len(before) - len(after)
    return [*before, *map(str, range(spread - dots, spread)), *after]

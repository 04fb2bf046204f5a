"""The sums and products of `fused` in plain NumPy: what they compute, and the oracle of their tests."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from orthospec.intervals import ends, linear
from orthospec.intervals.interval import Interval
from orthospec.intervals.linear import Linear
from orthospec.intervals.rounding import SPARE, TINY, ULP

if TYPE_CHECKING:
    from orthospec.arrays import Array
    from orthospec.intervals.ends import Ends


class Bilinear(NamedTuple):
    """A product of arrays, linear in both: on values, and with the axis of u at the end of either or both."""

    plain: Callable[[Any, Any], Any]
    left: Callable[[Any, Any], Any]
    right: Callable[[Any, Any], Any]
    both: Callable[[Any, Any], Any]
    """With u summed over."""
    terms: int
    """Products that are added up for one entry."""


ENTRIES = Bilinear(
    plain=lambda a, b: a * b,
    left=lambda a, b: a * b[..., None],
    right=lambda a, b: a[..., None] * b,
    both=lambda a, b: (a * b).sum(axis=-1),
    terms=1,
)
"""The product entry by entry."""


def add(a: Interval, b: Interval) -> Interval:
    """a + b."""
    if a.is_exact:
        a, b = b, a
    d = a.coordinates or b.coordinates
    form = _sum(a.form_over(d), b.lo if b.is_exact else b.form_over(d)) if d else None
    return narrowed(ends.add(a.ends, b.ends), form)


def multiply(a: Interval, b: Interval) -> Interval:
    """a b, entry by entry."""
    d = a.coordinates or b.coordinates
    form = _product(ENTRIES, _factor(a, d), _factor(b, d)) if d else None
    return narrowed(ends.multiply(a.ends, b.ends), form)


def contract(left: str, right: str, out: str, a: Interval, b: Interval) -> Interval:
    """Sums of products in the notation of `numpy.einsum`: ``left,right->out``."""
    entries = np.einsum(f"{left},{right}->{out}", np.ones(a.shape), np.ones(b.shape))
    by = Bilinear(
        plain=lambda x, y: np.einsum(f"{left},{right}->{out}", x, y),
        left=lambda x, y: np.einsum(f"{left}Z,{right}->{out}Z", x, y),
        right=lambda x, y: np.einsum(f"{left},{right}Z->{out}Z", x, y),
        both=lambda x, y: np.einsum(f"{left}Z,{right}Z->{out}", x, y),
        terms=int(entries.max(initial=0)),
    )
    d = a.coordinates or b.coordinates
    form = _product(by, _factor(a, d), _factor(b, d)) if d else None
    return narrowed(_product(by, _factor(a, 0, balls=True), _factor(b, 0, balls=True)).ends, form)


def narrowed(around: Ends, form: Linear | None) -> Interval:
    """Ends where a form gives narrower ones; a form that knows nothing but them where it is not finite."""
    if form is None:
        return Interval(*around)
    lo, hi = form.ends
    lo, hi = np.where(lo > around[0], lo, around[0]), np.where(hi < around[1], hi, around[1])
    known, other = linear.is_known(form), linear.flat((lo, hi), form.g.shape[-1])
    c, r = np.where(known, form.c, other.c), np.where(known, form.r, other.r)
    return Interval(lo, hi, Linear(c, np.where(known[..., None], form.g, other.g), r))


def _factor(x: Interval, d: int, balls: bool = False) -> Linear:
    """A factor's form: of numbers one without slopes and rest, of a ball one without slopes."""
    if x.is_exact:
        return Linear(x.lo, np.zeros((*x.shape, d)), np.zeros(x.shape))
    return linear.flat(x.ends, 0) if balls else x.form_over(d)


def _sum(x: Linear, y: Linear | Array) -> Linear:
    if not isinstance(y, Linear):
        c = x.c + y
        g = np.broadcast_to(x.g, (*c.shape, x.g.shape[-1]))
        return Linear(c, g, np.broadcast_to(x.r, c.shape) * SPARE + (ULP * np.abs(c) + TINY))
    c, g = x.c + y.c, x.g + y.g
    return linear.rounded(c, g, x.r + y.r, np.abs(c) + np.abs(g).sum(axis=-1))


def _product(by: Bilinear, x: Linear, y: Linear) -> Linear:
    """x times y.

    Of Σ g_k u_k times Σ h_l u_l the terms of u_k² lie between 0 and g_k h_k: half of it goes into the middle.
    """
    left, right = np.abs(x.g), np.abs(y.g)
    spreads = x.spread, y.spread
    c = by.plain(x.c, y.c) + by.both(x.g, y.g) / 2
    g = by.left(x.g, y.c) + by.right(x.c, y.g)
    r = by.plain(np.abs(x.c), y.r) + by.plain(x.r, np.abs(y.c))
    r = r + (by.plain(*spreads) - by.both(left, right) / 2)
    size = by.plain(np.abs(x.c) + spreads[0], np.abs(y.c) + spreads[1])
    return linear.rounded(c, g, r, size, by.terms)

"""Mean-value forms: x(u) = c + Σ g_k u_k + e, |e| <= r, for all u in [−1, 1]^d.

u are the coordinates of a box, each from −1 at its one end to 1 at the other. What an operation bends, and
its rounding, go into r. On a box of half-width h they are of order h², so that an enclosure converges
quadratically where interval arithmetic alone, which forgets that two quantities depend on the same u,
converges linearly. These are Taylor models of first order (Makino and Berz 2003).

All three are doubles: c and r have the shape of the quantity, g one more axis of d at the end.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from orthospec.intervals import ends
from orthospec.intervals.rounding import FEW, SPARE, TINY, ULP

if TYPE_CHECKING:
    from orthospec.arrays import Array, Flags
    from orthospec.intervals.ends import Ends


class Linear(NamedTuple):
    """A mean-value form over the box that its quantity belongs to."""

    c: Array
    """The middle."""
    g: Array
    """How much it changes from the middle to the end of each coordinate."""
    r: Array
    """The rest."""

    @property
    def spread(self) -> Array:
        """A bound on |x − c|."""
        return np.asarray((np.abs(self.g).sum(axis=-1) + self.r) * SPARE)

    @property
    def ends(self) -> Ends:
        """The interval that it spans."""
        spread = self.spread
        return ends.outward(self.c - spread, self.c + spread)


def flat(x: Ends, d: int) -> Linear:
    """An interval as a form that knows nothing of u."""
    with np.errstate(all="ignore"):
        middle = (x[0] + x[1]) / 2
        radius = np.maximum(x[1] - middle, middle - x[0]) * SPARE + TINY
    return Linear(middle, np.zeros((*middle.shape, d)), radius)


def is_known(x: Linear) -> Flags:
    """Where the form says something."""
    return np.asarray(np.isfinite(x.r) & np.isfinite(x.c) & np.isfinite(x.g).all(axis=-1))


def negative(x: Linear) -> Linear:
    """−x."""
    return Linear(-x.c, -x.g, x.r.copy())


def taylor(x: Linear, within: Ends, value: Array, slope: Array, bend: Ends) -> Linear:
    """f(x) from f(c), f'(c) and the range of f''/2 over all of x and c; x lies ``within`` an interval."""
    spread = np.minimum(x.spread, np.maximum(within[1] - x.c, x.c - within[0]) * SPARE + TINY)
    # Not the square of the spread, which may underflow where the bend is large.
    lo, hi = (end * spread * spread * SPARE for end in (np.minimum(bend[0], 0.0), np.maximum(bend[1], 0.0)))
    size = np.abs(value) + np.abs(slope) * (spread + x.spread) + (hi - lo)
    rest = np.abs(slope) * x.r + (hi - lo) / 2
    return rounded(value + (lo + hi) / 2, slope[..., None] * x.g, rest, size)


def linear(x: Linear, on: Callable[[Array], Array], terms: int) -> Linear:
    """A sum of so many entries; ``on`` takes arrays with any axes after the quantity's own."""
    return rounded(np.array(on(x.c)), np.array(on(x.g)), on(x.r), on(_sizes(x)), terms)


def _sizes(x: Linear) -> Array:
    return np.asarray(np.abs(x.c) + np.abs(x.g).sum(axis=-1) + x.r)


def rounded(c: Array, g: Array, r: Array, size: Array, terms: int = 1) -> Linear:
    """A form with the rounding of sums of so many terms, and of a handful of operations, put into r."""
    d = g.shape[-1]
    return Linear(c, g, np.maximum(r, 0.0) * SPARE + ((terms + d) * ULP + FEW) * size + TINY)

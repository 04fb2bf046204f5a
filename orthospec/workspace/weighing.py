"""Several conditions over a box that cannot all hold, though each one does somewhere in it.

With f_j <= 0 where condition j holds and any weights w_j >= 0, at each point of a box at which all hold
Σ w_j f_j <= 0 too. So where the sum is above 0 in the whole box, none of its points meets them all. Near the
best point conditions hold each other in balance: their slopes cancel in the sum that has the multipliers of
the optimum as its weights (Karush, Kuhn and Tucker), and what is left of it changes by the square of the
box's size only. The weights are found in plain arithmetic; only the sum is rounded outward.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from orthospec.intervals import Interval, linear

if TYPE_CHECKING:
    from orthospec.arrays import Array, Flags
    from orthospec.intervals.linear import Linear

ROUNDS = 4
"""How often one condition more is weighed in: the best of all, as much of it as is best."""


def cannot_all_hold(conditions: Linear) -> Flags:
    """Whether in each box (n,) its conditions (n, k) exclude each other.

    They are given as mean-value forms over the box, <= 0 where they hold; NaN where nothing is known.
    """
    if not len(conditions.c):
        return np.zeros(0, dtype=bool)
    known = linear.is_known(conditions)
    c, g, r = (np.where(_wide(known, part), part, 0.0) for part in conditions)
    form = linear.Linear(c, g, r)
    weights = _weights(np.where(known, c - r, -np.inf), g)
    total: Any = np.sum(Interval(*form.ends, form) * weights, axis=1)
    return np.asarray(total.lo > 0)


def _weights(least: Array, slopes: Array) -> Array:
    """Weights (n, k) with which least − Σ|slopes| of the sum is great; ``least`` is −inf where not known.

    From the best condition alone steps are taken towards another one, to where a slope of the sum vanishes.
    """
    n, k, _ = slopes.shape
    each, none = np.arange(n), np.isneginf(least)
    alone = np.where(none, -np.inf, least - np.abs(slopes).sum(axis=2))
    least = np.where(none, 0.0, least)
    best = alone.argmax(axis=1)
    weights = np.zeros((n, k))
    weights[each, best] = 1.0
    level, slope, value = least[each, best], slopes[each, best], alone[each, best]
    for _ in range(ROUNDS):
        with np.errstate(divide="ignore", invalid="ignore"):
            step = slope[:, None, :] / (slope[:, None, :] - slopes)
        step = np.where((step > 0) & (step < 1) & ~none[:, :, None], step, 0.0)
        levels = level[:, None, None] + step * (least[:, :, None] - level[:, None, None])
        sums = slope[:, None, None, :] + step[..., None] * (slopes - slope[:, None, :])[:, :, None, :]
        values = (levels - np.abs(sums).sum(axis=3)).reshape(n, -1)
        taken = values.argmax(axis=1)
        better = values[each, taken] > value
        if not better.any():
            break
        other, axis = np.divmod(taken, slopes.shape[2])
        part = np.where(better, step[each, other, axis], 0.0)
        weights *= (1 - part)[:, None]
        weights[each, other] += part
        level = level + part * (least[each, other] - level)
        slope = slope + part[:, None] * (slopes[each, other] - slope)
        value = np.where(better, values[each, taken], value)
    return weights


def _wide(known: Flags, like: Array) -> Flags:
    return known if like.ndim == known.ndim else known[..., None]

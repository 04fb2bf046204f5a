"""Goal attainment for plain functions: what MATLAB's ``fgoalattain`` does, on the machines' solver.

    minimise λ    subject to    f_i(x) − w_i λ <= goal_i,    lower <= x <= upper

(Gembicki 1974; Pashkevich, Chablat and Wenger 2009, eqs. 12-13.) A weight of 0 makes a goal a hard bound.

>>> import numpy as np
>>> def objectives(x):
...     return [2 + (x[0] - 3) ** 2, 5 + x[0] ** 2 / 4]
>>> found = attain_goals(objectives, [0.5], goals=[3, 6], weights=[1, 1])
>>> bool(abs(found.x[0] - 2) < 1e-8 and abs(found.factor) < 1e-8)
True
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from orthospec.composite.subproblem import HalfLines, Rows, Step
from orthospec.composite.trust_region import Assessment, Solution, minimise

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from orthospec.arrays import Array


class _Goals:
    """`Problem` of plain functions; x is used as it comes."""

    def __init__(
        self,
        functions: Callable[[Array], ArrayLike],
        goals: Array,
        weights: Array,
        lower: Array,
        upper: Array,
    ) -> None:
        self.functions, self.goals, self.weights = functions, goals, weights
        self.lower, self.upper = lower, upper
        self.scale = np.ones(len(lower))
        self.has_factor = bool((weights > 0).any())

    def smooth(self, points: Array, rows: Rows) -> Array:  # noqa: ARG002
        return np.array([np.asarray(self.functions(x), dtype=float) - self.goals for x in points])

    def assess(self, x: Array) -> Assessment:
        gap = np.asarray(self.functions(x), dtype=float) - self.goals
        if not np.isfinite(gap).all():
            return Assessment(x, np.inf, np.inf)
        soft = self.weights > 0
        factor = float(np.max(gap[soft] / self.weights[soft])) if soft.any() else 0.0
        return Assessment(x, factor, float(np.max(gap[~soft], initial=0.0)))

    def rows(self, x: Array) -> Rows:  # noqa: ARG002
        return Rows((), HalfLines(0, self.weights, (self.weights == 0).astype(float)))

    def drift(self, x: Array, rows: Rows, step: Step) -> Array:  # noqa: ARG002
        return np.zeros((len(x), len(x)))


def attain_goals(
    functions: Callable[[Array], ArrayLike],
    start: ArrayLike,
    goals: ArrayLike,
    weights: ArrayLike,
    lower: ArrayLike | Sequence[float] = -np.inf,
    upper: ArrayLike | Sequence[float] = np.inf,
) -> Solution:
    """Attain goals on smooth functions from one start; `Solution.factor` is λ.

    What is found is a point from which no step of first order gains: started on a crest or a saddle it stays.

    functions(x) gives the k objective values at x (n,); goals and weights (k,), lower and upper (n,) or one
    number for all. Variables should be of order 1: the trust region is a box in x as it comes.

    Raises ValueError for a weight below 0, and where there are not as many goals as weights and values.
    """
    x = np.atleast_1d(np.asarray(start, dtype=float))
    box = [np.broadcast_to(np.asarray(side, dtype=float), x.shape).copy() for side in (lower, upper)]
    goals, weights = (np.atleast_1d(np.asarray(part, dtype=float)) for part in (goals, weights))
    values = np.shape(functions(np.clip(x, *box)))
    if not goals.shape == weights.shape == values:
        raise ValueError(f"{goals.size} goals, {weights.size} weights and values of shape {values}")
    if not (weights >= 0).all():
        raise ValueError("a weight is below 0: turn its sign, and those of its objective and goal")
    return minimise(_Goals(functions, goals, weights, *box), np.clip(x, *box))

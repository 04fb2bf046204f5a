"""The curvature of a subproblem: a convex stand-in for the Lagrangian's Hessian.

A subproblem must be convex, the Hessian need not be. Only along the rows that bind must its curvature be
true for fast convergence; across them it may be what it likes, since there the rows decide the step. So the
positive part is taken of each of the two blocks, and the rest left out (a reduced Hessian: Nocedal and
Wright, *Numerical Optimization*, 2006, section 18.7). The positive part of the whole would be too stiff along
the rows, and a loop with twice the true curvature halves its error with each step and no more. At a vertex,
where rows that hold leave no direction, none is needed.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from orthospec.composite.differences import positive_part

if TYPE_CHECKING:
    from orthospec.arrays import Array
    from orthospec.composite.subproblem import Rows, Step

BINDS = 1e-6
"""A row binds whose multiplier is more than this part of the greatest."""
ON_BOUND = 1e-9
"""A variable this near a bound is on it."""
RANK = 1e-9
"""Gradients that depend on each other but for this part are one."""


def binding_gradients(rows: Rows, slopes: Array, step: Step) -> Array:
    """Gradients (r, n + 1) in (x, factor) of the rows and of the copies of blocks that bind; unit length."""
    lines = rows.half_lines
    parts = [np.column_stack([slopes[lines.start : lines.stop], -lines.on_factor])]
    sizes = [step.multipliers[lines.start : lines.stop]]
    for block in rows.blocks:
        cut = slice(block.start, block.stop)
        weighed = step.multipliers[cut, None] * slopes[cut]
        sums = weighed.reshape(block.copies, block.width, -1).sum(axis=1)
        parts.append(np.column_stack([sums, np.zeros(block.copies)]))
        sizes.append(step.shares[len(lines.on_factor) + sum(map(len, sizes[1:])) :][: block.copies])
    size = np.abs(np.concatenate(sizes))
    gradients = np.concatenate(parts)[size > BINDS * size.max(initial=0.0)]
    lengths = np.linalg.norm(gradients, axis=1)
    return np.asarray(gradients[lengths > 0] / lengths[lengths > 0, None])


def bound_gradients(step: Step, x: Array, lower: Array, upper: Array) -> Array:
    """The same (r, n + 1) of the variables that a bound of theirs holds."""
    pressed = step.on_bounds > BINDS * max(1.0, float(np.abs(step.on_bounds).max(initial=0.0)))
    held = (pressed[:, 0] & (x - lower < ON_BOUND)) | (pressed[:, 1] & (upper - x < ON_BOUND))
    return np.eye(len(x), len(x) + 1)[held]


def directions(gradients: Array) -> tuple[Array, Array]:
    """Orthonormal directions of x along rows (n, c), by their gradients (r, n + 1), and across (n, n − c)."""
    n = gradients.shape[1] - 1
    _, sizes, both = np.linalg.svd(np.vstack([gradients, np.zeros((n + 1, n + 1))]))
    free = both[sizes <= RANK, :n]
    every, sizes, _ = np.linalg.svd(free.T, full_matrices=True)
    count = int((sizes > RANK).sum())
    return every[:, :count], every[:, count:]


def convex_part(hessian: Array, along: Array, across: Array) -> Array:
    """A positive semidefinite (n, n), the Hessian's positive part along the rows that bind."""
    return np.asarray(sum(p @ positive_part(p.T @ hessian @ p) @ p.T for p in (along, across)))

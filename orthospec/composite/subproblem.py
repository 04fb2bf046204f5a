"""The convex subproblem: convex parts kept, smooth insides linearised, solved by Clarabel.

    minimise    factor + penalty·slack + ½ δᵀ H δ
    subject to  offset − on_inside (F + F'δ) − on_slack slack − on_auxiliary a ∈ K      for each block's copy
                g + g'δ <= on_factor·factor + on_slack·slack                            for each half-line
                lower <= δ <= upper,  slack >= 0.

F and g are stacked in one vector w(x) with its Jacobian; blocks and half-lines are slices of it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import clarabel
import numpy as np
from scipy import sparse

from orthospec.composite.template import Template

if TYPE_CHECKING:
    from orthospec.arrays import Array

ACCURACY = 1e-11
ANSWERS = {"Solved", "AlmostSolved", "InsufficientProgress", "MaxIterations", "NumericalError"}
"""Statuses whose point is an answer to be judged by its residuals, not by its name."""


@dataclass(frozen=True)
class Block:
    """``copies`` insides of one form, consecutive in w from ``start``."""

    template: Template
    start: int
    copies: int

    @property
    def width(self) -> int:
        """Length of one copy of w."""
        return int(self.template.on_inside.shape[1])

    @property
    def stop(self) -> int:
        """Where the block ends in w."""
        return self.start + self.copies * self.width


@dataclass(frozen=True)
class HalfLines:
    """Rows g <= on_factor·factor + on_slack·slack, consecutive in w from ``start``."""

    start: int
    on_factor: Array
    on_slack: Array

    @property
    def stop(self) -> int:
        """Where the rows end in w."""
        return self.start + len(self.on_factor)


@dataclass(frozen=True)
class Rows:
    """The shape of a subproblem: how w is cut into blocks and half-lines."""

    blocks: tuple[Block, ...]
    half_lines: HalfLines
    selection: Any = None
    """Whatever the problem needs to evaluate the same w at another point."""


@dataclass(frozen=True)
class Step:
    """A subproblem's answer: the step, its predicted factor and slack, and the multipliers."""

    delta: Array
    factor: float
    slack: float
    multipliers: Array
    """Gradient of the Lagrangian in w: what one unit more of w costs."""
    on_bounds: Array
    """Multipliers of delta's bounds (n, 2): lower, upper."""
    pressure: float
    """Sum of the multipliers on the slack: a penalty below it would be cheaper than the bounds."""
    shares: Array
    """The part of the pressure that each half-line, then each copy of each block, has."""


def solve(
    rows: Rows,
    w: Array,
    jacobian: Array,
    hessian: Array,
    lower: Array,
    upper: Array,
    penalty: float,
    factor_weight: float = 1.0,
) -> Step | None:
    """Solve one subproblem; None where the solver found no usable point.

    w (t,), jacobian (t, n), hessian (n, n) positive semidefinite; lower and upper (n,) bound the step.
    """
    n = len(lower)
    pieces = [_bound_rows(lower, upper), _half_line_rows(rows.half_lines, w, jacobian)]
    pieces += [_block_rows(block, w, jacobian) for block in rows.blocks]
    size = n + 2 + sum(block.copies * block.template.on_auxiliary.shape[1] for block in rows.blocks)
    matrix, offset, cones = _stack(pieces, size)
    cost = np.zeros(size)
    cost[n : n + 2] = factor_weight, penalty
    quadratic = np.zeros((size, size))
    quadratic[:n, :n] = np.triu(hessian)
    answer = clarabel.DefaultSolver(
        sparse.csc_matrix(quadratic), cost, matrix, offset, cones, _settings()
    ).solve()
    x, dual = np.array(answer.x), np.array(answer.z)
    if str(answer.status) not in ANSWERS or not (np.isfinite(x).all() and np.isfinite(dual).all()):
        return None
    return _read(rows, x, dual, n, penalty)


def _settings() -> Any:
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.max_threads = 1
    settings.tol_feas = settings.tol_gap_abs = settings.tol_gap_rel = ACCURACY
    return settings


@dataclass(frozen=True)
class _Piece:
    """Rows offset − dense·(δ, factor, slack) − auxiliary·a ∈ cones.

    ``auxiliary`` stands ``copies`` times on a block diagonal.
    """

    dense: Array
    offset: Array
    cones: Sequence[tuple[str, int]]
    auxiliary: Array
    copies: int = 1


def _bound_rows(lower: Array, upper: Array) -> _Piece:
    n = len(lower)
    dense = np.zeros((2 * n + 1, n + 2))
    dense[:n, :n], dense[n : 2 * n, :n] = -np.eye(n), np.eye(n)
    dense[2 * n, n + 1] = -1.0
    offset = np.concatenate([-lower, upper, [0.0]])
    return _Piece(dense, offset, [("nonneg", 2 * n + 1)], np.zeros((2 * n + 1, 0)))


def _half_line_rows(lines: HalfLines, w: Array, jacobian: Array) -> _Piece:
    cut = slice(lines.start, lines.stop)
    dense = np.column_stack([jacobian[cut], -lines.on_factor, -lines.on_slack])
    return _Piece(dense, -w[cut], [("nonneg", len(dense))] if len(dense) else [], np.zeros((len(dense), 0)))


def _block_rows(block: Block, w: Array, jacobian: Array) -> _Piece:
    form, cut = block.template, slice(block.start, block.stop)
    values = w[cut].reshape(block.copies, block.width)
    slopes = jacobian[cut].reshape(block.copies, block.width, -1)
    dense = np.zeros((block.copies, len(form.offset), slopes.shape[2] + 2))
    dense[:, :, :-2] = form.on_inside @ slopes
    dense[:, :, -1] = form.on_slack
    offset = (form.offset - values @ form.on_inside.T).ravel()
    rows = dense.reshape(-1, dense.shape[2])
    return _Piece(rows, offset, form.cones * block.copies, form.on_auxiliary, block.copies)


def _stack(pieces: Sequence[_Piece], size: int) -> tuple[Any, Array, list[Any]]:
    """The pieces as one sparse matrix of ``size`` columns, its offset and its cones."""
    dense = np.vstack([piece.dense for piece in pieces])
    row, column = np.nonzero(dense)
    entries = [(row, column, dense[row, column])]
    at, auxiliary = 0, dense.shape[1]
    for piece in pieces:
        rows, columns = piece.auxiliary.shape
        i, j = np.nonzero(piece.auxiliary)
        copy = np.arange(piece.copies)[:, None]
        data = np.tile(piece.auxiliary[i, j], piece.copies)
        entries.append(((at + copy * rows + i).ravel(), (auxiliary + copy * columns + j).ravel(), data))
        at += len(piece.offset)
        auxiliary += piece.copies * columns
    i, j, data = (np.concatenate(part) for part in zip(*entries, strict=True))
    matrix = sparse.csc_matrix((data, (i, j)), shape=(at, size))
    cones = [_cone(kind, size) for piece in pieces for kind, size in piece.cones]
    return matrix, np.concatenate([piece.offset for piece in pieces]), cones


def _cone(kind: str, size: int) -> Any:
    if kind == "exp":
        return clarabel.ExponentialConeT()
    kinds = {
        "zero": clarabel.ZeroConeT,
        "nonneg": clarabel.NonnegativeConeT,
        "soc": clarabel.SecondOrderConeT,
        "psd": clarabel.PSDTriangleConeT,
    }
    return kinds[kind](size)


def _read(rows: Rows, x: Array, dual: Array, n: int, penalty: float) -> Step:
    lines = rows.half_lines
    multipliers = np.zeros(max([lines.stop, *(block.stop for block in rows.blocks)]))
    at = 2 * n + 1
    on_slack = dual[2 * n]
    multipliers[lines.start : lines.stop] = dual[at : at + len(lines.on_factor)]
    shares = [multipliers[lines.start : lines.stop] * lines.on_slack]
    at += len(lines.on_factor)
    for block in rows.blocks:
        count = len(block.template.offset)
        part = dual[at : at + block.copies * count].reshape(block.copies, count)
        multipliers[block.start : block.stop] = (part @ block.template.on_inside).ravel()
        shares.append(-(part @ block.template.on_slack))
        at += block.copies * count
    on_bounds = np.column_stack([dual[:n], dual[n : 2 * n]])
    pressure = float(penalty - on_slack)
    return Step(x[:n], float(x[n]), float(x[n + 1]), multipliers, on_bounds, pressure, np.concatenate(shares))

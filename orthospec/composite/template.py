"""A convex form as rows of cones: compiled once through cvxpy, stamped for every critical point.

A form's ``holds(X, bound, slack)`` states a bound for one X. Compiled with X, bound, ln(bound) and slack as
variables it becomes

    offset − on_inside w − on_slack s − on_auxiliary a ∈ K,      w = (X, bound, ln bound),

with K a product of cones and a the auxiliary variables that cvxpy introduced. The subproblem repeats these
rows for each critical point with its own linearisation of w, so neither a new point nor a new size of the
problem compiles anything.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from orthospec.arrays import Array


@dataclass(frozen=True)
class Template:
    """One form as cone rows: r rows, q = size of the inside + 2 columns of w, k auxiliary variables."""

    offset: Array
    on_inside: Array
    on_slack: Array
    on_auxiliary: Array
    cones: tuple[tuple[str, int], ...]
    """Kind (zero, nonneg, soc, psd, exp) and size of each cone, in the order of the rows."""


def compile_form(holds: Callable[[Any, Any, Any], list[Any]], shape: tuple[int, ...]) -> Template:
    """Compile ``holds`` for insides of this shape.

    Raises ValueError where its constraints are not convex, or need a cone outside the five kinds.
    """
    import cvxpy as cp

    class Bound(cp.Variable):  # type: ignore[misc]
        """A bound with its logarithm beside it, both affine for the solver."""

        logarithm: cp.Variable

    inside, bound, slack = cp.Variable(shape), Bound(), cp.Variable()
    bound.logarithm = cp.Variable()
    size = int(np.prod(shape, dtype=int))
    # An objective that numbers the variables tells which column of the canonical form is which.
    numbers = np.arange(1.0, size + 1).reshape(shape)
    mark = cp.sum(cp.multiply(numbers, inside)) + (size + 1) * bound + (size + 2) * bound.logarithm
    problem = cp.Problem(cp.Minimize(mark + (size + 3) * slack), holds(inside, bound, slack))
    if not problem.is_dcp():
        raise ValueError(
            "the constraints of the form are not convex in X, bound and slack (cvxpy's DCP rules)"
        )
    data = problem.get_problem_data(cp.CLARABEL)[0]
    rows = np.asarray(data["A"].todense())
    order = np.rint(data["c"]).astype(int)
    columns = np.argsort(order, kind="stable")[np.count_nonzero(order == 0) :]
    keep = ~_symmetry_rows(rows, columns, shape, data["dims"].zero)
    rows = rows[keep]
    return Template(
        offset=np.asarray(data["b"], dtype=float)[keep],
        on_inside=rows[:, columns[:-1]],
        on_slack=rows[:, columns[-1]],
        on_auxiliary=rows[:, order == 0],
        cones=_cones(data["dims"], int(np.count_nonzero(~keep))),
    )


def _symmetry_rows(
    rows: Array, columns: NDArray[np.intp], shape: tuple[int, ...], zeros: int
) -> NDArray[np.bool_]:
    """Which rows only state X = Xᵀ: cvxpy asks it of spectral functions, and a linearised inside has it."""
    found = np.zeros(len(rows), dtype=bool)
    if len(shape) == 2 and shape[0] == shape[1]:
        on_x = rows[:zeros, columns[:-3]].reshape(zeros, *shape)
        other = np.abs(rows[:zeros]).sum(axis=1) - np.abs(on_x).sum(axis=(1, 2))
        found[:zeros] = (other == 0) & (on_x == -np.swapaxes(on_x, 1, 2)).all(axis=(1, 2))
    return found


def _cones(dims: Any, dropped: int) -> tuple[tuple[str, int], ...]:
    if dims.p3d or getattr(dims, "pnd", ()):
        raise ValueError("the form needs a power cone, which is not served")
    cones = [("zero", dims.zero - dropped), ("nonneg", dims.nonneg)]
    cones += [("soc", size) for size in dims.soc]
    cones += [("psd", size) for size in dims.psd]
    cones += [("exp", 3)] * dims.exp
    return tuple((kind, int(size)) for kind, size in cones if size)

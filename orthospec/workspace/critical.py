"""Critical points: where, over a whole cuboid, functions of the pose are greatest.

The paper (section 2) gives up critical points because they were derived by hand, machine by machine. Here
they are found: a lattice over the cuboid, faces and inside included, gives the local maximisers of each
function; those near the greatest are refined by a compass search and Newton steps on the free coordinates.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from itertools import product
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from orthospec.arrays import Array

Functions = Callable[["Array"], "Array"]
"""Maps points u (n, d) in [−1/2, 1/2]^d to function values (k, n)."""

NODES = 9
"""Nodes of the lattice along each axis."""
NEAR = 0.1
"""A local maximiser this near the greatest value, as a part of the function's range or of 1, is critical."""
MOST = 27
"""Most critical points found of one function."""
KEPT = 24
"""Most critical points kept of one cuboid, beside the worst of each function."""
SHADOW = 0.2
"""A critical point this near a worse one (as a part of the cuboid) tells little of its own."""
COMPASS = 3
"""Rounds of compass search, each halving its step."""
CLIMB = 30
"""Rounds of the last climb, to a step of 2e-11."""
NEWTON = (2e-3, 2e-4)
"""Steps of the differences of the Newton rounds."""
ROUNDING = 1e-14
"""A rise up to this is none: on a ridge or plateau, points would wander off and become ever more."""


class Peaks(NamedTuple):
    """Critical points of k functions: point u[j] belongs to function of[j], with that value."""

    u: Array
    of: NDArray[np.intp]
    value: Array

    def greatest(self, count: int) -> Array:
        """The greatest value of each of ``count`` functions; −inf where one has no point."""
        best = np.full(count, -np.inf)
        np.maximum.at(best, self.of, self.value)
        return best


def find_peaks(functions: Functions, d: int, known: Array | None = None, nodes: int = NODES) -> Peaks:
    """The near-greatest local maximisers of each function over [−1/2, 1/2]^d.

    ``known`` (n, d) are further points to start from, the critical points of before.
    """
    nodal = lattice(nodes, d)
    points = nodal if known is None else np.vstack([nodal, known])
    values = functions(points)
    starts = []
    peaked = _local_maxima(values[:, : len(nodal)].reshape(-1, *(nodes,) * d))
    for row, highest in zip(values[:, : len(nodal)], peaked.reshape(-1, len(nodal)), strict=True):
        chosen = np.flatnonzero(highest)
        starts.append(_apart(nodal, row, chosen[row[chosen] >= _threshold(row)]))
    for row in values:
        near = np.flatnonzero(row[len(nodal) :] >= _threshold(row[: len(nodal)])) + len(nodal)
        starts.append(near[np.argsort(-row[near], kind="stable")][:MOST])
    of = np.repeat([*range(len(values))] * 2, [len(chosen) for chosen in starts])
    first = np.concatenate(starts)
    return _refine(functions, Peaks(points[first], of, values[of, first]), 0.5 / (nodes - 1))


@lru_cache
def lattice(nodes: int, d: int) -> Array:
    """Points (nodes^d, d) over [−1/2, 1/2]^d, read-only; of 3 nodes an axis: corners, middles, centre."""
    points = np.array(list(product(np.linspace(-0.5, 0.5, nodes), repeat=d)))
    points.flags.writeable = False
    return points


def _threshold(row: Array) -> float:
    greatest = float(row.max())
    return greatest - NEAR * min(1.0, greatest - float(row.min())) if np.isfinite(greatest) else greatest


def _local_maxima(values: Array) -> NDArray[np.bool_]:
    """Which nodes none of their neighbours exceeds, of each function (k, ...)."""
    around = values
    for axis in range(1, values.ndim):
        beside, around = np.moveaxis(around, axis, 0), around.copy()
        here = np.moveaxis(around, axis, 0)
        np.maximum(here[1:], beside[:-1], out=here[1:])
        np.maximum(here[:-1], beside[1:], out=here[:-1])
    return np.asarray(values >= around)


def _apart(lattice: Array, row: Array, chosen: NDArray[np.intp]) -> NDArray[np.intp]:
    """The greatest of the chosen nodes; on a plateau only nodes half a cuboid apart."""
    kept: list[int] = []
    for node in chosen[np.argsort(-row[chosen], kind="stable")]:
        level = [k for k in kept if row[k] <= row[node] + 1e-9]
        if not level or np.abs(lattice[level] - lattice[node]).max(axis=1).min() >= 0.5:
            kept.append(int(node))
    return np.array(kept[:MOST], dtype=np.intp)


def _own(functions: Functions, points: Array, of: NDArray[np.intp]) -> Array:
    """The value of each point's own function."""
    return np.asarray(functions(points)[of, np.arange(len(points))])


def _refine(functions: Functions, starts: Peaks, step: float) -> Peaks:
    u, of, value = _compass(functions, starts, step, COMPASS)
    step /= 2**COMPASS
    for h in NEWTON:
        u, value = _newton(functions, u, of, value, h, 2 * step)
        step = min(step, 50 * h)
    return Peaks(u, of, value)


def highest_peaks(functions: Functions, peaks: Peaks, count: int) -> Peaks:
    """The best peak of each of ``count`` functions, climbed to the top where a ridge or cone stops Newton."""
    of = [np.flatnonzero(peaks.of == k) for k in range(count)]
    best = [int(mine[peaks.value[mine].argmax()]) for mine in of]
    return _compass(functions, Peaks(peaks.u[best], peaks.of[best], peaks.value[best]), 0.02, CLIMB)


def _compass(functions: Functions, peaks: Peaks, step: float, rounds: int) -> Peaks:
    """Compass search from each peak with a step that halves each round."""
    u, of, value = peaks
    d = u.shape[1]
    star = np.array([s for s in product((-1.0, 0.0, 1.0), repeat=d) if any(s)])
    for _ in range(rounds):
        tries = np.clip(u[:, None, :] + step * star, -0.5, 0.5)
        found = _own(functions, tries.reshape(-1, d), np.repeat(of, len(star))).reshape(len(u), len(star))
        best = found.argmax(axis=1)
        here = np.arange(len(u))
        better = found[here, best] > value + ROUNDING
        u = np.where(better[:, None], tries[here, best], u)
        value = np.where(better, found[here, best], value)
        step /= 2
    return Peaks(u, of, value)


def _newton(
    functions: Functions, u: Array, of: NDArray[np.intp], value: Array, h: float, reach: float
) -> tuple[Array, Array]:
    """One Newton step on the coordinates that no face holds; kept where it rises."""
    d = u.shape[1]
    # Differences are taken around a centre that keeps a step's distance from the faces.
    centre = np.clip(u, -0.5 + h, 0.5 - h)
    offsets = [np.zeros(d), *(h * np.eye(d)), *(-h * np.eye(d))]
    pairs = [(i, j) for i in range(d) for j in range(i)]
    offsets += [s * h * (np.eye(d)[i] + np.eye(d)[j]) for i, j in pairs for s in (1, -1)]
    tries = (centre[:, None, :] + np.array(offsets)).reshape(-1, d)
    f = _own(functions, tries, np.repeat(of, len(offsets))).reshape(len(u), len(offsets))
    usable = np.asarray(np.isfinite(f).all(axis=1))
    f = np.where(usable[:, None], f, 0.0)
    plus, minus, f0 = f[:, 1 : d + 1], f[:, d + 1 : 2 * d + 1], f[:, :1]
    slope = (plus - minus) / (2 * h)
    bend = np.zeros((len(u), d, d))
    bend[:, range(d), range(d)] = (plus - 2 * f0 + minus) / h**2
    for k, (i, j) in enumerate(pairs):
        both = f[:, 2 * d + 1 + 2 * k] + f[:, 2 * d + 2 + 2 * k]
        cross = both - plus[:, i] - minus[:, i] - plus[:, j] - minus[:, j] + 2 * f0[:, 0]
        bend[:, i, j] = bend[:, j, i] = cross / (2 * h**2)
    held = ((u >= 0.5) & (slope > 0)) | ((u <= -0.5) & (slope < 0))
    usable &= ~held.all(axis=1)
    if not usable.any():
        return u, value
    move = np.where(held, np.clip(u, -0.5, 0.5) - centre, 0.0)
    move[usable] = _ascent(slope[usable], bend[usable], held[usable], move[usable], reach)
    trial = np.clip(centre + move, -0.5, 0.5)
    rising = np.where(usable, _own(functions, trial, of), -np.inf)
    better = rising > value + ROUNDING
    return np.where(better[:, None], trial, u), np.where(better, rising, value)


def _ascent(slope: Array, bend: Array, held: NDArray[np.bool_], fixed: Array, reach: float) -> Array:
    """Newton's step on the free coordinates of each point, the held ones moved as given."""
    moves = fixed.copy()
    for free in np.unique(~held, axis=0):
        (these,) = np.nonzero((~held == free).all(axis=1))
        among = bend[these][:, free]
        gradient = slope[these][:, free] + (among[:, :, ~free] @ fixed[these][:, ~free, None])[:, :, 0]
        eigenvalues, vectors = np.linalg.eigh(among[:, :, free])
        down = np.maximum(np.abs(eigenvalues), 1e-9)
        along = (np.swapaxes(vectors, 1, 2) @ gradient[:, :, None])[:, :, 0] / down
        moves[np.ix_(these, free)] = np.clip((vectors @ along[:, :, None])[:, :, 0], -reach, reach)
    return moves


def worst_points(values: Array, u: Array) -> NDArray[np.intp]:
    """Which points u (n, d) to keep, by the values (k, n) of what is bounded there: the worst few.

    The worst of each row, then the worst of all; those in the shadow of a worse one nearby come last, or a
    flat peak's many points would crowd out a corner that no other stands for. Points at which a row is not
    known (inf) are dropped; −inf is a bound that holds by any factor.
    """
    known = np.flatnonzero((values < np.inf).all(axis=0))
    values, u = values[:, known], u[known]
    worst = values.argmax(axis=1)
    near = np.abs(u[:, None] - u).max(axis=2) < SHADOW
    order = np.arange(len(u))
    behind = values[:, :, None] < values[:, None, :]
    behind |= (values[:, :, None] == values[:, None, :]) & (order[:, None] > order)
    shadowed = (behind & near).any(axis=2)
    own = np.where(shadowed, -np.inf, values).max(axis=0)
    by_rank = np.lexsort((order, -values.max(axis=0), -own))
    return np.asarray(known[np.union1d(worst, by_rank[:KEPT])])

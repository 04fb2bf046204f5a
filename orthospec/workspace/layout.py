"""What the variables of a fit are: a design, the cuboids' centres, their scale, the extremes of goals."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from orthospec.workspace.conditions import Extreme
from orthospec.workspace.cuboid import Cuboid

if TYPE_CHECKING:
    from orthospec.arrays import Array


class Point(NamedTuple):
    """The variables unscaled but for the design: (k,), centres (g, d), μ, extremes (e,)."""

    design: Array
    centres: Array
    scale: float
    extremes: Array


@dataclass(frozen=True)
class Limits:
    """What bounds the cuboids beside the machine: the design's box, their region, their scale."""

    design: tuple[Array, Array]
    """Box of the scaled design variables, (k,) each."""
    region: Cuboid | None = None
    scale: tuple[float, float] | None = None
    """Range of μ where it is a variable; None fixes it at 1."""
    least_scale: float | None = None
    """A scale to be reached, elastically: the start may be smaller."""

    def centres(self, size: Array) -> tuple[Array, Array]:
        """Box of the centres of cuboids of scale 1, (d,) each; a point in an axis that leaves no room."""
        if self.region is None:
            return np.full(len(size), -np.inf), np.full(len(size), np.inf)
        low, high = np.array(self.region.low) + size / 2, np.array(self.region.high) - size / 2
        return np.where(low < high, low, (low + high) / 2), np.where(low < high, high, (low + high) / 2)

    def rows(self, size: Array, point: Point) -> Array:
        """Rows <= 0: the scale to be reached, and a μ that varies within the region, relative to the size.

        Cuboids of fixed scale are held by bounds on their centres, which need no slack.
        """
        rows = [] if self.least_scale is None else [np.array([self.least_scale - point.scale])]
        if self.region is not None and self.scale is not None:
            half = point.scale * size / 2
            rows.append(np.ravel((np.array(self.region.low) - point.centres + half) / size))
            rows.append(np.ravel((point.centres + half - np.array(self.region.high)) / size))
        return np.concatenate(rows) if rows else np.zeros(0)


@dataclass(frozen=True)
class Layout:
    """How a `Point` stands in x: design in [0, 1], centres in cuboid sizes from their start, μ, extremes.

    A positive extreme of a measure varies as a logarithm, since bounds are linear in it; another in multiples
    of its first value; a joint's in cuboid sizes.
    """

    size: Array
    start: Array
    """Centres at the start (g, d)."""
    limits: Limits
    extremes: tuple[Extreme, ...] = ()
    reference: tuple[float, ...] = ()
    """First values of the extremes."""

    def with_reference(self, values: Array) -> Layout:
        """The same layout, its extremes measured from these values."""
        return replace(self, reference=tuple(float(v) for v in values))

    @property
    def is_ratio(self) -> Array:
        """Which extremes vary as logarithms (e,)."""
        pairs = zip(self.extremes, self.reference, strict=True)
        return np.array([isinstance(e.of, str) and value > 0 for e, value in pairs], dtype=bool)

    @property
    def unit(self) -> Array:
        """One unit of x of each extreme that does not vary as a logarithm (e,)."""
        pairs = zip(self.extremes, self.reference, strict=True)
        longest = float(self.size.max())
        return np.array([longest if isinstance(e.of, int) else abs(v) or 1.0 for e, v in pairs])

    def pack(self, point: Point) -> Array:
        """X of a point."""
        moves = np.ravel((point.centres - self.start) / self.size)
        mu = [point.scale] if self.limits.scale else []
        reference, ratio = np.array(self.reference), self.is_ratio
        with np.errstate(divide="ignore", invalid="ignore"):
            z = np.where(ratio, np.log(point.extremes / reference), (point.extremes - reference) / self.unit)
        return np.concatenate([point.design, moves, mu, z])

    def unpack(self, x: Array) -> Point:
        """The point of x."""
        k, (g, d) = len(self.limits.design[0]), self.start.shape
        centres = self.start + x[k : k + g * d].reshape(g, d) * self.size
        rest = x[k + g * d :]
        mu, z = (float(rest[0]), rest[1:]) if self.limits.scale else (1.0, rest)
        reference, ratio = np.array(self.reference), self.is_ratio
        values = np.where(ratio, reference * np.exp(np.where(ratio, z, 0.0)), reference + z * self.unit)
        return Point(x[:k], centres, mu, values)

    def box(self) -> tuple[Array, Array]:
        """Bounds of x."""
        ends = []
        places = self.limits.centres(self.size)
        for side, infinity in enumerate((-np.inf, np.inf)):
            mu = [self.limits.scale[side]] if self.limits.scale else []
            held = np.full(self.start.shape, infinity)
            if self.limits.scale is None:
                held = (places[side] - self.start) / self.size
            extremes = np.full(len(self.extremes), infinity)
            ends.append(np.concatenate([self.limits.design[side], held.ravel(), mu, extremes]))
        return ends[0], ends[1]

"""Where plugins are tried: poses, boxes of poses, and other units."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from pydantic import BaseModel

from orthospec.errors import OrthospecError
from orthospec.intervals import Boxes, Interval
from orthospec.show.keys import keys_of
from orthospec.testing.expectations import Nonconformity
from orthospec.workspace.cuboid import Cuboid
from orthospec.workspace.grid import reach_box

if TYPE_CHECKING:
    from orthospec.arrays import Array, Poses
    from orthospec.manipulators import Manipulator
    from orthospec.testing.views import Units

Model = TypeVar("Model", bound=BaseModel)

POSES, SINGLES, BOXES, INSIDE = 500, 12, 40, 25
"""Tried in a block, one by one, as boxes, and in each box."""
PARTS = (0.0, 1e-3, 3e-2)
"""Edges of boxes, relative to all that is tried; points among them."""
CLOSE, DIFFERENCE = 1e-9, 1e-5
"""How near two ways to one number have to come, relative: by the same code, and by differences."""
ALIKE = 1e-7
"""How near values come in two frames or units, relative: to rounding, and to differences if taken."""
WELL_INSIDE = 1e-2
"""A margin from which on differences are taken: nearer to its end a field may change too fast for them."""
LARGER = 2.0
"""By what a machine is made larger to see whether its lengths are lengths."""
ROUNDING = 1e-12
"""What a mean-value form may be off by at a pose, relative: both are computed in plain arithmetic here."""


def tried_in(machine: Manipulator, region: tuple[Any, Any] | None) -> Cuboid:
    """The box of poses to try."""
    if region is not None:
        return Cuboid(tuple(map(float, region[0])), tuple(map(float, region[1])))
    try:
        return reach_box(machine, np.full(len(machine.axes), 0.1))
    except OrthospecError as error:
        raise Nonconformity(
            f"{type(machine).__name__}: {error}; give the test a region=(low, high)"
        ) from None


def block(box: Cuboid, axes: int, seed: int, count: int = POSES) -> Poses:
    """Poses of a box at random, the same for the same seed."""
    u = np.random.default_rng(seed).uniform(-0.5, 0.5, (count, len(box.low)))
    return box.poses(u, axes)


def read_only(poses: Poses) -> Poses:
    """The same poses, which nobody may change."""
    poses.flags.writeable = False
    return poses


def retold(one: Model, units: Units) -> Model | None:
    """The same machine or measure with its fields told in other units; None where that cannot be built."""
    keys = one.model_dump(mode="json", by_alias=True, exclude_none=True)
    for key in keys_of(type(one)).every():
        *stem, last = key.path
        holder: Any = keys
        for name in stem:
            holder = holder.get(name) if isinstance(holder, dict) else None
        if not key.units or not isinstance(holder, dict) or last not in holder:
            continue
        factors = [units.of(unit) for unit in key.units]
        if len(factors) == 1:
            holder[last] = _times(holder[last], factors[0])
        elif isinstance(holder[last], list) and len(holder[last]) == len(factors):
            holder[last] = [_times(*pair) for pair in zip(holder[last], factors, strict=True)]
        else:
            return None  # Which number has which unit is not known.
    try:
        return type(one).model_validate(keys)
    except ValueError:
        return None


def _times(value: Any, factor: float) -> Any:
    """All numbers in a value times a factor; words stay."""
    if isinstance(value, list):
        return [_times(inner, factor) for inner in value]
    if isinstance(value, dict):
        return {name: _times(inner, factor) for name, inner in value.items()}
    return value * factor if isinstance(value, float) else value


def boxes(box: Cuboid, axes: int, around: Poses | None = None) -> list[Boxes]:
    """Boxes of three sizes, points among them."""
    centres = block(box, axes, seed=3, count=BOXES) if around is None else around[:BOXES]
    found = []
    for part in PARTS:
        half = np.zeros((1, axes))
        half[0, : len(box.low)] = part * box.size / 2
        found.append(Boxes(centres - half, centres + half))
    return found


def within(boxes: Boxes, seed: int) -> Poses:
    """A pose of each box."""
    parts = np.random.default_rng(seed).uniform(0, 1, boxes.lo.shape)
    return np.clip(boxes.lo + parts * (boxes.hi - boxes.lo), boxes.lo, boxes.hi)


def told_at(enclosed: Interval, boxes: Boxes, poses: Poses) -> tuple[Array, Array]:
    """What an enclosure says of one pose of each box: its ends, and what its mean-value form is there."""
    own, form = boxes.poses.form, enclosed.form
    if own is None or form is None or form.g.shape[-1] != poses.shape[1]:
        return enclosed.lo, enclosed.hi
    u = (poses - own.c) / np.einsum("nkk->nk", own.g)
    near = form.c + np.einsum("n...k,nk->n...", form.g, u)
    rest = form.r + ROUNDING * (np.abs(form.c) + np.abs(form.g).sum(axis=-1))
    return np.fmax(enclosed.lo, near - rest), np.fmin(enclosed.hi, near + rest)

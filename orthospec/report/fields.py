"""The fields that a report shows: each measure on planes through the middle of its cuboid, and in space."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from orthospec.errors import OrthospecError, PluginFault
from orthospec.measures.demand import bounded_side, excess
from orthospec.solution import Lattice, sampled, sliced, workspace_surface
from orthospec.workspace.cuboid import Cuboid
from orthospec.workspace.grid import reach_box

if TYPE_CHECKING:
    from orthospec.arrays import Array
    from orthospec.measures import Demand
    from orthospec.solution import Solution, Surface
    from orthospec.spec import Design

ON_PLANES, IN_SPACE = 61, 27
"""Nodes along the longest edge."""


@dataclass(frozen=True)
class Field:
    """One measure about one cuboid."""

    demand: Demand
    cuboid: Cuboid | None
    middle: Array
    """The pose that the planes go through."""
    planes: tuple[tuple[tuple[int, int], Lattice], ...]
    """The two axes that each plane spans, and its nodes."""
    space: Lattice | None
    """With three axes."""


def cuboid_of(solution: Solution, name: str) -> Cuboid | None:
    """The prescribed cuboid that a measure stands for, or else the largest one."""
    workspace = solution.result.workspace
    record = workspace.measures.get(name)
    places = [record.prescribed if record else None, workspace.prescribed, workspace.joint, record]
    for place in places:
        if place is not None and place.min is not None and place.max is not None:
            corners = [*place.min, *place.max]
            if all(one is not None for one in corners):
                return Cuboid(tuple(place.min), tuple(place.max))  # type: ignore[arg-type]
    return None


def fields(solution: Solution, design: Design) -> tuple[list[Field], list[str]]:
    """A field for each measure that can be computed, and what to say of the others."""
    failed = {error.name for error in solution.result.errors}
    groups: dict[Cuboid | None, list[Demand]] = {}
    found: list[Field] = []
    not_shown: list[str] = []
    for demand in design.demands:
        if demand.name in failed:
            not_shown.append(f"No field is shown of {demand.name}, which failed.")
        else:
            groups.setdefault(cuboid_of(solution, demand.name), []).append(demand)
    for cuboid, demands in groups.items():
        while demands:
            try:
                found += _of(solution, replace(design, demands=tuple(demands)), cuboid)
                break
            except OrthospecError as error:
                place = error.place if isinstance(error, PluginFault) else None
                without = [one for one in demands if one.place == place] or demands
                not_shown.append(f"No field is shown of {', '.join(one.name for one in without)}: {error}")
                demands = [one for one in demands if one not in without]
    return found, not_shown


def _of(solution: Solution, design: Design, cuboid: Cuboid | None) -> Iterator[Field]:
    workspace = solution.spec.workspace if solution.spec else None
    if workspace is None:
        return
    size = np.asarray(workspace.size)
    region = workspace.region
    box = reach_box(design.manipulator, size) if region is None else Cuboid(region.min, region.max)
    middle = box.centre if cuboid is None else cuboid.centre
    planes = tuple(
        (pair, sliced(design, box, middle, pair, ON_PLANES)) for pair in combinations(range(len(size)), 2)
    )
    bounded = replace(design, demands=tuple(one for one in design.demands if one.bounds))
    space = sampled(bounded, box, size, IN_SPACE) if len(size) == 3 and bounded.demands else None
    for demand in design.demands:
        yield Field(demand, cuboid, middle, planes, space)


def bounded_values(lattice: Lattice, name: str, side: str) -> Array:
    """What a bound of this side bounds of a measure, at the nodes of a lattice."""
    shape = lattice.margin.shape
    found = lattice.values.get(name)
    if found is None:
        return np.full(shape, np.nan)
    flat = found.reshape(lattice.margin.size, *found.shape[lattice.margin.ndim :])
    return bounded_side(flat, side).reshape(shape)


def continued(margin: Array) -> Array:
    """A margin of the reach, going on beyond its end as it changes from node to node where it is known."""
    known = np.isfinite(margin)
    steps = [np.abs(np.diff(margin, axis=k)) for k in range(margin.ndim)]
    finite = np.concatenate([one[np.isfinite(one)] for one in steps]) if steps else np.zeros(0)
    return np.where(known, margin, -float(finite.mean()) if finite.any() else -1.0)


def bound_surface(lattice: Lattice, name: str, side: str, bound: float) -> Surface | None:
    """The closed surface around all nodes in reach that meet a bound; None where none does."""
    values = bounded_values(lattice, name, side)
    over = excess(values.ravel(), bound, side).reshape(values.shape)
    inside = np.where(np.isfinite(over), np.clip(-over, -1.0, 1.0), -1.0)
    margin = continued(lattice.margin)
    reach = np.clip(margin / (np.abs(margin).max() or 1.0), -1.0, 1.0)
    # Out of reach the margin alone says how far outside a node is: values end there.
    holding = np.where(lattice.reachable, np.minimum(inside, reach), np.minimum(reach, -1e-9))
    return workspace_surface(replace(lattice, margin=holding, reachable=np.asarray(holding > 0)))

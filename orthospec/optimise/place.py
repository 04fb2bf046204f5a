"""Where a fit begins or ended, as plain data, and the fit made anew from it.

Whatever follows a solve makes its problem from such a place, in the same way whether the solve ran here, in
another process or was kept from an earlier run.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from orthospec.optimise.objective import GoalObjective, Learnt
from orthospec.optimise.space import DesignSpace
from orthospec.workspace.conditions import Condition
from orthospec.workspace.cuboid import Cuboid
from orthospec.workspace.evaluate import FINE
from orthospec.workspace.fit import FitProblem, Group
from orthospec.workspace.layout import Limits, Point

if TYPE_CHECKING:
    from orthospec.arrays import Array


@dataclass(frozen=True)
class Place:
    """A scaled design, and where its prescribed cuboids stand."""

    z: tuple[float, ...]
    groups: tuple[Group, ...]
    """The cuboids' centres, and which demands share each."""
    scale: float = 1.0
    scales: tuple[float, float] | None = None
    """Range of the scale where it is a variable."""
    least_scale: float | None = None
    """A scale to be reached, where the cuboid is smaller than the prescribed one."""

    @property
    def design(self) -> Array:
        """The scaled design (k,)."""
        return np.array(self.z, dtype=float)

    def limits(self, space: DesignSpace) -> Limits:
        """What bounds a fit from here: the variables' ranges, the region, the scale."""
        box = np.zeros(len(self.z)), np.ones(len(self.z))
        return Limits(box, space.setting.region, self.scales, self.least_scale)

    def at(self, point: Point) -> Place:
        """The same fit at another point."""
        groups = tuple(
            replace(group, centre=tuple(map(float, centre)))
            for group, centre in zip(self.groups, point.centres, strict=True)
        )
        return replace(self, z=tuple(map(float, point.design)), groups=groups, scale=float(point.scale))

    def carried(self, space: DesignSpace, other: DesignSpace) -> Place:
        """The same place in a space of the same variables with other ranges."""
        return replace(self, z=tuple(map(float, other.scaled(space.values(self.design)))))

    def cuboids(self, space: DesignSpace) -> dict[str, Cuboid]:
        """The prescribed cuboids, by measure; "" names the joint one."""
        size = self.scale * space.setting.size
        apart = not space.spec.workspace.together and any(
            demand.bounds for demand in space.design(self.design).demands
        )
        return {
            group.names[0] if apart else "": Cuboid.around(np.array(group.centre), size)
            for group in self.groups
        }


@dataclass(frozen=True)
class Fit:
    """The fit problem of a place; it begins at ``problem.start``."""

    space: DesignSpace
    place: Place
    objective: GoalObjective
    problem: FitProblem


def fit_at(
    space: DesignSpace,
    place: Place,
    learnt: Learnt | None = None,
    *,
    limits: Limits | None = None,
    shifts: Mapping[str, float] | None = None,
    relaxed: Mapping[Condition, float] | None = None,
    pinned: Array | None = None,
) -> Fit:
    """The fit at a place; what its objective has ``learnt`` at the start of a solve is to be handed on.

    ``limits``, ``shifts`` of goals and ``relaxed`` conditions change the problem, as for a price; ``pinned``
    poses are those that a proof has found.
    """
    z = place.design
    objective = GoalObjective(space, z, shifts)
    bounded = limits or place.limits(space)
    inside = np.clip(z, *bounded.design)
    problem = FitProblem(
        space.machine,
        space.setting.size,
        place.groups,
        objective,
        bounded,
        (inside, place.scale),
        relaxed,
        pinned,
        space.forms,
    )
    if learnt is None:
        objective.settle(space.machine(inside), problem.layout.unpack(problem.start))
    else:
        objective.recall(learnt)
    return Fit(space, place, objective, problem)


def fit_finely(space: DesignSpace, place: Place, learnt: Learnt) -> Fit:
    """The fit where a solve ended, with the critical points of a fine lattice."""
    fit = fit_at(space, place, learnt)
    fit.problem.lattice = FINE
    fit.problem.assess(fit.problem.start)
    return fit

"""By how little something must give way for a design to be found: the tasks of which a card is made."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf

from orthospec.optimise.loosen import largest_scale, look
from orthospec.optimise.place import Place
from orthospec.optimise.space import DesignSpace
from orthospec.optimise.tasks import Task, problem_of
from orthospec.result import Limit
from orthospec.workspace.field import Progress

EXACT = 1e-8
"""A loosening is known when it is enclosed this tightly."""
LOOKS = 30
"""Most looks spent on one loosening."""


@dataclass(frozen=True)
class Without:
    """Some conditions to leave out, in a look from a place."""

    place: Place
    ones: tuple[Limit, ...]


@dataclass(frozen=True)
class WayOut:
    """What is to give way, all of it by the same part: conditions; where none is named, the cuboid's size."""

    place: Place
    ones: tuple[Limit, ...]


@dataclass(frozen=True)
class Way:
    """The least loosening with which a design is found, or the greatest scale, and the design there."""

    by: float
    z: tuple[float, ...] | None = None
    """Scaled; None where nothing that is told of the way hangs on it."""


def conflicts_without(space: DesignSpace, one: Without, _: Progress | None = None) -> bool:
    """Whether no design is found though some conditions are left out."""
    return not look(space, one.place, dict.fromkeys(one.ones, inf)).found


def least_way(space: DesignSpace, way: WayOut, _: Progress | None = None) -> Way | None:
    """The least loosening, or the greatest scale, with which a design is found; None where none does it."""
    if way.ones:
        return loosened(space, way.place, way.ones)
    scale = largest_scale(space, way.place)
    return None if scale is None else Way(scale)


CONFLICT = Task("what conflicts", conflicts_without, problem_of)
GIVE_WAY = Task("what would have to give way", least_way, problem_of, (Way,))


def loosened(space: DesignSpace, place: Place, ones: Sequence[Limit]) -> Way | None:
    """By how much these must be loosened, all by the same part, for a design to be found.

    None where no loosening does it.
    """
    free = look(space, place, dict.fromkeys(ones, inf))
    if not free.found:
        return None
    if any(one.kind == "joint" for one in ones):
        by = _enclosed(space, place, ones)
        return None if by is None else Way(by)
    solved = look(space, free.at, dict.fromkeys(ones, inf), tuple(ones))
    return Way(solved.factor, solved.at.z) if solved.found else None


def _enclosed(space: DesignSpace, place: Place, ones: Sequence[Limit]) -> float | None:
    """The same where the reach has the values: the least violation falls with the loosening.

    The curve is nearly convex: secants from below, and bisection where one leads too far.
    """
    seen = look(space, place, {})
    below: list[tuple[float, float]] = [(0.0, seen.missed)]
    above, at = inf, seen.at
    for _ in range(LOOKS):
        here = _next(below, above)
        seen = look(space, at, dict.fromkeys(ones, here))
        if seen.found:
            above = here
        else:
            below.append((here, seen.missed))
            at = seen.at
        if above < inf and above - below[-1][0] <= EXACT * max(1.0, above):
            break
    return above if above < inf else None


def _next(below: Sequence[tuple[float, float]], above: float) -> float:
    """The loosening to look at next, between the greatest that is too little and the least that is enough."""
    here, missed = below[-1]
    guess = here + 2 * missed
    if len(below) > 1:
        before, more = below[-2]
        slope = (more - missed) / (here - before)
        guess = here + missed / slope if slope > 0 else here + 2 * (here - before)
    hair = 0.8 * EXACT * max(1.0, guess)
    if abs(guess - above) <= hair:
        return above - hair
    # A hair beyond the root that is expected, so that the look there encloses it.
    return guess + hair / 4 if guess + hair / 4 < above else (here + above) / 2

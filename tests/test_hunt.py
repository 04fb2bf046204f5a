"""The search of a design space: what is refined, what counts as one place, what goes on to the end."""

from __future__ import annotations

import numpy as np
import pytest

from orthospec.optimise import hunt as hunting
from orthospec.optimise.attain import begin, finish
from orthospec.optimise.explore import explore
from orthospec.optimise.hunt import DISTINCT, KEPT, REFINED, hunt
from orthospec.optimise.space import DesignSpace
from orthospec.optimise.workers import Here

TWO_BASINS = """\
orthospec: 1
variables: {x: {min: -1, max: 1, start: -0.9}, leg: {min: 0.32, max: 0.5}}
manipulator: {use: orthoglide, leg_lengths: [leg, leg, leg]}
workspace: {size: [0.2, 0.2, 0.2], divisions: 4}
measures: {t: {use: velocity_transmission, at_least: 0.4, at_most: 2.5}}
goals: {g: {minimise: "(x**2 - 0.49)**2 - 0.2 * x + leg", goal: 1, weight: 1}}
optimise: {starts: 12}
"""
"""The deeper well of x is on the right, the spec's start in the other; leg ends at its least."""


@pytest.fixture(scope="module")
def space(spec_of):
    return DesignSpace(spec_of(TWO_BASINS))


@pytest.fixture(scope="module")
def hunted(space):
    return hunt(space, Here())


def test_the_better_half_is_refined_and_the_best_places_solved(hunted):
    assert hunted.designs == 12
    assert len(hunted.begun) == 6
    assert len(hunted.solved) == min(hunted.distinct, KEPT)


def test_starts_that_lead_to_one_place_are_solved_once(hunted):
    assert hunted.distinct < len(hunted.begun)
    ends = [one.start.design for one in hunted.solved.values()]
    assert len(ends) == len({tuple(end) for end in ends})
    places = [begun.end.design for begun in hunting._clusters(list(hunted.begun.values()))]
    for k, place in enumerate(places):
        assert all(np.abs(place - other).max() > DISTINCT for other in places[:k])


def test_the_deeper_well_is_found_from_a_start_in_the_other(space, hunted):
    x = np.roots([4, 0, -1.96, -0.2]).real.max()
    values = space.values(hunted.best.end.design)
    assert values["x"] == pytest.approx(x, abs=1e-6)
    assert hunted.best.factor * hunted.best.unit == pytest.approx(
        (x * x - 0.49) ** 2 - 0.2 * x + 0.32 - 1, abs=1e-9
    )


def test_few_starts_are_all_refined(spec_of):
    space = DesignSpace(spec_of(TWO_BASINS, "optimise.starts=5"))
    found = hunt(space, Here())
    assert len(found.begun) == REFINED


def test_what_was_begun_goes_on_where_it_stopped(space):
    start = explore(space, Here())[0][0]
    begun = begin(space, start.place)
    found = finish(space, begun)
    assert found.start == start.place
    assert found.subproblems > begun.subproblems
    counts = [iterate.subproblems for iterate in found.iterates]
    assert found.iterates[: len(begun.iterates)] == begun.iterates
    assert counts == sorted(counts)
    assert found.factor <= begun.factor or begun.violation > 0


def test_stopped_while_starts_are_refined_the_best_of_these_is_kept(space, monkeypatch):
    done = hunting.counted

    def counted(workers, task, *given):
        for number, item in done(workers, task, *given):
            yield number, item
            if task is hunting.BEGIN and number == 2:
                raise KeyboardInterrupt

    monkeypatch.setattr(hunting, "counted", counted)
    found = hunt(space, Here())
    assert found.interrupted
    assert len(found.begun) == 3
    assert not found.solved
    assert not any(other.beats(found.best) for other in found.begun.values())

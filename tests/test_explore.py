"""Starts: the design space's ends, the low-discrepancy sequence, and starts that can always be evaluated."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from orthospec.optimise.explore import candidates, explore, start_at
from orthospec.optimise.place import fit_at
from orthospec.optimise.space import DesignSpace
from orthospec.optimise.workers import Here

SPEC = """\
orthospec: 1
variables:
  leg: {min: 100 mm, max: 500 mm, start: 400 mm}
  third: {min: 300 mm, max: 330 mm}
manipulator: {use: orthoglide, leg_lengths: [leg, leg, third]}
workspace: {size: [200 mm, 200 mm, 200 mm], divisions: 10}
measures: {transmission: {use: velocity_transmission, at_least: 0.5, at_most: 2}}
goals: {legs: {minimise: leg, goal: 300 mm}}
"""


@pytest.fixture(scope="module")
def space(spec_of):
    return DesignSpace(spec_of(SPEC))


def test_ends_of_the_ranges_are_exact(space):
    assert space.values(np.zeros(2)) == {"leg": 0.1, "third": 0.3}
    assert space.values(np.ones(2)) == {"leg": 0.5, "third": 0.33}


@given(z=st.tuples(st.floats(0, 1), st.floats(0, 1)))
def test_scaling_goes_there_and_back(space, z):
    values = space.values(np.array(z))
    assert 0.1 <= values["leg"] <= 0.5
    np.testing.assert_allclose(space.scaled(values), z, atol=1e-14)


def test_a_design_is_built_once(space):
    z = np.array([0.25, 0.5])
    assert space.design(z) is space.design(z.copy())
    assert space.machine(z).manipulator.leg_lengths == pytest.approx((0.2, 0.2, 0.315))
    assert list(space.machine(z).demands) == ["transmission"]


def test_the_specs_start_comes_first_then_as_many_designs_as_asked_for(space):
    found = list(candidates(space))
    assert len(found) == space.spec.optimise.starts
    np.testing.assert_allclose(found[0], [0.75, 0.5])
    assert all(((z >= 0) & (z <= 1)).all() for z in found)


def test_the_sequence_is_spread_out_and_depends_on_the_seed_alone(spec_of):
    def sequence(*settings):
        return np.array(list(candidates(DesignSpace(spec_of(SPEC, "optimise.starts=65", *settings)))))[1:]

    first = sequence()
    np.testing.assert_array_equal(first, sequence())
    assert not np.array_equal(first, sequence("optimise.seed=1"))
    for k in range(2):
        counts = np.histogram(first[:, k], bins=8, range=(0, 1))[0]
        assert counts.min() >= 5
        assert counts.max() <= 11
    cells = {tuple((4 * z).astype(int)) for z in first}
    assert len(cells) == 16


def test_starts_come_best_first_and_can_be_evaluated(space):
    starts, count = explore(space, Here())
    assert count == space.spec.optimise.starts
    assert 1 <= len(starts) <= count
    merits = [start.merit for start in starts]
    assert merits == sorted(merits)
    assert np.isfinite(merits).all()
    for start in starts:
        problem = fit_at(space, start.place).problem
        assert np.isfinite(problem.assess(problem.start).violation)


@pytest.mark.parametrize("z", [(0.0, 0.0), (0.1, 1.0)])
def test_where_the_prescribed_cuboid_leaves_the_reach_the_start_is_a_smaller_one(space, z):
    place = start_at(space, z).place
    problem = fit_at(space, place).problem
    (cuboid,) = problem.cuboids(problem.start)
    assert cuboid.size[0] < 0.2
    assert place.least_scale == 1.0
    assert problem.assess(problem.start).violation > 0.1


def test_where_it_fits_it_is_taken_as_it_is(space):
    place = start_at(space, (0.75, 0.5)).place
    (cuboid,) = place.cuboids(space).values()
    np.testing.assert_allclose(cuboid.size, [0.2] * 3, rtol=1e-12)
    assert place.scales is None


def test_a_design_that_cannot_be_built_is_no_start(spec_of):
    text = SPEC.replace("[leg, leg, third]", '[leg, leg, "leg - 0.3"]')
    space = DesignSpace(spec_of(text))
    assert start_at(space, (0.25, 0.5)) is None
    starts, _ = explore(space, Here())
    assert starts
    assert all(space.values(start.place.design)["leg"] > 0.3 for start in starts)


def test_nothing_reachable_in_the_region_is_no_start(spec_of):
    text = SPEC.replace("divisions: 10", "divisions: 10, region: {min: [5, 5, 5], max: [6, 6, 6]}")
    assert explore(DesignSpace(spec_of(text)), Here())[0] == []

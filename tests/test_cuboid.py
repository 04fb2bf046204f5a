"""The largest cuboid on a mask: place, ties and clusters against brute force."""

from __future__ import annotations

from fractions import Fraction
from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage

from orthospec.kernels import twin
from orthospec.workspace.cuboid import Cuboid, Placement, clusters, largest

seeds = st.integers(0, 2**32 - 1)
densities = st.sampled_from([0.3, 0.6, 0.8, 0.9, 0.97])


@st.composite
def masks(draw, d):
    shape = draw(st.tuples(*[st.integers(1, 6)] * d))
    return np.random.default_rng(draw(seeds)).random(shape) < draw(densities)


def all_cubes(mask):
    """Corners of the least indices of the largest cubes of ones, and their edge in nodes."""
    for edge in range(min(mask.shape), 0, -1):
        corners = [
            corner
            for corner in product(*[range(n - edge + 1) for n in mask.shape])
            if mask[tuple(slice(i, i + edge) for i in corner)].all()
        ]
        if corners:
            return edge, corners
    return 0, []


def by_brute_force(mask):
    """The placement rule as the words say it, in fractions."""
    edge, corners = all_cubes(mask)
    if not corners:
        return None
    mean = [Fraction(sum(c[k] for c in corners), len(corners)) for k in range(mask.ndim)]
    nearest = min(corners, key=lambda c: (sum((i - m) ** 2 for i, m in zip(c, mean, strict=True)), c))
    return Placement(edge - 1, nearest, len(corners))


@settings(max_examples=300, deadline=None)
@given(masks(3))
def test_placement_in_space_is_that_of_the_rule(mask):
    assert largest(mask) == by_brute_force(mask)


@settings(max_examples=300, deadline=None)
@given(masks(2))
def test_placement_in_the_plane_is_that_of_the_rule(mask):
    assert largest(mask) == by_brute_force(mask)


@pytest.mark.parametrize("shape", [(4, 5), (4, 5, 6)])
def test_nothing_one_node_and_everything(shape):
    mask = np.zeros(shape, dtype=bool)
    assert largest(mask) is None
    assert clusters(mask) == []
    mask[(1,) * len(shape)] = True
    assert largest(mask) == Placement(0, (1,) * len(shape), 1)
    mask[:] = True
    found = largest(mask)
    assert found.steps == 3
    assert found.ties == (2 if len(shape) == 2 else 2 * 3)


def test_equal_distances_go_to_the_first_in_c_order():
    mask = np.zeros((5, 5, 5), dtype=bool)
    for node in ((0, 2, 2), (4, 2, 2), (2, 0, 2), (2, 4, 2)):
        mask[node] = True
    assert largest(mask) == Placement(0, (0, 2, 2), 4)


def test_a_symmetric_tie_goes_to_the_middle():
    found = largest(np.ones((3, 7, 3), dtype=bool))
    assert found == Placement(2, (0, 2, 0), 5)


def test_many_ties_far_out_do_not_overflow():
    mask = np.zeros((2000, 2000), dtype=bool)
    mask[1999] = mask[0] = True
    found = largest(mask)
    assert found.ties == 4000
    assert found.corner in {(0, 999), (0, 1000)}


class TestClusters:
    def test_each_component_has_one_placement_the_largest_first(self):
        mask = np.zeros((20, 8, 8), dtype=bool)
        mask[0:4, 0:4, 0:4] = True
        mask[10:15, 1:6, 1:6] = True
        found = clusters(mask)
        assert found == [Placement(4, (10, 1, 1), 1), Placement(3, (0, 0, 0), 1)]

    def test_components_two_steps_smaller_are_left_out(self):
        mask = np.zeros((20, 8, 8), dtype=bool)
        mask[0:3, 0:3, 0:3] = True
        mask[10:15, 1:6, 1:6] = True
        assert clusters(mask) == [Placement(4, (10, 1, 1), 1)]

    @settings(max_examples=200, deadline=None)
    @given(masks(3))
    def test_are_the_components_of_all_ends_within_one_step_of_the_largest(self, mask):
        sizes = twin.cube_sizes(mask).astype(int)
        edge = sizes.max()
        labels, count = ndimage.label(sizes >= max(edge - 1, 1), structure=np.ones((3, 3, 3)))
        expected = set()
        for k in range(1, count + 1):
            steps = int(sizes[labels == k].max()) - 1
            corners = np.argwhere((labels == k) & (sizes == steps + 1)) - steps
            mean = [Fraction(int(total), len(corners)) for total in corners.sum(axis=0)]
            nearest = min(
                map(tuple, corners.tolist()),
                key=lambda c, mean=mean: (sum((i - m) ** 2 for i, m in zip(c, mean, strict=True)), c),
            )
            expected.add(Placement(steps, nearest, len(corners)))
        found = clusters(mask)
        assert set(found) == expected
        assert len(found) == count
        assert found == sorted(found, key=lambda one: (-one.steps, -one.ties, one.corner))


class TestCuboid:
    def test_around_a_centre(self):
        cuboid = Cuboid.around(np.array([1.0, 2.0, 3.0]), np.array([2.0, 4.0, 6.0]))
        assert cuboid == Cuboid((0.0, 0.0, 0.0), (2.0, 4.0, 6.0))
        np.testing.assert_array_equal(cuboid.centre, [1, 2, 3])
        np.testing.assert_array_equal(cuboid.size, [2, 4, 6])

    def test_poses_at_corners_and_with_further_coordinates(self):
        poses = Cuboid((0.0, 0.0), (2.0, 4.0)).poses(np.array([[-0.5, 0.5], [0.0, 0.0]]), 3)
        np.testing.assert_array_equal(poses, [[0, 4, 0], [1, 2, 0]])
        assert not poses.flags.writeable

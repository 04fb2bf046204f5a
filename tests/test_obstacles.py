"""Poses that no cuboid may hold leave out boxes of placements, and none in which a cuboid fits."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from orthospec.intervals import Boxes
from orthospec.workspace.obstacles import Obstacles


def outside(radius):
    """Whether poses lie outside a ball about the origin."""
    return lambda poses: np.linalg.norm(poses, axis=1) > radius


def boxes_within(half, count, size, seed):
    """Boxes of centres of many sizes, most of them smaller than the cuboid."""
    random = np.random.default_rng(seed)
    low = random.uniform(-half, half, (count, len(size)))
    return Boxes(low, low + size * 10 ** random.uniform(-3, 0, (count, 1)))


@given(
    st.lists(st.floats(0.05, 3.0), min_size=1, max_size=3).map(np.array),
    st.floats(0.3, 3.0),
    st.integers(0, 1000),
)
def test_no_box_is_left_out_in_which_a_cuboid_fits(size, radius, seed):
    fails = outside(radius)
    obstacles = Obstacles(size, fails, fails)
    boxes = boxes_within(2 * radius, 200, size, seed)
    left = {tuple(low) for low in obstacles.leave(boxes).lo}
    for low, high in zip(boxes.lo, boxes.hi, strict=True):
        if tuple(low) not in left:
            nearest = np.clip(0.0, low, high)
            corner = np.abs(nearest) + size / 2
            assert np.linalg.norm(corner) > radius


def test_few_are_left_where_cuboids_are_too_large_by_far():
    size = np.array([1.0, 1.0, 0.1])
    obstacles = Obstacles(size, outside(0.6), outside(0.6))
    edges = np.linspace(-0.6, 0.6, 17)
    low = np.stack(np.meshgrid(edges, edges, edges), axis=-1).reshape(-1, 3)
    boxes = Boxes(low, low + 0.02)
    assert len(obstacles.leave(boxes)) < 0.02 * len(boxes)


def test_what_only_seems_to_fail_leaves_out_nothing():
    boxes = boxes_within(1.0, 500, np.ones(3), 0)
    seeming = Obstacles(np.ones(3), outside(0.1), lambda poses: np.zeros(len(poses), dtype=bool))
    assert len(seeming.leave(boxes)) == len(boxes)


@pytest.mark.parametrize("at", [0.25, 0.1])
def test_a_pose_on_the_face_of_a_cuboid_is_not_held_for_certain(at):
    """The box's last cuboid ends where the pose is: rounding may have it beyond."""
    size, pose = np.ones(1), np.array([[at]])
    obstacles = Obstacles(size, outside(0.0), outside(0.0))
    touching = Boxes(pose - 0.5, pose)
    assert not obstacles._hold_one_of(pose, touching).any()
    assert obstacles._hold_one_of(pose, Boxes(pose - 0.49, pose)).all()

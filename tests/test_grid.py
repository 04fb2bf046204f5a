"""The grid: whole multiples of the step within the region; the box around a machine's reach."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from orthospec.errors import UsageError
from orthospec.manipulators import Manipulator
from orthospec.manipulators.linear_delta import LinearDelta
from orthospec.manipulators.orthoglide import Orthoglide
from orthospec.workspace.cuboid import Cuboid, Placement
from orthospec.workspace.grid import Grid, make_grid, reach_box

UNIT = Orthoglide(leg_lengths=(1.0, 1.0, 1.0))


class Everywhere(Manipulator):
    """A machine that reaches every pose, or none."""

    joint_units: ClassVar[tuple[str, ...]] = ("m", "m", "m")
    nowhere: bool = False

    def inverse_kinematics(self, poses):
        return poses.copy(), np.full(len(poses), not self.nowhere)

    def reach(self, poses):
        return {"all": np.full(len(poses), -1.0 if self.nowhere else 1.0)}

    def inverse_jacobian(self, poses):
        return np.tile(np.eye(3), (len(poses), 1, 1))

    def indices(self, joint_ranges):  # noqa: ARG002
        return {}

    def skeleton(self, poses):  # noqa: ARG002
        pytest.fail("nothing here draws the machine")


class Plate(Everywhere):
    """A machine that reaches the poses of a plate."""

    def inverse_kinematics(self, poses):
        return poses.copy(), (np.abs(poses) <= HALF_PLATE).all(axis=1)


HALF_PLATE = np.array([0.9, 0.7, 0.001])


@settings(deadline=None)
@given(
    st.tuples(*[st.floats(0.05, 3.0)] * 3),
    st.integers(1, 12),
    st.tuples(*[st.floats(-2.0, 0.0)] * 3),
    st.tuples(*[st.floats(0.0, 2.0)] * 3),
)
def test_nodes_are_all_whole_multiples_of_the_step_within_the_region(size, divisions, low, high):
    step = np.array(size) / divisions
    region = Cuboid(low, tuple(h + 1.01 * s for h, s in zip(high, step, strict=True)))
    grid = make_grid(UNIT, np.array(size), divisions, region)
    ends = grid.poses(0, 1)[0], grid.poses(grid.nodes - 1, grid.nodes)[0]
    for k in range(3):
        nodes = (grid.first[k] + np.arange(grid.shape[k])) * step[k]
        assert (nodes >= region.low[k] - 1e-8 * step[k]).all()
        assert (nodes <= region.high[k] + 1e-8 * step[k]).all()
        assert nodes[0] - step[k] < region.low[k]
        assert nodes[-1] + step[k] > region.high[k]
        assert ends[0][k] == nodes[0]
        assert ends[1][k] == nodes[-1]


def test_a_region_that_ends_on_nodes_keeps_them():
    """0.1·3 is not 0.3: the last bit must not lose a layer of nodes."""
    grid = make_grid(UNIT, np.full(3, 0.8), 8, Cuboid((-0.3,) * 3, (0.7,) * 3))
    assert grid.shape == (11, 11, 11)
    assert grid.first == (-3, -3, -3)


def test_poses_run_in_c_order_and_are_read_only():
    grid = Grid((0.1, 0.2, 0.5), (-1, 0, 2), (2, 3, 2), 3)
    assert grid.nodes == 12
    expected = [((i - 1) * 0.1, j * 0.2, (k + 2) * 0.5) for i in range(2) for j in range(3) for k in range(2)]
    poses = np.vstack([grid.poses(0, 5), grid.poses(5, 100)])
    np.testing.assert_allclose(poses, expected, rtol=1e-15)
    assert not grid.poses(0, 5).flags.writeable


def test_coordinates_beyond_the_grids_axes_are_zero():
    poses = Grid((0.1, 0.1), (1, 1), (2, 2), 3).poses(0, 4)
    assert poses.shape == (4, 3)
    np.testing.assert_array_equal(poses[:, 2], np.zeros(4))


def test_a_placement_spans_its_cuboid():
    cuboid = Grid((0.1, 0.1, 0.2), (-3, -3, -3), (9, 9, 9), 3).cuboid(Placement(4, (1, 2, 3), 1))
    np.testing.assert_allclose(cuboid.low, [-0.2, -0.1, 0.0], atol=1e-15)
    np.testing.assert_allclose(cuboid.high, [0.2, 0.3, 0.8], atol=1e-15)


def test_a_region_between_two_nodes_is_refused():
    with pytest.raises(UsageError, match=r"no node.*workspace\.region"):
        make_grid(UNIT, np.ones(3), 10, Cuboid((0.01,) * 3, (0.09,) * 3))


def test_too_many_nodes_are_refused_before_they_are_made():
    with pytest.raises(UsageError, match="divisions"):
        make_grid(UNIT, np.ones(3), 2000, Cuboid((-1.0,) * 3, (1.0,) * 3))


@pytest.mark.parametrize("lengths", [(1.0, 1.0, 1.0), (0.3, 0.4, 0.5), (25.0, 3.0, 14.0)])
@pytest.mark.parametrize("size", [(0.01, 0.01, 0.01), (1.0, 1.0, 0.8), (40.0, 40.0, 10.0)])
def test_reach_box_contains_the_reach(lengths, size):
    machine = Orthoglide(leg_lengths=lengths)
    box = reach_box(machine, np.array(size))
    poses = np.random.default_rng(0).uniform(-1.0, 1.0, (50_000, 3)) * max(lengths)
    reached = poses[machine.inverse_kinematics(poses)[1]]
    assert len(reached) > 100
    assert (reached >= box.low).all()
    assert (reached <= box.high).all()
    assert (box.size <= 2.6 * max(lengths)).all()


LIMITED = Orthoglide(
    leg_lengths=(1.0, 1.0, 1.0), joint_limits={"min": (1.05, 1.05, 0.5), "max": (1.4, 1.4, 1.5)}
)
HIGH_UP = LinearDelta(
    leg_lengths=(0.5, 0.5, 0.5),
    base_radius=0.3,
    platform_radius=0.05,
    joint_limits={"min": 1.5, "max": 2.0},
)


@pytest.mark.parametrize("machine", [UNIT, LIMITED, HIGH_UP], ids=["orthoglide", "limited", "delta"])
@pytest.mark.parametrize("size", [(0.2, 0.2, 0.02), (0.02, 0.2, 0.2), (0.2, 0.2, 2e-4), (2e-3, 2e-3, 0.5)])
def test_reach_box_fits_the_reach_whatever_the_cuboids_proportions(machine, size):
    """No reachable pose is outside it, though it is hardly larger than the poses that were found."""
    box = reach_box(machine, np.array(size))
    around = Cuboid.around(box.centre, 1.5 * box.size)
    poses = around.poses(np.random.default_rng(0).uniform(-0.5, 0.5, (100_000, 3)), 3)
    reached = poses[machine.inverse_kinematics(poses)[1]]
    assert (reached >= box.low).all()
    assert (reached <= box.high).all()
    assert (box.size <= 1.2 * np.ptp(reached, axis=0)).all()


def test_a_reach_much_flatter_than_the_cuboid_is_fitted_along_each_axis():
    box = reach_box(Plate(), np.full(3, 0.2))
    assert (box.low <= -HALF_PLATE).all()
    assert (box.high >= HALF_PLATE).all()
    assert (box.size <= 2.4 * HALF_PLATE).all()


@pytest.mark.parametrize("nowhere", [False, True])
def test_a_reach_without_end_or_beginning_asks_for_a_region(nowhere):
    with pytest.raises(UsageError, match=r"workspace\.region"):
        make_grid(Everywhere(nowhere=nowhere), np.ones(3), 10, None)


def test_with_a_region_a_machine_without_end_is_no_trouble():
    grid = make_grid(Everywhere(), np.ones(3), 10, Cuboid((-1.0,) * 3, (1.0,) * 3))
    assert grid.shape == (21, 21, 21)

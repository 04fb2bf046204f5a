"""Polish against closed forms: the largest cubes, grown and shrunk, held by poses of all sorts."""

from __future__ import annotations

import numpy as np
import pytest

from orthospec.manipulators.orthoglide import Orthoglide
from orthospec.measures import Demand
from orthospec.measures.kinematic import ConditionNumber, Manipulability, VelocityTransmission
from orthospec.workspace.critical import lattice
from orthospec.workspace.cuboid import Cuboid
from orthospec.workspace.evaluate import Setting, evaluate
from orthospec.workspace.fit import Machine
from orthospec.workspace.polish import polish

CUBE = np.ones(3)
START = Cuboid((-0.3, -0.3, -0.3), (0.1, 0.1, 0.1))


def machine(*demands, lengths=(1.0, 1.0, 1.0), **keys):
    return Machine(Orthoglide(leg_lengths=lengths, **keys), {demand.name: demand for demand in demands})


def transmission(ratio=2.0):
    return Demand("transmission", VelocityTransmission(), {"at_least": 1 / ratio, "at_most": ratio})


def condition(most):
    return Demand("condition", ConditionNumber(), {"at_most": most})


def polished(machine, size=CUBE, start=START, region=None):
    return polish(machine, list(machine.demands), np.asarray(size, dtype=float), [start], region)


def side(v, u):
    """Side of the cube over L whose corners have these q / sqrt(L² − 2q²) on the diagonal."""
    return v / np.sqrt(1 + 2 * v * v) + u / np.sqrt(1 + 2 * u * u)


@pytest.mark.parametrize(
    ("ratio", "known"), [(1.5, 0.397924), (2.0, 0.643951), (2.5, 0.733668), (3.0, 0.786583)]
)
def test_cube_of_transmission_factors_within_1_over_r_and_r(ratio, known):
    """σ are 1/|1 − 2u| and 1/|1 + u|: the lower corner ends where either factor does."""
    expected = side(min((ratio - 1) / 2, 1 - 1 / ratio), min((1 - 1 / ratio) / 2, ratio - 1))
    assert expected == pytest.approx(known, abs=5e-7)
    found = polished(machine(transmission(ratio)))
    assert found.scale == pytest.approx(expected, abs=1e-8)


@pytest.mark.parametrize(("most", "known"), [(2, 0.428152), (3, 0.613062), (4, 0.709760), (1000, 0.984612)])
def test_cube_of_condition_numbers_up_to_k(most, known):
    expected = side((most - 1) / (most + 2), (most - 1) / (2 * most + 1))
    assert expected == pytest.approx(known, abs=5e-7)
    found = polished(machine(condition(float(most))))
    assert found.scale == pytest.approx(expected, abs=1e-8)


def test_cube_of_the_reach_alone_ends_at_both_parallel_singularities():
    """u = −1, where the three sliders meet, and u = 1/2."""
    found = polished(machine())
    assert found.scale == pytest.approx(1 / np.sqrt(3) + 1 / np.sqrt(6), abs=1e-6)


def test_cuboid_of_unequal_legs():
    found = polished(machine(transmission(), lengths=(1.5, 1.4, 1.7)), size=(1, 1, 0.8))
    assert found.scale == pytest.approx(1.0399891635, abs=1e-8)


def test_least_equal_legs_hold_the_flat_cuboid_exactly():
    found = polished(machine(transmission(), lengths=(1.4475348021,) * 3), size=(1, 1, 0.8))
    assert found.scale == pytest.approx(1.0, abs=1e-8)


def test_cube_held_by_a_pose_inside_a_face():
    """Slides that end at 370 mm: x + sqrt(L² − y² − z²) is greatest at y = z = 0."""
    held = machine(transmission(), lengths=(0.33,) * 3, joint_limits={"max": 0.37})
    found = polished(held, start=Cuboid((-0.1,) * 3, (0.02,) * 3))
    assert found.scale == pytest.approx(0.04 + 0.33 / np.sqrt(6), abs=1e-9)
    np.testing.assert_allclose(found.cuboid.low, [-0.13472194] * 3, atol=1e-8)
    np.testing.assert_allclose(found.cuboid.high, [0.04] * 3, atol=1e-9)
    margins = held.manipulator.reach(np.array([[0.04, 0.0, 0.0], [0.04, 0.04, 0.04]]))
    np.testing.assert_allclose(margins["joint_limits.0.at_most"][0], 0.0, atol=1e-9)
    assert margins["joint_limits.0.at_most"][1] > 0.01


def test_two_measures_together_hold_one_corner_each():
    found = polished(machine(transmission(), condition(3.0)))
    assert found.scale == pytest.approx(0.5838576, abs=5e-8)
    np.testing.assert_allclose(found.cuboid.low, [-0.3481553] * 3, atol=5e-8)
    np.testing.assert_allclose(found.cuboid.high, [0.2357023] * 3, atol=5e-8)


def test_each_way_of_asking_finds_the_same_cube():
    """The branch mirrors the machine, and its cube with it."""
    found = polished(
        machine(transmission(), branch=(-1, 1, -1)), start=Cuboid((-0.1, -0.3, -0.1), (0.3, 0.1, 0.3))
    )
    assert found.scale == pytest.approx(side(0.5, 0.25), abs=1e-8)
    np.testing.assert_allclose(found.cuboid.centre * [-1, 1, -1], [-0.0862730] * 3, atol=1e-7)


@pytest.mark.parametrize(
    "start",
    [
        Cuboid((-0.1,) * 3, (-0.1,) * 3),
        Cuboid((0.2,) * 3, (0.2,) * 3),
        Cuboid((-0.45,) * 3, (0.3,) * 3),
        Cuboid((-0.6,) * 3, (0.35,) * 3),
        Cuboid((-0.5, -0.2, 0.1), (-0.3, 0.0, 0.3)),
    ],
    ids=["from one node", "from a node near the end", "from too large", "from much too large", "from aside"],
)
def test_the_same_cube_is_found(start):
    found = polished(machine(transmission()), start=start)
    assert found.scale == pytest.approx(side(0.5, 0.25), abs=1e-7)


def test_a_cube_with_a_singular_pose_inside_shrinks_out_of_it():
    found = polished(machine(condition(100.0)), start=Cuboid((-0.6,) * 3, (0.4,) * 3))
    assert found.scale == pytest.approx(side(99 / 102, 99 / 201), abs=1e-7)


def test_the_region_is_respected():
    region = Cuboid((-0.2, -1.0, -1.0), (0.25, 1.0, 1.0))
    found = polished(machine(transmission()), start=Cuboid((-0.1,) * 3, (0.1,) * 3), region=region)
    assert found.scale == pytest.approx(0.45, abs=1e-9)
    assert found.cuboid.low[0] >= -0.2 - 1e-9
    assert found.cuboid.high[0] <= 0.25 + 1e-9


def test_the_best_of_several_starts_is_kept():
    far = Cuboid((0.22,) * 3, (0.23,) * 3)
    held = machine(transmission())
    assert polish(held, ["transmission"], CUBE, [far, START]).scale == pytest.approx(0.6439505509, abs=1e-8)
    assert polish(held, ["transmission"], CUBE, []) is None


def test_no_place_at_all_gives_none():
    hopeless = Demand("t", VelocityTransmission(), {"at_least": 5.0})
    assert polished(machine(hopeless)) is None


@pytest.mark.parametrize("least", [0.5, 0.9])
def test_manipulability_holds_on_a_fine_lattice_and_could_not_grow(least):
    held = machine(Demand("w", Manipulability(), {"at_least": least}))
    found = polished(held)
    axis = np.linspace(-0.5, 0.5, 41)
    u = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), axis=-1).reshape(-1, 3)
    values = Manipulability().values(held.manipulator, found.cuboid.poses(u, 3))
    assert values.min() >= least * (1 - 1e-8)
    for place in np.random.default_rng(0).uniform(-0.01, 0.01, (30, 3)):
        larger = Cuboid.around(found.cuboid.centre + place, 1.001 * found.cuboid.size)
        poses = larger.poses(u, 3)
        reached = held.manipulator.inverse_kinematics(poses)[1]
        assert not reached.all() or Manipulability().values(held.manipulator, poses).min() < least


@pytest.mark.parametrize("divisions", [10, 40])
def test_what_stops_a_hair_beyond_a_bound_is_not_lost(divisions):
    """Next to a singular corner the derivatives leave the reach; the grid's own cuboid has scale 1."""
    slow = machine(Demand("it", VelocityTransmission(), {"at_least": 0.65}), lengths=(1.4475348,) * 3)
    found = evaluate(slow, Setting(np.array([1.0, 1.0, 0.8]), divisions)).joint
    assert found.scale == pytest.approx(1.02399727, rel=1e-7)
    corners = found.cuboid.poses(lattice(2, 3), 3)
    slowest = VelocityTransmission().values(slow.manipulator, corners)[:, 0].min()
    assert slowest == pytest.approx(0.65, rel=1e-6)

"""One design evaluated: grid and polished cuboids, levels, poses, extremes, places, failures."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np
import pytest
from scipy.optimize import brentq

from orthospec.errors import PluginFault, UsageError
from orthospec.manipulators.orthoglide import Orthoglide
from orthospec.measures import Demand, Level, Measure
from orthospec.measures.kinematic import ConditionNumber, Manipulability, VelocityTransmission
from orthospec.workspace.cuboid import Cuboid
from orthospec.workspace.evaluate import Setting, evaluate
from orthospec.workspace.fit import Machine

LEG = 0.2 / (1 / np.sqrt(6) + 1 / np.sqrt(18))
CORNERS = (-LEG / np.sqrt(6), LEG / np.sqrt(18))
BOUNDS = {"at_least": 0.5, "at_most": 2.0}


class Scripted(Measure):
    """A stranger's measure: numbers alone."""

    unit: ClassVar[str] = "m"
    sides: ClassVar[frozenset[str]] = frozenset({"at_least", "at_most"})
    act: Any = None

    def values(self, manipulator, poses):  # noqa: ARG002
        return self.act(poses)


def norms(poses):
    return np.linalg.norm(poses, axis=1)


def machine_of(*demands, leg=LEG, **keys):
    return Machine(Orthoglide(leg_lengths=(leg,) * 3, **keys), {demand.name: demand for demand in demands})


def transmission(*levels):
    return Demand("transmission", VelocityTransmission(), BOUNDS, tuple(Level(level) for level in levels))


def setting(divisions=10, size=0.2, **keys):
    return Setting(np.full(3, size), divisions, **keys)


@pytest.mark.parametrize(("divisions", "grid_scale", "ties"), [(20, 0.95, 46), (40, 0.975, 25)])
def test_grid_scale_ties_and_polished_scale_of_the_exact_orthoglide(divisions, grid_scale, ties):
    found = evaluate(machine_of(transmission()), setting(divisions)).joint
    assert found.grid_scale == grid_scale
    assert found.ties == ties
    assert found.scale == pytest.approx(1.0, abs=1e-9)
    np.testing.assert_allclose(found.cuboid.low, [CORNERS[0]] * 3, atol=1e-9)
    np.testing.assert_allclose(found.cuboid.high, [CORNERS[1]] * 3, atol=1e-9)


def test_eighty_divisions_still_miss_one_step():
    region = Cuboid((-0.16,) * 3, (0.11,) * 3)
    found = evaluate(machine_of(transmission()), setting(80, region=region)).joint
    assert found.grid_scale == 0.9875
    assert found.ties == 25
    assert found.scale == pytest.approx(1.0, abs=1e-9)


@pytest.fixture(scope="module")
def evaluation():
    """The exact Orthoglide with a second measure, a level each way and named poses."""
    demands = (
        transmission({"at_most": 1.5}, {"at_least": 0.8, "at_most": 1.25}),
        Demand("condition", ConditionNumber(), {"at_most": 3.0}),
        Demand("volume", Manipulability(), {}),
    )
    poses = {"home": (0.0, 0.0, 0.0), "away": (9.0, 0.0, 0.0), "corner": (CORNERS[1],) * 3}
    return evaluate(machine_of(*demands), setting(poses=poses))


class TestEvaluation:
    def test_each_measure_has_its_own_largest_cuboid_and_the_joint_one_is_less(self, evaluation):
        scales = {
            name: record.largest and record.largest.scale for name, record in evaluation.measures.items()
        }
        assert scales["transmission"] == pytest.approx(1.0, abs=1e-9)
        assert scales["condition"] == pytest.approx(0.6130618 * LEG / 0.2, abs=1e-6)
        assert scales["volume"] is None
        assert evaluation.joint.scale == pytest.approx(0.5838576 * LEG / 0.2, abs=1e-6)

    def test_levels_have_cuboids_of_their_own(self, evaluation):
        levels = evaluation.measures["transmission"].levels
        assert [dict(level.bounds) for level, _ in levels] == [
            {"at_most": 1.5},
            {"at_least": 0.8, "at_most": 1.25},
        ]
        for (_, found), (least, most) in zip(levels, [(0.0, 1.5), (0.8, 1.25)], strict=True):
            v = min(1 - 1 / most, (1 / least - 1) / 2 if least else np.inf)
            u = min((1 - 1 / most) / 2, 1 / least - 1 if least else np.inf)
            expected = v / np.sqrt(1 + 2 * v * v) + u / np.sqrt(1 + 2 * u * u)
            assert found.scale == pytest.approx(expected * LEG / 0.2, abs=1e-8)

    def test_nodes_are_counted_by_state(self, evaluation):
        one, other = evaluation.joint.nodes, evaluation.measures["condition"].largest.nodes
        assert one.keys() == {"meets", "violates", "unreachable", "failed"}
        assert sum(one.values()) == sum(other.values())
        assert one["unreachable"] == other["unreachable"]
        assert one["failed"] == 0
        assert one["meets"] < other["meets"]

    def test_named_poses_are_measured_where_they_are_reachable(self, evaluation):
        poses = evaluation.measures["transmission"].poses
        assert poses["home"] == (1.0, 1.0)
        assert poses["away"] is None
        np.testing.assert_allclose(poses["corner"], [0.8, 2.0], rtol=1e-9)
        assert evaluation.measures["volume"].poses["home"] == (1.0,)

    def test_without_a_place_the_prescribed_cuboid_is_centred_on_the_joint_one(self, evaluation):
        centre = np.mean([-0.3481553 * LEG, 0.2357023 * LEG])
        np.testing.assert_allclose(evaluation.prescribed.cuboid.low, [centre - 0.1] * 3, atol=1e-7)
        assert not evaluation.prescribed.holds
        assert not evaluation.holds

    def test_extremes_are_those_over_the_prescribed_cuboid(self, evaluation):
        low, high = evaluation.prescribed.cuboid.low[0], evaluation.prescribed.cuboid.high[0]
        record = evaluation.measures["condition"]
        u = high / np.sqrt(LEG**2 - 2 * high**2)
        v = -low / np.sqrt(LEG**2 - 2 * low**2)
        expected = max((1 + u) / (1 - 2 * u), (1 + 2 * v) / (1 - v))
        assert record.highest.value == pytest.approx(expected, rel=1e-8)
        assert record.lowest.value == pytest.approx(1.0, abs=1e-6)
        np.testing.assert_allclose(record.lowest.at, [0.0] * 3, atol=1e-5)


def test_joint_ranges_are_those_of_the_corners():
    """The 200 mm cube: slider range 126.795 ... 383.788 mm, stroke 256.993 mm."""
    place = Cuboid((CORNERS[0],) * 3, (CORNERS[1],) * 3)
    found = evaluate(machine_of(transmission()), setting(), {"": place})
    assert found.holds
    assert found.prescribed.violation <= 1e-9
    np.testing.assert_allclose(found.joints, [[0.126794919, 0.383788]] * 3, atol=5e-7)
    assert found.indices["stroke"] == pytest.approx(0.256993, abs=5e-7)
    assert found.indices["footprint"] == pytest.approx(0.383788**2, abs=1e-6)
    assert found.measures["transmission"].lowest.value == pytest.approx(0.5, rel=1e-9)
    assert found.measures["transmission"].highest.value == pytest.approx(2.0, rel=1e-9)


def test_greatest_joint_value_may_stand_inside_a_face():
    place = Cuboid((-0.1,) * 3, (0.04,) * 3)
    found = evaluate(machine_of(transmission(), leg=0.33), setting(), {"": place})
    assert found.joints[0, 1] == pytest.approx(0.37, abs=1e-9)


def test_prescribed_cuboid_beyond_the_reach_has_no_extremes_and_no_stroke():
    found = evaluate(machine_of(transmission()), setting(), {"": Cuboid((0.1,) * 3, (0.3,) * 3)})
    assert not found.prescribed.reached
    assert not found.holds
    assert found.measures["transmission"].lowest is None
    assert found.measures["transmission"].highest is None
    assert found.joints is None
    assert np.isnan(found.indices["stroke"])
    assert found.indices["leg_length_total"] == pytest.approx(3 * LEG)


def test_apart_each_measure_has_its_own_prescribed_cuboid():
    demands = (transmission(), Demand("condition", ConditionNumber(), {"at_most": 3.0}))
    found = evaluate(machine_of(*demands), setting(together=False))
    assert found.joint is None
    assert found.prescribed is None
    assert found.measures["transmission"].prescribed.holds
    assert not found.measures["condition"].prescribed.holds
    assert not found.holds


def test_without_measures_the_reach_alone_is_measured():
    found = evaluate(machine_of(leg=1.0), setting(size=0.9))
    assert found.joint.scale * 0.9 == pytest.approx(1 / np.sqrt(3) + 1 / np.sqrt(6), abs=1e-6)
    assert found.measures == {}
    assert found.holds


def test_levels_alone_leave_the_joint_cuboid_to_the_reach():
    levels = (Level({"at_most": 1.2}), Level({"at_most": 1.5}))
    found = evaluate(machine_of(Demand("t", VelocityTransmission(), {}, levels), leg=1.0), setting(size=0.9))
    assert found.joint.scale * 0.9 == pytest.approx(1 / np.sqrt(3) + 1 / np.sqrt(6), abs=1e-6)
    nested = [largest.scale for _, largest in found.measures["t"].levels]
    assert nested[0] < nested[1] < found.joint.scale


def test_no_place_where_the_bounds_hold_is_an_answer():
    hopeless = Demand("t", VelocityTransmission(), {"at_least": 5.0})
    found = evaluate(machine_of(hopeless), setting())
    assert (found.joint.scale, found.joint.grid_scale, found.joint.ties) == (0.0, 0.0, 0)
    assert found.joint.cuboid is None
    assert found.prescribed is None
    assert not found.holds


def test_a_single_node_is_a_point():
    """Only the isotropic pose meets κ <= 1."""
    found = evaluate(machine_of(Demand("c", ConditionNumber(), {"at_most": 1.0})), setting())
    assert found.joint.grid_scale == 0.0
    assert found.joint.ties == 1
    assert found.joint.nodes["meets"] == 1
    assert found.joint.scale == pytest.approx(0.0, abs=1e-6)


def test_a_failed_node_is_told_with_its_pose_and_shrinks_the_cuboid():
    """NaN at the isotropic pose, which a symmetric grid always has."""

    def broken(poses):
        return np.where(norms(poses) < 1e-9, np.nan, norms(poses))

    demand = Demand("mine", Scripted(act=broken), {"at_most": 0.1}, place="s.yaml:4:3")
    found = evaluate(machine_of(demand), setting())
    (failure,) = found.failures
    assert (failure.measure, failure.pose, failure.place) == ("mine", (0.0, 0.0, 0.0), "s.yaml:4:3")
    assert found.joint.nodes["failed"] == 1


def test_a_measure_of_numbers_alone_has_its_cuboid_polished():
    found = evaluate(machine_of(Demand("mine", Scripted(act=norms), {"at_most": 0.1})), setting())
    assert found.joint.scale * 0.2 == pytest.approx(0.2 / np.sqrt(3), abs=1e-9)


def test_a_measure_that_raises_is_the_plugins_fault():
    def raising(_):
        raise ValueError("no")

    with pytest.raises(PluginFault, match="no"):
        evaluate(machine_of(Demand("mine", Scripted(act=raising), {"at_most": 1.0})), setting())


def test_a_region_bounds_grid_and_polish():
    region = Cuboid((-0.05, -0.2, -0.2), (0.06, 0.2, 0.2))
    found = evaluate(machine_of(transmission()), setting(region=region))
    assert found.joint.grid_scale == pytest.approx(0.5)
    assert found.joint.scale == pytest.approx(0.55, abs=1e-9)


def test_a_region_without_a_node_is_wrong_use():
    with pytest.raises(UsageError, match=r"workspace\.region"):
        evaluate(machine_of(transmission()), setting(region=Cuboid((0.001,) * 3, (0.002,) * 3)))


def test_two_axes_have_a_square():
    """The machine moved in the plane z = 0: a factor reaches 2 at two opposed corners (c, c).

    J⁻¹ is [[1, t, 0], [t, 1, 0], [v, v, 1]] there, with t = −c / sqrt(L² − c²) and v = −c / sqrt(L² − 2c²).
    Its singular values are 1 − t, least for c < 0, and those of [[1 + t, 0], [√2 v, 1]].
    """

    def least(c):
        t, v = -c / np.sqrt(LEG**2 - c**2), -c / np.sqrt(LEG**2 - 2 * c**2)
        return np.linalg.svd([[1 + t, 0], [np.sqrt(2) * v, 1]], compute_uv=False)[-1]

    edge = LEG / np.sqrt(5) + brentq(lambda c: least(c) - 0.5, 0.0, 0.6 * LEG, xtol=1e-15)
    found = evaluate(machine_of(transmission()), Setting(np.full(2, 0.2), 10)).joint
    assert found.scale * 0.2 == pytest.approx(edge, abs=1e-9)
    assert found.cuboid.size == pytest.approx([edge] * 2, abs=1e-9)
    assert found.grid_scale == 1.2


def test_of_clusters_that_tie_on_the_grid_each_one_is_polished():
    """A square, and about it a ring of channels that are wider by less than a step of the grid.

    The mean of all placements is in the middle of the square, which is one placement alone.
    """

    def square_in_a_ring(poses):
        r = np.abs(poses[:, :2]).max(axis=1)
        return np.minimum(r - 0.1, np.abs(r - 0.3) - 0.145)

    demand = Demand("mine", Scripted(act=square_in_a_ring), {"at_most": 0.0})
    flat = Setting(np.full(2, 0.2), 4, Cuboid((-0.5,) * 2, (0.5,) * 2))
    found = evaluate(machine_of(demand, leg=1.0), flat).joint
    assert (found.grid_scale, found.ties) == (1.0, 49)
    assert found.scale * 0.2 == pytest.approx(0.29, abs=1e-9)


def test_progress_is_told():
    told = []
    evaluate(machine_of(transmission()), setting(), progress=lambda *step: told.append(step))
    assert told[-1][1] == told[-1][2] > 0


@pytest.mark.parametrize(("size", "scale"), [(0.05, 0.25), (0.2, 1.0), (0.2 - 1e-12, 1.0)])
def test_a_cuboid_that_is_not_of_the_prescribed_size_has_its_scale(size, scale):
    place = {"": Cuboid.around(np.zeros(3), np.full(3, size))}
    assert evaluate(machine_of(transmission()), setting(), place).prescribed.scale == pytest.approx(scale)

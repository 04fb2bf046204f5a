"""Machines within tolerances: none of them escapes what is computed of all of them together."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from orthospec.intervals import Boxes
from orthospec.manipulators.linear_delta import LinearDelta
from orthospec.manipulators.orthoglide import Orthoglide
from orthospec.measures.dynamic import (
    Acceleration,
    ActuatorForce,
    DynamicIsotropy,
    GieNorm,
    JointSpeed,
    ToolSpeed,
)
from orthospec.measures.elastic import Deflection, Rotation, Stiffness
from orthospec.measures.kinematic import ConditionNumber, Manipulability, VelocityTransmission
from orthospec.workspace.cuboid import Cuboid
from orthospec.workspace.tolerances import Family

BAR = {
    "section": {"given": {"A": 1.6e-4, "Iy": 9.0e-9, "Iz": 5.0e-9, "J": 1.1e-8}},
    "material": {"E": 7.0e10, "nu": 0.33, "density": 2700.0},
}
PUU, PRPAR = {"kind": "PUU", **BAR}, {"kind": "PRPaR", "spacing": 0.08, **BAR}
PARTS = {
    "actuators": {"stiffness": 2e7, "mass": 1.7, "force": 500.0, "speed": 2.0, "friction": 10.0},
    "platform": {"mass": 0.8},
    "gravity": (1.5, -2.0, -9.5),
    "feet": {
        "length": 0.08,
        "section": {"rectangle": {"height": 0.03, "width": 0.02}},
        "material": {"E": 2.1e11, "G": 8.1e10},
        "mass": 0.4,
    },
}
DELTA = {"base_radius": 0.25, "platform_radius": 0.06, **PARTS}
UNEQUAL = {"leg_lengths": (0.31, 0.33, 0.36), **PARTS}
GIVEN = {"section": {"compliance": np.diag([1e-8, 1e-6, 1e-6, 1e-3, 1e-4, 1e-4]).tolist()}, "mass": 0.2}
MACHINES = {
    "puu": Orthoglide(legs={**PUU, "offset": 0.03}, **UNEQUAL),
    "prpar": Orthoglide(branch=(1, -1, 1), legs=PRPAR, joint_limits={"min": -0.4, "max": 0.4}, **UNEQUAL),
    "rigid": Orthoglide(legs={"section": "rigid", "mass": 0.1}, **{**UNEQUAL, "feet": "rigid"}),
    "given": Orthoglide(legs=GIVEN, **UNEQUAL),
    "delta": LinearDelta(leg_lengths=(0.4, 0.43, 0.38), rail_tilt=0.25, legs=PUU, **DELTA),
    "delta_prpar": LinearDelta(leg_lengths=(0.4,) * 3, legs=PRPAR, **DELTA),
}
MEASURES = {
    "transmission": VelocityTransmission(),
    "condition": ConditionNumber(),
    "manipulability": Manipulability(),
    "deflection": Deflection(force=50),
    "deflection of a wrench": Deflection(wrench=(10.0, -20.0, 30.0, 1.0, 2.0, -3.0)),
    "rotation": Rotation(torque=2),
    "rotation by a force": Rotation(force=20),
    "stiffness": Stiffness(),
    "gie": GieNorm(),
    "isotropy": DynamicIsotropy(),
    "acceleration": Acceleration(),
    "joint speed": JointSpeed(speed=1.5),
    "tool speed": ToolSpeed(),
    "actuator force": ActuatorForce(acceleration=10, speed=1),
}
OFF = {"leg_lengths": 3e-4, "base_radius": 2e-4, "platform_radius": 1e-4}


def family_of(name):
    nominal = MACHINES[name]
    return Family(nominal, {field: OFF[field] for field in nominal.toleranced})


def boxes_of(name, count=6):
    """Boxes of poses and numbers: all that the machine's numbers may be, and parts of it."""
    family, random = family_of(name), np.random.default_rng(4)
    low = random.uniform(-0.1, 0.05, (count, 3)) - [0, 0, 0.15 if "delta" in name else 0]
    whole = family.whole(Cuboid((), ()))
    least, most = (np.tile(end[:, 3:], (count, 1)) for end in (whole.lo, whole.hi))
    least[1::2] += (most - least)[1::2] / 3
    return Boxes(np.hstack([low, least]), np.hstack([low + 3e-3, most]))


def points_in(boxes, count=40):
    """Corners, where the machines differ most, and points inside (n, count, d)."""
    t = np.random.default_rng(5).uniform(0, 1, (len(boxes), count, boxes.lo.shape[1]))
    t[:, : count // 2] = np.round(t[:, : count // 2])
    points = boxes.lo[:, None] + t * (boxes.hi - boxes.lo)[:, None]
    return np.clip(points, boxes.lo[:, None], boxes.hi[:, None])


def built(family, point):
    """The machine of one point, as its class builds it from numbers."""
    nominal, named = family.nominal, family.named(point)
    own = {name: getattr(nominal, name) for name in type(nominal).model_fields}
    numbers = {name: values if len(values) > 1 else values[0] for name, values in named.items()}
    return type(nominal)(**{**own, **numbers})


def lies_within(enclosure, values):
    """Whether values (n, count, ...) lie within the enclosure (n, ...), but for their own rounding."""
    spare = 1e-9 * np.abs(values)
    return (enclosure.lo[:, None] - spare <= values) & (values <= enclosure.hi[:, None] + spare)


@pytest.mark.parametrize("name", MACHINES)
def test_no_machine_within_tolerances_escapes(name):
    family, boxes = family_of(name), boxes_of(name)
    points = points_in(boxes)
    over, of_poses = family.over(boxes)
    one_each, poses = family.at(points.reshape(-1, points.shape[2]))
    margins, enclosures = one_each.reach(poses), over.reach_enclosure(of_poses)
    for key, margin in margins.items():
        assert lies_within(enclosures[key], margin.reshape(points.shape[:2])).all(), key
    for what, measure in MEASURES.items():
        found = measure.enclosure(over, of_poses)
        values = measure.values(one_each, poses)
        assert np.isfinite(found.lo).all(), what
        assert lies_within(found, values.reshape(*points.shape[:2], *values.shape[1:])).all(), what


@pytest.mark.parametrize("name", MACHINES)
def test_a_machine_for_each_pose_has_the_values_of_machines_built_one_by_one(name):
    family = family_of(name)
    points = points_in(boxes_of(name, 2), 4).reshape(-1, 3 + len(family.whole(Cuboid((), ())).lo[0, 3:]))
    one_each, poses = family.at(points)
    machines = [built(family, point) for point in points]
    margins = [one.reach(pose[None]) for one, pose in zip(machines, poses, strict=True)]
    for key, found in one_each.reach(poses).items():
        np.testing.assert_allclose(found, [margin[key][0] for margin in margins], rtol=1e-12, atol=1e-15)
    for what, measure in MEASURES.items():
        expected = [measure.values(one, pose[None])[0] for one, pose in zip(machines, poses, strict=True)]
        np.testing.assert_allclose(measure.values(one_each, poses), expected, rtol=1e-9, err_msg=what)


def test_the_whole_holds_all_that_the_numbers_may_be_and_no_more():
    delta = LinearDelta(leg_lengths=(0.4, 0.43, 0.38), base_radius=0.25, platform_radius=0.06)
    family = Family(delta, {"base_radius": 1e-4, "leg_lengths": 0.1})
    whole = family.whole(Cuboid((-0.1, -0.2, -0.3), (0.1, 0.2, -0.2)))
    expected = [(-0.1, -0.2, -0.3, 0.2499, 0.3, 0.33, 0.28), (0.1, 0.2, -0.2, 0.2501, 0.5, 0.53, 0.48)]
    np.testing.assert_allclose([whole.lo[0], whole.hi[0]], expected, rtol=1e-15)
    assert (whole.lo[0, 3:] < expected[0][3:]).sum() + (whole.hi[0, 3:] > expected[1][3:]).sum() >= 4
    named = family.named(whole.lo[0])
    assert list(named) == ["base_radius", "leg_lengths"]
    assert named["leg_lengths"] == pytest.approx((0.3, 0.33, 0.28))


def test_numbers_change_each_on_its_own():
    family = Family(Orthoglide(leg_lengths=(0.3, 0.3, 0.3)), {"leg_lengths": 0.01})
    whole = family.whole(Cuboid((0.0,) * 3, (0.0,) * 3))
    corners = np.array(list(itertools.product(*zip(whole.lo[0, 3:], whole.hi[0, 3:], strict=True))))
    one_each, poses = family.at(np.hstack([np.zeros((8, 3)), corners]))
    np.testing.assert_allclose(one_each.inverse_kinematics(poses)[0], corners, rtol=1e-15)


def test_without_tolerances_the_machine_is_the_nominal_one():
    family = Family(MACHINES["delta"])
    boxes = family.whole(Cuboid((-0.1,) * 3, (0.1,) * 3))
    assert family.over(boxes) == (family.nominal, boxes)
    assert family.at(boxes.lo)[0] is family.nominal
    assert family.named(boxes.lo[0]) == {}


def test_where_machines_differ_in_how_their_legs_lean_nothing_is_known():
    """Vertical slides stand 300 mm out, the platform's joints 298.9 to 300.9 mm."""
    delta = LinearDelta(leg_lengths=(0.4,) * 3, base_radius=0.3, platform_radius=0.2999)
    family = Family(delta, {"platform_radius": 1e-3})
    over, poses = family.over(family.whole(Cuboid((0.0, 0.0, -0.1), (0.0, 0.0, -0.1))))
    margins = over.reach_enclosure(poses)
    assert np.isnan(margins["singularity"].lo).all()
    assert np.isfinite(margins["leg_1"].lo).all()

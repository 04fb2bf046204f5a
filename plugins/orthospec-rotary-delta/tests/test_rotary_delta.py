"""The machine against its geometry, the conformance test, and its spec."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from orthospec_rotary_delta import AZIMUTHS, RotaryDelta
from scipy.optimize import fsolve

from orthospec.errors import SpecError
from orthospec.optimise import evaluate_spec, solve
from orthospec.registry import MANIPULATORS, distribution_of
from orthospec.spec import load_spec
from orthospec.testing import check_manipulator

SPEC = Path(__file__).parent.parent / "specs" / "rotary-delta-pick.yaml"
MACHINE = RotaryDelta(base_radius=0.12, platform_radius=0.045, arm=0.14, forearm=0.25)


def poses(count: int, seed: int = 1) -> np.ndarray:
    drawn = np.random.default_rng(seed).uniform([-0.1, -0.1, -0.22], [0.1, 0.1, -0.14], (20 * count, 3))
    return drawn[MACHINE.inverse_kinematics(drawn)[1]][:count]


def elbows(angles: np.ndarray) -> np.ndarray:
    """(n, 3, 3), from the drawing: out by the cosine, down by the sine."""
    radial = np.array([[np.cos(a), np.sin(a), 0.0] for a in AZIMUTHS])
    out = MACHINE.base_radius + MACHINE.arm * np.cos(angles)
    return out[:, :, None] * radial - MACHINE.arm * np.sin(angles)[:, :, None] * np.array([0.0, 0.0, 1.0])


def test_the_name_belongs_to_this_distribution() -> None:
    assert distribution_of(MANIPULATORS, "rotary_delta").distribution == "orthospec-rotary-delta"


def test_it_conforms() -> None:
    check_manipulator(MACHINE)


def test_each_forearm_has_its_length_and_each_elbow_points_outwards() -> None:
    tool = poses(200)
    angles, _ = MACHINE.inverse_kinematics(tool)
    joints = tool[:, None, :] + MACHINE.platform_radius * np.array(
        [[np.cos(a), np.sin(a), 0.0] for a in AZIMUTHS]
    )
    lengths = np.linalg.norm(joints - elbows(angles), axis=2)
    np.testing.assert_allclose(lengths, MACHINE.forearm, rtol=1e-12)


def test_the_tool_is_found_again_from_its_angles() -> None:
    """Forward, by a root finder that knows the drawing only."""
    platform = MACHINE.platform_radius * np.array([[np.cos(a), np.sin(a), 0.0] for a in AZIMUTHS])
    for tool in poses(10, seed=2):
        angles, _ = MACHINE.inverse_kinematics(tool[None])
        centres = elbows(angles)[0] - platform

        def misses(p: np.ndarray, centres: np.ndarray = centres) -> np.ndarray:
            return ((p - centres) ** 2).sum(axis=1) - MACHINE.forearm**2

        found = fsolve(misses, tool + 0.005, xtol=1e-12)
        np.testing.assert_allclose(found, tool, atol=1e-8)


def test_a_third_of_a_turn_changes_the_arms_around() -> None:
    tool = poses(50, seed=3)
    cos, sin = np.cos(2 * np.pi / 3), np.sin(2 * np.pi / 3)
    turned = tool @ np.array([[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]])
    before, after = (MACHINE.inverse_kinematics(each)[0] for each in (tool, turned))
    np.testing.assert_allclose(np.roll(before, 1, axis=1), after, atol=1e-12)


def test_it_is_drawn_with_its_lengths() -> None:
    drawn = MACHINE.skeleton(poses(20))
    lengths = np.linalg.norm(drawn.segments[:, :, 1] - drawn.segments[:, :, 0], axis=2)
    for name, length in zip(drawn.names, lengths.T, strict=True):
        wanted = {"arm": MACHINE.arm, "left": MACHINE.forearm, "right": MACHINE.forearm}.get(
            name.split("_")[0]
        )
        if wanted is not None:
            np.testing.assert_allclose(length, wanted, rtol=1e-12)


@pytest.mark.parametrize(("lowest", "highest"), [(-0.2, 1.0), (-1.5, 0.3), (0.3 - np.pi, 0.3)])
def test_limits_of_the_arms_bound_the_reach(lowest: float, highest: float) -> None:
    narrow = MACHINE.model_copy(update={"lowest": lowest, "highest": highest})
    tool = poses(400, seed=4)
    angles, reachable = narrow.inverse_kinematics(tool)
    inside = ((angles > lowest) & (angles < highest)).all(axis=1)
    assert inside.any()
    assert not inside.all()
    np.testing.assert_array_equal(reachable, inside)


@pytest.mark.parametrize(
    ("lowest", "highest"), [("95 deg", "-60 deg"), ("0 deg", "0 deg"), ("-120 deg", "107 deg")]
)
def test_limits_that_an_arm_cannot_have_are_a_mistake(lowest: str, highest: str) -> None:
    """Over more than half a turn the sine of the way to a limit tells the wrong side."""
    with pytest.raises(SpecError, match="highest must be above lowest, by half a turn"):
        load_spec(SPEC, [f"manipulator.lowest={lowest}", f"manipulator.highest={highest}"])


def test_its_spec_ends_where_the_bound_is_held() -> None:
    spec = load_spec(SPEC, ["optimise.starts=1", "workspace.divisions=5", "proof=false"])
    finding = solve(spec).finding
    highest = finding.evaluation.measures["evenness"].highest
    assert finding.status == "compromise"
    assert highest is not None
    assert highest.value == pytest.approx(2.0, rel=1e-6)
    shorter = {name: 0.98 * value for name, value in finding.design.values.items()}
    assert not evaluate_spec(spec, shorter).finding.evaluation.holds


def test_an_angle_in_metres_is_a_mistake() -> None:
    with pytest.raises(SpecError, match="an angle"):
        load_spec(SPEC, ["manipulator.highest=1 m"])

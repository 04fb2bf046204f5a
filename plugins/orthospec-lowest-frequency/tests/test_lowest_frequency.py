"""The measure against closed forms, a simulated vibration and the conformance test; its spec."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from orthospec_lowest_frequency import LowestFrequency
from scipy.linalg import eigh

from orthospec.errors import SpecError
from orthospec.manipulators.orthoglide import Orthoglide
from orthospec.optimise import evaluate_spec
from orthospec.registry import MEASURES, distribution_of
from orthospec.spec import load_spec
from orthospec.testing import check_measure

SPEC = Path(__file__).parent.parent / "specs" / "orthoglide-legs.yaml"


def machine(**keys: object) -> Orthoglide:
    legs = {
        "kind": "PRPaR",
        "section": {"round": {"diameter": 0.03, "wall": 0.002}},
        "material": "steel",
        "spacing": 0.08,
    }
    drives = {"stiffness": 2e7, "mass": 2.0}
    whole = {"leg_lengths": [0.32] * 3, "legs": legs, "actuators": drives, "platform": {"mass": 3.0}}
    return Orthoglide.model_validate({**whole, **keys})


def test_the_name_belongs_to_this_distribution() -> None:
    assert distribution_of(MEASURES, "lowest_frequency").distribution == "orthospec-lowest-frequency"


def test_it_conforms() -> None:
    check_measure(LowestFrequency(), machine())


def test_a_mass_on_three_equal_springs_has_the_frequency_of_one() -> None:
    """At the isotropic pose of stiff light legs each axis is a drive's spring, a slider and the platform."""
    hard = {"E": 1e30, "nu": 0.3, "density": 1e-9}
    one = machine(legs={"kind": "PUU", "section": {"round": {"diameter": 0.2}}, "material": hard})
    (found,) = LowestFrequency().values(one, np.zeros((1, 3)))
    assert found == pytest.approx(np.sqrt(2e7 / (2.0 + 3.0)) / (2 * np.pi), rel=1e-6)


def test_it_is_the_least_root_of_the_generalised_problem() -> None:
    one, poses = machine(), np.random.default_rng(1).uniform(-0.1, 0.07, (30, 3))
    inverse, inertia = one.inverse_jacobian(poses), one.joint_inertia(poses)
    for pose in range(len(poses)):
        mass = inverse[pose].T @ inertia[pose] @ inverse[pose]
        stiffness = np.linalg.inv(one.compliance(poses)[pose, :3, :3])
        squares = eigh(stiffness, mass, eigvals_only=True)
        found = LowestFrequency().values(one, poses[pose : pose + 1])[0]
        assert found == pytest.approx(np.sqrt(squares[0]) / (2 * np.pi), rel=1e-9)


def test_four_times_the_mass_halves_it_where_all_mass_is_the_platforms() -> None:
    light, heavy = (machine(actuators={"stiffness": 2e7}, platform={"mass": m}) for m in (1e5, 4e5))
    pose = np.array([[0.03, -0.05, 0.01]])
    ratio = LowestFrequency().values(light, pose) / LowestFrequency().values(heavy, pose)
    assert ratio == pytest.approx(2.0, rel=1e-4)


def test_a_machine_that_does_not_know_its_masses_is_told_what_to_give() -> None:
    with pytest.raises(SpecError, match="stiffness"):
        load_spec(SPEC, ["manipulator.actuators={mass: 2 kg}"])


def test_the_bound_of_the_spec_holds_with_thicker_legs_and_fails_with_thinner_ones() -> None:
    spec = load_spec(SPEC, ["workspace.divisions=6", "proof=false"])
    holds = [
        evaluate_spec(spec, {"diameter": d}).finding.evaluation.measures["hum"].lowest for d in (0.05, 0.008)
    ]
    assert holds[0] is not None
    assert holds[1] is not None
    assert holds[0].value > 130 > holds[1].value

"""The measure against closed forms, and its spec solved to the optimum that they give."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from orthospec_joint_error import JointError

from orthospec.errors import PluginFault, SpecError
from orthospec.manipulators.orthoglide import Orthoglide
from orthospec.measures import Demand
from orthospec.optimise import Outcome, evaluate_spec, solve
from orthospec.registry import MEASURES, distribution_of
from orthospec.spec import load_spec
from orthospec.testing import check_measure
from orthospec.workspace.cuboid import Cuboid
from orthospec.workspace.field import measured
from orthospec.workspace.machine import Machine
from orthospec.workspace.proof import prove

SPEC = Path(__file__).parent.parent / "specs" / "orthoglide-scales.yaml"
LEG = 0.31


@pytest.fixture(scope="module")
def outcome() -> Outcome:
    return solve(load_spec(SPEC))


def machine(leg: float = LEG) -> Orthoglide:
    return Orthoglide(leg_lengths=(leg, leg, leg))


def diagonal(u: np.ndarray) -> np.ndarray:
    """‖J‖_F² on the Orthoglide's diagonal: the singular values of J⁻¹ are |1 − 2u| once and |1 + u| twice."""
    return 1 / (1 - 2 * u) ** 2 + 2 / (1 + u) ** 2


def corners(ratio: float) -> tuple[float, float]:
    """The two q / L on the diagonal where ‖J‖_F = ratio: roots of a quartic in u, around the isotropic 0."""
    a, b = np.poly1d([-2.0, 1.0]), np.poly1d([1.0, 1.0])
    roots = (ratio**2 * a * a * b * b - b * b - 2 * a * a).roots
    u = np.sort(roots[np.isreal(roots)].real)
    low, high = u[u < 0].max(), u[u > 0].min()
    return tuple(float(v / np.sqrt(1 + 2 * v**2)) for v in (low, high))


def test_the_name_belongs_to_this_distribution() -> None:
    assert distribution_of(MEASURES, "joint_error").distribution == "orthospec-joint-error"


def test_the_error_on_the_diagonal_has_its_closed_form() -> None:
    q = np.linspace(-0.16, 0.09, 26)
    values = JointError(error=5e-6).values(machine(), np.column_stack([q, q, q]))
    expected = 5e-6 * np.sqrt(diagonal(q / np.sqrt(LEG**2 - 2 * q**2)))
    np.testing.assert_allclose(values, expected, rtol=1e-12)


def test_the_error_is_the_spread_of_many_disturbed_tools() -> None:
    """The sliders are disturbed, and the tool that belongs to them found by Newton's method."""
    rng = np.random.default_rng(1)
    pose, spread = np.array([[0.05, -0.04, 0.02]]), 5e-6
    target = machine().inverse_kinematics(pose)[0] + rng.normal(scale=spread, size=(20000, 3))
    tool = np.repeat(pose, len(target), axis=0)
    for _ in range(4):
        miss = machine().inverse_kinematics(tool)[0] - target
        tool -= np.linalg.solve(machine().inverse_jacobian(tool), miss[:, :, None])[:, :, 0]
    spread_of_tools = np.sqrt(((tool - pose) ** 2).sum(axis=1).mean())
    assert JointError(error=spread).values(machine(), pose)[0] == pytest.approx(spread_of_tools, rel=0.02)


def test_the_error_has_no_bound_at_a_parallel_singularity_and_no_value_out_of_reach() -> None:
    singular, unreachable = [LEG / np.sqrt(6)] * 3, [1.0, 1.0, 1.0]
    values = JointError(error=5e-6).values(machine(), np.array([singular, unreachable]))
    assert values[0] > 1e6
    assert np.isnan(values[1])


def test_the_spec_is_solved_to_its_closed_form(outcome: Outcome) -> None:
    low, high = corners(12 / 5)
    finding = outcome.finding
    leg = 0.2 / (high - low)
    assert finding.design.values["leg"] == pytest.approx(leg, rel=1e-6)
    assert finding.evaluation.joint is not None
    assert finding.evaluation.joint.scale == pytest.approx(1.0, abs=1e-6)
    assert finding.evaluation.prescribed is not None
    np.testing.assert_allclose(finding.evaluation.prescribed.cuboid.low, leg * low, rtol=1e-6)
    np.testing.assert_allclose(finding.evaluation.prescribed.cuboid.high, leg * high, rtol=1e-6)
    assert finding.search is not None
    assert finding.search.subproblems <= 30


def test_the_bound_binds_and_the_isotropic_pose_has_sqrt_3_times_one_error(outcome: Outcome) -> None:
    accuracy = outcome.finding.evaluation.measures["accuracy"]
    assert accuracy.highest is not None
    assert accuracy.highest.value == pytest.approx(12e-6, rel=1e-8)
    assert accuracy.poses["isotropic"] == pytest.approx((5e-6 * np.sqrt(3),))
    bounds = [limit for limit in outcome.finding.limits if limit.kind == "bound"]
    assert [(limit.name, limit.side) for limit in bounds] == [("accuracy", "at_most")]


def test_the_scale_of_its_cuboid_is_proved_to_a_part_in_a_million(outcome: Outcome) -> None:
    joint = outcome.finding.evaluation.joint
    assert joint is not None
    assert joint.proved is not None
    assert joint.proved.most is not None
    assert joint.proved.most - joint.scale < 2e-6


def test_a_longer_leg_than_the_optimum_holds_and_a_shorter_one_does_not(outcome: Outcome) -> None:
    leg = outcome.finding.design.values["leg"]
    spec = load_spec(SPEC)
    assert evaluate_spec(spec, {"leg": 1.001 * leg}).finding.evaluation.holds
    assert not evaluate_spec(spec, {"leg": 0.999 * leg}).finding.evaluation.holds


@pytest.mark.parametrize(
    ("setting", "words"),
    [
        ("measures.accuracy.error=5 kg", "5 kg is a mass, a length [m] was expected"),
        ("measures.accuracy.error=0", "more than 0 was expected"),
        ("measures.accuracy.at_least=1 um", "joint_error has no 'at_least'; it knows at_most"),
    ],
)
def test_its_mistakes_are_told_in_the_words_of_the_host(setting: str, words: str) -> None:
    with pytest.raises(SpecError) as caught:
        load_spec(SPEC, [setting])
    assert words in str(caught.value)


def test_a_machine_that_it_is_not_for_is_a_fault_with_its_name() -> None:
    class Turning(Orthoglide):
        joint_units = ("rad", "rad", "rad")

    demand = Demand("accuracy", JointError(error=5e-6), {"at_most": 12e-6}, place="spec.yaml:14:3")
    with pytest.raises(PluginFault, match=r"spec\.yaml:14:3: plugin JointError .* prismatic actuators"):
        measured(demand, Turning(leg_lengths=(LEG, LEG, LEG)), np.zeros((1, 3)))


def test_the_bound_is_proved_at_every_pose_without_a_line_for_it() -> None:
    """The largest cube of 12/5 times one error, corners on the diagonal; a larger bound than it has fails."""
    low, high = (LEG * end for end in corners(12 / 5))
    cube = Cuboid((low,) * 3, (high,) * 3)
    for bound, verdict in ((12e-6, "proved"), (11.9e-6, "refuted")):
        demand = Demand("accuracy", JointError(error=5e-6), {"at_most": bound})
        claims = prove(Machine(machine(), {"accuracy": demand}), cube, slack=1e-4)
        assert claims[-1].verdict == verdict


def test_it_conforms() -> None:
    check_measure(JointError(error=5e-6), machine())

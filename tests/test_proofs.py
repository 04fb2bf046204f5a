"""Proofs in a run: beside each cuboid of a result, and as critical points where they refute a design."""

from __future__ import annotations

from dataclasses import replace
from functools import reduce
from itertools import product
from typing import ClassVar

import numpy as np
import pytest

from orthospec import registry
from orthospec.manipulators.orthoglide import Orthoglide
from orthospec.measures import Measure
from orthospec.optimise import evaluate_spec, hired, proofs, remembering, solve, with_proof
from orthospec.optimise.space import DesignSpace
from orthospec.optimise.workers import Here
from orthospec.result import compose
from orthospec.result.model import ProofRecord
from orthospec.show import show, words
from orthospec.spec import ProofKeys
from orthospec.workspace.evaluate import Prescribed

HEAD = """\
orthospec: 1
variables: {leg: {min: 250 mm, max: 500 mm, start: 400 mm}}
manipulator: {use: orthoglide, leg_lengths: [leg, leg, leg]}
workspace: {size: [200 mm, 200 mm, 200 mm], divisions: 10}
measures: {transmission: {use: velocity_transmission, at_least: 0.5, at_most: 2}}
goals: {legs: {minimise: leg, goal: 300 mm}}
optimise: {starts: 1}
proof: {slack: 1e-3}
"""
LEG = 0.2 / (1 / np.sqrt(6) + 1 / np.sqrt(18))


@pytest.fixture(scope="module")
def solved(spec_of):
    spec = spec_of(HEAD)
    return spec, solve(spec)


def test_a_run_proves_the_design_that_it_finds(solved):
    workspace = solved[1].finding.evaluation
    for one in (workspace.prescribed, workspace.joint, workspace.measures["transmission"].largest):
        assert one.proof.verdict == "proved"
        assert one.proof.slack == 1e-3
    assert workspace.joint.proved.least == pytest.approx(1.0, abs=2e-6)
    assert workspace.joint.proved.most == pytest.approx(1.0, abs=2e-6)


def test_the_result_and_show_tell_it(solved):
    spec, outcome = solved
    content = compose(spec, outcome.finding)
    proof = content["workspace"]["prescribed"]["proof"]
    assert list(proof) == ["verdict", "slack", "boxes", "excess", "at"]
    assert set(content["workspace"]["joint"]["proved"]) == {"least", "most"}
    text = show(content, spec=spec, width=80, colour=False)
    assert "proved: it holds within 0.1 % at every pose" in text
    assert "proved of the scale: at least 0.999999 and at most 1.000001" in text


def test_without_proof_nothing_of_it_is_told(spec_of):
    spec = spec_of(HEAD, "proof=false")
    outcome = solve(spec)
    assert outcome.finding.evaluation.prescribed.proof is None
    assert "proof" not in str(compose(spec, outcome.finding))


def test_an_evaluation_is_proved_where_it_is_asked_for(spec_of):
    spec = spec_of(HEAD)
    plain = evaluate_spec(spec, {"leg": 0.32})
    assert plain.finding.evaluation.prescribed.proof is None
    proved = with_proof(spec, plain, ProofKeys(slack=1e-2)).finding.evaluation.prescribed
    assert (proved.proof.verdict, proved.proof.slack, proved.holds) == ("proved", 1e-2, True)


def test_what_does_not_hold_is_refuted_with_a_pose(spec_of):
    spec = spec_of(HEAD)
    outcome = with_proof(spec, evaluate_spec(spec, {"leg": 0.305}), ProofKeys())
    prescribed = outcome.finding.evaluation.prescribed
    assert not prescribed.holds
    assert prescribed.proof.verdict == "refuted"
    design = spec.design({"leg": 0.305})
    (values,) = design.demands[0].measure.values(design.manipulator, np.array([prescribed.proof.at]))
    assert values[0] < 0.5 * (1 - 1e-3) or values[1] > 2 * (1 + 1e-3)


def test_each_level_and_each_measures_own_cuboid_is_proved(spec_of):
    text = HEAD.replace(
        "at_most: 2}}",
        "at_most: 2, levels: {at_most: [1.5]}}, c: {use: joint_speed, speed: 1, at_most: 1.2}}",
    )
    spec = spec_of(text)
    found = with_proof(spec, evaluate_spec(spec), ProofKeys()).finding.evaluation
    assert found.measures["c"].largest.proof.verdict == "proved"
    assert found.measures["transmission"].levels[0][1].proof.verdict == "proved"
    assert found.joint.proved is not None
    assert found.measures["c"].largest.proved is None


def test_two_processes_prove_the_same(solved):
    spec = solved[0]
    with hired(jobs=2) as workers:
        assert compose(spec, solve(spec, workers=workers).finding) == compose(spec, solved[1].finding)


class Bump(Measure):
    """1 but for a bump a fifth of a millimetre wide, the lower the longer the legs: no lattice meets it."""

    unit: ClassVar[str] = "1"
    sides: ClassVar[frozenset[str]] = frozenset({"at_most"})

    def values(self, manipulator, poses):
        square = np.sum((poses - PLACE) ** 2, axis=1)
        return 1 + 5 * (0.4 - manipulator.leg_lengths[0]) * np.exp(-square / 1e-8)


PLACE = np.array([-0.0333, -0.0217, -0.0271])


@pytest.fixture
def bumpy(monkeypatch, spec_of):
    find = registry.find_measure
    monkeypatch.setattr(registry, "find_measure", lambda name: Bump if name == "bump" else find(name))
    text = HEAD.replace("at_most: 2}}", "at_most: 2}, bump: {use: bump, at_most: 1.2}}")
    return spec_of(text, "proof.boxes=3000")


def test_a_violation_smaller_than_a_cell_of_the_grid_is_found(bumpy):
    outcome = with_proof(bumpy, evaluate_spec(bumpy, {"leg": 0.32}), ProofKeys())
    prescribed = outcome.finding.evaluation.prescribed
    assert prescribed.proof.verdict == "refuted"
    assert prescribed.proof.condition == "bump: at_most"
    assert np.linalg.norm(np.array(prescribed.proof.at) - PLACE) < 1e-3
    assert evaluate_spec(bumpy, {"leg": 0.32}).finding.evaluation.prescribed.holds


def test_a_design_that_a_proof_refutes_is_solved_on_until_one_is_proved(bumpy):
    """Without the pose that the proof found, the shortest legs would do."""
    finding = solve(bumpy).finding
    assert finding.design.values["leg"] == pytest.approx(0.36, rel=1e-6)
    assert finding.status == "compromise"
    assert finding.evaluation.prescribed.proof.verdict == "proved"


class Islands(Measure):
    """At most 2 in balls about cubes: seven of 31 mm with four nodes in a row, one of 33 mm with three."""

    unit: ClassVar[str] = "1"
    sides: ClassVar[frozenset[str]] = frozenset({"at_most"})

    def values(self, manipulator, poses):  # noqa: ARG002
        far = _corners(poses, FAR, 33e-3)
        return reduce(np.minimum, [_corners(poses, place, 31e-3) for place in OTHERS], far)


def _corners(poses, place, edge):
    """2 at the corners of a cube."""
    return np.sum((poses - place) ** 2, axis=1) * (8 / 3 / edge**2)


FAR = np.full(3, -40e-3)
OTHERS = [np.array(place) * 1e-3 for place in product((-45, 45), repeat=3) if max(place) > 0]
ISLANDS = HEAD.replace(
    "[200 mm, 200 mm, 200 mm], divisions: 10", "[SIZE, SIZE, SIZE], divisions: 3, region: REGION"
)
ISLANDS = ISLANDS.replace("REGION", "{min: [-0.1, -0.1, -0.1], max: [0.1, 0.1, 0.1]}")
ISLANDS = ISLANDS.replace(
    "transmission: {use: velocity_transmission, at_least: 0.5,", "islands: {use: islands,"
)


@pytest.mark.parametrize("size", [30, 40])
def test_a_larger_cuboid_that_the_grid_has_missed_is_told_and_proved_instead(monkeypatch, spec_of, size):
    monkeypatch.setattr(registry, "find_measure", lambda _: Islands)
    spec = spec_of(ISLANDS.replace("SIZE", f"{size} mm"), f"workspace.divisions={size // 10}")
    plain = evaluate_spec(spec)
    before = plain.finding.evaluation
    assert before.joint.scale == pytest.approx(31 / size, rel=1e-9)
    after = with_proof(spec, plain, ProofKeys()).finding.evaluation
    for one in (after.joint, after.measures["islands"].largest):
        assert one.scale == pytest.approx(33 / size, rel=1e-9)
        assert one.cuboid.centre == pytest.approx(FAR, abs=1e-9)
        assert (one.proved.least, one.proved.most) == pytest.approx((33 / size,) * 2, rel=2e-6)
        assert one.grid_scale == before.joint.grid_scale
    # The prescribed one stays where it holds, and moves where it does not.
    assert after.prescribed.holds == (size == 30)
    assert after.prescribed.proof.verdict == ("proved" if size == 30 else "refuted")
    assert after.prescribed.cuboid.centre == pytest.approx(
        before.prescribed.cuboid.centre if size == 30 else FAR, abs=1e-6
    )


class Opaque(Bump):
    """Its code knows numbers only."""

    def values(self, manipulator, poses):  # noqa: ARG002
        return np.array([1.0 + float(pose[0]) for pose in poses])


def test_a_measure_without_enclosure_is_undecided_and_says_why(monkeypatch, spec_of):
    find = registry.find_measure
    monkeypatch.setattr(registry, "find_measure", lambda name: Opaque if name == "opaque" else find(name))
    spec = spec_of(HEAD.replace("at_most: 2}}", "at_most: 2}, plain: {use: opaque, at_most: 2}}"))
    outcome = with_proof(spec, evaluate_spec(spec), ProofKeys())
    proof = outcome.finding.evaluation.prescribed.proof
    assert (proof.verdict, proof.condition) == ("undecided", "plain: at_most")
    assert f"{__name__}, line " in proof.why


def test_ctrl_c_leaves_the_proof_out(spec_of, monkeypatch):
    spec = spec_of(HEAD)

    def stopped(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(proofs, "in_order", stopped)
    outcome = solve(spec)
    assert outcome.interrupted
    assert outcome.finding.status == "unfinished"
    assert outcome.finding.design.values["leg"] == pytest.approx(LEG, rel=1e-8)
    assert outcome.finding.evaluation.prescribed.proof is None


@pytest.mark.parametrize(
    ("record", "said"),
    [
        ({"verdict": "proved", "boxes": 1}, "proved: it holds within 0.1 % at every pose (1 box)"),
        (
            {"verdict": "refuted", "boxes": 9, "excess": 0.02, "condition": "t: at_most"},
            "refuted: t (at most) is missed by 2 % at HERE",
        ),
        (
            {"verdict": "undecided", "boxes": 9, "excess": 0.02, "condition": "singularity"},
            "not proved within 0.1 % in 9 boxes: singularity; a miss by more than 2 % is ruled out",
        ),
        (
            {"verdict": "undecided", "boxes": 0, "condition": "t: at_least"},
            "not proved within 0.1 % in 0 boxes: t (at least)",
        ),
        (
            {"verdict": "undecided", "boxes": 0, "condition": "t: at_most", "why": "m.py:3: no"},
            "not proved: nothing is known of t (at most) between poses: m.py:3: no",
        ),
    ],
)
def test_each_verdict_has_its_sentence(record, said):
    assert words.proof(ProofRecord(slack=1e-3, **record), "HERE")[1] == said


# Tolerances.

OFF = "manipulator.tolerance={leg_lengths: 0.5 mm}"


def proof_of(spec_of, leg, setting):
    spec = spec_of(HEAD, setting)
    finding = evaluate_spec(spec, {"leg": leg}).finding
    point = [(finding.design, finding.evaluation)]
    (evaluation,) = proofs.proved(Here(), DesignSpace(spec), point, ProofKeys(), of=(Prescribed,))
    return evaluation.prescribed, compose(spec, replace(finding, evaluation=evaluation)), spec


def test_room_makes_the_proof_hold_for_every_machine_within_its_tolerances(spec_of):
    prescribed, content, spec = proof_of(spec_of, LEG + 5e-4, OFF)
    assert (prescribed.proof.verdict, prescribed.proof.nominal, prescribed.holds) == (
        "proved",
        "proved",
        True,
    )
    text = " ".join(show(content, spec=spec, width=90, colour=False).split())
    assert "at every pose, for every machine within its tolerances (" in text


def test_a_design_that_ends_on_its_bounds_is_refuted_with_the_machine_that_fails(solved, spec_of):
    spec = spec_of(HEAD, OFF)
    finding = solve(spec).finding
    assert finding.design.values == solved[1].finding.design.values
    assert finding.status == solved[1].finding.status
    prescribed, joint = finding.evaluation.prescribed, finding.evaluation.joint
    assert prescribed.holds
    assert joint.proved == solved[1].finding.evaluation.joint.proved
    content = compose(spec, finding)
    proof = content["workspace"]["prescribed"]["proof"]
    assert (proof["verdict"], proof["nominal"], proof["condition"]) == (
        "refuted",
        "proved",
        "transmission: at_most",
    )
    lengths = proof["machine"]["leg_lengths"]
    assert lengths == pytest.approx([LEG - 5e-4] * 3, rel=1e-8)
    factors = (
        spec.design({"leg": lengths[0]})
        .demands[0]
        .measure.values(Orthoglide(leg_lengths=lengths), np.array([proof["at"]]))
    )
    assert factors[0, 1] == pytest.approx(2 * (1 + proof["excess"]), rel=1e-12)
    text = " ".join(show(content, spec=spec, width=90, colour=False).split())
    assert "tolerance leg_lengths ± 0.5 mm" in text
    assert (
        "(-126.795, -126.795, -126.795) mm with leg_lengths 3 x 310.083 mm; the machine as designed" in text
    )


def test_a_design_that_fails_itself_is_refuted_as_it_is(spec_of):
    prescribed, content, _ = proof_of(spec_of, 0.305, OFF)
    assert not prescribed.holds
    assert (prescribed.proof.verdict, prescribed.proof.nominal) == ("refuted", "refuted")
    assert "machine" not in content["workspace"]["prescribed"]["proof"]


def test_another_tolerance_makes_only_the_proofs_anew(spec_of, tmp_path):
    def made(*settings):
        with remembering(Here(), tmp_path) as workers:
            solve(spec_of(HEAD, *settings), workers=workers)
            return workers.asked - workers.known

    cuboids = 2  # The prescribed one, and the largest: of all measures and of the one alike.
    assert made() > cuboids
    assert made(OFF) == cuboids
    assert made(OFF) == 0
    assert made("manipulator.tolerance={leg_lengths: 0}") == 0


def test_the_hash_of_a_spec_tells_its_tolerances(spec_of):
    plain, one, same, other, none = (
        spec_of(HEAD, *setting).sha256()
        for setting in (
            (),
            (OFF,),
            ("manipulator.tolerance={leg_lengths: 0.0005}",),
            ("manipulator.tolerance={leg_lengths: 0.6 mm}",),
            ("manipulator.tolerance={leg_lengths: 0}",),
        )
    )
    assert one == same
    assert plain == none
    assert len({plain, one, other}) == 3

"""What is told of a design of which a measure, or the machine in something, fails: all else."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar

import numpy as np
import pytest

from orthospec import registry
from orthospec.errors import PluginFault
from orthospec.manipulators.orthoglide import Orthoglide
from orthospec.measures import Measure
from orthospec.measures.kinematic import VelocityTransmission
from orthospec.optimise import Outcome, evaluate_spec
from orthospec.preview import preview
from orthospec.preview.build import scene_of
from orthospec.report import report
from orthospec.report.subject import Subject
from orthospec.solution import solution_of
from orthospec.spec import Spec

SPEC = """
orthospec: 1
manipulator: {use: orthoglide, leg_lengths: [1, 1, 1]}
workspace: {size: [0.5, 0.5, 0.25], divisions: 4}
measures: {transmission: {use: velocity_transmission, at_most: 2}}
"""


class Undrawn(Orthoglide):
    """No skeleton."""

    def skeleton(self, poses: Any) -> Any:  # noqa: ARG002
        """None."""
        raise ZeroDivisionError("no line")


class Nameless(Orthoglide):
    """A stroke that is not known."""

    def indices(self, joint_ranges: Any) -> Any:
        """NaN for one."""
        return {**super().indices(joint_ranges), "stroke": np.nan}


class Lacking(Orthoglide):
    """No stroke."""

    def indices(self, joint_ranges: Any) -> Any:
        """One less."""
        return {name: one for name, one in super().indices(joint_ranges).items() if name != "stroke"}


class Numbered(Orthoglide):
    """Numbers for flags, which would be taken for the places of poses."""

    def inverse_kinematics(self, poses: Any) -> Any:
        """The flags as integers."""
        joints, reachable = super().inverse_kinematics(poses)
        return joints, reachable.astype(int)


class Flagless(Orthoglide):
    """Joints alone, of which the second would be taken for the flags."""

    def inverse_kinematics(self, poses: Any) -> Any:
        """No flags."""
        return super().inverse_kinematics(poses)[0]


class Columns(Orthoglide):
    """Margins as columns."""

    def reach(self, poses: Any) -> Any:
        """Each (n, 1)."""
        return {name: margin[:, None] for name, margin in super().reach(poses).items()}


@pytest.mark.parametrize(
    ("machine", "said"),
    [
        (Numbered, "inverse_kinematics gave no flags beside the joints"),
        (Flagless, "inverse_kinematics gave no flags beside the joints"),
        (Columns, r"reach gave shape \(\d+, 1\) of float64 for"),
    ],
)
def test_what_the_reach_is_known_by_has_its_form(
    spec_of: Callable[..., Spec], monkeypatch: pytest.MonkeyPatch, machine: type[Orthoglide], said: str
) -> None:
    monkeypatch.setattr(registry, "find_manipulator", lambda _: machine)
    with pytest.raises(PluginFault, match=said):
        evaluate_spec(spec_of(SPEC))


@pytest.fixture
def evaluated(
    spec_of: Callable[..., Spec], monkeypatch: pytest.MonkeyPatch
) -> Callable[[type[Orthoglide]], tuple[Spec, Outcome]]:
    def find(machine: type[Orthoglide]) -> tuple[Spec, Outcome]:
        monkeypatch.setattr(registry, "find_manipulator", lambda _: machine)
        spec = spec_of(SPEC)
        return spec, evaluate_spec(spec)

    return find


def test_an_index_that_is_nan_of_a_cuboid_in_reach_is_told(evaluated: Callable[..., Any]) -> None:
    spec, outcome = evaluated(Nameless)
    (error,) = outcome.finding.errors
    assert error.name == "Nameless"
    assert error.place == spec.place(("manipulator",))
    assert error.message == "gave NaN for the index 'stroke' of a cuboid in reach"
    assert outcome.finding.status == "evaluated"


def test_a_machine_that_is_not_drawn_is_told_and_costs_the_pages_its_drawing_alone(
    evaluated: Callable[..., Any],
) -> None:
    spec, outcome = evaluated(Undrawn)
    (error,) = outcome.finding.errors
    assert (error.name, error.message) == ("Undrawn", "skeleton raised ZeroDivisionError: no line")
    solution = solution_of(spec, outcome)
    assert "The machine is not drawn: plugin Undrawn: skeleton raised" in report(solution)
    assert "the machine is not drawn: plugin Undrawn: skeleton raised" in preview(solution)


def test_what_a_machine_owes_to_every_measure_has_its_place(evaluated: Callable[..., Any]) -> None:
    with pytest.raises(PluginFault, match=r"spec\.yaml:3:1: plugin Lacking: indices gave no 'stroke'"):
        evaluated(Lacking)


class Broken(Measure):
    """Raises."""

    unit: ClassVar[str] = "1"
    sides: ClassVar[frozenset[str]] = frozenset({"at_most"})

    def values(self, manipulator: Any, poses: Any) -> Any:  # noqa: ARG002
        """None."""
        raise ZeroDivisionError("no number")


def test_a_measure_that_fails_costs_the_pages_what_is_of_it_alone(
    spec_of: Callable[..., Spec], monkeypatch: pytest.MonkeyPatch
) -> None:
    uses = {"velocity_transmission": VelocityTransmission, "condition_number": Broken}
    monkeypatch.setattr(registry, "find_measure", uses.get)
    spec = spec_of(SPEC.replace("at_most: 2}", "at_most: 2}, broken: {use: condition_number, at_most: 3}"))
    solution = solution_of(spec, evaluate_spec(spec))
    scene, page, reported = scene_of(Subject(solution)), preview(solution), report(solution)
    assert [scale.words for scale in scene.scales] == ["transmission"]
    assert {"machine", "workspace", "cuboid"} <= {group.path for group in scene.groups}
    assert "broken is not shown: " in page
    assert "plugin Broken (measure broken): raised ZeroDivisionError: no number" in page
    assert "No field is shown of broken: " in reported
    assert "No field is shown of transmission" not in reported
    assert 'id="slice-transmission-' in reported

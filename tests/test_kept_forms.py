"""Compiled forms are found again by other runs, and made anew where anything that decides them differs."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from orthospec.optimise.cache import Cache
from orthospec.optimise.kept_forms import code_of
from orthospec.optimise.space import DesignSpace
from orthospec.spec import Spec
from orthospec.workspace import forms

SPEC = """\
orthospec: 1
variables: {leg: {min: 250 mm, max: 500 mm}}
manipulator: {use: orthoglide, leg_lengths: [leg, leg, leg]}
workspace: {size: [200 mm, 200 mm, 200 mm], divisions: 5}
measures:
  transmission: {use: velocity_transmission, at_least: 0.5, at_most: 2}
  limit: {use: joint_speed, speed: 1 m/s, at_most: 2 m/s}
goals: {length: {minimise: leg, goal: 300 mm, weight: 10 mm}}
optimise: {starts: 2}
proof: false
"""


@pytest.fixture
def compiled(monkeypatch: pytest.MonkeyPatch) -> list[tuple[int, ...]]:
    shapes, compile_form = [], forms.compile_form
    monkeypatch.setattr(
        forms, "compile_form", lambda holds, shape: shapes.append(shape) or compile_form(holds, shape)
    )
    return shapes


def _templates(spec: Spec, folder: Path) -> list[forms.Template | None]:
    space = DesignSpace(spec, Cache(folder))
    machine, pose = space.machine(np.array([0.3])), np.zeros((1, 3))
    sides = [("transmission", "at_least"), ("transmission", "at_most"), ("limit", "at_most")]
    return [space.forms.template(machine, name, side, pose) for name, side in sides]


def test_what_was_compiled_is_found_again_to_the_last_bit(
    spec_of: Callable[..., Spec], tmp_path: Path, compiled: list[tuple[int, ...]]
) -> None:
    first = _templates(spec_of(SPEC), tmp_path)
    assert compiled == [(3, 3), (3, 3), (3,)]
    moved = spec_of(SPEC.replace("at_most: 2}", "at_most: 1.9}").replace("500 mm", "480 mm"))
    again = _templates(moved, tmp_path)
    assert len(compiled) == 3
    for one, other in zip(first, again, strict=True):
        assert one is not None
        assert other is not None
        assert one.cones == other.cones
        for name in ("offset", "on_inside", "on_slack", "on_auxiliary"):
            np.testing.assert_array_equal(getattr(one, name), getattr(other, name))


def test_other_code_or_damage_compile_anew(
    spec_of: Callable[..., Spec],
    tmp_path: Path,
    compiled: list[tuple[int, ...]],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    _templates(spec_of(SPEC), tmp_path)
    for path in tmp_path.rglob("*.json"):
        path.write_text(path.read_text(encoding="utf-8")[:-3], encoding="utf-8")
    _templates(spec_of(SPEC), tmp_path)
    assert len(compiled) == 6
    monkeypatch.setattr("orthospec.optimise.kept_forms.fingerprint", lambda _: "other code")
    _templates(spec_of(SPEC), tmp_path)
    assert len(compiled) == 9


def test_other_keys_find_the_form_again_where_only_its_inside_has_them(
    spec_of: Callable[..., Spec], tmp_path: Path, compiled: list[tuple[int, ...]]
) -> None:
    _templates(spec_of(SPEC), tmp_path)
    _templates(spec_of(SPEC.replace("speed: 1 m/s", "speed: 2 m/s")), tmp_path)
    assert len(compiled) == 3


def _closing_over(value: Any) -> Callable[..., Any]:
    return lambda x, bound, slack: [x, bound, slack, value]


def _of_defaults(x: Any, bound: Any, slack: float = 0.0) -> list[Any]:
    return [x, bound, slack]


def test_functions_are_told_by_their_code_and_plain_values() -> None:
    one, again, other = (code_of(_closing_over(value)) for value in (1, 1, 2))
    assert one is not None
    assert one == again != other
    inner, same, another = (code_of(_closing_over(_closing_over(value))) for value in (1, 1, 2))
    assert inner == same != another
    assert inner != one
    for own in ([1], np.ones(1), _closing_over([1]), "text".join):
        assert code_of(_closing_over(own)) is None
    for method in (_of_defaults, str.upper, "text".upper, partial(_of_defaults, 1)):
        assert code_of(method) is None


def test_a_space_without_a_folder_compiles_once(
    spec_of: Callable[..., Spec], compiled: list[tuple[int, ...]]
) -> None:
    space = DesignSpace(spec_of(SPEC))
    for leg in (0.3, 0.4):
        space.forms.template(space.machine(np.array([leg])), "transmission", "at_most", np.zeros((1, 3)))
    assert compiled == [(3, 3)]


def test_a_later_run_of_another_bound_does_not_import_cvxpy(tmp_path: Path) -> None:
    program = """
import sys
from pathlib import Path
from orthospec.optimise.workers import hired
from orthospec.optimise.cache import remembering
from orthospec.optimise import solve
from orthospec.spec import load_spec
folder = Path(sys.argv[1])
with hired() as workers, remembering(workers, folder / "kept") as keeping:
    print(solve(load_spec(folder / "spec.yaml", sys.argv[2:]), workers=keeping).finding.status)
print("cvxpy" in sys.modules)
"""
    lines = [line for line in SPEC.splitlines() if "limit:" not in line]
    (tmp_path / "spec.yaml").write_text("\n".join(lines).replace("at_least: 0.5, ", ""), encoding="utf-8")

    def told(setting: str) -> list[str]:
        command = [sys.executable, "-P", "-c", program, str(tmp_path), setting]
        return subprocess.run(command, check=True, capture_output=True, text=True).stdout.split()

    bound = "measures.transmission.at_most="
    assert told(f"{bound}1.8") == ["compromise", "True"]
    assert told(f"{bound}1.9") == ["compromise", "False"]

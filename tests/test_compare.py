"""Comparisons by meaning: rows of nested contents, specs in other words, results, and git's way of asking."""

from __future__ import annotations

import copy
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from orthospec.compare import Comparison, Row, compare, git_call, line_by_line, read_side, rows
from orthospec.errors import SpecError, UsageError
from orthospec.spec.writing import dump

SPEC = """\
orthospec: 1
title: A cube
variables:
  leg: {min: 250 mm, max: 500 mm}
  other: {min: 250 mm, max: 500 mm, start: 300 mm}
manipulator: {use: orthoglide, leg_lengths: [leg, leg, other]}
workspace: {size: [200 mm, 200 mm, 200 mm]}
measures:
  transmission: {use: velocity_transmission, at_least: 0.5, at_most: 2, levels: {at_most: [1.5, 1.8]}}
goals:
  length: {minimise: leg, goal: 300 mm}
sweep: {variable: leg, from: 250 mm, to: 500 mm, points: 3}
"""
LARGEST = {
    "scale": 1.02,
    "grid_scale": 0.975,
    "ties": 25,
    "min": [-0.1, -0.1, -0.1],
    "max": [0.1, 0.1, 0.1],
    "nodes": {"meets": 1, "violates": 2, "unreachable": 3, "failed": 0},
    "proof": {"verdict": "proved", "slack": 1e-3, "boxes": 7},
}
RESULT: dict[str, Any] = {
    "orthospec": 1,
    "title": "A cube",
    "status": "compromise",
    "attainment": {
        "factor": 0.01,
        "goals": {"length": {"value": 0.31, "goal": 0.3, "weight": 1.0, "attained": False}},
    },
    "variables": {"leg": 0.31},
    "manipulator": {"use": "orthoglide", "leg_lengths": [0.31, 0.31, 0.33]},
    "indices": {"stroke": 0.25},
    "workspace": {
        "prescribed": {"min": [-0.1, -0.1, -0.1], "max": [0.1, 0.1, 0.1], "holds": True},
        "joint": LARGEST,
        "measures": {
            "transmission": {
                "scale": 1.02,
                "lowest": {"value": 0.5, "at": [0.1, 0.1, 0.1]},
                "highest": {"value": 2.0, "at": [0.1, 0.1, 0.1]},
                "levels": [{"at_most": 1.5, **LARGEST}],
                "poses": {"Q0": [0.9, 1.1]},
            }
        },
    },
    "limits": [
        {"kind": "bound", "name": "transmission", "side": "at_most", "at": [], "gain": 1e-3, "cost": 2e-3},
        {"kind": "joint", "name": "joint_limits.0.at_most", "side": "at_most", "at": [], "gain": 0.0},
    ],
    "provenance": {"orthospec": "0.1.0", "spec_sha256": "0" * 64},
}
TREE = st.recursive(
    st.one_of(
        st.none(), st.booleans(), st.integers(-9, 9), st.sampled_from(["leg", "other"]), st.floats(-1e3, 1e3)
    ),
    lambda inner: st.one_of(
        st.lists(inner, max_size=3), st.dictionaries(st.sampled_from("abc"), inner, max_size=3)
    ),
    max_leaves=12,
)


def told(found: Comparison | list[Row]) -> list[tuple[str, str, Any, Any]]:
    changed = found.changed if isinstance(found, Comparison) else found
    return [(row.what, row.state, row.a, row.b) for row in changed]


def of_specs(folder: Path, *changes: tuple[str, str], text: str = SPEC) -> Comparison:
    """The spec, beside the same one with pieces of its text replaced."""
    other = text
    for old, new in changes:
        assert old in other
        other = other.replace(old, new)
    for name, content in (("a.yaml", text), ("b.yaml", other)):
        (folder / name).write_text(content)
    return compare(read_side(folder / "a.yaml"), read_side(folder / "b.yaml"))


def of_results(folder: Path, other: dict[str, Any]) -> Comparison:
    for name, content in (("a.yaml", RESULT), ("b.yaml", other)):
        (folder / name).write_text(dump(content))
    return compare(read_side(folder / "a.yaml"), read_side(folder / "b.yaml"))


def test_a_row_tells_where_and_how_far() -> None:
    a = {"legs": [0.2, 0.3], "use": "a", "gone": {"x": 1}, "hard": True, "zero": 0}
    b = {"legs": [0.2, 0.27], "use": "b", "hard": 1, "zero": 2, "new": [3]}
    found = list(rows(a, b))
    assert told(found) == [
        ("legs.0", "same", 0.2, 0.2),
        ("legs.1", "changed", 0.3, 0.27),
        ("use", "changed", "a", "b"),
        ("gone", "removed", {"x": 1}, None),
        ("hard", "changed", True, 1),
        ("zero", "changed", 0, 2),
        ("new", "added", None, [3]),
    ]
    assert found[1].difference == pytest.approx(-0.03, rel=1e-12)
    assert found[1].relative == pytest.approx(-0.1, rel=1e-12)
    assert (found[0].difference, found[0].relative) == (0.0, 0.0)
    assert (found[5].difference, found[5].relative) == (2.0, None)
    assert [found[k].difference for k in (2, 3, 4, 6)] == [None] * 4


@pytest.mark.parametrize(("b", "state"), [(1 + 0.9e-9, "same"), (1 + 1.2e-9, "changed")])
def test_numbers_within_a_billionth_are_the_same(b: float, state: str) -> None:
    assert next(rows(1.0, b)).state == state
    assert next(rows(1e-12, b * 1e-12)).state == state


def test_a_floor_holds_for_the_last_key_alone() -> None:
    a, b = {"gain": 0.0, "value": 0.0}, {"gain": 5e-10, "value": 5e-10}
    assert [row.state for row in rows(a, b, floor={"gain": 1e-9})] == ["same", "changed"]


@given(TREE)
def test_nothing_differs_from_itself(tree: Any) -> None:
    assert all(row.state == "same" for row in rows(tree, copy.deepcopy(tree)))


@given(TREE, TREE)
def test_the_other_way_round_differences_are_of_the_other_sign(a: Any, b: Any) -> None:
    there = {row.path: row for row in rows(a, b)}
    back = {row.path: row for row in rows(b, a)}
    other = {"added": "removed", "removed": "added"}
    assert there.keys() == back.keys()
    for path, row in there.items():
        assert back[path].state == other.get(row.state, row.state)
        assert (back[path].a, back[path].b) == (row.b, row.a)
        if row.difference is not None:
            assert back[path].difference == -row.difference


def test_other_words_for_the_same_spec_make_no_difference(tmp_path: Path) -> None:
    found = of_specs(
        tmp_path,
        ("title: A cube", "title: Another\nnotes: {any: thing}  # and a comment"),
        ("{min: 250 mm, max: 500 mm}", "{max: 0.5, min: 25 cm, start: 375 mm}"),
        ("goal: 300 mm}", "goal: 0.3, weight: 1}"),
        ("to: 500 mm", "to: 0.5"),
    )
    assert found.changed == ()
    assert found.a.spec is not None
    assert found.b.spec is not None
    assert found.a.spec.sha256() == found.b.spec.sha256()


def test_a_spec_differs_where_its_meaning_does(tmp_path: Path) -> None:
    found = of_specs(
        tmp_path,
        ("at_most: [1.5, 1.8]", "at_most: [1.5, 1.7]"),
        ("[leg, leg, other]", "[leg, leg, 0.3]"),
        ("to: 500 mm", "to: 450 mm"),
        ("minimise: leg, goal: 300 mm}", "minimise: leg, goal: 310 mm, weight: relative}"),
        ("sweep:", "pareto: {points: 5}\nproof: false\nposes: {Q0: [0, 0, 0]}\nsweep:"),
        ("  length:", "  more: {maximise: scale, goal: 2}\n  length:"),
    )
    assert told(found) == [
        ("manipulator.leg_lengths.2", "changed", "other", 0.3),
        ("measures.transmission.levels.at_most.1", "changed", 1.8, 1.7),
        ("goals.length.goal", "changed", 0.3, 0.31),
        ("goals.length.weight", "changed", 1.0, "relative"),
        ("goals.more", "added", None, {"maximise": "scale", "goal": 2.0, "weight": 1.0}),
        ("poses.Q0", "added", None, [0.0, 0.0, 0.0]),
        ("sweep.to", "changed", 0.5, 0.45),
        ("proof", "changed", {"slack": 1e-3, "boxes": 50_000}, False),
        ("pareto", "added", None, {"points": 5}),
    ]


def test_the_order_of_variables_counts_as_it_does_for_the_result(tmp_path: Path) -> None:
    lines = SPEC.splitlines(keepends=True)
    lines[3], lines[4] = lines[4], lines[3]
    found = of_specs(tmp_path, (SPEC, "".join(lines)))
    assert told(found) == [("variables", "changed", ["leg", "other"], ["other", "leg"])]


def test_of_a_catalogue_the_choices_are_compared(tmp_path: Path) -> None:
    text = SPEC.replace("leg: {min: 250 mm, max: 500 mm}", "leg: {choices: [250 mm, 300 mm, 350 mm]}")
    found = of_specs(tmp_path, (", 350 mm]", ", 360 mm, 400 mm]"), text=text)
    assert told(found) == [
        ("variables.leg.choices.2", "changed", 0.35, 0.36),
        ("variables.leg.choices.3", "added", None, 0.4),
    ]


def test_a_result_is_compared_in_what_it_found(tmp_path: Path) -> None:
    other = copy.deepcopy(RESULT)
    other |= {"title": "Another", "status": "attained", "variables": {"leg": 0.29}}
    other["attainment"]["goals"]["length"] |= {"value": 0.29, "attained": True}
    other["workspace"]["joint"] |= {"ties": 1, "min": [0.0, 0.0, 0.0], "scale": 1.03}
    other["workspace"]["joint"]["proof"] = {"verdict": "undecided", "slack": 1e-3, "boxes": 9}
    measure = other["workspace"]["measures"]["transmission"]
    measure |= {"highest": {"value": 1.9, "at": [0.0, 0.0, 0.0]}, "lowest": None, "poses": {"Q0": [0.9, 1.2]}}
    other["limits"] = [{**RESULT["limits"][1], "gain": 5e-10}, {**RESULT["limits"][0], "cost": 3e-3}]
    other["provenance"] = {"orthospec": "0.2.0", "spec_sha256": "1" * 64}
    at = "workspace.measures.transmission"
    assert told(of_results(tmp_path, other)) == [
        ("status", "changed", "compromise", "attained"),
        ("attainment.goals.length.value", "changed", 0.31, 0.29),
        ("attainment.goals.length.attained", "changed", False, True),
        ("variables.leg", "changed", 0.31, 0.29),
        ("workspace.joint.scale", "changed", 1.02, 1.03),
        ("workspace.joint.proof.verdict", "changed", "proved", "undecided"),
        (f"{at}.lowest", "changed", {"value": 0.5}, None),
        (f"{at}.highest.value", "changed", 2.0, 1.9),
        (f"{at}.poses.Q0.1", "changed", 1.1, 1.2),
        ("limits.bound.transmission.at_most.cost", "changed", 2e-3, 3e-3),
        ("provenance.orthospec", "changed", "0.1.0", "0.2.0"),
    ]


def test_sets_of_designs_are_compared_entry_by_entry(tmp_path: Path) -> None:
    point = {key: RESULT[key] for key in ("attainment", "variables", "manipulator", "workspace")}
    moved = copy.deepcopy(point)
    moved["attainment"]["goals"]["length"]["value"] = 0.32
    swept = {key: part for key, part in moved.items() if key != "attainment"} | {"variables": {"leg": 0.4}}
    other = copy.deepcopy(RESULT) | {"pareto": [moved], "sweep": [swept, swept]}
    (tmp_path / "c.yaml").write_text(dump(copy.deepcopy(RESULT) | {"pareto": [point], "sweep": [point]}))
    of_results(tmp_path, other)
    found = compare(read_side(tmp_path / "c.yaml"), read_side(tmp_path / "b.yaml"))
    assert [row[:2] for row in told(found)] == [
        ("pareto.0.goals.length", "changed"),
        ("sweep.0.variables.leg", "changed"),
        ("sweep.1", "added"),
    ]


def test_rounding_of_another_processor_is_no_difference(tmp_path: Path) -> None:
    def rounded(part: Any) -> Any:
        if isinstance(part, dict):
            return {key: rounded(inner) for key, inner in part.items()}
        if isinstance(part, list):
            return [rounded(inner) for inner in part]
        return part * (1 + 5e-10) if isinstance(part, float) else part

    assert of_results(tmp_path, rounded(RESULT)).changed == ()


def test_only_two_of_a_kind_are_compared(tmp_path: Path) -> None:
    (tmp_path / "spec.yaml").write_text(SPEC)
    (tmp_path / "result.yaml").write_text(dump(RESULT))
    a, b = read_side(tmp_path / "spec.yaml"), read_side(tmp_path)
    assert (a.kind, b.kind) == ("spec", "result")
    assert b.spec is not None
    with pytest.raises(UsageError, match=r"spec.yaml is a spec and .* is a result: two specs or two results"):
        compare(a, b)
    with pytest.raises(UsageError, match="nowhere: no such file"):
        read_side(tmp_path / "nowhere")


def test_a_copy_is_resolved_where_its_original_stands(tmp_path: Path) -> None:
    specs = Path(__file__).parents[1] / "specs"
    copied = tmp_path / "blob.yaml"
    copied.write_bytes((specs / "orthoglide-200-drives.yaml").read_bytes())
    with pytest.raises(SpecError, match="no such file"):
        read_side(copied)
    original = specs / "orthoglide-200-drives.yaml"
    assert compare(read_side(original), read_side(copied, stands_for=original)).changed == ()


ASKED = ["s.yaml", "/tmp/old", "a1b2c3d4e5", "100644", "s.yaml", "0" * 40, "100644"]


def test_git_s_arguments_are_told_from_two_files() -> None:
    assert git_call(["a", "b"], {"GIT_DIFF_PATH_COUNTER": "1"}) is None
    assert git_call(["a"], {}) is None
    assert git_call([], {}) is None
    unmerged = git_call(["a"], {"GIT_DIFF_PATH_COUNTER": "1"})
    assert unmerged is not None
    assert (unmerged.old, unmerged.new) == (None, None)
    call = git_call(ASKED, {})
    assert call is not None
    assert (call.path, call.old, call.new) == (Path("s.yaml"), Path("/tmp/old"), Path("s.yaml"))
    assert (call.old_name, call.new_name) == ("s.yaml (a1b2c3d)", "s.yaml (in the working tree)")
    renamed = git_call([*ASKED, "t.yaml", "similarity index 90%\n"], {})
    assert renamed is not None
    assert renamed.new_name == "t.yaml (in the working tree)"


def test_a_new_file_is_told_by_its_lines(tmp_path: Path) -> None:
    (tmp_path / "new").write_text("one\ntwo\n")
    call = git_call(["s.yaml", "/dev/null", ".", ".", str(tmp_path / "new"), "a" * 40, "100644"], {})
    assert call is not None
    assert line_by_line(call).splitlines()[-2:] == ["+one", "+two"]

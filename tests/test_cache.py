"""What is kept: found again whatever was killed in between, never for anything else nor when damaged."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from orthospec.errors import UsageError
from orthospec.optimise import evaluate_spec, remembering, solve, versions
from orthospec.optimise.cache import Cache, Remembering, sha256_of, user_cache
from orthospec.optimise.kept_fields import KeptFields
from orthospec.optimise.space import DesignSpace
from orthospec.optimise.tasks import Task, problem_of
from orthospec.optimise.workers import Here, in_order
from orthospec.registry import Installed
from orthospec.result import compose
from orthospec.spec import Spec
from orthospec.spec.writing import dump
from orthospec.workspace import field
from orthospec.workspace.grid import Grid

SPEC = """\
orthospec: 1
title: Small
variables: {leg: {min: 250 mm, max: 500 mm}}
manipulator: {use: orthoglide, leg_lengths: [leg, leg, leg]}
workspace: {size: [200 mm, 200 mm, 200 mm], divisions: 5}
measures:
  transmission: {use: velocity_transmission, at_least: 0.5, at_most: 2}
goals: {legs: {minimise: leg, goal: 300 mm}}
optimise: {starts: 3}
"""


@dataclass(frozen=True)
class Tally:
    """A result, and how much of it was known before."""

    text: str
    known: int
    asked: int


@pytest.fixture(scope="module")
def kept(tmp_path_factory: pytest.TempPathFactory, spec_of: Callable[..., Spec]) -> Callable[..., Tally]:
    """Solves with one and the same cache, in which the spec as it stands is known."""
    folder = tmp_path_factory.mktemp("kept")

    def run(text: str = SPEC, *settings: str) -> Tally:
        with remembering(Here(), folder) as workers:
            spec = spec_of(text, *settings)
            finding = solve(spec, workers=workers).finding
            return Tally(dump(compose(spec, finding)), workers.known, workers.asked)

    assert run().known == 0
    return run


def test_what_is_kept_is_what_is_made(kept: Callable[..., Tally], spec_of: Callable[..., Spec]) -> None:
    spec = spec_of(SPEC)
    again = kept()
    assert again.known == again.asked > 0
    assert again.text == dump(compose(spec, solve(spec).finding))


@pytest.mark.parametrize(
    "change",
    [
        ("title: Small", "title: Other\nnotes: [many]"),
        ("250 mm", "0.25"),
        ("goals:", "# Aims.\ngoals:"),
        ("orthospec: 1\n", "# Mine.\n\northospec: 1\n"),
    ],
)
def test_what_changes_no_result_computes_nothing(kept: Callable[..., Tally], change: tuple[str, str]) -> None:
    found = kept(SPEC.replace(*change))
    assert found.known == found.asked


@pytest.mark.parametrize(
    ("setting", "remade"),
    [
        ("poses={Q: [0, 0, 0]}", 1),
        ("measures.transmission.levels={at_most: [1.5]}", 1),
        ("sweep={variable: leg, from: 0.3, to: 0.4, points: 2}", 2),
        ("variables.leg.start=0.3", None),
        ("measures.transmission.at_most=2.01", None),
    ],
)
def test_only_what_depends_on_a_change_is_made_anew(
    kept: Callable[..., Tally], setting: str, remade: int | None
) -> None:
    found = kept(SPEC, setting)
    if remade is not None:
        assert found.asked - found.known == remade
    else:
        assert found.known < found.asked


CHEAP = SPEC.replace("min: 250 mm, max: 500 mm", "min: 250 mm, max: 500 mm, start: 330 mm")


@pytest.fixture
def measured(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """How many poses of the grid the measure was asked for."""
    counts: list[int] = []
    measure = field.measured

    def counting(demand: Any, manipulator: Any, poses: Any) -> Any:
        counts.append(len(poses))
        return measure(demand, manipulator, poses)

    monkeypatch.setattr(field, "measured", counting)
    return counts


def test_another_bound_reuses_the_field_of_a_design_and_gives_the_same_bytes(
    tmp_path: Path, spec_of: Callable[..., Spec], measured: list[int]
) -> None:
    def evaluated(*settings: str, folder: Path) -> str:
        measured.clear()
        with remembering(Here(), folder) as workers:
            spec = spec_of(CHEAP, *settings)
            return dump(compose(spec, evaluate_spec(spec, workers=workers).finding))

    evaluated(folder=tmp_path / "one")
    assert sum(measured) > 1000
    moved = "measures.transmission={use: velocity_transmission, at_most: 2.2, levels: {at_most: [1.8]}}"
    reused = evaluated(moved, folder=tmp_path / "one")
    assert not measured
    assert reused == evaluated(moved, folder=tmp_path / "two")
    assert measured
    for changed in ("workspace.divisions=6", "variables.leg.start=0.34", "manipulator.branch=[1, 1, 1]"):
        evaluated(moved, changed, folder=tmp_path / "one")
        assert measured, changed


def test_a_damaged_field_counts_as_none(tmp_path: Path, spec_of: Callable[..., Spec]) -> None:
    random, grid = np.random.default_rng(0), Grid((0.1,) * 3, (0,) * 3, (4,) * 3, 3)
    kept = KeptFields(Cache(tmp_path), DesignSpace(spec_of(SPEC)), [0.3])
    reachable = random.random(50) < 0.6
    values = random.random((int(reachable.sum()), 2))
    assert kept.read("transmission", grid, 10, 60) is None
    kept.write(field.Block(10, reachable, {"transmission": values}), grid)
    found = kept.read("transmission", grid, 10, 60)
    assert found is not None
    assert found.start == 10
    np.testing.assert_array_equal(found.reachable, reachable)
    np.testing.assert_array_equal(found.values["transmission"], values)
    (file,) = (path for path in tmp_path.rglob("*") if path.is_file())
    whole = file.read_bytes()
    for at in range(0, len(whole), 7):
        flipped = whole[:at] + bytes([whole[at] ^ 2]) + whole[at + 1 :]
        for damaged in (whole[:at], flipped):
            file.write_bytes(damaged)
            assert kept.read("transmission", grid, 10, 60) is None


def test_a_damaged_file_counts_as_none(tmp_path: Path) -> None:
    cache = Cache(tmp_path)
    cache.write("abc", {"made": [0.1, "text"]})
    assert cache.read("abc") == {"made": [0.1, "text"]}
    (file,) = (path for path in tmp_path.rglob("*") if path.is_file())
    whole = file.read_bytes()
    for damaged in (b"", whole[:-1], whole.replace(b"0.1", b"0.2"), b"\xff" + whole):
        file.write_bytes(damaged)
        assert cache.read("abc") is None
    file.write_bytes(whole)
    assert cache.read("abc") is not None


def test_only_what_has_not_been_used_for_longest_is_removed(tmp_path: Path) -> None:
    cache = Cache(tmp_path)
    keys = [sha256_of(name) for name in "abc"]
    (tmp_path / keys[0][:2]).mkdir()
    others = [tmp_path / "thesis.doc", tmp_path / keys[0][:2] / "thesis.json"]
    for age, path in enumerate([*others, *map(cache.path, reversed(keys))]):
        if path in others:
            path.write_text("x" * 5000)
        else:
            cache.write(path.stem, "x" * 1000)
        os.utime(path, (age, age))
    cache.read(keys[2])
    cache.trim(2500)
    cache.trim(0, kind=".field")
    assert [cache.read(key) is not None for key in keys] == [True, False, True]
    assert all(path.exists() for path in others)


def test_a_folder_that_cannot_be_written_is_told(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(UsageError, match="results cannot be kept there"):
        Cache(tmp_path / "file" / "cache")


def test_where_the_users_folder_cannot_be_written_the_run_goes_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, spec_of: Callable[..., Spec]
) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    space = DesignSpace(spec_of(SPEC))
    with remembering(Here()) as workers:
        assert in_order(workers, Task("twice", _twice, problem_of), space, [1.0]) == [2.0]
        assert in_order(workers, Task("twice", _twice, problem_of), space, [1.0]) == [2.0]
    assert (workers.known, workers.asked) == (1, 2)


def test_the_users_folder_is_the_one_of_the_system() -> None:
    assert user_cache().name == "orthospec"


def _twice(space: DesignSpace, item: float, _: Any) -> float:  # noqa: ARG001
    return 2 * item


def test_what_may_not_last_is_made_each_time(tmp_path: Path, spec_of: Callable[..., Spec]) -> None:
    space = DesignSpace(spec_of(SPEC))
    task = Task("twice", _twice, problem_of, lasting=lambda made: made > 4)
    for known in (0, 2):
        workers = Remembering(Here(), Cache(tmp_path))
        assert in_order(workers, task, space, [1.0, 2.5, 2.0, 3.0]) == [2.0, 5.0, 4.0, 6.0]
        assert workers.known == known


def test_edited_code_finds_nothing_of_before(
    tmp_path: Path, spec_of: Callable[..., Spec], monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "stranger").mkdir()
    module = tmp_path / "stranger" / "__init__.py"
    module.write_text("ONE = 1\n")
    monkeypatch.syspath_prepend(tmp_path)
    __import__("stranger")
    before = versions._hash_of("stranger")
    versions._hash_of.cache_clear()
    assert versions._hash_of("stranger") == before
    module.write_text("ONE = 2\n")
    versions._hash_of.cache_clear()
    assert versions._hash_of("stranger") != before
    spec = spec_of(SPEC)
    known = versions.fingerprint(spec)
    monkeypatch.setattr(versions, "_hash_of", lambda _: "edited")
    assert versions.fingerprint(spec) != known


@pytest.mark.parametrize(
    ("name", "counts"),
    [
        ("data/table.csv", True),
        ("_fast.so", True),
        ("__pycache__/a.cpython-312.pyc", False),
        (".DS_Store", False),
    ],
)
def test_all_that_lies_in_a_plugins_package_counts_but_caches(
    name: str, counts: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    package = f"with_files_{abs(hash(name))}"
    file = tmp_path / package / name
    file.parent.mkdir(parents=True, exist_ok=True)
    (tmp_path / package / "__init__.py").write_text("")
    file.write_text("1")
    monkeypatch.syspath_prepend(tmp_path)
    __import__(package)
    before = versions._hash_of(package)
    file.write_text("2")
    versions._hash_of.cache_clear()
    assert (versions._hash_of(package) != before) == counts


def test_the_versions_of_what_a_plugin_requires_count(
    tmp_path: Path, spec_of: Callable[..., Spec], monkeypatch: pytest.MonkeyPatch
) -> None:
    def told(helper: str) -> str:
        for name, version, more in (
            ("made-up", "1.0", "Requires-Dist: made-up-helper>=1\nRequires-Dist: pytest; extra == 'test'\n"),
            ("made-up-helper", helper, ""),
        ):
            folder = tmp_path / f"{name.replace('-', '_')}.dist-info"
            folder.mkdir(exist_ok=True)
            (folder / "METADATA").write_text(
                f"Metadata-Version: 2.1\nName: {name}\nVersion: {version}\n{more}"
            )
        versions._required.cache_clear()
        return versions.fingerprint(spec)

    monkeypatch.syspath_prepend(tmp_path)
    spec = spec_of(SPEC)
    monkeypatch.setattr(Spec, "plugins", (Installed("", "", "made-up", "1.0", ""),))
    assert told("1.1") != told("1.2")
    assert versions._required("made-up") == ("made-up-helper 1.2",)


RUN = """
import os, signal, sys
from orthospec.optimise import cache
write, limit = cache.Cache.write, int(sys.argv.pop(1))
def writing(self, key, content):
    global limit
    limit -= 1
    if limit == 0:
        os.kill(os.getpid(), signal.SIGKILL)
    write(self, key, content)
cache.Cache.write = writing
from orthospec.cli import main
main()
"""


def test_a_run_that_was_killed_goes_on_and_ends_in_the_same_bytes(tmp_path: Path) -> None:
    (tmp_path / "small.yaml").write_text(SPEC)

    def run(*arguments: str, killed_at: int = -1) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, "-P", "-c", RUN, str(killed_at), "run", "small.yaml", *arguments]
        return subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=100, check=False)

    whole = run("-o", "whole", "--cache", "one")
    assert whole.returncode == 0, whole.stderr
    for killed_at in (5, 8):
        assert run("--cache", "two", killed_at=killed_at).returncode == -signal.SIGKILL
        assert not (tmp_path / "runs").exists()
    resumed = run("--cache", "two", "--resume")
    assert resumed.returncode == 0, resumed.stderr
    known, asked = (int(word) for word in resumed.stderr.splitlines()[-1].split() if word.isdigit())
    assert 5 <= known < asked
    assert resumed.stdout.replace("runs/small", "whole") == whole.stdout
    for name in ("result.yaml", "spec.yaml"):
        assert (tmp_path / "runs" / "small" / name).read_bytes() == (tmp_path / "whole" / name).read_bytes()
    log = json.loads((tmp_path / "runs" / "small" / "run.log.json").read_text())
    assert [one["start"] for one in log["solves"]]

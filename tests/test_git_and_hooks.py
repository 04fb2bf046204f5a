"""What docs/diff.md tells a reader to set up, set up: git's diff driver, and the hook that checks specs."""

from __future__ import annotations

import os
import re
import shlex
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
import yaml
from typer.testing import CliRunner

from orthospec.cli import app

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "docs" / "diff.md").read_text(encoding="utf-8")
Git = Callable[..., str]


@pytest.fixture
def specs(tmp_path: Path) -> Path:
    """The folder of specs in a working tree that is set up as the page says."""
    (tmp_path / ".gitattributes").write_text(block("In git", "text"))
    source, folder = ROOT / "specs", tmp_path / "specs"
    solved = folder / "solved" / "orthoglide-200"
    solved.mkdir(parents=True)
    for name in ("orthoglide-200-drives.yaml", "solved/orthoglide-200/result.yaml"):
        (folder / name).write_bytes((source / name).read_bytes())
    return folder


@pytest.fixture
def git(specs: Path) -> Git:
    environment = {key: value for key, value in os.environ.items() if not key.startswith("GIT_")}
    environment |= {"GIT_CONFIG_GLOBAL": os.devnull, "GIT_CONFIG_NOSYSTEM": "1"}
    environment["PATH"] = os.pathsep.join([str(Path(sys.executable).parent), environment["PATH"]])

    def call(*arguments: str) -> str:
        asked = ["git", "-c", "user.name=a", "-c", "user.email=a@b", *arguments]
        done = subprocess.run(
            asked, cwd=specs, env=environment, capture_output=True, text=True, encoding="utf-8", check=False
        )
        assert done.returncode == 0, done.stderr
        return done.stdout

    call("init", "-q", "..")
    call(*shlex.split(block("In git", "sh"))[1:])
    call("add", "--all", "..")
    call("commit", "-qm", "first")
    return call


def block(heading: str, language: str, which: int = 0) -> str:
    """A fenced block under a heading of the page."""
    section = PAGE.split(f"\n## {heading}\n")[1].split("\n## ")[0]
    return re.findall(rf"```{language}\n(.*?)^```$", section, re.DOTALL | re.MULTILINE)[which]


def test_git_shows_what_a_spec_and_a_result_mean(specs: Path, git: Git) -> None:
    """From a folder below the top; git's copy of the spec has not the solved machine beside it."""
    drives, result = specs / "orthoglide-200-drives.yaml", specs / "solved" / "orthoglide-200" / "result.yaml"
    text = drives.read_text()
    drives.write_text(text.replace("at_most: 17 kg", "at_most: 18000 g").replace("2000 N", "2 kN"))
    result.write_text(result.read_text().replace("stroke: 0.25699", "stroke: 0.26699"))
    lines = git("diff").splitlines()
    assert "  effective_mass.at_most  17000 g  18000 g  +1000 g  +5.88 %" in lines
    assert "  stroke  0.256993  0.266993  +0.01  +3.89 %" in lines
    assert sum(line.startswith("1 value differs") for line in lines) == 2


def test_git_goes_on_with_lines_where_there_is_no_meaning(specs: Path, git: Git) -> None:
    drives = specs / "orthoglide-200-drives.yaml"
    drives.write_text(drives.read_text() + "wrong: 1\n")
    lines = git("diff").splitlines()
    assert lines[0].startswith("specs/orthoglide-200-drives.yaml:49:1: unknown key 'wrong'")
    assert "+wrong: 1" in lines


def test_the_hook_runs_check_on_specs_alone(tmp_path: Path) -> None:
    (hook,) = yaml.safe_load((ROOT / ".pre-commit-hooks.yaml").read_text())
    assert {"id", "name", "entry", "language", "files"} <= hook.keys()
    command, *arguments = shlex.split(hook["entry"])
    files = [str(path.relative_to(ROOT)) for path in ROOT.glob("specs/**/*.yaml")]
    chosen = sorted(name for name in files if re.search(hook["files"], name))
    assert command == "orthospec"
    assert chosen == sorted(str(path.relative_to(ROOT)) for path in ROOT.glob("specs/*.yaml"))
    assert len(chosen) < len(files)
    held = CliRunner().invoke(app, [*arguments, *(str(ROOT / name) for name in chosen)])
    assert held.exit_code == 0, held.output
    (tmp_path / "wrong.yaml").write_text("orthospec: 1\n")
    refused = CliRunner().invoke(app, [*arguments, str(ROOT / chosen[0]), str(tmp_path / "wrong.yaml")])
    assert refused.exit_code == 2


def test_the_page_s_configuration_asks_for_the_hook_there_is() -> None:
    (hook,) = yaml.safe_load((ROOT / ".pre-commit-hooks.yaml").read_text())
    (repository,) = yaml.safe_load(block("Before a commit", "yml"))["repos"]
    (asked,) = repository["hooks"]
    assert asked["id"] == hook["id"]
    assert re.search(asked["files"], "specs/orthoglide-200.yaml")
    assert not re.search(asked["files"], "specs/solved/orthoglide-200/result.yaml")


def test_the_page_s_own_hook_checks_what_is_to_be_committed(specs: Path, git: Git) -> None:
    hook = specs.parent / ".git" / "hooks" / "pre-commit"
    hook.parent.mkdir(exist_ok=True)
    hook.write_text(block("Before a commit", "sh"))
    hook.chmod(0o755)
    drives = specs / "orthoglide-200-drives.yaml"
    drives.write_text(drives.read_text() + "# a comment\n")
    git("commit", "-qam", "holds")
    drives.write_text(drives.read_text() + "wrong: 1\n")
    with pytest.raises(AssertionError, match="unknown key 'wrong'"):
        git("commit", "-qam", "wrong")

"""What differs from a git revision, and the comment that is made of it."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import pytest
import yaml
from typer.testing import CliRunner

from orthospec.cli import app
from orthospec.compare import changed_since
from orthospec.errors import UsageError
from orthospec.show import comment

SPEC = """\
orthospec: 1
title: Legs
variables: {leg: {min: 250 mm, max: 500 mm}}
manipulator: {use: orthoglide, leg_lengths: [leg, leg, leg]}
workspace: {size: [200 mm, 200 mm, 200 mm]}
measures: {transmission: {use: velocity_transmission, at_most: 2}}
goals: {length: {minimise: leg, goal: 300 mm}}
"""


pytestmark = pytest.mark.usefixtures("repository")


def git(*arguments: str) -> None:
    identity = ["-c", "user.name=a", "-c", "user.email=a@example.com", "-c", "init.defaultBranch=main"]
    subprocess.run(["git", *identity, *arguments], check=True, capture_output=True)


@pytest.fixture
def repository(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    git("init")
    Path("legs.yaml").write_text(SPEC)
    Path("other.yaml").write_text(SPEC)
    Path("gone.yaml").write_text(SPEC)
    Path("notes.yaml").write_text("a: 1\n")
    git("add", ".")
    git("commit", "-m", "first")
    return tmp_path


def test_nothing_that_differs_is_said() -> None:
    assert changed_since("HEAD") == []
    assert comment([], "HEAD") == "No spec and no result differs from `HEAD`.\n"


def test_each_spec_that_differs_is_found_and_nothing_else() -> None:
    Path("legs.yaml").write_text(SPEC.replace("at_most: 2", "at_most: 2.2"))
    Path("other.yaml").write_text("# only words\n" + SPEC.replace("title: Legs", "title: Other legs"))
    Path("gone.yaml").unlink()
    Path("notes.yaml").write_text("a: 2\n")
    Path("new.yaml").write_text(SPEC)
    git("add", "--all")
    found = {one.path: one for one in changed_since("HEAD")}
    assert set(found) == {"legs.yaml", "other.yaml", "gone.yaml", "new.yaml"}
    assert (found["gone.yaml"].said, found["new.yaml"].said) == ("removed", "new")
    text = comment(list(found.values()), "HEAD")
    assert "| transmission.at\\_most | 2 | 2.2 | +0.2 | +10 % |" in text
    assert "**other.yaml**: the same in meaning" in text
    assert "**gone.yaml**: removed" in text


def test_a_spec_with_mistakes_is_told_with_their_places() -> None:
    Path("legs.yaml").write_text(SPEC.replace("use: orthoglide", "use: orthoglyde"))
    (one,) = changed_since("HEAD")
    assert "legs.yaml:4:" in one.said
    assert "did you mean" in comment([one], "HEAD")


def test_a_key_before_the_format_and_an_untracked_file_hide_nothing() -> None:
    Path("legs.yaml").write_text("title: First\n" + SPEC.replace("title: Legs\n", "").replace("2}}", "2.5}}"))
    Path("untracked.yaml").write_text(SPEC)
    assert [(one.path, one.said) for one in changed_since("HEAD")] == [
        ("legs.yaml", ""),
        ("untracked.yaml", "new"),
    ]


def test_a_revision_is_never_an_option_of_git() -> None:
    with pytest.raises(UsageError, match="is no revision"):
        changed_since("--output=pwned")
    assert not Path("pwned").exists()


def test_what_a_user_wrote_is_text_in_the_comment() -> None:
    Path("legs.yaml").write_text(SPEC.replace("orthoglide,", "<b>x</b>,").replace("at_most: 2", "at_mots: 2"))
    (one,) = changed_since("HEAD")
    text = comment([one], "HEAD")
    assert "<b>" not in text
    assert text.count("\n* legs.yaml:") == 3


def test_a_comment_is_no_longer_than_hosts_take() -> None:
    from orthospec.compare import Changed

    text = comment([Changed(f"{k}.yaml", None, "x" * 1000) for k in range(100)], "main")
    assert len(text) < 65_000
    assert "more: `orthospec diff --since` tells them." in text


def test_from_a_folder_below_paths_are_found(repository: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    Path("legs.yaml").write_text(SPEC.replace("at_most: 2", "at_most: 2.2"))
    (repository / "below").mkdir()
    monkeypatch.chdir(repository / "below")
    assert [one.path for one in changed_since("HEAD")] == ["legs.yaml"]


def test_a_revision_that_there_is_not_is_told() -> None:
    with pytest.raises(UsageError, match=r"git: 'nowhere' is no revision"):
        changed_since("nowhere")


def test_the_command_writes_markdown_json_and_text() -> None:
    Path("legs.yaml").write_text(SPEC.replace("goal: 300 mm", "goal: 310 mm"))
    run = CliRunner().invoke
    assert (
        "### Specs and results that differ from `HEAD`"
        in run(app, ["diff", "--since", "HEAD", "--markdown"]).stdout
    )
    (entry,) = json.loads(run(app, ["diff", "--since", "HEAD", "--json", "--changed"]).stdout)
    assert entry["path"] == "legs.yaml"
    assert entry["rows"][0]["difference"] == pytest.approx(0.01)
    assert "length.goal" in run(app, ["diff", "--since", "HEAD"]).stdout
    assert run(app, ["diff", "--since", "HEAD", "legs.yaml"]).exit_code == 2
    pair = run(app, ["diff", "legs.yaml", "other.yaml", "--markdown"]).stdout
    assert "**legs.yaml, other.yaml**: 1 value differs" in pair


def test_the_workflow_in_the_pages_calls_it_and_nothing_else() -> None:
    page = (Path(__file__).parents[1] / "docs" / "diff.md").read_text()
    text = page.split("<!-- workflow -->\n```yml\n")[1].split("```")[0]
    steps = yaml.safe_load(text)["jobs"]["compare"]["steps"]
    ran = [step["run"] for step in steps if "run" in step]
    assert ran[1] == 'orthospec diff --since "origin/$GITHUB_BASE_REF" --markdown > comment.md'
    assert steps[0]["with"]["fetch-depth"] == 0

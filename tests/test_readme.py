"""What the README and the pages in docs/ say, held to what the code does."""

from __future__ import annotations

import importlib.util
import re
import shlex
import tomllib
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
import typer
import yaml

from orthospec import registry
from orthospec.cli import app
from orthospec.intervals import Boxes
from orthospec.measures import Demand
from orthospec.measures.elastic import Deflection
from orthospec.measures.kinematic import ConditionNumber
from orthospec.mechanics.materials import TABLE
from orthospec.optimise import Outcome, solve
from orthospec.optimise.hunt import hunt
from orthospec.optimise.space import DesignSpace
from orthospec.optimise.workers import Here
from orthospec.result import compose
from orthospec.show import installed, show
from orthospec.show.keys import keys_of
from orthospec.spec import load_spec
from orthospec.workspace.cuboid import Cuboid
from orthospec.workspace.evaluate import Setting, evaluate
from orthospec.workspace.machine import Machine
from orthospec.workspace.proof import prove

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")
PAGES = [
    ROOT / "README.md",
    ROOT / "CHANGELOG.md",
    *sorted(ROOT.glob("docs/**/*.md")),
    *sorted(ROOT.glob("plugins/*/README.md")),
]
SYMMETRIC = 1.5529143
"""Equal legs for the unit cube, as the paper's comparison has them."""

UNITS = {"": 1.0, "m": 1.0, "mm": 1e-3}
OutcomeOf = Callable[..., Outcome]


def blocks(page: Path, language: str) -> Iterator[tuple[str, str]]:
    """The fenced blocks of a page, each with the comment before it."""
    pattern = rf"(?:<!-- (.*?) -->\n)?```{language}\n(.*?)^```$"
    for found in re.finditer(pattern, page.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE):
        yield found[1] or "", found[2]


def table(name: str, page: str = README) -> list[list[str]]:
    """The cells of the rows that follow <!-- table: NAME --> in a page."""
    rows = page.split(f"<!-- table: {name} -->\n")[1].split("\n\n")[0].splitlines()[2:]
    return [[cell.strip() for cell in re.split(r"(?<!\\)\|", row)[1:-1]] for row in rows]


def decimals(number: str) -> int:
    return len(number.partition(".")[2])


def named(cases: list[Any]) -> list[Any]:
    return [pytest.param(*case[1:], id=case[0]) for case in cases]


SPECS = [
    (f"{page.parent.name or 'README'} {page.name} {i}", block)
    for page in PAGES
    for i, (_, block) in enumerate(blocks(page, "yaml"))
]


@pytest.mark.parametrize("block", named(SPECS))
def test_each_spec_in_the_pages_loads(block: str, tmp_path: Path) -> None:
    """A piece of a spec is tried in the README's first one, in place of its own sections."""
    first = next(blocks(ROOT / "README.md", "yaml"))[1]
    path = tmp_path / "spec.yaml"
    (tmp_path / "solved").symlink_to(ROOT / "specs" / "solved")
    if not block.startswith("orthospec:"):
        block = yaml.safe_dump(yaml.safe_load(first) | yaml.safe_load(block))
    path.write_text(block)
    load_spec(path)


def test_the_readmes_first_spec_is_the_one_that_its_command_runs() -> None:
    first = yaml.safe_load(next(blocks(ROOT / "README.md", "yaml"))[1])
    run = yaml.safe_load((ROOT / "specs" / "orthoglide-200.yaml").read_text())
    run.pop("notes")
    assert first == run


def test_each_command_has_help_and_stands_in_the_readme_with_its_options() -> None:
    commands = typer.main.get_command(app).commands  # type: ignore[attr-defined]
    in_readme = dict(re.findall(r"^\| `orthospec ([\w-]+)(.*?)` \|", README, re.MULTILINE))
    assert in_readme.keys() == commands.keys()
    for name, command in commands.items():
        assert command.help, name
        told = set(re.findall(r"(?<![-\w])--?[a-z][a-z-]*", in_readme[name]))
        options = [parameter.opts for parameter in command.params if parameter.opts[0].startswith("-")]
        assert len(told) == len(options), name
        assert all(told & set(names) for names in options), name


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_each_link_leads_to_a_file_and_a_heading(page: Path) -> None:
    for target in re.findall(r"\]\((?!http)([^)]+)\)", page.read_text(encoding="utf-8")):
        path, _, heading = target.partition("#")
        file = (page.parent / path).resolve() if path else page
        assert file.exists(), target
        if heading:
            headings = re.findall(r"^#+ (.*)$", file.read_text(encoding="utf-8"), re.MULTILINE)
            assert heading in {re.sub(r"[^\w -]", "", h).lower().replace(" ", "-") for h in headings}, target


def test_the_change_log_begins_with_the_version_at_hand() -> None:
    version = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["version"]
    latest = re.search(r"^## (\S+)", (ROOT / "CHANGELOG.md").read_text(), re.MULTILINE)
    assert latest is not None
    assert version == latest[1]


def test_the_table_of_packages_is_the_import_contract() -> None:
    page = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    told = re.findall(r"^\| `(\w+)` \|", page.split("## Decisions")[0], re.MULTILINE)
    contract = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["importlinter"]["contracts"][0]
    assert told == [layer.removeprefix("orthospec.") for layer in reversed(contract["layers"])]


def test_the_table_has_every_spec_once() -> None:
    linked = [re.search(r"\]\((.*?)\)", row[0])[1] for row in table("specs")]  # type: ignore[index]
    here = [str(path.relative_to(ROOT)) for path in ROOT.glob("specs/*.yaml")]
    theirs = [str(path.relative_to(ROOT)) for path in ROOT.glob("plugins/*/specs/*.yaml")]
    assert sorted(linked) == sorted([*here, *theirs])


@pytest.mark.parametrize(
    ("path", "status", "gives", "subproblems"),
    named([(*re.findall(r"\[(.*?)\]\((.*?)\)", row[0])[0], *row[2:]) for row in table("specs")]),
)
def test_the_figures_of_the_specs_are_true(
    path: str, status: str, gives: str, subproblems: str, outcome_of: OutcomeOf
) -> None:
    ours = path.startswith("specs/")
    outcome = outcome_of(Path(path).stem) if ours else solve(load_spec(ROOT / path, ("proof=false",)))
    figures = re.findall(r"(\S+) = (\S+?)(?: (mm|m))?(?:,|$)", gives)
    assert figures
    assert outcome.finding.status == status
    for name, number, unit in figures:
        found = figure(outcome, name.strip("`")) / UNITS[unit]
        assert round(found, decimals(number)) == pytest.approx(float(number), abs=1e-12), name
    search = outcome.finding.search
    taken = 0 if search is None else search.subproblems
    # Another processor rounds otherwise, and may take a few steps more or less.
    said = int(subproblems or 0)
    assert abs(taken - said) <= max(3, said // 2), taken


def figure(outcome: Outcome, name: str) -> float:
    """A figure as the table names it."""
    finding, evaluation = outcome.finding, outcome.finding.evaluation
    if name == "λ":
        assert finding.attainment is not None
        assert finding.attainment.factor is not None
        return finding.attainment.factor
    kind, _, measure = name.rstrip(")").partition("(")
    if measure:
        record = evaluation.measures[measure]
        return record.largest.scale if kind == "scale" else getattr(record, kind).value  # type: ignore[union-attr]
    joint = {"scale": evaluation.joint.scale} if evaluation.joint else {}
    return {**finding.design.values, **evaluation.indices, **joint}[name]


@pytest.mark.parametrize(("asked", "base", "third", "base_change", "third_change"), named(table("finding")))
def test_the_finding_about_different_legs_is_true(
    asked: str, base: str, third: str, base_change: str, third_change: str, outcome_of: OutcomeOf
) -> None:
    values = design(*re.findall(r"`(.*?)`", asked), outcome_of=outcome_of)
    for name, written, change in (("base", base, base_change), ("third", third, third_change)):
        assert round(values[name], decimals(written)) == pytest.approx(float(written), abs=1e-12)
        percent = 100 * (values[name] / SYMMETRIC - 1)
        assert percent == pytest.approx(float(change.removesuffix(" %").replace("−", "-")), abs=0.05001)


def design(name: str, *settings: str, outcome_of: OutcomeOf) -> Mapping[str, float]:
    """The best design; where the spec is changed, without what is measured and priced beside."""
    if not settings:
        return outcome_of(name).finding.design.values
    space = DesignSpace(load_spec(ROOT / "specs" / f"{name}.yaml", settings))
    best = hunt(space, Here()).best
    assert best is not None
    return space.values(best.end.design)


OUTPUTS = [
    (f"{page.name} {note}", note, block)
    for page in (ROOT / "README.md", ROOT / "docs" / "tutorial.md")
    for note, block in blocks(page, "text")
    if note.startswith("output")
]


@pytest.mark.parametrize(("note", "block"), named(OUTPUTS))
def test_the_output_in_the_readme_is_what_is_printed(note: str, block: str, outcome_of: OutcomeOf) -> None:
    """Places of equal extremes and counts of nodes on a bound are left to the processor's rounding."""
    _, path, *options = shlex.split(note.removeprefix("output: "))
    settings = [option for option in options if option != "--set"]
    outcome = outcome_of(Path(path).stem, *settings, "proof.slack=1e-3")
    spec = load_spec(ROOT / path, settings)
    printed = show(compose(spec, outcome.finding), spec=spec, width=80, colour=False).splitlines()
    lines = [line for line in block.splitlines() if line and line != "..."]
    lines = [line for line in lines if not line.startswith("Written to")]
    assert [line for line in lines if not re.search(r"\bat \(|nodes: ", line) and line not in printed] == []


EXAMPLES = [
    (f"{page.name} {i}", note, block)
    for page in PAGES
    for i, (note, block) in enumerate(blocks(page, "python"))
]


@pytest.mark.parametrize(("note", "block"), named(EXAMPLES))
def test_each_example_in_python_runs(
    note: str, block: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(ROOT)
    imported(note.removeprefix("module: ") or "example", block, tmp_path)


def imported(name: str, source: str, folder: Path) -> ModuleType:
    """A module made of an example."""
    path = folder / f"{name}.py"
    path.write_text(source, encoding="utf-8")
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_manual_s_planar_machine_has_its_largest_square(tmp_path: Path) -> None:
    """κ = max(t, 1/t) with t = y / sqrt(L² − y²): a square of side L (k − 1) / sqrt(1 + k²)."""
    sources = dict(blocks(ROOT / "docs" / "plugins.md", "python"))
    machine = imported("biglide", sources["module: biglide"], tmp_path).Biglide(leg_length=0.4)
    bound = Demand("isotropy", ConditionNumber(), {"at_most": 3.0})
    region = Cuboid((-0.5, 0.0), (0.5, 0.4))
    found = evaluate(Machine(machine, {"isotropy": bound}), Setting(np.array([0.1, 0.1]), 10, region))
    assert found.joint is not None
    assert found.joint.cuboid is not None
    assert found.joint.scale * 0.1 == pytest.approx(0.4 * 2 / np.sqrt(10), rel=1e-7)
    assert found.joint.cuboid.low[1] == pytest.approx(0.4 / np.sqrt(10), rel=1e-7)
    claims = prove(Machine(machine, {"isotropy": bound}), found.joint.cuboid, slack=1e-6)
    assert [claim.verdict for claim in claims] == ["proved"] * 3


def test_the_manual_s_planar_machine_gives_as_a_truss_does(tmp_path: Path) -> None:
    """Under forces at the tool each leg is a bar: K = Σ u uᵀ / (c_a (u·e)² + c_l) in the plane."""
    sources = dict(blocks(ROOT / "docs" / "plugins.md", "python"))
    compliance = imported("biglide_compliance", sources["module: biglide_compliance"], tmp_path)
    poses, sliders = np.array([[0.0, 0.24], [0.05, 0.3]]), np.array([[-0.32, 0.32], [0.0, 0.0]])
    sliders[1] = poses[1, 0] + np.sqrt(0.4**2 - 0.3**2) * np.array([-1.0, 1.0])
    found = compliance.biglide_compliance(poses, sliders, 0.4, 20e6)
    along_leg = 0.4 / (210e9 * np.pi * 0.01**2)
    for pose, ends, C in zip(poses, sliders, found, strict=True):
        legs = np.stack([pose[0] - ends, np.full(2, pose[1])], axis=1) / 0.4
        stiffness = sum(np.outer(u, u) / (u[0] ** 2 / 20e6 + along_leg) for u in legs)
        assert C[:2, :2] == pytest.approx(np.linalg.inv(stiffness), rel=1e-9, abs=1e-18)


def test_the_manual_s_planar_machine_is_enclosed_without_a_line_for_it(tmp_path: Path) -> None:
    sources = dict(blocks(ROOT / "docs" / "plugins.md", "python"))
    base = imported("biglide", sources["module: biglide"], tmp_path).Biglide
    compliance = imported("biglide_compliance", sources["module: biglide_compliance"], tmp_path)

    class Elastic(base):  # type: ignore[misc, valid-type]
        def compliance(self, poses: Any) -> Any:
            sliders = self.inverse_kinematics(poses)[0]
            return compliance.biglide_compliance(poses, sliders, self.leg_length, 20e6)

    machine, measure = Elastic(leg_length=0.4), Deflection(force=100)
    random = np.random.default_rng(0)
    lo = random.uniform([-0.1, 0.15], [0.1, 0.3], (40, 2))
    boxes = Boxes(lo, lo + random.choice([0.0, 1e-6, 1e-3], (40, 1)))
    found = measure.enclosure(machine, boxes)
    assert found is not None
    for t in (0.0, 0.4, 1.0):
        values = measure.values(machine, boxes.lo + t * (boxes.hi - boxes.lo))
        assert ((found.lo <= values * (1 + 1e-9)) & (values * (1 - 1e-9) <= found.hi)).all()
        assert (found.hi - found.lo <= 0.05 * values).all()


def test_the_table_of_materials_is_the_one_in_use() -> None:
    page = (ROOT / "docs" / "spec.md").read_text(encoding="utf-8")
    rows = {row[0].strip("`"): row[1:-1] for row in table("materials", page)}
    assert rows.keys() == TABLE.keys()
    for name, told in rows.items():
        known = TABLE[name]
        values = (known.E / 1e9, known.G / 1e9, known.density, (known.yield_strength or 0) / 1e6)
        for text, value in zip(told, values, strict=True):
            assert value == pytest.approx(float(text or 0), abs=0.5 * 10.0 ** -decimals(text)), name


def test_the_manual_names_every_measure_and_each_key_of_the_machines() -> None:
    page = (ROOT / "docs" / "spec.md").read_text(encoding="utf-8")
    words = set(re.findall(r"\w+", " ".join(re.findall(r"`([^`\n]+)`", page))))
    ours = [one for one in installed() if one["distribution"] == "orthospec"]
    assert {one["name"] for one in ours} <= words
    for name in ("orthoglide", "linear_delta"):
        machine = registry.find_manipulator(name)
        assert {key for one in keys_of(machine).every() for key in one.path} <= words
        assert set(machine.index_units) <= words

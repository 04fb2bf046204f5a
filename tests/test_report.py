"""The report: one page that says what the terminal says, the same each time; figures for papers."""

from __future__ import annotations

import copy
import csv
import importlib
import re
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from typer.testing import CliRunner

from orthospec import registry
from orthospec.cli import app
from orthospec.optimise import evaluate_spec
from orthospec.report import report, write_figures
from orthospec.report.bars import beside_goal, in_range
from orthospec.report.fields import bound_surface
from orthospec.report.figures import curves, machine
from orthospec.report.latex import escaped, latex
from orthospec.report.palette import PAGE
from orthospec.report.panels import figures
from orthospec.report.views import AXONOMETRIC, ORTHOGONAL, View, edges, hidden
from orthospec.result import write_result
from orthospec.show import words
from orthospec.show.reading import read
from orthospec.solution import Lattice, Solution, solution_of
from orthospec.spec import Spec, Variable

if TYPE_CHECKING:
    from playwright.sync_api import Browser

SPEC = """
orthospec: 1
title: "Legs & feet <two>"
variables:
  base: {min: 0.9, max: 2.0, start: 1.0}
  third: {min: 0.9, max: 2.0, start: 1.0}
manipulator: {use: orthoglide, leg_lengths: [base, base, third]}
workspace: {size: [0.5, 0.5, 0.25], divisions: 4}
measures:
  transmission: {use: velocity_transmission, at_most: 2}
goals:
  base_legs: {minimise: base, goal: 0.95}
  third_leg: {minimise: third, goal: 1.2}
poses: {middle: [0, 0, 0]}
"""

PLANAR = """
orthospec: 1
manipulator: {use: orthoglide, leg_length: 0.4}
workspace: {size: [0.1, 0.1], divisions: 4, region: {min: [-0.2, -0.2], max: [0.2, 0.2]}}
measures: {condition: {use: condition_number, at_most: 3}}
"""


@pytest.fixture(scope="module")
def spec(spec_of: Callable[..., Spec]) -> Spec:
    return spec_of(SPEC)


@pytest.fixture(scope="module")
def evaluated(spec: Spec) -> Solution:
    return solution_of(spec, evaluate_spec(spec))


def _front(content: dict[str, Any]) -> list[dict[str, Any]]:
    """Three designs that trade one leg for the other."""
    designs = []
    for base, third in ((1.0, 1.9), (1.2, 1.3), (1.8, 1.1)):
        goals = copy.deepcopy(content["attainment"]["goals"])
        goals["base_legs"]["value"], goals["third_leg"]["value"] = base, third
        designs.append(
            {
                "attainment": {"factor": 0.1, "goals": goals},
                "variables": {"base": base, "third": third},
                **{key: content[key] for key in ("manipulator", "workspace")},
                **({"knee": True} if base == 1.2 else {}),
            }
        )
    return designs


@pytest.fixture(scope="module")
def rich(evaluated: Solution) -> Solution:
    """As the search of an infeasible problem leaves it, with a Pareto set too: all sections are there."""
    content = copy.deepcopy(dict(evaluated.content))
    conflict = [
        {"kind": "bound", "name": "transmission", "side": "at_most", "place": "spec.yaml:9:3"}
        | {"value": 2.0, "needed": 2.2, "by": 0.1}
    ]
    content |= {
        "status": "infeasible",
        "limits": [
            {"kind": "bound", "name": "transmission", "side": "at_most", "at": [[0.1, 0.1, 0.1]]}
            | {"gain": 0.01, "cost": 0.02},
            {"kind": "goal", "name": "base_legs", "side": None, "at": [], "gain": 0.005, "cost": None},
        ],
        "search": {
            "designs": 8,
            "refined": 4,
            "distinct": 1,
            "starts": 1,
            "subproblems": 3,
            "steps": [
                {"subproblems": 1, "factor": 0.3, "violation": 0.1},
                {"subproblems": 3, "factor": 0.2, "violation": 0.0},
            ],
            "least_violation": 0.05,
            "card": {"conflict": conflict, "irreducible": True, "together": 0.04, "scale": 0.9},
            "combinations": 2,
            "branches": [{"choices": {"base": 1.0}, "found": False, "least_violation": 0.05}],
        },
        "pareto": _front(content),
        "sweep": [
            {
                **{key: content[key] for key in ("manipulator", "workspace")},
                "variables": {"base": 1.0, "third": x},
            }
            for x in (1.0, 1.1)
        ],
    }
    measure = content["workspace"]["measures"]["transmission"]
    measure["levels"] = [{**measure, "at_most": 1.5, "max": [0.1, 0.1, 0.0]}]
    return Solution(content, evaluated.spec)


@pytest.fixture(scope="module")
def page(rich: Solution) -> str:
    return report(rich)


def test_page_asks_for_nothing_and_runs_nothing(page: str) -> None:
    assert "default-src 'none'" in page
    assert not re.search(r"<script|<link|@import|https?://|xmlns", page)
    loads = re.findall(r'(?:src|href)="([^"]*)"', page) + re.findall(r"url\(([^)]*)\)", page)
    assert loads
    assert all(one.startswith(("#", "data:image/png;base64,")) for one in loads)


def test_page_is_small_and_the_same_each_time(rich: Solution, page: str) -> None:
    assert len(page.encode()) < 1_000_000
    assert report(rich) == page


def test_names_in_the_page_are_its_own(page: str) -> None:
    ids = re.findall(r'\sid="([^"]*)"', page)
    assert len(ids) == len(set(ids))
    targets = set(re.findall(r'(?:href="|url\()#([^")]*)', page))
    assert targets <= set(ids)


def test_page_says_what_the_terminal_says(rich: Solution, page: str) -> None:
    reading = read(rich.content, rich.spec)
    told = [words.status(reading.result)[1], words.searched(rich.result)]
    told += [words.limiting(one, reading.known, reading.numbers) for one in rich.result.limits]
    told += [
        "These cannot all hold",
        "alone: to 2.2, by 10 %",
        "2 knee",
        "third_leg 1300 mm",
        "Sweep along third",
    ]
    assert [one for one in told if one not in page] == []
    assert "Legs &amp; feet &lt;two&gt;" in page
    assert "<two>" not in page


def test_page_says_of_a_cuboid_that_stands_shrunk_that_it_is(evaluated: Solution) -> None:
    content = copy.deepcopy(dict(evaluated.content))
    content["workspace"]["prescribed"]["scale"] = 0.25
    page = report(Solution(content, evaluated.spec))
    assert "Measures over the prescribed cuboid shrunk to 25 %" in page
    assert page.count("shrunk to 25 %") >= 3


def test_page_of_a_result_without_its_spec_says_so(rich: Solution) -> None:
    page = report(Solution(rich.content, None))
    assert "The spec is not at hand" in page
    assert "Neither machine nor fields are drawn" in page
    assert 'id="pareto-1-2"' in page


def test_page_of_a_planar_machine_has_one_plane_and_no_surface(
    spec_of: Callable[..., Spec], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    manual = (Path(__file__).parents[1] / "docs" / "plugins.md").read_text(encoding="utf-8")
    source = manual.split("<!-- module: biglide -->\n```python\n")[1].split("\n```")[0]
    (tmp_path / "biglide_in_a_report.py").write_text(source, encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    machine = importlib.import_module("biglide_in_a_report").Biglide
    monkeypatch.setattr(registry, "find_manipulator", lambda _: machine)
    solution = solution_of(planar := spec_of(PLANAR), evaluate_spec(planar))
    names = [one.name for one in figures(solution, read(solution.content, planar)).every()]
    assert [name for name in names if name.startswith("slice")] == ["slice-condition-at-most-xy"]
    assert not [name for name in names if name.startswith("surface")]
    assert [name for name in names if name.startswith("machine")] == ["machine-axonometric", "machine-top"]
    page = report(solution)
    assert "100 x 100 mm" in page


def test_page_of_a_failed_measure_shows_the_rest(evaluated: Solution) -> None:
    errors = [
        {"name": "transmission", "place": "spec.yaml:9:3", "message": "values raised ZeroDivisionError"}
    ]
    page = report(Solution({**evaluated.content, "status": "failed", "errors": errors}, evaluated.spec))
    assert page.index("A plugin failed") < page.index("values raised ZeroDivisionError")
    assert "No field is shown of transmission" in page
    assert 'id="machine-axonometric"' in page


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_page_in_a_browser(browser: Browser, page: str, tmp_path: Path, scheme: Any) -> None:
    """No serious finding of axe, no message, no request, no sideways scroll on a phone; marks by keyboard."""
    from axe_playwright_python.sync_playwright import Axe

    (tmp_path / "report.html").write_text(page, encoding="utf-8")
    tab = browser.new_page(
        viewport={"width": 360, "height": 740}, color_scheme=scheme, bypass_csp=True, java_script_enabled=True
    )
    heard: list[str] = []
    tab.on("console", lambda message: heard.append(message.text))
    tab.on("request", lambda request: heard.append(request.url))
    tab.goto((tmp_path / "report.html").as_uri())
    assert [one for one in heard if not one.startswith(("data:", "file:"))] == []
    assert tab.evaluate("document.documentElement.scrollWidth") == 360
    mark = tab.locator(".mark").first
    mark.focus()
    assert mark.locator("span").is_visible()
    found = Axe().run(tab).response["violations"]
    assert [
        (one["id"], one["nodes"][0]["html"]) for one in found if one["impact"] in ("serious", "critical")
    ] == []
    tab.close()


def test_figures_are_files_with_their_data_and_the_same_each_time(rich: Solution, tmp_path: Path) -> None:
    left_out = ("limits", "search", "sweep")
    few = Solution({key: part for key, part in rich.content.items() if key not in left_out}, None)
    files = write_figures(few, tmp_path / "a")
    write_figures(few, tmp_path / "b")
    names = sorted(file.name for file in (tmp_path / "a").iterdir())
    assert names == sorted(file.name for file in files)
    assert all((tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes() for name in names)
    rows = list(csv.reader((tmp_path / "a" / "pareto-1-2.csv").read_text().splitlines()))
    assert rows[0][0] == "design"
    assert rows[2] == ["2, knee", "1.2", "1.3"]
    assert "<text" in (tmp_path / "a" / "pareto-1-2.svg").read_text()


def test_axes_of_curves_make_room_for_the_curves_alone() -> None:
    along = ("leg [mm]", np.linspace(350.0, 500.0, 4))
    lines = {"lowest": np.linspace(0.003, 0.004, 4), "highest": np.linspace(0.012, 0.014, 4)}
    figure = curves.swept("rotation", "Rotation", along, "rotation [deg]", lines, [0.05]).draw(PAGE)
    (axes,) = figure.axes
    assert 340 < axes.get_xlim()[0] < 350
    assert 500 < axes.get_xlim()[1] < 510
    assert 0 < axes.get_ylim()[0] < 0.003
    assert 0.05 < axes.get_ylim()[1] < 0.055


@pytest.mark.parametrize("count", [1, 3, 9])
def test_names_of_a_machines_parts_stand_above_it(rich: Solution, count: int) -> None:
    segments = np.random.default_rng(0).uniform(-1, 1, (count, 2, 3))
    drawing = machine.Drawing(
        segments,
        np.full(count, 0.01),
        tuple(f"part{k}_1" for k in range(count)),
        np.ones(count, dtype=bool),
        np.full(3, -0.5),
        np.full(3, 0.5),
        "prescribed cuboid",
        read(rich.result, rich.spec).numbers,
    )
    figure = machine.panels(drawing)[0].draw(PAGE)
    renderer = FigureCanvasAgg(figure).get_renderer()
    names = [text.get_window_extent(renderer) for text in figure.texts]
    assert len(names) == count + 1
    drawn = [line.get_window_extent(renderer) for line in figure.axes[0].lines]
    assert min(name.y0 for name in names) > max(line.y1 for line in drawn)


def test_slice_has_the_measure_in_it(evaluated: Solution) -> None:
    shown = figures(evaluated, read(evaluated.content, evaluated.spec))
    panel = next(one for one in shown.every() if one.name == "slice-transmission-at-most-xy")
    assert list(panel.data) == ["x [mm]", "y [mm]", "transmission [1]"]
    x, y, values = (np.asarray(column, dtype=float) for column in panel.data.values())
    z = np.mean([evaluated.result.workspace.prescribed.min[2], evaluated.result.workspace.prescribed.max[2]])
    poses = np.stack([x / 1000, y / 1000, np.full_like(x, z)], axis=1)[np.isfinite(values)][::500]
    inverse = evaluated.design.manipulator.inverse_jacobian(poses)
    greatest = 1 / np.linalg.svd(inverse, compute_uv=False).min(axis=1)
    assert values[np.isfinite(values)][::500] == pytest.approx(greatest)


def test_latex_has_a_cell_for_each_column(rich: Solution) -> None:
    text = latex(read(rich.content, rich.spec))
    for columns, body in re.findall(r"\\begin{tabular}{(\w+)}(.*?)\\end{tabular}", text, re.DOTALL):
        rows = [line for line in body.splitlines() if line.endswith(r"\\")]
        assert len(rows) > 1
        assert {len(re.findall(r"(?<!\\)&", row)) + 1 for row in rows} == {len(columns)}
    assert text.count(r"\toprule") == 4


def test_latex_is_escaped() -> None:
    assert escaped("a_b & 1 % {λ} m^2") == r"a\_b \& 1 \% \{$\lambda$\} m\textsuperscript{2}"


def test_command_writes_the_page_into_the_result(spec: Spec, evaluated: Solution, tmp_path: Path) -> None:
    write_result(tmp_path / "kept", spec, evaluated.content, {})
    ran = CliRunner().invoke(app, ["report", str(tmp_path / "kept")])
    assert ran.exit_code == 0
    assert "report.html" in ran.output
    assert (tmp_path / "kept" / "report.html").read_text(encoding="utf-8") == report(evaluated)


@pytest.mark.parametrize("view", [*ORTHOGONAL, AXONOMETRIC], ids=lambda view: view.name)
def test_views_turn_and_do_not_stretch_or_mirror(view: View) -> None:
    rows = np.array(view.rows)
    assert rows @ rows.T == pytest.approx(np.eye(3), abs=1e-12)
    assert np.linalg.det(rows) == pytest.approx(1.0)


def test_a_box_has_twelve_edges_and_three_hidden_ones() -> None:
    box = edges(np.zeros(3), np.array([1.0, 2.0, 3.0]))
    assert sorted(np.linalg.norm(box[:, 1] - box[:, 0], axis=1)) == [1] * 4 + [2] * 4 + [3] * 4
    assert hidden(box, AXONOMETRIC).sum() == 3
    flat = edges(np.zeros(3), np.array([1.0, 2.0, 0.0]))
    assert len(np.unique(flat.reshape(len(flat), -1), axis=0)) == 4


def test_bars_tell_both_sides_of_nothing() -> None:
    bar = beside_goal(-1.0, 1.0, "warn", "")
    assert bar is not None
    assert bar.end == pytest.approx(50)
    assert bar.start + bar.ticks[0] == pytest.approx(100)
    assert beside_goal(None, 1.0, "warn", "") is None
    assert in_range(2.0, Variable(2.0, 2.0, 2.0), "") is None


def test_surface_of_a_bound_is_that_of_the_ball_in_which_it_holds() -> None:
    """A value of 1 + r², at most 1.25, is met to r = 1/2."""
    axis = np.linspace(-1, 1, 41)
    squares = sum(one**2 for one in np.meshgrid(axis, axis, axis, indexing="ij"))
    reach = 0.9 - squares
    values = np.where(reach >= 0, 1 + squares, np.nan)
    surface = bound_surface(Lattice((axis,) * 3, reach, reach >= 0, {"m": values}), "m", "at_most", 1.25)
    assert surface is not None
    assert np.linalg.norm(surface.vertices, axis=1) == pytest.approx(0.5, abs=2e-3)

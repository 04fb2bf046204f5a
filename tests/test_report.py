"""The report: what is in it, that it stands alone, and how it is seen, heard and printed."""

from __future__ import annotations

import csv
import re
from collections.abc import Callable, Iterator
from html.parser import HTMLParser
from importlib.resources import files
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from orthospec.optimise import Outcome
from orthospec.report import report, write_figures
from orthospec.report.latex import latex
from orthospec.report.subject import Subject
from orthospec.report.tables import Rows, tables
from orthospec.solution import Solution, solution_of
from orthospec.spec import load_spec

QUICK = ("workspace.divisions=10", "optimise.starts=2")


SPECS = Path(__file__).parents[1] / "specs"


def solution(outcome_of: Callable[..., Outcome], name: str, *settings: str) -> Solution:
    spec = load_spec(SPECS / f"{name}.yaml", [*settings, "proof=false"])
    return solution_of(spec, outcome_of(name, *settings))


@pytest.fixture(scope="module")
def solved(outcome_of: Callable[..., Outcome]) -> Solution:
    return solution(outcome_of, "orthoglide-200", *QUICK)


@pytest.fixture(scope="module")
def front(outcome_of: Callable[..., Outcome]) -> Solution:
    return solution(outcome_of, "orthoglide-1x1x0.8-pareto", *QUICK, "pareto.points=3")


@pytest.fixture(scope="module")
def page(solved: Solution) -> str:
    return report(solved)


class Outline(HTMLParser):
    """Ids, links, headings and sources of a page."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.ids: list[str] = []
        self.links: list[str] = []
        self.headings: list[int] = []
        self.loaded: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        named = {key: value or "" for key, value in attrs}
        if "id" in named:
            self.ids.append(named["id"])
        if tag == "a":
            self.links.append(named["href"])
        if re.fullmatch(r"h[1-6]", tag):
            self.headings.append(int(tag[1]))
        self.loaded += [named[key] for key in ("src", "data", "xlink:href") if key in named]
        if tag in ("link", "script", "iframe", "object", "embed"):
            self.loaded.append(tag)


def test_page_loads_nothing_and_its_links_hold(page: str) -> None:
    outline = Outline(page)
    assert all(one.startswith(("#", "data:image/png;base64,")) for one in outline.loaded)
    assert len(outline.ids) == len(set(outline.ids))
    assert {link.removeprefix("#") for link in outline.links} <= set(outline.ids)
    assert not re.search(r"(?:src|href)=\"https?:|url\(\s*['\"]?https?:|@import", page)
    assert len(page.encode()) < 1_000_000


def test_headings_follow_each_other(page: str) -> None:
    headings = Outline(page).headings
    assert headings[0] == 1
    assert all(after <= before + 1 for before, after in pairwise(headings))


def test_page_is_the_same_each_time_and_tells_no_place(page: str, solved: Solution) -> None:
    assert report(Solution(solved.content, solved.spec, solved.log)) == page
    assert str(Path.home()) not in page
    assert "<metadata" not in page


def test_page_says_what_the_terminal_says(page: str) -> None:
    for said in (
        "Best compromise: every bound holds, not every goal is met",
        "310.583 mm",
        "missed by 10.5829 mm",
        "measure transmission: at most 2",
        "1 % looser: λ falls by 0.000996; 1 % tighter: λ rises by 0.00237",
    ):
        assert said in page, said


def test_text_of_a_user_is_text(solved: Solution) -> None:
    content = {**solved.content, "title": 'legs < 300 & "short" <script>alert(1)</script>'}
    page = report(Solution(content, solved.spec, solved.log))
    assert "<script" not in page
    assert "legs &lt; 300 &amp; &quot;short&quot; &lt;script&gt;" in page


def test_page_without_spec_and_log_tells_what_is_known(solved: Solution) -> None:
    page = report(Solution(solved.content, None))
    assert "0.310583" in page
    assert "figure-machine" not in page
    assert "figure-goals" in page


@pytest.mark.parametrize("status", ["infeasible", "unfinished", "failed", "evaluated", "attained"])
def test_page_of_any_status_begins_with_it(solved: Solution, status: str) -> None:
    page = report(Solution({**solved.content, "status": status, "limits": []}, None))
    assert page.index('class="status') < page.index("<main")


def test_each_point_of_a_front_tells_its_design(front: Solution) -> None:
    page = report(front)
    marks = re.findall(r'class="mark" tabindex="0" role="img" aria-label="([^"]*)"', page)
    assert len(marks) == len(front.result.pareto)
    assert sum("(knee)" in mark for mark in marks) == 1
    assert all("base_legs" in mark and "third = " in mark for mark in marks)


@pytest.fixture(scope="module")
def figures(solved: Solution, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("figures")
    assert sorted(write_figures(solved, folder)) == sorted(folder.iterdir())
    return folder


def test_figures_stand_in_files_with_their_numbers(figures: Path, solved: Solution) -> None:
    names = {path.name for path in figures.iterdir()}
    for name in ("machine", "goals", "prices", "slices-transmission", "surfaces", "convergence"):
        assert {f"{name}.{suffix}" for suffix in ("svg", "pdf", "png", "csv")} <= names
    assert (figures / "goals.png").read_bytes().startswith(b"\x89PNG")
    (row,) = csv.DictReader((figures / "goals.csv").read_text().splitlines())
    assert float(row["value"]) == solved.result.variables["leg"]


def test_figures_are_the_same_each_time(front: Solution, tmp_path: Path) -> None:
    numbers = Solution(front.content, None, front.log)
    first, second = (
        {path.name: path.read_bytes() for path in write_figures(numbers, tmp_path)} for _ in range(2)
    )
    assert first == second
    rows = list(csv.DictReader(first["pareto.csv"].decode().splitlines()))
    assert [float(row["base"]) for row in rows] == [one.variables["base"] for one in front.result.pareto]


def test_slices_hold_the_measure_where_they_say(solved: Solution, figures: Path) -> None:
    table = np.loadtxt(figures / "slices-transmission.csv", delimiter=",", skiprows=1)
    assert solved.design is not None
    (demand,) = solved.design.demands
    values = demand.measure.values(solved.design.manipulator, table[:, :3].copy())
    assert np.allclose(values[:, 1], table[:, 3], rtol=1e-12)
    place = solved.result.workspace.prescribed
    assert place is not None
    middle = np.mean([place.min, place.max], axis=0)
    assert (np.isclose(table[:, :3], middle, atol=1e-12).sum(axis=1) >= 1).all()


def test_tables_for_latex_are_escaped_and_whole(solved: Solution) -> None:
    text = latex(list(tables(Subject(solved))))
    assert text.count(r"\begin{tabular}") == text.count(r"\end{tabular}") == text.count(r"\bottomrule")
    assert r"leg\_length" in text
    row = latex([Rows("x", "y", "50 % & more", ("a_b", "λ"), [("#1 {x}", "~^\\")], frozenset({1}))])
    assert r"\caption{50 \% \& more}" in row
    assert r"\#1 \{x\} & \textasciitilde{}\textasciicircum{}\textbackslash{} \\" in row
    assert r"\begin{tabular}{lr}" in row


AXE = files("axe_playwright_python").joinpath("axe.min.js")


@pytest.fixture(scope="module")
def opened(browser: Any, front: Solution, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    """The report of a Pareto set in a browser, with what it asks for and complains of."""
    file = tmp_path_factory.mktemp("report") / "report.html"
    file.write_text(report(front), encoding="utf-8")
    tab = browser.new_page()
    asked: list[str] = []
    said: list[str] = []
    tab.on("request", lambda request: asked.append(request.url))
    tab.on("console", lambda message: said.append(message.text))
    tab.goto(file.as_uri())
    yield tab, [url for url in asked if not url.startswith(("data:", file.as_uri()))], said
    tab.close()


def test_a_browser_asks_for_nothing_and_complains_of_nothing(opened: Any) -> None:
    _, asked, said = opened
    assert asked == []
    assert said == []


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_axe_finds_nothing_serious(opened: Any, scheme: str) -> None:
    tab = opened[0]
    tab.emulate_media(color_scheme=scheme)
    tab.evaluate(AXE.read_text(encoding="utf-8"))
    found = tab.evaluate("axe.run()")
    assert len(found["passes"]) > 20
    grave = [one for one in found["violations"] if one["impact"] in ("serious", "critical")]
    assert not grave, [(one["id"], [node["html"][:200] for node in one["nodes"][:3]]) for one in grave]


def test_page_fits_a_phone(opened: Any) -> None:
    tab = opened[0]
    tab.set_viewport_size({"width": 360, "height": 740})
    assert tab.evaluate("document.documentElement.scrollWidth") <= 360


def test_points_are_reached_by_the_keyboard(opened: Any) -> None:
    tab = opened[0]
    tab.locator(".mark").first.focus()
    assert "design 1" in tab.evaluate("document.activeElement.getAttribute('aria-label')")

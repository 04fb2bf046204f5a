"""The preview: what stands in the scene, that the page stands alone, and that a browser shows it."""

from __future__ import annotations

import base64
import copy
import io
import json
import os
import re
import threading
import urllib.error
import urllib.request
import uuid
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from orthospec.optimise import evaluate_spec
from orthospec.preview import preview
from orthospec.preview.build import overlaid, scene_of
from orthospec.preview.live import LOOPBACK, server
from orthospec.preview.scene import Lines, Mesh
from orthospec.preview.viewer import EXTENT, outline
from orthospec.report.subject import Subject
from orthospec.solution import Solution, solution_of
from orthospec.spec import Spec

EVALUATED = """
orthospec: 1
title: An Orthoglide </script> to look at
manipulator: {use: orthoglide, leg_lengths: [LENGTH, LENGTH, LENGTH]}
workspace: {size: [0.5, 0.5, 0.25], divisions: 4}
measures:
  transmission: {use: velocity_transmission, at_most: 2, levels: {at_most: [1.5]}}
"""


@pytest.fixture(scope="module")
def solved(spec_of: Callable[..., Spec]) -> Solution:
    spec = spec_of(EVALUATED.replace("LENGTH", "1"))
    return solution_of(spec, evaluate_spec(spec))


@pytest.fixture(scope="module")
def longer(spec_of: Callable[..., Spec]) -> Solution:
    spec = spec_of(EVALUATED.replace("LENGTH", "1.2"))
    return solution_of(spec, evaluate_spec(spec))


@pytest.fixture(scope="module")
def page(solved: Solution) -> str:
    return preview(solved)


def test_the_machine_follows_the_tool_to_each_corner_and_along_each_diagonal(solved: Solution) -> None:
    subject = Subject(solved)
    scene = scene_of(subject)
    (tool,), (frames,) = scene.tools, scene.frames
    assert len(scene.bars) == frames.shape[1]
    assert len(tool.places) == len(frames) == len(scene.poses)
    place = subject.place
    assert place is not None
    reached = {tuple(np.round(one, 9)) for one in tool.places}
    low, high = np.round(place.low, 9), np.round(place.high, 9)
    assert {tuple(np.where([i, j, k], high, low)) for i in (0, 1) for j in (0, 1) for k in (0, 1)} <= reached
    middles = [k for k, one in enumerate(tool.places) if np.allclose(one, place.centre)]
    ways = {tuple(np.sign(tool.places[k + 1] - place.centre).astype(int)) for k in middles[1:-1]}
    assert len(ways | {tuple(-np.array(way)) for way in ways}) == 8
    steps = np.linalg.norm(np.diff(tool.places, axis=0), axis=1)
    assert steps.max() < 0.1 * np.linalg.norm(place.size)
    legs = [k for k, bar in enumerate(scene.bars) if "leg" in bar.path]
    lengths = np.linalg.norm(frames[:, legs, 1] - frames[:, legs, 0], axis=-1)
    np.testing.assert_allclose(lengths, 1.0, rtol=1e-9)
    np.testing.assert_allclose(
        frames[:, legs, 1], np.repeat(tool.places[:, None], len(legs), axis=1), atol=1e-9
    )


def test_the_scene_has_what_its_panel_names(solved: Solution) -> None:
    scene = scene_of(Subject(solved))
    paths = {thing.path.split("/")[0] for thing in scene.things} | {
        bar.path.split("/")[0] for bar in scene.bars
    }
    assert {group.path for group in scene.groups} | {scale.path for scale in scene.scales} == paths
    assert "transmission at most 1.5, scale" in "; ".join(group.words for group in scene.groups)


def test_a_cuboid_that_stands_shrunk_says_so(solved: Solution) -> None:
    content: dict[str, Any] = copy.deepcopy(dict(solved.content))
    content["workspace"]["prescribed"]["scale"] = 0.25
    scene = scene_of(Subject(Solution(content, solved.spec)))
    assert "the prescribed cuboid shrunk to 25 %" in [group.words for group in scene.groups]


def test_colours_on_the_faces_are_the_values(solved: Solution) -> None:
    from matplotlib import colormaps

    subject = Subject(solved)
    scene = scene_of(subject)
    (faces,) = (thing for thing in scene.things if isinstance(thing, Mesh) and thing.colours is not None)
    assert solved.design is not None
    (demand,) = solved.design.demands
    values = demand.measure.values(solved.design.manipulator, faces.vertices.copy())[:, 1]
    parts = (values - values.min()) / np.ptp(values)
    assert faces.colours is not None
    np.testing.assert_allclose(faces.colours, colormaps["cividis"](parts)[:, :3], atol=0.01)
    assert scene.scales[0].low == f"{values.min():.6g}"
    place = subject.place
    assert place is not None
    u = (faces.vertices - place.centre) / place.size
    assert np.allclose(np.abs(u).max(axis=1), 0.5)


def test_page_loads_nothing_and_tells_nothing_of_where_it_was_made(page: str) -> None:
    assert not re.search(r"<(?:script|img|link|iframe)[^>]*\b(?:src|href)=", page)
    ids = set(re.findall(rb"[0-9a-f]{8}-[0-9a-f]{4}-[0-9a-f]{4}-[0-9a-f]{4}-[0-9a-f]{12}", _messages(page)))
    assert ids
    assert all(one.endswith(b"-0000-4000-8000-000000000000") for one in ids)
    assert f"{uuid.getnode():012x}" not in page
    assert str(Path.home()) not in page
    assert len(page.encode()) < 3_000_000


def _messages(page: str) -> bytes:
    content = json.loads(re.search(r'id="scene">(.*?)</script>', page, re.DOTALL)[1])  # type: ignore[index]
    return b"".join(base64.b64decode(command) for command in content["commands"])


def test_page_is_the_same_each_time(page: str, solved: Solution) -> None:
    assert preview(Solution(solved.content, solved.spec)) == page


def test_text_of_a_user_ends_no_script(page: str) -> None:
    assert "An Orthoglide &lt;/script&gt; to look at" in page
    assert page.count("</script>") == page.count("<script")


def test_a_result_without_its_spec_shows_its_cuboids(solved: Solution) -> None:
    scene = scene_of(Subject(Solution(solved.content, None)))
    assert not scene.bars
    assert any(isinstance(thing, Lines) for thing in scene.things)
    assert 'id="place"' not in preview(Solution(solved.content, None))


def test_machines_of_other_proportions_move_together(solved: Solution, spec_of: Callable[..., Spec]) -> None:
    """A flat cuboid has a shorter tour: each machine goes through its own as the other one does."""
    text = EVALUATED.replace("LENGTH", "1").replace("[0.5, 0.5, 0.25]", "[0.4, 0.3]")
    flat = spec_of(text)
    other = solution_of(flat, evaluate_spec(flat))
    for first, second in ((solved, other), (other, solved)):
        scene = overlaid(Subject(first), Subject(second))
        assert {len(frames) for frames in scene.frames} == {len(scene.poses)}
        assert {len(tool.places) for tool in scene.tools} == {len(scene.poses)}


def test_poses_are_told_on_the_axes_of_the_machine_that_takes_them(
    solved: Solution, spec_of: Callable[..., Spec]
) -> None:
    """The first solution has no place to be shown at: the tour is the second one's."""
    workspace = {**solved.content["workspace"], "prescribed": None, "joint": None}
    workspace["measures"] = {
        name: {**record, "prescribed": None} for name, record in workspace["measures"].items()
    }
    nowhere = Solution({**solved.content, "workspace": workspace}, solved.spec)
    assert not scene_of(Subject(nowhere)).poses
    text = EVALUATED.replace("LENGTH", "1").replace("[0.5, 0.5, 0.25]", "[0.4, 0.3]")
    flat = spec_of(text)
    other = Subject(solution_of(flat, evaluate_spec(flat)))
    scene = overlaid(Subject(nowhere), other)
    assert scene.poses == scene_of(other).poses
    assert len(scene.frames) == 1


def test_a_machine_waits_with_its_tool_where_it_cannot_go(solved: Solution) -> None:
    """Legs of one metre do not reach the far corners of this cuboid."""
    far = {"min": [-0.2, -0.2, -0.2], "max": [0.9, 0.9, 0.9], "holds": False}
    workspace = {**solved.content["workspace"], "prescribed": far}
    scene = scene_of(Subject(Solution({**solved.content, "workspace": workspace}, solved.spec)))
    (frames,), (tool,) = scene.frames, scene.tools
    legs = [k for k, bar in enumerate(scene.bars) if "leg" in bar.path]
    assert np.isfinite(frames).all()
    np.testing.assert_allclose(
        frames[:, legs, 1], np.repeat(tool.places[:, None], len(legs), axis=1), atol=1e-9
    )
    assert (np.diff(tool.places, axis=0) == 0).all(axis=1).any()


def test_the_outline_is_as_large_as_the_scene(solved: Solution) -> None:
    scene = scene_of(Subject(solved))
    low, high = scene.ends
    size = (high - low) * EXTENT / np.max(high - low)
    np.testing.assert_allclose(outline(scene).max(axis=0), size / 2)
    np.testing.assert_allclose(outline(scene).min(axis=0), -size / 2)


def test_joints_stand_at_the_ends_of_their_bars(solved: Solution) -> None:
    scene = scene_of(Subject(solved))
    ends = {(one.bar, one.end) for one in scene.joints}
    assert ends == {(k, end) for k in range(len(scene.bars)) for end in (0, 1)}


def test_a_second_solution_stands_beside_the_first(solved: Solution, longer: Solution) -> None:
    one, both = scene_of(Subject(solved)), overlaid(Subject(solved), Subject(longer))
    assert len(both.bars) == 2 * len(one.bars)
    assert {group.path for group in both.groups} - {group.path for group in one.groups} == {
        "other-machine",
        "other-cuboid",
    }


def test_live_serves_this_machine_alone_and_follows_the_result(tmp_path: Path) -> None:
    watched = tmp_path / "result.yaml"
    watched.write_text("one")
    pages = iter(["<body>first; connect-src data:</body>", "<body>second; connect-src data:</body>"])
    with server(lambda: next(pages), watched) as serving:
        assert serving.server_address[0] == LOOPBACK == "127.0.0.1"
        threading.Thread(target=serving.serve_forever, args=(0.01,), daemon=True).start()
        address = f"http://{LOOPBACK}:{serving.server_address[1]}/"

        def asked(path: str, **headers: str) -> str:
            with urllib.request.urlopen(urllib.request.Request(address + path, headers=headers)) as answer:
                return str(answer.read().decode())

        first = asked("")
        assert "first; connect-src data: 'self'" in first
        assert asked("") == first
        before = asked("stamp")
        watched.write_text("another")
        os.utime(watched, ns=(1, 1))
        assert asked("stamp") != before
        assert "second" in asked("")
        for path, headers in (("etc/passwd", {}), ("", {"Host": "elsewhere.example"})):
            with pytest.raises(urllib.error.HTTPError):
                asked(path, **headers)
        serving.shutdown()


@pytest.fixture(scope="module")
def opened(
    browser: Any, solved: Solution, longer: Solution, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[Any]:
    """Both machines in a browser, with what it asks for and complains of."""
    file = tmp_path_factory.mktemp("preview") / "preview.html"
    file.write_text(preview(solved, longer), encoding="utf-8")
    tab = browser.new_page(viewport={"width": 700, "height": 450})
    asked: list[str] = []
    said: list[str] = []
    tab.on("request", lambda request: asked.append(request.url))
    tab.on("console", lambda message: said.append(message.text))
    tab.on("pageerror", lambda error: said.append(str(error)))
    tab.goto(file.as_uri())
    tab.wait_for_selector("body[data-ready]")
    tab.wait_for_timeout(500)
    yield tab, [url for url in asked if not url.startswith(("data:", "blob:", file.as_uri()))], said
    tab.close()


def _seen(tab: Any) -> np.ndarray:
    """The scene beside the panel, as it is drawn when all is still."""
    tab.wait_for_timeout(250)
    picture = tab.screenshot(clip={"x": 310, "y": 0, "width": 390, "height": 450})
    return np.asarray(Image.open(io.BytesIO(picture)).convert("RGB")).astype(int)


def _share(a: np.ndarray, b: np.ndarray) -> float:
    """Of pixels that differ."""
    return float((np.abs(a - b).max(axis=2) > 24).mean())


def test_a_browser_complains_of_nothing_and_asks_for_nothing(opened: Any) -> None:
    _, asked, said = opened
    assert said == []
    assert asked == []


def test_the_scene_is_drawn_and_its_parts_are_hidden_and_moved(opened: Any) -> None:
    tab = opened[0]
    whole = _seen(tab)
    shown = {}
    for path in ("machine", "other-machine", "workspace", "cuboid"):
        tab.uncheck(f'input[data-path="{path}"]')
        shown[path] = _share(whole, _seen(tab))
        tab.check(f'input[data-path="{path}"]')
    assert all(part > 2e-4 for part in shown.values()), shown
    tab.evaluate("document.getElementById('place').value = 30")
    tab.dispatch_event("#place", "input")
    assert _share(whole, _seen(tab)) > 1e-3
    assert tab.input_value("#place") == "30"
    assert "(" in tab.inner_text("#pose")


def test_a_screen_is_light_or_dark_as_is_chosen(opened: Any) -> None:
    tab = opened[0]
    seen = {}
    for theme in ("light", "dark"):
        tab.select_option("#theme", theme)
        seen[theme] = _seen(tab)[-1, -1].mean()
        ink = tab.evaluate("getComputedStyle(document.body).color")
        assert ink == {"light": "rgb(27, 28, 31)", "dark": "rgb(232, 233, 236)"}[theme]
    tab.select_option("#theme", "")
    assert seen["dark"] < 40 < 200 < seen["light"]


def test_all_of_the_scene_stands_in_the_middle_of_its_room(opened: Any) -> None:
    tab = opened[0]
    seen = tab.evaluate(
        """() => {
          viewer.camera.updateMatrixWorld(true);
          const point = viewer.camera.position.clone();
          const seen = ([x, y, z]) => point.set(x, z, -y).project(viewer.camera).toArray();
          return scene.outline.map((place) => seen(place).slice(0, 2));
        }"""
    )
    low, high = np.min(seen, axis=0), np.max(seen, axis=0)
    np.testing.assert_allclose(low, -high, atol=0.05)
    assert high.max() == pytest.approx(0.92, abs=1e-3)


def test_on_a_phone_the_scene_stands_above_the_panel(browser: Any, page: str, tmp_path: Path) -> None:
    file = tmp_path / "preview.html"
    file.write_text(page, encoding="utf-8")
    tab = browser.new_page(viewport={"width": 390, "height": 800})
    tab.goto(file.as_uri())
    tab.wait_for_selector("body[data-ready]")
    tab.wait_for_timeout(500)
    canvas, panel = (tab.locator(one).bounding_box() for one in ("canvas", "aside"))
    tab.close()
    assert canvas["width"] == 390
    assert canvas["y"] + canvas["height"] <= panel["y"] + 1


def test_a_measure_is_shown_with_its_scale(opened: Any) -> None:
    tab = opened[0]
    before = _seen(tab)
    assert tab.is_hidden("#legend-measure-0")
    tab.select_option("#measure", label="transmission")
    assert tab.is_visible("#legend-measure-0")
    assert _share(before, _seen(tab)) > 2e-3

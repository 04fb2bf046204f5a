"""The preview: one page with meshcat's viewer in it, the scene, and what moves and explains it."""

from __future__ import annotations

import json
from collections.abc import Iterator
from html import escape as escaped
from importlib.resources import files
from typing import TYPE_CHECKING

import numpy as np

from orthospec.preview.build import overlaid, scene_of
from orthospec.preview.scene import Scene
from orthospec.preview.viewer import ROOT, commands, outline, viewer_source
from orthospec.report.figures.slices import COLOURS as MAP
from orthospec.report.subject import Subject
from orthospec.show import words
from orthospec.show.numbers import UNKNOWN

if TYPE_CHECKING:
    from orthospec.solution import Solution

POLICY = (
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:;"
    " connect-src data:"
)
"""What a browser may load: nothing from anywhere else."""
INDICES = 4
"""So many of the machine's indices are told in the panel."""
DIGITS = 6
"""Of coordinates in frames [m]: a micrometre is more than a screen shows."""

_SCREEN = """<h2 id="screen">Light or dark</h2>
<select id="theme" aria-labelledby="screen"><option value="">as the system</option>
<option>light</option><option>dark</option></select>
"""


def preview(solution: Solution, other: Solution | None = None) -> str:
    """The whole page: the same text for the same solution, on any day; it loads nothing.

    With another solution, its machine and cuboid stand in the scene too.
    """
    subject = Subject(solution)
    scene = scene_of(subject) if other is None else overlaid(subject, Subject(other))
    title = subject.result.title or str(subject.result.manipulator["use"])
    return "\n".join(
        [
            "<!DOCTYPE html>",
            '<html lang="en">',
            "<head>",
            '<meta charset="utf-8">',
            '<meta name="viewport" content="width=device-width, initial-scale=1">',
            f'<meta http-equiv="Content-Security-Policy" content="{POLICY}">',
            f"<title>{escaped(title)}</title>",
            f"<style>\n{_own('page.css')}</style>",
            "</head>",
            "<body>",
            '<main id="meshcat-pane" aria-label="The machine in space: drag to turn it"></main>',
            f'<aside aria-label="What is shown">\n{"".join(_panel(subject, scene, title))}</aside>',
            "<noscript>The preview needs JavaScript; report.html does not.</noscript>",
            f'<script type="application/json" id="scene">{_data(scene)}</script>',
            f"<script>\n{viewer_source()}\n</script>",
            f"<script>\n{_own('page.js')}</script>",
            "</body>",
            "</html>",
            "",
        ]
    )


def _own(name: str) -> str:
    return files(__package__).joinpath(name).read_text(encoding="utf-8")


def _data(scene: Scene) -> str:
    content = {
        "commands": list(commands(scene)),
        "bars": [f"/{ROOT}/{bar.path}" for bar in scene.bars],
        "frames": [np.round(one.reshape(*one.shape[:2], 6), DIGITS).tolist() for one in scene.frames],
        "joints": [[f"/{ROOT}/{one.ball.path}", one.machine, one.bar, one.end] for one in scene.joints],
        "tools": [
            {"path": f"/{ROOT}/{tool.ball.path}", "places": np.round(tool.places, DIGITS).tolist()}
            for tool in scene.tools
        ],
        "poses": scene.poses,
        "outline": np.round(outline(scene), DIGITS).tolist(),
    }
    # What stands in a script must not end it.
    return json.dumps(content, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")


def _panel(subject: Subject, scene: Scene, title: str) -> Iterator[str]:
    yield f"<h1>{escaped(title)}</h1>\n"
    yield f"<p>{escaped(words.status(subject.result)[1])}</p>\n"
    for name, value in subject.result.variables.items():
        told = subject.numbers.value(value, subject.known.variables.get(name, UNKNOWN))
        yield f'<p class="muted">{escaped(name)} = {escaped(told)}</p>\n'
    for name, index in [*subject.result.indices.items()][:INDICES]:
        told = subject.numbers.value(index, subject.known.indices.get(name, UNKNOWN))
        yield f'<p class="muted">{escaped(name)} {escaped(told)}</p>\n'
    yield from _motion(scene)
    yield from _measures(scene)
    yield from _groups(scene)
    for note in scene.notes:
        yield f'<p class="muted">{escaped(note)}</p>\n'
    yield _SCREEN


def _motion(scene: Scene) -> Iterator[str]:
    if not scene.poses:
        return
    yield (
        '<h2 id="tool">The tool, along edges and diagonals of the cuboid</h2>\n'
        f'<div class="motion"><input type="range" id="place" min="0" max="{len(scene.poses) - 1}" value="0"'
        ' aria-labelledby="tool"><button id="play" type="button">Move</button></div>\n'
        f'<output id="pose" for="place">{escaped(scene.poses[0])}</output>\n'
    )


def _groups(scene: Scene) -> Iterator[str]:
    yield "<h2>Shown</h2>\n"
    for group in scene.groups:
        checked = " checked" if group.shown else ""
        yield (
            f'<label class="part"><input type="checkbox" data-path="{group.path}"{checked}>'
            f'<span class="swatch" style="background:{_css(group.colour)}"></span>'
            f"<span>{escaped(group.words)}</span></label>\n"
        )


def _measures(scene: Scene) -> Iterator[str]:
    if not scene.scales:
        return
    options = "".join(f'<option value="{one.path}">{escaped(one.words)}</option>' for one in scene.scales)
    yield '<h2 id="colours">A measure on the faces of the cuboid</h2>\n'
    yield f'<select id="measure" aria-labelledby="colours"><option value="">none</option>{options}</select>\n'
    for one in scene.scales:
        yield (
            f'<div id="legend-{one.path}" hidden><div class="map" style="background:{_gradient()}"></div>'
            f'<div class="ends"><span>{escaped(one.low)}</span><span>{escaped(one.high)}</span></div></div>\n'
        )


def _gradient() -> str:
    from matplotlib import colormaps

    stops = [_css(tuple(round(255 * part) for part in colormaps[MAP](k / 8)[:3])) for k in range(9)]
    return f"linear-gradient(to right,{','.join(stops)})"


def _css(colour: tuple[int, ...]) -> str:
    return f"rgb({','.join(map(str, colour))})"

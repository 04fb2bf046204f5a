"""Make the pictures of previews in docs/screens anew: python docs/screens.py

Needs the extras `test` and `docs`, the plugins, and Chromium.
The specs are solved first, into a temporary folder; that takes a minute.
"""

from __future__ import annotations

import io
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image
from playwright.sync_api import sync_playwright
from rich.console import Console
from rich.text import Text

from orthospec.cli.command import WIDEST
from orthospec.report.canvas import style
from orthospec.result import read_result, spec_of
from orthospec.show import show
from orthospec.study import open_study

HERE = Path(__file__).parent
ROOT = HERE.parent
COLOURS = 256
"""Of a picture, so that it stays small."""
PREVIEWS: dict[str, tuple[str, str, int, int]] = {
    "preview-orthoglide": ("orthoglide-200-drives", "light", 1, 12),
    "preview-linear-delta": ("linear-delta-300", "dark", 0, 30),
    "preview-rotary-delta": ("rotary-delta-pick", "light", 1, 20),
}
"""Which spec, on which screen, the number of the measure shown, and where the tool is."""


def solved(spec: str, folder: Path) -> Path:
    result = folder / spec
    if not result.exists():
        (path,) = [*ROOT.glob(f"specs/{spec}.yaml"), *ROOT.glob(f"plugins/*/specs/{spec}.yaml")]
        command = [sys.executable, "-m", "orthospec", "run", str(path), "-o", str(result), "-q"]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return result


def terminal(result: Path, columns: int, file: Path) -> None:
    """What `orthospec show` prints on a terminal so wide, in its colours."""
    content = read_result(result)
    text = show(content, spec=spec_of(result), width=min(columns, WIDEST), colour=True)
    console = Console(record=True, width=columns, file=io.StringIO(), force_terminal=True)
    console.print(Text.from_ansi("\n".join(text.splitlines()[:60])))
    drawn = console.export_svg(title=f"orthospec show, {columns} columns")
    # rich would load a font from elsewhere; the reader's own does.
    drawn = re.sub(r"@font-face \{.*?\}", "", drawn, flags=re.DOTALL).replace("Fira Code", "monospace")
    file.write_text(drawn, encoding="utf-8")


def machine(result: Path, file: Path) -> None:
    """The drawing of the machine in a report, by itself."""
    panel = open_study(result).drawings()["machine-axonometric"]
    with style():
        panel.figure.savefig(file, dpi=160, facecolor="white", metadata={"Software": None})
    small(file)


def small(path: Path) -> None:
    """Few colours, and no larger than it has to be."""
    with Image.open(path) as picture:
        picture.convert("RGB").quantize(COLOURS, dither=Image.Dither.FLOYDSTEINBERG).save(path, optimize=True)


def main() -> None:
    chromium = shutil.which("chromium") or sys.exit("no Chromium is installed")
    options = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
    with tempfile.TemporaryDirectory() as scratch, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium, args=options)
        for columns in (80, 120):
            terminal(
                solved("orthoglide-200", Path(scratch)), columns, HERE / "screens" / f"terminal-{columns}.svg"
            )
        for name, spec in (("orthoglide", "orthoglide-200-drives"), ("linear-delta", "linear-delta-300")):
            machine(solved(spec, Path(scratch)), HERE / "screens" / f"machine-{name}.png")
        for name, (spec, scheme, measure, place) in PREVIEWS.items():
            page = browser.new_page(viewport={"width": 1100, "height": 700})
            page.emulate_media(color_scheme="dark" if scheme == "dark" else "light")
            page.goto((solved(spec, Path(scratch)) / "preview.html").resolve().as_uri())
            page.wait_for_selector("body[data-ready]")
            page.select_option("#measure", index=measure)
            page.evaluate(f"document.getElementById('place').value = {place}")
            page.dispatch_event("#place", "input")
            page.wait_for_timeout(500)
            page.screenshot(path=HERE / "screens" / f"{name}.png")
            page.close()
            small(HERE / "screens" / f"{name}.png")
        browser.close()


if __name__ == "__main__":
    main()

"""Make the pictures of pages in `docs/screens/` anew: ``python docs/screens_of_reports.py RESULT...``.

Each result folder's report is shown in light and dark, on a phone and on paper. Needs the extra ``test``,
Chromium, pypdfium2 and Pillow.
"""

from __future__ import annotations

import io
import shutil
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pypdfium2
from PIL import Image
from playwright.sync_api import sync_playwright

from orthospec.report import report
from orthospec.solution import read_solution

if TYPE_CHECKING:
    from playwright.sync_api import Browser

SCREENS = Path(__file__).parent / "screens"
COLOURS = 96
"""Of a picture: few enough for a small file."""
TALLEST = 2600
"""Rows of a picture; what is below is left out."""
SHOWN: dict[str, dict[str, Any]] = {
    "light": {"viewport": {"width": 1180, "height": 800}, "color_scheme": "light"},
    "dark": {"viewport": {"width": 1180, "height": 800}, "color_scheme": "dark"},
    "phone": {"viewport": {"width": 360, "height": 740}, "color_scheme": "light"},
}


def shown(browser: Browser, page: Path, **how: Any) -> Image.Image:
    """A page as a window shows it."""
    tab = browser.new_page(**how)
    tab.goto(page.as_uri())
    picture = Image.open(io.BytesIO(tab.screenshot(full_page=True)))
    tab.close()
    return picture.crop((0, 0, picture.width, min(picture.height, TALLEST)))


def printed(browser: Browser, page: Path) -> Image.Image:
    """The first two sheets that a page is printed on, side by side."""
    tab = browser.new_page()
    tab.goto(page.as_uri())
    sheets = pypdfium2.PdfDocument(tab.pdf(prefer_css_page_size=True, print_background=True))
    tab.close()
    pictures = [sheets[k].render(scale=1.3).to_pil() for k in range(min(2, len(sheets)))]
    both = Image.new("RGB", (sum(one.width + 12 for one in pictures), pictures[0].height), "#888888")
    for k, one in enumerate(pictures):
        both.paste(one, (k * (one.width + 12), 0))
    return both


def pictures(browser: Browser, name: str, page: Path) -> Iterator[tuple[str, Image.Image]]:
    """All pictures of one page by name."""
    for kind, how in SHOWN.items():
        yield f"report-{name}-{kind}", shown(browser, page, **how)
    yield f"report-{name}-print", printed(browser, page)


def main(folders: list[str]) -> None:
    """Write the pictures of these results."""
    program = shutil.which("chromium") or shutil.which("google-chrome")
    SCREENS.mkdir(exist_ok=True)
    with sync_playwright() as playwright, tempfile.TemporaryDirectory() as scratch:
        browser = playwright.chromium.launch(executable_path=program)
        for folder in map(Path, folders):
            page = Path(scratch) / f"{folder.name}.html"
            page.write_text(report(read_solution(folder)), encoding="utf-8")
            for name, picture in pictures(browser, folder.name, page):
                small = picture.convert("RGB").quantize(COLOURS, dither=Image.Dither.NONE)
                small.save(SCREENS / f"{name}.png", optimize=True)
        browser.close()


if __name__ == "__main__":
    main(sys.argv[1:])

"""The preview on the loopback address, which follows its result as it is written anew."""

from __future__ import annotations

import webbrowser
from collections.abc import Callable
from contextlib import suppress
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

from orthospec.result import RESULT

LOOPBACK = "127.0.0.1"
_FOLLOW = """<script>
setInterval(async () => {
  try {
    const stamp = await (await fetch("stamp")).text();
    if (document.body.dataset.stamp && document.body.dataset.stamp !== stamp) location.reload();
    document.body.dataset.stamp = stamp;
  } catch (gone) { /* the server has ended */ }
}, 1000);
</script>
"""


def show_live(make: Callable[[], str], result: Path, told: Callable[[str], None]) -> None:
    """Open the page that ``make`` gives in a browser, and serve it until Ctrl-C.

    Only this machine can reach it. When the result is written anew the page is made and loaded anew.
    """
    make()  # What cannot be shown is said before a browser opens.
    with server(make, result / RESULT if result.is_dir() else result) as serving:
        address = f"http://{LOOPBACK}:{serving.server_address[1]}/"
        told(f"{address} shows it, and follows it as it is written; end with Ctrl-C")
        webbrowser.open(address)
        with suppress(KeyboardInterrupt):
            serving.serve_forever(poll_interval=0.2)


def server(make: Callable[[], str], watched: Path) -> ThreadingHTTPServer:
    """What serves the page on a free port of the loopback address."""
    return ThreadingHTTPServer((LOOPBACK, 0), _handler(make, watched))


def _handler(make: Callable[[], str], watched: Path) -> type[BaseHTTPRequestHandler]:
    pages: dict[str, bytes] = {}

    def stamp() -> str:
        return str(watched.stat().st_mtime_ns) if watched.exists() else ""

    class Handler(BaseHTTPRequestHandler):
        """Two things to ask for: the page, and when its result was written."""

        server_version, sys_version = "orthospec", ""

        def do_GET(self) -> None:
            """Answer a browser on this machine."""
            now = stamp()
            if self.headers.get("Host", "").split(":")[0] not in (LOOPBACK, "localhost"):
                self.send_error(403)
            elif self.path == "/":
                if now not in pages:
                    pages.clear()
                    pages[now] = _following(make()).encode()
                self._answer(pages[now], "text/html; charset=utf-8")
            elif self.path == "/stamp":
                self._answer(now.encode(), "text/plain")
            else:
                self.send_error(404)

        def _answer(self, content: bytes, kind: str) -> None:
            self.send_response(200)
            self.send_header("Content-Type", kind)
            self.send_header("Content-Length", str(len(content)))
            self.send_header("Cache-Control", "no-store")
            self.end_headers()
            self.wfile.write(content)

        def log_message(self, format: str, *args: object) -> None:
            """Say nothing: a terminal is for people."""

    return Handler


def _following(page: str) -> str:
    page = page.replace("connect-src data:", "connect-src data: 'self'", 1)
    return page.replace("</body>", f"{_FOLLOW}</body>", 1)

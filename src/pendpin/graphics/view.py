"""A motion in the browser: as an HTML file, or live, served by this process to this machine only."""

import os
import socketserver
import sys
import threading
import time
from collections.abc import Callable
from http.server import BaseHTTPRequestHandler
from typing import Any, cast

from pendpin.errors import InputError
from pendpin.graphics.drawing import Drawing
from pendpin.graphics.page import page

ADDRESS = "127.0.0.1"


def serve(
    drawing: Drawing,
    report: str = "",
    *,
    port: int = 0,
    ready: Callable[[str], object] = lambda url: None,
    duration: float | None = None,
    open_browser: bool = False,
) -> None:
    """Show a drawing live at http://127.0.0.1:port/ until Ctrl-C, or for `duration` s.

    Only this machine can reach it. Port 0 means any free one. `ready` is called with the address once it answers; every
    browser that opens it sees the whole motion. Raises InputError where the port is taken or not allowed.
    """
    content = page(drawing, report, live=True).encode(errors="replace")
    end = None if duration is None else time.monotonic() + duration
    with _listen(port, content) as server:
        url = f"http://{ADDRESS}:{server.server_address[1]}/"
        try:
            ready(url)
            if open_browser:
                _open(url)
            while end is None or time.monotonic() < end:
                server.handle_request()
        except KeyboardInterrupt:
            pass  # the usual end


class _Server(socketserver.ThreadingTCPServer):
    daemon_threads = True  # a slow browser does not hold up the end
    allow_reuse_address = os.name == "posix"  # elsewhere it would let two programs share a port
    timeout = 0.25  # s, between looks at the clock
    content: bytes

    def handle_error(self, request: Any, client_address: Any) -> None:
        """A browser that went away is no error."""
        if not isinstance(sys.exception(), ConnectionError | TimeoutError):
            super().handle_error(request, client_address)


class _Handler(BaseHTTPRequestHandler):
    timeout = 10.0  # s, for a request to arrive

    def do_GET(self) -> None:
        """Answer `/` with the page and `/alive` with nothing, and only to a browser of this machine."""
        server = cast(_Server, self.server)
        port = server.server_address[1]
        if self.headers.get("Host") not in {f"{ADDRESS}:{port}", f"localhost:{port}"}:
            self._answer(403, b"")  # a foreign name that was made to point here
        elif self.path == "/":
            self._answer(200, server.content)
        elif self.path == "/alive":
            self._answer(204, b"")
        else:
            self._answer(404, b"")

    def _answer(self, status: int, content: bytes) -> None:
        self.send_response(status)
        self.send_header("Content-Type", "text/html; charset=utf-8")
        self.send_header("Content-Length", str(len(content)))
        self.send_header("Cache-Control", "no-store")
        self.send_header("Cross-Origin-Resource-Policy", "same-origin")
        self.send_header("X-Frame-Options", "DENY")
        self.end_headers()
        self.wfile.write(content)

    def log_message(self, format: str, *args: Any) -> None:
        """Say nothing: the terminal belongs to the command."""


def _listen(port: int, content: bytes) -> _Server:
    if not 0 <= port <= 65535:
        raise InputError(f"port {port} is not between 0 and 65535")
    try:
        server = _Server((ADDRESS, port), _Handler)
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise InputError(f"port {port} of {ADDRESS}: {reason}; choose another, or 0 for any free one") from None
    server.content = content
    return server


def _open(url: str) -> None:
    """Open the user's browser, where there is a screen; a browser in the terminal would take the terminal over."""
    import webbrowser

    if sys.platform in {"win32", "darwin"} or os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"):
        threading.Thread(target=webbrowser.open, args=(url,), daemon=True).start()

"""A headless Chromium for tests, spoken to over two pipes in its DevTools protocol."""

import base64
import fcntl
import io
import json
import os
import select
import shutil
import signal
import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any

import numpy as np
import pytest

from laws import HANG, sooner_or_later

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
FLAGS = """
    --headless --no-sandbox --disable-gpu --use-angle=swiftshader --enable-unsafe-swiftshader --disable-quic
    --no-first-run --disable-background-networking --disable-component-update --disable-sync --disable-dev-shm-usage
    --hide-scrollbars --remote-debugging-pipe
"""
NO_NETWORK = "--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1"  # no name and no address but this machine's


class Browser:
    """A running Chromium: `open` gives a page of it."""

    def __init__(self, to: int, back: int, profile: str) -> None:
        self._to, self._back, self.profile = to, back, profile
        self._heard = b""
        self._asked = 0
        self.events: list[dict[str, Any]] = []

    def open(self, url: str, size: tuple[int, int] = (900, 700)) -> "Page":
        """Open an address in a window of its own and wait until the page has started to play."""
        target = self.ask("Target.createTarget", url="about:blank", width=size[0], height=size[1], newWindow=True)
        session = self.ask("Target.attachToTarget", targetId=target["targetId"], flatten=True)["sessionId"]
        for domain in ("Runtime", "Log", "Page", "Network"):
            self.ask(f"{domain}.enable", session)
        self.ask("Page.navigate", session, url=url)
        page = Page(self, session, target["targetId"])
        page.wait_for("document.getElementById('clock')?.textContent")
        return page

    def ask(self, method: str, session: str | None = None, **params: Any) -> dict[str, Any]:
        """Send a command and wait for its answer; what happens meanwhile goes to `events`."""
        self._asked += 1
        message = {"id": self._asked, "method": method, "params": params}
        os.write(self._to, json.dumps(message | ({"sessionId": session} if session else {})).encode() + b"\0")
        while (answer := self._next()).get("id") != self._asked:
            self.events.append(answer)
        assert "error" not in answer, answer
        return answer["result"]

    def _next(self) -> dict[str, Any]:
        while b"\0" not in self._heard:
            ready, _, _ = select.select([self._back], [], [], HANG)
            heard = os.read(self._back, 1 << 20) if ready else b""
            if not heard:
                pytest.fail(f"Chromium {'ended' if ready else f'did not answer within {HANG} s'}")
            self._heard += heard
        message, self._heard = self._heard.split(b"\0", 1)
        return json.loads(message)


class Page:
    """One page in a Browser."""

    def __init__(self, browser: Browser, session: str, target: str) -> None:
        self._browser, self._session, self._target = browser, session, target

    def __enter__(self) -> "Page":
        return self

    def __exit__(self, *error: object) -> None:
        self._browser.ask("Target.closeTarget", targetId=self._target)

    def evaluate(self, script: str) -> Any:
        """The value of an expression, or of the promise it gives, in the page."""
        answer = self._browser.ask(
            "Runtime.evaluate", self._session, expression=script, awaitPromise=True, returnByValue=True
        )
        assert "exceptionDetails" not in answer, answer
        return answer["result"].get("value")

    def text(self, name: str) -> str:
        """The text of the element with this id."""
        return self.evaluate(f"document.getElementById({name!r}).textContent")

    def wait_for(self, condition: str) -> None:
        """Wait until an expression holds in the page."""
        if not sooner_or_later(lambda: self.evaluate(condition)):
            pytest.fail(f"this does not come to hold: {condition}; the page says {self.complaints}")

    def press(self, x: float, y: float) -> None:
        """Press and release the mouse at a place, in pixels from the top left."""
        for kind in ("mousePressed", "mouseReleased"):
            mouse = {"type": kind, "x": x, "y": y, "button": "left", "buttons": 1, "clickCount": 1}
            self._browser.ask("Input.dispatchMouseEvent", self._session, **mouse)

    def resize(self, width: int, height: int) -> None:
        """Give the page another size, in pixels."""
        size = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False}
        self._browser.ask("Emulation.setDeviceMetricsOverride", self._session, **size)
        self.wait_for(f"innerWidth == {width} && innerHeight == {height}")

    def picture(self) -> np.ndarray:
        """What is to be seen: (rows, columns, 3), from 0 to 1."""
        from matplotlib.image import imread

        data = self._browser.ask("Page.captureScreenshot", self._session)["data"]
        return imread(io.BytesIO(base64.b64decode(data)), format="png")[..., :3]

    @property
    def complaints(self) -> list[str]:
        """Errors of the page: exceptions, refused or failed requests, breaches of its own policy."""
        found = [e for e in self._events("Runtime.exceptionThrown", "Log.entryAdded") if "exceptionDetails" in e]
        logged = [e["entry"]["text"] for e in self._events("Log.entryAdded") if e["entry"]["level"] == "error"]
        return [e["exceptionDetails"]["exception"]["description"] for e in found] + logged

    @property
    def requests(self) -> list[str]:
        """Every address the page has asked for, save what it holds itself."""
        urls = [e["request"]["url"] for e in self._events("Network.requestWillBeSent")]
        return [url for url in urls if not url.startswith(("data:", "blob:"))]

    def _events(self, *methods: str) -> list[dict[str, Any]]:
        mine = [e for e in self._browser.events if e.get("sessionId") == self._session]
        return [e["params"] for e in mine if e["method"] in methods]


@contextmanager
def chromium() -> Iterator[Browser]:
    """A headless Chromium with a profile of its own; the test fails where it is not installed."""
    found = next(filter(None, map(shutil.which, NAMES)), None)
    if found is None:
        pytest.fail("this test needs Chromium: apt-get install chromium")
    with (
        tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile,
        _pipe() as (hear, to),
        _pipe() as (back, say),
    ):

        def as_3_and_4() -> None:  # where Chromium looks for its two pipes
            ends = [fcntl.fcntl(end, fcntl.F_DUPFD, 64) for end in (hear, say)]
            os.dup2(ends[0], 3)
            os.dup2(ends[1], 4)

        command = [found, *FLAGS.split(), NO_NETWORK, f"--user-data-dir={profile}", "about:blank"]
        null = subprocess.DEVNULL
        process = subprocess.Popen(
            command,
            stdin=null,
            stdout=null,
            stderr=null,
            start_new_session=True,
            preexec_fn=as_3_and_4,
            pass_fds=(3, 4),
        )
        try:
            yield Browser(to, back, profile)
        finally:
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)  # with its helpers
            process.wait()


@contextmanager
def _pipe() -> Iterator[tuple[int, int]]:
    ends = os.pipe()
    try:
        yield ends
    finally:
        for end in ends:
            os.close(end)

"""A headless Chromium for tests: what a page looks like, what it says, and what it complains of."""

import os
import re
import shutil
import signal
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
LIMIT = 60  # s, for one look
FLAGS = (
    "--headless --no-sandbox --disable-gpu --use-angle=swiftshader --enable-unsafe-swiftshader --disable-quic "
    "--no-first-run --disable-background-networking --disable-component-update --disable-sync --disable-dev-shm-usage "
    "--hide-scrollbars --window-size=900,700 --enable-logging=stderr"
).split()


@dataclass(frozen=True)
class Look:
    """A page after some seconds of its own time: `pixels` (rows, columns, 3) from 0 to 1, its text, its complaints."""

    pixels: np.ndarray
    clock: str
    note: str
    complaints: list[str]


def look(url: str, seconds: float = 2.0) -> Look:
    """Open a page, let its clock run for `seconds`, and look. No name but 127.0.0.1 can be reached."""
    from matplotlib.image import imread

    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        picture = Path(folder, "look.png")
        options = [f"--screenshot={picture}", "--dump-dom", f"--virtual-time-budget={round(1000 * seconds)}"]
        dom, log = _run([*options, f"--user-data-dir={folder}/profile"], url)
        if not picture.exists():
            pytest.fail(f"Chromium made no picture of {url}:\n{log[-2000:]}")
        pixels = imread(picture)[..., :3]
    complaints = [line for line in log.splitlines() if "CONSOLE" in line and "GPU stall" not in line]
    return Look(pixels, _text(dom, "output"), _text(dom, "p"), complaints)


def chromium() -> str:
    """Where Chromium is; the test fails where it is not."""
    found = next(filter(None, map(shutil.which, NAMES)), None)
    return found or pytest.fail("this test needs Chromium: apt-get install chromium")


def _run(options: list[str], url: str) -> tuple[str, str]:
    rules = "--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1"
    process = subprocess.Popen(
        [chromium(), *FLAGS, rules, *options, url],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    try:
        return process.communicate(timeout=LIMIT)
    except subprocess.TimeoutExpired:
        return pytest.fail(f"Chromium took more than {LIMIT} s over {url}")
    finally:
        try:
            os.killpg(process.pid, signal.SIGKILL)  # its helpers, if any are left
        except ProcessLookupError:
            pass
        process.wait()


def _text(dom: str, tag: str) -> str:
    match = re.search(rf"<{tag}\b[^>]*>([^<]*)</{tag}>", dom)
    return match[1] if match else ""

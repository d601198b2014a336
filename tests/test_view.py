"""The live view and the HTML page, seen through a headless Chromium."""

import os
import re
import signal
import socket
import subprocess
import sys
import textwrap
import urllib.error
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from browser import Browser
from laws import HANG
from pendpin.graphics.page import POSES, contents, pick, quaternions
from swinging import LEFT, RIGHT, swinging, tip_side

# ---- its data --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("samples", "seconds", "kept"), [(601, 10, 601), (100_001, 10, 601), (11, 10, 11), (1, 0, 1)])
def test_key_poses_keep_both_ends_and_at_most_60_per_second(samples: int, seconds: float, kept: int) -> None:
    keys = pick(np.linspace(3, 3 + seconds, samples), 60, POSES)
    assert len(keys) == kept
    assert (keys[0], keys[-1]) == (0, samples - 1)
    assert np.ptp(np.diff(keys)) <= 1 if kept > 1 else True


def test_quaternions_turn_without_jumps() -> None:
    angle = np.linspace(0, 40, 800)
    turns = Rotation.from_rotvec(np.outer(angle, [0.48, -0.6, 0.64])).as_matrix()[:, None]
    q = quaternions(turns)
    assert np.abs(np.diff(q, axis=0)).max() < 0.06
    np.testing.assert_allclose(Rotation.from_quat(q[:, 0]).as_matrix(), turns[:, 0], atol=1e-14)


def test_a_single_pose_stands_still_for_a_second() -> None:
    still = contents(swinging(samples=1))
    assert still["duration"] == 1


# ---- the live view ---------------------------------------------------------------------------------------------------


def test_live_view_serves_this_machine_only_shows_the_rod_and_leaves_nothing(browser: Browser) -> None:
    with live() as (process, url):
        assert listening(process.pid) == [("127.0.0.1", int(url.rstrip("/").rsplit(":")[-1]))]
        assert relatives(process.pid) == [process.pid]
        for t, side in ((RIGHT, 1), (LEFT, -1)):  # the second is a browser that comes late
            with browser.open(f"{url}#t={t}") as seen:
                assert side * tip_side(seen.picture()) > 100
                assert seen.complaints == []
        process.send_signal(signal.SIGINT)
        assert process.wait(HANG) == 0
        assert process.stderr.read() == ""
    assert relatives(process.pid) == []
    with pytest.raises(ConnectionRefusedError):
        socket.create_connection(("127.0.0.1", int(url.rstrip("/").rsplit(":")[-1])), HANG)


def test_live_view_ends_at_once_even_while_a_browser_holds_on() -> None:
    with live(before="view.PATIENCE = None") as (process, url):  # it would wait for ever for this browser
        port = int(url.rstrip("/").rsplit(":")[-1])
        with socket.create_connection(("127.0.0.1", port)) as slow:
            slow.sendall(b"GET / HTTP/1.1\r\n")
            assert status_of(urllib.request.Request(url)) == 200  # taken in turn: the slow one is being waited for
            process.send_signal(signal.SIGINT)
            assert process.wait(HANG) == 0


def test_live_view_answers_no_foreign_name_and_serves_no_file() -> None:
    with live() as (_, url):
        for path, host, status in (("", "evil.example", 403), ("../view.py", None, 404), ("alive", None, 204)):
            request = urllib.request.Request(url + path, headers={"Host": host} if host else {})
            assert status_of(request) == status


def test_live_view_says_when_its_program_has_ended(browser: Browser) -> None:
    with live() as (process, url), browser.open(f"{url}#t=0", size=(300, 200)) as seen:
        seen.wait_for("performance.getEntriesByName(location.origin + '/alive').length > 0")
        assert seen.text("note") == ""
        process.send_signal(signal.SIGINT)
        seen.wait_for("document.getElementById('note').textContent.includes('pendpin has ended')")


@contextmanager
def live(before: str = "") -> Iterator[tuple[subprocess.Popen, str]]:
    """A process that serves `swinging`, and its address."""
    process = start_python(f"""
        import signal
        signal.signal(signal.SIGINT, signal.default_int_handler)  # where the tests run in the background it is off
        from swinging import swinging
        from pendpin.graphics.view import serve
        from pendpin.graphics import view
        {before}
        serve(swinging(), lambda url: print(url, flush=True))
    """)
    try:
        url = process.stdout.readline().strip()
        assert re.fullmatch(r"http://127\.0\.0\.1:\d+/", url), process.stderr.read()
        yield process, url
    finally:
        process.kill()
        process.communicate()


def start_python(script: str) -> subprocess.Popen:
    source = f"import sys; sys.path[:0] = {sys.path!r}\n{textwrap.dedent(script)}"
    pipe = subprocess.PIPE
    return subprocess.Popen([sys.executable, "-c", source], stdout=pipe, stderr=pipe, text=True, start_new_session=True)


def run_python(script: str) -> None:
    process = start_python(script)
    _, errors = process.communicate(timeout=HANG)
    assert process.returncode == 0, errors


def status_of(request: urllib.request.Request) -> int:
    try:
        with urllib.request.urlopen(request, timeout=HANG) as answer:
            return answer.status
    except urllib.error.HTTPError as error:
        return error.code


def listening(pid: int) -> list[tuple[str, int]]:
    """Addresses and ports at which a process listens; fails if it holds any other socket."""
    links = [os.readlink(f) for f in Path(f"/proc/{pid}/fd").iterdir() if os.path.islink(f)]
    inodes = {link[8:-1] for link in links if link.startswith("socket:[")}
    found = []
    for table in ("tcp", "tcp6", "udp", "udp6"):
        for row in Path(f"/proc/{pid}/net/{table}").read_text().splitlines()[1:]:
            _, local, _, state, *rest = row.split()
            if rest[5] in inodes:
                address, port = local.split(":")
                assert (table, state) == ("tcp", "0A")
                found.append((socket.inet_ntoa(bytes.fromhex(address)[::-1]), int(port, 16)))
    assert len(inodes) == len(found)
    return found


def relatives(session: int) -> list[int]:
    """Processes of a session."""
    found = []
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = stat.read_text().rsplit(")", 1)[1].split()
        except OSError:  # it has just ended
            continue
        if int(fields[3]) == session and fields[0] != "Z":
            found.append(int(stat.parent.name))
    return found

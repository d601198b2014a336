"""The live view in hostile surroundings."""

import signal
import socket
import subprocess
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

import pytest

from laws import HANG
from test_hostile_surroundings import COMMAND, PLAIN

# ---- the live view ---------------------------------------------------------------------------------------------------

JUNK = [
    b"",
    bytes(100),
    b"GET / HTTP/9.9\r\n\r\n",
    b"GET / HTTP/1.1\r\n" + b"A: b\r\n" * 200 + b"\r\n",
    b"A" * 70_000,
    b"GET / HTTP/1.1\r\nHost: \xff\xfe\r\n\r\n",
    b"POST / HTTP/1.1\r\nContent-Length: 99\r\n\r\n",
    b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03",
    b"GET http://[::1 HTTP/1.1\r\n\r\n",
]


def test_two_views_at_once_and_junk_sent_to_one(folder: Path) -> None:
    """Each finds a port of its own; what is no request of a browser is answered or dropped, in silence."""
    with two_views() as views:
        ports = [int(view.stdout.readline().split(b"/")[2].split(b":")[1]) for view in views if view.stdout]
        assert len(set(ports)) == 2
        for junk in JUNK:
            assert b"Content-Security-Policy" not in answer(ports[0], junk)  # as the page has
        for view in views:
            view.send_signal(signal.SIGINT)
        for view in views:
            assert view.communicate(timeout=HANG)[1] == b""
            assert view.returncode == 0


def test_two_views_end_with_a_test_that_fails(folder: Path) -> None:
    """Whatever happens beside them, they end with the test."""
    with pytest.raises(ZeroDivisionError), two_views() as views:
        raise ZeroDivisionError
    assert [view.returncode for view in views] == [-signal.SIGKILL, -signal.SIGKILL]


@contextmanager
def two_views() -> Iterator[list[subprocess.Popen]]:
    """Two views that Ctrl-C ends, also where the tests run in the background, in which shells switch that off."""
    line, pipe = [*COMMAND, "view", "run.npz"], subprocess.PIPE
    ctrl_c_on = lambda: signal.signal(signal.SIGINT, signal.SIG_DFL)  # noqa: E731
    with ExitStack() as ends:
        views = []
        for _ in range(2):
            view = subprocess.Popen(line, env=PLAIN, stdout=pipe, stderr=pipe, preexec_fn=ctrl_c_on)
            views.append(ends.enter_context(view))
            ends.callback(view.kill)
        yield views


def answer(port: int, junk: bytes) -> bytes:
    """What comes back; nothing where the connection is dropped, which may be while the junk is still being sent."""
    with suppress(ConnectionError), socket.create_connection(("127.0.0.1", port), timeout=HANG) as end:
        end.sendall(junk)
        end.shutdown(socket.SHUT_WR)
        return end.recv(10_000)
    return b""

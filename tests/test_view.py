"""The live view and the HTML page, seen through a headless Chromium."""

import itertools
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

from browser import Browser, chromium
from laws import HANG
from pendpin.errors import InputError
from pendpin.graphics import view
from pendpin.graphics.drawing import WORLD, Drawing, Shape
from pendpin.graphics.page import POSES, contents, page, pick, quaternions, write_page

ORANGE, STEEL, BLUE = 0xD9622B, 0x7A8696, 0x2B6CB0
LEFT, RIGHT = 1.5, 0.5  # s: when the rod of `swinging` is seen on the left and on the right


def pose(x: float = 0, y: float = 0, z: float = 0, turn: np.ndarray | None = None) -> np.ndarray:
    out = np.eye(4)
    out[:3, 3] = x, y, z
    out[:3, :3] = np.eye(3) if turn is None else turn
    return out


def swinging(seconds: float = 2.0, samples: int = 121, title: str = "A rod") -> Drawing:
    """A rod of 1 m that swings about x by 1 rad, once in 2 s: farthest along y at 0.5 s, along -y at 1.5 s."""
    t = np.linspace(0, seconds, samples)
    turns = Rotation.from_rotvec(np.outer(np.sin(np.pi * t), [1.0, 0, 0])).as_matrix()
    poses = np.tile(np.eye(4), (samples, 1, 1, 1))
    poses[:, 0, :3, :3] = turns
    sideways = Rotation.from_euler("y", 90, degrees=True).as_matrix()
    shapes = (
        Shape("box", (0.24, 0.24, 0.02), pose(z=0.04), STEEL, WORLD),
        Shape("sphere", (0.018,), pose(), STEEL, 0),
        Shape("cylinder", (0.008, 0.09), pose(turn=sideways), STEEL, WORLD),
        Shape("cylinder", (0.01, 1.0), pose(z=-0.5), ORANGE, 0),
    )
    return Drawing(title, t, poses, shapes, -turns[..., 2], 1.0)


def of_color(pixels: np.ndarray, color: int) -> np.ndarray:
    """Where in the picture, above the bar, a colour is seen, in whatever light: rows and columns (k, 2)."""
    wanted = np.array([(color >> 16) & 255, (color >> 8) & 255, color & 255]) / 255
    scene = pixels[:-100]
    brightness = scene.max(axis=-1, keepdims=True)
    near = np.abs(scene / np.maximum(brightness, 1e-9) - wanted / wanted.max()).max(axis=-1) < 0.08
    return np.argwhere(near & (brightness[..., 0] > 0.3))


def tip_side(pixels: np.ndarray) -> float:
    """How far right of its joint the rod's lower end is seen, in columns."""
    seen = of_color(pixels, ORANGE)
    assert len(seen) > 1000, "the rod is not seen"
    return seen[-20:, 1].mean() - seen[:20, 1].mean()


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with chromium() as running:
        yield running


# ---- the page --------------------------------------------------------------------------------------------------------


def test_page_shows_the_rod_where_it_is_at_each_time(tmp_path: Path, browser: Browser) -> None:
    path = write_page(tmp_path / "run.html", swinging())
    assert os.listdir(tmp_path) == ["run.html"]
    for t, side in ((RIGHT, 1), (LEFT, -1)):
        with browser.open(f"{path.as_uri()}#t={t}") as seen:
            picture = seen.picture()
            assert side * tip_side(picture) > 100
            assert len(of_color(picture, BLUE)) > 300, "the trail of the tip is not seen"
            assert seen.text("clock") == f"{t:.2f} / 2.00 s"
            assert seen.requests == [f"{path.as_uri()}"]
            assert seen.complaints == []


@pytest.mark.slow  # it reads a clock, the page's own
def test_page_plays_in_real_time_whatever_the_spacing_of_samples(tmp_path: Path, browser: Browser) -> None:
    path = write_page(tmp_path / "run.html", swinging(seconds=60, samples=1234))
    now = "[performance.now() / 1000, parseFloat(document.getElementById('time').value)]"
    every_frame = f"window.seen = []; (function look() {{ seen.push({now}); requestAnimationFrame(look) }})()"
    with browser.open(path.as_uri(), size=(300, 200)) as seen:
        for speed in (1, 5):
            choose = (
                f"const s = document.getElementById('speed'); s.value = {speed}; s.dispatchEvent(new Event('change'))"
            )
            seen.evaluate(f"{{{choose}}}")
            seen.evaluate(f"{{{every_frame}}}")
            seen.wait_for("window.seen.length > 20 && window.seen.at(-1)[0] - window.seen[0][0] > 2")
            clock, shown = np.array(seen.evaluate("window.seen")).T
            assert np.polyfit(clock, shown, 1)[0] == pytest.approx(speed, rel=0.05)  # however few frames there are


def test_page_obeys_its_controls(tmp_path: Path, browser: Browser) -> None:
    path = write_page(tmp_path / "run.html", swinging())
    with browser.open(path.as_uri(), size=(300, 200)) as seen:
        playing = "document.getElementById('play').classList.contains('playing')"
        seen.wait_for(playing)
        seen.evaluate("document.getElementById('play').click()")
        seen.wait_for(f"!{playing}")
        seen.evaluate("location.hash = '#t=2'")
        seen.wait_for("document.getElementById('clock').textContent == '2.00 / 2.00 s'")
        slide = "const s = document.getElementById('time'); s.value = 0.25; s.dispatchEvent(new Event('input'))"
        seen.evaluate(f"{{{slide}}}")
        seen.wait_for("document.getElementById('clock').textContent == '0.25 / 2.00 s'")
        seen.evaluate("document.getElementById('play').click()")
        seen.wait_for(playing)


def test_page_has_no_outside_address_and_forbids_every_connection() -> None:
    text = page(swinging(title="<b>&"))
    assert re.findall(r"""(?:src|href|action)\s*=\s*["']?(?!data:)[^"'\s>]*//""", text) == []
    assert "connect-src 'none'" in text
    assert "default-src 'none'" in text
    assert "<b>" not in text


def test_writing_the_page_opens_no_socket_and_starts_no_library_that_would(tmp_path: Path) -> None:
    run_python(f"""
        import socket, subprocess
        def refuse(*args, **kwargs): raise AssertionError("a socket or process was asked for")
        socket.socket.__init__ = subprocess.Popen.__init__ = refuse
        from test_view import swinging
        from pendpin.graphics.page import write_page
        write_page({str(tmp_path / "run.html")!r}, swinging())
        assert not {{"zmq", "meshcat", "tornado", "IPython"}} & set(sys.modules)
    """)
    assert (tmp_path / "run.html").stat().st_size > 800_000


def test_page_that_cannot_be_written_leaves_nothing(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"run\.html"):
        write_page(tmp_path / "missing" / "run.html", swinging())
    assert os.listdir(tmp_path) == []


def test_meshes_are_seen_and_bad_ones_named(tmp_path: Path, browser: Browser) -> None:
    tip = tmp_path / "tetrahedron.obj"
    tip.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n")
    stl = tmp_path / "triangle.STL"
    facet = np.array([1, 0, 0, 0, -1, 0, 0, 1, 0, 0, 0, 1], "<f4").tobytes() + bytes(2)
    stl.write_bytes(bytes(80) + np.array([1], "<u4").tobytes() + facet)
    still = swinging(samples=1)
    meshes = (
        Shape("mesh", (0.4, 0.4, 0.4), pose(z=-0.6), ORANGE, 0, str(tip)),
        Shape("mesh", (0.3, 0.3, 0.3), pose(), BLUE, WORLD, str(stl)),
    )
    path = write_page(tmp_path / "run.html", Drawing("", still.t, still.poses, meshes, still.trail, 1.0))
    with browser.open(path.as_uri()) as seen:
        picture = seen.picture()
        assert seen.complaints == []
    assert len(of_color(picture, ORANGE)) > 1000
    assert len(of_color(picture, BLUE)) > 1000
    for name, reason in {"gone.stl": "No such file", "rod.blend": "one of: .obj, .stl, .dae"}.items():
        bad = (Shape("mesh", (1, 1, 1), pose(), ORANGE, 0, str(tmp_path / name)),)
        with pytest.raises(InputError, match=f"{name}.*{reason}"):
            page(Drawing("", still.t, still.poses, bad, still.trail, 1.0))


def test_pages_stay_small() -> None:
    bodies, samples = 1000, 601
    poses = np.tile(np.eye(4), (samples, bodies, 1, 1))
    shapes = tuple(Shape("cylinder", (0.01, 0.1), pose(), ORANGE, body) for body in range(bodies))
    many = Drawing("", np.linspace(0, 10, samples), poses, shapes, np.zeros((samples, 3)), 100.0)
    assert len(page(many)) < 6e6
    assert len(page(swinging(seconds=10, samples=10_001))) < 1e6


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


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("t", np.zeros(3)),
        ("trail", np.zeros((121, 2))),
        ("poses", np.full((121, 1, 4, 4), np.nan)),
        ("poses", np.empty((121, 0, 4, 4))),
        ("shapes", (Shape("sphere", (1.0,), np.eye(4), 0, 1),)),
        ("extent", 0.0),
    ],
)
def test_drawing_refuses_parts_that_do_not_fit(field: str, value: object) -> None:
    with pytest.raises(ValueError, match=r"fit|finite|bodies|length"):
        Drawing(**(vars(swinging()) | {field: value}))


@pytest.mark.parametrize("parts", [("cone", (1.0,)), ("box", (1.0,)), ("sphere", (1.0, 2.0))])
def test_shape_refuses_parts_that_do_not_fit(parts: tuple) -> None:
    with pytest.raises(ValueError, match=r"one of: cylinder|sizes"):
        Shape(*parts, np.eye(4), 0, 0)


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
    with live(before="view._Handler.timeout = None") as (process, url):  # it would wait for ever for this browser
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


def test_live_view_names_a_port_that_is_taken_or_none() -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        with pytest.raises(InputError, match=f"port {port} of 127.0.0.1: address already in use"):
            view.serve(swinging(), port=port, duration=0)
    with pytest.raises(InputError, match="port 70000"):
        view.serve(swinging(), port=70000, duration=0)


def test_live_view_ends_after_its_duration(monkeypatch: pytest.MonkeyPatch) -> None:
    """Looked at every half second of a made-up clock, a view of one second ends at the second look."""
    clock, asked, urls = itertools.count(0.0, 0.5), [], []
    monkeypatch.setattr(view.time, "monotonic", lambda: next(clock))
    monkeypatch.setattr(view._Server, "handle_request", lambda server: asked.append(server))
    view.serve(swinging(), ready=urls.append, duration=1.0)
    assert len(asked) == 1  # at 0.5 s; at 1 s it ends
    assert len(urls) == 1


@contextmanager
def live(options: str = "", before: str = "") -> Iterator[tuple[subprocess.Popen, str]]:
    """A process that serves `swinging`, and its address."""
    process = start_python(f"""
        import signal
        signal.signal(signal.SIGINT, signal.default_int_handler)  # where the tests run in the background it is off
        from test_view import swinging
        from pendpin.graphics.view import serve
        from pendpin.graphics import view
        {before}
        serve(swinging(), ready=lambda url: print(url, flush=True), {options})
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

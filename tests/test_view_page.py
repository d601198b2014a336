"""The page of a run, as a browser shows it."""

import os
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from browser import Browser
from pendpin.errors import InputError
from pendpin.graphics.drawing import WORLD, Drawing, Shape
from pendpin.graphics.page import compress, contents, page, write_page
from swinging import BLUE, LEFT, ORANGE, RIGHT, of_color, pose, swinging, tip_side
from test_view import run_python


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


def test_times_far_from_0_are_shown_after_the_start(tmp_path: Path, browser: Browser) -> None:
    """Seconds since 1970 have more digits than fit; an address still names a time of the scene."""
    motion = swinging()
    path = write_page(tmp_path / "run.html", replace(motion, t=motion.t + 1.7e9))
    with browser.open(f"{path.as_uri()}#t=1700000000.5") as seen:
        assert seen.text("clock") == "+0.50 / 2.00 s"


def test_a_mesh_that_cannot_be_read_is_left_out(tmp_path: Path, browser: Browser) -> None:
    """The page names each and plays on, however a file is damaged."""
    damaged = {"empty.stl": b"", "bytes.stl": bytes(range(256)) * 4, "no.dae": b"<COLLADA/>", "text.DAE": b"text"}
    shapes = []
    for name, content in damaged.items():
        (tmp_path / name).write_bytes(content)
        shapes.append(Shape("mesh", (1.0, 1.0, 1.0), np.eye(4), 0xFF0000, 0, str(tmp_path / name)))
    motion = swinging()
    path = write_page(tmp_path / "run.html", replace(motion, shapes=(*motion.shapes, *shapes)))
    with browser.open(f"{path.as_uri()}#t=0.5") as seen:
        assert seen.text("clock") == "0.50 / 2.00 s"
        assert tip_side(seen.picture()) > 100
        assert seen.text("note").splitlines() == [f"the mesh {name} cannot be read: it is left out" for name in damaged]


def test_a_packed_page_unpacks_itself(tmp_path: Path, browser: Browser) -> None:
    """It is what the page is, in less than half its size, and asks for nothing either."""
    whole = page(swinging())
    packed = compress(whole)
    assert len(packed) < len(whole) / 2
    path = tmp_path / "packed.html"
    path.write_text(packed)
    with browser.open(f"{path.as_uri()}#t=0.5") as seen:
        assert seen.text("clock") == "0.50 / 2.00 s"
        assert tip_side(seen.picture()) > 100
        assert seen.requests == [path.as_uri()]
        assert seen.complaints == []


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
        from swinging import swinging
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


def test_parts_of_a_collada_file_keep_places_and_normals_alone(tmp_path: Path) -> None:
    """meshcat joins the parts of a file into one, which fails where one has a texture or colours and another has none."""
    mesh = tmp_path / "two.dae"
    inputs = ('semantic="VERTEX"', 'semantic="NORMAL"', 'semantic="TEXCOORD"', "semantic='COLOR'")
    mesh.write_text(f"<COLLADA>{''.join(f'<input {one}/>' for one in inputs)}</COLLADA>")
    still = swinging(samples=1)
    shapes = (Shape("mesh", (0.5, 0.5, 0.5), pose(), BLUE, 0, str(mesh)),)
    text = str(contents(Drawing("", still.t, still.poses, shapes, still.trail, 1.0))["commands"])
    assert [word in text for word in ("VERTEX", "NORMAL", "TEXCOORD", "COLOR")] == [True, True, False, False]


def test_pages_stay_small() -> None:
    assert len(page(swinging(seconds=10, samples=10_001))) < 1e6


@pytest.mark.slow
def test_pages_of_many_bodies_stay_small() -> None:
    bodies, samples = 1000, 601
    poses = np.tile(np.eye(4), (samples, bodies, 1, 1))
    shapes = tuple(Shape("cylinder", (0.01, 0.1), pose(), ORANGE, body) for body in range(bodies))
    many = Drawing("", np.linspace(0, 10, samples), poses, shapes, np.zeros((samples, 3)), 100.0)
    assert len(page(many)) < 6e6

"""The player of a run: every control does what it says, in a headless Chromium; and what is drawn, by its laws."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import pendpin as pp
from browser import Browser, Page
from pendpin.graphics.drawing import Curve, Plot, Quantity
from pendpin.graphics.page import write_page
from pendpin.graphics.run_drawing import drawing_of
from pendpin.scene import builtin_scene
from swinging import ORANGE, of_color, swinging

VIOLET = 0x6B46C1  # of the arrows
SIZE = (800, 700)


@pytest.fixture(scope="module")
def run() -> pp.Trajectory:
    """Two rods with a payload that hang from a moving support."""
    scene = pp.Scene(
        duration=2.0,
        model=pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0, radius=0.02), pp.Rod(length=0.5, mass=0.5, payload=20.0)]),
        start=pp.Start(positions={"phi_1": 0.4}),
        effects=[pp.effects.Gravity(), pp.effects.Support(amplitude=(0.5, 0.2, 0.0), frequency=3.0)],
    )
    return pp.simulate(scene, method="dop853")


@pytest.fixture(scope="module")
def page(run: pp.Trajectory, browser: Browser, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Page]:
    path = run.animate().save(tmp_path_factory.mktemp("player") / "run.html")
    with browser.open(f"{path.as_uri()}#t=1", size=SIZE) as seen:
        yield seen
        assert seen.complaints == []
        assert seen.requests == [path.as_uri()]


def click(page: Page, name: str) -> None:
    page.evaluate(f"document.querySelector({name!r}).click()")


def press(page: Page, key: str) -> None:
    page.evaluate(f"document.body.dispatchEvent(new KeyboardEvent('keydown', {{key: {key!r}, bubbles: true}})); 0")


@pytest.mark.parametrize(("on", "back"), [("#on", "#back"), ("ArrowRight", "ArrowLeft")])
def test_one_frame_on_and_back(page: Page, run: pp.Trajectory, on: str, back: str) -> None:
    frames = run.t
    act = click if on.startswith("#") else press
    page.evaluate("seek(0)")
    for control, frame in ((on, 1), (on, 2), (on, 3), (back, 2), (back, 1), (back, 0), (back, 0), (on, 1)):
        act(page, control)
        assert page.evaluate("t") == pytest.approx(frames[frame], abs=1e-6)
        assert page.evaluate("playing") is False
    page.evaluate(f"seek({(frames[5] + frames[6]) / 2})")
    act(page, back)
    assert page.evaluate("t") == pytest.approx(frames[5], abs=1e-6)
    page.evaluate(f"seek({frames[-1]})")
    act(page, on)
    assert page.evaluate("t") == pytest.approx(frames[-1], abs=1e-6)


def test_it_begins_again_or_stops_at_the_end(page: Page) -> None:
    state = "[t, playing, element('loop').ariaPressed]"
    for looping, end in (("true", [0.25, True, "true"]), ("false", [2.0, False, "false"])):
        assert page.evaluate(f"loop({looping}); seek(1.5); play(true); pass(0.75); {state}") == pytest.approx(end)
    assert page.evaluate(f"element('play').click(); {state}") == [0, True, "false"]  # from the end it begins again
    page.evaluate("play(false)")  # on a busy machine it could meanwhile reach the end and stop by itself
    press(page, "l")
    press(page, " ")
    assert page.evaluate("[looping, playing]") == [True, True]
    assert page.evaluate("play(false); loop(false); element('loop').click(); looping") is True


def test_reactions_are_drawn_where_they_are_asked_for(page: Page, run: pp.Trajectory) -> None:
    assert page.evaluate("drawing.forces.largest") == pytest.approx(
        np.linalg.norm(run.wrench[:, [1, 3], :3], axis=-1).max()
    )
    assert len(of_color(page.picture(), VIOLET)) < 20
    for act in (lambda: click(page, "#reactions"), lambda: press(page, "r")):
        act()
        assert len(of_color(page.picture(), VIOLET)) > 150
        assert "longest arrow is" in page.text("scale")
        act()
        assert len(of_color(page.picture(), VIOLET)) < 20


def test_arrows_are_the_forces_of_the_joints_in_the_world(run: pp.Trajectory) -> None:
    """They are what moves the mass above and below: gravity and the support's acceleration are all that acts besides."""
    drawing = drawing_of(run)
    masses, lengths = np.array([1.0, 20.5]), np.array([1.0, 0.5])
    forces = drawing.forces
    assert forces is not None
    assert not forces[:, drawing.support].any()
    i = np.arange(5, len(run.t) - 5)
    h = run.t[1] - run.t[0]
    joints = drawing.poses[:, :2, :3, 3]
    down = -drawing.poses[:, :2, :3, 2]
    com = np.stack([lengths[0] / 2, (0.5 * 0.25 + 20 * 0.5) / 20.5])
    centres = joints + down * com[:, None]
    stencil = {-2: -1 / 12, -1: 4 / 3, 0: -5 / 2, 1: 4 / 3, 2: -1 / 12}
    acceleration = sum(weight * centres[i + k] for k, weight in stencil.items()) / h**2
    momentum = masses[:, None] * (acceleration + np.array([0, 0, 9.81]))
    assert np.abs(forces[i, 1] - momentum[:, 1]).max() < 1e-4 * np.abs(momentum).max()  # differences of order h^4
    assert np.abs(forces[i, 0] - momentum.sum(1)).max() < 1e-4 * np.abs(momentum).max()


@pytest.mark.parametrize(
    ("name", "key", "toward"), [("front", "2", [1, 0, 0]), ("side", "3", [0, -1, 0]), ("above", "4", [0, 0, 1])]
)
def test_views_look_from_where_they_say(page: Page, name: str, key: str, toward: list[float]) -> None:
    for act in (lambda: click(page, f"button[value={name}]"), lambda: press(page, key)):
        click(page, "button[value=corner]")
        act()
        x, y, z = page.evaluate("viewer.camera.position.clone().sub(viewer.controls.target).normalize().toArray()")
        np.testing.assert_allclose([x, -z, y], toward, atol=2e-4)  # three.js has y up
        assert page.evaluate("[...document.querySelectorAll('#views [aria-pressed=true]')].map((b) => b.value)") == [
            name
        ]
    click(page, "button[value=corner]")


def test_the_same_swing_seen_from_front_side_and_above(browser: Browser, tmp_path: Path) -> None:
    """At 0.5 s the rod is out along y by 1 rad: to the right from the front, foreshortened from the side, up from above."""
    path = write_page(tmp_path / "run.html", swinging())
    ratios = {}
    with browser.open(f"{path.as_uri()}#t=0.5", size=(500, 500)) as seen:
        for name in ("front", "side", "above"):
            seen.evaluate(f"look({name!r})")
            rows, columns = np.ptp(of_color(seen.picture(), ORANGE), axis=0)
            ratios[name] = columns / rows
    assert ratios["front"] == pytest.approx(np.tan(1.0), rel=0.1)
    assert ratios["side"] < 0.1
    assert ratios["above"] < 0.1


@pytest.mark.parametrize("swing", [[1, 0], [0, 1], [1, 1], [1, -0.7]])
def test_the_first_view_looks_across_the_swing(page: Page, swing: list[float]) -> None:
    """At 54 degrees, whatever the direction in which it swings; a round path leaves the camera where it is."""
    path = np.outer(np.linspace(-1, 1, 9), [*swing, 0]).ravel().tolist()
    x, y, z = page.evaluate(f"acrossSwing({path}, [1, -0.72, 0.27])")
    across = (x * swing[1] - y * swing[0]) / np.hypot(x, y) / np.hypot(*swing)
    assert abs(across) == pytest.approx(1 / np.hypot(1, 0.72), abs=1e-6)
    assert z == 0.27
    angles = np.linspace(0, 6.28, 40)
    circle = np.stack([np.cos(angles), np.sin(angles), 0 * angles], 1).ravel().tolist()
    assert page.evaluate(f"acrossSwing({circle}, [1, -0.72, 0.27])") == [1, -0.72, 0.27]


@pytest.mark.parametrize("width", [420, 1200])
def test_legends_are_whole(page: Page, width: int) -> None:
    page.resize(width, 800)
    boxes = page.evaluate("""[...document.querySelectorAll('figcaption')].map((c) =>
        [c.scrollHeight - c.clientHeight, c.scrollWidth - c.clientWidth, c.getBoundingClientRect().right])""")
    assert all(below <= 0 and beside <= 0 and right <= width for below, beside, right in boxes)
    page.resize(*SIZE)


def test_plots_show_the_run_and_set_the_time(page: Page, run: pp.Trajectory) -> None:
    for place, plot in ((0.25, 0), (0.75, 1)):
        spot = f"document.querySelectorAll('.curves')[{plot}]"
        box = page.evaluate(
            f"(({{left, top, width, height}}) => [left, top, width, height])({spot}.getBoundingClientRect())"
        )
        page.press(box[0] + place * box[2], box[1] + box[3] / 2)
        assert page.evaluate("t") == pytest.approx(2 * place, abs=2 / box[2])
        cursors = page.evaluate("[...document.querySelectorAll('.cursor')].map((c) => parseFloat(c.style.left))")
        assert cursors == pytest.approx([100 * place] * 3, abs=100 / box[2])
        row = int(np.searchsorted(run.t, page.evaluate("t") + 1e-6, side="right")) - 1
        shown = page.evaluate("[...document.querySelectorAll('figcaption span')].map((s) => s.textContent.split(' '))")
        wanted = {"kinetic": "kinetic", "R3_1": "R3_1", "R3_2": "R3_2"} | {name: name for name in run.joints}
        assert set(wanted) <= {name for name, _ in shown}
        for name, value in shown:
            if name in wanted:  # three digits, of a number that the page holds as one of 65,535 levels
                level = np.ptp(run[name]) / 65535
                assert float(value) == pytest.approx(run[name][row], rel=5e-3, abs=level + 1e-9)
    assert page.evaluate("document.querySelectorAll('path.curve').length") == 3 + 4 + 2


def choose(page: Page, plot: int, title: str) -> None:
    """Choose what a plot shows, as a user does."""
    page.evaluate(f"""{{ const s = document.querySelectorAll('select.quantity')[{plot}];
        s.value = [...s.options].find((o) => o.textContent === {title!r}).value;
        s.dispatchEvent(new Event('change')) }}""")


def test_every_quantity_can_be_plotted(page: Page, run: pp.Trajectory) -> None:
    offered = page.evaluate("[...document.querySelector('select.quantity').options].map((o) => o.textContent)")
    assert set(run.names) - {"t"} <= set(offered)
    page.evaluate(f"seek({run.t[60:62].mean()})")  # between two samples a value is on the line through them
    for name in ("Mc_1", "R1_2", "theta_2_acceleration"):
        choose(page, 0, name)
        [text] = page.evaluate(
            "[...document.querySelector('.values').querySelectorAll('span')].map((s) => s.textContent)"
        )
        level = np.ptp(run[name]) / 65535
        assert float(text.split()[-1]) == pytest.approx(run[name][60:62].mean(), rel=5e-3, abs=level + 1e-9)
    choose(page, 0, "Energy, potential above its least")


def test_a_plot_of_many_swings_is_an_envelope_until_it_is_zoomed(browser: Browser, tmp_path: Path) -> None:
    """300 swings are a solid block; of few, every one is drawn. The axis says what is to be seen."""
    t = np.linspace(0, 300, 12_001)
    swing = np.exp(-t / 200) * np.sin(2 * np.pi * t)
    many = replace(
        swinging(seconds=300, samples=len(t)),
        quantities=(Quantity("swing", "rad", swing),),
        plots=(Plot("Swing", (Curve("swing", "swing", "#000000"),)),),
    )
    path = write_page(tmp_path / "run.html", many)
    envelopes = "document.querySelectorAll('path.envelope').length"
    with browser.open(f"{path.as_uri()}#t=100", size=SIZE) as seen:
        assert seen.evaluate(envelopes) == 1
        for _ in range(7):
            press(seen, "+")
        assert seen.evaluate(envelopes) == 0
        low, *_, high = seen.evaluate("[...document.querySelectorAll('i.x:not(.name)')].map((i) => +i.textContent)")
        assert 95 <= low < high <= 105
        assert "time (s)" in seen.evaluate("[...document.querySelectorAll('i.x')].map((i) => i.textContent)")
        seen.evaluate("document.querySelector('.curves').dispatchEvent(new Event('dblclick')); 0")
        assert seen.evaluate(envelopes) == 1
        assert seen.complaints == []


def test_the_frames_are_those_of_the_derivation(page: Page, run: pp.Trajectory) -> None:
    """The close-up says both angles of the chosen joint, and its camera looks at that joint wherever it goes."""
    act = (lambda: click(page, "#frames")), (lambda: press(page, "f"))
    act[0]()
    for t in (0.4, 1.7):
        page.evaluate(f"seek({t})")
        row = int(np.searchsorted(run.t, t))
        for joint in (1, 2):
            page.evaluate(
                f"element('joint').value = {joint - 1}; element('joint').dispatchEvent(new Event('change')); 0"
            )
            words = page.text("angles").replace(",", "").split()
            angles = np.array([float(words[1]), float(words[4])])
            wanted = [run[f"theta_{joint}"][row], run[f"phi_{joint}"][row]]
            apart = np.array([angles, wanted])
            np.testing.assert_allclose(np.cos(apart[0] - apart[1]), 1, atol=1e-4)  # shown to 1 mrad, turns left out
    letters = page.evaluate("[...document.querySelectorAll('#letters span')].map((s) => s.textContent)")
    assert {"b1", "b2", "b3", "xW", "yW", "zW", "θ", "φ"} <= set(letters)
    act[1]()
    assert page.evaluate("element('closeup').hidden && !frames.group.visible") is True


def test_arrows_leave_the_camera_where_it_was(page: Page) -> None:
    click(page, "button[value=corner]")
    place = "viewer.camera.position.toArray()"
    before = page.evaluate(place)
    click(page, "#reactions")
    assert page.evaluate(place) == before
    click(page, "#reactions")


def test_runs_side_by_side(browser: Browser, run: pp.Trajectory, tmp_path: Path) -> None:
    """The second run stands where it was, its distance is plotted, and the report has a column for each run."""
    other = pp.simulate(run.source.replace({"start.positions.phi_1": 0.5}), method="rk4", step=0.002)
    path = run.animate(compare=other).save(tmp_path / "both.html")
    apart = np.linalg.norm(run.tips[:, -1] - other.tips[:, -1], axis=-1)
    with browser.open(f"{path.as_uri()}#t=1.5", size=SIZE) as seen:
        ghost = "viewer.scene_tree.find(['pendpin', 'ghost_0']).object.getObjectByName('body_1').position.toArray()"
        np.testing.assert_allclose(seen.evaluate(ghost), drawing_of(other).poses[90, 1, :3, 3], atol=1e-4)
        text = seen.evaluate("document.querySelector('.values span').textContent")
        assert float(text.split()[-1]) == pytest.approx(apart[90], rel=5e-3, abs=np.ptp(apart) / 65535)
        rows = seen.evaluate(
            "[...document.querySelectorAll('#report tr')].map((r) => [...r.cells].map((c) => c.innerText))"
        )
        found = {name: cells for name, *cells in rows}
        settings = [f"dop853, {run.stats.setting}", f"rk4, {other.stats.setting}"]
        assert [cell.partition(" (")[0] for cell in found["method"]] == settings
        assert len(found["cross-check"]) == 2
        assert seen.evaluate("document.querySelector('#report img').naturalWidth") > 300
        assert seen.complaints == []
        assert seen.requests == [path.as_uri()]


@pytest.mark.parametrize("turned", [False, True])
def test_a_page_says_which_run_has_no_such_quantity(browser: Browser, tmp_path: Path, turned: bool) -> None:
    """The quantity is offered in either order, drawn of the run that has it, and the other run is named."""
    scene = pp.Scene(
        model=pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0, radius=0.02)]),
        start=pp.Start(positions={"phi": 0.4}),
        effects=[pp.effects.Gravity()],
        duration=0.5,
    )
    both = [pp.simulate(scene, energy_balance=True), pp.simulate(scene, method="rk45")]
    one, other = both[::-1] if turned else both
    path = one.animate(compare=other).save(tmp_path / "both.html")
    with browser.open(f"{path.as_uri()}#t=0", size=SIZE) as seen:
        choose(seen, 0, "work_gravity")
        words = seen.evaluate("document.querySelector('.values').innerText")
        assert words.count("work_gravity") == 1
        assert f"rk45, {both[1].stats.setting}: no work_gravity" in words
        choose(seen, 0, "phi")
        assert "no phi" not in seen.evaluate("document.querySelector('.values').innerText")


def test_speed_is_chosen_and_meshcats_panel_is_gone(page: Page) -> None:
    page.evaluate("element('speed').value = 5; element('speed').dispatchEvent(new Event('change'))")
    assert page.evaluate("speed") == 5
    page.evaluate("setSpeed(1)")
    assert page.evaluate("document.querySelector('.dg')") is None


@pytest.mark.parametrize("width", [800, 1600])
def test_every_control_has_a_name_and_a_place(page: Page, width: int) -> None:
    page.resize(width, 700)
    controls = page.evaluate("""[...document.querySelectorAll('button, input, select')]
        .filter((c) => c.checkVisibility()).map((c) => {
        const { left, right, top, bottom } = c.getBoundingClientRect();
        return [c.ariaLabel ?? c.textContent, left, right, top, bottom, c.tabIndex];
    })""")
    assert len(controls) == (18 if width > 960 else 17)  # below, the third plot makes room
    assert all(name and index == 0 for name, *_, index in controls)
    boxes = np.array([box[1:5] for box in controls])
    assert (boxes[:, :2] >= 0).all()
    assert (boxes[:, 1] <= width).all()
    for i, (left, right, top, bottom) in enumerate(boxes):
        others = np.delete(boxes, i, axis=0)
        apart = (others[:, 1] <= left) | (others[:, 0] >= right) | (others[:, 3] <= top) | (others[:, 2] >= bottom)
        assert apart.all(), controls[i][0]
    page.resize(*SIZE)


def test_the_address_asks_for_a_view_a_speed_and_arrows(page: Page) -> None:
    page.evaluate("location.hash = '#t=0.5&view=side&speed=10&reactions=on'")
    page.wait_for("t == 0.5 && view == 'side' && speed == 10 && arrows.group.visible")
    page.evaluate("location.hash = '#t=1&view=corner&speed=1&reactions=off&nonsense=1&view=none'")
    page.wait_for("t == 1 && view == 'corner' && speed == 1 && !arrows.group.visible")


# ---- what is drawn -----------------------------------------------------------------------------------------------------


def test_the_support_is_drawn_moving_and_the_rods_with_it(run: pp.Trajectory, tmp_path: Path) -> None:
    loaded = pp.Trajectory.load(run.save(tmp_path / "run.npz"))
    for one in (run, loaded):
        drawing = drawing_of(one)
        over_ground = np.outer(np.sin(3.0 * run.t), [0.5, 0.2, 0.0])
        np.testing.assert_allclose(drawing.poses[:, drawing.support, :3, 3], over_ground, atol=1e-15)
        np.testing.assert_allclose(drawing.poses[:, 0, :3, 3], over_ground, atol=1e-15)
        np.testing.assert_allclose(drawing.trail, run.tips[:, -1] + over_ground, atol=1e-15)
        assert any(shape.body == drawing.support for shape in drawing.shapes)


def test_above_hides_the_plate_of_the_built_in_rod(browser: Browser, tmp_path: Path) -> None:
    """Its plate belongs to a URDF's base, and would cover what hangs below as that of a chain would."""
    path = pp.simulate(builtin_scene(), duration=0.5).animate().save(tmp_path / "rod.html")
    with browser.open(f"{path.as_uri()}#t=0&view=above", size=(300, 300)) as seen:
        assert seen.evaluate("support.visible") is False
        assert seen.evaluate("look('corner'); support.visible") is True


def test_a_film_shows_the_support_where_it_is(run: pp.Trajectory, tmp_path: Path) -> None:
    """In 25 frames a second; within the size of its grey square, 11 pixels, of which rods may cover a part."""
    run = pp.simulate(run.source, duration=0.6)
    frames = read_film(run.animate().save(tmp_path / "run.mp4"))
    assert len(frames) == 16
    grey = [np.argwhere(np.abs(frame - np.array([0x7A, 0x86, 0x96])).max(-1) < 12) for frame in frames]
    across = np.array([np.median(places[:, 1]) for places in grey])  # not moved by edges of rods that look grey
    assert not np.isnan(across).any()
    eye = np.cos(np.pi / 6) * 0.5 + np.sin(np.pi / 6) * 0.2
    wanted = eye * np.sin(3.0 * run.t[np.linspace(0, len(run.t) - 1, 16).round().astype(int)])
    slope, _ = np.polyfit(wanted, across, 1)
    assert slope > 100  # pixels per m
    np.testing.assert_allclose(across - across.mean(), slope * (wanted - wanted.mean()), atol=11)


@pytest.mark.slow
def test_a_film_shows_the_other_run_as_a_ghost(tmp_path: Path) -> None:
    """Two rods at rest, one hanging and one held up by a spring: each where its own angle is."""
    scene = pp.Scene(duration=0.2, model=pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0)]), effects=[pp.effects.Gravity()])
    hanging = pp.simulate(scene)
    upright = pp.simulate(scene.replace({"start.positions.phi_1": np.pi}))
    frame = read_film(hanging.animate(compare=upright).save(tmp_path / "both.mp4"))[2]
    green, orange = np.array([0x80, 0xCE, 0xB9]), np.array([0xD5, 0x5E, 0x00])  # the ghost is half white
    above, below = (np.argwhere(np.abs(frame - color).max(-1) < 30)[:, 0].mean() for color in (green, orange))
    assert above < len(frame) / 2 < below


def read_film(path: Path) -> np.ndarray:
    """The frames of an MP4, (n, rows, columns, 3) from 0 to 255."""
    import imageio_ffmpeg

    reader = imageio_ffmpeg.read_frames(str(path), pix_fmt="rgb24")
    columns, rows = next(reader)["size"]
    return np.array([np.frombuffer(frame, np.uint8).reshape(rows, columns, 3) for frame in reader], float)

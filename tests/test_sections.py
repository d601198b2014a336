"""Sections: side by side as one by one, exact curves, areas that stay, published doublings, hostile input."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import pendpin as pp
from bad_input import run_main
from pendpin import effects as fx
from pendpin.model.bodies import mass_matrix
from pendpin.stability import sections

GRAVITY = fx.Gravity()
PLANAR = pp.Scene(
    model=pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0, radius=0.02), pp.Rod(length=0.7, mass=0.5)]),
    effects=[GRAVITY],
    start=pp.Start(positions={"theta_1": 1.0, "theta_2": 0.3}),
    duration=5.0,
    solver=pp.Solver(tolerance=1e-11),
)
POINT = pp.Chain(rods=[pp.Rod(length=1.0, mass=0.0, payload=1.0)])


def driven(amplitude: float, **fields: object) -> pp.Scene:
    """The damped driven pendulum x'' + x'/2 + sin x = amplitude cos(2 t/3), in seconds of the small swing."""
    effects = [
        fx.Gravity(acceleration=1.0),
        fx.Viscous(coefficient=0.5),
        fx.Motor(joint="theta", amplitude=amplitude, frequency=2 / 3),
    ]
    start = pp.Start(positions={"theta": 0.5})
    return pp.Scene(model=POINT, effects=effects, start=start, duration=30.0, solver=pp.Solver(tolerance=1e-9))


# --- the points -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("direction", [1, -1, 0])
def test_side_by_side_as_one_by_one(direction: int) -> None:
    """Regular motions of one energy: events of Taylor series find the crossings that the search between samples finds."""
    pytest.importorskip("heyoka")
    section = sections.crossing(
        "theta_1", 0.1, direction, of=("theta_2", "theta_2_rate", "theta_1_rate"), count=6, skip=2
    )
    low = sections.portrait(PLANAR, section, 3, -9.0, seed=4)
    assert low.why == ("", "", "")
    for start, points in zip(low.starts, low.values, strict=True):
        np.testing.assert_allclose(section(PLANAR.replace(start=start)), points, atol=1e-7)


def test_a_section_is_that_of_a_run_and_counts_turns_as_nothing() -> None:
    """A rod that turns over rises through 0.3 once in every turn; crossings of a run count its turns."""
    turning = pp.Scene(model=POINT, effects=[GRAVITY], start=pp.Start(velocities={"theta": 9.0}), duration=6.0)
    turning = turning.with_solver(tolerance=1e-11)
    run = pp.simulate(turning)
    points = sections.crossing("theta", 0.3, of="theta", count=4)(run)
    np.testing.assert_allclose(points[:, 0], 0.3 + 2 * np.pi * np.arange(4), atol=1e-9)
    for k in range(4):
        np.testing.assert_allclose(run.crossings("theta", 0.3 + 2 * np.pi * k).q[:, 0], points[k], atol=1e-9)


def test_a_spherical_pendulum_has_closed_curves() -> None:
    """Where phi = 0 energy and vertical angular momentum leave theta' as a function of theta: every point is on it."""
    start = pp.Start(positions={"theta": 1.0, "phi": 0.0}, velocities={"theta": 0.3, "phi": 2.0})
    scene = pp.Scene(model=POINT, effects=[GRAVITY], start=start, duration=5.0, solver=pp.Solver(tolerance=1e-12))
    theta, rate, across = sections.crossing("phi", of=("theta", "theta_rate", "phi_rate"), count=60)(scene).T
    momentum, energy = 2.0 * np.sin(1.0), (0.3**2 + 2.0**2) / 2 - 9.81 * np.cos(1.0)
    np.testing.assert_allclose(np.sin(theta) * across, momentum * np.sign(across * np.sin(theta)), atol=1e-9)
    np.testing.assert_allclose(
        rate**2, 2 * (energy + 9.81 * np.cos(theta)) - (momentum / np.sin(theta)) ** 2, atol=1e-8
    )


def test_the_map_of_a_double_pendulum_keeps_areas() -> None:
    """Hénon: from crossing to crossing at one energy the determinant of d(theta_2, p_2) is 1."""
    from pendpin.dynamics.dynamics import bind

    model = bind(PLANAR)
    energy, moving, level = -8.0, np.array([0, 2]), 0.2

    def mass(q: np.ndarray) -> np.ndarray:
        return mass_matrix(model.model.pin, q)[np.ix_(moving, moving)]

    def mapped(x: np.ndarray, count: int) -> np.ndarray:
        """(theta_2, p_2) after some crossings, from those at a start on the section."""
        q = np.array([level, 0.0, x[0], 0.0])
        M, (_, potential) = mass(q), model.energy(q, np.zeros(4))
        # p_2 = M12 u + M22 w, and u > 0, w have the kinetic energy that is left
        a, c = M[0, 0] - M[0, 1] ** 2 / M[1, 1], x[1] ** 2 / M[1, 1] - 2 * (energy - potential)
        u = np.sqrt(-c / a)
        w = (x[1] - M[0, 1] * u) / M[1, 1]
        start = pp.Start(positions=(level, 0.0, x[0], 0.0), velocities=(u, 0.0, w, 0.0))
        section = sections.crossing("theta_1", level, of=("theta_2", "theta_1_rate", "theta_2_rate"), count=count)
        angle, first, second = section(PLANAR.replace(start=start))[-1]
        M = mass(np.array([level, 0.0, angle, 0.0]))
        return np.array([angle, M[0, 1] * first + M[1, 1] * second])

    x, h = np.array([0.4, 0.3]), 3e-5
    columns = [(mapped(x + h * e, 2) - mapped(x - h * e, 2)) / (2 * h) for e in np.eye(2)]
    assert np.linalg.det(np.array(columns)) == pytest.approx(1.0, abs=1e-6)  # third derivatives times h²: 2e-7


def test_a_strobe_is_the_run_once_a_period() -> None:
    """With the period of the drive, and with one of one's own; a late start of the clock changes nothing."""
    scene = driven(0.9)
    period = 3 * np.pi
    points = sections.strobe(of=("theta", "theta_rate"), count=3, skip=2)(scene)
    run = pp.simulate(scene, duration=5 * period, times=period * np.arange(1, 6))
    np.testing.assert_allclose(points, np.stack([run["theta"], run["theta_rate"]], 1)[2:], atol=1e-9)
    np.testing.assert_array_equal(sections.strobe(period, of="theta", count=3, skip=2)(scene)[:, 0], points[:, 0])


def test_two_sections_of_one_sweep_have_two_names() -> None:
    """The second is a function with a name and dimensions of its own; the same name twice says how to give another."""
    pytest.importorskip("xarray")
    one, other = (sections.crossing("theta_1", 0.0, way, of="theta_2", count=3) for way in (1, -1))

    def falling(run: pp.Trajectory) -> np.ndarray:
        return other(run)

    falling.dims = {"fall": 3, "rate": 1}  # type: ignore[attr-defined]
    vary = {"start.positions.theta_2": [0.1]}
    data = pp.sweep(PLANAR, vary, [one, falling])
    assert data["falling"].dims == ("theta_2", "fall", "rate")
    np.testing.assert_allclose(
        data["falling"].values[0], other(PLANAR.replace({"start.positions.theta_2": 0.1})), atol=1e-7
    )
    with pytest.raises(pp.InputError, match="section is given twice; give one of them as a function of another name"):
        pp.sweep(PLANAR, vary, [one, other])


def test_a_section_is_a_measure_of_a_sweep(tmp_path) -> None:
    """With dimensions of its own, in memory, in a store that is resumed, and in a table; each case as it is alone."""
    pytest.importorskip("zarr")
    section = sections.crossing("theta_1", of=("theta_2", "theta_2_rate"), count=3)
    key, values = "start.positions.theta_2", [0.1, 0.2]
    chosen = PLANAR.with_solver(tolerance=1e-10)
    data = pp.sweep(chosen, {key: values}, ["swing", section], out=tmp_path / "map.zarr")
    assert data["section"].dims == ("theta_2", "crossing", "quantity")
    for i, value in enumerate(values):
        np.testing.assert_allclose(data["section"].values[i], section(chosen.replace({key: value})), atol=1e-7)
    again = pp.sweep(chosen, {key: values}, ["swing", section], out=tmp_path / "map.zarr")
    np.testing.assert_array_equal(again["section"], data["section"])
    other = sections.crossing("theta_1", 0.1, of=("theta_2", "theta_2_rate"), count=3)
    with pytest.raises(pp.InputError, match="it holds another sweep: measure section"):
        pp.sweep(chosen, {key: values}, ["swing", other], out=tmp_path / "map.zarr")
    from pendpin.sweeps.store import write_table

    heads, *rows = write_table(data, tmp_path / "map.csv").read_text().splitlines()
    assert "section[2][1]" in heads
    assert len(rows) == 2


# --- portraits and diagrams -------------------------------------------------------------------------------------------


def test_starts_have_the_energy_and_lie_on_the_section() -> None:
    """Each drawn start: its energy, its angle, the way of its rate; phi stays 0."""
    section = sections.crossing("theta_2", -0.4, -1, of=("theta_1", "theta_1_rate"), count=1)
    drawn = sections.portrait(PLANAR, section, 20, -4.0, seed=1)
    bound = pp.bind(PLANAR)
    for start in drawn.starts:
        q, v = np.array(start.positions), np.array(start.velocities)
        assert sum(bound.energy(q, v)) == pytest.approx(-4.0, abs=1e-12)
        assert q[2] == -0.4
        assert v[2] < 0
        assert not q[[1, 3]].any()
        assert not v[[1, 3]].any()


def test_doublings_of_the_driven_pendulum() -> None:
    """J. R. Taylor, Classical Mechanics (2005), table 12.1: doublings at 1.0663, 1.0793 and 1.0821."""
    strobe = sections.strobe(of="theta", count=40, skip=400)
    at = [1.060, 1.072, 1.0809]
    diagram = sections.bifurcation(driven(1.0), "effects[2].amplitude", at, strobe)
    assert diagram.points(diagram.up).tolist() == [1, 2, 4]
    assert diagram.points(diagram.down).tolist() == [1, 2, 4]
    words = str(diagram.report())
    assert "the same point in every period" in words
    assert "a cycle of 4 points" in words


def turn_back(text: str) -> int:
    """How many points a row of the diagram's table names."""
    return int(text.split()[3]) if text.startswith("a cycle") else {"the": 1, "no": 0}[text.split()[0]]


@settings(max_examples=30)
@given(st.lists(st.integers(0, 6), min_size=1, max_size=9), st.lists(st.integers(0, 6), min_size=1, max_size=9))
def test_a_diagram_is_the_cycles_that_it_was_made_of(up: list[int], down: list[int]) -> None:
    """Any cycles, with whole turns, up and down: its points count them, and its table has them, read row by row."""
    many = min(len(up), len(down))
    rows = np.full((2, many, 13, 2), np.nan)
    for way, counts in enumerate((up[:many], down[:many])):
        for place, count in enumerate(counts):
            if count:  # an angle that goes round beside a number, each of `count` values
                turns = 2 * np.pi * np.arange(13)
                points = np.arange(13) % count
                rows[way, place] = np.stack([points / 7 + turns, 100.0 * points], -1)
    at = np.arange(many) / 2
    section = sections.strobe(1.0, of=("theta", "theta_rate"), count=13)
    units = {"theta": "rad", "theta_rate": "rad/s", "key": ""}
    diagram = sections.Bifurcation("key", at, section, rows[0], rows[1], (), units)
    for way, values, counts in (("up", diagram.up, up), ("down", diagram.down, down)):
        assert diagram.points(values).tolist() == counts[:many]
        order = slice(None, None, 1 if way == "up" else -1)
        changes = [(float(x), turn_back(text)) for row, x, text in diagram.report().tables[0].rows if row == way]
        assert all(one[1] != other[1] for one, other in pairwise(changes))
        read, (first, *_) = dict(changes), at[order]
        assert changes[0][0] == first
        now = 0
        assert [now := read.get(float(x), now) for x in at[order]] == counts[:many][order]


# --- the commands, and what is refused --------------------------------------------------------------------------------


def test_the_commands(tmp_path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture) -> None:
    """A portrait and a diagram from the command line, with their pictures; wrong usage is one line."""
    monkeypatch.chdir(tmp_path)
    PLANAR.save("double.toml")
    driven(1.06).save("driven.toml")
    several = ("--starts", "3", "--energy", "-8", "--count", "5", "--plot", "section.png")
    assert (
        run_main("section", "double.toml", "--at", "theta_1 = 0, rising", "--of", "theta_2,theta_2_rate", *several) == 0
    )
    assert "3 of 3 motions have 5 points each" in capsys.readouterr().out
    over = ("--vary", "effects[2].amplitude=1.06:1.07:2", "--count", "10", "--skip", "20", "--plot", "diagram.png")
    assert run_main("bifurcation", "driven.toml", "--of", "theta", *over) == 0
    assert "up" in capsys.readouterr().out
    for picture in ("section.png", "diagram.png"):
        assert (tmp_path / picture).read_bytes().startswith(b"\x89PNG")
    never = ("--count", "1", "--plot", "never.png", "--set", "duration=0.1")
    assert run_main("section", "double.toml", "--at", "theta_1 = 2.9", "--of", "theta_2,phi_1", *never) == 1
    assert "no motion has all its points" in capsys.readouterr().err
    assert not (tmp_path / "never.png").exists()
    assert run_main("section", "double.toml", "--at", "theta_1 at 0", "--of", "theta_2") == 2
    assert "is not NAME = LEVEL, rising" in capsys.readouterr().err
    assert run_main("section", "double.toml", "--at", "theta_9 = 0", "--of", "theta_2") == 1
    assert "did you mean 'theta_2'?" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: sections.crossing("theta_1", np.nan, of="theta_2"), "level: nan is not a finite number"),
        (lambda: sections.crossing("theta_1", 0.0, 2, of="theta_2"), "direction: 2 is not 1"),
        (lambda: sections.crossing("theta_1", "a", of="theta_2"), "level: 'a' is not a finite"),  # type: ignore[arg-type]
        (lambda: sections.crossing("theta_1", True, of="theta_2"), "level: True is not a finite number"),
        (lambda: sections.crossing("theta_1", 0.0, "up", of="theta_2"), "direction: 'up' is not"),  # type: ignore[arg-type]
        (lambda: sections.crossing("theta_1", 0.0, [1], of="theta_2"), r"direction: \[1\] is not"),  # type: ignore[arg-type]
        (lambda: sections.crossing("theta_1", 0.0, np.nan, of="theta_2"), "direction: nan"),  # type: ignore[arg-type]
        (lambda: sections.crossing("theta_1", of=()), "are not names of quantities"),
        (lambda: sections.crossing("theta_1", of=(3,)), "are not names of quantities"),  # type: ignore[arg-type]
        (lambda: sections.strobe(of=("theta_1", 3)), "are not names of quantities"),  # type: ignore[arg-type]
        (lambda: sections.crossing("theta_1", of="theta_2", count=0), "count: 0 is not a whole number from 1"),
        (lambda: sections.crossing("theta_1", of="theta_2", count=True), "count: True is not a whole number"),
        (lambda: sections.crossing("theta_1", of="theta_2", skip=-1), "skip: -1 is not a whole number from 0"),
        (lambda: sections.crossing(3, of="theta_2"), "name: 3 is not the name of a quantity"),  # type: ignore[arg-type]
        (lambda: sections.strobe(0.0, of="theta_1"), "period: 0.0 is not a number of seconds above 0"),
        (lambda: sections.strobe(np.inf, of="theta_1"), "period: inf is not"),
        (lambda: sections.strobe("2", of="theta_1"), "period: '2' is not"),  # type: ignore[arg-type]
        (
            lambda: sections.strobe(1e-20, of="theta")(driven(1.0).replace({"start.time": 5.0})),
            "does not come after 5 s",
        ),
        (lambda: sections.strobe(1e300, of="theta")(driven(1.0)), r"times\[0\]: .* is above 1e\+150"),
        (lambda: sections.strobe(of="theta_1")(PLANAR), "strobe: nothing drives this scene"),
        (lambda: sections.crossing("theta_1", of="theta_3")(PLANAR), "'theta_3' is not a quantity"),
        (lambda: sections.crossing("tehta_1", of="theta_2")(PLANAR), "did you mean 'theta_1'"),
        (lambda: sections.crossing("theta_1", of="theta_2")(PLANAR.replace(duration=0.0)), "a motion of 0 s"),
        (lambda: sections.crossing("theta_1", of="tips")(PLANAR), "'tips' is not a quantity"),
        (lambda: ON_THETA(None), "scene: None is not a Scene"),  # type: ignore[arg-type]
        (lambda: ON_THETA("nowhere.toml"), "nowhere.toml: cannot be read"),
        (lambda: sections.portrait(PLANAR, None), "section: None is not a pp.sections.crossing"),  # type: ignore[arg-type]
        (lambda: sections.portrait(PLANAR, sections.strobe(of="theta_1")), "section: Strobe"),  # type: ignore[arg-type]
        (lambda: sections.portrait(PLANAR, ON_THETA, 2, -5.0, seed=-1), "seed: -1 is not a whole number from 0"),
        (lambda: sections.portrait(PLANAR, ON_THETA, 2, -5.0, "a"), "seed: 'a' is not"),  # type: ignore[arg-type]
        (lambda: sections.portrait(PLANAR, ON_THETA, 2, "-5"), "energy: '-5' is not"),  # type: ignore[arg-type]
        (lambda: sections.portrait(PLANAR, ON_THETA, 2, 1e300), "is above 1e\\+150"),
        (lambda: sections.portrait(PLANAR, ON_THETA).plot(ax=3), "ax: 3 is not a matplotlib Axes"),
        (lambda: sections.portrait(PLANAR, ON_THETA, 0), "starts: 0 is not a whole number"),
        (lambda: sections.portrait(PLANAR, ON_THETA, 2), "energy: 2 starts are drawn at one energy"),
        (lambda: sections.portrait(PLANAR, ON_THETA, 2, np.inf), "energy: inf is not a finite number"),
        (lambda: sections.portrait(PLANAR, ON_THETA, 2, -1e3), "energy: -1000 J is too little"),
        (lambda: sections.portrait(driven(1.0), ON_ONE, 2, 1.0), "effects of this scene have no potential energy"),
        (lambda: sections.portrait(PLANAR, sections.crossing("phi_1", of="phi_2"), 2, 1.0), "phi_1 stays at 0"),
        (
            lambda: sections.portrait(PLANAR, sections.crossing("energy", of="phi_2"), 2, 1.0),
            "not the angle of a joint",
        ),
        (lambda: sections.bifurcation(driven(1.0), "effects[2].amplitude", [2, 1], ON_ONE), "in rising order"),
        (lambda: sections.bifurcation(driven(1.0), "effects[2].amplitude", [], ON_ONE), "in rising order"),
        (lambda: sections.bifurcation(driven(1.0), "duration", [0, 1], ON_ONE), "a motion of 0 s has no section"),
        (lambda: sections.bifurcation(driven(1.0), None, [1], ON_ONE), "None is not a key path"),  # type: ignore[arg-type]
        (lambda: sections.bifurcation(driven(1.0), "effects[2].amplitude", [1, np.nan], ON_ONE), "nan is not a finite"),
        (lambda: sections.bifurcation(driven(1.0), "effects[2].amplitude", "a", ON_ONE), "values: 'a' are not numbers"),
        (lambda: sections.bifurcation(driven(1.0), "effects[2].amplitude", [1], "theta"), "section: 'theta' is not"),  # type: ignore[arg-type]
        (lambda: sections.bifurcation(driven(1.0), "effects[5].amplitude", [1], ON_ONE), r"effects\[5\]"),
        (lambda: sections.bifurcation(driven(1.0), "effects[1].coefficient", [-1], ON_ONE), "coefficient"),
    ],
)
def test_what_cannot_be_is_refused(make, said: str) -> None:
    with pytest.raises(pp.InputError, match=said):
        make()


ON_THETA = sections.crossing("theta_1", of=("theta_2", "theta_2_rate"), count=2)
ON_ONE = sections.crossing("theta", of="theta_rate", count=2)


def test_a_section_that_is_never_reached_says_so() -> None:
    """A rod at rest crosses nothing, one that turns never falls: how long was waited, and whether it is at rest."""
    still = PLANAR.replace(start=pp.Start(), duration=0.5)
    waited = r"theta_1 rises through 1: 0 of 1 points, none in the last .* s"
    with pytest.raises(pp.RunError, match=waited + "; the motion has come to rest$"):
        sections.crossing("theta_1", 1.0, of="theta_2", count=1)(still)
    held = PLANAR.replace(effects=[GRAVITY, fx.DryFriction(kinetic=40.0, static=90.0)])
    with pytest.raises(pp.RunError, match=waited + "; the motion has come to rest$"):
        sections.crossing("theta_1", 1.0, of="theta_2", count=1)(held)
    turning = pp.Scene(model=POINT, effects=[GRAVITY], start=pp.Start(velocities={"theta": 9.0}), duration=1.0)
    with pytest.raises(pp.RunError, match=r"theta falls through 0: 0 of 1 points, none in the last .* s$"):
        sections.crossing("theta", 0.0, -1, of="theta", count=1)(turning)

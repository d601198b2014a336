"""What happens near a motion: periodic orbits, their continuation, Lyapunov exponents."""

import math

import mpmath as mp
import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

import pendpin as pp
from laws import law
from pendpin import effects as fx
from pendpin.ground.files import folder_of
from pendpin.motions.variations import Variations
from pendpin.stability.linearize import stability
from pendpin.verification.hardcases.base import inertia_about_joint

pytest.importorskip("llvmlite", reason="llvmlite is not installed: pip install llvmlite")

G = fx.Gravity(acceleration=9.81)
ROD = pp.Rod(length=1.0, mass=1.0, radius=0.05)
POINT = pp.Rod(length=0.2, mass=1.0, com=0.2, inertia=(0, 0, 0))
TWO = pp.Chain(rods=[ROD, pp.Rod(length=0.7, mass=0.4, radius=0.02)])
SERIES = 50  # terms: those of the solution fall faster than (pi/4 / log n)^n, to 1e-34


def scene(*effects: fx.Effect, q=(0.6, 0.3, -0.4, 0.2), model=TWO, duration=2.0, **solver) -> pp.Scene:
    start = pp.Start(positions=list(q))
    return pp.Scene(
        model=model,
        start=start,
        duration=duration,
        effects=[G, *effects],
        solver=pp.Solver(**({"samples": 21} | solver)),
    )


# --- periodic orbits ------------------------------------------------------------------------------------------------


def kapitza(amplitude: float) -> pp.Scene:
    """A point mass on 0.2 m, upright, its support shaken upwards and downwards at 300 rad/s."""
    support = fx.Support(amplitude=(0, 0, amplitude), frequency=300.0)
    return scene(support, q=(math.pi, 0.0), model=pp.Chain(rods=[POINT]), duration=1.0)


def test_kapitzas_bounds() -> None:
    """Both ends of the range in which the upright pendulum is stable, to the ten digits of Mathieu's equation."""
    branch = pp.follow(pp.periodic_orbit(kapitza(0.004)), "effects[1].amplitude[2]", 0.1)
    np.testing.assert_allclose(branch.changes, [0.0066046038, 0.0909876411], rtol=0, atol=1e-9)
    assert list(branch.stable[[0, -1]]) == [False, False]
    assert [change.kind for change in branch.bifurcations] == ["symmetry breaking", "period doubling"]


def test_a_hanging_rod_in_a_plane_has_its_period() -> None:
    """4 K(sin(theta/2)) / omega for a rod let go at 1 rad: a family of orbits, of which the nearest is taken."""
    from scipy.special import ellipk

    orbit = pp.periodic_orbit(scene(q=(1.0, 0.0), model=pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0)]), duration=10.0))
    amplitude = np.abs(orbit.orbit["theta"]).max()
    omega = math.sqrt(9.81 * 1.5)
    assert orbit.period == pytest.approx(4 * ellipk(math.sin(amplitude / 2) ** 2) / omega, rel=2e-6)  # of the samples
    assert orbit.miss < 1e-11


def test_multipliers_of_a_damped_rest() -> None:
    """Of x'' + c x' + k x = 0 they are exp(s T), with s the roots of s^2 + c s + k."""
    inertia = ROD.mass * (3 * 0.05**2 + 1) / 12 + 0.25
    motor = fx.Motor(joint="theta_1", amplitude=0.0, frequency=3.0)
    chosen = scene(fx.Viscous(coefficient=0.4), motor, q=(0.0, 0.0), model=pp.Chain(rods=[ROD]), duration=3.0)
    found = pp.periodic_orbit(chosen, period=2 * math.pi / 3.0)
    c, k = 0.4 / inertia, 9.81 * 0.5 / inertia
    root = np.exp(complex(-c / 2, math.sqrt(k - c**2 / 4)) * 2 * math.pi / 3)
    assert np.abs(np.abs(found.multipliers) - abs(root)).max() < 1e-11
    assert np.abs(np.abs(found.multipliers.imag) - abs(root.imag)).max() < 1e-11
    assert found.stable


def by_series(damping: mp.mpf, constant: mp.mpf, wave: mp.mpf) -> tuple[complex, complex]:
    """The multipliers of x'' + damping x' + (constant + wave sin t) x = 0 over 2 pi, from Taylor series in eight parts."""
    h, ends = mp.pi / 4, [[mp.mpf(1), mp.mpf(0)], [mp.mpf(0), mp.mpf(1)]]
    for part in range(8):
        sines = [mp.sin(part * h + k * mp.pi / 2) / mp.factorial(k) for k in range(SERIES)]
        for x in ends:
            for n in range(SERIES - 2):
                forced = sum(sines[k] * x[n - k] for k in range(n + 1))
                x.append(-(damping * (n + 1) * x[n + 1] + constant * x[n] + wave * forced) / ((n + 1) * (n + 2)))
            x[:] = mp.polyval(x[::-1], h), mp.polyval([n * x[n] for n in range(SERIES - 1, 0, -1)], h)
    half, product = (ends[0][0] + ends[1][1]) / 2, mp.exp(-2 * mp.pi * damping)
    root = mp.sqrt(half**2 - product)
    return complex(half + root), complex(half - root)


@pytest.mark.parametrize(
    ("angle", "amplitude", "stable"), [(0.0, 0.03, True), (0.0, 0.3, False), (math.pi, 0.06, True)]
)
def test_a_damped_rod_on_a_shaken_support_is_mathieus(angle: float, amplitude: float, stable: bool) -> None:
    """Hanging or upright: the multipliers of Mathieu's equation with damping, in 30 digits; each in both directions."""
    rod, c, frequency = pp.Rod(length=0.4, mass=0.5, radius=0.03), 0.002, 40.0
    support = fx.Support(amplitude=(0, 0, amplitude), frequency=frequency)
    found = pp.periodic_orbit(scene(fx.Viscous(coefficient=c), support, q=(angle, 0.0), model=pp.Chain(rods=[rod])))
    with mp.workdps(40):
        inertia = mp.mpf(0.5) * (3 * mp.mpf(0.03) ** 2 + 4 * mp.mpf(0.4) ** 2) / 12
        lever = round(math.cos(angle)) * mp.mpf(0.5) * mp.mpf(0.4) / 2 / inertia
        known = by_series(mp.mpf(c) / inertia / 40, lever * mp.mpf(9.81) / 1600, -lever * mp.mpf(amplitude))
    size = max(map(abs, known))
    for value in known:
        assert np.sort(np.abs(found.multipliers - value))[1] < 1e-11 * size
    assert found.stable == stable


def test_a_branch_of_rests_ends_at_the_same_rest() -> None:
    """An upright rod on a shaken support stays upright from the first value to the last, which is the one asked for."""
    rod, support = pp.Rod(length=0.4, mass=0.5, radius=0.03), fx.Support(amplitude=(0, 0, 0.06), frequency=40.0)
    upright = scene(fx.Viscous(coefficient=0.002), support, q=(math.pi, 0.0), model=pp.Chain(rods=[rod]))
    branch = pp.follow(pp.periodic_orbit(upright), "effects[2].amplitude[2]", 0.0605)
    assert branch.values[-1] == 0.0605
    assert np.abs([orbit.orbit.q[0] - (math.pi, 0.0) for orbit in branch.orbits]).max() < 1e-12


def test_a_rest_that_is_not_its_mirror_image_doubles_its_period() -> None:
    """A rod on a spring, its support shaken along it, swings once in two shakes where a multiplier of Mathieu is -1."""
    rod, angle, frequency, c, shift = pp.Rod(length=0.4, mass=0.5, radius=0.03), 0.6, 18.0, 0.002, 0.03
    inertia, stiffness = inertia_about_joint(rod), 1.6702132878
    with mp.workdps(40):
        known = c / frequency / inertia, stiffness / frequency**2 / inertia, 0.5 * 0.2 * shift / inertia
        assert min(abs(x + 1) for x in by_series(*map(mp.mpf, known))) < 1e-9
    hinges = fx.Spring(stiffness=stiffness, rest=angle, joints=("theta",)), fx.Spring(stiffness=4.0, joints=("phi",))
    along = fx.Support(amplitude=(0.0, -shift * math.sin(angle), -shift * math.cos(angle)), frequency=frequency)
    resting = pp.Scene(model=pp.Chain(rods=[rod]), effects=(*hinges, fx.Viscous(coefficient=c), along), duration=1.0)
    once = pp.periodic_orbit(resting.replace(start=pp.Start(positions=(angle, 0.0))))
    assert np.abs(once.multipliers + 1).min() < 1e-8
    for orbit in pp.follow(once, "effects[0].stiffness", 1.0001 * stiffness, onto="doubled").orbits:
        assert orbit.period == pytest.approx(2 * once.period, rel=1e-14)
        assert abs(orbit.orbit.q[0, 0] - angle) > 1e-4


@pytest.mark.slow
def test_a_driven_swing_folds() -> None:
    """A damped pendulum near resonance: the branch turns back at a fold, where a multiplier is 1 and stability ends."""
    rod = pp.Rod(length=1.0, mass=1.0, com=1.0, inertia=(0, 0, 0))
    drive = fx.Motor(joint="theta", amplitude=0.6, frequency=2.85)
    chosen = scene(fx.Viscous(coefficient=0.1), drive, q=(0.0, 0.0), model=pp.Chain(rods=[rod]), duration=3.0)
    branch = pp.follow(pp.periodic_orbit(chosen), "effects[2].frequency", 3.2)
    assert len(branch.folds) >= 1
    assert np.abs(branch.changes[0] - branch.folds[0]) < 1e-6
    assert branch.bifurcations[0].kind == "fold"
    for orbit in branch.orbits[:: max(1, len(branch.orbits) // 5)]:
        assert orbit.orbit.q[-1] == pytest.approx(orbit.orbit.q[0], abs=1e-8)


@pytest.mark.parametrize(
    ("frequency", "begin", "amplitude", "to"),
    [
        pytest.param(0.5, 0.0, 0.77, 0.82, marks=pytest.mark.slow),
        pytest.param(0.8, 0.0, 1.25, 1.36, marks=pytest.mark.slow),
        (0.8, 1.3, 1.25, 1.36),
    ],
)
def test_a_symmetry_breaking_is_that_of_half_a_period(
    frequency: float, begin: float, amplitude: float, to: float
) -> None:
    """x'' + x'/2 + sin x = a sin(w t) by SciPy: after half a period the orbit found is its mirror image, a change is not.

    At the value found, one change of the start comes back as it was. The multipliers' product is exp(-T/2): no torus.
    """
    from scipy.integrate import solve_ivp

    drive = fx.Motor(joint="theta", amplitude=amplitude, frequency=frequency)
    point = pp.Chain(rods=[pp.Rod(length=1.0, mass=0.0, payload=1.0, joint="hinge")])
    effects = fx.Gravity(acceleration=1.0), fx.Viscous(coefficient=0.5), drive
    start = pp.Start(time=begin, positions=[-2.5], velocities=[0.2])
    driven, key = pp.Scene(model=point, effects=effects, start=start, duration=9.0), "effects[2].amplitude"
    (change,) = pp.follow(pp.periodic_orbit(driven), key, to).bifurcations
    assert change.kind == "symmetry breaking"

    def rates(t: float, y: np.ndarray) -> np.ndarray:
        x, v, *w = y  # and its two changes, (x, x, v, v)
        slopes = -np.cos(x) * np.array(w[:2]) - np.array(w[2:]) / 2
        return np.array([v, change.value * np.sin(frequency * t) - np.sin(x) - v / 2, *w[2:], *slopes])

    y = np.append(change.orbit.scene.start.positions, change.orbit.scene.start.velocities)
    first, half = np.concatenate([y, np.eye(2).ravel()]), (begin, begin + math.pi / frequency)
    end = solve_ivp(rates, half, first, "DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
    assert np.abs(np.append(np.sin(end[0] + y[0]), end[1] + y[1])).max() < 1e-9
    transition = end[2:].reshape(2, 2)
    assert abs(np.linalg.eigvals(transition) - 1).min() < 1e-8
    assert np.prod(change.orbit.multipliers) == pytest.approx(math.exp(-math.pi / frequency), abs=1e-10)
    lopsided = pp.follow(change.orbit, key, change.value + 1e-3, onto="asymmetric")
    for orbit in lopsided.orbits:
        begins, run = orbit.scene.start, pp.simulate(orbit.scene, times=[begin + math.pi / frequency])
        assert abs(np.sin((run.q[0] + begins.positions) / 2)).max() > 1e-3


@pytest.mark.slow
def test_a_driven_pendulum_doubles_its_period_again_and_again() -> None:
    """x'' + x'/2 + sin x = a cos(2 t/3): its swing loses its mirror image, then its period doubles at 1.0663, 1.0793, ...

    The doublings are those of J. R. Taylor, Classical Mechanics (2005), table 12.1, to its last digit.
    """
    effects = (fx.Viscous(coefficient=0.5), fx.Motor(joint="theta", amplitude=0.9, frequency=2 / 3))
    point = pp.Chain(rods=[pp.Rod(length=1.0, mass=0.0, payload=1.0)])
    key, period = "effects[2].amplitude", 3 * math.pi
    driven = pp.Scene(model=point, effects=(fx.Gravity(acceleration=1.0), *effects), duration=30.0)
    driven = driven.replace(start=pp.Start(positions=(-2.452151, 0.0), velocities=(-0.281156, 0.0)))
    (broken,) = pp.follow(pp.periodic_orbit(driven), key, 1.03).bifurcations
    assert broken.kind == "symmetry breaking"
    lopsided = pp.follow(broken.orbit, key, 1.03, onto="asymmetric")
    for each, value in list(zip(lopsided.orbits, lopsided.values, strict=True))[::6]:
        begin, run = each.scene.start, pp.simulate(each.scene, times=[period / 2, period], tolerance=1e-12)
        mirrored = np.append(np.sin(run.q[0] + begin.positions), run.v[0] + begin.velocities)
        assert np.abs(mirrored).max() == pytest.approx(4.0 * math.sqrt(value - broken.value), rel=0.05)  # a pitchfork
        assert np.abs(np.sin(run.q[1] - begin.positions)).max() < 1e-9
    assert lopsided.stable.all()
    driven = driven.replace({key: 1.06}, start=pp.Start(positions=(-1.859796, 0.0), velocities=(-0.839234, 0.0)))
    once = pp.follow(pp.periodic_orbit(driven), key, 1.07)
    twice = pp.follow(once.bifurcations[0].orbit, key, 1.0815, onto="doubled")
    for branch, at, turns in ((once, 1.0663, 1), (twice, 1.0793, 2)):
        (change,) = branch.bifurcations
        assert change.kind == "period doubling"
        assert abs(change.value - at) < 1e-4
        assert change.orbit.period == pytest.approx(turns * period, rel=1e-14)
        assert np.abs(change.orbit.multipliers + 1).min() < 1e-6
    with pytest.raises(pp.InputError, match="onto: this orbit is not at a period doubling"):
        pp.follow(broken.orbit, key, 1.03, onto="doubled")
    with pytest.raises(
        pp.InputError, match="onto: this orbit is not at a symmetry breaking: its multiplier next to 1 is"
    ):
        pp.follow(once.bifurcations[0].orbit, key, 1.1, onto="asymmetric")
    with pytest.raises(pp.InputError, match="onto: 'halved' is not one of: doubled"):
        pp.follow(broken.orbit, key, 1.03, onto="halved")  # type: ignore[arg-type]


def test_a_given_period_stays() -> None:
    """With two frequencies, of which each is a multiple of one; no period follows from one of them."""
    drives = (fx.Motor(joint=joint, amplitude=0.3, frequency=f) for joint, f in (("theta", 2.0), ("phi", 4.0)))
    driven = scene(fx.Viscous(coefficient=0.4), *drives, q=(0.0, 0.0), model=pp.Chain(rods=[ROD]), duration=3.0)
    orbit = pp.periodic_orbit(driven, period=math.pi)
    branch = pp.follow(orbit, "effects[2].amplitude", 0.31)
    assert {each.period for each in branch.orbits} == {math.pi}
    assert max(each.miss for each in branch.orbits) < 1e-11
    with pytest.raises(pp.InputError, match="other frequencies"):
        pp.follow(orbit, "effects[2].frequency", 3.0)


def test_a_given_period_is_a_whole_multiple_of_that_of_each_drive() -> None:
    """With frequencies 2 and 3 the period is 2 pi, or n times that with the same orbit, its multipliers to the power n."""
    drives = (fx.Motor(joint=joint, amplitude=0.3, frequency=f) for joint, f in (("theta", 2.0), ("phi", 3.0)))
    driven = scene(fx.Viscous(coefficient=0.1), *drives, q=(0.0, 0.0), model=pp.Chain(rods=[ROD]))
    once, twice = (pp.periodic_orbit(driven, period=n * 2 * math.pi) for n in (1, 2))
    np.testing.assert_allclose(
        np.sort_complex(twice.multipliers), np.sort_complex(once.multipliers**2), rtol=0, atol=1e-10
    )  # each transition is off by 1e-11 of its size, and a period magnifies what the orbits differ by
    assert pp.periodic_orbit(driven, period=6.28319).stable == once.stable  # as it is printed
    for period, place in ((math.pi, "3"), (2 * math.pi / 3, "2"), (1.234, "2"), (6.282, "2"), (1e-6, "2")):
        with pytest.raises(
            pp.InputError, match=rf"not a whole multiple of that of effects\[{place}\] \(motor\), [23]\."
        ):
            pp.periodic_orbit(driven, period=period)


def test_a_table_that_ends_before_the_period_ends_the_orbit_as_it_ends_a_run(tmp_path) -> None:
    """One line says that the times of a file do not cover the run, whoever asks; a table that lasts has its orbit."""
    file, times = tmp_path / "rates.csv", np.linspace(0.0, 10.0, 201)
    file.write_text("".join(f"{t:.17g},{0.1 * np.sin(2 * np.pi * t / 5):.17g}\n" for t in times))
    slewed = scene(fx.Viscous(coefficient=0.2), fx.Rotation(csv=file, axis=(0, 0, 1)), model=TWO, duration=5.0)
    said = set[str]()
    for ask in (
        lambda: pp.periodic_orbit(slewed, period=40.0),
        lambda: stability(slewed, period=40.0),
        lambda: pp.simulate(slewed.replace(duration=40.0)),
    ):
        with pytest.raises(
            pp.InputError, match=r"rates\.csv: its times, 0 to 10 s, do not cover the run, 0 to 40 s"
        ) as no:
            ask()
        said.add(str(no.value))
    assert len(said) == 1
    assert pp.periodic_orbit(slewed, period=5.0).miss < 1e-11


@pytest.mark.parametrize("given", [False, True])
def test_only_a_found_period_is_free(given: bool) -> None:
    """A rod in a plane has the period 4 K(sin(theta/2)) / omega: in a stronger field a given one needs a longer swing."""
    from scipy.special import ellipk

    thin = scene(q=(1.0, 0.0), model=pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0)]), duration=3.0)
    orbit = pp.periodic_orbit(thin, period=1.8 if given else None)
    last = pp.follow(orbit, "effects[0].acceleration", 9.9).orbits[-1]
    assert (last.period == 1.8) == given
    theta, rate, square = last.scene.start.positions[0], last.scene.start.velocities[0], 9.9 * 1.5
    modulus = (1 - math.cos(theta) + rate**2 / (2 * square)) / 2  # sin(theta/2)² at the turning point, from the energy
    assert last.period == pytest.approx(4 * ellipk(modulus) / math.sqrt(square), rel=1e-10)


# --- Lyapunov exponents ---------------------------------------------------------------------------------------------


def test_a_rest_upright_grows_at_its_own_rate() -> None:
    """Exponents of an upright rod are the real parts of the eigenvalues: +-sqrt(m g h / J), each twice."""
    inertia = ROD.mass * (3 * 0.05**2 + 1) / 12 + 0.25
    found = pp.lyapunov(scene(q=(math.pi, 0.0), model=pp.Chain(rods=[ROD])), duration=3.0)
    rate = math.sqrt(9.81 * 0.5 / inertia)
    assert found.exponents == pytest.approx([rate, rate, -rate, -rate], rel=0.1)  # what they start from fades slowly
    assert abs(found.exponents.sum()) < 1e-9


@example(c=0.02)
@law(2)
@given(c=st.floats(0.01, 0.3))
def test_the_sum_is_the_mean_divergence(c: float) -> None:
    """The trace of the Jacobian, summed along the same motion by Simpson's rule."""
    chosen = scene(fx.Viscous(coefficient=c), q=(1.0, 0.1, 0.5, -0.2), duration=3.0, samples=1001, tolerance=1e-12)
    found, run = pp.lyapunov(chosen), pp.simulate(chosen)
    equations, size = Variations(chosen, []).equations, 8
    states = np.concatenate([run.q, run.v], 1)
    ways = [np.tile(way, (len(run.t), 1, 1)) for way in np.eye(size)[4:]]
    traces = sum(equations.rates(run.t, states, way)[1][:, 0, 4 + k] for k, way in enumerate(ways))
    from scipy.integrate import simpson

    assert found.exponents.sum() == pytest.approx(simpson(traces, x=run.t) / 3.0, abs=1e-6)


def test_a_regular_motion_has_exponents_within_their_errors_of_0() -> None:
    """One rod in a plane; by Liouville's theorem they come in pairs too."""
    found = pp.lyapunov(scene(q=(1.5, 0.0), model=pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0)])), duration=100.0)
    assert (np.abs(found.exponents) <= found.error + np.log(100.0) / 100.0).all()
    assert found.exponents == pytest.approx(-found.exponents[::-1], abs=1e-6)
    assert found.history.shape == (len(found.t), 4)


def test_the_spectrum_of_a_plane_is_that_of_its_block() -> None:
    """The state's transition maps the plane to itself; its block there is Q R, with the growth on the diagonal of R."""
    chosen = scene(q=(2.0, 0.0, 1.0, 0.0), duration=2.0, tolerance=1e-12)
    found, whole = pp.lyapunov(chosen, planar=True), pp.simulate(chosen).state_transition(0.0, 2.0)
    plane, across = [0, 2, 4, 6], [1, 3, 5, 7]
    assert not whole[np.ix_(plane, across)].any()
    growth = np.log(np.abs(np.diag(np.linalg.qr(whole[np.ix_(plane, plane)])[1]))) / 2.0
    assert found.exponents == pytest.approx(np.sort(growth)[::-1], abs=1e-8)


@pytest.mark.parametrize("axis", ["x", "y"])
def test_rods_on_hinges_of_one_axis_are_in_a_plane(axis: str) -> None:
    """They have no joint across it: the exponents of the plane are all of them."""
    hinge = {"joint": "hinge", "axis": axis}
    two = pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0, **hinge), pp.Rod(length=0.7, mass=0.4, **hinge)])
    chosen = scene(q=(1.0, 0.5), model=two)
    np.testing.assert_array_equal(pp.lyapunov(chosen, planar=True).exponents, pp.lyapunov(chosen).exponents)


def test_a_planar_robot_is_in_its_plane() -> None:
    """A URDF whose joints turn about one axis has no joint across it either; one about others is refused as before."""
    start = {"model": "double_pendulum", "start": pp.Start(positions=[2.0, 1.0]), "effects": [fx.Gravity()]}
    robot = pp.Scene(duration=2.0, **start)
    np.testing.assert_array_equal(pp.lyapunov(robot, planar=True).exponents, pp.lyapunov(robot).exponents)
    with pytest.raises(pp.InputError, match="planar: every joint moves"):
        pp.lyapunov(pp.Scene(duration=0.1, model="ur5", effects=[fx.Gravity()]), planar=True)


def test_an_orbit_is_found_next_to_a_rod_that_hangs_or_stands() -> None:
    """Where the start leads to none, as the command finds it; a guess of one's own stands alone."""
    kapitza = pp.load_scene(folder_of("examples") / "kapitza.toml")
    orbit = pp.periodic_orbit(kapitza)
    (drive,) = (effect.frequency for effect in kapitza.effects if isinstance(effect, fx.Support))
    assert orbit.period == stability(kapitza).orbit.period == 2 * np.pi / drive
    assert orbit.miss < 1e-9
    with pytest.raises(pp.RunError, match="no periodic motion found near the guess"):
        pp.periodic_orbit(kapitza, kapitza.start)


def test_a_double_pendulum_in_a_plane_has_one_pair_of_exponents_that_is_not_0() -> None:
    """The textbook's (lambda, 0, 0, -lambda), from a start that is chaotic; energy and time give the two zeros.

    Angles and rates are not canonical: volumes change by the mass matrix's determinant, which is nothing over a long time.
    """
    found = pp.lyapunov(scene(q=(2.2, 0.0, 1.0, 0.0)), duration=100.0, planar=True)
    largest, one, other, least = found.exponents
    slack = np.log(100.0) / 100.0
    assert largest > 0.5
    assert abs(largest + least) < slack
    assert abs(one + other) < slack
    assert max(abs(one), abs(other)) < found.error[1:3].max() + slack


@pytest.mark.parametrize("duration", [5.0, 20.0])
def test_a_mass_that_cancels_changes_nothing(duration: float) -> None:
    """One rod under gravity alone moves the same with any mass; what is asked with it is as if asked alone."""
    rod = pp.Rod(length=0.7, mass=2.3, radius=0.03)
    start = pp.Start(positions={"theta": 0.7, "phi": 0.4}, velocities={"theta": 1.0})
    scene = pp.Scene(model=pp.Chain(rods=[rod]), effects=[pp.effects.Gravity()], start=start, duration=duration)
    run, keys = pp.simulate(scene, tolerance=1e-10), ["model.rods[0].mass", "model.rods[0].length"]
    assert np.abs(run.sensitivity(keys[:1])).max() < 1e-12
    both, alone = run.sensitivity(keys), run.sensitivity(keys[1:])
    np.testing.assert_allclose(both[..., 1:], alone, rtol=0, atol=1e-8 * np.abs(alone).max())
    tension = run.sensitivity(keys[:1], "R3")[:, 0]
    np.testing.assert_allclose(tension, run["R3"] / 2.3, rtol=1e-9)


def test_below_resonance_the_doubled_orbits_are_on_the_other_side() -> None:
    """The hanging pendulum softens: shaken slower than twice its frequency it doubles its period at smaller amplitudes."""
    rate = 0.97 * 2 * np.sqrt(9.81 / 0.2)
    rod = pp.Rod(length=0.2, mass=0.0, payload=1.0, joint="hinge")
    shaken = [fx.Gravity(), fx.Viscous(coefficient=0.002), fx.Support(amplitude=(0.0, 0.0, 0.005), frequency=rate)]
    orbit = pp.periodic_orbit(pp.Scene(model=pp.Chain(rods=[rod]), effects=shaken, duration=1.0), guess=[0.0, 0.0])
    key = "effects[2].amplitude[2]"
    (change,) = pp.follow(orbit, key, to=0.008).bifurcations
    with pytest.raises(pp.RunError, match="on the other side there may be some"):
        pp.follow(change.orbit, key, to=0.008, onto="doubled")
    assert len(pp.follow(change.orbit, key, to=0.0055, onto="doubled").orbits) > 1

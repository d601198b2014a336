"""Rotation and support against the same motion computed in the inertial frame (tests/inertial.py), and slewing."""

from pathlib import Path

import numpy as np
import pytest

import pendpin as pp
from effect_cases import FIVE, POINT, ROD
from inertial import point_mass, residual, rigid_rod, rotation, sinusoid
from pendpin import effects as fx
from pendpin.model.bodies import pinocchio
from scenes import scene_of

G = 9.81
STILL, SHAKEN = ((0.0, 0.0, 0.0), 1.0, 0.0), ((0.05, -0.08, 0.1), 7.0, 0.4)
FRAMES = {
    "support": ((0.0, 0.0, 0.0), SHAKEN),
    "rotation about the vertical": ((0.0, 0.0, 2.0), STILL),
    "rotation about any axis": ((0.7, -1.1, 2.0), STILL),
    "both": ((0.7, -1.1, 2.0), SHAKEN),
}
PARAMETERS = pytest.mark.parametrize(("Omega", "support"), FRAMES.values(), ids=FRAMES)
THICK = pp.Rod(length=1.2, mass=0.8, radius=0.2, payload=0.1)
START = {"q": np.array([0.7, 0.4]), "v": np.array([1.3, -0.8])}


def scene(rods: tuple[pp.Rod, ...], Omega: tuple, support: tuple, q, v, duration: float = 3.0) -> pp.Scene:
    """Rods in a world that turns and is shaken; only what is asked for is listed."""
    effects: list[fx.Effect] = [fx.Gravity()]
    if any(Omega):
        effects.append(fx.Rotation(rate=Omega))
    if any(support[0]):
        effects.append(fx.Support(amplitude=support[0], frequency=support[1], phase=support[2]))
    return scene_of(rods, *effects, q=np.ravel(q), v=np.ravel(v), duration=duration, tolerance=1e-13, samples=31)


@PARAMETERS
def test_a_point_mass(Omega: tuple, support: tuple) -> None:
    """Cartesian coordinates in the inertial frame: tips equal to 1e-10 over 3 s."""
    run = pp.simulate(scene((POINT,), Omega, support, **START))
    (theta, phi), (dt, dp) = START["q"], START["v"]
    s_t, c_t, s, c = np.sin(theta), np.cos(theta), np.sin(phi), np.cos(phi)
    r, v = [s, -s_t * c, -c_t * c], [c * dp, s_t * s * dp - c_t * c * dt, c_t * s * dp + s_t * c * dt]
    expected = point_mass(rotation(Omega), sinusoid(*support), 1.0, G, r, v, run.t)
    assert np.abs(run.tips[:, 0] - expected).max() < 1e-10


@pytest.mark.parametrize(
    ("rod", "frame"),
    [
        *((ROD, "both"), (THICK, "support")),
        *(pytest.param(THICK, frame, marks=pytest.mark.slow) for frame in ("both", "rotation about any axis")),
    ],
)
def test_a_rigid_rod(rod: pp.Rod, frame: str) -> None:
    """d'Alembert's principle in the inertial frame, integrated by SciPy: angles equal to 1e-10 over 1 s."""
    Omega, support = FRAMES[frame]
    run = pp.simulate(scene((rod,), Omega, support, **START, duration=1.0))
    expected = rigid_rod(rotation(Omega), sinusoid(*support), rod.properties, G, *START.values(), run.t)
    assert np.abs(run.q - expected).max() < 1e-10


@pytest.mark.parametrize("engine", ["pinocchio", "chain"])
@PARAMETERS
def test_a_chain_of_rigid_rods(Omega: tuple, support: tuple, engine: str) -> None:
    """d'Alembert's principle in the inertial frame at 60 digits: the accelerations of five rods right to 1e-12."""
    random = np.random.default_rng(5)
    q, v, t = random.uniform(-1.2, 1.2, 10), random.uniform(-3, 3, 10), 0.83
    dynamics = pp.bind(scene(FIVE, Omega, support, q, v).model_copy(update={"solver": pp.Solver(engine=engine)}))
    a = dynamics.acceleration(t, q, v)
    rods = [(*rod.properties, rod.length) for rod in FIVE]
    given = (x.reshape(-1, 2) for x in (q, v, a))
    left, sizes = residual(rotation(Omega), sinusoid(*support), rods, G, t, *given)
    assert np.abs(left).max() < 1e-13 * sizes.max()
    pin = pinocchio()
    M = np.triu(pin.crba(dynamics.model.pin, dynamics.model.pin.createData(), q))
    assert np.abs(np.linalg.solve(M + np.triu(M, 1).T, left)).max() < 1e-12 * np.abs(a).max()


@pytest.mark.parametrize("rods", [1, 3])
def test_a_tracked_rate_at_all_samples_is_that_at_each(rods: int, tmp_path) -> None:
    """Samples are taken all at once, at times (k, 1, 1): accelerations and wrenches are those of each state alone."""
    times = np.linspace(0.0, 3.0, 31)
    lines = [f"{t:.17g},{0.4 + 0.3 * np.sin(2 * t):.17g}" for t in times]
    path = tmp_path / "rate.csv"
    path.write_text("\n".join(["t,rate", *lines]) + "\n")
    turning = fx.Rotation(csv=str(path), axis=(0.1, 0.2, 1.0))
    chain = pp.Chain(rods=(pp.Rod(length=1.0, mass=1.0, radius=0.02),) * rods)
    positions = (0.7, 0.4) + (0.1,) * (2 * rods - 2)
    scene = pp.Scene(model=chain, start=pp.Start(positions=positions), effects=(fx.Gravity(), turning), duration=0.5)
    run, bound = pp.simulate(scene, samples=9), pp.bind(scene)
    states = list(zip(run.t, run.q, run.v, strict=True))
    np.testing.assert_allclose(run.a, [bound.acceleration(*state) for state in states], atol=1e-11)
    np.testing.assert_allclose(run.wrench, [bound.wrenches(*state) for state in states], atol=1e-11)


# --- slewing: a rate from a file ------------------------------------------------------------------------------------


@pytest.mark.parametrize("method", ["dop853", "radau"])
def test_a_world_that_slews_is_a_world_at_rest(method: str, tmp_path: Path) -> None:
    """Thin rods, whose joints feel no twist: the motion in a frame that turns by the integral of the rate, turned back."""
    t = np.linspace(0, 2, 401)
    rows = np.stack([t, 1.2 * np.sin(2 * t) ** 2], 1)
    (tmp_path / "rate.csv").write_text("t,rate\n" + "".join(f"{a!r},{b!r}\n" for a, b in rows.tolist()))
    model = pp.Chain(rods=[pp.Rod(length=0.6, mass=0.5), pp.Rod(length=0.4, mass=0.3, payload=0.2)])
    start = pp.Start(positions={"theta_1": 0.5, "phi_2": 0.3}, velocities={"theta_2": 0.7})
    slews = fx.Rotation(csv=tmp_path / "rate.csv", axis=(0, 0, 2))
    rest, turning = (
        pp.simulate(
            pp.Scene(duration=2.0, model=model, start=start, effects=effects), tolerance=1e-11, method=method, samples=9
        )
        for effects in ([fx.Gravity()], [fx.Gravity(), slews])
    )
    angle = 1.2 * (rest.t / 2 - np.sin(4 * rest.t) / 8)
    s, c = np.sin(angle), np.cos(angle)
    back = np.stack([[c, -s, 0 * s], [s, c, 0 * s], [0 * s, 0 * s, 1 + 0 * s]]).transpose(2, 0, 1)
    assert np.abs(np.einsum("nij,nrj->nri", back, turning.tips) - rest.tips).max() < 1e-8


def test_all_routes_agree_where_the_world_slews(tmp_path: Path) -> None:
    """The check of a run and `pendpin check` take many states at once; a track gives them as one by one."""
    (tmp_path / "rate.csv").write_text("t,rate\n0,0\n1,0.2\n2,0.2\n3,0.1\n")
    slews = fx.Rotation(csv=tmp_path / "rate.csv", axis=(0, 0, 1))
    rods = [pp.Rod(length=0.6, mass=0.5, radius=0.02, copies=2)]
    start = pp.Start(positions={"theta_1": 0.5, "phi_2": 0.3}, velocities={"theta_2": 0.7})
    scene = pp.Scene(duration=2.0, model=pp.Chain(rods=rods), start=start, effects=[fx.Gravity(), slews, fx.Drag()])
    assert not pp.crosscheck(scene, states=20).report().fault


def test_a_rate_that_is_not_a_number_is_refused(tmp_path: Path) -> None:
    """With its line and column."""
    (tmp_path / "rate.csv").write_text("t,rate\n0,0\n1,nan\n2,1\n")
    with pytest.raises(pp.InputError, match=r"rate\.csv: line 3: rate: 'nan' is not a finite number"):
        fx.Rotation(csv=tmp_path / "rate.csv", axis=(0, 0, 1))


def test_a_copy_with_other_fields_moves_by_these(tmp_path: Path) -> None:
    """With another file by that one; the old one is not read again, and a copy with other fields does not miss it."""
    one, other, t = tmp_path / "one.csv", tmp_path / "other.csv", np.linspace(0.0, 3.0, 7)
    one.write_text("0,0,0,0\n1,0.3,0,0\n2,0.1,0,0\n3,0,0,0\n")
    other.write_text("0,0,0,0\n1,0,0.2,0\n2,0,0,0.1\n3,0,0,0\n")
    moved = fx.Support(csv=one)
    np.testing.assert_array_equal(
        moved.model_copy(update={"csv": other}).position(t), fx.Support(csv=other).position(t)
    )
    rate = tmp_path / "rate.csv"
    rate.write_text("0,0\n1,0.2\n2,0.2\n3,0.1\n")
    about_x, about_z = (fx.Rotation(csv=rate, axis=axis) for axis in ((1, 0, 0), (0, 0, 1)))
    assert about_z.track
    expected = about_z.track.at(t)
    rate.unlink()
    turned = about_x.model_copy(update={"axis": (0, 0, 1)}).track
    assert turned
    np.testing.assert_array_equal(turned.at(t), expected)
    constant = about_x.model_copy(update={"csv": None, "axis": None, "rate": (0.0, 0.0, 0.5)})
    np.testing.assert_array_equal(constant.vector, [0.0, 0.0, 0.5])

"""`pendpin stability`: the rests of a scene, its driven motion, its exponents."""

import json
import math

import pytest

from bad_input import AtOnce, run_main
from pendpin.stability.linearize import NEAR_START, OTHER_TURNS, stability
from test_near_motions import ROD, TWO, G, fx, kapitza, pp, scene


def test_a_chain_of_two_has_four_rests() -> None:
    """Each rod hanging or upright; only the one with both hanging is stable."""
    rows = stability(scene()).rows()
    assert len(rows) == 4
    assert [row["stable"] for row in rows].count(True) == 1
    assert all(row["growth"] > 0 for row in rows if not row["stable"])


@pytest.mark.parametrize("strength", [1e-6, 1e4, 1e9])
def test_rests_do_not_depend_on_the_strength_of_gravity(strength: float) -> None:
    """The same four; how fast the others are left goes with its square root."""
    usual, other = (stability(scene().replace({"effects[0].acceleration": g})) for g in (1.0, strength))
    assert len(other.rests) == len(usual.rests) == 4
    for one, rest in zip(usual.rests, other.rests, strict=True):
        assert rest.q == pytest.approx(one.q, abs=1e-9)
    growths = [[row["growth"] for row in found.rows()] for found in (usual, other)]
    assert growths[1] == pytest.approx([math.sqrt(strength) * growth for growth in growths[0]], rel=1e-6, abs=1e-12)


def test_an_upright_rod_falls_at_its_own_rate() -> None:
    """sqrt(m g h / J)."""
    inertia = ROD.mass * (3 * 0.05**2 + 1) / 12 + 0.25
    rows = stability(scene(q=(0.0, 0.0), model=pp.Chain(rods=[ROD]))).rows()
    (upright,) = (row for row in rows if not row["stable"])
    assert upright["growth"] == pytest.approx(math.sqrt(9.81 * 0.5 / inertia), rel=1e-12)


def test_a_spring_moves_the_rests() -> None:
    """J theta'' = 0 where k (theta - rest) = -m g h sin(theta): solved by hand with bisection."""
    from scipy.optimize import brentq

    spring = fx.Spring(stiffness=3.0, rest=0.5, joints=("theta",))
    rows = stability(scene(spring, q=(0.0, 0.0), model=pp.Chain(rods=[ROD]))).rows()
    angle = brentq(lambda x: 3.0 * (x - 0.5) + 9.81 * 0.5 * math.sin(x), 0, 1, xtol=1e-15)
    assert math.radians(rows[0]["degrees"]["theta"]) == pytest.approx(angle, abs=1e-9)


def test_a_list_of_rests_says_where_it_ends() -> None:
    """A weak spring has rests in further turns, a long chain may have others: neither is listed, and a note says so."""
    spring = fx.Spring(stiffness=0.05, rest=0.3, joints=("theta",))
    rod = stability(scene(spring, q=(0.0, 0.0), model=pp.Chain(rods=[ROD])))
    torques = [0.05 * (x - 0.3) + 9.81 * 0.5 * math.sin(x) for x in (6.0, 6.3)]
    assert torques[0] < 0 < torques[1]  # a rest a turn on
    assert all(abs(row["degrees"]["theta"]) < 270 for row in rod.rows())
    chain = stability(scene(q=(0.0,) * 10, model=pp.Chain(rods=[ROD], copies=5)))
    plain = stability(scene(q=(0.0, 0.0), model=pp.Chain(rods=[ROD])))
    assert [found.notes for found in (rod, chain, plain)] == [(OTHER_TURNS,), (NEAR_START,), ()]


def test_slides_are_in_metres(tmp_path) -> None:
    """A trolley on a spring: where it stands is a length, and no angle."""
    path = tmp_path / "trolley.urdf"
    path.write_text(
        '<robot name="t"><link name="base"/><link name="cart"><inertial><mass value="2"/>'
        '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>'
        '<joint name="rail" type="prismatic"><parent link="base"/><child link="cart"/><axis xyz="0 0 -1"/>'
        '<limit lower="-9" upper="9" effort="1" velocity="1"/></joint></robot>'
    )
    hung = pp.Scene(model=pp.UrdfModel(path), effects=(fx.Gravity(), fx.Spring(stiffness=100.0)))
    (row,) = stability(hung).rows()
    assert row["degrees"] == {}
    assert row["m"]["rail"] == pytest.approx(2 * 9.81 / 100, rel=1e-12)


def test_rounding_does_not_swing() -> None:
    """Damping shifts a swing a little, and an overdamped motion has none: the eigenvalues are real but for rounding."""
    rods = pp.Chain(rods=[pp.Rod(length=0.4, mass=0.5, radius=0.015)], copies=4)
    free, damped = (
        stability(scene(*effects, q=(0.0,) * 8, model=rods)).rows() for effects in ([], [fx.Viscous(coefficient=1e-2)])
    )
    for one, other in zip(free, damped, strict=True):
        assert one["degrees"] == pytest.approx(other["degrees"], abs=1e-6)
        assert (one["slowest"] is None) == (other["slowest"] is None)
        assert other["slowest"] is None or other["slowest"] == pytest.approx(one["slowest"], rel=0.05)
        assert all(-180 < angle <= 180 + 1e-6 for angle in other["degrees"].values())


def test_a_shaken_rod_far_from_its_motion_is_reported_upright() -> None:
    """Newton's method does not reach the periodic motion from a start that is still falling towards it."""
    shaken = kapitza(0.01)
    start = pp.Start(time=shaken.start.time, positions={"theta": 2.6, "phi": 0.3})
    found = stability(shaken.replace(start=start))
    assert "theta 180°" in str(found)


def test_the_command(tmp_path, capsys: pytest.CaptureFixture[str]) -> None:
    """JSON of rests, of a driven motion, of exponents; the rests of what has no period."""
    two, shaken, beating = (tmp_path / f"{name}.toml" for name in ("two", "shaken", "beating"))
    scene(duration=1.0).save(two)
    kapitza(0.01).save(shaken)
    scene(*(fx.Motor(joint="theta_1", amplitude=1.0, frequency=f) for f in (1.0, 2.0))).save(beating)
    assert run_main("stability", str(two), "--json") == 0
    assert len(json.loads(capsys.readouterr().out)["rests"]) == 4
    assert run_main("stability", str(shaken), "--json") == 0
    assert json.loads(capsys.readouterr().out)["stable"] is True
    assert run_main("stability", str(two), "--lyapunov", "--json") == 0
    assert len(json.loads(capsys.readouterr().out)["exponents"]) == 2 * 2 * len(TWO.all_rods)
    assert run_main("stability", str(beating)) == 0
    assert "all 0 " in (said := capsys.readouterr().out)
    assert "--period" in said
    assert run_main("stability", str(beating), "--period", "0") == 2
    assert capsys.readouterr().err.startswith("pendpin: Invalid value for --period: 0.0 is not a number of seconds")
    assert G.acceleration == 9.81


@pytest.mark.parametrize(
    ("command", "where", "doing"),
    [
        ("modes", "pendpin.motions.special_starts.Dynamics.acceleration", "looking for the rest near the start"),
        ("modes", "pendpin.motions.periodic.vibrations", "the modes"),
        ("stability", "pendpin.stability.linearize.refuse_poles", "differentiating the motion near a rest"),
    ],
)
def test_a_limit_ends_a_command_and_says_what_it_was_doing(command, where, doing, monkeypatch, capsys) -> None:
    """The clock rings at once, and is heard at the place that is planted: no test waits for a clock."""

    def heard(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("threading.Timer", AtOnce)
    monkeypatch.setattr("signal.pthread_kill", lambda *_: None)
    monkeypatch.setattr(where, heard)
    assert run_main(command, "examples/double_pendulum.toml", "--limit", "7") == 1
    assert f"stopped after 7 s (--limit), at: {doing}" in capsys.readouterr().err


def test_what_never_ends_says_why() -> None:
    """A finger that falls for ever, and a damped rod of next to no mass whose steps would take hours."""
    with pytest.raises(pp.InputError, match="panda_finger_joint1 slides away"):
        pp.modes(pp.Scene(model=pp.UrdfModel("panda"), effects=(fx.Gravity(),)))
    light = pp.Chain(rods=[pp.Rod(length=1.0, mass=1e-9, radius=0.01)])
    shaken = kapitza(0.05).replace(model=light)
    damped = shaken.model_copy(update={"effects": (*shaken.effects, fx.Viscous(coefficient=0.3))})
    with pytest.raises(pp.RunError, match=r"settles within .* give what is damped or held more mass"):
        stability(damped)

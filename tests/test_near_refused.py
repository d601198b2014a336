"""Calls that have no answer: small motions, sensitivities, orbits and exponents end in one readable line."""

import math
from collections.abc import Callable
from functools import cache
from pathlib import Path
from tempfile import mkdtemp
from typing import Any

import numpy as np
import pytest

import pendpin as pp
from pendpin import effects as fx
from pendpin.motions.periodic import PeriodicOrbit

pytest.importorskip("llvmlite", reason="llvmlite is not installed: pip install llvmlite")
ROD = pp.Rod(length=1.0, mass=1.0, radius=0.05)
POINT = pp.Rod(length=1.0, mass=0.0, payload=1.0)
FRICTION, STOP = fx.DryFriction(kinetic=0.1), fx.Stop(lower=-1.0)
FUNCTION = fx.Torque(lambda t, q, v: -v, steady=True)
SHAKEN = fx.Support(amplitude=(0, 0, 0.1), frequency=3.0)
BEATING = [fx.Motor(joint="theta", amplitude=1.0, frequency=f) for f in (1.0, 2.0)]
RUBBED = pp.Scene(
    model=pp.Chain(rods=[ROD, pp.Rod(length=0.7, mass=0.4, radius=0.02)]),
    start=pp.Start(positions=(-1.4, 0.0, -1.1, 0.0)),
    effects=[fx.Gravity(), fx.DryFriction(kinetic=0.8)],
    duration=1.0,
)
HEIGHT = "effects[1].amplitude[2]"


def scene(*effects: fx.Effect, rod: pp.Rod = ROD, q: tuple[float, ...] = (0.0, 0.0), **more: Any) -> pp.Scene:
    options = {"duration": 2.0, "solver": pp.Solver(samples=5)} | more
    return pp.Scene(
        model=pp.Chain(rods=[rod]), effects=[fx.Gravity(), *effects], start=pp.Start(positions=q), **options
    )


@cache
def orbit() -> PeriodicOrbit:
    return pp.periodic_orbit(scene(SHAKEN))


@cache
def run() -> pp.Trajectory:
    return pp.simulate(scene(q=(1.0, 0.0)))


def of_robot(name: str, *effects: fx.Effect) -> pp.Scene:
    return pp.Scene(model=pp.UrdfModel(name), effects=effects)


SLIDING = """<robot name="lift"><link name="base"/><link name="cage"><inertial><mass value="1"/>
<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link><joint name="up" type="prismatic">
<parent link="base"/><child link="cage"/><axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
</robot>"""


@cache
def sliding() -> pp.Scene:
    path = Path(mkdtemp()) / "lift.urdf"
    path.write_text(SLIDING)
    return pp.Scene(model=pp.UrdfModel(path=str(path)), effects=[fx.Gravity()])


Call = Callable[[], Any]
REFUSED: dict[str, tuple[Call, str]] = {
    "no scene": (lambda: pp.linearize(7), "7 is not a Scene"),
    "nothing": (lambda: pp.modes(None), "None is not a Scene"),
    "a list": (lambda: pp.lyapunov([1, 2]), "not a Scene"),
    "no file": (lambda: pp.periodic_orbit("nowhere.toml"), "nowhere.toml"),
    "an unknown state": (lambda: pp.linearize(scene(), "rest"), "at: 'rest' is not a Start"),
    "a state that is NaN": (lambda: pp.linearize(scene(), math.nan), "at: nan is not a Start"),
    "too many angles": (lambda: pp.linearize(scene(), pp.Start(positions=[1, 2, 3])), "a list of 3"),
    "an unknown joint": (lambda: pp.linearize(scene(), pp.Start(positions={"thet": 1.0})), "thet"),
    "no equilibrium": (lambda: pp.modes(scene(fx.Motor(joint="theta", torque=50.0))), "no equilibrium"),
    "a robot that slides down": (lambda: pp.modes(sliding()), "no equilibrium"),
    "a thin rod at its pole": (
        lambda: pp.linearize(scene(rod=POINT), pp.Start(positions={"phi": math.pi / 2})),
        "rod is thin and at phi = ±90 degrees",
    ),
    "a thin rod that hangs along x": (
        lambda: pp.modes(pp.Scene(model=pp.Chain(rods=[POINT]), effects=[fx.Gravity(direction=(1, 0, 0))])),
        "rod is thin and at phi = ±90 degrees",
    ),
    "a motion from the pole": (lambda: pp.lyapunov(scene(rod=POINT, q=(0, math.pi / 2))), "rod is thin and at phi"),
    "a function": (lambda: pp.linearize(scene(FUNCTION)), r"effects\[1\]: torque has no derivative"),
    "exponents of a function": (lambda: pp.lyapunov(scene(FUNCTION)), r"effects\[1\]: torque has no derivative"),
    "exponents with friction": (lambda: pp.lyapunov(scene(FRICTION)), r"effects\[1\]: dry_friction acts at events"),
    "an orbit with a stop": (lambda: pp.periodic_orbit(scene(STOP), period=1.0), r"effects\[1\]: stop acts at events"),
    "transition with a stop": (
        lambda: pp.simulate(scene(STOP, q=(0.1, 0.0))).state_transition(0.0, 1.0),
        r"effects\[1\]: stop acts at events",
    ),
    "a force by friction": (
        lambda: pp.simulate(scene(FRICTION, q=(1.0, 0.0))).sensitivity("model.rods[0].mass", of="R3"),
        "of: R3 jumps where a joint sticks or slips",
    ),
    "a period too short to tell": (
        lambda: pp.periodic_orbit(scene(q=(0.5, 0.1)), period=1e-300),
        "period: after 1e-300 s",
    ),
    "a period of 0": (lambda: pp.periodic_orbit(scene(), period=0), "period: 0 is not"),
    "a negative period": (lambda: pp.periodic_orbit(scene(), period=-1.0), "period: -1.0 is not"),
    "a period that is NaN": (lambda: pp.periodic_orbit(scene(), period=math.nan), "period: nan is not"),
    "a period in words": (lambda: pp.periodic_orbit(scene(), period="1 s"), "period: '1 s' is not"),
    "several periods": (lambda: pp.periodic_orbit(scene(), period=np.ones(2)), "period: .* is not"),
    "two frequencies": (lambda: pp.periodic_orbit(scene(*BEATING)), "not driven by one frequency"),
    "no return": (
        lambda: pp.periodic_orbit(scene(fx.Viscous(coefficient=3.0), q=(1.0, 0.0))),
        "does not come near its start",
    ),
    "a guess in words": (lambda: pp.periodic_orbit(scene(), "near", 1.0), "guess: 'near' is neither"),
    "a guess of one number": (lambda: pp.periodic_orbit(scene(), [1.0], 1.0), "guess: .* 4 finite numbers"),
    "a guess that is NaN": (lambda: pp.periodic_orbit(scene(), [math.nan] * 4, 1.0), "guess: .* 4 finite numbers"),
    "no orbit": (lambda: pp.follow(scene(SHAKEN), HEIGHT, 0.2), "not a periodic orbit"),
    "a wrong key": (lambda: pp.follow(orbit(), "effects[1].amplitud[2]", 0.2), "nothing there"),
    "a key that is no text": (lambda: pp.follow(orbit(), None, 0.2), "None is not a key path"),
    "a key that is no number": (lambda: pp.follow(orbit(), "model.kind", 0.2), "'chain' is not a number"),
    "a number that is left out": (lambda: pp.follow(orbit(), "model.rods[0].com", 0.2), "no number is given there"),
    **{
        f"a change with {key}": (lambda key=key: run().sensitivity(key), says)
        for key, says in {
            "model.rods[0].com": "no number is given there; set one",
            "model.rods[0].inertia[0]": "nothing there",
            "model.rods[0].length.real": "nothing there",
            "effects[0].direction": "is not a number",
            "model.rods[0].copies": "this number has no derivative; lengths, masses and coefficients have one",
            "model.copies": "this number has no derivative",
        }.items()
    },
    **{
        f"{name} beyond double precision, or an array": (call, says)
        for name, call, says in (
            ("times", lambda: run().at(10**400), "times: a number of 400 digits are not numbers"),
            ("a level", lambda: run().crossings("theta_1", 10**400), "level: a number of 400 digits is not"),
            ("t0", lambda: run().state_transition(10**400, 1.0), "t0: a number of 400 digits is not a time"),
            ("a rate", lambda: pp.bind(scene()).energy([10**400] * 2, [0.0] * 2), "are not numbers"),
            ("a point", lambda: run().express("theta", point=10**400), "point: .* are not numbers"),
            ("a guess", lambda: pp.periodic_orbit(scene(), 10**400, 1.0), "guess: .* 4 finite numbers"),
            ("a joint", lambda: run().express(np.zeros((2, 2))), "express: .* is not one of"),
            ("a frame", lambda: run().express("theta", np.zeros((2, 2))), "frame: .* is not one of"),
            ("a side", lambda: run().express("theta", on=[]), "on: .* is not one of"),
            ("a case", lambda: pp.validate([[1]]), "validate: case .* is not one of"),
            ("a column", lambda: run().to_pandas(np.zeros((2, 2))), "is not the name of a quantity"),
            (
                "a key",
                lambda: pp.sections.bifurcation(scene(), [], [1], pp.sections.strobe(of="phi")),
                "is not a key path",
            ),
        )
    },
    "a key without derivative": (lambda: pp.follow(orbit(), "duration", 9.0), "has no derivative"),
    "to NaN": (lambda: pp.follow(orbit(), HEIGHT, math.nan), "to: nan is not a finite number"),
    "to words": (lambda: pp.follow(orbit(), HEIGHT, "far"), "to: 'far' is not a finite number"),
    "to where it is": (lambda: pp.follow(orbit(), HEIGHT, 0.1), "is 0.1 already"),
    "through the frequency 0": (lambda: pp.follow(orbit(), "effects[1].frequency", -3.0), "the drive has no period"),
    "no exponents": (lambda: pp.lyapunov(scene(), count=0), "count: 0 is not"),
    "too many exponents": (lambda: pp.lyapunov(scene(), count=5), "count: 5 is not .* 1 to 4"),
    "exponents in words": (lambda: pp.lyapunov(scene(), count="all"), "count: 'all' is not"),
    "no plane": (lambda: pp.lyapunov(scene(q=(0.5, 0.1)), planar=True), "planar: every joint moves from this start"),
    "no motion": (lambda: pp.lyapunov(scene(q=(0.0, 0.0)), planar=True), "planar: nothing moves from this start"),
    "too many of a plane": (
        lambda: pp.lyapunov(scene(q=(0.5, 0.0)), count=3, planar=True),
        "count: 3 is not .* 1 to 2",
    ),
    "a rate that is largest where a joint sticks": (
        lambda: pp.simulate(RUBBED).sensitivity("model.rods[0].length", of="theta_1_rate.max"),
        r"of: theta_1_rate.max is reached at 0\..* s, where a joint sticks or slips",
    ),
    "a swing through the vertical": (
        lambda: run().sensitivity("model.rods[0].length", of="swing.min"),
        "swing has no derivative at 0",
    ),
    **{
        name: (
            lambda name=name: pp.simulate(scene(), energy_balance=True).sensitivity("model.rods[0].mass", of=name),
            rf"of: {name}: derivatives of works and efforts are not computed; those of angles, .* are$",
        )
        for name in ("work_gravity.final", "work_gravity", "effort_gravity_theta.max")
    },
    "a quantity almost named as a work": (
        lambda: pp.simulate(scene(), energy_balance=True).sensitivity("model.rods[0].mass", of="wor_gravity"),
        r"of: 'wor_gravity' is not one of: (?!.*work_)",  # what would be refused then is not proposed
    ),
    "a negative duration": (lambda: pp.lyapunov(scene(), duration=-1.0), "duration: -1.0 is not"),
    "an infinite duration": (lambda: pp.lyapunov(scene(), duration=math.inf), "duration: inf is not"),
    "a scene of 0 s": (lambda: pp.lyapunov(scene(duration=0.0, solver=pp.Solver())), "a motion of 0 s"),
    "planar in words": (lambda: pp.lyapunov(scene(), planar="no"), "planar: 'no' is neither True nor False"),
    "a state in place of a start": (lambda: pp.linearize(scene(), np.zeros(4)), "at: .* is not a Start"),
    "a direction in a list": (lambda: run().crossings("theta", 0.0, [1]), r"direction: \[1\] is not 1"),
    "mode 0": (lambda: pp.modes(scene()).animate(0), "whole number from 1 to 2"),
    "a time that is NaN": (lambda: run().state_transition(0.0, math.nan), "t1: nan is not a time"),
    "times in reverse": (lambda: run().state_transition(1.0, 0.5), "t1: 0.5 s is before t0"),
    "no keys": (lambda: run().sensitivity([]), "none is given"),
    "keys that are a number": (lambda: run().sensitivity(3), "keys: 3 is not a list"),
    "a key that is a number": (lambda: run().sensitivity([3]), "3 is not a key path"),
    "a number that is not there": (lambda: run().sensitivity("model.rods[0].lenght"), "lenght"),
    "a rod that is not there": (lambda: run().sensitivity("model.rods[7].length"), r"rods\[7\]"),
    "a joint that is not there": (lambda: run().sensitivity("start.positions.theta_9"), "theta_9"),
    "a duration's derivative": (lambda: run().sensitivity("duration"), "duration: this number has no derivative"),
    "a quantity that is not there": (lambda: run().sensitivity("model.rods[0].length", of="R3_9"), "R3_9"),
    "an unknown statistic": (lambda: run().sensitivity("model.rods[0].length", of="R3.largest"), "largest"),
}


@pytest.mark.parametrize("name", list(REFUSED))
def test_hostile_calls_end_in_one_line(name: str) -> None:
    """InputError that names what is wrong; nothing is written beside it."""
    call, says = REFUSED[name]
    with pytest.raises(pp.InputError, match=says) as error:
        call()
    assert "\n" not in str(error.value)


def test_what_has_no_effects_has_an_answer() -> None:
    """Nothing brings anything back: every frequency and every exponent is 0, and a robot without gravity rests anywhere."""
    free = pp.Scene(model=pp.Chain(rods=[ROD]), effects=[], duration=1.0)
    assert not pp.modes(free).omega.any()
    assert not pp.lyapunov(free).exponents.any()
    assert not pp.modes(of_robot("ur5")).omega.any()

"""Laws of whole runs that hold for any scene: the order of the effects, effects of strength 0, units, potentials."""

import re
from dataclasses import replace
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import pendpin as pp
from effect_cases import ZERO
from laws import law
from pendpin import effects as fx
from pendpin.errors import InputError
from pendpin.scene import event_methods

LEAN = law(12)
ROD = pp.Rod(length=0.8, mass=1.0, radius=0.03)
TWO = pp.Chain(rods=(ROD, pp.Rod(length=0.5, mass=0.4, radius=0.02)))
SMOOTH = (
    fx.Gravity(),
    fx.Gravity(acceleration=0.3, direction=(1.0, 0.2, 0.1)),
    fx.Gravity(acceleration=0.1, direction=(0.3, 1.0, 0.7)),
    fx.Viscous(coefficient=0.05),
    fx.Viscous(coefficient=0.013, joints=("phi_1", "theta_2")),
    fx.Viscous(coefficient=0.0071, joints=("theta_2",)),
    fx.Spring(stiffness=0.7, rest=0.3),
    fx.Spring(stiffness=0.1, rest=-0.2),
    fx.Motor(joint="phi_2", amplitude=0.5, frequency=3.0),
    fx.Push(link="rod_1", force=(0.3, -0.2, 0.1), point=0.8),
    fx.Push(link="rod_2", force=(0.1, 0.1, 0.7)),
    fx.Drag(wind=(1.0, 0.5, 0.0), diameter=0.1),
    fx.Support(amplitude=(0.05, 0.0, 0.02), frequency=4.0),
    fx.Support(amplitude=(0.01, 0.03, 0.02), frequency=7.0),
    fx.Rotation(rate=(0.1, 0.2, 0.5)),
)
CONTACTS = (
    fx.DryFriction(kinetic=0.05, static=0.07),
    fx.DryFriction(kinetic=0.013, joints=("theta_1", "phi_2")),
    fx.DryFriction(kinetic=0.0071, static=0.02, stribeck=0.4),
    fx.Stop(lower=-0.6, upper=0.55, restitution=0.5),
    fx.Stop(upper=0.5, restitution=1.0, joints=("theta_1", "phi_2")),
    fx.Stop(upper=0.5, restitution=0.2),
    fx.Stop(lower=-0.4, restitution=0.9, joints=("phi_1", "phi_2")),
)
START = pp.Start(positions=(0.3, 0.4, -0.2, 0.5), velocities=(1.5, -1.0, 1.5, 2.0))
METHODS = (
    {"method": "dop853", "tolerance": 1e-8},
    {"method": "radau", "tolerance": 1e-5},
    {"method": "lsoda", "tolerance": 1e-7},
    {"method": "rk4", "step": 0.01},
    {"method": "euler", "step": 0.01},
    {"method": "gauss4", "step": 0.02},
)


def same_bits(one: pp.Trajectory, other: pp.Trajectory) -> None:
    """Every number of two runs, bit for bit."""
    for name in ("t", "q", "v", "a", "wrench", "kinetic", "potential", "tips"):
        assert np.array_equal(getattr(one, name), getattr(other, name)), name
    assert one.work.keys() == other.work.keys()
    assert all(np.array_equal(work, other.work[kind]) for kind, work in one.work.items())


# --- the order of the list ------------------------------------------------------------------------------------------


@LEAN
@given(st.data(), st.booleans())
def test_the_order_of_the_effects_changes_no_bit(data: st.DataObject, touching: bool) -> None:
    """Of motion, reactions, energies and works: any effects, several of a kind, stops that meet, by any method."""
    chosen = data.draw(st.lists(st.sampled_from(SMOOTH + CONTACTS * touching), max_size=6, unique_by=id))
    other = data.draw(st.permutations(chosen))
    method = data.draw(st.sampled_from(METHODS[: 3 if touching else None]))
    balance = not method["method"].startswith(("gauss", "euler"))
    scenes = (
        pp.Scene(duration=0.2, model=TWO, start=START, effects=tuple(effects), solver=pp.Solver(samples=3))
        for effects in (chosen, other)
    )
    same_bits(*(pp.simulate(scene, **method, energy_balance=balance) for scene in scenes))


# --- effects of strength 0 ------------------------------------------------------------------------------------------

THIN = pp.Chain(rods=(pp.Rod(length=0.8, mass=1.0), pp.Rod(length=0.5, mass=0.4)))
ANY_METHOD = (
    *METHODS,
    {"method": "taylor", "tolerance": 1e-12},
    {"method": "auto", "tolerance": 1e-9},
    {"accuracy": 1e-5},
    {"method": "bdf", "tolerance": 1e-5},
    {"method": "rk45", "tolerance": 1e-6},
    {"method": "rk23", "tolerance": 1e-4},
    {"method": "gauss2", "step": 0.02},
    {"method": "gauss6", "step": 0.02},
)
SCENES = st.tuples(
    st.sampled_from([TWO, THIN, pp.Chain(rods=(ROD,)), pp.Chain(rods=(pp.Rod(length=1.0, mass=1.0),))]),
    st.sampled_from(["auto", "auto", "compiled", "pinocchio", "chain"]),
    st.sampled_from([(), (fx.Gravity(),), (fx.Gravity(), fx.Support(amplitude=(0.05, 0.0, 0.02), frequency=4.0))]),
    st.booleans(),
)


@law(60)
@given(SCENES, st.sampled_from(ANY_METHOD), st.data())
def test_an_effect_of_strength_0_changes_no_bit(parts: Any, method: Any, data: st.DataObject) -> None:
    """Of a run: any of pendpin's effects, any number of them, at any place of the list, any engine and method.

    Nor does it change what is chosen, what is conservative, or which methods take the scene.
    """
    model, engine, effects, touching = parts
    name = method.get("method", "auto")
    balance = name in (*event_methods(), "auto")
    engine = engine if (balance and "accuracy" not in method) or name == "rk4" else "auto"
    if touching and balance and engine != "compiled":
        effects = (*effects, fx.Stop(upper=0.6, restitution=0.4))
    more = [*effects]
    for idle in data.draw(st.lists(st.sampled_from(list(ZERO.values())), min_size=1, max_size=4)):
        more.insert(data.draw(st.integers(0, len(more))), idle)
    count = 2 * len(model.rods)
    start = pp.Start(positions=(0.3, 0.4, -0.2, 0.5)[:count], velocities=(1.5, -1.0, 1.5, 2.0)[:count])
    solver = pp.Solver(samples=3, engine=engine)
    base = pp.Scene(duration=0.2, model=model, start=start, effects=tuple(effects), solver=solver)
    scenes = (base, base.model_copy(update={"effects": tuple(more)}))
    one, other = (pp.simulate(scene, **method, energy_balance=balance) for scene in scenes)
    same_bits(one, replace(other, work={kind: other.work[kind] for kind in one.work}))
    assert not any(work.any() for kind, work in other.work.items() if kind not in one.work)
    assert (one.stats.conservative, one.stats.engine) == (other.stats.conservative, other.stats.engine)


@pytest.mark.parametrize(
    ("effect", "said"),
    [
        (fx.Viscous(coefficient=0.0, joints=("thetta",)), "effects[1]"),
        (fx.Motor(joint="omega", torque=0.0), "effects[1]"),
        (fx.Push(link="rod_9"), "effects[1]"),
        (fx.DryFriction(kinetic=0.0, joints=("phi_9",)), "effects[1]"),
    ],
)
def test_names_are_read_at_strength_0_too(effect: fx.Effect, said: str) -> None:
    """A joint or link that the model lacks is refused, whatever the strength."""
    with pytest.raises(InputError, match=re.escape(said)):
        pp.bind(pp.Scene(model=pp.Chain(rods=(ROD,)), effects=(fx.Gravity(), effect)))


def test_a_support_that_stays_is_none(tmp_path: Path) -> None:
    """The path of a csv that never leaves the origin of W changes no bit."""
    path = tmp_path / "path.csv"
    path.write_text("t,x,y,z\n" + "".join(f"{t / 10},0,-0.0,0\n" for t in range(11)))
    base = pp.Scene(duration=0.5, model=TWO, start=START, effects=(fx.Gravity(),), solver=pp.Solver(samples=3))
    still = base.replace(effects=(fx.Gravity(), fx.Support(csv=path)))
    same_bits(*(pp.simulate(scene, method="taylor", tolerance=1e-12) for scene in (base, still)))


def test_a_subclass_has_its_own_strength() -> None:
    """What a user's own effect adds is not known from the strength of the class that it extends."""

    class Steady(fx.Viscous):
        def torques(self, t: Any, q: Any, v: Any, xp: Any = np) -> Any:
            return 0.1 - self.coefficient * v

    scene = pp.Scene(duration=0.1, model=pp.Chain(rods=(ROD,)), effects=(Steady(coefficient=0.0),))
    assert (pp.simulate(scene, tolerance=1e-8).q[-1] > 0).all()


# --- units of mass and length ---------------------------------------------------------------------------------------

LINK = """<link name="{0}"><inertial><origin xyz="{1!r} {2!r} {3!r}"/><mass value="{4!r}"/><inertia ixx="{5!r}" ixy="0"
 ixz="0" iyy="{5!r}" iyz="0" izz="{5!r}"/></inertial></link>"""
JOINT = """<joint name="{0}" type="{1}"><parent link="{2}"/><child link="{3}"/><origin xyz="{4!r} 0 {5!r}"/>
<axis xyz="0 1 0"/><limit lower="-9" upper="9" effort="1" velocity="1"/></joint>"""


def welded(folder: Path, mass: float, length: float) -> pp.UrdfModel:
    """Two links that turn, with others fixed to them: Pinocchio adds up their inertias."""
    text = ""
    for name, x, m in (("a", 0.3, 1.0), ("b", 0.7, 0.5), ("c", 0.1, 2.0), ("d", -0.4, 0.25)):
        sizes = (x * length, 0.1 * length, -0.3 * length, m * mass, 0.1 * m * mass * length**2)
        text += LINK.format(name, *sizes)
    joints = (("u", "continuous", "w", "a"), ("f", "fixed", "a", "b"), ("v", "continuous", "a", "c"))
    for joint in (*joints, ("g", "fixed", "c", "d")):
        text += JOINT.format(*joint, 0.1 * length, -0.5 * length)
    path = folder / f"{mass!r}.urdf"
    path.write_text(f'<robot name="r"><link name="w"/>{text}</robot>')
    return pp.UrdfModel(path=path)


def rods_of(mass: float, length: float, radius: float) -> pp.Chain:
    """Two rods."""
    sizes = ((0.7, 0.9), (0.5, 1.1))
    return pp.Chain(rods=[pp.Rod(length=a * length, mass=b * mass, radius=radius * length) for a, b in sizes])


@law(30)
@given(
    st.sampled_from(["rods", "thin rods", "urdf", "pin.Model"]),
    st.integers(-60, 60).map(lambda power: 4.0**power),
    st.integers(-40, 40).map(lambda power: 4.0**power),
    st.booleans(),
    st.sampled_from([*METHODS, {"method": "dop853", "tolerance": 1e-8, "engine": "compiled"}]),
)
def test_units_of_mass_and_length_change_no_bit(
    kind: str, mass: float, length: float, air: bool, method: dict[str, Any]
) -> None:
    """Any number of kilograms and metres moves alike, by any method: nothing is small or large but beside the scene.

    Powers of 4 are exact in every operation, and in square roots.
    """
    runs, options = [], {name: value for name, value in method.items() if name != "engine"}
    with TemporaryDirectory() as folder:
        for m, d in ((1.0, 1.0), (mass, length)):
            model: Any = rods_of(m, d, 0.05 * (kind == "rods")) if "rods" in kind else welded(Path(folder), m, d)
            model = pp.bind(pp.Scene(model=model)).model.pin if kind == "pin.Model" else model
            start = pp.Start(positions=(0.3, 0.4, -0.2, 0.5)[: 4 if "rods" in kind else 2])
            drag = fx.Drag(density=m / d**3, linear=0.1 * m / d, wind=(d, 0.5 * d, 0), diameter=0.1 * d, buoyancy=True)
            effects = (fx.Gravity(acceleration=9.75 * d), *(drag,) * air)
            solver = pp.Solver(engine=method.get("engine", "auto"), samples=3)
            scene = pp.Scene(duration=0.1, model=model, start=start, effects=effects, solver=solver)
            runs.append(pp.simulate(scene, **options))
    for name, unit in (("q", 1.0), ("v", 1.0), ("a", 1.0), ("kinetic", mass * length**2), ("tips", length)):
        assert np.array_equal(getattr(runs[0], name) * unit, getattr(runs[1], name)), name
    unit = np.repeat([mass * length, mass * length**2], 3)
    assert np.array_equal(runs[0].wrench * unit, runs[1].wrench)


# --- one air, one rotation ------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("effects", "says"),
    [
        ((fx.Rotation(rate=(0, 0, 1)), fx.Rotation(latitude=45.0)), "a second rotation beside effects[1]; W turns"),
        (
            (fx.Drag(wind=(3, 0, 0)), fx.Drag(wind=(0, 2, 0))),
            "a second drag beside effects[1]; a scene has one air",
        ),
    ],
)
def test_what_does_not_add_up_is_there_once(effects: tuple[Any, ...], says: str) -> None:
    """Coriolis and centrifugal forces of two rates, and the drag of two winds, lack their cross terms."""
    scene = pp.Scene(model=TWO, effects=(fx.Gravity(), *effects))
    with pytest.raises(pp.InputError) as error:
        pp.simulate(scene)
    assert f"effects[2]: {says}" in str(error.value)


@LEAN
@given(st.lists(st.tuples(*[st.floats(-2, 2)] * 3), min_size=2, max_size=3))
def test_fields_and_supports_add_up(parts: list[tuple[float, float, float]]) -> None:
    """Gravities and motions of the pivot are vectors: several do what their sum does, to rounding."""
    total = tuple(np.sum(parts, 0).tolist())
    push, support = partial(fx.Push, link="rod_2", point=0.3), partial(fx.Support, frequency=2.0)
    for several, one in (
        ([support(amplitude=part) for part in parts], support(amplitude=total)),
        ([push(force=part) for part in parts], push(force=total)),
    ):
        found, other = (
            pp.bind(pp.Scene(model=TWO, effects=(fx.Gravity(), *effects))).acceleration(
                0.3, np.array([0.3, 0.4, -0.2, 0.5]), np.array([1.5, -1.0, 1.5, 2.0])
            )
            for effects in (several, (one,))
        )
        assert np.abs(found - other).max() < 1e-11 * (1 + np.abs(found).max())


# --- potentials -----------------------------------------------------------------------------------------------------

CONSERVATIVE = (
    fx.Gravity(),
    fx.Spring(stiffness=0.7, rest=0.3),
    fx.Push(link="rod_1", force=(0.3, -0.2, 0.1), point=0.8),
    fx.Push(link="rod_2", force=(2.0, 0.4, 0.7)),
    fx.Rotation(rate=(0.4, 0.8, 1.5)),
)


@LEAN
@given(st.lists(st.sampled_from(CONSERVATIVE), min_size=1, unique_by=id), st.sampled_from([0.0, 0.05]))
def test_what_offers_a_potential_is_conserved(effects: list[Any], radius: float) -> None:
    """Constant pushes and the centrifugal force too: their energy is in the total, which stays; and so are the works."""
    model = pp.Chain(rods=(pp.Rod(length=0.8, mass=1.0, radius=radius), pp.Rod(length=0.5, mass=0.4, radius=radius)))
    scene = pp.Scene(duration=1.0, model=model, start=START, effects=tuple(effects), solver=pp.Solver(samples=11))
    run = pp.simulate(scene, tolerance=1e-12, energy_balance=True)
    assert run.stats.conservative
    assert run.energy().drift < 1e-9
    assert run.imbalance < 1e-9


def test_a_potential_that_moves_with_the_pivot_is_none() -> None:
    """The centrifugal force about an axis that stays while the pivot moves: its work is integrated, and adds up."""
    effects = (fx.Gravity(), fx.Rotation(rate=(0.4, 0.8, 1.5)), fx.Support(amplitude=(0.2, 0.1, 0), frequency=3.0))
    run = pp.simulate(pp.Scene(duration=1.0, model=TWO, start=START, effects=effects), energy_balance=True)
    assert not run.stats.conservative
    assert run.imbalance < 1e-8

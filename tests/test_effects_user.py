"""Effects that users write: the example of docs/effects.md runs, is right, and its runs can be drawn without it."""

from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar, Literal

import numpy as np
import pytest

import pendpin as pp
from effect_cases import MODELS, on_both, states
from pendpin.effects.pace import Pace
from pendpin.engines import Revolute, Spherical
from pendpin.graphics.run_drawing import drawing_of
from pendpin.model import kinematics
from pendpin.motions.crosschecks.crosscheck import crosscheck_run

TOP = Path(__file__).parents[1]
DOCS, EXAMPLES = TOP / "docs" / "effects.md", TOP / "examples"


@pytest.fixture(scope="module")
def example() -> dict[str, Any]:
    """The names that the code of docs/effects.md leaves behind."""
    names: dict[str, Any] = {"__name__": "example"}
    exec(DOCS.read_text().split("```python\n")[1].split("```")[0], names)
    return names


class Draught(pp.effects.FieldEffect):
    """A field of one's own: it grows with time."""

    kind: Literal["draught"] = "draught"
    growth: float

    def field(self, t: Any, xp: Any = np) -> np.ndarray:
        return np.array([self.growth * t, 0.0, 0.0])


class Brake(pp.effects.JointEffect):
    """A torque of one's own, on every joint: -strength v³."""

    kind: Literal["brake"] = "brake"
    strength: float

    def torques(self, t: Any, q: np.ndarray, v: np.ndarray, xp: Any = np) -> np.ndarray:
        return -self.strength * v**3


class Roughness(pp.effects.JointEffect):
    """A torque -strength |v| v that does not run on symbols, by an author who has not said so."""

    kind: Literal["roughness"] = "roughness"
    strength: float

    def torques(self, t: Any, q: np.ndarray, v: np.ndarray, xp: Any = np) -> np.ndarray:
        return -self.strength * np.abs(v) * v


class Spread(pp.effects.JointEffect):
    """A torque of one's own with a parameter that no file holds."""

    kind: Literal["spread"] = "spread"
    law: Any

    def torques(self, t: Any, q: np.ndarray, v: np.ndarray, xp: Any = np) -> np.ndarray:
        return self.law(q)


class Square(pp.effects.JointEffect):
    """A torque of one's own that keeps what it computes from its parameter: -strength² v."""

    parameters: ClassVar[tuple[str, ...]] = ("strength",)
    kind: Literal["square"] = "square"
    strength: float

    @cached_property
    def squared(self) -> Any:
        return self.strength * self.strength

    def torques(self, t: Any, q: np.ndarray, v: np.ndarray, xp: Any = np) -> np.ndarray:
        return -self.squared * v


def test_compiled_equations_take_the_numbers_of_each_scene() -> None:
    """Two scenes that differ in a parameter share machine code; what an effect kept of the first is no part of it."""
    compiled = pp.Solver(method="dop853", tolerance=1e-10, engine="compiled")
    still = pp.Scene(
        duration=1.0, model=MODELS["chain of 5"], start=pp.Start(positions={"theta_1": 1.0}), solver=compiled
    )
    for strength in (0.5, 1.5):
        square = Square(strength=strength)
        assert square.squared == strength**2  # kept before the scene is compiled
        damped = (square, pp.effects.Viscous(coefficient=strength**2))
        one, other = (pp.simulate(still.replace(effects=(pp.effects.Gravity(), effect))) for effect in damped)
        assert np.abs(one.q - other.q).max() < 1e-7


def test_what_cannot_be_saved_is_said_in_one_line(tmp_path: Path) -> None:
    """A run holds its scene; an effect with a function in it is refused before anything is computed."""
    scene = pp.Scene(duration=0.1, model=MODELS["one rod"], effects=(pp.effects.Gravity(), Spread(law=np.sin)))
    for options in ({}, {"accuracy": 1e-3}, {"checkpoint": tmp_path / "run.ckpt", "tolerance": 1e-6}):
        with pytest.raises(
            pp.InputError, match=r"^effects\[1\].law: a ufunc cannot be saved with the run: give Spread"
        ):
            pp.simulate(scene, **options)


def test_the_magnet_of_the_docs(example: dict[str, Any]) -> None:
    """It pulls the tip: energy with its potential is kept, and the thin rod stays regular."""
    run, dynamics = example["run"], pp.bind(example["scene"])
    assert isinstance(dynamics.engine, Spherical)
    model, (gravity, magnet) = dynamics.model, example["scene"].effects
    bodies, poses, zero = model.body_arrays, kinematics.poses(model, run.q), np.zeros((1, 3))
    total = run.kinetic + kinematics.field_potential(model, poses, gravity.field(0.0))
    for i, pose in enumerate(poses):
        total[i] += magnet.potential(bodies, pp.effects.Motion(pose[:, :3, 3], pose[:, :3, :3], zero, zero))
    assert np.ptp(total) < 1e-8 * run.kinetic.max()
    without = example["scene"].model_copy(update={"effects": example["scene"].effects[:1]})
    assert np.abs(pp.simulate(without).tips - run.tips).max() > 0.01


def test_effects_of_ones_own_on_both_engines(example: dict[str, Any]) -> None:
    """One of each interface, on a chain of five."""
    magnet = example["Magnet"](link="rod_3", at=(0.5, 0.5, -2.5), strength=1.0)
    found, other = on_both(MODELS["chain of 5"], (Draught(growth=0.3), Brake(strength=0.1), magnet), *states(10))
    assert np.abs(found - other).max() < 1e-11 * np.abs(found).max()


def test_a_sweep_takes_a_law_that_a_run_takes() -> None:
    """Where no method is named no law of one's own is believed to run on symbols, side by side as one by one."""
    effects = (pp.effects.Gravity(), Roughness(strength=0.1))
    scene = pp.Scene(duration=1.0, model=MODELS["one rod"], effects=effects, start=pp.Start(positions=(0.5, 0.1)))
    found = pp.sweep(scene, {"start.positions[0]": [0.5, 0.7]}, ["theta.final"])["theta.final"].values
    for end, theta in zip(found, (0.5, 0.7), strict=True):
        assert abs(end - pp.simulate(scene.replace({"start.positions[0]": theta}))["theta"][-1]) < 1e-8
    with pytest.raises(pp.InputError, match="roughness does not run on symbols"):
        pp.sweep(scene.with_solver(method="taylor"), {"start.positions[0]": [0.5, 0.7]}, ["theta.final"])


class Siren(pp.effects.JointEffect):
    """A torque of one's own of a frequency in Hz."""

    kind: Literal["siren"] = "siren"
    amplitude: float
    frequency: float

    def pace(self, begin: float, end: float, negligible: float) -> Pace:
        return Pace.even(0.5 / self.frequency)

    def torques(self, t: Any, q: np.ndarray, v: np.ndarray, xp: Any = np) -> np.ndarray:
        return self.amplitude * xp.sin(2 * np.pi * self.frequency * t) + 0 * q


def test_a_frequency_of_ones_own_is_no_period() -> None:
    """Nobody knows its unit: the period is asked for, and with it the orbit is that of the built-in motor."""
    model, orbits = pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0, joint="hinge")]), []
    for drive in (
        Siren(amplitude=0.3, frequency=0.4),
        pp.effects.Motor(joint="theta", amplitude=0.3, frequency=0.8 * np.pi),
    ):
        scene = pp.Scene(model=model, effects=(pp.effects.Gravity(), pp.effects.Viscous(coefficient=0.5), drive))
        orbits.append(pp.periodic_orbit(scene, period=2.5).orbit.q)
        if isinstance(drive, Siren):
            with pytest.raises(pp.InputError, match="give its period in s"):
                pp.periodic_orbit(scene)
    np.testing.assert_allclose(*orbits, rtol=0, atol=1e-10)


def test_a_number_without_derivative_is_refused_by_name() -> None:
    """What a class does not name in its parameters stands in the equations as a constant: its derivative is not 0."""

    class Named(Brake):
        """The same with its number among the parameters."""

        kind: Literal["named"] = "named"
        parameters = ("strength",)

    found, key = [], "effects[1].strength"
    for brake in (Named, Brake):
        effects = (pp.effects.Gravity(), brake(strength=0.1))
        scene = pp.Scene(duration=1.0, model=MODELS["one rod"], effects=effects, start=pp.Start(positions=(0.7, 0.1)))
        run = pp.simulate(scene)
        if brake is Named:
            ends = [pp.simulate(scene.replace({key: x}), tolerance=1e-13)["theta"][-1] for x in (0.1001, 0.0999)]
            found.append(run.sensitivity([key], of="theta.final")[0])
            assert found[0] == pytest.approx((ends[0] - ends[1]) / 0.0002, rel=1e-6)
        else:
            with pytest.raises(
                pp.InputError, match=r'this number has no derivative; .* Brake: parameters = \("strength",\)'
            ):
                run.sensitivity([key], of="theta.final")


class Coil(pp.effects.JointEffect):
    """A spring of one's own whose potential has the shape that `power` says."""

    kind: Literal["coil"] = "coil"
    power: int

    def torques(self, t: Any, q: np.ndarray, v: np.ndarray, xp: Any = np) -> np.ndarray:
        return -q

    def potential(self, q: np.ndarray) -> Any:
        return [(q**2).sum(1) / 2, q[0] ** 2, 1.0, q**2 / 2][self.power]


@pytest.mark.parametrize("power", [1, 2, 3])
def test_a_potential_of_another_shape_is_refused_by_name(power: int) -> None:
    """One number for each row of positions is wanted: (n,) of q (n, 2)."""
    start = pp.Start(positions=(0.7, 0.1))
    given = {"duration": 1.0, "model": MODELS["one rod"], "start": start}
    assert pp.simulate(pp.Scene(effects=(pp.effects.Gravity(), Coil(power=0)), **given)).energy().drift < 1e-8
    with pytest.raises(pp.InputError, match=r"coil: its potential returned shape .*, where \(31,\) is wanted"):
        pp.simulate(pp.Scene(effects=(pp.effects.Gravity(), Coil(power=power)), **given), samples=31)


def test_a_saved_run_is_drawn_without_the_class(example: dict[str, Any], tmp_path: Path) -> None:
    """Its scene cannot be built again, yet nothing that shows the run needs that."""
    checked = crosscheck_run(example["run"])  # while the class is there
    assert checked is not None
    assert checked.ok
    run = pp.Trajectory.load(example["run"].save(tmp_path / "run.npz"))
    assert run.scene["effects"][1] == {"kind": "magnet", "link": "rod", "at": [0.1, 0.1, -1.1], "strength": 0.2}
    assert len(drawing_of(run).t) == 301
    assert crosscheck_run(run) is None
    with pytest.raises(pp.InputError, match=r"effects\[1\]\.kind: 'magnet' is not one of: gravity, viscous"):
        pp.Scene(**run.scene)


def test_a_run_whose_file_of_positions_is_gone_is_drawn(tmp_path: Path) -> None:
    """The picture needs the model alone."""
    (tmp_path / "track.csv").write_text("0, 0, 0, 0\n1, 0, 0, 1\n2, 0, 0, 4\n")
    support = pp.effects.Support(csv=tmp_path / "track.csv")
    run = pp.simulate(pp.Scene(duration=0.5, model=MODELS["one rod"], effects=(support,)))
    (tmp_path / "track.csv").unlink()
    loaded = pp.Trajectory.load(run.save(tmp_path / "run.npz"))
    assert len(drawing_of(loaded).t) == 31
    assert crosscheck_run(loaded) is None


def test_parameters_of_ones_own_are_checked(example: dict[str, Any]) -> None:
    """Like any other, in one line."""
    for wrong, says in (({"strength": float("nan")}, "strength: nan is not a finite"), ({"radius": 1}, "unknown key")):
        with pytest.raises(pp.InputError, match=says):
            example["Magnet"](**({"link": "rod", "at": (0, 0, 0), "strength": 1.0} | wrong))


class Careless(pp.effects.JointEffect):
    """-0.1 (v - 0.5) N m, computed in place in what it is given, and returned in the same array every time."""

    kind: Literal["careless"] = "careless"
    joints: tuple[str, ...] | None = None
    shape: tuple[int, ...] | None = None

    @property
    def on(self) -> tuple[str, ...] | None:
        return self.joints

    def torques(self, t: Any, q: np.ndarray, v: np.ndarray, xp: Any = np) -> np.ndarray:
        v -= 0.5
        v *= -0.1
        SAME[: len(v)] = v
        return SAME[: len(v)] if self.shape is None else np.ones(self.shape)


class CarelessBody(pp.effects.BodyEffect):
    """-0.1 (velocity - 1) N on each body, in the same way."""

    kind: Literal["careless_body"] = "careless_body"

    def wrench(self, t: Any, bodies: Any, motion: Any, xp: Any = np) -> tuple[np.ndarray, np.ndarray]:
        force = motion.velocity
        force -= 1.0
        force *= -0.1
        SAME_FORCE[:] = force
        bodies.mass[:] = 7.0
        return SAME_FORCE, np.zeros((2, 3))


class CarefulBody(pp.effects.BodyEffect):
    kind: Literal["careless_body"] = "careless_body"

    def wrench(self, t: Any, bodies: Any, motion: Any, xp: Any = np) -> tuple[np.ndarray, np.ndarray]:
        return -0.1 * (motion.velocity - 1.0), np.zeros((2, 3))


SAME, SAME_FORCE = np.zeros(4), np.zeros((2, 3))


@pytest.mark.parametrize(
    "options", [{}, pytest.param({"method": "lsoda"}, marks=pytest.mark.slow), {"method": "rk4", "step": 0.01}]
)
def test_an_effect_that_computes_in_place_changes_no_state(options: dict[str, Any]) -> None:
    """Every array of the run is that of a law which makes new arrays, bit for bit."""
    rods = [pp.Rod(length=1.0, mass=1.0, radius=0.01)] * 2
    start = pp.Start(positions={"theta_1": 0.7})
    scene = pp.Scene(duration=0.5, model=pp.Chain(rods=rods), start=start, effects=[pp.effects.Gravity()])
    scene = scene.replace({"solver.engine": "pinocchio"})  # all else is compiled beside a Torque
    law = pp.effects.Torque(lambda t, q, v: (v - 0.5) * -0.1)
    for careless, careful in ((Careless(), law), (CarelessBody(), CarefulBody())):
        found, wanted = (
            pp.simulate(scene.replace(effects=[*scene.effects, e]), **options) for e in (careless, careful)
        )
        for name in ("q", "v", "a", "wrench"):
            assert np.abs(getattr(found, name) - getattr(wanted, name)).max() < 1e-13, name


@pytest.mark.parametrize("shape", [(1,), (2, 1), (4,), ()])
def test_torques_of_another_shape_are_refused(shape: tuple[int, ...]) -> None:
    """NumPy would spread one number over several joints, in silence."""
    effect = Careless(joints=("theta_1", "phi_2"), shape=shape)
    with pytest.raises(
        pp.InputError, match=r"^effects: careless: its torques returned shape .*, where \(2,\) is wanted"
    ):
        pp.simulate(pp.Scene(duration=0.1, model=MODELS["chain of 5"], effects=(effect,)))


def test_smooth_is_a_property() -> None:
    """A plain value, with or without a type, is refused in one line."""
    says = "Rough.smooth: write smooth as a property that returns False"
    with pytest.raises(pp.InputError, match=says):
        type("Rough", (pp.effects.JointEffect,), {"smooth": False, "__module__": __name__})
    with pytest.raises(pp.InputError, match=says):
        type("Rough", (pp.effects.JointEffect,), {"smooth": False, "__annotations__": {"smooth": bool}})


def test_an_effect_of_ones_own_may_turn_thin_rods() -> None:
    """Unless it says that it does not, they stay on their joints."""

    class Twist(pp.effects.BodyEffect):
        kind: Literal["twist"] = "twist"

        def wrench(self, t: Any, bodies: Any, motion: Any, xp: Any = np) -> tuple[np.ndarray, np.ndarray]:
            return np.zeros((len(bodies.mass), 3)), motion.rotation[:, :, 2]

    assert isinstance(pp.bind(pp.Scene(model=MODELS["thin chain of 3"], effects=(Twist(),))).engine, Revolute)


@pytest.mark.parametrize("name", ["foucault", "crane"])
def test_the_examples_run(name: str) -> None:
    """As files, for their first second."""
    scene = pp.load_scene(EXAMPLES / f"{name}.toml")
    run = pp.simulate(scene.model_copy(update={"duration": 1.0, "solver": pp.Solver(tolerance=1e-8, samples=5)}))
    assert np.isfinite(run.tips).all()


def test_the_example_of_kapitza_stands() -> None:
    """It comes to rest upright."""
    run = pp.simulate(pp.load_scene(EXAMPLES / "kapitza.toml"))
    assert np.abs(run.q[-1] - [np.pi, 0]).max() < 0.02

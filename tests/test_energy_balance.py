"""Energy balance: the change of kinetic energy is the sum of the works, whatever acts."""

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

import pendpin as pp
from laws import law
from pendpin.effects import Drag, DryFriction, Gravity, Motor, Push, Rotation, Spring, Stop, Support, Viscous
from pendpin.runs.preparation import EnergyBalance
from scenes import scene_of

SMOOTH = {
    "gravity": Gravity(),
    "viscous": Viscous(coefficient=0.05),
    "spring": Spring(stiffness=2.0, rest=0.1),
    "motor": Motor(joint="phi_2", amplitude=0.5, frequency=3.0),
    "push": Push(link="rod_1", force=(0.3, -0.2, 0.1), point=0.8),
    "drag": Drag(wind=(1.0, 0.5, 0.0), diameter=0.1),
    "support": Support(amplitude=(0.05, 0.0, 0.02), frequency=4.0),
    "rotation": Rotation(rate=(0.1, 0.2, 0.5)),
}
CONTACT = {
    "dry_friction": DryFriction(kinetic=0.05, static=0.07),
    "stop": Stop(lower=-0.6, upper=0.55, restitution=0.5),
}
Q, V = (0.3, 0.4, -0.2, 0.5), (1.5, -1.0, 1.5, 2.0)


def run_of(kinds, radius=0.03, duration=1.0, tolerance=1e-12) -> pp.Trajectory:
    """Two rods under these effects, with an energy balance."""
    effects = tuple((SMOOTH | CONTACT)[kind] for kind in kinds)
    rods = (pp.Rod(length=0.8, mass=1.0, radius=radius), pp.Rod(length=0.5, mass=0.4, radius=radius))
    scene = scene_of(rods, *effects, q=Q, v=V, duration=duration, samples=21)
    return pp.simulate(scene, tolerance=tolerance, energy_balance=True)


@law(10)
@given(st.sets(st.sampled_from(sorted(SMOOTH)), min_size=1))
def test_works_balance_without_events(kinds: set[str]) -> None:
    """Any set of smooth effects: to 1e-9 of the energy exchanged."""
    run = run_of(sorted(kinds))
    assert set(run.work) == kinds
    assert run.imbalance < 1e-9


@law(6)
@given(st.sets(st.sampled_from(sorted(SMOOTH)), max_size=3), st.sets(st.sampled_from(sorted(CONTACT)), min_size=1))
@example({"motor", "drag"}, {"dry_friction", "stop"})  # friction holds a joint at once, where another meets its stop
def test_works_balance_across_events(kinds: set[str], contacts: set[str]) -> None:
    """With sticking, sliding and impacts: to 1e-7 of the energy exchanged."""
    run = run_of(sorted(kinds | contacts), tolerance=1e-10)
    assert set(run.work) == kinds | contacts
    assert run.imbalance < 1e-7


@pytest.mark.parametrize("kind", ["gravity", "push", "support"])
def test_works_balance_for_thin_rods(kind: str) -> None:
    """The engines in directions have an energy balance too."""
    assert run_of(["gravity", kind], radius=0.0).imbalance < 1e-9


def test_dissipation_only_takes() -> None:
    """Viscous damping, drag in still air, friction and stops never give energy."""
    for kind in ("viscous", "dry_friction", "stop"):
        run = run_of(["gravity", kind], tolerance=1e-10, duration=4.0)
        assert np.diff(run.work[kind]).max() < 1e-9
        assert run.work[kind][-1] < -1e-4


def test_work_is_saved(tmp_path) -> None:
    """work_<kind> in the file, and back."""
    run = run_of(["gravity", "viscous"])
    again = pp.Trajectory.load(run.save(tmp_path / "run.npz"))
    assert set(again.work) == {"gravity", "viscous"}
    assert np.array_equal(again.work["viscous"], run.work["viscous"])


def test_powers_are_torques_times_rates() -> None:
    """Of a motor, of a coefficient for each joint, and of dry friction: each by the rates of its own joints."""
    effects = (
        Motor(joint="phi_2", torque=0.7),
        Viscous(coefficient=0.05, joints=["theta_1"]),
        Push(link="rod_1", force=(0.3, -0.2, 0.1), torque=(0.5, 0.0, 0.0)),
    )
    rods = (pp.Rod(length=0.8, mass=1.0, radius=0.03), pp.Rod(length=0.5, mass=0.4, radius=0.03))
    dynamics = pp.bind(scene_of(rods, *effects, q=Q, v=V, duration=1.0, samples=2))
    balance = EnergyBalance(dynamics)
    q, v = np.zeros(4), np.array(V)
    powers = dict(zip(balance.kinds, balance.powers(0.0, np.concatenate([q, v])), strict=True))
    assert powers["motor"] == pytest.approx(0.7 * v[3], rel=1e-14)
    assert powers["viscous"] == pytest.approx(-0.05 * v[0] ** 2, rel=1e-14)
    # it hangs: theta turns it about -x, phi about -y, and its middle is 0.4 m below
    assert powers["push"] == pytest.approx(0.3 * v[1] * 0.4 + 0.2 * -v[0] * -0.4 - 0.5 * v[0], rel=1e-12)

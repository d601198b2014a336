"""`linearize`: exact linear models of scenes near a state, against Pinocchio, differences and closed forms."""

import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import pendpin as pp
from laws import law
from pendpin import effects as fx
from pendpin.dynamics.dynamics import Dynamics
from pendpin.model.bodies import with_gravity
from pendpin.model.build import build

pytest.importorskip("llvmlite", reason="llvmlite is not installed: pip install 'pendpin[fast]'")
POINT = pp.Rod(length=1.0, mass=0.0, payload=1.0)
ROD = pp.Rod(length=1.0, mass=1.0, radius=0.05)
GRAVITY = fx.Gravity()


def hanging(*effects: fx.Effect, rods: tuple[pp.Rod, ...] = (ROD,), **more: object) -> pp.Scene:
    return pp.Scene(model=pp.Chain(rods=rods), effects=[GRAVITY, *effects], **more)


@pytest.mark.parametrize("robot", ["ur5", "panda"])
def test_robots_against_pinocchio(robot: str) -> None:
    """A and B at ten states, moving ones too, against ABA's own derivatives: within 1e-12 of the largest entry."""
    import pinocchio as pin

    scene, random = pp.Scene(model=pp.UrdfModel(robot), effects=[GRAVITY]), np.random.default_rng(4)
    model = with_gravity(build(scene.model).pin, np.array([0, 0, -9.81]))
    data, nv = model.createData(), model.nv
    for _ in range(10):
        q, v = random.uniform(-2.8, 2.8, nv), random.uniform(-2, 2, nv)
        found = pp.linearize(scene, pp.Start(positions=tuple(q), velocities=tuple(v)))
        pin.computeABADerivatives(model, data, q, v, np.zeros(nv))
        inverse = np.triu(data.Minv) + np.triu(data.Minv, 1).T
        for ours, theirs in (
            (found.A[nv:, :nv], data.ddq_dq),
            (found.A[nv:, nv:], data.ddq_dv),
            (found.B[nv:, :nv], inverse),
        ):
            assert np.abs(ours - theirs).max() <= 1e-12 * np.abs(theirs).max()
        assert (found.A[:nv] == np.eye(nv, 2 * nv, nv)).all()
        assert not found.B[:nv].any()
        assert np.allclose(found.residual, data.ddq, rtol=1e-10, atol=1e-9 * np.abs(data.ddq).max())


@law(20)
@given(seed=st.integers(0, 2**32 - 1), count=st.integers(1, 4))
def test_inputs_are_torques_and_the_acceleration_of_the_support(seed: int, count: int) -> None:
    """Accelerations are linear in both: the columns of B are differences for a unit of each, as the scene's effects."""
    random = np.random.default_rng(seed)
    q = tuple(random.uniform(-1.2, 1.2, 2 * count))
    scene = hanging(rods=(ROD,) * count, start=pp.Start(positions=q))
    found, nv = pp.linearize(scene, "start"), 2 * count
    still, model = np.zeros(nv), build(scene.model)
    base = Dynamics(model, scene.effects, form="angles").acceleration(0, np.array(q), still)
    for column, joint in enumerate(model.joints):
        effects = (*scene.effects, fx.Motor(joint=joint, torque=1.0))
        pushed = Dynamics(model, effects, form="angles").acceleration(0, np.array(q), still)
        assert np.allclose(found.B[nv:, column], pushed - base, rtol=1e-9, atol=1e-9 * np.abs(found.B).max())
    for axis in range(3):
        effects = (*scene.effects, fx.Gravity(acceleration=1.0, direction=tuple(-np.eye(3)[axis])))
        shaken = Dynamics(model, effects, form="angles").acceleration(0, np.array(q), still)
        assert np.allclose(found.B[nv:, nv + axis], shaken - base, rtol=1e-9, atol=1e-9 * np.abs(found.B).max())
    assert found.states == (*model.joints, *(f"{name}_rate" for name in model.joints))
    assert found.inputs == (*(f"torque_{name}" for name in model.joints), "support_x", "support_y", "support_z")


def test_the_default_is_the_rest_near_the_start() -> None:
    """Rods that start aside are linearised where they would hang; "start" and a Start are taken as they are."""
    scene = hanging(rods=(ROD, ROD), start=pp.Start(positions={"theta_1": 0.9}, velocities={"phi_2": 2.0}))
    rest, start = pp.linearize(scene), pp.linearize(scene, "start")
    assert np.abs(rest.q).max() < 1e-12
    assert rest.at_equilibrium
    assert rest.stable
    assert start.q[0] == 0.9
    assert start.v[3] == 2.0
    assert not start.at_equilibrium
    assert "not an equilibrium" in str(start)
    assert (pp.linearize(scene, scene.start).A == start.A).all()


@pytest.mark.parametrize("damping", [0.0, 1e6])
@pytest.mark.parametrize(("angle", "rests"), [(1e-10, True), (1e-7, False)])
def test_what_counts_as_a_rest_does_not_depend_on_the_damping(damping: float, angle: float, rests: bool) -> None:
    """Accelerations count against those of a turn by 1 rad; a rod that creeps back moves."""
    scene = hanging(*[fx.Viscous(coefficient=damping)] * bool(damping), start=pp.Start(positions={"theta_1": angle}))
    assert pp.linearize(scene, "start").at_equilibrium == rests


def test_an_upright_rod_is_unstable() -> None:
    """Its eigenvalues are ± sqrt(m g h / I), twice."""
    found = pp.linearize(hanging(), pp.Start(positions={"theta": np.pi}))
    rate = np.sqrt(9.81 * 0.5 / ((3 * 0.05**2 + 1) / 12 + 0.25))
    assert not found.stable
    assert np.allclose(np.sort(found.eigenvalues.real), [-rate, -rate, rate, rate], rtol=1e-14)


@pytest.mark.parametrize("spin", [4.0, 6.0])
def test_whirling_of_a_conical_pendulum(spin: float) -> None:
    """In a world that turns with it, it rests at cos(angle) = g / (spin² l): eigenvalues 0, 0, ±i spin sqrt(1 + 3 cos²).

    Small motions of the spherical pendulum: cos is that of the angle of the cone. The two zeros are the choice of the
    azimuth and of the spin: one Jordan block, so that rounding leaves sqrt(eps) of them.
    """
    angle = np.arccos(9.81 / spin**2)
    scene = pp.Scene(
        model=pp.Chain(rods=[POINT]),
        effects=[GRAVITY, fx.Rotation(rate=(0, 0, spin))],
        start=pp.Start(positions={"phi": angle - 0.05}),
    )
    found = pp.linearize(scene)
    swing = spin * np.sqrt(1 + 3 * np.cos(angle) ** 2)
    assert np.cos(found.q).prod() == pytest.approx(np.cos(angle), rel=1e-12)
    values = found.eigenvalues[np.argsort(np.abs(found.eigenvalues))]
    assert np.abs(values[:2]).max() < 1e-6 * spin
    assert np.allclose(np.abs(values[2:].imag), swing, rtol=1e-12)
    assert found.stable


def test_drag_and_friction_are_said() -> None:
    """Quadratic drag damps nothing that is small, friction is left out: the notes say so."""
    scene = hanging(
        fx.Drag(), fx.DryFriction(kinetic=0.1), fx.Support(amplitude=(0.1, 0, 0), frequency=2.0, phase=np.pi / 2)
    )
    found = pp.linearize(scene)
    assert [note.partition(":")[0] for note in found.notes] == ["effects[1]", "effects[2]", "effects[3]"]
    assert found.stable
    assert np.abs(found.A[2:, 2:]).max() < 1e-15  # the support is at its turning point, but for the rounding of pi


def test_without_python_control_its_name_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    """The package, and how to get it."""
    monkeypatch.setitem(sys.modules, "control", None)
    with pytest.raises(pp.MissingLibrary, match="pip install control"):
        pp.linearize(hanging()).to_control()


def test_python_control_has_the_same_model() -> None:
    """Its poles are the eigenvalues; its static gain from a torque is minus the inverse of the stiffness in A."""
    pytest.importorskip("control", reason="python-control is not installed: pip install control")
    found = pp.linearize(hanging(fx.Viscous(coefficient=0.2), rods=(ROD, ROD)))
    system = found.to_control()
    poles, own = (np.sort_complex(np.round(x, 9)) for x in (system.poles(), found.eigenvalues))
    assert np.abs(poles - own).max() < 1e-8  # two planes, so that each eigenvalue is double
    assert system.state_labels == list(found.states)
    assert system.input_labels == list(found.inputs)
    assert np.allclose(system.dcgain(), -np.linalg.solve(found.A, found.B), atol=1e-12)

"""Rods on hinges and in trees: the motion, its derivatives, reactions, fits and modes, and what is refused."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import pendpin as pp
from pendpin import effects as fx
from pendpin.engines.machine import llvm
from pendpin.model import kinematics
from pendpin.model.bodies import mass_matrix
from pendpin.model.build import build
from pendpin.runs.preparation import bind_for_run

G = 9.81
ROD: dict[str, Any] = {"length": 1.0, "mass": 1.2, "radius": 0.02}
ON_X, ON_Y = ROD | {"joint": "hinge"}, ROD | {"joint": "hinge", "axis": "y"}
# a tree of both hinges and universal joints, with branches at tips and between
TREE = pp.Chain(
    rods=[
        ON_X,
        ROD | {"length": 0.6, "at": 0.7},
        ON_Y | {"mass": 0.5},
        ON_X | {"length": 0.4, "hangs_on": "rod_2", "at": 0.1, "payload": 0.3},
        ON_Y | {"length": 0.8, "hangs_on": "rod_1"},
        ROD | {"hangs_on": "world", "copies": 2},
    ]
)
EFFECTS = (
    fx.Gravity(),
    fx.Viscous(coefficient=0.05),
    fx.Bending(stiffness=0.7, clamp=(0.1, 0.2, -1.0)),
    fx.Drag(linear=0.1),
    fx.Anchor(link="rod_5", point=(0.2, 0.0, -1.5), stiffness=4.0, damping=0.2, at=0.3),
    fx.Push(link="rod_3", force=(0.2, 0.0, 0.1), point=0.2),
    fx.Motor(joint="phi_3", amplitude=0.3, frequency=2.0),
)


def moving(model: pp.Chain, *effects: fx.Effect, duration: float = 1.0, seed: int = 0, **solver: Any) -> pp.Scene:
    """A scene of a model that starts anywhere."""
    q, v = np.random.default_rng(seed).uniform(-0.9, 0.9, (2, len(build(model).joints)))
    start = pp.Start(positions=tuple(q.tolist()), velocities=tuple(v.tolist()))
    solver = {"samples": 13} | solver
    return pp.Scene(model=model, start=start, duration=duration, effects=effects, solver=pp.Solver(**solver))


def states(model: pp.Chain, count: int = 20, seed: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """States (count, nv)."""
    q, v = np.random.default_rng(seed).uniform(-3, 3, (2, count, len(build(model).joints)))
    return q, v


# --- the motion -------------------------------------------------------------------------------------------------------


def test_two_hinges_move_by_lagrange() -> None:
    """A planar double pendulum in absolute angles: M a + C v² + G = 0, as mechanics books derive it."""
    rods = [pp.Rod(length=0.8, mass=1.1, joint="hinge", com=0.3, inertia=(0.05, 0.05, 0.01))]
    rods += [pp.Rod(length=0.6, mass=0.7, joint="hinge", com=0.4, inertia=(0.03, 0.03, 0.01))]
    dynamics = pp.bind(pp.Scene(model=pp.Chain(rods=rods), effects=[fx.Gravity()]))
    (m1, h1, I1, *_), (m2, h2, I2, *_) = (rod.properties for rod in rods)
    a, b, c = I1 + m1 * h1**2 + m2 * 0.8**2, I2 + m2 * h2**2, m2 * 0.8 * h2
    for q, v in zip(*states(pp.Chain(rods=rods)), strict=True):
        one, two = np.cumsum(q)
        w1, w2 = np.cumsum(v)
        mass = np.array([[a, c * math.cos(one - two)], [c * math.cos(one - two), b]])
        turning = c * math.sin(one - two) * np.array([w2**2, -(w1**2)])
        weight = G * np.array([(m1 * h1 + m2 * 0.8) * math.sin(one), m2 * h2 * math.sin(two)])
        absolute = np.linalg.solve(mass, -turning - weight)
        assert np.diff(absolute, prepend=0.0) == pytest.approx(dynamics.acceleration(0.0, q, v), rel=1e-10)


def test_a_hinge_about_y_is_one_about_x_turned() -> None:
    """Turned by 90 degrees about the vertical, x goes to y and y to -x: phi then counts as theta does, in every effect."""
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    rods = [
        ROD | {"joint": "hinge"},
        ROD | {"joint": "hinge", "at": 0.6},
        ROD | {"joint": "hinge", "hangs_on": "rod_1"},
    ]
    x, y = (pp.Chain(rods=[rod | {"axis": axis} for rod in rods]) for axis in "xy")
    one, two = (
        pp.simulate(moving(model, fx.Gravity(), fx.Drag(wind=wind), fx.Bending(stiffness=0.3, clamp=clamp)))
        for model, wind, clamp in ((x, (0.0, 2.0, 0.5), (0.2, 0.4, -1.0)), (y, (-2.0, 0.0, 0.5), (-0.4, 0.2, -1.0)))
    )
    assert one.q == pytest.approx(two.q, abs=1e-9)
    assert one.tips @ turn.T == pytest.approx(two.tips, abs=1e-9)
    for name, other in (("R2", "R1"), ("R3", "R3"), ("M2", "M1"), ("M3", "M3")):
        mine, theirs = getattr(one.reactions(), name), getattr(two.reactions(), other)
        assert mine == pytest.approx(theirs, abs=1e-7), name


def test_a_row_of_universal_joints_as_a_tree_is_the_chain() -> None:
    """`at` written out makes a tree of a chain: the same motion and reactions by other equations."""
    chain = pp.Chain(rods=[ROD, ROD | {"length": 0.5}, ROD])
    tree = pp.Chain(rods=[ROD, ROD | {"length": 0.5, "at": 1.0}, ROD | {"hangs_on": "rod_2", "at": 0.5}])
    assert build(chain).chain is not None
    assert build(tree).chain is None
    effects = (fx.Gravity(), fx.Bending(stiffness=0.7, clamp=(0.1, 0.2, -1.0)), fx.Drag(), fx.Viscous(coefficient=0.1))
    one, two = (pp.simulate(moving(model, *effects), tolerance=1e-12, energy_balance=True) for model in (chain, tree))
    assert one.names == two.names
    for name in one.names:
        assert np.abs(one[name] - two[name]).max() < 1e-9 * max(1.0, np.abs(one[name]).max()), name
    named = pp.Chain(rods=[ROD, ROD | {"length": 0.5, "hangs_on": "rod_1"}, ROD | {"hangs_on": "rod_2"}])
    assert build(named).chain is not None  # in a row all the same: to the bit
    assert np.array_equal(pp.simulate(moving(named, *effects)).q, pp.simulate(moving(chain, *effects)).q)


def test_a_hinge_is_a_universal_joint_that_stays_in_its_plane() -> None:
    """Two universal rods in the plane of theta carry the wrenches of two hinges."""
    hinged, universal = (pp.Chain(rods=[rod, rod | {"length": 0.5}]) for rod in (ON_X, ROD))
    start = {"theta_1": 1.0, "theta_2": -0.5}
    one, two = (
        pp.simulate(pp.Scene(model=model, start=pp.Start(positions=start), effects=[fx.Gravity()], duration=2.0))
        for model in (hinged, universal)
    )
    for name in ("theta_1", "theta_2_rate", "R2_1", "R3_2", "tip_y", "energy", "omega1_2"):
        assert one[name] == pytest.approx(two[name], abs=1e-7), name


@pytest.mark.parametrize("effects", [EFFECTS, (*EFFECTS, fx.DryFriction(kinetic=0.1, joints=("theta_1", "phi_5")))])
def test_the_work_explains_the_energy(effects: tuple[fx.Effect, ...]) -> None:
    run = pp.simulate(moving(TREE, *effects, duration=2.0), tolerance=1e-11, energy_balance=True)
    assert run.imbalance < 1e-8
    still = pp.simulate(moving(TREE, fx.Gravity(), fx.Bending(stiffness=0.7), duration=2.0), tolerance=1e-12)
    assert still.energy().drift < 1e-10


def test_a_stop_throws_a_hinge_back() -> None:
    """Its rate times the restitution, at the limit; the energy falls by that of one rod."""
    rod = pp.Chain(rods=[ON_X])
    stop = fx.Stop(lower=-0.2, restitution=0.5, joints=("theta",))
    scene = pp.Scene(model=rod, start=pp.Start(positions={"theta": 0.8}), effects=[fx.Gravity(), stop], duration=1.0)
    run = pp.simulate(scene)
    (event,) = [event for event in run.events if event.kind == "stop"][:1]
    before, after = run.at(event.t - 1e-7), run.at(event.t + 1e-7)
    assert after.v[0, 0] == pytest.approx(-0.5 * before.v[0, 0], rel=1e-5)
    assert run.q.min() > -0.2 - 1e-9


def test_all_methods_agree() -> None:
    effects = (fx.Gravity(), fx.Viscous(coefficient=0.05), fx.Spring(stiffness=0.5))
    scene = moving(TREE, *effects, samples=3)
    ways = [{"method": name, "tolerance": 1e-12} for name in ("dop853", "radau", "taylor")]
    ways += [{"method": "gauss4", "step": 2e-3}, {"accuracy": 1e-8}]
    ends = np.array([pp.simulate(scene, **way).q[-1] for way in ways])
    assert np.abs(ends - ends[0]).max() < 1e-7


# --- where it is, and what is compiled --------------------------------------------------------------------------------


def test_poses_and_energies_are_pinocchios() -> None:
    """Those of all states at once are those of one after the other, by Pinocchio."""
    import pinocchio as pin

    model = build(TREE)
    q, v = states(TREE)
    poses, kinetic = kinematics.poses_and_energy(model, q, v)
    data = pin.Data(model.pin)
    for i in range(len(q)):
        assert kinetic[i] == pytest.approx(pin.computeKineticEnergy(model.pin, data, q[i], v[i]), rel=1e-12)
        for body, pose in zip(model.bodies, poses[i], strict=True):
            assert np.abs(data.oMi[body.joint + 1].homogeneous - pose).max() < 1e-13


def test_the_mass_matrix_is_twice_the_energy() -> None:
    """Pinocchio's is right only where the joints of a branch stand together: v M v / 2 = T at random rates."""
    model = build(TREE)
    for q, v in zip(*states(TREE), strict=True):
        energy = kinematics.poses_and_energy(model, q[None], v[None])[1][0]
        assert v @ mass_matrix(model.pin, q) @ v / 2 == pytest.approx(energy, rel=1e-12)


ROWS = [pp.Chain(rods=[ON_X | {"copies": 7}]), pp.Chain(rods=[ON_Y | {"at": None}, ON_Y | {"at": 0.3}] * 3), TREE]


@pytest.mark.skipif(not llvm.installed(), reason="needs llvmlite")
@pytest.mark.parametrize("model", ROWS)
def test_compiled_equations_are_the_same(model: pp.Chain) -> None:
    """Rows of hinges as a loop over rods, trees written out: rates, and what is computed at the samples."""
    effects = [
        e.model_copy(update={"joint": build(model).joints[2]}) if isinstance(e, fx.Motor) else e for e in EFFECTS
    ]
    scene = moving(model, *effects)
    dynamics, q, v = bind_for_run(scene), *states(model, 5)
    nv = q.shape[1]
    derivative, _ = dynamics.in_machine_code.engine.derivative(lambda t: None)
    for one, two in zip(q, v, strict=True):
        rates = np.zeros(2 * nv)
        derivative(rates, 0.2, np.concatenate([one, two]))
        assert rates[nv:] == pytest.approx(dynamics.acceleration(0.2, one, two), rel=1e-10, abs=1e-10)
    assert dynamics.sampler is not None
    given = np.full(5, 0.2), q, v
    sampled = dynamics.sampler(*given)
    assert sampled is not None
    expected = (*dynamics.engine.evaluate(*given), *kinematics.poses_and_energy(dynamics.model, q, v))
    for ours, theirs in zip(sampled, expected, strict=True):
        assert np.abs(ours - theirs).max() < 1e-11 * np.abs(theirs).max()


# --- reactions --------------------------------------------------------------------------------------------------------


def test_reactions_hold_each_rod() -> None:
    """Newton and Euler for each rod, from the run's motion alone: in a frame at rest, about the centre of mass."""
    run = pp.simulate(moving(TREE, fx.Gravity(), samples=5), tolerance=1e-12)
    parts, model, h = run.reactions(), build(TREE), 1e-4
    assert TREE.parents == (-1, 0, 1, 1, 0, -1, 5)
    ways = [run.q + s * h * run.v + (s * h) ** 2 / 2 * run.a for s in (-1, 0, 1)]
    before, now, after = (kinematics.poses(model, q) for q in ways)
    flip = np.diag([1.0, -1.0, -1.0])
    frames = now[..., :3, :3] @ flip
    com = np.array([[*body.com, 1.0] for body in model.bodies])
    b, n, a = (np.einsum("nrij,rj->nri", pose[..., :3, :], com) for pose in (before, now, after))
    masses = np.array([body.mass for body in model.bodies])[:, None]
    force = np.stack([parts.R1, parts.R2, -parts.R3], -1)
    force = np.einsum("nrij,nrj->nri", frames, force)
    total = masses * ((a - 2 * n + b) / h**2 + [0, 0, G])
    for rod in range(len(masses)):
        children = [i for i, parent in enumerate(TREE.parents) if parent == rod]
        assert np.abs(total[:, rod] + force[:, children].sum(1) - force[:, rod]).max() < 1e-4
    zero = {rod.link: {"universal": "M2", "x": "M1", "y": "M2"}[rod.kind] for rod in model.rods}
    for place, name in enumerate(zero.values()):
        assert not getattr(parts, name)[:, place].any()
        assert f"{name}_{place + 1}" not in run.names


def test_moments_of_a_hinge_by_hand() -> None:
    """A lever of one hinge about x with a mass beside its plane: M3 and M2 carry it; a motor's torque is no reaction."""
    rods = [
        ON_X | {"mass": 1e-9, "inertia": (1e-6, 1e-6, 1e-6)},
        {"length": 1.0, "mass": 2.0, "joint": "hinge", "axis": "y"},
    ]
    start = pp.Start(positions={"phi_2": 0.6})
    torque = fx.Motor(joint="phi_2", torque=2.0 * G * 0.5 * math.sin(0.6))  # holds it
    scene = pp.Scene(model=pp.Chain(rods=rods), start=start, effects=[fx.Gravity(), torque], duration=0.0)
    run = pp.simulate(scene)
    assert abs(run["phi_2_acceleration"][0]) < 1e-9
    assert run["R3_1"][0] == pytest.approx(2.0 * G, rel=1e-6)
    assert abs(run["M2_1"][0]) == pytest.approx(2.0 * G * 0.5 * math.sin(0.6), rel=1e-6)  # of the weight beside it
    assert abs(run["M3_1"][0]) < 1e-9
    assert abs(run["M1_2"][0]) < 1e-9
    assert {"M2_1", "M3_1", "M1_2", "M3_2"} <= set(run.names)
    assert not {"M1_1", "Mc_1", "M2_2", "Mc_2"} & set(run.names)


def test_a_run_is_saved_with_its_moments(tmp_path: Path) -> None:
    run = pp.simulate(moving(TREE, *EFFECTS))
    again = pp.Trajectory.load(run.save(tmp_path / "run.npz"))
    assert again == run
    assert again.reactions()._fields == ("R1", "R2", "R3", "M1", "M2", "M3", "Mc")
    assert np.isfinite(np.array(again.reactions())).all()
    scene = pp.load_scene(run.source.save(tmp_path / "scene.toml"))
    assert scene == run.source
    universal = pp.simulate(moving(pp.Chain(rods=[ROD, ROD | {"at": 0.5}]), fx.Gravity()))
    assert universal.reactions()._fields == ("R1", "R2", "R3", "M3", "Mc")


# --- derivatives, modes, fits -----------------------------------------------------------------------------------------


@pytest.mark.skipif(not llvm.installed(), reason="needs llvmlite")
@pytest.mark.parametrize(
    ("model", "keys"),
    [
        (TREE, ("model.rods[0].length", "model.rods[1].at", "model.rods[3].payload", "effects[2].stiffness")),
        (pp.Chain(rods=[ON_Y] * 5), ("model.rods[1].mass", "model.rods[0].length", "effects[2].stiffness")),
    ],
)
def test_sensitivities_are_differences(model: pp.Chain, keys: tuple[str, ...]) -> None:
    scene = moving(model, *EFFECTS[:3], EFFECTS[4], samples=2, tolerance=1e-12)
    keys = (*keys, "start.positions[1]")
    exact = pp.simulate(scene).sensitivity(keys)[-1]
    for k, key in enumerate(keys):
        value: Any = scene
        for name in key.replace("[", ".").replace("]", "").split("."):
            value = value[int(name)] if name.isdigit() else getattr(value, name)
        above, below = (pp.simulate(scene.replace({key: value + step})) for step in (1e-5, -1e-5))
        differences = np.concatenate([above.q[-1] - below.q[-1], above.v[-1] - below.v[-1]]) / 2e-5
        assert exact[:, k] == pytest.approx(differences, abs=1e-6 * max(1.0, np.abs(differences).max())), key


def test_modes_of_half_a_mobile_by_hand() -> None:
    """A bar with a load on a string: M = [[a, b], [b, m l²]], K = diag(m g d, m g l) in absolute angles.

    The bar is held at its centre of mass, and the string hangs d from there.
    """
    m, long, half = 0.5, 0.7, 0.4
    bar = {"length": 2 * half, "mass": 1.0, "com": 0.0, "inertia": (0.06, 0.06, 0.001), "joint": "hinge"}
    string = {"length": long, "mass": 0.0, "payload": m, "joint": "hinge", "hangs_on": "rod_1"}
    model = pp.Chain(rods=[bar, string | {"at": half}])
    a, b = 0.06 + m * half**2, m * half * long
    M, K = np.array([[a, b], [b, m * long**2]]), np.diag([m * G * half, m * G * long])
    expected = np.sqrt(np.sort(np.linalg.eigvals(np.linalg.solve(M, K)).real))
    found = pp.modes(pp.Scene(model=model, effects=[fx.Gravity()])).omega
    assert found == pytest.approx(expected, rel=1e-10)
    assert pp.linearize(pp.Scene(model=model, effects=[fx.Gravity()])).A.shape == (4, 4)


def test_a_bending_hinge_is_a_spring_about_its_axis() -> None:
    """Its moment is EI angle / l, l the mean of both lengths, and that of the clamp with half its own."""
    model = pp.Chain(rods=[ON_X | {"length": 0.6}, ON_X | {"at": 0.3}])
    dynamics = pp.bind(pp.Scene(model=model, effects=[fx.Bending(stiffness=2.0, clamp=(0, 0, -1))]))
    q = np.array([0.4, -0.9])
    assert dynamics.loads.torque is not None
    assert dynamics.loads.torque(0.0, q, 0 * q) == pytest.approx([-2.0 * 0.4 / 0.3, 2.0 * 0.9 / 0.8], rel=1e-12)


@pytest.mark.skipif(not llvm.installed(), reason="needs llvmlite")
def test_a_fit_recovers_a_mass(tmp_path: Path) -> None:
    model = pp.Chain(rods=[ON_X, ON_X | {"hangs_on": "rod_1", "at": 0.6, "mass": 0.8}])
    start = pp.Start(positions={"theta_1": 0.5, "theta_2": -0.9})
    true = pp.Scene(model=model, start=start, effects=[fx.Gravity(), fx.Viscous(coefficient=0.02)], duration=6.0)
    path = pp.simulate(true).to_csv(tmp_path / "data.csv", "theta_1", "theta_2")
    columns = {"theta_1": ["theta_1"], "theta_2": ["theta_2"]}
    guess = true.replace({"model.rods[1].mass": 1.0, "data.columns": columns, "data.offsets": "zero"})
    result = pp.fit(guess, path, free=["model.rods[1].mass"])
    assert result.scene.model.rods[1].mass == pytest.approx(0.8, rel=1e-4)


def test_other_questions_are_answered() -> None:
    """Lyapunov exponents, stability, the measures of sweeps: each of a tree of hinges."""
    acrobot = pp.Chain(rods=[ON_X, ON_X])
    scene = pp.Scene(model=acrobot, effects=[fx.Gravity()], start=pp.Start(positions={"theta_1": 2.5}), duration=4.0)
    table = pp.sweep(scene, vary={"model.rods[1].length": [0.5, 1.0]}, measure=["flip_time", "swing"])
    assert np.asarray(table["flip_time"]).shape == (2,)
    rest = pp.Start.at_rest(scene.replace(start=pp.Start(positions={"theta_1": 0.3})))
    assert [rest.positions[name] for name in ("theta_1", "theta_2")] == pytest.approx([0.0, 0.0], abs=1e-9)


# --- names, and what is refused ---------------------------------------------------------------------------------------


def test_names_of_one_hinge() -> None:
    """A single rod has theta or phi, with _1 too."""
    for rod, own in ((ON_X, "theta"), (ON_Y, "phi")):
        scene = pp.Scene(
            model=pp.Chain(rods=[rod]), start=pp.Start(positions={f"{own}_1": 0.5}), effects=[fx.Gravity()]
        )
        run = pp.simulate(scene, duration=0.5)
        assert run.joints == (own,)
        assert np.array_equal(run[own], run[f"{own}_1"])
        with pytest.raises(pp.InputError, match=own):
            pp.simulate(scene.replace(start=pp.Start(positions={"theta_2": 0.5})))


def test_a_mobile_rests_at_plain_zeros() -> None:
    """No angle of a rest is a number below the least that a double holds in full."""
    rods = [ON_X | {"mass": 0.5, "radius": 0.01}, {"length": 0.6, "mass": 0.0, "payload": 0.4, "at": 0.3}]
    rods += [{"length": 0.7, "mass": 0.0, "payload": 0.3, "hangs_on": "rod_1"}]
    rest = pp.Start.at_rest(moving(pp.Chain(rods=rods), fx.Gravity(), seed=3))
    assert all(x == 0.0 or abs(x) > 1e-300 for x in rest.positions.values())


def test_an_anchor_on_a_single_rod_runs() -> None:
    """The rod is called rod, and rod_1 too."""
    for link in ("rod", "rod_1"):
        anchor = fx.Anchor(link=link, point=(0.0, 0.3, -1.0), stiffness=5.0, damping=0.1)
        run = pp.simulate(moving(pp.Chain(rods=[ON_X]), fx.Gravity(), anchor, duration=0.5), energy_balance=True)
        assert run.imbalance < 1e-8


def test_copies_hang_on_each_other() -> None:
    chain = pp.Chain(rods=[ROD, ROD | {"hangs_on": "rod_1", "at": 0.2, "copies": 3}, ON_X | {"hangs_on": "rod_1"}])
    assert chain.parents == (-1, 0, 1, 2, 0)
    assert chain.places == (0.0, 0.2, 1.0, 1.0, 1.0)
    assert pp.Chain(rods=[ON_X, ON_X | {"at": 0.5}], copies=2).places == (0.0, 0.5, 1.0, 0.5)
    assert pp.Chain(rods=[ROD, ROD | {"hangs_on": "rod"}, ROD | {"hangs_on": "world"}]).parents == (-1, 0, -1)


REFUSED = [
    ([ROD, ROD | {"hangs_on": "rod_2"}], "model.rods[1].hangs_on: rod_2 hangs on itself"),
    ([ROD | {"hangs_on": "rod_1"}], "model.rods[0].hangs_on: rod_1 hangs on itself"),
    ([ROD, ROD | {"hangs_on": "rod_3"}, ROD], "rod_3, which is listed after it"),
    ([ROD | {"hangs_on": "rod_2"}, ROD | {"hangs_on": "rod_1"}], "nothing hangs in a circle"),
    ([ROD, ROD | {"hangs_on": "rod1"}], "did you mean 'rod_1'?"),
    ([ROD, ROD | {"hangs_on": "rod_7"}], "model.rods[1].hangs_on: 'rod_7' is not one of: world, rod_1"),
    ([ROD, ROD | {"hangs_on": ""}], "is not one of: world, rod_1"),
    ([ROD, ROD | {"hangs_on": 1}], "model.rods[1].hangs_on: 1 is not text"),
    ([ROD, ROD, ROD | {"hangs_on": "rod_1"}, ROD | {"hangs_on": "rod_2"}], "list a branch as a whole"),
    ([ROD, ROD | {"at": 1.5}], "model.rods[1].at: 1.5 m is beyond the tip of rod_1, at 1 m"),
    ([ROD, ROD | {"at": -0.1}], "model.rods[1].at: -0.1 is below 0"),
    ([ROD, ROD | {"at": math.nan}], "model.rods[1].at: nan is not a finite number"),
    ([ROD, ROD | {"at": math.inf}], "model.rods[1].at: inf is not a finite number"),
    ([ROD, ROD | {"at": "tip"}], "model.rods[1].at: 'tip' is not a number"),
    ([ROD | {"at": 0.5}], "model.rods[0].at: this rod hangs on the world"),
    ([ROD, ROD | {"at": 0.5, "hangs_on": "world"}], "model.rods[1].at: this rod hangs on the world"),
    ([ON_X | {"axis": "z"}], "model.rods[0].axis: 'z' is not one of: x, y"),
    ([ON_X | {"axis": [1, 0, 0]}], "is not one of: x, y"),
    ([ROD | {"axis": "x"}], 'model.rods[0]: axis = "x" is of a hinge'),
    ([ROD | {"joint": "ball"}], "a thin rod (radius 0) on a universal joint is a spherical pendulum"),
    ([ROD | {"joint": "spherical"}], "is a spherical pendulum"),
    ([ROD | {"joint": "fixed"}], "one rod with the com and inertia of both"),
    ([ROD | {"joint": "revolute"}], 'a revolute joint is called "hinge"'),
    ([ROD | {"joint": "prismatic"}], "a URDF's links do"),
    ([ROD | {"joint": "hinges"}], "did you mean 'hinge'?"),
    ([ROD | {"joint": None}], "None is not one of: universal, hinge"),
    ([ON_X | {"com": 0, "inertia": (0, 1, 1)}], "an inertia about it"),
    ([ON_Y | {"com": 0, "inertia": (1, 0, 1)}], "an inertia about it"),
    ([ROD, ROD | {"hang_on": "rod_1"}], "did you mean 'hangs_on'?"),
    ([ON_X | {"copies": 400}], "joints need about"),
]


@pytest.mark.parametrize(("rods", "says"), REFUSED)
def test_what_cannot_hang_is_refused_in_one_line(rods: list[dict[str, Any]], says: str) -> None:
    with pytest.raises(pp.InputError) as caught:
        pp.bind(pp.Scene(model={"kind": "chain", "rods": rods}))  # type: ignore[arg-type]
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_list_of_branches_is_not_repeated() -> None:
    with pytest.raises(pp.InputError, match="copies: a list with hangs_on is not repeated"):
        pp.Chain(rods=[ROD, ROD | {"hangs_on": "rod_1", "at": 0.5}], copies=3)
    with pytest.raises(pp.InputError, match="one rod on a universal joint"):
        pp.Start.conical(pp.Scene(model=pp.Chain(rods=[ON_X]), effects=[fx.Gravity()]), 0.5)

"""Scenes with trees and hinges: every route, what others publish and compute of the acrobot, modes by hand, the examples."""

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import eigh, solve_continuous_are

import pendpin as pp
from laws import HANG, law

EXAMPLES = Path(__file__).parents[1] / "examples"
GRAVITY = pp.effects.Gravity()
G = 9.81  # m/s²
UPRIGHT = [np.pi, 0.0]  # rad


def hinged(**rod) -> pp.Rod:
    """A rod on a hinge about x, unless `axis` says otherwise."""
    return pp.Rod(joint="hinge", **rod)


def scene_of(*rods: pp.Rod, **given) -> pp.Scene:
    """Rods under gravity."""
    return pp.Scene(model=pp.Chain(rods=rods), effects=[GRAVITY], **given)


# --- every route ------------------------------------------------------------------------------------------------------


@st.composite
def trees(draw: st.DrawFn) -> pp.Scene:
    """Up to eight rods of any sizes within two decades on joints of all kinds, perhaps with drag and torques."""
    sizes, rods, branch = st.floats(0.1, 10.0), list[pp.Rod](), list[int]()
    for i in range(draw(st.integers(1, 8))):
        branch = branch[: draw(st.integers(1, len(branch)))] if branch else []
        hung = {}
        if branch:
            at = draw(st.floats(0.0, 1.0)) * rods[branch[-1]].length
            hung = {"hangs_on": f"rod_{branch[-1] + 1}", "at": at}
        kind = draw(st.sampled_from([{}, {"joint": "hinge"}, {"joint": "hinge", "axis": "y"}]))
        rods.append(pp.Rod(length=draw(sizes), mass=draw(sizes), radius=draw(st.floats(0.01, 0.3)), **kind, **hung))
        branch = [*branch, i]
    loads = [pp.effects.Viscous(coefficient=0.3), pp.effects.Drag(wind=[1.0, 2.0, 0.5])] if draw(st.booleans()) else []
    return pp.Scene(model=pp.Chain(rods=rods), effects=[GRAVITY, *loads])


@law(8)
@given(trees())
def test_every_route_agrees_on_trees(scene: pp.Scene) -> None:
    """Pinocchio, the balances of the tree, the recursion and 50 digits, within the bounds that follow from condition."""
    report = pp.crosscheck(scene, states=3)
    assert report.ok, report.fault
    assert set(report.routes) >= {"pinocchio", "recursion"}
    assert len({"chain", "tree"} & set(report.routes)) == 1


# --- the acrobot ------------------------------------------------------------------------------------------------------


def test_the_regulator_of_drakes_acrobot() -> None:
    """The gain of Drake 1.51's BalancingLQRController, eight decimals: Q = diag(10, 10, 1, 1), R = 1, u at the elbow.

    Its parameters are Spong's: 1 kg and 1 m, 1 kg and 2 m, inertias 0.083 and 0.33 kg m², damping 0.1 N m s. An angle
    that is counted the other way round changes the sign of a state and of the torque, so the gain stays.
    """
    rods = [
        hinged(length=1.0, mass=1.0, inertia=(0.083, 0.083, 0.01)),
        hinged(length=2.0, mass=1.0, inertia=(0.33, 0.33, 0.01)),
    ]
    scene = scene_of(*rods).replace(effects=[GRAVITY, pp.effects.Viscous(coefficient=0.1)])
    linear = pp.linearize(scene, at=pp.Start(positions=UPRIGHT))
    B = linear.B[:, [linear.inputs.index("torque_theta_2")]]
    gain = B.T @ solve_continuous_are(linear.A, B, np.diag([10.0, 10.0, 1.0, 1.0]), np.eye(1))
    assert np.abs(gain - [-278.44223126, -112.29125985, -119.72457377, -56.82824017]).max() < 1e-7


@pytest.mark.parametrize(("axis", "angles"), [("x", ("theta_1", "theta_2")), ("y", ("phi_1", "phi_2"))])
def test_hinges_move_as_universal_joints_in_their_plane(axis: str, angles: tuple[str, str]) -> None:
    """The same motion and tension with one angle a rod as with two of which one stays 0: planes of x and of y."""
    sizes = {"length": 1.0, "mass": 1.0, "radius": 0.05}, {"length": 2.0, "mass": 0.7, "radius": 0.03}
    given = {"start": pp.Start(positions=dict(zip(angles, (1.8, 0.6), strict=True))), "duration": 3.0}
    solver = pp.Solver(method="dop853", tolerance=1e-12, samples=31)
    hinge = pp.simulate(scene_of(*(hinged(axis=axis, **size) for size in sizes), **given, solver=solver))
    both = pp.simulate(scene_of(*(pp.Rod(**size) for size in sizes), **given, solver=solver))
    assert hinge.joints == angles
    for name in (*angles, "R1_1", "R2_2", "R3_1", "R3_2", "tip_z", "energy"):
        assert np.abs(hinge[name] - both[name]).max() < 1e-8 * max(1.0, np.abs(both[name]).max()), name
    assert hinge.energy().drift < 1e-10


# --- modes by hand ----------------------------------------------------------------------------------------------------


def test_the_modes_of_a_mobile() -> None:
    """A carrier with two equal pendulums at one point and a third at its tip, all on hinges about x, thin rods.

    In absolute angles M has the inertia about the joints on its diagonal and m h d beside it, with d the place of the
    joint along the carrier; K is diagonal. The two equal ones have a mode of their own, in which the carrier rests.
    """
    length, mass, place = np.array([2.0, 0.8, 0.8, 0.5]), np.array([1.5, 0.4, 0.4, 0.3]), np.array([0.0, 0.7, 0.7, 2.0])
    rods = [hinged(length=length[0], mass=mass[0])]
    rods += [hinged(length=x, mass=m, hangs_on="rod_1", at=d) for x, m, d in zip(length, mass, place, strict=True) if d]
    M, moments = np.diag(mass * length**2 / 3), mass * length / 2
    M[0, 0] += (mass * place**2).sum()
    M[0, 1:] = M[1:, 0] = moments[1:] * place[1:]
    K = G * np.diag(moments + np.append((mass * place).sum(), np.zeros(3)))
    omega = np.sqrt(eigh(K, M, eigvals_only=True))
    assert pp.modes(scene_of(*rods)).omega == pytest.approx(omega, rel=1e-12)
    assert np.abs(omega - np.sqrt(1.5 * G / 0.8)).min() < 1e-12


# --- the examples -----------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_the_acrobot_swings_up(tmp_path: Path) -> None:
    """examples/acrobot.py runs as written; the work of the hip is that of the height, as it comes to rest."""
    done = subprocess.run(
        [sys.executable, EXAMPLES / "acrobot.py"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=HANG,
        check=True,
    )
    assert done.stderr == ""
    work, height = (float(number) for number in re.findall(r"([\d.]+) J", done.stdout))
    assert work == pytest.approx(height, abs=0.2)
    assert (tmp_path / "acrobot.png").exists()


def test_the_crane_with_two_loads() -> None:
    """Its sling swings along x alone, and the rope carries the weight of all when the loads have come to rest."""
    scene = pp.load_scene(EXAMPLES / "two_loads.toml")
    run = pp.simulate(scene)
    assert run.joints == ("theta_1", "phi_1", "theta_2", "phi_2", "phi_3")
    weight = sum(rod.mass + rod.payload for rod in scene.model.rods) * G
    assert pp.simulate(scene.replace(start=pp.Start()), duration=0.1)["R3_1"] == pytest.approx(weight, rel=1e-12)

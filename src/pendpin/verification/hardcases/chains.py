"""Chains whose neighbours differ much in mass or length, and chains of many rods."""

from functools import cache, partial
from typing import Any

import numpy as np

from pendpin.equations.base import split_by_rod
from pendpin.equations.chain import solution
from pendpin.ground.arrays import EPS, Array
from pendpin.model.bodies import pinocchio
from pendpin.model.build import build
from pendpin.motions.simulate import simulate
from pendpin.scene import Chain, Rod, Scene, Solver
from pendpin.verification.hardcases.base import ROD, Case, Solve, case, drift_of, scene, settings

# --- ratios ---------------------------------------------------------------------------------------------------------


Scale = tuple[tuple[float, float], ...]  # mass in kg and length in m of each rod


def _swinging(sizes: Scale, duration: float) -> Scene:
    model = Chain(rods=tuple(Rod(length=length, mass=mass, radius=0.02 * length) for mass, length in sizes))
    return scene(model, q=np.resize([0.4, 0.2, 0.3, -0.1], 2 * len(sizes)), duration=duration, samples=11)


@cache
def _solve_by_reactions(sizes: Scale, duration: float) -> Array:
    """The tips (n, rods, 3) in m by the chain equations (reactions as the unknowns), at a tight tolerance."""
    solver = Solver(engine="chain", method="dop853", tolerance=1e-12, samples=11)
    return simulate(_swinging(sizes, duration).model_copy(update={"solver": solver})).tips


def _ratio(solve: Solve, full: bool, sizes: Scale, most: float, short: float) -> float:
    duration = most if full else short
    apart = solve(_swinging(sizes, duration)).tips - _solve_by_reactions(sizes, duration)
    relative = np.diff(apart, axis=1, prepend=0.0)  # of each rod's tip to its own joint
    return float((np.linalg.norm(relative, axis=-1) / [length for _, length in sizes]).max())


def _unlike(name: str, sizes: Scale, tolerance: float, most_steps: int, growth: float, **span: float) -> Case:
    return case(
        name,
        bound=tolerance * most_steps * growth,
        methods=settings(auto=tolerance) | (settings(taylor=1e-14) if len(sizes) == 2 else {}),
        measure=partial(_ratio, sizes=sizes, **span),
        tolerance=tolerance,
        most_steps=most_steps,
        growth=growth,
    )


# --- many rods ------------------------------------------------------------------------------------------------------

HUNDRED = Chain(rods=(ROD,), copies=100)


def tumbling(model: Chain, duration: float) -> Scene:
    """A chain with random angles and rates."""
    random = np.random.default_rng(0)
    q, v = random.normal(size=(2, 2 * model.count))
    return scene(model, q=0.3 * q, v=v, duration=duration, samples=3)


def _states(model: Chain) -> Array:
    return np.random.default_rng(1).uniform(-1, 1, (2, 3, 2 * model.count))


def _accelerations(model: Chain, q: Array, v: Array) -> Array:
    """(k, 2n) by the chain equations."""
    inertia = build(model).chain
    assert inertia is not None
    angles, rates = split_by_rod(q), split_by_rod(v)
    return solution.solve(inertia, angles, rates, np.array([0.0, 0.0, 9.81])).acceleration.reshape(q.shape)


def _digits(solve: Solve, full: bool) -> float:
    """The largest difference of the accelerations of runs from random states to the chain equations, over the largest."""
    starts = [scene(HUNDRED, q=q, v=v, duration=0.0) for q, v in zip(*_states(HUNDRED), strict=True)]
    accelerations = np.array([solve(start).a[0] for start in (starts if full else starts[:1])])
    q, v = _states(HUNDRED)
    exact = _accelerations(HUNDRED, q, v)[: len(accelerations)]
    return float(np.abs(accelerations - exact).max() / np.abs(exact).max())


def _other_joints() -> dict[str, float]:
    """The figure for Pinocchio's own joints of two and three degrees of freedom."""
    pin = pinocchio()
    x, y = np.eye(3)[:2]
    kinds = {"pin Universal": pin.JointModelUniversal(-x, -y), "pin Spherical": pin.JointModelSpherical()}
    words = {word: getattr(pin.Convention, word) for word in ("LOCAL", "WORLD")}
    return {f"{name}, {word}": _torque_error(kinds[name], words[word]) for name in kinds for word in words}


def _torque_error(joint: Any, convention: Any) -> float:
    """The largest torque that rnea computes for the accelerations of aba, over the torque that holds the chain."""
    pin = pinocchio()
    model, parent, (m, h, *principal) = pin.Model(), 0, ROD.properties
    body = pin.Inertia(m, np.array([0, 0, -h]), np.diag(principal))
    for i in range(HUNDRED.count):
        place = pin.SE3(np.eye(3), np.array([0.0, 0.0, -ROD.length if i else 0.0]))
        parent = model.addJoint(parent, joint, place, str(i))
        model.appendBodyToJoint(parent, body, pin.SE3.Identity())
    data, random, none = pin.Data(model), np.random.default_rng(1), [pin.Force.Zero()] * model.njoints
    step, v = random.uniform(-1, 1, (2, model.nv))
    q = pin.integrate(model, pin.neutral(model), step)
    a = pin.aba(model, data, q, v, 0 * v, none, convention)
    left = np.abs(pin.rnea(model, data, q, v, a)).max()
    return float(left / np.abs(pin.rnea(model, data, q, 0 * v, 0 * v)).max())


def whip(n: int, duration: float) -> Scene:
    """A chain of n thin rods, 1 m long, released level and at rest."""
    model = Chain(rods=(Rod(length=1 / n, mass=1 / n),), copies=n)
    return scene(model, q=(np.pi / 2,), duration=duration, samples=31)


def _whip(solve: Solve, full: bool) -> float:
    return solve(whip(40, 0.9) if full else whip(12, 0.3)).energy().drift


ONE, LIGHT, HEAVY, SHORT = (1.0, 1.0), (1e-6, 1.0), (1e6, 1.0), (1.0, 1e-4)  # kg, m

CASES = (
    _unlike("mass-light-below", (ONE, LIGHT), 1e-11, 1000, 100, most=3.0, short=1.0),
    _unlike("mass-light-above", (LIGHT, ONE), 1e-11, 1000, 100, most=3.0, short=1.0),
    _unlike("mass-heavy-below", (ONE, HEAVY), 1e-11, 1000, 100, most=3.0, short=1.0),
    _unlike("mass-mixed", (ONE, LIGHT, ONE, HEAVY), 1e-10, 1000, 100, most=0.3, short=0.05),
    _unlike("length-short-below", (ONE, SHORT), 1e-11, 2000, 100, most=0.5, short=0.05),
    _unlike("length-short-above", (SHORT, ONE), 1e-9, 2000, 1000, most=0.2, short=0.05),
    case(
        "chain-100",
        bound=1e-9 * 1000 * 10,
        methods=settings(auto=1e-9),
        measure=drift_of(partial(tumbling, HUNDRED), long=0.5, short=0.02),
    ),
    case("chain-100-digits", bound=200 * 100 * EPS, methods=settings(auto=None), measure=_digits, beside=_other_joints),
    case(
        "chain-2000",
        bound=1e-8 * 1000 * 10,
        methods=settings(auto=1e-8),
        measure=drift_of(partial(tumbling, Chain(rods=(ROD,), copies=2000)), long=0.02, short=0.001),
    ),
    case("whip", bound=1e-10 * 2000 * 100, methods=settings(auto=1e-10, rk45=1e-10), measure=_whip),
)

"""The cross-check: the same states by every route, and the largest difference of every pair of routes."""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path

import numpy as np

from pendpin.dynamics.dynamics import Dynamics, bind, loads_at
from pendpin.errors import InputError
from pendpin.ground.arguments import count
from pendpin.ground.arrays import TINY, Array, Indices
from pendpin.motions.crosschecks.report import CheckReport, CheckRow
from pendpin.motions.crosschecks.rounding_scale import tree_scale
from pendpin.motions.crosschecks.routes import (
    REFERENCE,
    Answer,
    HandRoute,
    engine_routes,
    hand_routes,
    other_joints,
    reference_route,
)
from pendpin.scene import Scene
from pendpin.trajectory import RunRecord

BOUND = 1e-13  # of the rounding scale, for each rod through which errors propagate
LARGEST_RATE = 100.0  # rad/s
ALONG_JOINTS = 1_200  # states times joints that are compared along a run: about a second
POLE = 1e-6  # of cos(phi): at poles of thin rods theta moves nothing, and the mass matrix keeps four digits here
REFERENCE_JOINTS = 400  # states times joints that the reference_route is given: some seconds


def crosscheck(
    scene: Scene | str | Path,
    states: int = 1000,
    seed: int = 0,
    routes: Mapping[str, HandRoute] | None = None,
) -> CheckReport:
    """Compare the independent routes to the accelerations and reactions of a scene at random states.

    Angles are any, rates up to 100 rad/s. The worst states are computed in 50 digits too.

    Args:
        scene: a Scene, or the path of a TOML file.
        states: how many.
        seed: of the random states.
        routes: functions of your own for a single rod, by name. f(rod, q, v, field) returns {quantity: values (states,)}
            for any of theta_dd, phi_dd, R1, R2, R3, M3, Mc. It gets a RodInertia, q and v (states, 2), and the uniform
            field (3,) m/s² in the inertial frame I (z down).

    Returns:
        The report: the worst difference for each pair of routes and each quantity.

    Raises:
        InputError: where fewer than two routes cover the model.
    """
    states, seed = count("states", states), count("seed", seed, least=0)
    dynamics, random = bind(scene), np.random.default_rng(seed)
    nv = len(dynamics.model.joints)
    q, v = random.uniform(-np.pi, np.pi, (states, nv)), random.uniform(-LARGEST_RATE, LARGEST_RATE, (states, nv))
    return compare(dynamics, q, v, routes or {}, in_50_digits=max(2, REFERENCE_JOINTS // nv))


def crosscheck_run(trajectory: RunRecord) -> CheckReport | None:
    """The same comparison at some states of a run; None where no two routes cover its model at any of them."""
    try:
        scene = Scene(**trajectory.scene)
    except InputError:  # an effect that a scene file cannot name: a user's own class
        return None
    dynamics = bind(scene)
    if dynamics.model.pin is None:
        return None
    thin = [rod.phi for rod in dynamics.model.rods if rod.inertia is not None and rod.inertia.I3 == 0]
    regular = np.flatnonzero((np.abs(np.cos(trajectory.q[:, thin])) > POLE).all(1))
    most = max(8, ALONG_JOINTS // len(trajectory.joints))
    chosen = regular[:: max(1, -(-len(regular) // most))]
    if not len(chosen):
        return None
    return compare(dynamics, trajectory.q[chosen], trajectory.v[chosen], {}, in_50_digits=0)


def run_verdict(trajectory: RunRecord) -> str:
    """What `crosscheck_run` says, in a few words; "" where nothing covers the run, or its model is gone."""
    try:
        report = crosscheck_run(trajectory)
    except InputError:
        return ""
    return report.verdict if report else ""


@np.errstate(over="ignore", invalid="ignore", divide="ignore")  # numbers that overflow differ and are reported
def compare(
    dynamics: Dynamics, q: Array, v: Array, users_routes: Mapping[str, HandRoute], in_50_digits: int
) -> CheckReport:
    """The report on states q, v (n, nv) by all routes, with some of them compared with 50 digits."""
    by_hand = _one_free_rod(dynamics)
    if users_routes and not by_hand:
        raise InputError(
            "routes: your own routes need a single rod on a universal joint, its centre of mass on its axis"
        )
    if dynamics.model.pin is None:
        raise InputError(f"{len(dynamics.model.joints)} joints are too many for Pinocchio: no second route to compare")
    routes = engine_routes(dynamics) | (hand_routes(dynamics, users_routes) if by_hand else {})
    try:
        answers = {name: route(q, v) for name, route in routes.items()}
        sizes = _sizes(dynamics, q, v, answers["pinocchio"])
    except np.linalg.LinAlgError:
        raise InputError("no cross-check: masses or lengths differ too much for a mass matrix in doubles") from None
    states = _States(np.arange(len(q)), q, v, sizes, _places(dynamics))
    rows = [row for pair in combinations(answers, 2) for row in _rows(pair, answers, states)]
    if in_50_digits:
        chosen = _worst_states(answers, sizes, in_50_digits)
        answers = {name: {k: x[chosen] for k, x in answer.items()} for name, answer in answers.items()}
        answers |= {REFERENCE: dict(reference_route(dynamics)(q[chosen], v[chosen]))}
        sizes, in_50_digits = {k: x[chosen] for k, x in sizes.items()}, len(chosen)
        states = _States(chosen, q[chosen], v[chosen], sizes, states.places)
        rows += [row for name in routes for row in _rows((name, REFERENCE), answers, states)]
    return CheckReport(tuple(rows), len(q), in_50_digits, tuple(routes), states.bound)


def _one_free_rod(dynamics: Dynamics) -> bool:
    """Whether the hand routes for one rod apply: a single rod on its axis, and fields alone."""
    model, loads = dynamics.model, dynamics.loads
    one = len(model.joints) == 2 and len(model.rods) == 1 and model.rods[0].inertia is not None
    return one and loads.torque is None and loads.wrench is None


@dataclass(frozen=True, eq=False)
class _States:
    """The states of a comparison, their rounding scales, and the names of each quantity's columns."""

    index: Indices  # (n,)
    q: Array  # (n, nv)
    v: Array
    sizes: dict[str, Array]  # quantity -> (n, places)
    places: dict[str, list[str]]

    @property
    def bound(self) -> float:
        """BOUND for every rod, or two joints, through which rounding errors propagate."""
        return BOUND * max(1, self.q.shape[1] / 2)


def _sizes(dynamics: Dynamics, q: Array, v: Array, reference: Answer) -> dict[str, Array]:
    """The size of each quantity (n, k) at states q, v (n, nv), to which differences are compared; SI units."""
    model = dynamics.model
    keys = ("theta_dd", "phi_dd") if "theta_dd" in reference else ("acceleration",)
    a = np.concatenate([reference[key] for key in keys], -1)
    scale = tree_scale(model, dynamics.loads.field(0.0), q, v, a, *loads_at(dynamics, q, v))
    at, others = [rod.phi for rod in model.rods], other_joints(model)
    sizes = dict(zip(keys, np.split(scale.acceleration, len(keys), -1), strict=True))
    sizes |= dict.fromkeys(("R1", "R2", "R3"), scale.force[:, at])
    sizes |= dict.fromkeys(("M3", "Mc"), scale.moment[:, at])
    return sizes | {name: np.repeat(getattr(scale, name)[:, others], 3, -1) for name in ("force", "moment")}


def _places(dynamics: Dynamics) -> dict[str, list[str]]:
    model = dynamics.model
    rods = [rod.link for rod in model.rods]
    others = [f"{model.joints[joint]} {axis}" for joint in other_joints(model) for axis in "xyz"]
    places = {"theta_dd": rods, "phi_dd": rods, "acceleration": list(model.joints), "force": others, "moment": others}
    return places | dict.fromkeys(("R1", "R2", "R3", "M3", "Mc"), rods)


def _relative(first: Array, second: Array, size: Array) -> Array:
    """Differences over rounding scales (n, places); the numbers may be of the reference route."""
    with np.errstate(invalid="ignore"):  # NaN is an answer too, and a broken one
        return np.abs(first - second).astype(float) / np.maximum(size, TINY)


def _worst_states(answers: Mapping[str, Answer], sizes: dict[str, Array], count: int) -> Indices:
    """The states (m,) at which routes differ most, half of the count, and the first ones; sizes are (n, k) each."""
    n = len(next(iter(sizes.values())))
    worst = np.zeros(n)
    for one, other in combinations(answers.values(), 2):
        for quantity in one.keys() & other.keys():
            worst = np.fmax(worst, _relative(one[quantity], other[quantity], sizes[quantity]).max(-1))
    return np.unique([*np.argsort(worst)[-max(1, count // 2) :], *range(min(n, count - count // 2))])


def _rows(pair: tuple[str, str], answers: Mapping[str, Answer], states: _States) -> list[CheckRow]:
    one, other = (answers[name] for name in pair)
    return [_row(quantity, pair, one[quantity], other[quantity], states) for quantity in one if quantity in other]


def _row(quantity: str, pair: tuple[str, str], first: Array, second: Array, states: _States) -> CheckRow:
    """The largest difference of two routes in one quantity, from their answers (n, k)."""
    size = states.sizes[quantity]
    relative = _relative(first, second, size)
    i, j = np.unravel_index(int(np.argmax(np.where(np.isnan(relative), np.inf, relative))), relative.shape)
    ulps = float(relative[i, j] * size[i, j] / np.spacing(max(size[i, j], TINY)))
    state = (int(states.index[i]), tuple(states.q[i].tolist()), tuple(states.v[i].tolist()))
    return CheckRow(quantity, states.places[quantity][j], *pair, float(relative[i, j]), ulps, *state, states.bound)

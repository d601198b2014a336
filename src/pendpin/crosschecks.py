"""The routes side by side: the same states through every route, the worst difference of every pair."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from pendpin.derivations import balances, lagrange, newton_euler
from pendpin.derivations.base import Array, RodInertia, RodSolution
from pendpin.bodies import RodJoint
from pendpin.dynamics import Dynamics, bind, reactions
from pendpin.engines import Revolute
from pendpin.errors import InputError
from pendpin.scene import Scene
from pendpin.trajectory import Trajectory

Solution = Mapping[str, Array]  # some or all of the quantities of RodSolution, by name
Route = Callable[[RodInertia, Array, Array, Array], Solution]

BOUND = 1e-13  # of the terms that enter: a hundred roundings or so
LARGEST_RATE = 100.0  # rad/s


@dataclass(frozen=True)
class Row:
    """The worst difference between two routes in one quantity."""

    quantity: str
    first: str
    second: str
    relative: float  # to the sum of the sizes of the terms that enter the quantity
    ulps: float  # of that sum
    state: int  # where: index of the state
    q: tuple[float, ...]
    v: tuple[float, ...]

    @property
    def ok(self) -> bool:
        """Whether the difference is within BOUND; a NaN is not."""
        return self.relative <= BOUND


@dataclass(frozen=True)
class Report:
    """A cross-check: one row for each quantity and pair of routes."""

    rows: tuple[Row, ...]
    states: int
    routes: tuple[str, ...]
    bound: float = BOUND

    @property
    def ok(self) -> bool:
        """Whether every row is within the bound."""
        return all(row.ok for row in self.rows)

    @property
    def fault(self) -> str | None:
        """What is broken, as one line that names the quantities, the suspect and the worst state; None if all is ok."""
        broken = [row for row in self.rows if not row.ok]
        if not broken:
            return None
        quantities = ", ".join(dict.fromkeys(row.quantity for row in broken))
        suspects = [name for name in self.routes if all(name in (row.first, row.second) for row in broken)]
        who = f"{suspects[0]} disagrees" if len(suspects) == 1 else "the routes disagree"
        worst = self.worst
        return (
            f"{who} in {quantities}; worst: {worst.quantity}, {worst.first} against {worst.second}, by "
            f"{worst.relative:.2g} of its terms (bound {self.bound:g}) at q = {_numbers(worst.q)}, v = {_numbers(worst.v)}"
        )

    @property
    def worst(self) -> Row:
        """The row with the largest relative difference, NaN above all."""
        return max(self.rows, key=lambda row: np.inf if np.isnan(row.relative) else row.relative)


def _numbers(values: tuple[float, ...]) -> str:
    return "(" + ", ".join(f"{value:.6g}" for value in values) + ")"


def crosscheck(scene: Scene, states: int = 1000, seed: int = 0, routes: Mapping[str, Route] | None = None) -> Report:
    """Compare the routes on random states: all angles, rates up to 100 rad/s.

    `routes` adds the user's own: name -> f(rod, q, v, field) -> {quantity: values (states,)}, for any of theta_dd,
    phi_dd, R1, R2, R3, M3, Mc; rod is a RodInertia, q, v are (states, 2), the uniform field (3,) is in the inertial
    frame I (z down). Raises InputError for a model that the hand routes do not cover.
    """
    if states < 1:
        raise InputError(f"states: {states} is not a count of 1 or more")
    dynamics = bind(scene)
    random = np.random.default_rng(seed)
    nv = len(dynamics.model.joints)
    q = random.uniform(-np.pi, np.pi, (states, nv))
    return _compare(dynamics, q, random.uniform(-LARGEST_RATE, LARGEST_RATE, (states, nv)), routes or {})


def along(trajectory: Trajectory) -> Report | None:
    """The same comparison at the states of a run; None where the hand routes do not cover its model."""
    dynamics = bind(Scene(**trajectory.scene))
    return _compare(dynamics, trajectory.q, trajectory.v, {}) if covered(dynamics) else None


def covered(dynamics: Dynamics) -> bool:
    """Whether the hand routes for one rod apply to a model."""
    rods = dynamics.model.rods
    return len(dynamics.model.joints) == 2 and len(rods) == 1 and rods[0].inertia is not None


def _compare(dynamics: Dynamics, q: Array, v: Array, own: Mapping[str, Route]) -> Report:
    if not covered(dynamics):
        raise InputError("the hand routes need one rod on a universal joint, its centre of mass on its axis")
    rod = dynamics.model.rods[0]
    inertia = rod.inertia
    assert inertia is not None
    turn = np.array([rod.sign, 1.0])
    hand_q, hand_v, field = q * turn, v * turn, rod.base.T @ dynamics.loads.field(0.0)
    reference = _pinocchio(dynamics, rod, q, v)
    solutions: dict[str, Solution] = {"pinocchio": reference._asdict()}
    for name, route in (_HAND_ROUTES | dict(own)).items():
        solutions[name] = route(inertia, hand_q, hand_v, field)
    sizes = term_sizes(inertia, hand_q, hand_v, field, reference)
    rows = [
        _row(quantity, pair, solutions, sizes, q, v)
        for quantity in RodSolution._fields
        for pair in combinations(solutions, 2)
        if all(quantity in solutions[name] for name in pair)
    ]
    return Report(tuple(rows), len(q), tuple(solutions))


def _lagrange(rod: RodInertia, q: Array, v: Array, field: Array) -> Solution:
    theta_dd, phi_dd = np.moveaxis(lagrange.accelerations(rod, q, v, field), -1, 0)
    return {"theta_dd": theta_dd, "phi_dd": phi_dd}


_HAND_ROUTES: dict[str, Route] = {
    "newton-euler": lambda *given: newton_euler.solve(*given)._asdict(),
    "balances": lambda *given: balances.solve(*given)._asdict(),
    "lagrange": _lagrange,
}


def _pinocchio(dynamics: Dynamics, rod: RodJoint, q: Array, v: Array) -> RodSolution:
    a, wrench = Revolute(dynamics.model, dynamics.loads).evaluate(np.zeros(len(q)), q, v)
    found = reactions(dynamics.model, q, wrench)
    assert found is not None
    return RodSolution(rod.sign * a[:, rod.theta], a[:, rod.phi], *(column[:, 0] for column in found))


def term_sizes(rod: RodInertia, q: Array, v: Array, field: Array, solution: RodSolution) -> RodSolution:
    """The sum of the absolute terms that enter each quantity: what its rounding errors are relative to.

    Taken from the balances of docs/derivation.md, section 3, with every product of components counted by its size.
    """
    m, h, I1, I2, I3 = rod._replace(h=abs(rod.h))
    J1, J2 = I1 + m * h * h, I2 + m * h * h
    (s_t, s), (c_t, c) = np.abs(np.sin(q)).T, np.abs(np.cos(q)).T
    dt, dp = np.abs(v).T
    gx, gy, gz = np.abs(field)
    along = s_t * gy + c_t * gz
    G1, G2, G3 = c * gx + s * along, c_t * gy + s_t * gz, s * gx + c * along
    alpha1 = np.abs(solution.theta_dd) * c + dt * dp * s
    alpha2 = np.abs(solution.phi_dd)
    alpha3 = np.abs(solution.theta_dd) * s + dt * dp * c

    theta_dd = c * (2 * (J1 + I3) * dt * dp * s + m * h * G2) / (J1 * c**2 + I3 * s**2)
    phi_dd = (m * h * G1 + (J1 + I3) * dt**2 * s * c) / J2
    R1 = m * (h * (alpha2 + dt**2 * s * c) + G1)
    R2 = m * (h * (alpha1 + dt * dp * s) + G2)
    R3 = m * (h * (dp**2 + dt**2 * c**2) + G3)
    moment1 = J1 * alpha1 + (I3 + J2) * dt * dp * s + m * h * G2
    moment3 = I3 * alpha3 + (J1 + J2) * dt * dp * c
    Mc = s * moment1 + c * moment3
    return RodSolution(theta_dd, phi_dd, R1, R2, R3, Mc * c, Mc)


def _row(
    quantity: str, pair: tuple[str, str], solutions: dict[str, Solution], sizes: RodSolution, q: Array, v: Array
) -> Row:
    first, second = (np.asarray(solutions[name][quantity], float) for name in pair)
    size = np.maximum(getattr(sizes, quantity), np.finfo(float).tiny)
    relative = np.abs(first - second) / size
    worst = int(np.argmax(np.where(np.isnan(relative), np.inf, relative)))
    ulps = np.abs(first - second)[worst] / np.spacing(size[worst])
    return Row(quantity, *pair, float(relative[worst]), float(ulps), worst, tuple(q[worst]), tuple(v[worst]))

"""The cross-check: the same states by every route, and the largest difference of every pair of routes."""

from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass
from itertools import combinations
from pathlib import Path

import numpy as np

from pendpin.dynamics.dynamics import Dynamics, bind, loads_at
from pendpin.equations.base import exact
from pendpin.errors import InputError, choices, shown
from pendpin.ground.arguments import whole_number
from pendpin.ground.arrays import TINY, Array, Indices
from pendpin.ground.report import Report, Result, Table
from pendpin.motions.crosschecks.routes import (
    REFERENCE,
    Answer,
    HandRoute,
    engine_routes,
    hand_routes,
    other_joints,
    recursion_route,
    tree_scale,
)
from pendpin.scene import Scene, scene_of
from pendpin.trajectory import HingeReactions, RunRecord

BOUND = 1e-13  # of the rounding scale, for each rod through which errors propagate
LARGEST_RATE = 100.0  # rad/s
MOST_STATES = 10_000_000  # compared at once: some gigabytes
ALONG_JOINTS = 1_200  # states times joints that are compared along a run: about a second
POLE = 1e-6  # of cos(phi): at poles of thin rods theta moves nothing, and the mass matrix keeps four digits here
REFERENCE_JOINTS = 400  # states times joints that the recursion in 50 digits is given: some seconds


@dataclass(frozen=True)
class CheckRow:
    """The worst difference between two routes in one quantity."""

    quantity: str
    place: str  # the joint or rod
    first: str
    second: str
    relative: float  # to the rounding scale of the quantity (pendpin.motions.crosschecks.routes)
    ulps: float  # of that scale
    state: int  # where: index of the state
    q: tuple[float, ...]
    v: tuple[float, ...]
    bound: float

    @property
    def ok(self) -> bool:
        """Whether the difference is within the bound; False for NaN."""
        return self.relative <= self.bound


def _badness(row: CheckRow) -> float:
    return np.inf if np.isnan(row.relative) else row.relative


@dataclass(frozen=True, repr=False)
class CheckReport(Result):
    """A cross-check: one row for each quantity and pair of routes."""

    rows: tuple[CheckRow, ...]
    states: int
    in_50_digits: int  # how many of the states the recursion in 50 digits was given
    routes: tuple[str, ...]
    bound: float

    def report(self, every_pair: bool = False) -> Report:
        """The matrix of routes and quantities, and the verdict in words; before it, if asked for, every pair."""
        pairs = []
        for row in self.rows if every_pair else ():
            figures = f"{row.relative:.1e}", f"{row.ulps:.1f}", str(row.state), "ok" if row.ok else "BROKEN"
            pairs.append((row.quantity, row.place, f"{row.first} / {row.second}", *figures))
        head = ("quantity", "of", "routes", "relative", "ulps", "state", "")
        few, n, against = self.in_50_digits, self.states, REFERENCE if self.in_50_digits else self.routes[0]
        where = f"at {few} of the {n} states, the worst among them" if few else f"at {n} states"
        each = f"each route against {against} {where}; any two at all {n}"
        words = [f"Largest differences, divided by the size of the terms: {each}."]
        if in_50_digits := [row for row in self.rows if REFERENCE in (row.first, row.second)]:
            row = max(in_50_digits, key=_badness)
            name = row.first if row.second == REFERENCE else row.second
            units = f"{row.ulps:.1f} units in the last place in {row.quantity} of {row.place}"
            words.append(f"Farthest from {REFERENCE}: {name}, {units}.")
        if self.ok:
            who = "Both" if len(self.routes) == 2 else f"All {len(self.routes)}"
            words.append(f"{who} routes agree: no difference is above {self.bound:g}, the bound for rounding errors.")
        else:
            words.append(f"BROKEN: the routes do not agree; ! marks differences above the bound {self.bound:g}.")
        # a line for each route with its worst difference in each quantity (! beyond the bound, - where none)
        quantities, lines = list(dict.fromkeys(row.quantity for row in self.rows)), []
        lines_of = {name: [r for r in self.rows if {name, against} == {r.first, r.second}] for name in self.routes}
        lines_of.pop(against, None)
        lines_of["any two"] = [row for row in self.rows if REFERENCE not in (row.first, row.second)]
        for name, rows in lines_of.items():
            cells = []
            for quantity in quantities:
                worst = max((row for row in rows if row.quantity == quantity), key=_badness, default=None)
                cells.append(f"{'' if worst.ok else '!'}{worst.relative:.0e}" if worst else "-")
            lines.append((name[:12], *cells))  # those of users may be long
        tables = [*[Table(head, pairs)] * every_pair, Table(("", *quantities), lines)]
        return Report((*tables, *words), asdict(self) | {"ok": self.ok}, self.fault)

    @property
    def ok(self) -> bool:
        """Whether every row is within the bound."""
        return all(row.ok for row in self.rows)

    @property
    def worst(self) -> CheckRow:
        """The row with the largest relative difference, NaN above all."""
        return max(self.rows, key=_badness)

    @property
    def verdict(self) -> str:
        """What a comparison along a run says, in a few words."""
        end = "ok" if self.ok else "BROKEN"
        return (
            f"two formulations agree to {self.worst.relative:.1e} (worst: {self.worst.quantity}), {end}, along the run"
        )

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
        q, v = (f"({choices((f'{x:.6g}' for x in y), 6)})" for y in (worst.q, worst.v))
        return (
            f"{who} in {quantities}; worst: {worst.quantity} of {worst.place}, {worst.first} against {worst.second}, by "
            f"{worst.relative:.2g} of its terms (bound {self.bound:g}), at state {worst.state}: q = {q}, v = {v}"
        )


def crosscheck(
    scene: Scene | str | Path, states: int = 1000, seed: int = 0, routes: Mapping[str, HandRoute] | None = None
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
    states, seed = whole_number("states", states, most=MOST_STATES), whole_number("seed", seed, least=0)
    if routes is not None and not (isinstance(routes, Mapping) and all(map(callable, routes.values()))):
        raise InputError(f"routes: {shown(routes)} is not a mapping of names to functions (rod, q, v, field)")
    dynamics, random = bind(scene), np.random.default_rng(seed)
    nv = len(dynamics.model.joints)
    q, v = random.uniform(-np.pi, np.pi, (states, nv)), random.uniform(-LARGEST_RATE, LARGEST_RATE, (states, nv))
    return compare(dynamics, q, v, routes or {}, in_50_digits=max(2, REFERENCE_JOINTS // nv))


def crosscheck_run(trajectory: RunRecord) -> CheckReport | None:
    """The same comparison at some states of a run; None where no two routes cover its model, or this is gone."""
    # a saved run has effects of a user's own that no file can name; or masses differ too much
    with suppress(InputError):
        dynamics = bind(scene_of(trajectory))
        universal = (rod for rod in dynamics.model.rods if rod.kind == "universal")
        thin = [rod.phi for rod in universal if rod.inertia is not None and rod.inertia.I3 == 0]
        regular = np.flatnonzero((np.abs(np.cos(trajectory.q[:, thin])) > POLE).all(1))
        most = max(8, ALONG_JOINTS // len(trajectory.joints))
        chosen = regular[:: max(1, -(-len(regular) // most))]
        if len(chosen):
            return compare(dynamics, trajectory.q[chosen], trajectory.v[chosen], {}, in_50_digits=0)
    return None


def run_verdict(trajectory: RunRecord) -> str:
    """What `crosscheck_run` says, in a few words; "" where it says nothing."""
    report = crosscheck_run(trajectory)
    return report.verdict if report else ""


@np.errstate(over="ignore", invalid="ignore", divide="ignore")  # numbers that overflow differ and are reported
def compare(
    dynamics: Dynamics, q: Array, v: Array, users_routes: Mapping[str, HandRoute], in_50_digits: int
) -> CheckReport:
    """The report on states q, v (n, nv) by all routes, with some of them compared with 50 digits."""
    model, loads = dynamics.model, dynamics.loads
    one = len(model.joints) == 2 and len(model.rods) == 1 and model.rods[0].inertia is not None
    by_hand = one and loads.torque is None and loads.wrench is None  # a single rod on its axis, and fields alone
    if users_routes and not by_hand:
        need = "need a single rod on a universal joint, its centre of mass on its axis"
        raise InputError(f"routes: your own routes {need}")
    if model.pin is None:
        raise InputError(f"{len(model.joints)} joints are too many for Pinocchio: no second route to compare")
    routes = engine_routes(dynamics) | (hand_routes(dynamics, users_routes) if by_hand else {})
    try:
        answers = {name: route(q, v) for name, route in routes.items()}
        sizes = _sizes(dynamics, q, v, answers["pinocchio"])
    except np.linalg.LinAlgError:
        raise InputError("no cross-check: masses or lengths differ too much for a mass matrix in doubles") from None

    others = [f"{model.joints[joint]} {axis}" for joint in other_joints(model) for axis in "xyz"]
    places = {"acceleration": list(model.joints), "force": others, "moment": others}
    places |= {name: [rod.link for rod in model.rods] for name in ("theta_dd", "phi_dd", *HingeReactions._fields)}
    bound = BOUND * max(1, q.shape[1] / 2)  # for every rod, or two joints, through which rounding errors propagate

    def compare_pairs(pairs: Iterable[tuple[str, str]], answers: Mapping[str, Answer], at: Indices) -> list[CheckRow]:
        rows = []  # the largest difference, at some of the states, in each quantity that both routes of a pair give
        for pair in pairs:
            one, other = (answers[name] for name in pair)
            for quantity in (name for name in one if name in other):
                size = sizes[quantity][at]
                relative = _relative_difference(one[quantity], other[quantity], size)
                i, j = np.unravel_index(int(np.argmax(np.where(np.isnan(relative), np.inf, relative))), relative.shape)
                ulps = float(relative[i, j] * size[i, j] / np.spacing(max(size[i, j], TINY)))
                where = int(at[i]), tuple(q[at[i]].tolist()), tuple(v[at[i]].tolist())
                rows.append(CheckRow(quantity, places[quantity][j], *pair, float(relative[i, j]), ulps, *where, bound))
        return rows

    rows = compare_pairs(combinations(answers, 2), answers, np.arange(len(q)))
    if in_50_digits:  # the states at which routes differ most, half of these, and the first ones
        worst = np.zeros(len(q))
        for one, other in combinations(answers.values(), 2):
            for name in one.keys() & other.keys():
                worst = np.fmax(worst, _relative_difference(one[name], other[name], sizes[name]).max(-1))
        first = range(min(len(q), in_50_digits - in_50_digits // 2))
        chosen = np.unique([*np.argsort(worst)[-max(1, in_50_digits // 2) :], *first])
        answers = {name: {k: x[chosen] for k, x in answer.items()} for name, answer in answers.items()}
        answers |= {REFERENCE: dict(recursion_route(dynamics, exact(50))(q[chosen], v[chosen]))}
        rows += compare_pairs(((name, REFERENCE) for name in routes), answers, chosen)
        in_50_digits = len(chosen)
    return CheckReport(tuple(rows), len(q), in_50_digits, tuple(routes), bound)


def _sizes(dynamics: Dynamics, q: Array, v: Array, reference: Answer) -> dict[str, Array]:
    """The size of each quantity (n, k) at states q, v (n, nv), to which differences are compared; SI units."""
    model = dynamics.model
    keys = ("theta_dd", "phi_dd") if "theta_dd" in reference else ("acceleration",)
    a = np.concatenate([reference[key] for key in keys], -1)
    scale = tree_scale(model, dynamics.loads.field(0.0), q, v, a, *loads_at(dynamics, q, v))
    at, others = [rod.last for rod in model.rods], other_joints(model)
    sizes = dict(zip(keys, np.split(scale.acceleration, len(keys), -1), strict=True))
    sizes |= {name: (scale.force if name.startswith("R") else scale.moment)[:, at] for name in HingeReactions._fields}
    return sizes | {name: np.repeat(getattr(scale, name)[:, others], 3, -1) for name in ("force", "moment")}


def _relative_difference(first: Array, second: Array, size: Array) -> Array:
    """Differences over rounding scales (n, places); the numbers may be of the reference route."""
    return np.abs(first - second).astype(float) / np.maximum(size, TINY)  # NaN is an answer too, and a broken one

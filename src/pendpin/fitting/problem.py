"""What a fit solves: measured pieces, the scene that shall explain them, residuals and their exact derivatives.

The motions are those of the scene, from stick to slip and back, and the derivatives are integrated beside them
(pendpin.motions.variations). Joints that stay at rest, as phi does in a plane swing, are left out.
"""

from contextlib import suppress
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from scipy.optimize import lsq_linear

from pendpin.dynamics.binding import Binding
from pendpin.dynamics.compiling import EquationsOfMotion, staying_zero
from pendpin.dynamics.contacts import Mode
from pendpin.dynamics.derivatives import differentiable
from pendpin.dynamics.dynamics import choose_engine
from pendpin.effects import ContactEffect, DryFriction
from pendpin.engines.machine import llvm
from pendpin.errors import InputError, RunError
from pendpin.fitting.data import Batch, Sensors, tips_at
from pendpin.fitting.parameters import Free, substitute
from pendpin.fitting.uncertainty import RANK
from pendpin.ground.arrays import Array, Mask
from pendpin.model.build import Model, build, start_state
from pendpin.motions.variations import Variations, list_state_keys
from pendpin.scene import Scene, Solver, Start

MOST_START_STEPS = 6
STARTS_DONE = 1e-4  # of the sum of squares: what another step of the starts would gain
POLISHED = 0.01  # of the noise of one residual: what another step would gain of the sum of squares
LONGEST = 3.0  # natural scales: the first step, within which residuals are nearly linear
TOLERANCE = 1e-10  # of the motions; pieces magnify it a thousandfold at most, and sensors show 1e-5 rad
EVALUATIONS, FEW = 2000, 10  # at most, for each time scale of the data and some more; good models take 100
MOST_KEPT = 256  # motions with the same numbers: a quarter is asked for again, of one search by the next
LOST = 1e6  # a residual that is no number, in units of the weights
HOLD = 1e-3  # weight of the guess, in units of the noise, for what the data do not determine
ASIDE = 1e-5  # rad, or of a number: half of a difference of tips


@dataclass(frozen=True, eq=False)
class Pendulum:
    """A scene whose free numbers are search coordinates z (nz,), with its n joints that move."""

    scene: Scene  # with the guesses; its start is at rest, at the first time of the data
    model: Model  # of it
    free: Free
    sensors: Sensors
    moving: tuple[int, ...]  # joints, in model order
    home: Array  # (n,) rad, their positions at the start that the scene says
    places: list[int]  # (2n,) of these in a state: of their angles, then of their rates
    pace: float  # s, the time scale of the data
    last: "list[Bound]" = field(default_factory=list)  # the one that was asked for last

    def at(self, z: Array) -> "Bound":
        """The scene with its numbers at search coordinates (nz,), its changes being those with them and with the start."""
        # One search begins where the one before it ended: three in five times the numbers are those of the last call, and
        # binding them takes 10 ms.
        if self.last and np.array_equal(self.last[0].z, z):
            return self.last[0]
        scene = substitute(self.scene, self.free.keys, self.free.values(z))
        starts = list_state_keys(len(self.model.joints))
        keys = [*self.free.keys, *(starts[place] for place in self.places)]
        still = tuple(i for i in range(len(starts)) if i not in self.places)
        self.last[:] = [Bound(self, z.copy(), Variations(scene, keys, still), self.free.gradients(z))]
        return self.last[0]


@dataclass(frozen=True, eq=False)
class Bound:
    """A pendulum with certain numbers, ready to move."""

    pendulum: Pendulum
    z: Array  # (nz,)
    variations: Variations
    gradients: Array  # (K, nz), of the free numbers by the search coordinates
    moved: dict[tuple[bytes, bytes], tuple[Array, Array]] = field(default_factory=dict)  # by start and times

    def move(self, start: Array, times: Array) -> tuple[Array, Array]:
        """The motion (M, nv) from a start (2n,) at times (M,) in s, and its derivatives (D, M, nv). Raises RunError."""
        if (known := self.moved.get((start.tobytes(), times.tobytes()))) is not None:
            return known
        nv, places = self.variations.nv, self.pendulum.places
        y = np.zeros(2 * nv)
        y[places] = start
        w = self.variations.equations.starts
        states, changes = self.variations.follow(
            *(y, w, times - self.pendulum.scene.start.time, TOLERANCE, np.full(w.size, np.inf)),
            most=EVALUATIONS * (FEW + (times[-1] - times[0]) / self.pendulum.pace),
        )
        motion = states[:, :nv], self._by_coordinates(changes.transpose(1, 0, 2)[..., :nv])
        if len(self.moved) == MOST_KEPT:
            self.moved.pop(next(iter(self.moved)))
        self.moved[start.tobytes(), times.tobytes()] = motion
        return motion

    def accelerate(self, t: Array, q: Array, v: Array) -> tuple[Array, Array]:
        """Accelerations (n, N) of joints that slide, by q, v (n, N) at times (N,) in s, and derivatives (nz + 2n, n, N)."""
        equations, places, nv, N = self.variations.equations, self.pendulum.places, self.variations.nv, len(t)
        n, w = len(q), equations.starts
        y = np.zeros((N, 1 + len(w), 2 * nv))
        y[:, 0, places] = np.concatenate([q, v]).T
        y[:, 1:] = w
        y, rates = y.reshape(N, -1), np.empty((N, y[0].size))
        ways = np.zeros((N, nv))
        if equations.contacts is not None:
            ways = np.sign(y[:, nv : 2 * nv]) * (equations.contacts.static > 0)
        for way in np.unique(ways, axis=0):
            some = (ways == way).all(1)
            if equations.contacts is not None:
                equations.contacts.enter(Mode(np.zeros(nv, bool), way, np.zeros(nv)))
            rates[some] = equations.block.evaluated((t - self.pendulum.scene.start.time)[some], y[some])[0]
        a = rates.reshape(N, -1, 2 * nv)[..., places[n:]].transpose(1, 2, 0)
        return a[0], self._by_coordinates(a[1:])

    def measure(self, start: Array, times: Array) -> tuple[Array, Array]:
        """What the sensors show of a motion without their zeros (M, columns), and its derivatives (M, columns, D)."""
        sensors, free, z, (q, by) = self.pendulum.sensors, self.pendulum.free, self.z, self.move(start, times)
        values, slopes = q @ sensors.angles.T, by @ sensors.angles.T
        if not sensors.tips.any():
            return values, slopes.transpose(1, 2, 0)
        of_tips = []
        for direction, change in enumerate(by):  # central differences in closed form
            dz, size = np.zeros(len(z)), np.abs(change).max(initial=0.0)
            if direction < len(z):
                dz[direction], size = 1.0, max(size, 1 / abs(z[direction]) if z[direction] else 1.0)
            h, sides = ASIDE / (size or 1.0), []
            for side in (h, -h):
                moved = substitute(self.pendulum.scene, free.keys, free.values(z + side * dz), checked=False)
                sides.append(tips_at(build(moved.model), q + side * change))
            of_tips.append((sides[0] - sides[1]) / (2 * h))
        values = values + tips_at(self.variations.equations.model, q) @ sensors.tips.T
        return values, (slopes + np.array(of_tips) @ sensors.tips.T).transpose(1, 2, 0)

    def _by_coordinates(self, by: Array) -> Array:
        """Derivatives (D, ...) by search coordinates and start, from those (K + 2n, ...) by the free numbers and start."""
        K = len(self.gradients)
        return np.concatenate([np.tensordot(self.gradients, by[:K], (0, 0)), by[K:]])


def bind_pendulum(scene: Scene, free: Free, sensors: Sensors, begin: float, end: float, pace: float) -> Pendulum:
    """The pendulum of a scene from `begin` to `end` in s, without joints that stay at rest. InputError, MissingLibrary."""
    llvm.require("a fit")
    for i, effect in enumerate(scene.effects):
        if isinstance(effect, ContactEffect) and not isinstance(effect, DryFriction):
            raise InputError(f"effects[{i}]: a fit does not take {effect.kind}: measure swings that do not touch it")
    scene = substitute(scene, free.keys, free.guess)
    moved = scene.replace(start=Start(time=begin), duration=end - begin, solver=Solver(samples=2))
    model = build(scene.model)
    q, v = start_state(model, scene.start)
    resting = [j for j in range(len(q)) if j not in sensors.joints and q[j] == v[j] == 0]
    present = substitute(moved, free.keys, np.where(free.guess == 0, 1.0, free.guess), checked=False)  # none is 0
    effects, some = differentiable(present), build(present.model)
    engine = choose_engine(some, Binding(some, effects, begin).loads, "auto", "angles")
    equations = EquationsOfMotion(engine, effects, begin)
    still = staying_zero(equations, [part * len(q) + j for part in range(2) for j in resting])
    moving = tuple(j for j in range(len(q)) if j not in still or len(q) + j not in still)
    if not moving:
        raise InputError("data.columns: no joint moves them from zero; measure a tip's x or y, or give start.positions")
    places = [part * len(q) + j for part in range(2) for j in moving]
    return Pendulum(moved, model, free, sensors, moving, q[list(moving)], places, pace)


class Residuals(NamedTuple):
    """Weighted residuals of P pieces with M samples, and their derivatives; 0 where nothing was measured."""

    r: Array  # (P, M columns)
    by_start: Array  # (P, M columns, 2n)
    by_unknowns: Array  # (P, M columns, nx), the starts being held


@dataclass(frozen=True, eq=False)
class Problem:
    """Measured pieces, the pendulum that shall explain them, and what each residual counts.

    The unknowns x (nx,) are the search coordinates z (nz,), then the offsets of the columns if these are free.
    """

    pendulum: Pendulum
    batch: Batch
    weights: Array  # (columns,) 1/rad or 1/m
    scale: Array  # (nx,) natural sizes of the unknowns: they change accelerations by one hundredth
    lower: Array  # (nx,)
    upper: Array  # (nx,)
    prior: Array  # (nx,) the guess, to which what the data do not determine is held
    offsets: Array  # (columns,) those of columns whose offsets are not free
    still: Mask  # (nx,) unknowns that stay where they are
    share: Array | float = 1.0  # (M, columns, P) of each residual

    @property
    def nz(self) -> int:
        """The number of search coordinates."""
        return len(self.pendulum.free.start)

    def split(self, x: Array) -> tuple[Array, Array]:
        """The search coordinates (nz,) and the offsets (columns,)."""
        return x[: self.nz], x[self.nz :] if len(x) > self.nz else self.offsets

    def show(self, x: Array, starts: Array, t: Array) -> Array:
        """What the sensors show at unknowns (nx,), (M, columns, C), from starts (2n, C) at times t (M, C); else infinite."""
        bound, out = self.pendulum.at(self.split(x)[0]), np.full((len(t), len(self.weights), t.shape[1]), np.inf)
        for piece, times in enumerate(t.T):
            count = 1 + int((np.diff(times) > 0).sum())
            with suppress(RunError):
                values, _ = bound.measure(starts[:, piece], times[:count])
                out[:count, :, piece] = values + self.split(x)[1]
                out[count:, :, piece] = out[count - 1, :, piece]
        return out

    def evaluate(self, x: Array, starts: Array, some: Mask | None = None) -> Residuals:
        """The residuals at unknowns (nx,) from starts (2n, P), of some pieces (P,) or of all. Raises InputError."""
        z, offsets = self.split(x)
        bound = self.pendulum.at(z)
        chosen = np.arange(starts.shape[1]) if some is None else np.flatnonzero(some)
        M, columns, _ = self.batch.y.shape
        share = np.broadcast_to(self.share, self.batch.y.shape)
        r = np.zeros((len(chosen), M, columns))
        J = np.zeros((len(chosen), M, columns, len(z) + len(starts)))
        free = np.zeros((len(chosen), M, columns, len(x) - len(z)))
        for row, piece in enumerate(chosen.tolist()):
            times, y = self.batch.t[:, piece], self.batch.y[..., piece]
            count, seen = 1 + int((np.diff(times) > 0).sum()), ~np.isnan(y)
            weight = seen * self.weights * share[..., piece]
            free[row] = weight[..., None] * np.eye(columns)[:, : len(x) - len(z)]
            try:
                values, slopes = bound.measure(starts[:, piece], times[:count])
            except RunError:
                r[row] = LOST * seen
                continue
            off = np.where(seen[:count], values + offsets - y[:count], 0.0) * weight[:count]
            r[row, :count] = np.where(np.abs(off) < LOST, off, LOST)
            J[row, :count] = slopes * weight[:count, :, None]
        J, free = (part.reshape(len(chosen), M * columns, -1) for part in (np.nan_to_num(J), free))
        by_unknowns = np.concatenate([J[..., : len(z)], free], -1)
        by_unknowns[..., self.still] = 0.0
        return Residuals(r.reshape(len(chosen), -1), J[..., len(z) :], by_unknowns)


# --- the search: least squares over physics and offsets, the starts of all pieces being solved for at every step ----


@dataclass(frozen=True, eq=False)
class Solved:
    """The starts at some unknowns, the residuals there, and the basis of what the starts explain."""

    starts: Array  # (2n, P)
    r: Array  # (P, M columns)
    Q: Array  # (P, M columns, 2n)
    R_inverse: Array  # (P, 2n, 2n)
    J: Array  # (P, M columns, nx), the derivatives by the unknowns, the starts being held

    def rest(self, J: Array) -> Array:
        """What the starts cannot explain of residuals or derivatives (P, M columns, ...)."""
        return J - self.Q @ (self.Q.transpose(0, 2, 1) @ J)

    @property
    def unexplained(self) -> Array:
        """The residuals (P, M columns, 1) that no start explains."""
        return self.rest(self.r[..., None])

    @property
    def follow(self) -> Array:
        """The derivatives (P, 2n, nx) of the starts that explain the data best by the unknowns."""
        return -(self.R_inverse @ (self.Q.transpose(0, 2, 1) @ self.J))


def solve_starts(problem: Problem, x: Array, starts: Array, steps: int = MOST_START_STEPS) -> Solved:
    """The starts (2n, P) that explain the data best at unknowns x: Gauss-Newton, piece by piece, halved where worse."""

    def basis(J: Array) -> tuple[Array, Array]:  # Q (P, R, 2n) and the inverse of U (P, 2n, 2n) of J = Q U (P, R, 2n)
        Q, R = np.linalg.qr(np.nan_to_num(J))
        return Q, np.linalg.pinv(R, rcond=1e-12)

    r, by_start, J = problem.evaluate(x, starts)
    pace, starts = np.ones(starts.shape[1]), starts.copy()
    for _ in range(steps):
        Q, inverse = basis(by_start)
        seen = (Q.transpose(0, 2, 1) @ r[:, :, None])[:, :, 0]  # (P, 2n)
        cost = (r**2).sum(1)
        some = (seen**2).sum(1) > STARTS_DONE * cost.mean()
        if not some.any():
            break
        tried = starts - pace * (inverse @ seen[:, :, None])[:, :, 0].T
        new = problem.evaluate(x, tried, some)
        better = some.copy()
        better[some] = (new.r**2).sum(1) <= cost[some]
        took = better[some]
        starts[:, better] = tried[:, better]
        r[better], by_start[better], J[better] = (part[took] for part in new)
        pace = np.where(better, np.minimum(1.0, 2 * pace), np.where(some, pace / 4, pace))
    return Solved(starts, r, *basis(by_start), J)


def search(p: Problem, x: Array, starts: Array, most: int, tolerance: float = 0.0) -> tuple[Array, Solved, Array]:
    """The best unknowns (nx,) from x and starts (2n, P), the starts there, and what of the derivatives they do not explain.

    Gauss-Newton steps, `most` of them, within the bounds and a box that grows where they succeed, until a step would gain
    less than `tolerance` of the sum of squares.
    """
    at, reach = solve_starts(p, x, starts), LONGEST
    pull = HOLD * (x - p.prior) / p.scale  # of the guess
    cost, J = float((at.unexplained**2).sum() + (pull**2).sum()), at.rest(at.J)
    for _ in range(most):
        # The best step for linear residuals within the bounds and the box, and its gain.
        Q, R = np.linalg.qr(np.concatenate([J.reshape(-1, len(x)) * p.scale, HOLD * np.eye(len(x))]))
        seen = Q.T @ np.concatenate([at.unexplained.reshape(-1), pull])
        damped = np.concatenate([R, RANK * np.linalg.norm(R, axis=0).max() * np.eye(len(x))])
        below, above = (p.lower - x) / p.scale, (p.upper - x) / p.scale
        bounds = (np.clip(below, -reach, -1e-12), np.clip(above, 1e-12, reach))
        step = lsq_linear(damped, np.concatenate([-seen, np.zeros(len(x))]), bounds, method="bvls").x
        gain = float((seen**2).sum() - ((seen + R @ step) ** 2).sum())
        if gain < max(POLISHED, tolerance * cost):
            break
        dx = np.clip(x + p.scale * step, p.lower, p.upper) - x
        tried = x + dx
        try:
            new = solve_starts(p, tried, at.starts + at.follow.transpose(1, 0, 2) @ (tried - x))
        except InputError:  # no scene has such numbers: a rod without any mass
            reach = np.abs(dx / p.scale).max() / 4
            continue
        new_pull = HOLD * (tried - p.prior) / p.scale
        new_cost = float((new.unexplained**2).sum() + (new_pull**2).sum())
        if new_cost < cost:
            x, at, cost, pull, J, reach = tried, new, new_cost, new_pull, new.rest(new.J), 2 * reach
        else:
            reach = np.abs(dx / p.scale).max() / 4
    return x, at, J

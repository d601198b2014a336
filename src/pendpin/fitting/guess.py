"""Where a search starts: the time scale of the data, states by local polynomials, physics by equation error."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import least_squares, lsq_linear

from pendpin.fitting.data import Swing, tips_at
from pendpin.fitting.problem import Pendulum, Problem
from pendpin.ground.arrays import Array
from pendpin.model.build import Model
from pendpin.motions.periodic import wrap

INTERPOLATED = 2 / 3  # of the variance of noise, on average, is left between the samples
# Weight of equal accelerations against nearness: a natural scale that changes them by less than 1e-7 is free.
SAME = 1e7
REACH = 3.0  # natural scales: a step within which accelerations are nearly linear
FAR_OFF = 1e3  # times the accelerations: an error, or none that is a number
ENOUGH = 1e-3  # of the sum of squares: what a step gains that still pays
PULL = 1e-3  # weight of the guess
STARTS = 12  # of the search for angles, for each sample of tips
ALIKE = 1e-6  # rad or m: joint angles, or tips, that differ by less are the same
BESIDE = 0.3  # rad: joint angles farther from those of the sample before are searched for from there too


def time_to_move(t: Array, y: Array, noise: float) -> float:
    """The time in s in which a column y (m,) at t (m,) s moves by half its standard deviation, less its noise."""
    seen = ~np.isnan(y)
    t, y = t[seen], y[seen]
    if len(t) < 4 or np.ptp(y) == 0:
        return np.inf
    grid = np.linspace(t[0], t[-1], max(64, min(4 * len(t), 20_000)))
    even, spacing = np.interp(grid, t, y), grid[1] - grid[0]
    noise_left = INTERPOLATED * noise**2
    for lag in range(1, len(grid) // 2):
        if np.mean((even[lag:] - even[:-lag]) ** 2) - 2 * noise_left >= 0.25 * (even.var() - noise_left):
            return lag * spacing
    return (t[-1] - t[0]) / 2


def fit_cubics(swing: Swing, at: Array, rows: Array) -> tuple[Array, Array, Array]:
    """Values, rates and accelerations (N, columns) at instants (N,) by cubics through the samples `rows` (N, W)."""
    s = swing.t[rows] - at[:, None]
    size = np.abs(s).max() or 1.0
    powers, parts = (s / size)[:, :, None] ** np.arange(4), []
    for k in range(swing.y.shape[1]):
        y = swing.y[rows, k]
        seen = ~np.isnan(y)
        basis = powers * seen[:, :, None]
        parts.append((np.linalg.pinv(basis, rcond=1e-9) @ np.where(seen, y, 0.0)[:, :, None])[:, :, 0])
    c = np.array(parts)  # (columns, N, 4)
    return c[:, :, 0].T, c[:, :, 1].T / size, 2 * c[:, :, 2].T / size**2


class Regression(NamedTuple):
    """Smoothed states of all swings at N instants, for equation error: model accelerations less measured ones."""

    pendulum: Pendulum
    shift: Array  # (n, columns): joint angles are those of the points less shift times the offsets
    t: Array  # (N,) s
    y: Array  # (N, n) joint angles and their rates
    rate: Array
    measured: Array  # (n N,) their accelerations

    def accelerations(self, x: Array) -> tuple[Array, Array]:
        """What the equations say, (n N,), at unknowns (nx,), and its derivatives (n N, nx)."""
        nz = len(self.pendulum.free.start)
        offsets = x[nz:] if len(x) > nz else np.zeros(self.shift.shape[1])
        q, v = self.y.T - (self.shift @ offsets)[:, None], self.rate.T
        with np.errstate(all="ignore"):
            a, by = self.pendulum.at(x[:nz]).accelerate(self.t, q, v)
        of_offsets = -np.einsum("jnN,jc->cnN", by[nz : nz + len(q)], self.shift)
        J = np.concatenate([by[:nz], of_offsets[: len(x) - nz]])
        return a.reshape(-1), J.reshape(len(x), -1).T


def joint_angles(pendulum: Pendulum, swings: Sequence[Swing], z: Array) -> tuple[Swing, ...]:
    """The swings of the joints that move (n,), from the columns without offsets; z (nz,) gives the rods' lengths."""
    sensors, moving = pendulum.sensors, list(pendulum.moving)
    if not sensors.tips.any():
        inverse = np.linalg.pinv(sensors.angles[:, moving])
        return tuple(s._replace(y=s.y @ inverse.T) for s in swings)
    model = pendulum.at(z).variations.equations.model
    return tuple(s._replace(y=_angles_from_tips(pendulum, model, s)) for s in swings)


def _angles_from_tips(pendulum: Pendulum, model: Model, swing: Swing) -> Array:
    """Joint angles (m, n) that bring tips where they were measured: Gauss-Newton from several starts, sample by sample.

    Several positions may do so: theta + pi and pi - phi turn a rod as theta and phi do, and x and y alone say nothing of
    above and below. Of these it is the one nearest to the scene's start, then the nearest to the sample before.
    """
    sensors, moving = pendulum.sensors, list(pendulum.moving)
    n, m, draw = len(moving), len(swing.t), np.random.default_rng(0)
    whole = ~np.isnan(swing.y).any(1)

    def off(q: Array, y: Array) -> Array:  # columns at joint angles (C, n) less the measured ones (C, columns)
        angles = np.zeros((len(q), sensors.angles.shape[1]))
        angles[:, moving] = q
        return angles @ sensors.angles.T + tips_at(model, angles) @ sensors.tips.T - y

    def reach(q: Array, y: Array) -> tuple[Array, Array]:  # from joint angles (C, n), with the sums of squares (C,)
        for _ in range(20):
            r = off(q, y)
            J = np.stack([(off(q + 1e-6 * unit, y) - r) / 1e-6 for unit in np.eye(n)], -1)  # (C, columns, n)
            step = np.linalg.pinv(J, rcond=1e-6) @ r[..., None]
            q = q - np.clip(step[..., 0], -1.0, 1.0)
        return q, (off(q, y) ** 2).sum(1)

    def distance(q: Array, squares: Array) -> Array:  # (C,) rad from the last ones; of a worse fit inf
        return np.where(squares <= 4 * squares.min() + ALIKE**2, np.abs(wrap(q - last)).max(1), np.inf)

    y = np.repeat(np.nan_to_num(swing.y), STARTS, 0)  # (m STARTS, columns)
    q, squares = reach(np.tile(draw.uniform(-np.pi, np.pi, (STARTS, n)), (m, 1)), y)
    q, squares = q.reshape(m, STARTS, n), squares.reshape(m, STARTS)
    angles, last = np.full((m, n), np.nan), pendulum.home
    for k in np.flatnonzero(whole):
        one, fit = q[k], squares[k]
        if (away := distance(one, fit)).min() > BESIDE:  # perhaps none of the starts came there
            one, fit = map(np.append, (one, fit), reach(last[None], swing.y[k : k + 1]), (0, 0))
            away = distance(one, fit)
        last = angles[k] = one[np.argmin(np.where(away <= away.min() + ALIKE, fit, np.inf))]
    angles[whole] = np.unwrap(wrap(angles[whole]), axis=0)
    return angles


def regress(samples: Regression, p: Problem) -> Array:
    """The unknowns (nx,) that explain the measured accelerations best: robust least squares, a tenth of a second."""
    size = np.sqrt(np.mean(samples.measured**2)) or 1.0

    def evaluate(x: Array) -> tuple[Array, Array]:  # residuals: accelerations less the measured ones over their size
        a, J = samples.accelerations(np.where(p.still, p.prior, x))
        off = (a - samples.measured) / size
        fine = np.abs(off) < FAR_OFF  # nor is it NaN
        J = np.where(fine[:, None] & ~p.still, np.nan_to_num(J) / size, 0.0)
        pull = PULL * (x - p.prior) / p.scale
        return np.concatenate([np.where(fine, off, FAR_OFF), pull]), np.concatenate([J, np.diag(PULL / p.scale)])

    options: Any = {"x_scale": p.scale, "loss": "soft_l1", "f_scale": 0.05, "max_nfev": 40, "ftol": ENOUGH}
    options |= {"jac": lambda x: evaluate(x)[1], "bounds": (p.lower, p.upper)}
    best = least_squares(lambda x: evaluate(x)[0], np.clip(p.prior, p.lower, p.upper), **options).x
    return np.where(p.still, p.prior, best)


def nearest_to_guess(samples: Regression, p: Problem, x: Array, sizes: Array) -> Array:
    """The unknowns (nx,) nearest to the guess in units of its size with the accelerations of x (nx,); x where that fails."""
    aim, y = samples.accelerations(x)[0], x
    weight = SAME / (np.linalg.norm(aim) or 1.0)
    for _ in range(30):
        a, J = samples.accelerations(y)
        Q, R = np.linalg.qr(np.concatenate([weight * J * sizes, np.eye(len(x))]))
        goal = Q.T @ np.concatenate([weight * (aim - a), (p.prior - y) / sizes])
        reach = np.minimum(REACH * p.scale, np.maximum(np.abs(y), sizes) / 2) / sizes
        bounds = np.clip((p.lower - y) / sizes, -reach, -1e-12), np.clip((p.upper - y) / sizes, 1e-12, reach)
        step = lsq_linear(R, goal, bounds, method="bvls").x
        y = np.clip(y + sizes * step, p.lower, p.upper)
        if np.abs(step).max() < 1e-9:
            break
    same = np.linalg.norm(samples.accelerations(y)[0] - aim) * weight < 1.0
    return y if same else x

"""Where a search starts: the time scale of the data, states by local polynomials, physics by equation error."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.optimize import least_squares, lsq_linear

from pendpin.fitting.data import Swing
from pendpin.fitting.equations import Equations
from pendpin.ground.arrays import Array, Mask

MOST_POINTS = 1_000  # of the regression
ONE_PERCENT = 0.01
INTERPOLATED = 2 / 3  # of the variance of noise, on average, is left between the samples
# Weight of equal accelerations against nearness: a natural scale that changes them by less than 1e-7 is free.
SAME = 1e7
REACH = 3.0  # natural scales: a step within which accelerations are nearly linear
NEAREST = 30  # steps at most towards the guess
STARTS = 12  # of the search for angles, for each sample of tips


class Smoothed(NamedTuple):
    """Columns at N instants, smoothed: values, rates, accelerations (N, columns)."""

    t: Array  # (N,) s
    y: Array
    rate: Array
    acceleration: Array


def time_scale(swings: Sequence[Swing], noise: Array) -> float:
    """The time in s in which the fastest column moves by half its standard deviation, about half a radian of phase.

    noise (columns,) is not counted as a motion.
    """
    return min(_moves(swing.t, swing.y[:, k], noise[k]) for swing in swings for k in range(swing.y.shape[1]))


def _moves(t: Array, y: Array, noise: float) -> float:
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


def smoothed(swing: Swing, width: float, points: int) -> Smoothed:
    """A swing's columns at about `points` instants, by cubics over `width` s to either side."""
    m = len(swing.t)
    reach = int(np.clip(np.ceil(width / np.median(np.diff(swing.t))), 3, (m - 1) // 2))
    centres = np.unique(np.linspace(reach, m - 1 - reach, min(points, m - 2 * reach)).astype(int))
    rows = centres[:, None] + np.arange(-reach, reach + 1)
    return _cubics(swing, swing.t[centres], rows)


def first_state(swing: Swing, width: float) -> tuple[Array, Array]:
    """The columns (columns,) and their rates at a swing's first instant, by cubics over the first 2 `width` s."""
    count = int(np.clip((swing.t <= swing.t[0] + 2 * width).sum(), 5, len(swing.t)))
    cubics = _cubics(swing, swing.t[:1], np.arange(count)[None])
    return cubics.y[0], cubics.rate[0]


def _cubics(swing: Swing, at: Array, rows: Array) -> Smoothed:
    """Cubics through the samples `rows` (N, W), at instants (N,)."""
    s = swing.t[rows] - at[:, None]
    size = np.abs(s).max() or 1.0
    powers = (s / size)[:, :, None] ** np.arange(4)
    parts = []
    for k in range(swing.y.shape[1]):
        y = swing.y[rows, k]
        seen = ~np.isnan(y)
        basis = powers * seen[:, :, None]
        parts.append((np.linalg.pinv(basis, rcond=1e-9) @ np.where(seen, y, 0.0)[:, :, None])[:, :, 0])
    c = np.array(parts)  # (columns, N, 4)
    return Smoothed(at, c[:, :, 0].T, c[:, :, 1].T / size, 2 * c[:, :, 2].T / size**2)


class Regression(NamedTuple):
    """Smoothed states of all swings, for equation error: model accelerations less measured ones."""

    equations: Equations
    shift: Array  # (n, columns): joint angles are those of the points less shift times the offsets
    points: Smoothed  # joint angles

    def accelerations(self, z: Array, offsets: Array) -> Array:
        """What the equations say, (n, N), at search coordinates (nz,) and offsets (columns,)."""
        q, v = self.points.y.T - (self.shift @ offsets)[:, None], self.points.rate.T
        way = np.sign(v[list(self.equations.rubbing)])
        pars = np.concatenate([np.repeat(z[:, None], q.shape[1], 1), way])
        return self.equations.rate(np.vstack([q, v, self.points.t]), pars)

    @property
    def measured(self) -> Array:
        """The accelerations (n, N) by local polynomials."""
        return self.points.acceleration.T


def regression(equations: Equations, shift: Array, swings: Sequence[Swing], width: float) -> Regression:
    """Smoothed states of swings of joint angles; shift (n, columns), width in s."""
    each = max(8, MOST_POINTS // len(swings))
    parts = zip(*(smoothed(swing, width, each) for swing in swings), strict=True)
    points = Smoothed(*(np.concatenate(part) for part in parts))
    some = np.isfinite(points.acceleration).all(1)
    return Regression(equations, shift, Smoothed(*(part[some] for part in points)))


def joint_angles(equations: Equations, sensors: Array, swings: Sequence[Swing], z: Array) -> tuple[Swing, ...]:
    """The swings of the joints that move (n,), from the columns without offsets; z (nz,) gives the rods' lengths."""
    if sensors.shape[1] == len(equations.joints):
        inverse = np.linalg.pinv(sensors)
        return tuple(s._replace(y=s.y @ inverse.T) for s in swings)
    return tuple(s._replace(y=_angles_from_tips(equations, sensors, s, z)) for s in swings)


def _angles_from_tips(equations: Equations, sensors: Array, swing: Swing, z: Array) -> Array:
    """Joint angles (m, n) that bring tips where they were measured: Gauss-Newton from several starts, sample by sample."""
    n, m, draw = len(equations.joints), len(swing.t), np.random.default_rng(0)
    y = np.repeat(np.nan_to_num(swing.y.T), STARTS, 1)  # (columns, m STARTS)
    q = np.tile(draw.uniform(-np.pi, np.pi, (n, STARTS)), m)
    pars = np.repeat(z[:, None], q.shape[1], 1)

    def off(q: Array) -> Array:
        """Columns at joint angles (n, m STARTS) less the measured ones (columns, m STARTS), m."""
        states = np.vstack([q, np.zeros_like(q), np.repeat(swing.t, STARTS)[None]])
        return sensors @ equations.outputs(states, pars) - y

    for _ in range(20):
        r = off(q)
        J = np.stack([(off(q + 1e-6 * unit[:, None]) - r) / 1e-6 for unit in np.eye(n)], 1)  # (columns, n, C)
        step = np.linalg.pinv(J.transpose(2, 0, 1), rcond=1e-6) @ r.T[..., None]
        q = q - np.clip(step[..., 0].T, -1.0, 1.0)
    best = (off(q) ** 2).sum(0).reshape(m, STARTS).argmin(1)
    angles = q.T.reshape(m, STARTS, n)[np.arange(m), best]
    angles[np.isnan(swing.y).any(1)] = np.nan
    whole = ~np.isnan(angles).any(1)
    angles[whole] = np.unwrap((angles[whole] + np.pi) % (2 * np.pi) - np.pi, axis=0)
    return angles


def natural_scale(samples: Regression, z: Array, offsets: Array) -> Array:
    """The changes of the search coordinates (nz,) that change accelerations by one hundredth; 0 where none does."""
    with np.errstate(all="ignore"):
        base = samples.accelerations(z, offsets)
        size = np.sqrt(np.nanmean(base**2)) or 1.0
        scale = np.where(z != 0, np.abs(z), 1.0) * 1e-3
        for _ in range(2):
            for j in range(len(z)):
                step = np.eye(len(z))[j] * scale[j] * 0.1
                change = np.sqrt(np.nanmean((samples.accelerations(z + step, offsets) - base) ** 2)) / 0.1
                unseen = not change > 1e-9 * size
                scale[j] = 0.0 if unseen else scale[j] * ONE_PERCENT * size / change
    return scale


def regress(samples: Regression, prior: Array, scale: Array, lower: Array, upper: Array, still: Mask) -> Array:
    """The unknowns (nx,) that explain the measured accelerations best: robust least squares, a tenth of a second."""
    nz, columns = samples.equations.nz, samples.shift.shape[1]

    def residuals(x: Array) -> Array:
        """At unknowns (nx,): accelerations less the measured ones (n N,), over their size, then the pull of the guess."""
        x = np.where(still, prior, x)
        offsets = x[nz:] if len(x) > nz else np.zeros(columns)
        with np.errstate(all="ignore"):
            off = ((samples.accelerations(x[:nz], offsets) - samples.measured) / size).reshape(-1)
        return np.concatenate([np.where(np.isfinite(off), np.clip(off, -1e3, 1e3), 1e3), 1e-3 * (x - prior) / scale])

    size = np.sqrt(np.mean(samples.measured**2)) or 1.0
    options = {"x_scale": scale, "loss": "soft_l1", "f_scale": 0.05, "max_nfev": 40}
    best = least_squares(residuals, np.clip(prior, lower, upper), bounds=(lower, upper), **options).x
    return np.where(still, prior, best)


def nearest_to_guess(
    samples: Regression, x: Array, prior: Array, sizes: Array, scale: Array, lower: Array, upper: Array
) -> Array:
    """The unknowns (nx,) nearest to the guess, each in units of its size, of all that give the accelerations of x (nx,).

    They give the same motions too, and a fit cannot tell them apart. `scale` (nx,) are natural scales. x itself where the
    search fails.
    """
    nz, columns = samples.equations.nz, samples.shift.shape[1]

    def accelerations(x: Array) -> Array:
        """At unknowns (nx,), (n N,)."""
        return samples.accelerations(x[:nz], x[nz:] if len(x) > nz else np.zeros(columns)).reshape(-1)

    aim, y, moves = accelerations(x), x, np.diag(1e-3 * scale)
    weight = SAME / (np.linalg.norm(aim) or 1.0)
    for _ in range(NEAREST):
        J = np.array([(accelerations(y + h) - accelerations(y - h)) / (2 * h.sum()) for h in moves]).T * sizes
        Q, R = np.linalg.qr(np.concatenate([weight * J, np.eye(len(x))]))
        goal = Q.T @ np.concatenate([weight * (aim - accelerations(y)), (prior - y) / sizes])
        reach = np.minimum(REACH * scale, np.maximum(np.abs(y), sizes) / 2) / sizes
        bounds = np.clip((lower - y) / sizes, -reach, -1e-12), np.clip((upper - y) / sizes, 1e-12, reach)
        step = lsq_linear(R, goal, bounds, method="bvls").x
        y = np.clip(y + sizes * step, lower, upper)
        if np.abs(step).max() < 1e-9:
            break
    same = np.linalg.norm(accelerations(y) - aim) * weight < 1.0
    return y if same else x

"""The search: least squares over physics and offsets, the starts of all pieces being solved for at every step.

Separable least squares (G. Golub, V. Pereyra, SIAM J. Numer. Anal. 10 (1973), 413; the Jacobian of L. Kaufman, BIT 15
(1975), 49): residuals and derivatives are projected onto what the starts cannot explain, piece by piece, so that the
outer problem has a dozen unknowns whatever the number of pieces. Derivatives are differences of exact motions.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import lsq_linear

from pendpin.fitting.data import Batch
from pendpin.fitting.equations import Equations
from pendpin.fitting.motion import motions
from pendpin.fitting.uncertainty import RANK
from pendpin.ground.arrays import Array, Mask

MOST_START_STEPS = 6
STARTS_DONE = 1e-4  # of the sum of squares: what another step of the starts would gain
DIFFERENCE = 1e-6  # of a natural scale: step of derivatives, which motions may magnify a thousandfold
CENTRAL = 3e-5  # the same, of the central differences that tell what is determined
START_DIFFERENCE = 1e-6  # rad, rad/s
POLISHED = 0.01  # of the noise of one residual: what another step would gain of the sum of squares
LONGEST = 3.0  # natural scales: the first step, within which residuals are nearly linear
LOST = 1e6  # a residual that is no number, in units of the weights


@dataclass(frozen=True, eq=False)
class Problem:
    """Measured pieces, the equations that shall explain them, and what each residual counts.

    The unknowns x (nx,) are the search coordinates z (nz,), then the offsets of the columns if these are free.
    """

    equations: Equations
    sensors: Array  # (columns, outputs): what each column measures of the outputs of the equations
    batch: Batch
    weights: Array  # (columns,) 1/rad or 1/m
    scale: Array  # (nx,) natural sizes of the unknowns: they change accelerations by one hundredth
    lower: Array  # (nx,)
    upper: Array  # (nx,)
    prior: Array  # (nx,) the guess, to which what the data do not determine is held
    hold: float  # weight of the guess, in units of scale
    offsets: Array  # (columns,) those of columns whose offsets are not free
    largest_step: float  # s
    still: Mask  # (nx,) unknowns that stay where they are
    share: Array | float = 1.0  # (M, columns, P) of each residual, for robust fits

    @property
    def nz(self) -> int:
        """How many search coordinates there are."""
        return self.equations.nz

    def split(self, x: Array) -> tuple[Array, Array]:
        """The search coordinates (nz,) and the offsets (columns,)."""
        return x[: self.nz], x[self.nz :] if len(x) > self.nz else self.offsets

    def predicted(self, z: Array, starts: Array, t: Array) -> Array:
        """What the sensors would show without offsets, (M, columns, C), from starts (2n, C) at times t (M, C)."""
        y = motions(self.equations, t, starts, z, self.largest_step)
        n = len(self.equations.joints)
        if self.sensors.shape[1] == n:
            return self.sensors @ y[:, :n]
        M, _, C = y.shape
        flat = y.transpose(1, 0, 2).reshape(2 * n, -1)
        outputs = self.equations.outputs(np.vstack([flat, t.reshape(1, -1)]), np.tile(z, (1, M)))
        return self.sensors @ outputs.reshape(-1, M, C).transpose(1, 0, 2)

    def columns(self, x: Array, starts: Array, t: Array) -> Array:
        """What the sensors show at unknowns (nx,), (M, columns, C), from starts (2n, C) at times t (M, C)."""
        z, offsets = self.split(x)
        return self.predicted(np.repeat(z[:, None], starts.shape[1], 1), starts, t) + offsets[:, None]

    def residuals(self, x: Array, starts: Array) -> Array:
        """Weighted residuals (P, M columns); 0 where nothing was measured."""
        return self._residuals(x[:, None] + np.zeros((1, starts.shape[1])), starts)

    def _residuals(self, x: Array, starts: Array) -> Array:
        """As `residuals`, for k P motions with unknowns (nx, k P)."""
        repeats = starts.shape[1] // self.batch.t.shape[1]
        share = np.tile(self.share, repeats) if isinstance(self.share, np.ndarray) else self.share
        with np.errstate(all="ignore"):
            predicted = self.predicted(x[: self.nz], starts, np.tile(self.batch.t, repeats))
            offset = x[self.nz :] if len(x) > self.nz else self.offsets[:, None]
            r = (predicted + offset - np.tile(self.batch.y, repeats)) * self.weights[:, None] * share
        seen = ~np.isnan(np.tile(self.batch.y, repeats))
        r = np.where(seen, np.where(np.abs(r) < LOST, r, LOST), 0.0)
        return r.transpose(2, 0, 1).reshape(starts.shape[1], -1)

    def by_starts(self, x: Array, starts: Array) -> tuple[Array, Array]:
        """Residuals (P, M columns) and their derivatives by the starts (P, M columns, 2n)."""
        size, P = starts.shape
        moved = starts[:, None, :] + START_DIFFERENCE * np.eye(size, size + 1, 1)[:, :, None]
        r = self._residuals(np.repeat(x[:, None], (size + 1) * P, 1), moved.reshape(size, -1))
        r = r.reshape(size + 1, P, -1)
        return r[0], ((r[1:] - r[0]) / START_DIFFERENCE).transpose(1, 2, 0)

    def by_unknowns(self, x: Array, starts: Array, r: Array, central: bool = False) -> Array:
        """The derivatives of the residuals by the unknowns, (P, M columns, nx), the starts being held."""
        P, nz = starts.shape[1], self.nz
        moving = np.flatnonzero(~self.still[:nz])
        h = (CENTRAL if central else DIFFERENCE) * self.scale[moving]
        h = np.where(x[moving] + h > self.upper[moving], -h, h)
        sides = (h, -h) if central else (h,)
        residuals = []
        for side in sides:
            moved = x[:, None] + np.eye(len(x))[:, moving] * side
            residuals.append(self._residuals(np.repeat(moved, P, 1), np.tile(starts, len(h))).reshape(len(h), P, -1))
        slope = (
            (residuals[0] - residuals[1]) / (2 * h[:, None, None]) if central else (residuals[0] - r) / h[:, None, None]
        )
        J = np.zeros((P, r.shape[1], len(x)))
        J[:, :, moving] = slope.transpose(1, 2, 0)
        if len(x) > nz:
            seen = ~np.isnan(self.batch.y) * (self.weights[:, None] * self.share)  # (M, columns, P)
            eye = np.eye(len(self.weights))
            J[:, :, nz:] = (seen.transpose(2, 0, 1)[..., None] * eye).reshape(P, -1, len(eye))
        return J


@dataclass
class Starts:
    """The starts (2n, P) that explain the data best at some unknowns, and how they follow the unknowns."""

    x: Array
    starts: Array
    follow: Array | None = None  # (2n, P, nx), their derivatives by the unknowns

    def near(self, x: Array) -> Array:
        """The starts (2n, P) to begin with at other unknowns (nx,)."""
        return self.starts if self.follow is None else self.starts + self.follow @ (x - self.x)


@dataclass(frozen=True, eq=False)
class Solved:
    """The starts at some unknowns, the residuals there, and the basis of what the starts explain."""

    starts: Array  # (2n, P)
    r: Array  # (P, M columns)
    Q: Array  # (P, M columns, 2n)
    R_inverse: Array  # (P, 2n, 2n)

    def rest(self, J: Array) -> Array:
        """What the starts cannot explain of residuals or derivatives (P, M columns, ...)."""
        return J - self.Q @ (self.Q.transpose(0, 2, 1) @ J)


def solve_starts(problem: Problem, x: Array, starts: Array, steps: int = MOST_START_STEPS) -> Solved:
    """The starts (2n, P) that explain the data best at unknowns x: Gauss-Newton, piece by piece, halved where worse."""
    r, J = problem.by_starts(x, starts)
    pace = np.ones(starts.shape[1])
    for _ in range(steps):
        Q, inverse = _basis(J)
        seen = (Q.transpose(0, 2, 1) @ r[:, :, None])[:, :, 0]  # (P, 2n)
        cost = (r**2).sum(1)
        if (seen**2).sum() <= STARTS_DONE * cost.sum() + 1e-300:
            break
        step = -(inverse @ seen[:, :, None])[:, :, 0].T
        tried = starts + pace * step
        r_new, J_new = problem.by_starts(x, tried)
        better = (r_new**2).sum(1) <= cost
        starts, r = np.where(better, tried, starts), np.where(better[:, None], r_new, r)
        J = np.where(better[:, None, None], J_new, J)
        pace = np.where(better, np.minimum(1.0, 2 * pace), pace / 4)
    return Solved(starts, r, *_basis(J))


def _basis(J: Array) -> tuple[Array, Array]:
    """Q (P, R, 2n) and the inverse of U (P, 2n, 2n) of derivatives by the starts J = Q U (P, R, 2n), Q orthonormal."""
    Q, R = np.linalg.qr(np.nan_to_num(J))
    return Q, np.linalg.pinv(R, rcond=1e-12)


@dataclass
class Search:
    """One least-squares search by Gauss-Newton steps, within the bounds and within a box that grows where they succeed."""

    problem: Problem
    best: Starts

    def run(self, most: int, tolerance: float = 0.0, central: bool = False) -> tuple[Array, Solved, Array]:
        """The best unknowns (nx,) from those of `best` in so many steps, the starts there, and the last derivatives.

        It ends where a step would gain less than `tolerance` of the sum of squares. The derivatives are
        (P, M columns, nx), less what the starts explain.
        """
        x, p, reach = self.best.x, self.problem, LONGEST
        at = solve_starts(p, x, self.best.near(x))
        cost, J = self._cost(x, at), self._slopes(x, at, central)
        for step in range(most):
            dx, gain = self._step(x, at, J, reach)
            if gain < max(POLISHED, tolerance * cost):
                break
            tried = x + dx
            new = solve_starts(p, tried, self.best.near(tried))
            if (cost_new := self._cost(tried, new)) < cost:
                x, at, cost, reach = tried, new, cost_new, 2 * reach
                if step + 1 < most:
                    J = self._slopes(x, at, central)
            else:
                reach = np.abs(dx / p.scale).max() / 4
        return x, at, J

    def _cost(self, x: Array, at: Solved) -> float:
        """The sum of squares at unknowns x (nx,) that no start explains, with the pull of the guess."""
        return float((at.rest(at.r[..., None]) ** 2).sum() + (self._pull(x) ** 2).sum())

    def _step(self, x: Array, at: Solved, J: Array, reach: float) -> tuple[Array, float]:
        """The best step (nx,) for linear residuals within the bounds and within `reach` natural scales, and its gain."""
        p = self.problem
        rows = np.concatenate([J.reshape(-1, len(x)) * p.scale, p.hold * np.eye(len(x))])
        r = np.concatenate([at.rest(at.r[..., None]).reshape(-1), self._pull(x)])
        Q, R = np.linalg.qr(rows)
        seen = Q.T @ r
        damped = np.concatenate([R, RANK * np.linalg.norm(R, axis=0).max() * np.eye(len(x))])
        aim = np.concatenate([-seen, np.zeros(len(x))])
        below, above = (p.lower - x) / p.scale, (p.upper - x) / p.scale
        bounds = (np.clip(below, -reach, -1e-12), np.clip(above, 1e-12, reach))
        step = lsq_linear(damped, aim, bounds, method="bvls").x
        gain = float((seen**2).sum() - ((seen + R @ step) ** 2).sum())
        return np.clip(x + p.scale * step, p.lower, p.upper) - x, gain

    def _slopes(self, x: Array, at: Solved, central: bool = False) -> Array:
        """The derivatives (P, M columns, nx) of the residuals, less what the starts explain; `best` follows them."""
        J = self.problem.by_unknowns(x, at.starts, at.r, central)
        follow = -(at.R_inverse @ (at.Q.transpose(0, 2, 1) @ J))
        self.best = Starts(x.copy(), at.starts, follow.transpose(1, 0, 2))
        return at.rest(J)

    def _pull(self, x: Array) -> Array:
        """The pull (nx,) of the guess on unknowns x (nx,)."""
        return self.problem.hold * (x - self.problem.prior) / self.problem.scale

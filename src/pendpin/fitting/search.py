"""The search: least squares over physics and offsets, the starts of all pieces being solved for at every step.

Separable least squares (G. Golub, V. Pereyra, SIAM J. Numer. Anal. 10 (1973), 413; the Jacobian of L. Kaufman, BIT 15
(1975), 49): residuals and derivatives are projected onto what the starts cannot explain, piece by piece, so that the
outer problem has a dozen unknowns whatever the number of pieces.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import lsq_linear

from pendpin.fitting.problem import Problem
from pendpin.fitting.uncertainty import RANK
from pendpin.ground.arrays import Array

MOST_START_STEPS = 6
STARTS_DONE = 1e-4  # of the sum of squares: what another step of the starts would gain
POLISHED = 0.01  # of the noise of one residual: what another step would gain of the sum of squares
LONGEST = 3.0  # natural scales: the first step, within which residuals are nearly linear


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
    J: Array  # (P, M columns, nx), the derivatives by the unknowns, the starts being held

    def rest(self, J: Array) -> Array:
        """What the starts cannot explain of residuals or derivatives (P, M columns, ...)."""
        return J - self.Q @ (self.Q.transpose(0, 2, 1) @ J)


def solve_starts(problem: Problem, x: Array, starts: Array, steps: int = MOST_START_STEPS) -> Solved:
    """The starts (2n, P) that explain the data best at unknowns x: Gauss-Newton, piece by piece, halved where worse."""
    bound = problem.pendulum.at(problem.split(x)[0])
    r, by_start, J = problem.evaluate(bound, x, starts)
    pace, starts = np.ones(starts.shape[1]), starts.copy()
    for _ in range(steps):
        Q, inverse = _basis(by_start)
        seen = (Q.transpose(0, 2, 1) @ r[:, :, None])[:, :, 0]  # (P, 2n)
        cost = (r**2).sum(1)
        some = (seen**2).sum(1) > STARTS_DONE * cost.mean()
        if not some.any():
            break
        tried = starts - pace * (inverse @ seen[:, :, None])[:, :, 0].T
        new = problem.evaluate(bound, x, tried, some)
        better = some.copy()
        better[some] = (new.r**2).sum(1) <= cost[some]
        took = better[some]
        starts[:, better] = tried[:, better]
        r[better], by_start[better], J[better] = (part[took] for part in new)
        pace = np.where(better, np.minimum(1.0, 2 * pace), np.where(some, pace / 4, pace))
    return Solved(starts, r, *_basis(by_start), J)


def _basis(J: Array) -> tuple[Array, Array]:
    """Q (P, R, 2n) and the inverse of U (P, 2n, 2n) of derivatives by the starts J = Q U (P, R, 2n), Q orthonormal."""
    Q, R = np.linalg.qr(np.nan_to_num(J))
    return Q, np.linalg.pinv(R, rcond=1e-12)


@dataclass
class Search:
    """One least-squares search by Gauss-Newton steps, within the bounds and within a box that grows where they succeed."""

    problem: Problem
    best: Starts

    def run(self, most: int, tolerance: float = 0.0) -> tuple[Array, Solved, Array]:
        """The best unknowns (nx,) from those of `best` in so many steps, the starts there, and the last derivatives.

        It ends where a step would gain less than `tolerance` of the sum of squares. The derivatives are
        (P, M columns, nx), less what the starts explain.
        """
        x, p, reach = self.best.x, self.problem, LONGEST
        at = solve_starts(p, x, self.best.near(x))
        cost, J = self._cost(x, at), self._slopes(x, at)
        for _ in range(most):
            dx, gain = self._step(x, at, J, reach)
            if gain < max(POLISHED, tolerance * cost):
                break
            tried = x + dx
            new = solve_starts(p, tried, self.best.near(tried))
            if (cost_new := self._cost(tried, new)) < cost:
                x, at, cost, reach = tried, new, cost_new, 2 * reach
                J = self._slopes(x, at)
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

    def _slopes(self, x: Array, at: Solved) -> Array:
        """The derivatives (P, M columns, nx) of the residuals, less what the starts explain; `best` follows them."""
        follow = -(at.R_inverse @ (at.Q.transpose(0, 2, 1) @ at.J))
        self.best = Starts(x.copy(), at.starts, follow.transpose(1, 0, 2))
        return at.rest(at.J)

    def _pull(self, x: Array) -> Array:
        """The pull (nx,) of the guess on unknowns x (nx,)."""
        return self.problem.hold * (x - self.problem.prior) / self.problem.scale

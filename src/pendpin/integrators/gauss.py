"""Gauss-Legendre collocation in positions and momenta: symplectic, of order 2, 4 or 6, fixed steps.

V_i are the velocities at the stages c_i of a step h, Q_i = q + h sum_j a_ij V_j, and the stage equations are
    M(Q_i) V_i = p + h sum_j a_ij F(t_j, Q_j, V_j);
then q += h sum_j b_j V_j, p += h sum_j b_j F_j. After E. Hairer, C. Lubich, G. Wanner, Geometric Numerical Integration
(2006), II.1.3 and VIII.6; on keeping round-off down: Hairer, McLachlan, Razakarivony, BIT 48 (2008).
"""

from collections.abc import Callable
from functools import cache
from typing import NamedTuple

import numpy as np

from pendpin.engines import CanonicalForm, Derivative, Engine, ProgressCallback, Revolute
from pendpin.errors import InputError
from pendpin.ground.arrays import EPS, Array, lapack
from pendpin.ground.libraries import version
from pendpin.integrators.base import FREE, Integrator, Segment, StepPlan
from pendpin.integrators.fixed import GridPlace
from pendpin.scene import Method

MOST_ITERATIONS = 40  # chosen, five times PATIENCE: what has not converged by then does not
STEPS = 2  # whose stages are kept for the extrapolation
CALLBACK_STEPS = 16  # between two calls of the progress callback: a step takes 0.1 ms, at worst a hundred times that
PATIENCE = 8  # iterations with the first matrix; then each has its own
UNSOLVED = "the stage equations are not solved {:g} s after the start: take a smaller step"


class Rule(NamedTuple):
    """The coefficients of s stages, as a_ij = (1/2 + w_ij) b_j with w antisymmetric."""

    # So the conditions for a symplectic and symmetric method hold exactly, whatever the rounding of w.

    c: Array  # (s,)
    b: Array  # (s,)
    w: Array  # (s, s)
    a: Array  # (s, s), rounded

    def within(self, x: Array) -> Array:
        """sum_j a_ij x_j, from x (s, n)."""
        weighted = self.b[:, None] * x
        return np.add.reduce(weighted, 0) / 2 + self.w @ weighted


@cache
def rule(s: int) -> Rule:
    """The Gauss-Legendre rule of s stages on [0, 1]."""
    x, weights = np.polynomial.legendre.leggauss(s)
    c, b = (1 + x) / 2, weights / 2
    a = _integrals(c, lambda powers: c[:, None] ** (powers + 1) / (powers + 1))
    w = a / b - 0.5
    w = (w - w.T) / 2
    return Rule(c, b, w, (0.5 + w) * b)


def _integrals(nodes: Array, integrated: Callable[[Array], Array]) -> Array:
    """Functionals (k,) of the Lagrange polynomials of nodes (s,), from those of the powers."""
    powers = np.arange(float(len(nodes)))
    return np.asarray(np.linalg.solve(np.vander(nodes, increasing=True).T, integrated(powers).T).T, float)


@cache
def extrapolation(s: int, steps: int) -> Array:
    """From the stages of the last one or two steps, latest last, to those of the next: (s, steps s)."""
    c = rule(s).c
    nodes = np.concatenate([c - k for k in range(steps, 0, -1)])
    return _integrals(nodes, lambda powers: c[:, None] ** powers)


class GaussMemory(NamedTuple):
    """What collocation keeps from segment to segment."""

    motion: Array  # (2, nv), positions and momenta
    lost: Array  # (2, nv), the rounding errors of their sums
    stages: Array  # (STEPS, s, nv), velocities at the stages of the last steps; the latest last
    known: int  # how many of these steps there are
    place: GridPlace
    others: Array  # further integrated quantities at the end of the last step


class Gauss(Integrator):
    """Gauss-Legendre collocation on Pinocchio's equations with revolute joints.

    The stage equations are solved to rounding by Newton's method, with one matrix a step that holds the slopes of the
    fields only. If that does not converge, every iteration gets its own matrix with all slopes. Sums are compensated.
    """

    def __init__(self, method: Method, setting: float) -> None:
        super().__init__(method, setting)
        self.rule = rule(method.stages)
        self.library, self.version = "pinocchio", version("pin")

    def equations(self, engine: Engine, progress: ProgressCallback) -> tuple[Derivative, Callable[[], int]]:
        """The equations of Pinocchio in (q, p). Raises InputError for another engine."""
        if not isinstance(engine, Revolute):
            raise InputError("solver.method: gauss2, gauss4 and gauss6 need Pinocchio; leave solver.engine out")
        self._form, self._nv = CanonicalForm(engine.model, engine.loads), len(engine.model.joints)
        self._progress, self._calls = progress, 0
        return engine.derivative(lambda t: None)[0], lambda: self._calls

    def memory(self, y: Array) -> GaussMemory:
        """Positions and momenta at y (size,), without rounding errors and stages so far."""
        q, v = y[: self._nv], y[self._nv : 2 * self._nv]
        motion, stages = np.array([q, self._form.momentum(q, v)]), np.zeros((STEPS, len(self.rule.b), self._nv))
        return GaussMemory(motion, np.zeros_like(motion), stages, 0, GridPlace(), np.array(y[2 * self._nv :]))

    def integrate(self, derivative: Derivative, y: Array, times: Array, plan: StepPlan = FREE) -> Segment:
        """The states (n, size) by collocation; further integrated quantities use the same rule."""
        memory, t = plan.memory or self.memory(y), float(times[0])
        assert isinstance(memory, GaussMemory)
        place, inside = memory.place.enter(t, plan)
        if plan.anew and inside:
            memory = self.memory(y)
        elif plan.anew or not inside:
            memory = memory._replace(others=y[2 * self._nv :])
        states, steps = [np.array(y)], 0
        for t in times[1:].tolist():
            place, blocks, (last, left) = place.go_to(t, self.setting)
            for t_step, step in ((start + i * h, h) for start, count, h in blocks for i in range(count)):
                if not steps % CALLBACK_STEPS:
                    self._progress(t_step)
                advanced = self._advanced(derivative, t_step, step, memory)
                if advanced is None:
                    return Segment(np.array(states), steps, UNSOLVED.format(t_step))
                memory, steps = advanced, steps + 1
            sample = memory
            if left:
                sample = self._advanced(derivative, last, left, memory, extrapolates=False)
            if sample is None:
                return Segment(np.array(states), steps, UNSOLVED.format(last))
            q, p = sample.motion
            states.append(np.concatenate([q, self._form.velocity(q, p), sample.others]))
        return Segment(np.array(states), steps, None, memory._replace(place=place))

    def _advanced(
        self, derivative: Derivative, t: float, h: float, memory: GaussMemory, extrapolates: bool = True
    ) -> GaussMemory | None:
        """The memory one step h from t later, in s; None without convergence of its stages."""
        (motion, lost, past, known, _, others), s, stages = memory, len(self.rule.b), None
        if extrapolates and known:
            V = extrapolation(s, known) @ past[STEPS - known :].reshape(-1, self._nv)
            stages = self._iterated(t, h, motion, V)
        stages = stages or self._iterated(t, h, motion, np.tile(self._form.velocity(*motion), (s, 1)))
        if stages is None:
            return None
        Q, V, F = stages
        if len(others):  # by their mean rates over the step
            rates = np.empty((s, 2 * self._nv + len(others)))
            for rate, time, q, v in zip(rates, t + h * self.rule.c, Q, V, strict=True):
                derivative(rate, time, np.concatenate([q, v, others]))
            others = others + h * (self.rule.b @ rates[:, 2 * self._nv :])
        due = np.array([h * (self.rule.b @ V), h * (self.rule.b @ F)]) + lost  # W. Kahan's summation
        moved = motion + due
        return memory._replace(
            motion=moved,
            lost=due - (moved - motion),
            stages=np.concatenate([past[1:], V[None]]),
            known=min(known + 1, STEPS),
            others=others,
        )

    @np.errstate(over="ignore", invalid="ignore")  # an iteration that diverges ends where it overflows
    def _iterated(self, t: float, h: float, motion: Array, V: Array) -> tuple[Array, Array, Array] | None:
        """Positions, velocities and forces (s, nv) at the stages, by Newton's iteration from velocities V (s, nv)."""
        (q, p), times, factors, before = motion, t + h * self.rule.c, None, np.inf
        for i in range(MOST_ITERATIONS):
            Q = q + h * self.rule.within(V)
            self._calls += len(times)
            now = [self._form.at(*stage) for stage in zip(times, Q, V, strict=True)]
            M, N, F = map(np.array, zip(*now, strict=True))
            thorough = i >= PATIENCE
            if factors is None or thorough:
                self._calls += thorough * len(times) * self._nv
                slopes = [self._form.slopes(*stage, thorough) for stage in zip(times, Q, V, now, strict=True)]
                in_q, in_v = map(np.array, zip(*slopes, strict=True))
                # The derivative of the residual in V, (s nv, s nv): M_i delta_ij + h a_ij (N_i - dF_j/dv)
                # - h² sum_k a_ik dF_k/dq a_kj, with N = dp/dq.
                a, (s, nv, _) = self.rule.a, N.shape
                J = h * a[:, None, :, None] * (N[:, :, None, :] - in_v.transpose(1, 0, 2)[None])
                J -= h * h * np.einsum("ik,kab,kj->iajb", a, in_q, a)
                J[np.arange(s), :, np.arange(s)] += M
                factors = lapack("getrf")(J.reshape(s * nv, s * nv))[:2]
            residual = (M @ V[..., None])[..., 0] - p - h * self.rule.within(F)
            change = lapack("getrs")(*factors, residual.reshape(-1))[0].reshape(V.shape)
            V = V - change
            size, scale = np.abs(change).max(), max(np.abs(V).max(), 1e-300)
            if not np.isfinite(size):
                return None
            ratio = min(size / before, 1.0) if np.isfinite(before) else 1.0
            if size * ratio < EPS / 8 * scale or (size < 1e-9 * scale and size >= before / 2):
                return Q, V, F
            before = size
        return None

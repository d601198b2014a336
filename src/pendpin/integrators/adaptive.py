"""The adaptive integrator: embedded Runge-Kutta and multistep methods, on CyRK where installed, else on SciPy."""

from collections.abc import Callable

import numpy as np

from pendpin.arrays import Array
from pendpin.engines import Derivative
from pendpin.integrators.base import FREE, Integrator, Segment, StepPlan
from pendpin.versions import version

NAMES = {"dop853": "DOP853", "rk45": "RK45", "rk23": "RK23", "radau": "Radau", "bdf": "BDF", "lsoda": "LSODA"}
LEAST_RTOL = 2.3e-14  # SciPy raises smaller ones to 100 times the rounding, with a warning
NOT_FINITE = "the acceleration is not a finite number"


class Adaptive(Integrator):
    """A method of `NAMES` with one tolerance, relative and absolute (rad, rad/s) alike."""

    def __init__(self, method: str, tolerance: float) -> None:
        self.method, self.tolerance = NAMES[method], tolerance
        try:
            import CyRK
        except ImportError:
            from scipy import integrate

            self.library, self._solve, self._scipy_method = "scipy", self._scipy, getattr(integrate, self.method)
        else:
            self.library, self._solve, self._cyrk_solve = "CyRK", self._cyrk, CyRK.pysolve_ivp
        self.version = version(self.library)

    def integrate(self, derivative: Derivative, y: Array, times: Array, plan: StepPlan = FREE) -> Segment:
        """The states (n, size) by CyRK or SciPy, within the tolerance a step."""
        first_step = plan.first and min(plan.first, (times[-1] - times[0]) / 2, plan.longest)
        return self._solve(derivative, y, times, first_step, plan.longest)

    def _cyrk(
        self, derivative: Derivative, y: Array, times: Array, first_step: float | None, longest: float
    ) -> Segment:
        """The states (n, size) by CyRK, from y (size,) at `times` (n,) in s."""
        result = self._cyrk_solve(
            derivative,
            (times[0], times[-1]),
            np.ascontiguousarray(y),
            method=self.method,
            t_eval=np.ascontiguousarray(times),
            rtol=self.tolerance,
            atol=self.tolerance,
            first_step=first_step or 0.0,
            max_step=longest,
            pass_dy_as_arg=True,
        )
        states = np.array(result.y).T.copy() if np.size(result.y) else np.array(y[None])  # it may fail at once
        failure = None if result.success else result.message
        return Segment(*finite_part(states, result.steps_taken, failure))

    def _scipy(
        self, derivative: Derivative, y: Array, times: Array, first_step: float | None, longest: float
    ) -> Segment:
        """The states (n, size) by SciPy, from y (size,) at `times` (n,) in s."""
        states, steps, failure, function = [np.array(y)], 0, None, returning(derivative)
        try:
            solver = self._scipy_method(
                function,
                times[0],
                y,
                times[-1],
                rtol=max(self.tolerance, LEAST_RTOL),
                atol=self.tolerance,
                first_step=first_step,
                max_step=longest,
            )
            while solver.status == "running":
                failure = solver.step()
                steps += 1
                due = times[len(states) : np.searchsorted(times, solver.t, side="right")]
                if len(due) and not failure:
                    states.extend(solver.dense_output()(due).T)
        except FloatingPointError:
            failure = NOT_FINITE
        return Segment(*finite_part(np.array(states), steps, failure))


def returning(derivative: Derivative) -> Callable[[float, Array], Array]:
    """A derivative that returns dy (size,), for SciPy. Raises FloatingPointError on NaN and inf."""

    def function(t: float, y: Array) -> Array:
        dy = np.empty_like(y)
        derivative(dy, t, y)
        if not np.isfinite(dy).all():
            raise FloatingPointError
        return dy

    return function


def finite_part(states: Array, steps: int, failure: str | None) -> tuple[Array, int, str | None]:
    """The states (n, size) before the first that is not finite, the steps, and the failure."""
    good = np.isfinite(states).all(1)
    if good.all():
        return states, steps, failure
    return states[: max(1, int(np.argmin(good)))], steps, NOT_FINITE  # the first is what was given

"""The adaptive integrator: embedded Runge-Kutta and multistep methods, on CyRK where installed, else on SciPy."""

import numpy as np

from pendpin.dynamics.dynamics import Dynamics
from pendpin.engines import Derivative
from pendpin.ground.arrays import Array
from pendpin.ground.libraries import version
from pendpin.integrators import machine
from pendpin.integrators.base import (
    FREE,
    LEAST_RTOL,
    NOT_FINITE,
    Integrator,
    Segment,
    StepPlan,
    finite_part,
    return_rates,
)
from pendpin.integrators.events import EventIntegrator
from pendpin.scene import Method, Scene


class Adaptive(EventIntegrator):
    """A method of CyRK and SciPy with one tolerance, relative and absolute (rad, rad/s) alike."""

    @classmethod
    def for_scene(cls, scene: Scene, dynamics: Dynamics) -> Integrator:
        """The method with the scene's tolerance; its loop in machine code where the equations are compiled."""
        if dynamics.engine.compiles and machine.available():
            return machine.AdaptiveInMachineCode.for_scene(scene, dynamics)
        return super().for_scene(scene, dynamics)

    def __init__(self, method: Method, setting: float) -> None:
        super().__init__(method, setting)
        try:
            import CyRK
        except ImportError:
            from scipy import integrate

            self.library, self._solve = "scipy", self._scipy
            self._scipy_method = getattr(integrate, method.library_name)
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
        # Radau without a Jacobian: ABA's derivatives saved 25 % with SciPy and nothing with CyRK (docs/accuracy.md).
        result = self._cyrk_solve(
            derivative,
            (times[0], times[-1]),
            np.ascontiguousarray(y),
            method=self.method.library_name,
            t_eval=np.ascontiguousarray(times),
            rtol=self.tolerance,
            atol=self.tolerance,
            first_step=first_step or 0.0,
            max_step=longest,
            pass_dy_as_arg=True,
        )
        states = np.array(result.y).T.copy() if np.size(result.y) else np.array(y[None])  # it may fail at once
        failure = None if result.success else result.message.rstrip(".")
        return Segment(*finite_part(states, result.steps_taken, failure))

    def _scipy(
        self, derivative: Derivative, y: Array, times: Array, first_step: float | None, longest: float
    ) -> Segment:
        """The states (n, size) by SciPy, from y (size,) at `times` (n,) in s."""
        states, steps, failure, function = [np.array(y)], 0, None, return_rates(derivative)
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

"""The motion near a motion: changes of the state with the start or with numbers of the scene, integrated beside it.

w' = df/dy w + df/dp along y' = f(t, y, p), by exact derivatives (pendpin.dynamics.derivatives) and the Runge-Kutta method
DOP853, with errors of every change measured by its own size.
"""

from collections.abc import Sequence

import numpy as np

from pendpin.dynamics.as_written import expand_as_written
from pendpin.dynamics.derivatives import Variational, refuse_poles
from pendpin.dynamics.dynamics import Dynamics
from pendpin.dynamics.timing import timing
from pendpin.effects import ContactEffect
from pendpin.engines.machine_code import Block
from pendpin.errors import InputError, RunError
from pendpin.ground.arrays import Array
from pendpin.integrators import cyrk
from pendpin.integrators.base import LEAST_RTOL
from pendpin.integrators.machine import Call, available
from pendpin.model.build import build, start_state
from pendpin.scene import Scene

_SURVEY = 1e-3  # the tolerance of a first integration, which finds how large the changes get
_LEAST = 1e-6  # of the largest change: smaller ones are as if they had this size


class Variations:
    """A scene whose motion is integrated together with K changes of its state; times are since the scene's start, in s.

    The changes are those with the numbers at some key paths. Use one in each thread. Raises InputError for friction and
    stops, which act at events, for effects without derivatives, and for keys that are not numbers of the scene;
    MissingLibrary without llvmlite.
    """

    def __init__(self, scene: Scene, keys: Sequence[str]) -> None:
        for i, effect in enumerate(expand_as_written(build(scene.model), scene.effects)):
            if isinstance(effect, ContactEffect):
                where = f"effects[{i}]" if i < len(scene.effects) else "as_written"
                raise InputError(
                    f"{where}: {effect.kind} acts at events, where a motion has no derivative; leave it out"
                )
        self.scene, self.equations = scene, Variational(scene, keys)
        self.keys, self.nv = tuple(keys), self.equations.nv
        q, v = start_state(self.equations.model, scene.start)
        dynamics = Dynamics(self.equations.model, scene.effects, start=scene.start.time)
        refuse_poles(self.equations.model, q)
        self.start = np.concatenate([q, v])
        self.pace = timing(dynamics, scene.effects, q, v, scene.duration, None).pace

    def integrate(self, y: Array, w: Array, times: Array, tolerance: float) -> tuple[Array, Array]:
        """The states (n, 2 nv) and the changes (n, K, 2 nv) at times (n,), from y (2 nv,) and w (K, 2 nv) at the first.

        Raises RunError where they cannot be integrated.
        """
        survey = self._integrated(y, w, times, _SURVEY, np.ones(w.size))
        sizes = np.abs(survey).max(0)[len(y) :].reshape(len(w), 2, -1).max(-1)
        largest = sizes.max(1, initial=0.0)[:, None]
        sizes = np.maximum(np.repeat(sizes, self.nv, axis=1), np.where(largest > 0, _LEAST * largest, 1.0))
        states = self._integrated(y, w, times, tolerance, sizes.ravel())
        return states[:, : len(y)], states[:, len(y) :].reshape(len(times), *w.shape)

    def _integrated(self, y: Array, w: Array, times: Array, tolerance: float, sizes: Array) -> Array:
        """The states and changes, (n, 2 nv (1 + K)); `sizes` (2 nv K,) are those of the changes."""
        atol = tolerance * np.concatenate([np.ones(len(y)), sizes])
        state = np.concatenate([y, w.ravel()])
        rows = [state[None]]
        for piece, due, longest in self.pace.pieces(times):
            part = solve(self.equations.block, state, piece, max(tolerance, LEAST_RTOL), atol, longest)
            if len(part) < len(piece) or not np.isfinite(part).all():
                raise RunError(
                    f"the changes of the motion cannot be integrated beyond {piece[max(len(part), 1) - 1]:.6g} s: they grow "
                    "too large, take too many steps, or a thin rod is near phi = 90 degrees, where its angles are singular"
                )
            rows.append(part[1 : due + 1])
            state = part[-1]
        return np.concatenate(rows)


def solve(block: Block, y: Array, times: Array, rtol: float, atol: Array, longest: float) -> Array:
    """The states (n, size) of a block's equations at times (n,), from y (size,) at the first; fewer where it stops."""
    if times[-1] == times[0]:
        return np.repeat(y[None], len(times), 0)
    if available():
        call = Call(cyrk.METHODS["DOP853"], block.code().address, block, np.array([rtol]), atol, 0.0, longest)
        solution = call.solved(y, times[0], times[-1], np.ascontiguousarray(times))
        return solution.states(y)
    from scipy.integrate import solve_ivp

    def rates(t: float, state: Array) -> Array:
        return block.evaluated(np.array([t]), state[None])[0][0]

    span = (float(times[0]), float(times[-1]))
    solution = solve_ivp(rates, span, y, "DOP853", times, rtol=rtol, atol=atol, max_step=longest)
    return solution.y.T


def list_state_keys(nv: int) -> list[str]:
    """The key paths of the starts of nv joints: their angles, then their rates."""
    return [f"start.{part}[{i}]" for part in ("positions", "velocities") for i in range(nv)]

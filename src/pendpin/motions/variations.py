"""The motion near a motion: changes of the state with the start or with numbers of the scene, integrated beside it.

w' = df/dy w + df/dp along y' = f(t, y, p), by exact derivatives (pendpin.dynamics.derivatives) and the Runge-Kutta method
DOP853, with errors of every change measured by its own size.
"""

from collections.abc import Sequence

import numpy as np

from pendpin.dynamics.binding.acting import expand_as_written
from pendpin.dynamics.contacts.contacts import Mode, Scales
from pendpin.dynamics.contacts.falls import RATE, Guards, guards_of
from pendpin.dynamics.derivatives import Variational, refuse_poles
from pendpin.dynamics.dynamics import Dynamics
from pendpin.dynamics.timing import timing
from pendpin.effects import ContactEffect, DryFriction
from pendpin.engines.machine.code import Block
from pendpin.errors import InputError, RunError
from pendpin.ground.arrays import EPS, Array
from pendpin.ground.keypaths import number_at, parsed
from pendpin.integrators import cyrk
from pendpin.integrators.base import LEAST_RTOL
from pendpin.integrators.events import integrate_to_event
from pendpin.integrators.machine import Call, available, block_stepper
from pendpin.model.build import build, start_state
from pendpin.scene import Scene

MOST_EVENTS = 100_000  # of one motion
_SECANT = 1e-5  # of the time scale: half of a difference
_SURVEY = 1e-3  # the tolerance of a first integration, which finds how large the changes get
_LEAST = 1e-6  # of the largest change: smaller ones are as if they had this size
_ROUNDING = 10 * EPS  # of the state over the number: changes are not integrated closer, as by a mass that cancels


class Variations:
    """A scene whose motion is integrated together with K changes of its state; times are since the scene's start, in s.

    The changes are those with the numbers at some key paths. Joints stick and slip by dry friction. At such an event all
    changes jump (the saltation matrix: M. A. Aizerman, F. R. Gantmacher, Q. J. Mech. Appl. Math. 11 (1958), 498): a
    neighbour meets it earlier or later and moves on with other accelerations from there. The places `still` of the state
    (2 nv,) are 0. Use one in each thread.

    Raises InputError for stops, for effects without derivatives, and for keys that are not numbers of the scene;
    MissingLibrary without llvmlite.
    """

    def __init__(self, scene: Scene, keys: Sequence[str], still: tuple[int, ...] = ()) -> None:
        refuse_contacts(scene, DryFriction)
        self.scene, self.equations = scene, Variational(scene, keys, contacts=True, still=still)
        self.keys, self.nv = tuple(keys), self.equations.nv
        values = [1.0 if parsed(key)[0] == "start" else abs(number_at(scene, key)) for key in keys]
        self._numbers = np.array([value or np.inf for value in values])  # where one is 0, nothing cancels
        q, v = start_state(self.equations.model, scene.start)
        refuse_poles(self.equations.model, q)
        self._last = np.inf  # the number of evaluations that may not be passed
        self._scales: Scales | None = None  # of the first motion that is integrated
        self.start = np.concatenate([q, v])
        dynamics = Dynamics(self.equations.model, scene.effects, start=scene.start.time)
        self.pace = timing(dynamics, scene.effects, q, v, scene.duration, None).pace

    def integrate(self, y: Array, w: Array, times: Array, tolerance: float) -> tuple[Array, Array]:
        """The states (n, 2 nv) and the changes (n, K, 2 nv) at times (n,), from y (2 nv,) and w (K, 2 nv) at the first.

        The errors of every change are measured by its own size. Raises RunError where they cannot be integrated.
        """
        states, survey = self.follow(y, w, times, _SURVEY, np.ones(w.size))
        sizes = np.abs(survey).max(0).reshape(len(w), 2, -1).max(-1)
        largest = sizes.max(1, initial=0.0)[:, None]
        sizes = np.maximum(np.repeat(sizes, self.nv, axis=1), np.where(largest > 0, _LEAST * largest, 1.0))
        of_state = np.repeat(np.abs(states).max(0).reshape(2, self.nv).max(1), self.nv)
        rounding = _ROUNDING / max(tolerance, LEAST_RTOL) * of_state / self._numbers[: len(w), None]
        return self.follow(y, w, times, tolerance, np.maximum(sizes, rounding).ravel())

    def follow(
        self, y: Array, w: Array, times: Array, tolerance: float, sizes: Array, most: float = np.inf
    ) -> tuple[Array, Array]:
        """States and their changes at some times, with given sizes (2 nv K,) of the changes.

        Those that are infinite do not shorten the steps.
        RunError after about `most` evaluations of the equations.
        """
        self._last = self.equations.block.calls + most
        self.equations.block.on_progress(lambda t: self._is_over())
        atol = tolerance * np.concatenate([np.ones(len(y)), sizes])
        state, rtol = np.concatenate([y, w.ravel()]), max(tolerance, LEAST_RTOL)
        rows, mode = [state[None]], None
        if self.equations.contacts is not None:
            mode = self._mode(times, state)
            rows = [state[None].copy()]
        for piece, due, longest in self.pace.pieces(times):
            if mode is None:
                part = solve(self.equations.block, state, piece, rtol, atol, longest)
            else:
                part, mode = self._through_events(state, piece, mode, rtol, atol, longest)
            if len(part) < len(piece) or not np.isfinite(part).all():
                raise RunError(
                    f"the changes of the motion cannot be integrated beyond {piece[max(len(part), 1) - 1]:.6g} s: they grow "
                    "too large, take too many steps, or a thin rod is near phi = 90 degrees, where its angles are singular"
                )
            rows.append(part[1 : due + 1])
            state = part[-1]
        states = np.concatenate(rows)
        return states[:, : len(y)], states[:, len(y) :].reshape(len(times), *w.shape)

    # --- through sticking and slipping ------------------------------------------------------------------------------

    def _mode(self, times: Array, state: Array) -> Mode:
        """The mode at the start; a joint that is held forgets a change of its rate."""
        contacts, nv = self.equations.contacts, self.nv
        assert contacts is not None
        q, v = state[:nv], state[nv : 2 * nv]
        if self._scales is None:
            self._scales = contacts.scales(times, q, v)
        mode = contacts.choose(times[0], q, v, self._scales)
        state.reshape(-1, 2, nv)[:, 1, mode.held] = 0.0
        return mode

    def _through_events(
        self, state: Array, times: Array, mode: Mode, rtol: float, atol: Array, longest: float
    ) -> tuple[Array, Mode]:
        """The states (n, size) at times (n,) from event to event, and the mode at the end."""
        contacts, scales, nv = self.equations.contacts, self._scales, self.nv
        assert contacts is not None
        assert scales is not None
        t, end, parts, done = float(times[0]), float(times[-1]), [state[None]], 1
        first_step = 2 * rtol ** (1 / 8) / float((scales.rate / scales.position).max())
        for _ in range(MOST_EVENTS):
            contacts.enter(mode)
            stepper = block_stepper(self.equations.block, rtol, atol, first_step, longest, self._refuse_more)
            guards = guards_of(contacts, state[:nv], mode, scales, rtol)
            segment = integrate_to_event(stepper, guards.values, guards.floor, t, state, end, times[done:])
            samples = segment.samples
            samples.reshape(len(samples), 1 + len(self.keys), 2, nv)[:, :, 1, mode.held] = 0.0
            parts, done, t, state = [*parts, samples], done + len(samples), segment.t, segment.y.copy()
            if segment.fired is None or segment.failure:
                break
            mode = self._cross(t, state, guards, segment.fired)
        if done == len(times) - 1 and t == end:  # an event at the last time
            parts.append(state[None])
        return np.concatenate(parts), mode

    def _is_over(self) -> bool:
        """Whether as many evaluations were made as may be."""
        return bool(self.equations.block.calls > self._last)

    def _refuse_more(self) -> None:
        """RunError when they were."""
        if self._is_over():
            raise RunError("the motion takes too many evaluations")

    def _cross(self, t: float, state: Array, guards: Guards, fired: list[int]) -> Mode:
        """The mode after an event at t; the state (size,) is changed to that after it."""
        contacts, block, nv = self.equations.contacts, self.equations.block, self.nv
        assert contacts is not None
        assert self._scales is not None
        y = state.reshape(-1, 2, nv)  # the state, then its K changes
        q, v = y[0]
        contacts.enter(guards.mode)
        rates, holding = (x[0] for x in block.evaluated(np.array([t]), state[None]))
        which = fired[0]
        joint, turned = int(guards.joint[which]), guards.turned[which]
        if guards.kind[which] == RATE:
            slope, changes = rates[nv + joint], y[1:, 1, joint].copy()
        else:  # a neighbour has another holding torque, and another limit
            h = _SECANT / float((self._scales.rate / self._scales.position).max())
            sides = np.array([state + h * rates, state - h * rates])
            late, early = block.evaluated(t + np.array([h, -h]), sides)[1][:, joint]
            slope = turned * (late - early) / (2 * h)
            changes = turned * holding.reshape(-1, nv)[1:, joint] + self.equations.variation.static[:, joint]
        mode = contacts.choose(t, q, v, self._scales, guards.land(q, v, fired))
        contacts.enter(mode)
        after = block.evaluated(np.array([t]), state[None])[0][0]
        jump = (rates - after)[: 2 * nv].reshape(2, nv)
        if slope:
            y[1:] -= (changes / slope)[:, None, None] * jump
        y[1:, 1, mode.held] = 0.0
        return mode


def refuse_contacts(scene: Scene, *taken: type) -> None:
    """Raise InputError for effects that act at events, but for those `taken`."""
    for i, effect in enumerate(expand_as_written(build(scene.model), scene.effects)):
        if isinstance(effect, ContactEffect) and not isinstance(effect, taken):
            where = f"effects[{i}]" if i < len(scene.effects) else "as_written"
            raise InputError(f"{where}: {effect.kind} acts at events, where a motion has no derivative; leave it out")


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

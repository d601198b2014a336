"""The Taylor integrator: series of the solution to rounding, by heyoka, from the equations of motion run on its symbols."""

import time
import weakref
from collections.abc import Callable, Sequence
from copy import copy
from functools import cache
from math import isfinite
from operator import add, mul, neg, sub, truediv
from typing import Any, NamedTuple
from weakref import WeakKeyDictionary

import numpy as np

from pendpin.dynamics.compiling import EquationsOfMotion
from pendpin.dynamics.dynamics import Dynamics
from pendpin.effects import Effect
from pendpin.engines import Derivative, Engine, Function, ProgressCallback
from pendpin.engines.machine.tape import Recording
from pendpin.errors import InputError, MissingLibrary, choices
from pendpin.ground.arrays import Array
from pendpin.ground.libraries import heyoka, version, wait_for
from pendpin.integrators.base import FREE, NOT_FINITE, Integrator, Segment, StepPlan
from pendpin.scene import Scene, event_methods

MAX_JOINTS = 20  # ten rods compile in about half a minute
# Joints up to which heyoka writes the code out whole. Two rods take 12 s to compile so, and 0.7 s in the compact form.
SMALL = 2
COMPENSATED = 1e-15  # tolerances below are met with compensated sums in the series
FIRST_STEP = float(np.exp(-2))  # of the radius of convergence: the best there is (Jorba, Zou)
LONGEST_STEP = 2.0  # times the shortest time of an effect: the longest step of a series, which knows all derivatives
STEPS_AT_ONCE = 4096  # between two calls of the progress callback


class CompiledSeries(NamedTuple):
    """heyoka's integrator of one structure and tolerance, which further runs copy."""

    first: Any
    free: list[Any]  # copies that no run uses
    compile_seconds: float  # s, of the run that compiled it


class SeriesMemory(NamedTuple):
    """What series keep from segment to segment."""

    motion: Array  # (size,), the state before it is projected


class Taylor(Integrator):
    """Adaptive order and step (A. Jorba, M. Zou, Experimental Mathematics 14 (2005)); an evaluation is a whole series."""

    # Its state is kept from segment to segment without projection, so that no digits are lost between them.

    @classmethod
    def for_scene(cls, scene: Scene, dynamics: Dynamics) -> "Taylor":
        assert scene.solver.tolerance is not None
        return cls(dynamics.effects, scene.solver.tolerance, scene.start.time)

    def __init__(self, effects: Sequence[Effect], tolerance: float, start: float = 0.0) -> None:
        self._heyoka = heyoka()
        for i, effect in enumerate(effects):
            if not effect.smooth:
                rough = f"effects[{i}]: {effect.kind} is not smooth"
                raise InputError(f"{rough}, and solver.method: taylor needs smooth effects; take dop853")
        self._effects, self.tolerance, self._start, self._compiling = effects, tolerance, start, 0.0
        self.library, self.version = "heyoka", version("heyoka")

    def equations(self, engine: Engine, progress: ProgressCallback) -> tuple[Derivative, Callable[[], int]]:
        """Compile the series; the derivative is that of the engine, the count is of steps."""
        begin = time.thread_time()
        self._integrator = self.compiled(engine)
        self.compile_seconds, self._steps, self._progress = time.thread_time() - begin + self._compiling, 0, progress
        return engine.derivative(lambda t: None)[0], lambda: self._steps

    def memory(self, y: Array) -> SeriesMemory:
        return SeriesMemory(y)

    def integrate(self, derivative: Derivative, y: Array, times: Array, plan: StepPlan = FREE) -> Segment:
        series, before, size = self._integrator, self._steps, len(self._integrator.state)
        if len(y) > size:
            raise InputError(f"energy_balance: taylor does not integrate work, but {choices(event_methods())} do")
        memory = plan.memory or self.memory(y)
        assert isinstance(memory, SeriesMemory)
        series.time, series.state[:] = times[0], memory.motion
        if plan.first is None:
            # The first step is chosen by all coefficients: by the last two, as heyoka's are, it may go far beyond where
            # series converge. From rest at right angles to gravity, three of four coefficients vanish.
            series.step(max_delta_t=0.0, write_tc=True)
            coefficients = np.abs(series.tc[:, 1:]) / max(1.0, np.abs(series.state).max())
            fastest = (coefficients ** (1 / np.arange(1, coefficients.shape[1] + 1))).max()
            if fastest > 0:
                half = min(float(times[1] - times[0]), plan.longest) / 2
                slow = fastest * half <= FIRST_STEP  # of a rate of 1e-300 the quotient overflows
                series.step(max_delta_t=half if slow else FIRST_STEP / fastest)
                self._steps += 1
        states, done, failure = np.empty((len(times), len(y))), 1, None
        states[0] = y
        while done < len(times) and failure is None:
            if not isfinite(series.time):  # a coefficient overflows
                return Segment(states[:done], self._steps - before, NOT_FINITE, self.memory(y))
            self._progress(series.time)
            ahead = times[done - 1 :].copy()
            ahead[0] = series.time
            limits = {"max_steps": STEPS_AT_ONCE, "max_delta_t": LONGEST_STEP * plan.longest}
            outcome, _, _, steps, _, reached = series.propagate_grid(ahead, **limits)
            states[done : done + len(reached) - 1] = reached[1:]
            done, self._steps = done + len(reached) - 1, self._steps + steps
            if outcome == self._heyoka.taylor_outcome.err_nf_state:
                failure = NOT_FINITE
        return Segment(states[:done], self._steps - before, failure, SeriesMemory(series.state.copy()))

    def compiled(self, engine: Engine) -> Any:
        """heyoka's integrator of the engine's state. Raises InputError for what it does not take."""
        begin, joints = time.thread_time(), len(engine.model.joints)
        if engine.compiles:
            raise InputError("solver.engine: taylor compiles series of its own; leave solver.engine out")
        if joints > MAX_JOINTS:
            most = f"{MAX_JOINTS // 2} rods, or {MAX_JOINTS} joints"
            raise InputError(f"solver.method: taylor takes up to {most}; this model has {joints}: take dop853")
        equations, numbers = equations_with_numbers(engine, self._effects, self._start)
        recording = equations.recording

        def compile_series() -> tuple[Any, float]:
            """heyoka's integrator, and the s in which it was compiled."""
            begin, (symbols, rates) = time.thread_time(), expressions(self._heyoka, recording)
            series = self._heyoka.taylor_adaptive(
                list(zip(symbols, rates, strict=True)),
                np.zeros(recording.state_size()),
                tol=self.tolerance,
                high_accuracy=self.tolerance < COMPENSATED,
                compact_mode=joints > SMALL,
            )
            return series, time.thread_time() - begin

        if self.tolerance not in equations.series:
            first, self._compiling = wait_for(compile_series)
            took = time.thread_time() - begin + self._compiling
            equations.series[self.tolerance] = CompiledSeries(first, [], took)
        first, free, _ = equations.series[self.tolerance]
        try:  # one that no other run uses, until this one is gone: a copy takes a millisecond
            series = free.pop()
        except IndexError:
            series = copy(first)
        weakref.finalize(self, free.append, series).atexit = False
        series.pars[:] = numbers
        return series


_known = WeakKeyDictionary[Engine, tuple[Function, list[float]]]()


def equations_with_numbers(engine: Engine, effects: Sequence[Effect], start: float) -> tuple[Function, list[float]]:
    """The equations of an engine with the effects that it was bound with, and the series' parameters: kept as it is."""
    if (known := _known.get(engine)) is None:
        equations, parameters = EquationsOfMotion(engine, effects, start).function()
        known = _known[engine] = equations, run_time_parameters(equations.recording)(parameters.shared)
    return known


@cache
def start_compiler() -> float:
    """The s of a first compilation, that of y' = -y, in which heyoka's LLVM starts: 0.08 s, once. 0 without heyoka."""
    # Called before the first series, it keeps that out of the time of whichever is compiled first.
    try:
        hy = heyoka()
    except MissingLibrary:
        return 0.0

    def compile_decay() -> float:
        begin, y = time.thread_time(), hy.make_vars("y")
        hy.taylor_adaptive([(y, -y)], [1.0], tol=0.1, compact_mode=True)
        return time.thread_time() - begin

    return wait_for(compile_decay)


def run_time_parameters(recording: Recording) -> Callable[[Sequence[float]], list[float]]:
    """A function for what the series of a recording take as par[i], from the values of the recording's parameters."""
    tape = recording.tape
    fixed = tape.fixed_operands(recording.places)
    needed = tape.needed(fixed)

    def evaluate(values: Sequence[float]) -> list[float]:
        cells = tape.values(needed, values)
        return [cells[place] for place in fixed]

    return evaluate


def expressions(hy: Any, recording: Recording) -> tuple[list[Any], list[Any]]:
    """heyoka's variables of the state, and its rates; what depends on parameters alone as parameters of its own."""
    tape, symbols = recording.tape, [hy.make_vars(f"y{i}") for i in range(recording.state_size())]
    functions = {"add": add, "sub": sub, "mul": mul, "div": truediv, "neg": neg, "pow": pow}
    terms = {place: hy.par[cell] for cell, place in enumerate(tape.fixed_operands(recording.places))}
    for place in tape.needed(recording.places):
        name, *operands = tape.operations[place]
        if name == "number":
            terms[place] = hy.expression(operands[0])
        elif name == "time":
            terms[place] = hy.time
        elif name == "state":
            terms[place] = symbols[operands[0]]
        elif not tape.fixed[place]:
            function = functions.get(name) or getattr(hy, name)
            terms[place] = function(*(terms[x] for x in operands))
    return symbols, [terms[place] for place in recording.places]

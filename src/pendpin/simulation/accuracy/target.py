"""Accuracy as the target: the method and its setting that bring the tips within a given error.

The scene is run with a coarse setting and with finer ones. Three runs in a row give an estimate of the error (estimate.py),
a run that is pushed off gives what rounding does (rounding.py); the finest run is returned where both together are
within the target. Else the setting is made finer, as far as that can help.
"""

from dataclasses import replace

import numpy as np

from pendpin.arrays import Array
from pendpin.dynamics.acting import built_in
from pendpin.engines import ProgressCallback
from pendpin.errors import RunError
from pendpin.model.build import build
from pendpin.scene import Scene
from pendpin.simulation.accuracy import rounding
from pendpin.simulation.accuracy.estimate import DISAGREEMENT, NOISE, SMALL, Estimate, Gaps, estimate
from pendpin.simulation.accuracy.methods import independent, refinement_of, with_method
from pendpin.simulation.accuracy.refinement import IMPLICIT, MOST_STEPS, RUNGE_KUTTA, STEADY, Refinement
from pendpin.simulation.accuracy.runs import Attempt, Runs, alike, at_rest, extent, gap, length_of
from pendpin.simulation.limits import Deadline
from pendpin.trajectory import Trajectory

FARTHEST = 1e4  # how much smaller than the last error the next may be
BLIND = 100.0  # the same, if the runs are too coarse for an estimate
LIKELY = 0.85  # the power of the promised factor by which gaps fall as a rule
MARGIN = 4.0  # by which the next error should be below the target
NEGLIGIBLE = 1e-3  # of the target: smaller gaps need not be small compared with the motion
LAST_NEGLIGIBLE = 0.1  # the same, of runs that cannot be finer
LEAST_OF_ANOTHER = 1e-13  # tolerance of another method
OF_ANOTHER = 1e-3  # of the target, over what the motion magnifies errors by: the tolerance of another method, at most
HARMLESS = 0.1  # of the target: a bound on rounding that needs no measurement
HOPELESS = 10.0  # times the target: rounding of a coarse run that no finer run needs to confirm
UNSTABLE = 1e-11  # rounding error of a motion that magnifies errors ten thousand times: no claim is below NEGLIGIBLE
GROWING = 1e-13  # rounding error of a motion that magnifies errors a hundred times and more
SAFETY = 6.0  # times the estimate there: its errors follow no law (measured near unstable rests, up to 5.1)
OTHER_STEPS = 4.0  # times the distance of a run with other steps: the error of a motion that magnifies errors
SURE = 1e-12  # tolerance of a run whose motion is as stable as the true one
EPS = float(np.finfo(float).eps)


def run_to_accuracy(scene: Scene, energy_balance: bool, progress: ProgressCallback, deadline: Deadline) -> Trajectory:
    """The motion of a scene to the accuracy of its solver; as `simulate`, which see."""
    scene = with_method(scene, energy_balance)
    runs = Runs(scene, energy_balance, progress, deadline)
    search = _Search(scene, runs, refinement_of(scene, runs))
    if not scene.duration:
        return search.result(0.0)
    while (found := search.go_on()) is None:
        pass
    return found


class _Search:
    """The runs of a scene from coarse to fine, and the estimates of their errors."""

    def __init__(self, scene: Scene, runs: Runs, refinement: Refinement) -> None:
        self.runs, self.refinement, self.target = runs, refinement, scene.solver.accuracy or 0.0
        self.scene = scene
        self.may_jump = refinement.method in IMPLICIT and not built_in(scene.effects)
        first = scene.by(refinement.method, refinement.first)
        run, self.units = rounding.first_run(runs, first, self.target) if scene.duration else (runs.run(first), 0.0)
        self.first = Attempt(first, refinement.first, run)
        self.attempts = [self.first]
        self.length = length_of(build(scene.model), self.last.run)
        self.shifted: Array | None = None  # the gap (n,) between the first run, which is shifted, and the second
        self.rounding: Array | None = None
        if scene.duration:
            self._refuse_start(first)

    @property
    def last(self) -> Attempt:
        """The finest run so far."""
        return self.attempts[-1]

    @property
    def finest(self) -> bool:
        """Whether there is no finer setting."""
        return self.last.setting <= self.refinement.least

    def go_on(self) -> Trajectory | None:
        """One more run: its result if it meets the target, else None. Raises RunError if no run can meet it."""
        setting = self.refinement.finer(self.last.setting, self._factor())
        scene = self.scene.by(self.refinement.method, setting)
        run = self.runs.unlike(scene, self.last.run)
        self.attempts.append(Attempt(scene, setting, run))
        if self.shifted is None:
            self.shifted = self._gap(-2, -1)
        if self._same() and not at_rest(run):
            del self.attempts[-2]
            return self._met(self._against_another_method(), "finer settings give the same run")
        if len(self.attempts) < 3:
            return None
        del self.attempts[:-3]
        verdict = self._estimate()
        if self.attempts[0] is self.first and verdict.lost:
            self._refuse_chaos()
        if verdict.error[-1] <= self.target or self.finest or (verdict.small and not verdict.regular):
            self._measure_rounding(self.attempts[-2 if verdict.small else -1])
            verdict = self._estimate()
        if verdict.error[-1] > self.target:
            return self._met(verdict.error, self._reason(verdict))
        if self.may_jump or self._hardly_moves() or self._may_damp():
            error = np.maximum(verdict.error, self._against_another_method())
            return self._met(error, "another method gives another motion")
        if self._unstable() and self.refinement.method in RUNGE_KUTTA:
            error = np.maximum(verdict.error, self._against_other_steps())
            return self._met(error, f"other steps of {self.refinement.method} give another motion")
        return self._met(verdict.error, "")

    def _met(self, error: Array, reason: str) -> Trajectory | None:
        """The last run, if its error (n,) is within the target. Raises RunError with the reason if no other can do it."""
        if error[-1] <= self.target:
            return self.result(max(float(error[-1]), NEGLIGIBLE * self.target * self._unstable()))
        if self.finest or self._rounding_is_too_large():
            raise self._refused(error, reason)
        return None

    def _rounding_is_too_large(self) -> bool:
        """Whether rounding alone keeps every claim above the target."""
        return self.rounding is not None and self._claimed(self.rounding)[-1] > self.target

    def _hardly_moves(self) -> bool:
        """Whether the last run moves less than rounding errors may do, or than the target.

        Near an unstable rest a method may take long steps that see no growth; all its runs then stay there and agree.
        """
        assert self.rounding is not None
        return extent(self.last.run, self.length) <= max(NOISE * float(self.rounding[-1]), self.target)

    def _may_damp(self) -> bool:
        """Whether implicit steps may damp what grows: all runs then fall behind alike, and their gaps say little.

        The steps that an accuracy below the reach of another method needs are too short for that.
        """
        assert self.rounding is not None
        grows = self.rounding[-1] > GROWING and self._of_another() > LEAST_OF_ANOTHER
        return bool(grows) and self.refinement.method in IMPLICIT

    def _of_another(self) -> float:
        """The tolerance of another method whose error is small beside the target, where it has one so small."""
        assert self.rounding is not None
        return OF_ANOTHER * self.target * EPS / max(float(self.rounding[-1]), EPS)

    def _unstable(self) -> bool:
        """Whether the motion magnifies errors so much that they follow no law."""
        return self.rounding is not None and bool(self.rounding[-1] > UNSTABLE)

    def _same(self) -> bool:
        """Whether the last two runs are the same, or as close as if they had the same steps."""
        if alike(self.attempts[-2].run, self.last.run):
            return True
        same_steps = self._promised(-2, -1) ** self.refinement.pace <= self.refinement.scatter
        return same_steps and self._gap(-2, -1)[-1] <= SMALL * extent(self.last.run, self.length)

    # --- estimates --------------------------------------------------------------------------------------------------

    def _gap(self, one: int, other: int) -> Array:
        """The largest tip distance so far (n,) between two attempts, over the length."""
        return gap(self.attempts[one].run, self.attempts[other].run, self.length, len(self.runs.times))

    def _promised(self, coarse: int, fine: int) -> float:
        """By what factor the error of one attempt should be smaller than that of another."""
        one, other = self.attempts[coarse], self.attempts[fine]
        if one is self.first or at_rest(other.run):  # shifted, which takes further steps; steps of a rest say nothing
            return self.refinement.promised(one.setting, other.setting)
        more = other.run.stats.steps / max(one.run.stats.steps, 1)
        return self.refinement.promised(one.setting, other.setting, more)

    def _estimate(self) -> Estimate:
        """The estimate from the last three runs; with rounding errors once they are measured."""
        gaps = Gaps(
            *(self._gap(-3, -2), self._gap(-2, -1)),
            (self._promised(-3, -2), self._promised(-2, -1)),
            *(self.refinement.pace, self.refinement.scatter),
        )
        negligible = self.target * (LAST_NEGLIGIBLE if self.finest else NEGLIGIBLE)
        known = np.full(len(gaps.first), EPS) if self.rounding is None else self.rounding
        found = estimate(gaps, extent(self.last.run, self.length), known, negligible)
        return replace(found, error=self._claimed(found.error))

    def _claimed(self, error: Array) -> Array:
        """The error (n,) to claim for an estimate."""
        return SAFETY * error if self._unstable() else error

    def _against_other_steps(self) -> Array:
        """The error (n,) of the last run, from its distance to a run of the same tolerance that begins with other steps."""
        other = self.runs.run(self.last.scene, 2)
        return OTHER_STEPS * gap(self.last.run, other, self.length, len(self.runs.times))

    def _against_another_method(self) -> Array:
        """The error (n,) of a run that no finer setting changes, from its difference to a run of another method."""
        self._measure_rounding(self.last)
        assert self.rounding is not None
        method = next(method for method in independent(self.scene) if method != self.refinement.method)
        own = self.last.setting if self.refinement.spacing is None else 1.0
        other = self.runs.run(self.scene.by(method, max(min(own, self._of_another()), LEAST_OF_ANOTHER)))
        apart = gap(self.last.run, other, self.length, len(self.runs.times))
        return DISAGREEMENT * apart + self.rounding

    def _measure_rounding(self, base: Attempt) -> None:
        """Bound rounding errors by the shift of the first run, or measure them beside the run `base`."""
        if self.rounding is None and self.shifted is not None:
            self.rounding = rounding.bounded(self.shifted, self.units, self.last.run, self.length)
            if self.rounding[-1] > HARMLESS * self.target:
                self.rounding = rounding.of_motion(self.runs, base, self.last, self.target, self.length)

    def _factor(self) -> float:
        """How much smaller the next error should be. Raises RunError if that would take too many steps."""
        if len(self.attempts) == 1:
            return self.refinement.usual
        usual, pace, scatter = self.refinement.usual, self.refinement.pace, self.refinement.scatter
        promised, last = self._promised(-2, -1), self._gap(-2, -1)[-1]
        if last > SMALL * extent(self.last.run, self.length):
            return self._affordable(usual if len(self.attempts) == 2 or self.refinement.spacing else BLIND)
        error = last * max(scatter / max(promised - scatter, 1.0), promised**-LIKELY)
        return self._affordable((scatter * (1 + MARGIN * error / self.target)) ** (1 / pace))

    def _affordable(self, factor: float) -> float:
        """The factor within the limits of one more run. Raises RunError if it would take too many steps."""
        one, other = self.attempts[-2:]
        more = np.log(max(other.run.stats.steps, 1) / max(one.run.stats.steps, 1)) / np.log(one.setting / other.setting)
        power = 1 / self.refinement.order if self.refinement.spacing else max(float(more), 0.0)
        needed = other.run.stats.steps * factor**power
        if needed > MOST_STEPS:
            seconds = needed * other.run.stats.seconds / max(other.run.stats.steps, 1)
            raise self._refused(np.full(len(self.runs.times), np.inf), self.refinement.too_many(needed, seconds))
        return float(np.clip(factor, self.refinement.smallest, FARTHEST))

    def _refuse_chaos(self) -> None:
        """Raise RunError if the motion magnifies rounding far beyond the target.

        The run so far is a hint. It is wrong, and may be unstable where the true motion is not, as a coarse run gains or
        loses energy: a run to a small tolerance decides.
        """
        method = self.refinement.method if self.refinement.method in STEADY else "dop853"
        for scene in (self.attempts[1].scene, self.scene.by(method, SURE)):
            like = replace(self.last, scene=scene)
            found = rounding.of_motion_like(self.runs, like, HOPELESS * self.target, self.length)
            if found[-1] <= HOPELESS * self.target:
                return
        self.rounding = found
        verdict = self._estimate()
        raise self._refused(verdict.error, self._reason(verdict))

    # --- results ----------------------------------------------------------------------------------------------------

    def result(self, error: float | None) -> Trajectory:
        """The finest run with its error."""
        run = self.runs.at_output_times(self.last.run)
        return replace(run, stats=replace(run.stats, accuracy=self.target, error=error, all_seconds=self.runs.seconds))

    def _refuse_start(self, first: Scene) -> None:
        """Raise RunError if the rounding error of the start is above the target."""
        moved = rounding.of_start(first, self.length)
        if moved > self.target:
            self.attempts = [replace(self.last, run=self.runs.run(first))]  # not shifted
            q = self.last.run.q[0]
            joint = int(np.argmax(np.abs(q)))
            where, off = f"{self.last.run.joints[joint]} = {q[joint]:.10g}", np.spacing(abs(q[joint]))
            raise RunError(
                f"accuracy {self.target:g} is not met: it is finer than the start, where {where} is rounded to {off:.1g}",
                self.result(moved),
            )

    def _reason(self, verdict: Estimate) -> str:
        """Why no other run can meet the target."""
        gaps, stats = verdict.gaps, self.last.run.stats
        if self._rounding_is_too_large():
            return (
                "rounding errors of the start and of the steps grow beyond that before the end, as in chaotic and unstable "
                "motions: no setting meets it over the whole run"
            )
        if not verdict.small:
            return (
                f"runs with the finest settings are {gaps.second[-1]:.1g} of the length apart, not small beside "
                f"the motion ({extent(self.last.run, self.length):.1g})"
            )
        if not verdict.regular:
            return (
                f"the gap between runs has fallen {gaps.fallen:.2g} times, where {stats.method} promises "
                f"{gaps.promised[0]:.2g}"
            )
        return f"{stats.setting} is the finest of {stats.method}"

    def _refused(self, error: Array, why: str) -> RunError:
        """The error with its reason and the time up to which the target is met; error (n,) over the length."""
        run = self.last.run
        held = run.t[: int(np.argmax(np.append(error[: len(run.t)] > self.target, True)))]
        up_to = f"it is met up to t = {held[-1]:g} s" if len(held) > 1 else "it is not met at any time"
        last = error[-1] if np.isfinite(error[-1]) else self._gap(-2, -1)[-1]
        about = f"the error is about {last:.1g}" if np.isfinite(last) else "the run does not reach its end"
        setting = f"with {run.stats.method}, {run.stats.setting}, {about} and {up_to}"
        further = "" if self.finest else "; a finer setting reaches further"
        message = f"accuracy {self.target:g} is not met: {why}; {setting}{further}"
        return RunError(message, self.result(float(last) if np.isfinite(last) else None))

"""Accuracy as the target: the method and its setting that bring the tips within a given error.

The scene is run with a coarse setting and with finer ones. Three runs in a row give an estimate of the error,
a shifted run shows the effect of rounding (estimate.py); the finest run is returned where both together are within the
target. Else the setting is made finer, as far as that can help. Where the finest setting gives no estimate, the distance to
a run of another method decides; and where the scene names no method, others are tried before the target is refused.
"""

from dataclasses import replace

import numpy as np

from pendpin.dynamics.acting import built_in
from pendpin.engines import ProgressCallback
from pendpin.errors import Halted, RunError
from pendpin.ground.arrays import EPS, Array
from pendpin.runs.accuracy import estimate
from pendpin.runs.accuracy.runs import (
    Attempt,
    Runs,
    are_equal,
    choose_method,
    choose_other_methods,
    choose_refinement,
    is_at_rest,
    list_alternatives,
)
from pendpin.runs.accuracy.thresholds import COMPARISON, ESTIMATE, INSTABILITY, SEARCH, SETTING
from pendpin.runs.limits import Deadline
from pendpin.runs.run import ENERGY_ERROR, balanced, prepare
from pendpin.scene import Scene, method_of
from pendpin.scene.methods import EXPLICIT
from pendpin.trajectory import RunRecord

ROUNDING_GROWS = (
    "rounding errors of the start and of the steps grow beyond that before the end, as in chaotic and unstable motions: "
    "no setting meets it over the whole run"
)


class NotMet(RunError):
    """An accuracy that a method does not meet; another one may. `reached`: s, up to which it is met."""

    reached = 0.0


def run_to_accuracy(scene: Scene, energy_balance: bool, progress: ProgressCallback, deadline: Deadline) -> RunRecord:
    """The motion of a scene to the accuracy of its solver."""
    if scene.duration and (scene.solver.accuracy or 0.0) < EPS:
        alone = scene.model_copy(update={"duration": 0.0, "solver": scene.solver.with_settings(samples=1)})
        raise RunError(
            f"accuracy {scene.solver.accuracy:g} is not met: it is finer than numbers of 64 bits, which are rounded to "
            f"{EPS:.1g} of themselves",
            run_to_accuracy(alone, energy_balance, progress, deadline),
        )
    runs = Runs(choose_method(scene, prepare(scene, energy_balance, deadline)), progress, deadline)
    try:
        return _Search(runs.scene, runs).run()
    except NotMet as refusal:
        farthest = refusal
        for other in list_alternatives(scene, runs):
            try:
                return _Search(other, runs).run()
            except Halted:
                raise
            except NotMet as another:
                farthest = max(farthest, another, key=lambda one: one.reached)
            except RunError:
                continue
        raise farthest from None


class _Search:
    """The runs of a scene from coarse to fine, and the estimates of their errors."""

    def __init__(self, scene: Scene, runs: Runs) -> None:
        self.scene, self.runs, self.target = scene, runs, scene.solver.accuracy or 0.0
        self.refinement = choose_refinement(scene, runs)
        self.method = method_of(self.refinement.method)
        first = scene.by(self.method.name, self.refinement.first)
        run, self.units = estimate.run_first(runs, first, self.target) if scene.duration else (runs.run(first), 0.0)
        self.first = Attempt(first, self.refinement.first, run)
        self.attempts = [self.first]
        self.ruler = runs.ruler(run)
        self.first_gap: Array | None = None  # (n,), between the first run, which is shifted, and the second
        self.rounding: estimate.RoundingError | None = None
        self.chaos_denied = False  # whether a run to a small tolerance has shown that finer ones may meet the target
        self.assumed = estimate.list_assumptions(scene.effects)

    @property
    def last(self) -> Attempt:
        """The finest run so far."""
        return self.attempts[-1]

    @property
    def at_finest(self) -> bool:
        """Whether no finer setting is left."""
        return self.last.setting <= self.refinement.least

    def run(self) -> RunRecord:
        """The run that meets the target. Raises NotMet, or RunError where no method can meet it."""
        if not self.scene.duration:
            return self._complete(0.0)
        error = EPS / 2 * float(np.abs(self.runs.start[0]).sum())  # so far rounding of the start may move a tip
        if error > self.target:
            self.attempts = [replace(self.last, run=self.runs.run(self.first.scene))]  # not shifted
            q = self.last.run.q[0]
            joint = int(np.argmax(np.abs(q)))
            where, off = f"{self.last.run.joints[joint]} = {q[joint]:.10g}", np.spacing(abs(q[joint]))
            why = f"it is finer than the start, where {where} is rounded to {off:.1g}"
            raise RunError(f"accuracy {self.target:g} is not met: {why}", self._complete(error))
        while (run := self._refine()) is None:
            pass
        return run

    def _refine(self) -> RunRecord | None:
        """One more run: its result if it meets the target, else None. Raises RunError if no run can meet it."""
        setting = self.refinement.finer(self.last.setting, self._choose_factor())
        solver = self.first.scene.solver.model_copy(update={self.method.setting: setting})
        scene = self.first.scene.model_copy(update={"solver": solver})
        run = self.runs.run_differently(scene, self.last.run)
        self._add(scene, setting, run)
        if self.first_gap is None:
            self.first_gap = self.last.gap
        same = are_equal(self.attempts[-2].run, run)
        alike = self._predict_fall(-2, -1) ** self.refinement.pace <= self.refinement.scatter
        if not same and alike:  # as good as equal
            same = bool(self.last.gap[-1] <= ESTIMATE.small * self.ruler.measure_extent(run))
        if same and not is_at_rest(run):
            del self.attempts[-2:]
            self._add(scene, setting, run)
            return self._decide(self._compare_methods(), "finer settings give the same run")
        if len(self.attempts) < 3:
            return None
        del self.attempts[:-3]
        verdict = self._estimate()
        if not self.chaos_denied and (verdict.lost or (self.refinement.spacing and not verdict.small)):
            self._refuse_chaos()
        if verdict.error[-1] <= self.target or self.at_finest or (verdict.small and not verdict.regular):
            self._find_rounding(self.attempts[-2 if verdict.small else -1])
            verdict = self._estimate()
        if verdict.error[-1] <= self.target:
            return self._confirm(verdict.error)
        error, reason = verdict.error, self._explain(verdict)
        if self.at_finest and not self._rounding_is_too_large():
            error = np.minimum(error, self._compare_methods())
        return self._decide(error, reason)

    def _confirm(self, error: Array) -> RunRecord | None:
        """The last run if, where its estimate (n,) alone is not enough, further evidence supports it; as `_refine`."""
        assert self.rounding is not None
        rounding, implicit, own = self.rounding.last, self.method.implicit, not built_in(self.scene.effects)
        # Near an unstable rest a method may take long steps that see no growth; all its runs then stay there and agree.
        hardly_moves = self.ruler.measure_extent(self.last.run) <= max(ESTIMATE.noise * rounding, self.target)
        # Implicit steps may damp what grows: all runs then fall behind alike. The steps that an accuracy below the reach
        # of another method needs are too short for that.
        may_damp = rounding > INSTABILITY.growing and self._bound_comparison() > COMPARISON.least_tolerance and implicit
        if (implicit and own) or hardly_moves or may_damp:
            return self._decide(np.maximum(error, self._compare_methods()), "another method gives another motion")
        explicit = self.method.family == EXPLICIT and self.method.setting == "tolerance"
        if self._is_unstable() and explicit:  # all steps follow the first one
            other = self.runs.run(self.last.scene, 2)  # of the same tolerance, which begins with other steps
            gap = self.ruler.measure_gap(self.last.run, other)
            reason = f"other steps of {self.method.name} give another motion"
            return self._decide(np.maximum(error, INSTABILITY.other_steps * gap), reason)
        return self._decide(error, "")

    def _decide(self, error: Array, reason: str) -> RunRecord | None:
        """The last run, if its error (n,) is within the target. Raises RunError with the reason if none can do it."""
        if error[-1] <= self.target and self.assumed and self.runs.dynamics.contacts is None:
            longest = self.scene.duration / COMPARISON.short_steps
            try:  # it shows what acts for less than the steps so far
                short = self.runs.run(self.last.scene, longest=longest)
            except RunError as failure:
                if isinstance(failure, Halted) or self.refinement.spacing is not None:
                    raise
                tolerance = max(self.last.setting, COMPARISON.least_tolerance)
                other = self.scene.by(choose_other_methods(self.runs, self.method.name)[0], tolerance)
                short = self.runs.run(other, longest=longest)  # lsoda's iteration may not converge in steps so short
            error = np.maximum(error, COMPARISON.short * self.ruler.measure_gap(self.last.run, short))
            names = ", ".join(note.partition(")")[0] + ")" for note in self.assumed)
            reason = f"steps of {longest:.2g} s give another motion: {names} may act for less"
        if error[-1] <= self.target:
            run = self.last.run
            try:
                good = run.sound == balanced(run) == len(self.runs.times)
            except np.linalg.LinAlgError:
                good = False
            run = run if good else self.runs.run(self.last.scene, whole=True)  # cut where its energies do not add up
            if len(run.t) == len(self.runs.times):
                self.attempts[-1] = replace(self.last, run=run)
                return self._complete(max(float(error[-1]), ESTIMATE.negligible * self.target * self._is_unstable()))
            error, reason = np.full(len(error), np.inf), ENERGY_ERROR
        if self._rounding_is_too_large():
            raise self._refusal(RunError, error, reason)
        if self.at_finest:
            raise self._refusal(NotMet, error, reason)
        return None

    def _rounding_is_too_large(self) -> bool:
        """Whether rounding alone keeps every claim above the target."""
        return self.rounding is not None and self.rounding.last > self.target

    def _is_unstable(self) -> bool:
        """Whether the motion magnifies errors so much that they follow no law."""
        return self.rounding is not None and self.rounding.magnified_beyond(INSTABILITY.unstable)

    # --- estimates --------------------------------------------------------------------------------------------------

    def _add(self, scene: Scene, setting: float, run: RunRecord) -> None:
        before = self.attempts[-1] if self.attempts else self.first
        self.attempts.append(Attempt(scene, setting, run, self.ruler.measure_gap(before.run, run)))

    def _predict_fall(self, coarse: int, fine: int) -> float:
        """By what factor the error of one attempt should be smaller than that of another."""
        before, after = self.attempts[coarse], self.attempts[fine]
        more = np.inf  # the first run is shifted, so it takes more steps; those of a rest say nothing
        if before is not self.first and not is_at_rest(after.run):
            more = after.run.stats.steps / max(before.run.stats.steps, 1)
        return self.refinement.predict_fall(before.setting, after.setting, more)

    def _estimate(self) -> estimate.Estimate:
        """The estimate from the last three runs; with rounding errors once they are measured."""
        first, second = self.attempts[-2].gap, self.last.gap
        promised = self._predict_fall(-3, -2), self._predict_fall(-2, -1)
        gaps = estimate.Gaps(first, second, promised, self.refinement.pace, self.refinement.scatter)
        negligible = self.target * (ESTIMATE.negligible_at_finest if self.at_finest else ESTIMATE.negligible)
        rounding = np.full(len(first), EPS) if self.rounding is None else self.rounding.error
        safety = INSTABILITY.safety if self._is_unstable() else 1.0
        return estimate.estimate_error(gaps, self.ruler.measure_extent(self.last.run), rounding, negligible, safety)

    def _compare_methods(self) -> Array:
        """The error (n,) of the last run from its distance to a run of another method, and from rounding."""
        self._find_rounding(self.last)
        assert self.rounding is not None
        method = choose_other_methods(self.runs, self.method.name)[0]
        setting = self.last.setting if self.refinement.spacing is None else 1.0
        tolerance = max(min(setting, self._bound_comparison()), COMPARISON.least_tolerance)
        gap = self.ruler.measure_gap(self.last.run, self.runs.run(self.scene.by(method, tolerance)))
        return ESTIMATE.disagreement * gap + self.rounding.error

    def _bound_comparison(self) -> float:
        """The tolerance of another method whose error is small beside the target, where it has one so small."""
        assert self.rounding is not None
        return COMPARISON.of_target * self.target * EPS / max(self.rounding.last, EPS)

    def _find_rounding(self, base: Attempt) -> None:
        """Bound rounding errors by the shift of the first run, or measure them beside the run `base`."""
        if self.rounding is None and self.first_gap is not None:
            self.rounding = estimate.bound_rounding(self.first_gap, self.units, self.last.run, self.ruler)
            if self.rounding.last > SEARCH.harmless * self.target:
                self.rounding = estimate.measure_rounding(self.runs, base, self.last, self.target, self.ruler)

    def _bound_error(self) -> Array:
        """A bound (n,) on the error of the last run from its distance to the one before, where three give no estimate."""
        gap = self.last.gap
        rounding = 0.0 if self.rounding is None else self.rounding.error
        return np.where(gap <= ESTIMATE.small, ESTIMATE.disagreement * gap, np.inf) + rounding

    def _choose_factor(self) -> float:
        """How much smaller the next error should be. Raises RunError if that would take too many steps."""
        factor, pace, scatter = self.refinement.usual, self.refinement.pace, self.refinement.scatter
        if len(self.attempts) == 1:
            return factor
        fall, gap = self._predict_fall(-2, -1), self.last.gap[-1]
        if gap <= ESTIMATE.small * self.ruler.measure_extent(self.last.run):
            error = gap * max(scatter / max(fall - scatter, 1.0), fall**-SEARCH.likely)
            factor = (scatter * (1 + SEARCH.margin * error / self.target)) ** (1 / pace)
        before, last = self.attempts[-2:]
        steps = max(last.run.stats.steps, 1)
        more = np.log(steps / max(before.run.stats.steps, 1)) / np.log(before.setting / last.setting)
        power = 1 / self.refinement.order if self.refinement.spacing else max(float(more), 0.0)
        needed = last.run.stats.steps * factor**power
        if needed * self.method.step_price > SETTING.most_steps:
            reason = self.refinement.describe_too_many(needed, needed * last.run.stats.seconds / steps)
            raise self._refusal(NotMet, self._bound_error(), reason)
        return float(np.clip(factor, self.refinement.smallest, SEARCH.farthest))

    # --- results ----------------------------------------------------------------------------------------------------

    def _complete(self, error: float | None) -> RunRecord:
        run = self.runs.keep_output_times(self.last.run)
        notes = (*run.stats.notes, *self.assumed)
        figures = {"accuracy": self.target, "error": error, "all_seconds": self.runs.seconds, "notes": notes}
        return replace(run, stats=replace(run.stats, **figures))

    def _refuse_chaos(self) -> None:
        """Raise RunError if the motion magnifies rounding far beyond the target."""
        # The run so far is a hint: a coarse run gains or loses energy, and may be unstable where the true motion is not. A
        # run to a small tolerance decides. Runs of fixed steps may all end early while they are coarse, and give no hint.
        method = self.method.name if self.method.shows_rounding else "dop853"
        hopeless, sure = INSTABILITY.hopeless * self.target, self.scene.by(method, INSTABILITY.sure)
        hints = [] if self.refinement.spacing else [self.attempts[1].scene]
        for scene in (*hints, sure):
            like = replace(self.last, scene=scene)
            self.rounding = estimate.measure_rounding_of_lost_run(self.runs, like, hopeless, self.ruler)
            if self.rounding.last <= hopeless:
                self.rounding, self.chaos_denied = None, scene is sure
                return
        if not self.method.shows_rounding:
            raise self._refusal(RunError, self._estimate().error, ROUNDING_GROWS)
        for setting in (INSTABILITY.sure, self.refinement.least):  # how far the finest runs reach
            scene = self.scene.by(method, setting)
            self._add(scene, setting, self.runs.run(scene))
        raise self._refusal(RunError, self._bound_error(), ROUNDING_GROWS)

    def _explain(self, verdict: estimate.Estimate) -> str:
        """Why no other run can meet the target."""
        gaps, stats = verdict.gaps, self.last.run.stats
        if self._rounding_is_too_large():
            return ROUNDING_GROWS
        if not verdict.small:
            extent = self.ruler.measure_extent(self.last.run)
            apart = f"runs with the finest settings are {gaps.second[-1]:.1g} of the length apart"
            return f"{apart}, not small beside the motion ({extent:.1g})"
        if not verdict.regular:
            fallen = f"the gap between runs has fallen {gaps.fallen:.2g} times"
            return f"{fallen}, where {stats.method} promises {gaps.promised[0]:.2g}"
        return f"{stats.setting} is the finest of {stats.method}"

    def _refusal(self, kind: type[RunError], error: Array, why: str) -> RunError:
        """The error to raise, with its reason and the time up to which the target is met; error (n,) over the length."""
        run = self.last.run
        t = run.t[self.runs.places[self.runs.places < len(run.t)]]
        good = t[: int(np.argmax(np.append(error[: len(t)] > self.target, True)))]
        up_to = f"it is met up to t = {good[-1]:g} s" if len(good) > 1 else "it is not met at any time"
        last = error[-1] if np.isfinite(error[-1]) else self.last.gap[-1]
        about = f"the error is about {last:.1g}" if np.isfinite(last) else "the run does not reach its end"
        setting = f"with {run.stats.method}, {run.stats.setting}, {about} and {up_to}"
        further = "" if self.at_finest else "; a finer setting reaches further"
        message = f"accuracy {self.target:g} is not met: {why}; {setting}{further}"
        refusal = kind(message, self._complete(float(last) if np.isfinite(last) else None))
        if isinstance(refusal, NotMet):
            refusal.reached = float(good[-1]) if len(good) else 0.0
        return refusal

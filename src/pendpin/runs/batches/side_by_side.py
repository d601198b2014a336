"""Accuracy as the target for cases side by side: Taylor series at ever finer tolerances, each case checked on its own.

A case is done when the estimate from its last three runs (estimate.py) meets the target. What a case gives does not depend
on its neighbours. The rest is left to the search of target.py, which runs one case and says why the target cannot be met.
"""

from collections.abc import Callable, Sequence

import numpy as np

from pendpin.ground.arrays import EPS, Mask
from pendpin.model.kinematics import evaluate_each, marks_at, tip_distance
from pendpin.runs.accuracy.estimate import Gaps, estimate_error
from pendpin.runs.accuracy.methods import TAYLOR, refine_by_tolerance
from pendpin.runs.accuracy.runs import choose_density, choose_length, sample_closely
from pendpin.runs.accuracy.thresholds import ESTIMATE, ROUNDING, SETTING, VECTOR
from pendpin.runs.batches.series import Cases, Motions, Series
from pendpin.scene import Scene


class Ladder:
    """The series of a scene from coarse to fine, made by `make` for a tolerance."""

    def __init__(self, scene: Scene, make: Callable[[float], Series]) -> None:
        self._target, self._every = scene.solver.accuracy or 0.0, choose_density(scene)
        self._times = sample_closely(scene, self._every).times
        self._refinement = refine_by_tolerance(TAYLOR, self._target)
        first = min(VECTOR.coarser * self._target, SETTING.loosest)
        settings = [first / VECTOR.finer**i for i in range(VECTOR.most_series)]
        self.series = [make(setting) for setting in settings if setting >= self._refinement.least]

    def run(self, cases: Cases) -> tuple[Motions, Motions, Mask]:
        """Motions at the output times, those of tolerances 100 times looser, and which cases (c,) meet the target."""
        runs = [series.run(cases, self._times) for series in self.series[:3]]
        met = self._met(cases, runs, self.series[0].tolerance)
        for coarsest, series in zip(self.series[1:], self.series[3:], strict=False):
            if not len(left := np.flatnonzero(~met)):
                break
            few = cases.some(left)
            finer = [*(run.some(left) for run in runs[1:]), series.run(few, self._times)]
            met[left] = self._met(few, finer, coarsest.tolerance)
            for whole, part in zip(runs, finer, strict=True):
                whole.put(left, part)
        every = slice(None, None, self._every)
        looser, finest = (run._replace(t=run.t[every], q=run.q[:, every], v=run.v[:, every]) for run in runs[-2:])
        return finest, looser, met

    @np.errstate(invalid="ignore")  # a case that cannot be integrated to its end does not meet the target
    def _met(self, cases: Cases, runs: Sequence[Motions], coarsest: float) -> Mask:
        """Whether the error of the last of three runs of each case (c,), with rounding, is within the target."""
        points = [evaluate_each(marks_at, run.models, run.q) for run in runs]
        met = np.zeros(len(cases.q), bool)
        for i, model in enumerate(cases.models):
            coarse, middle, fine = (of_case[i] for of_case in points)
            length = choose_length(model, fine)
            pairs = ((coarse, middle), (middle, fine))
            first, second = (np.maximum.accumulate(tip_distance(*pair, length)) for pair in pairs)
            gaps = Gaps(first, second, (VECTOR.finer, VECTOR.finer), self._refinement.pace, self._refinement.scatter)
            rounding = (
                ROUNDING.start_units * EPS * (1 + np.abs(runs[-1].q[i]).max() + first / (VECTOR.step_error * coarsest))
            )
            size = float(tip_distance(fine, fine[:1], length).max())
            alike = not second.any() and np.abs(runs[-1].v[i]).any()  # says nothing of the error
            error = estimate_error(gaps, size, rounding, ESTIMATE.negligible * self._target).error[-1]
            met[i] = error <= self._target and not alike
        return met

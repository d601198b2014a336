"""Fit: from measured swings to a scene with fitted numbers and their errors (docs/fit.md).

May import: graphics, motions, runs and what is below them; no other tool. Reading: data; the free numbers: parameters;
residuals, their derivatives and the search: problem; where it starts: guess; the whole of a fit: fitting; what the result is
worth: uncertainty, correlated_noise, alternatives; what is shown: report, figure.
"""

import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from pendpin.fitting.alternatives import explain_residual
from pendpin.fitting.data import read_swings
from pendpin.fitting.fitting import Setting, Solution, prepare, solve
from pendpin.fitting.parameters import replace_checked, substitute
from pendpin.fitting.prediction import Prediction, compared_samples, fitted_prediction, predict
from pendpin.fitting.report import Fit
from pendpin.fitting.uncertainty import combinations, whiteness
from pendpin.ground.arrays import Array
from pendpin.scene import Data, Scene, chosen_scene


def fit(
    scene: Scene | str | Path,
    data: Any,
    free: str | Sequence[str] = "physics",
    hold_out: Any = None,
    hold_out_start: float = 0.1,
    *,
    robust: bool = False,
    progress: Callable[[str], None] = lambda what: None,
) -> Fit:
    """Fit free numbers of a scene to measured swings, with standard errors and what the data cannot determine.

    Args:
        scene: a Scene with guesses, or the path of a TOML file. Its [data] table says what the columns measure.
        data: the path of a CSV file, several of them, or a table of columns.
        free: key paths such as "model.rods[0].com", and the short forms "physics" (centres of mass, inertias, lengths of
            rods that carry another, frictions, drags) and "friction".
        hold_out: other data, which are predicted.
        hold_out_start: the part of each held-out swing on which its start is fitted, 0 to 1.
        robust: residuals of single samples count less the larger they are (Huber).
        progress: called with the name of each step.

    Returns:
        The Fit.

    Raises:
        InputError: for a scene, data or keys that cannot be used.
        MissingLibrary: without llvmlite.
    """
    begin = time.process_time()
    chosen = chosen_scene(scene)
    setting = prepare(chosen, data, free, robust)
    others = None if hold_out is None else read_swings(hold_out, setting.table)
    compared_samples(others or (), hold_out_start)  # what is wrong with them is said before the search
    solution = solve(setting, progress)
    prediction = None if others is None else predict(setting, solution, others, hold_out_start)
    return _report(setting, solution, prediction, time.process_time() - begin)


def _report(setting: Setting, solution: Solution, prediction: Prediction | None, seconds: float) -> Fit:
    """The report of a solution."""
    values, gradients = _numbers(setting, solution)
    certainty, train = solution.certainty, fitted_prediction(setting, solution)
    follows = train.follows(setting.noise)
    known = {key: certainty.error(g) for key, g in gradients.items() if follows and certainty.determined(g)}
    unsure = tuple(key for key in values if key not in known)
    errors = known if certainty.enough else {}
    ratios = combinations(setting.scene, setting.free, solution.z, certainty, set(unsure)) if follows else ()
    matrix = np.array([gradients[key] for key in errors]).reshape(len(errors), len(solution.x))
    batch = solution.problem.batch
    r = solution.solved.r.reshape(len(batch.swing), -1, len(setting.columns))
    return Fit(
        scene=_fitted(setting, solution),
        values=values,
        errors=errors,
        covariance=matrix @ certainty.covariance @ matrix.T,
        undetermined=unsure,
        combinations=ratios,
        train=train,
        hold_out=prediction,
        noise=dict(zip(setting.columns, setting.noise.tolist(), strict=True)),
        white=whiteness(r),
        inflation=certainty.inflation,
        seconds=seconds,
        setting=setting,
        solution=solution,
    )


def _numbers(setting: Setting, solution: Solution) -> tuple[dict[str, float], dict[str, Array]]:
    """The fitted numbers, and the zeros in the unit of [data], by key path; their gradients by the unknowns (nx,)."""
    free, nx = setting.free, len(solution.x)
    values = dict(zip(free.keys, map(float, free.values(solution.z)), strict=True))
    gradients = {
        key: np.pad(row, (0, nx - len(row))) for key, row in zip(free.keys, free.gradients(solution.z), strict=True)
    }
    for row, name in enumerate(setting.columns):
        if nx > len(solution.z):
            key = f"data.offsets.{name}"
            one, _ = setting.table.in_si(name)
            values[key], gradients[key] = float(solution.offsets[row]) / one, np.eye(nx)[len(solution.z) + row] / one
    return values, gradients


def _fitted(setting: Setting, solution: Solution) -> Scene:
    """The scene with the fitted numbers and zeros."""
    values = [float(value) for value in setting.free.values(solution.z)]
    pairs = zip(setting.columns, solution.offsets, strict=True)
    offsets = {name: float(offset) / setting.table.in_si(name)[0] for name, offset in pairs}
    scene = substitute(setting.scene, setting.free.keys, values, replace_checked)
    table: Data = replace_checked(setting.table, {"offsets": offsets})
    return replace_checked(scene, {"data": table})

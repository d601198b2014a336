"""Fit: from measured swings to a scene with fitted numbers and their errors (docs/fit.md).

May import: graphics, motions, runs and what is below them; no other tool. Reading: data; the free numbers: parameters;
residuals, their derivatives and the search: problem; where it starts: guess; the whole of a fit: fitting; what the result is
worth: uncertainty, alternatives, prediction; what is shown: report.
"""

import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from pendpin.fitting.alternatives import explain_residual
from pendpin.fitting.data import read_swings
from pendpin.fitting.fitting import prepare, solve
from pendpin.fitting.parameters import combinations, substitute
from pendpin.fitting.prediction import compared_samples, fitted_prediction, predict
from pendpin.fitting.report import Fit
from pendpin.fitting.uncertainty import whiteness
from pendpin.ground.arguments import flag, function
from pendpin.scene import Scene, chosen_scene


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
    begin, progress = time.process_time(), function("progress", progress)
    setting = prepare(chosen_scene(scene), data, free, flag("robust", robust))
    others = None if hold_out is None else read_swings(hold_out, setting.table)
    compared_samples(others or (), hold_out_start)  # what is wrong with them is said before the search
    solution = solve(setting, progress)
    prediction = None if others is None else predict(setting, solution, others, hold_out_start)
    seconds = time.process_time() - begin

    chosen, nz, nx, columns = setting.pendulum.free, len(solution.z), len(solution.x), setting.columns
    certainty, train = solution.certainty, fitted_prediction(setting, solution)
    # The fitted numbers by key path, and their gradients by the unknowns (nx,); zeros are in the unit of [data].
    numbers = chosen.values(solution.z)
    values = dict(zip(chosen.keys, numbers.tolist(), strict=True))
    gradients = {k: np.pad(row, (0, nx - nz)) for k, row in zip(chosen.keys, chosen.gradients(solution.z), strict=True)}
    sizes = [setting.table.in_si(name)[0] for name in columns]
    offsets = {n: float(x) / size for n, x, size in zip(columns, solution.offsets, sizes, strict=True)}
    for row, name in enumerate(columns if nx > nz else ()):
        values[f"data.offsets.{name}"] = offsets[name]
        gradients[f"data.offsets.{name}"] = np.eye(nx)[nz + row] / sizes[row]

    follows = train.follows(setting.noise)
    known = {key: certainty.error(g) for key, g in gradients.items() if follows and certainty.determined(g)}
    unsure = tuple(key for key in values if key not in known)
    errors = known if certainty.enough else {}
    matrix = np.array([gradients[key] for key in errors]).reshape(len(errors), nx)
    return Fit(
        scene=substitute(setting.scene, chosen.keys, numbers).replace({"data.offsets": offsets}),
        values=values,
        errors=errors,
        covariance=matrix @ certainty.covariance @ matrix.T,
        undetermined=unsure,
        combinations=combinations(setting.scene, chosen, solution.z, certainty, set(unsure)) if follows else (),
        train=train,
        hold_out=prediction,
        noise=dict(zip(columns, setting.noise.tolist(), strict=True)),
        white=whiteness(solution.solved.r.reshape(len(solution.problem.batch.swing), -1, len(columns))),
        inflation=certainty.inflation,
        seconds=seconds,
        setting=setting,
        solution=solution,
    )

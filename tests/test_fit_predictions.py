"""What a fit says of other swings: prediction intervals, the region of two numbers, the samples as a table."""

import csv
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import chi2

import pendpin as pp
from fit_scenes import ANGLE, NOISE, scene_of, swings_of
from pendpin.cli import main
from pendpin.effects import Viscous
from pendpin.scene import Data

FREE = ["model.rods[0].com", "effects[1].coefficient"]
FITS = 12


def scene(duration: float) -> pp.Scene:
    return scene_of(1, Viscous(coefficient=2e-4), data=ANGLE, duration=duration)


def test_a_prediction_interval_holds_what_is_measured() -> None:
    """95 % of the samples of 5 s, predicted from fits to 0.8 s, in which the numbers are worth six times the noise.

    Errors of one fit's samples go together, so few fits give 95 % only about; intervals of short data are on the safe side.
    The noise alone would hold less than three quarters of them. Half of the predicted swing fits its start: an interval
    that left out how this start follows the numbers would be twice as wide as the errors.
    """
    held, noise, sizes = [], [], []
    for seed in range(FITS):
        fit = pp.fit(scene(0.8), swings_of(scene(0.8), [0.5], [0.3], seed=seed), FREE)
        prediction = fit.predict(swings_of(scene(5.0), [0.8], seed=1000 + seed), start=0.6)
        assert prediction.interval is not None
        held.append(prediction.covered["a1"])
        half = prediction.interval[0][prediction.compared[0]]
        sizes.append(np.sqrt(np.mean((1.96 * prediction.errors() / half) ** 2)))
        noise.append(np.mean(np.abs(prediction.errors()) < 1.96 * NOISE))
    assert np.mean(held) > 0.93
    assert np.mean(noise) < 0.75
    assert 0.6 < np.mean(sizes) < 1.1


def test_an_interval_is_no_wider_than_the_noise_where_the_numbers_are_known() -> None:
    """Of many samples, what remains is the noise of one measurement and the start of the predicted swing."""
    fit = pp.fit(scene(4.0), swings_of(scene(4.0), [0.8], [0.5], [0.3]), FREE)
    prediction = fit.predict(swings_of(scene(4.0), [0.6], seed=9), start=0.5)
    assert prediction.interval is not None
    half = prediction.interval[0]
    assert 0.9 < half.min() / (1.96 * NOISE) < half.max() / (1.96 * NOISE) < 1.3
    assert prediction.covered["a1"] == pytest.approx(0.95, abs=0.04)  # of 200 samples: three standard errors


def test_there_is_no_interval_where_there_are_no_errors() -> None:
    """As of a model that does not follow the motion: the samples scatter as far as it swings, and are said to be exact."""
    data = Data(segment="segment", columns={"a1": ("theta",)}, noise=NOISE)
    table = swings_of(scene(2.0), [0.5])
    table["a1"] = table["a1"] + np.random.default_rng(0).normal(0, 0.4, len(table["t"]))
    fit = pp.fit(scene(2.0).replace(data=data), table, FREE, hold_out=table)
    assert (fit.errors, fit.hold_out.interval, fit.hold_out.covered) == ({}, None, {})
    assert "interval" not in str(fit)


def test_the_region_of_two_numbers_is_that_of_their_covariance() -> None:
    """Every point at one distance, that of chi-squared with two degrees of freedom; its extent, that of each number.

    The curve is closed, and goes round once.
    """
    fit = pp.fit(scene(2.0), swings_of(scene(2.0), [0.8], [0.5]), [*FREE, "model.rods[0].length"][:2])
    for one, other in combinations(fit.errors, 2):
        places = [list(fit.errors).index(key) for key in (one, other)]
        covariance = fit.covariance[np.ix_(places, places)]
        for level in (0.5, 0.95):
            off = fit.confidence_region(one, other, level) - [fit.values[one], fit.values[other]]
            distance = np.einsum("ki,ij,kj->k", off, np.linalg.inv(covariance), off)
            np.testing.assert_allclose(distance, chi2(2).ppf(level), rtol=1e-6)
            np.testing.assert_allclose(off[0], off[-1], rtol=1e-9)
            turned = np.unwrap(np.arctan2(*(off @ np.linalg.inv(np.linalg.cholesky(covariance)).T).T))
            assert abs(turned[-1] - turned[0]) == pytest.approx(2 * np.pi)
            size = np.sqrt(chi2(2).ppf(level)) * np.array([fit.errors[one], fit.errors[other]])
            np.testing.assert_allclose(off.max(0), size, rtol=1e-3)  # of 200 points, the nearest
    with pytest.raises(pp.InputError, match="give two numbers with errors"):
        fit.confidence_region(FREE[0], FREE[0])
    with pytest.raises(pp.InputError, match="between 0 and 1"):
        fit.confidence_region(*list(fit.errors)[:2], level=95)


def test_the_table_holds_every_sample(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """In the unit of the data: measured less fitted is the rest; intervals of what was held out alone."""
    degrees = scene(2.0).replace(data=ANGLE.model_copy(update={"unit": "degrees"}))
    tables = [swings_of(degrees, *starts, seed=seed) for seed, starts in enumerate(([[0.8], [0.5]], [[0.6]]))]
    files = [tmp_path / f"{name}.csv" for name in ("data", "held_out")]
    for table, file in zip(tables, files, strict=True):
        table["a1"] = np.degrees(table["a1"])
        with file.open("w", newline="") as out:
            csv.writer(out).writerows([list(table), *zip(*(column.tolist() for column in table.values()), strict=True)])
    path = degrees.save(tmp_path / "scene.toml")
    options = ["--free", ",".join(FREE), "--hold-out", str(files[1]), "--csv", str(tmp_path / "samples.csv")]
    monkeypatch.setattr("sys.argv", ["pendpin", "fit", str(path), str(files[0]), *options])
    with pytest.raises(SystemExit) as end:
        main()
    assert not end.value.code
    with (tmp_path / "samples.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert list(rows[0]) == ["set", "swing", "t", "a1", "a1_fitted", "a1_residual", "a1_interval"]
    measured = np.concatenate([table["a1"] for table in tables])
    np.testing.assert_allclose([float(row["a1"]) for row in rows], measured, rtol=1e-15)  # to rad and back
    for row in rows:
        assert float(row["a1"]) - float(row["a1_fitted"]) == pytest.approx(float(row["a1_residual"]), abs=1e-12)
        assert (row["a1_interval"] != "") == (row["set"] == "held out")
    rest = np.array([float(row["a1_residual"]) for row in rows if row["set"] == "fitted"])
    assert np.sqrt(np.mean(rest**2)) == pytest.approx(np.degrees(NOISE), rel=0.1)

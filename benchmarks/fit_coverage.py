"""How often 95 % intervals of a fit hold the truth, for noise with a memory: a table for docs/fit.md.

    nice -n 10 python benchmarks/fit_coverage.py 200 coverage.jsonl  # linear fits of each kind; seconds to minutes each
    nice -n 10 python benchmarks/fit_coverage.py 20 fits.jsonl --fits  # whole fits, a second or more each
    nice -n 10 python benchmarks/fit_coverage.py 1000 one.jsonl --sizes "2 x 400" --noises 0.5  # one cell

One rod with viscous and dry friction and the zero of its sensor, at 100 samples a second. The noise is of first order:
each sample remembers rho of the one before; "mixed" is rho = 0.98 and white noise of the same size. A linear fit takes the
derivatives of one whole fit, so that many cost what one did; and as its errors are sums of the noise, their exact standard
errors are known. "By exact errors" is how often intervals of the claimed size hold a normal error of the exact one: ten fits
tell it better than hundreds tell how often intervals held. The same command goes on where it was stopped.
"""

import argparse
import json
from pathlib import Path

import numpy as np
from scipy.signal import lfilter
from scipy.special import ndtr

import pendpin as pp
from pendpin.effects import DryFriction, Gravity, Viscous
from pendpin.fitting.uncertainty import Certainty, certainty
from pendpin.scene import Data

SIZES = {"2 x 400": (2, 4.0), "4 x 1000": (4, 10.0), "10 x 400": (10, 4.0), "10 x 2000": (10, 20.0)}
NOISES = ("0", "0.5", "0.9", "0.98", "mixed")
RATE, SIZE = 100, 1e-4  # samples a second, rad
FREE = ["model.rods[0].inertia[0]", "effects[1].coefficient", "effects[2].kinetic"]


def noise_of(kind: str, shape: tuple[int, ...], draw: np.random.Generator) -> np.ndarray:
    """Noise of variance 1 along the last axis."""
    if kind == "mixed":
        return (noise_of("0", shape, draw) + noise_of("0.98", shape, draw)) / np.sqrt(2)
    rho, new = float(kind), draw.normal(0, 1, shape)
    new[..., 1:] *= np.sqrt(1 - rho**2)
    return np.asarray(lfilter([1.0], [1.0, -rho], new, axis=-1))


def measured(segments: int, seconds: float) -> tuple[pp.Scene, dict[str, np.ndarray]]:
    """A rod, and its swings without noise."""
    truth = pp.Scene(
        duration=seconds,
        model=pp.Chain(rods=[pp.Rod(length=0.2, mass=0.1, radius=0.005)]),
        effects=[Gravity(), Viscous(coefficient=5e-5), DryFriction(kinetic=1e-4)],
        solver=pp.Solver(samples=round(RATE * seconds), tolerance=1e-11),
        data=Data(segment="segment", columns={"a": ("theta",)}),
    )
    starts = np.random.default_rng(3).uniform(0.5, 1.5, segments)
    runs = [pp.simulate(truth.replace(start=pp.Start(positions={"theta": float(x)}))) for x in starts]
    segment = np.repeat(np.arange(segments), len(runs[0].t))
    columns = {"t": np.concatenate([run.t for run in runs]), "a": np.concatenate([run.q[:, 0] for run in runs])}
    return truth, columns | {"segment": segment}


class LinearFits:
    """Fits of noise alone, linear about one whole fit: starts, numbers and zero."""

    def __init__(self, scene: pp.Scene, table: dict[str, np.ndarray]) -> None:
        draw = np.random.default_rng(0)
        fit = pp.fit(scene, table | {"a": table["a"] + draw.normal(0, SIZE, len(table["a"]))}, FREE)
        x, p, solved = fit.solution.x, fit.solution.problem, fit.solution.solved
        self.problem, self.J = p, solved.rest(solved.J)[:, :, None, :]
        self.starts, self.seen = solved.Q[:, :, None, :], ~np.isnan(p.batch.y.transpose(2, 0, 1))
        self.inverse = np.linalg.pinv((self.J * p.scale).reshape(-1, len(x)), rcond=1e-5) * p.scale[:, None]
        gradients = fit.setting.pendulum.free.gradients(fit.solution.z)
        self.keys = [key for key in fit.setting.pendulum.free.keys if key in fit.errors] + ["zero"]
        rows = [
            np.append(row, 0.0)
            for key, row in zip(fit.setting.pendulum.free.keys, gradients, strict=True)
            if key in fit.errors
        ]
        self.gradients = [*rows, np.eye(len(x))[-1]]

    def exact_errors(self, kind: str) -> np.ndarray:
        """The standard errors (k,) of the numbers for a kind of noise of variance 1."""
        rows = (np.array(self.gradients) @ self.inverse).reshape(-1, *self.seen.shape[:2])
        basis = self.starts[:, :, 0]
        rows = rows - np.einsum("pmk,npk->npm", basis, np.einsum("pmk,npm->npk", basis, rows))
        rows = np.where(self.seen[..., 0], rows, 0.0)
        if kind == "mixed":
            return np.hypot(self.exact_errors("0"), self.exact_errors("0.98")) / np.sqrt(2)
        remembered = lfilter([1.0], [1.0, -float(kind)], rows, axis=-1)
        return np.sqrt((rows * (2 * remembered - rows)).sum((1, 2)))

    def deviations(self, kind: str, draw: np.random.Generator) -> tuple[list[float], Certainty]:
        """Of each number, its error over its standard error."""
        seen, p = self.seen[..., 0], self.problem
        r = np.where(seen, noise_of(kind, seen.shape, draw), 0.0)[:, :, None]
        r = r - self.starts[:, :, 0] @ (self.starts[:, :, 0].transpose(0, 2, 1) @ r)
        change = -self.inverse @ r.reshape(-1)
        r = r + self.J[:, :, 0] @ change[:, None]
        known = certainty(r, self.J, self.starts, p.scale, p.batch.swing, p.batch.t, self.seen)
        return [float(g @ change / known.error(g)) for g in self.gradients], known


def linear_row(fits: LinearFits, kind: str, draw: np.random.Generator) -> dict:
    """One linear fit."""
    z, known = fits.deviations(kind, draw)
    sizes = np.array([known.error(g) for g in fits.gradients]) / fits.exact_errors(kind)
    return {"z": z, "sizes": sizes.tolist(), "enough": known.enough, "keys": fits.keys}


def whole_row(scene: pp.Scene, table: dict[str, np.ndarray], kind: str, draw: np.random.Generator) -> dict:
    """One whole fit."""
    segments = len(np.unique(table["segment"]))
    noise = SIZE * noise_of(kind, (segments, len(table["t"]) // segments), draw).reshape(-1)
    fit = pp.fit(scene, table | {"a": table["a"] + noise}, FREE)
    truth = dict(zip(FREE, (scene.model.rods[0].properties.I1, 5e-5, 1e-4), strict=True)) | {"data.offsets.a": 0.0}
    z = [(fit.values[key] - truth[key]) / fit.errors[key] for key in truth if key in fit.errors]
    return {"z": z, "enough": fit.solution.certainty.enough, "keys": [key for key in truth if key in fit.errors]}


def line_of(rows: list[dict]) -> str:
    """A line of the table."""
    good = [row["z"] for row in rows if row["enough"]]
    numbers = np.array(good) if good else np.zeros((0, 1))
    covered = ", ".join(f"{100 * x:.0f}" for x in (np.abs(numbers) < 1.96).mean(0)) if good else "-"
    pooled = f"{100 * (np.abs(numbers) < 1.96).mean():.1f}" if good else "-"
    sizes = np.array([row["sizes"] for row in rows if row["enough"] and "sizes" in row])
    exact = f"{100 * (1 - 2 * ndtr(-1.96 * sizes)).mean():.1f}" if len(sizes) else "-"
    missing = f"{len(rows) - len(good)} of {len(rows)}"
    return f"| {rows[0]['size']} | {rows[0]['noise']} | {covered} | {pooled} | {exact} | {missing} |"


def main() -> None:
    """Fill the file and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("count", type=int)
    parser.add_argument("file", type=Path)
    parser.add_argument("--fits", action="store_true", help="whole fits")
    parser.add_argument("--sizes", nargs="+", choices=SIZES, default=SIZES)
    parser.add_argument("--noises", nargs="+", choices=NOISES, default=NOISES)
    options = parser.parse_args()
    count, file, whole = options.count, options.file, options.fits
    rows = [json.loads(line) for line in file.read_text().splitlines()] if file.exists() else []
    print("| samples | noise | covered, % of each number | of all | by exact errors | without errors |")
    print("|---|---|---|---|---|---|")
    for size in options.sizes:
        scene, table = measured(*SIZES[size])
        fits = None if whole else LinearFits(scene, table)
        for kind in options.noises:
            done = [row for row in rows if (row["size"], row["noise"]) == (size, kind)]
            for case in range(len(done), count):
                draw = np.random.default_rng([NOISES.index(kind), case])
                row = linear_row(fits, kind, draw) if fits else whole_row(scene, table, kind, draw)
                done.append(row | {"size": size, "noise": kind})
                with file.open("a") as out:
                    out.write(json.dumps(done[-1]) + "\n")
            print(line_of(done), flush=True)


if __name__ == "__main__":
    main()

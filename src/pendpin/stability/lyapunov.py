"""`lyapunov`: the mean rates at which small changes of a motion grow, by its variational equations.

Changes are made orthogonal again after each of many parts of the time, and what they grew by is summed up (G. Benettin,
L. Galgani, A. Giorgilli, J.-M. Strelcyn, Meccanica 15 (1980), 9). Lengths of changes are in rad and rad/s (m, m/s).
"""

from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from pendpin.errors import InputError, brief, shown
from pendpin.ground.arrays import Array
from pendpin.motions.variations import Variations, list_state_keys
from pendpin.scene import Scene, chosen_scene

TOLERANCE = 1e-11
PARTS = 200  # of the time, at least
GROWTH = 1.0  # in a part, about, at the rate at which the equations change at the start
MOST_PARTS = 100_000
BATCHES = 20  # of the parts: the spread of their means gives the standard error


@dataclass(frozen=True, eq=False, repr=False)
class Lyapunov:
    """The exponents of a motion, the largest first."""

    exponents: Array  # (k,) 1/s
    error: Array  # (k,) 1/s: the standard error and what the estimate changed by in the second half
    history: Array  # (n, k) 1/s, the estimate at each of `t`
    t: Array  # (n,) s since the start

    def plot(self, ax: Any = None) -> Any:
        """Draw the estimates against time on a matplotlib Axes, a new one if absent; returns it."""
        from pendpin.graphics.figure import new_figure

        ax = ax if ax is not None else new_figure(figsize=(7.0, 4.0), layout="constrained").subplots()
        for i, (series, last) in enumerate(zip(self.history.T, self.exponents, strict=True)):
            ax.plot(self.t, series, lw=1.2, label=f"{i + 1}: {last:.3g} /s")
        ax.axhline(0.0, color="0.7", lw=0.8, zorder=0)
        ax.set(xlabel="time (s)", ylabel="Lyapunov exponents, estimate so far (1/s)", xscale="log")
        ax.legend(fontsize=8, ncols=2, frameon=False)
        return ax

    def __repr__(self) -> str:
        return brief(self.text())

    def text(self) -> str:
        """The exponents with their errors."""
        lines = [f"Lyapunov exponents after {self.t[-1]:.6g} s (1/s)"]
        lines += [f"{x:14.6g} ± {e:.2g}" for x, e in zip(self.exponents, self.error, strict=True)]
        lines.append(f"their sum {self.exponents.sum():.6g}")
        return "\n".join(lines)


def lyapunov(scene: Scene | str | Path, count: int | None = None, duration: float | None = None) -> Lyapunov:
    """The Lyapunov exponents of the motion from a scene's start, by its variational equations.

    Those of a finite time are estimates: `error` tells how far off they may be, and falls as 1/duration for a regular
    motion.

    Args:
        scene: a Scene, or the path of a TOML file.
        count: how many, the largest ones; all 2 nv if absent.
        duration: s; the scene's if absent.

    Returns:
        The Lyapunov record: exponents (k,) and error (k,) in 1/s, history (n, k), the estimate at each of t (n,) in s.

    Raises:
        InputError: for another count or duration, for friction and stops, for effects without derivatives.
        RunError: where the motion cannot be integrated.
    """
    scene = chosen_scene(scene)
    if duration is not None:
        if isinstance(duration, bool) or not isinstance(duration, int | float) or not 0 < duration < np.inf:
            raise InputError(f"duration: {shown(duration)} is not a number of seconds above 0")
        scene = scene.replace(duration=float(duration))
    if not scene.duration:
        raise InputError("duration: a motion of 0 s has no exponents; give it a duration in s")
    nv = Variations(scene, []).nv
    if count is not None and (type(count) is not int or not 1 <= count <= 2 * nv):
        raise InputError(f"count: {shown(count)} is not a number of exponents, 1 to {2 * nv}")
    variations = Variations(scene, list_state_keys(nv)[: count or 2 * nv])
    return _spectrum(variations, scene.duration)


def _spectrum(variations: Variations, duration: float) -> Lyapunov:
    """The exponents over a duration in s."""
    y, w = variations.start, np.eye(len(variations.keys), 2 * variations.nv)
    times = np.linspace(0.0, duration, _parts(variations, duration) + 1)
    growths = []
    for begin, end in pairwise(times):
        states, changes = variations.integrate(y, w, np.array([begin, end]), TOLERANCE)
        q, r = np.linalg.qr(changes[-1].T)
        growths.append(np.log(np.abs(np.diag(r))))
        y, w = states[-1], q.T
    sums = np.cumsum(growths, 0)
    history = sums / times[1:, None]
    order = np.argsort(-history[-1], kind="stable")
    history, growths = history[:, order], np.array(growths)[:, order]
    return Lyapunov(history[-1], _errors(times, growths, history), history, times[1:])


def _parts(variations: Variations, duration: float) -> int:
    """In how many parts the time is cut: changes grow by about e in each, so that none hides another."""
    size = 2 * variations.nv
    w = np.eye(len(variations.keys), size)[None]
    _, rates = variations.equations.rates(np.zeros(1), variations.start[None], w)
    fastest = np.sqrt(float(np.linalg.norm(np.nan_to_num(rates[0]), 2)))
    return int(np.clip(duration * fastest / GROWTH, PARTS, MOST_PARTS))


def _errors(times: Array, growths: Array, history: Array) -> Array:
    """The standard error of the mean of batches, and the change of the estimate from the middle to the end, (k,)."""
    batches = np.array_split(growths / np.diff(times)[:, None], BATCHES)
    means = np.array([batch.mean(0) for batch in batches])
    return means.std(0, ddof=1) / np.sqrt(BATCHES) + np.abs(history[-1] - history[len(history) // 2])

"""`lyapunov`: the mean rates at which small changes of a motion grow, by its variational equations.

Changes are made orthogonal again after each of many parts of the time, and what they grew by is summed up (G. Benettin,
L. Galgani, A. Giorgilli, J.-M. Strelcyn, Meccanica 15 (1980), 9). Lengths of changes are in rad and rad/s (m, m/s).
"""

from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from pendpin.dynamics.compiling import staying_zero
from pendpin.errors import InputError
from pendpin.graphics.style import BESIDE, PALE, new_figure, styled
from pendpin.ground.arguments import axes, flag, seconds, whole_number
from pendpin.ground.arrays import Array, Indices
from pendpin.ground.report import Report, Result, Table
from pendpin.model.kinematics import joint_poses
from pendpin.motions.variations import Variations, list_state_keys, refuse_contacts
from pendpin.scene import Scene, chosen_scene

TOLERANCE = 1e-11
PARTS, MOST_PARTS = 200, 100_000  # of the time, in each of which changes grow by about e: none hides another then
PARALLEL = 1e-9  # of unit vectors: axes that differ by less are parallel
BATCHES = 20  # of the parts: the spread of their means gives the standard error


@dataclass(frozen=True, eq=False, repr=False)
class Lyapunov(Result):
    """The exponents of a motion, the largest first."""

    exponents: Array  # (k,) 1/s
    error: Array  # (k,) 1/s: the standard error and what the estimate changed by in the second half
    history: Array  # (n, k) 1/s, the estimate at each of `t`
    t: Array  # (n,) s since the start

    @styled()
    def plot(self, ax: Any = None) -> Any:
        """Draw the estimates against time on a matplotlib Axes, a new one if absent; returns it."""
        ax = axes("ax", ax) or new_figure(7.0, 4.0).subplots()
        for i, (series, last) in enumerate(zip(self.history.T, self.exponents, strict=True)):
            ax.plot(self.t, series, label=f"{i + 1}: {last:.3g} /s")
        ax.axhline(0.0, color=PALE, linewidth=0.8, zorder=0)
        ax.set(xlabel="time (s)", ylabel="Lyapunov exponents, estimate so far (1/s)", xscale="log")
        ax.legend(**BESIDE)
        return ax

    def report(self) -> Report:
        """The exponents with their errors, and their sum."""
        rows = [(f"{x:.6g}", f"{e:.2g}") for x, e in zip(self.exponents, self.error, strict=True)]
        data = {"exponents": self.exponents.tolist(), "error": self.error.tolist(), "duration": float(self.t[-1])}
        table = Table(("Lyapunov exponent (1/s)", "error (1/s)"), rows)
        return Report((table, f"after {self.t[-1]:.6g} s; their sum is {self.exponents.sum():.6g} /s"), data)


def lyapunov(
    scene: Scene | str | Path, count: int | None = None, duration: float | None = None, planar: bool = False
) -> Lyapunov:
    """The Lyapunov exponents of the motion from a scene's start, by its variational equations.

    Those of a finite time are estimates: `error` tells how far off they may be, and falls as 1/duration for a regular
    motion.

    Args:
        scene: a Scene, or the path of a TOML file.
        count: how many, the largest ones; all 2 nv if absent, or those of the plane.
        duration: s; the scene's if absent.
        planar: only those of changes in the plane in which the motion stays, as textbooks give them for a double pendulum:
            joints that begin at 0 and stay there whatever the numbers of the scene do not change. Of a model whose joints
            all turn about parallel axes, such as a planar robot, these are all.

    Returns:
        The Lyapunov record: exponents (k,) and error (k,) in 1/s, history (n, k), the estimate at each of t (n,) in s.

    Raises:
        InputError: for another count or duration, for a motion that leaves every plane if `planar`, for friction and stops,
            for effects without derivatives.
        RunError: where the motion cannot be integrated.
    """
    scene = chosen_scene(scene)
    if duration is not None:
        scene = scene.replace(duration=float(seconds("duration", duration, lasting=True)))
    if not (duration := scene.duration):
        raise InputError("duration: a motion of 0 s has no exponents; give it a duration in s")
    refuse_contacts(scene)
    unchanged = Variations(scene, [])
    size = 2 * unchanged.nv
    places = _places_in_plane(unchanged) if flag("planar", planar) else np.arange(size)
    count = len(places) if count is None else whole_number("count", count, most=len(places))
    keys = list_state_keys(unchanged.nv)
    variations = Variations(scene, [keys[place] for place in places[:count]])

    y, many = variations.start, len(variations.keys)
    _, rates = variations.equations.rates(np.zeros(1), y[None], np.eye(many, size)[None])
    fastest = np.sqrt(float(np.linalg.norm(np.nan_to_num(rates[0]), 2)))  # of the changes, at the start
    times = np.linspace(0.0, duration, int(np.clip(duration * fastest, PARTS, MOST_PARTS)) + 1)
    w, growths = np.eye(size)[places[:many]], []
    for begin, end in pairwise(times):
        states, changes = variations.integrate(y, w, np.array([begin, end]), TOLERANCE)
        q, r = np.linalg.qr(changes[-1][:, places].T)  # at other places changes stay 0
        growths.append(np.log(np.abs(np.diag(r))))
        y, w[:, places] = states[-1], q.T
    history = np.cumsum(growths, 0) / times[1:, None]
    order = np.argsort(-history[-1], kind="stable")
    history, growths = history[:, order], np.array(growths)[:, order]
    means = np.array([part.mean(0) for part in np.array_split(growths / np.diff(times)[:, None], BATCHES)])
    error = means.std(0, ddof=1) / np.sqrt(BATCHES) + np.abs(history[-1] - history[len(history) // 2])
    return Lyapunov(history[-1], error, history, times[1:])


def _places_in_plane(variations: Variations) -> Indices:
    """The places in the state (2 nv,) of the joints that move in the plane. Raises InputError where all move, or none."""
    equations, start, nv = variations.equations, variations.start, variations.nv
    still = staying_zero(equations.of_motion._replace(contacts=None), np.flatnonzero(start == 0).tolist())
    moving = np.array([i for i in range(nv) if not {i, nv + i} <= set(still)], int)
    tree = equations.model.tree
    frames = joint_poses(equations.model, np.zeros((1, nv)))[0, :, :3, :3]
    axes = np.einsum("jab,jb->ja", frames, tree.axes)  # (nv, 3) in W at zero positions
    turns = np.array([kind == "revolute" for kind in tree.kinds])
    along = np.abs(axes @ axes[np.argmax(turns)])
    if turns.any() and (np.abs(along - turns) < PARALLEL).all():  # slides across parallel axes: no way out of the plane
        moving = np.arange(nv)
    elif not 0 < len(moving) < nv:
        which = "every joint moves" if len(moving) else "nothing moves"
        give = "give one in a plane, with phi and its rate 0, or leave it out"
        raise InputError(f"planar: {which} from this start; {give}")
    return np.concatenate([moving, nv + moving])

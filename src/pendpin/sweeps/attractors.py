"""The measure `attractor`: where a motion has settled, a fixed point, a cycle of several periods or a rotation.

What is stored of a case follows from its own motion alone: the length of its cycle, its turns, and the mean of its states
over the cycle, which is the same wherever on the cycle it ends. Cases with the same are of one attractor; they are numbered
where the results are read.
"""

from dataclasses import dataclass

import numpy as np

from pendpin.errors import InputError, is_number, shown
from pendpin.ground.arrays import Array
from pendpin.motions.periodic import period_of
from pendpin.motions.trajectory import Trajectory
from pendpin.runs.batches import Motions
from pendpin.scene import Scene, scene_of

NAME, PART = "attractor", "attractor_part"  # the measure, and the dimension of what is stored of it
KINDS = "attractors"  # the attribute of its variable: what each number is
LONGEST = 16  # periods of a cycle
WINDOW = 4  # periods, at least, over which differences are compared with those before
FEWEST = 2 * WINDOW + 1  # periods of a motion that can have settled
STILL = 1e-7  # rad, rad/s: differences over a cycle that are rounding and the error of the integration
PASSES = 4  # of Newton's method, for the instants of a rotation's turns
SETTLED = 1e-4  # how far the end may still be from the attractor, as the differences shrink
SAME = 1e-2  # mean states of one attractor differ by less, over the largest of them or 1
MOST = 1000  # attractors that are distinguished


@dataclass(frozen=True)
class Attractor:
    """The attractor that a motion has reached by its end: after how many periods it repeats, its turns, its mean state."""

    period: float | None = None  # s; that of each run's drive if None; a motion that nothing drives is seen once a turn
    size: int = 0  # numbers stored of a case: the length of its cycle, its turns, the mean of cos q, sin q and v

    def times(self, scene: Scene) -> Array | None:
        """The last instants (k,) in s, a period apart from the start of the scene on; None where nothing drives it."""
        period = self.period or period_of(scene)
        if period is None:
            return None
        count = int(scene.duration / period * (1 + 1e-12))
        if count < FEWEST:
            least = f"give the scene {FEWEST * period:.6g} s or more"
            raise InputError(f"duration: {NAME} looks at {FEWEST} periods of {period:.6g} s at least; {least}")
        ends = scene.start.time + period * np.arange(max(0, count - 3 * LONGEST), count + 1)
        return np.minimum(ends, scene.start.time + scene.duration)

    def __call__(self, run: Trajectory) -> Array:
        """The attractor that a run has reached: a number, the same for all cases that reach it. See docs/sections.md."""
        slides, times = np.isin(run.joints, [*(run.slides or ())]), self.times(scene_of(run))
        if times is not None:
            rows = run.at(times)
            return self.recognize(rows.q, rows.v, slides)
        if np.abs(run.v[-1]).max() < SETTLED:  # at rest, as far as its end tells
            rows = run.at(np.linspace(run.t[0], run.t[-1], 3 * LONGEST))
            return self.recognize(rows.q, rows.v, slides, 1)
        turned = np.where(slides, 0.0, run.q[-1] - run.q[0])
        joint = int(np.argmax(np.abs(turned)))
        way, turns = np.sign(turned[joint]), min(3 * LONGEST, int(abs(turned[joint]) / (2 * np.pi)))
        if turns < FEWEST:
            return np.full(self.size, np.nan)
        last = np.floor(way * run.q[-1, joint] / (2 * np.pi))
        angles = way * 2 * np.pi * (last - np.arange(turns)[::-1])  # hanging straight down, a turn apart
        times = np.interp(way * angles, np.maximum.accumulate(way * run.q[:, joint]), run.t)
        for _ in range(PASSES):
            rows = run.at(times)
            off = np.divide(angles - rows.q[:, joint], rows.v[:, joint], where=rows.v[:, joint] != 0, out=0 * angles)
            times = np.clip(times + off, run.t[0], run.t[-1])
            if (np.diff(times) <= 0).any():
                return np.full(self.size, np.nan)
        rows = run.at(times)
        return self.recognize(rows.q, rows.v, slides)

    def of_motions(self, times: Array, motions: Motions) -> Array:
        """That of each of c motions with samples at these times (k,), (c, size); NaN for what has not settled."""
        at, slides = np.searchsorted(motions.t, times), np.asarray(motions.models[0].slides)
        return np.array([self.recognize(q[at], v[at], slides) for q, v in zip(motions.q, motions.v, strict=True)])

    def recognize(self, q: Array, v: Array, slides: Array, longest: int = LONGEST) -> Array:
        """The stored numbers (size,) of states (k, nv), one each period; NaN for a motion that has not settled."""
        states = np.concatenate([np.where(slides, q, np.cos(q)), np.where(slides, 0.0, np.sin(q)), v], 1)
        for n in range(1, longest + 1):
            window = max(n, WINDOW)
            if 2 * window + n > len(q):
                break
            apart = np.abs(states[n:] - states[:-n]).max(1)
            last, before = apart[-window:].max(), apart[-2 * window : -window].max()
            if last <= STILL or (last < before and window * last / (1 - last / before) <= SETTLED):
                turns = np.where(slides, 0.0, np.round((q[-1] - q[-1 - n]) / (2 * np.pi)))
                mean = states[-n:].mean(0)
                mean[len(slides) : 2 * len(slides)][slides] = np.nan  # which tells a slide, whose place comes before
                return np.concatenate([[n], turns, mean])
        return np.full(self.size, np.nan)


def read_attractor(name: str) -> Attractor:
    """The measure of a name like "attractor" or "attractor(9.42)", with a period in s. Raises InputError."""
    given = name.removeprefix(NAME)
    if not given:
        return Attractor()
    try:
        period = float(given.removeprefix("(").removesuffix(")"))
    except ValueError:
        period = np.nan
    if given[0] + given[-1] != "()" or not (is_number(period) and 0 < period < np.inf):
        raise InputError(f"measure: {shown(name)}: give a period in s above 0, as in {NAME}(9.42)")
    return Attractor(period)


def number_attractors(values: Array) -> tuple[Array, list[str]]:
    """The numbers (...) of the attractors of cases (..., size), from 1 on, and what each is; NaN where there is none."""
    rows, nv = values.reshape(-1, values.shape[-1]), (values.shape[-1] - 1) // 4
    left, kinds, of = np.isfinite(rows[:, 0]), list[Array](), np.full(len(rows), -1)
    kind, mean = rows[:, : 1 + nv], np.nan_to_num(rows[:, 1 + nv :])
    while left.any() and len(kinds) < MOST:
        one = int(np.argmax(left))
        near = np.abs(mean - mean[one]).max(1) <= SAME * max(1.0, np.abs(mean[one]).max())
        same = left & near & (kind == kind[one]).all(1)
        of[same], left = len(kinds), left & ~same
        kinds.append(rows[one])
    # Fixed points come first, then cycles by their length, then rotations.
    keys = [(kind[1 : 1 + nv].any(), *np.nan_to_num(np.round(kind, 2)).tolist()) for kind in kinds]
    order = sorted(range(len(kinds)), key=keys.__getitem__)
    numbers = np.append(np.argsort(order) + 1.0, np.nan)[of]
    numbers[left] = len(kinds) + 1  # no longer distinguished
    words = []
    for i, k in enumerate(order, 1):
        row = kinds[k]
        n, turns, (cos, sin, _) = int(row[0]), row[1 : 1 + nv], row[1 + nv :].reshape(3, nv)
        if turns.any():
            each = ", ".join(f"{x:+.0f}" for x in turns)
            what = f"rotation, {each} turns" + (f" in {n} periods" if n > 1 else "")
        elif n > 1:
            what = f"cycle of {n} periods"
        else:
            places = np.where(np.isnan(sin), cos, np.arctan2(np.round(sin, 6), cos)) + 0.0
            what = f"fixed point at ({', '.join(f'{x:.3g}' for x in places)})"
        words.append(f"{i}: {what}")
    return numbers.reshape(values.shape[:-1]), words + [f"{len(kinds) + 1}: others"] * bool(left.any())

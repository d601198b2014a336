"""From a scene with guesses and measured swings to a fitted scene with error bars."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from pendpin.errors import InputError
from pendpin.fitting import guess
from pendpin.fitting.data import RESTS, Swing, batch, cut_pieces, read_swings, sensors_of, spread_of, thin_out
from pendpin.fitting.parameters import free_parameters
from pendpin.fitting.problem import MOST_START_STEPS, Pendulum, Problem, Solved, bind_pendulum, search, solve_starts
from pendpin.fitting.uncertainty import CORNER, Certainty, certainty, huber_scale, pseudo_residuals, sensor_noise
from pendpin.ground.arrays import Array
from pendpin.model.build import build
from pendpin.scene import Data, Scene

MOST_POINTS = 1_000  # of the regression
FINEST = 0.075  # of the time scale: samples farther apart than this are all used
SMOOTHING = 0.7  # of the time scale, to either side: local polynomials
SHORT = 12.6  # time scales: about one period, the length of the first pieces
FAR, LAST = 20, 3  # steps at most, of the search and over all samples
COARSE = 1e-3  # of the sum of squares: what a step gains that still pays before the last search
MOST_CHANGE = 0.3  # of the logarithm of a positive number: its natural scale is not above this
ROUGHLY = 100.0  # times its size: how far a friction may be from its guess, where a body may be by its size
UNSEEN = 1e-6  # of the accelerations, by a change of a number by its own size: it does not change them
OFFSET = 0.01  # rad or m: natural scale of a zero
NEAR = 0.3  # of the spread of a column: residuals from which whole swings can be searched
SURE = 0.1  # of the square of these: with less, nobody asks whether the guess itself is nearer
MOST_GROWTH = 1e3  # of a disturbance of a start: pieces are cut where the motion forgets its start
OTHER_UNIT = 30.0  # times slower or faster than the guesses: no better guess mends that
MOST_WEIGHT = 10.0  # between the best and the worst explained piece
NOISE_ALONE = 0.95  # of the spread of every column: noise in which nothing can be seen to move


@dataclass(frozen=True, eq=False)
class Setting:
    """What does not change during a fit."""

    scene: Scene
    table: Data
    pendulum: Pendulum
    swings: tuple[Swing, ...]
    noise: Array  # (columns,) rad or m
    columns: tuple[str, ...]
    robust: bool

    @property
    def shift(self) -> Array:
        """How the zeros of the columns shift joint angles, (n, columns); tips' zeros are left out."""
        sensors = self.pendulum.sensors
        angles = sensors.angles[:, list(self.pendulum.moving)]
        return np.linalg.pinv(angles) * (not sensors.tips.any())

    @cached_property
    def angles(self) -> tuple[Swing, ...]:
        """The swings of the joints that move (n,), from the columns."""
        return guess.joint_angles(self.pendulum, self.swings, self.pendulum.free.start)

    @cached_property
    def regression(self) -> guess.Regression:
        """The accelerations that the data show, for equation error, by cubics over some samples to either side."""
        parts, points = [], max(8, MOST_POINTS // len(self.angles))
        for swing in self.angles:
            m, width = len(swing.t), SMOOTHING * self.pendulum.pace
            reach = int(np.clip(np.ceil(width / np.median(np.diff(swing.t))), 3, (m - 1) // 2))
            centres = np.unique(np.linspace(reach, m - 1 - reach, min(points, m - 2 * reach)).astype(int))
            t, rows = swing.t[centres], centres[:, None] + np.arange(-reach, reach + 1)
            parts.append((t, *guess.fit_cubics(swing, t, rows)))
        t, *states = (np.concatenate(part) for part in zip(*parts, strict=True))
        some = np.isfinite(states[-1]).all(1)
        y, rate, a = (x[some] for x in states)
        return guess.Regression(self.pendulum, self.shift, t[some], y, rate, a.T.reshape(-1))

    @cached_property
    def slowness(self) -> float:
        """How many times slower the data move than the scene with its guesses, by their accelerations."""
        offsets = self.shift.shape[1] if self.table.offsets == "free" else 0
        a, _ = self.regression.accelerations(np.concatenate([self.pendulum.free.start, np.zeros(offsets)]))
        sizes = [np.sqrt(np.nanmean(x**2)) for x in (a, self.regression.measured)]
        return float(np.sqrt(sizes[0] / sizes[1])) if min(sizes) > 0 else 1.0


@dataclass(frozen=True, eq=False)
class Solution:
    """The unknowns that explain the data best, with what is known of them."""

    problem: Problem  # with every sample of the data
    x: Array  # (nx,)
    z: Array  # (nz,) of these the search coordinates
    offsets: Array  # (columns,) the zeros of the columns
    solved: Solved
    certainty: Certainty


def data_table(scene: Scene) -> Data:
    """The [data] table of a scene. Raises InputError."""
    if scene.data is None:
        raise InputError("data: the scene has no [data] table, which says what the columns of the CSV file measure")
    return scene.data


def prepare(scene: Scene, data: Any, free: str | Sequence[str], robust: bool = False) -> Setting:
    """Read the data and compile the equations. Raises InputError for what is wrong with scene, data or keys."""
    table = data_table(scene)
    sensors = sensors_of(table, build(scene.model))
    swings = read_swings(data, table)
    parameters = free_parameters(scene, free)
    seen, spread = sensor_noise(swings), spread_of(swings)
    least = np.where(spread > RESTS * spread.max(), 1e-12, spread)  # else a column that rests outweighs those that move
    noise = np.full(len(seen), table.noise) if table.noise else np.maximum(seen, least)
    # The time scale: the time in which the fastest column moves by half its deviation; noise is not a motion.
    pace = min(guess.time_to_move(swing.t, swing.y[:, k], x) for swing in swings for k, x in enumerate(seen))
    if not np.isfinite(pace):
        raise InputError("data: nothing moves in the columns that are measured")
    if (seen > NOISE_ALONE * spread).all():
        reason = "the columns hold noise, or a motion too fast for them"
        raise InputError(f"data: neighbouring samples differ as much as any two: {reason}")
    swings = thin_out(swings, FINEST * pace)
    t = np.concatenate([swing.t for swing in swings])
    pendulum = bind_pendulum(scene, parameters, sensors, float(t.min()), float(t.max()), pace)
    return Setting(scene, table, pendulum, swings, noise, tuple(table.columns), robust)


def fixed_offsets(setting: Setting) -> Array:
    """The zeros of columns that are not free, (columns,) in rad or m."""
    offsets = setting.table.offsets
    if isinstance(offsets, str):
        return np.zeros(len(setting.columns))
    if unknown := [name for name in offsets if name not in setting.columns]:
        raise InputError(f"data.offsets.{unknown[0]}: there is no such column among: {', '.join(setting.columns)}")
    return np.array([offsets.get(name, 0.0) * setting.table.in_si(name)[0] for name in setting.columns])


def solve(setting: Setting, progress: Callable[[str], None]) -> Solution:
    """The unknowns that explain the data best: by equation error, by short pieces, then by whole swings."""
    problem = _pose_problem(setting)
    progress("a start by equation error")
    p = _rescale(setting, problem, problem.prior)
    if not 1 / OTHER_UNIT < setting.slowness < OTHER_UNIT:
        x = problem.prior
        starts = start_states(setting, problem, x, setting.angles)
        return _finish(setting, problem, x, solve_starts(problem, x, starts, 0), 0)
    x = guess.regress(setting.regression, p)
    angles = setting.angles
    whole, starts, misfit = _try_whole_swings(setting, problem, x, angles)
    if not misfit < SURE and (other := _try_whole_swings(setting, problem, problem.prior, angles))[2] < misfit:
        x, (whole, starts, misfit) = problem.prior, other  # noise spoils accelerations first
    if not misfit < 1:
        progress("short pieces")
        problem = _rescale(setting, problem, x)
        x, solved, _ = search(problem, x, start_states(setting, problem, x, angles), FAR, COARSE)
        # the pieces show rates without the noise of the samples; where a piece did not come to its end, nothing is known
        shown = shown_swings(setting, problem, x, solved.starts)
        shown = [swing._replace(y=np.where(np.isinf(swing.y), np.nan, swing.y)) for swing in shown]
        angles = guess.joint_angles(setting.pendulum, shown, x[: problem.nz])
        whole, starts, _ = _try_whole_swings(setting, problem, x, angles)
    progress("whole swings")
    problem = _rescale(setting, replace(problem, batch=whole.batch), x)
    x, solved, _ = search(problem, x, starts, FAR, COARSE)
    problem = replace(_rescale(setting, problem, x), still=np.zeros(len(x), bool))
    p = count_outliers_less(setting, _weigh(setting, problem, solved), x, solved.starts)
    x, solved, _ = search(p, x, solved.starts, FAR)
    # How far a number that the data do not determine may be from its guess: frictions and drags farther, because bodies
    # are weighed and measured before a fit, frictions seldom.
    sizes = np.where(p.prior != 0, np.abs(p.prior), p.scale)
    free = setting.pendulum.free
    sizes[: p.nz] = np.where(free.positive, 1.0, sizes[: p.nz])
    sizes[: p.nz] *= np.where(free.dissipation(setting.scene), ROUGHLY, 1.0)
    x = guess.nearest_to_guess(setting.regression, p, x, sizes)
    progress("error bars")
    return _finish(setting, p, x, solved)


def start_states(setting: Setting, problem: Problem, x: Array, swings: Sequence[Swing]) -> Array:
    """First guesses of the starts (2n, P) at unknowns x (nx,): of each piece of swings of joint angles, from its samples."""
    shift, first_moments, starts = setting.shift @ problem.split(x)[1], 2 * (SMOOTHING * setting.pendulum.pace), []
    for swing in swings:
        for piece in cut_pieces(swing, problem.batch.longest):
            count = int(np.clip((piece.t <= piece.t[0] + first_moments).sum(), 5, len(piece.t)))
            q, rate, _ = guess.fit_cubics(piece, piece.t[:1], np.arange(count)[None])
            starts.append(np.concatenate([q[0] - shift, rate[0]]))
    return np.array(starts).T


def _pose_problem(setting: Setting) -> Problem:
    """The problem in short pieces, with the guesses as the prior."""
    many = len(setting.columns) if setting.table.offsets == "free" else 0
    free, none = setting.pendulum.free, np.full(many, np.inf)
    return Problem(
        setting.pendulum,
        batch(setting.swings, SHORT * setting.pendulum.pace),
        1 / setting.noise,
        np.concatenate([np.where(free.positive | (free.start == 0), 1.0, np.abs(free.start)), np.full(many, OFFSET)]),
        np.concatenate([free.lower, -none]),
        np.concatenate([free.upper, none]),
        np.concatenate([free.start, np.zeros(many)]),
        fixed_offsets(setting),
        np.pad(free.is_stribeck_speed, (0, many)),
    )


def with_scene(setting: Setting, p: Problem, scene: Scene, free: Sequence[str]) -> tuple[Setting, Problem]:
    """The same data and weights with another scene, whose numbers are the prior, and other free numbers."""
    parameters, sensors = free_parameters(scene, free), sensors_of(setting.table, build(scene.model))
    t = np.concatenate([swing.t for swing in setting.swings])
    pendulum = bind_pendulum(scene, parameters, sensors, float(t.min()), float(t.max()), setting.pendulum.pace)
    setting = replace(setting, scene=scene, pendulum=pendulum)
    fresh = _pose_problem(setting)
    fresh = replace(fresh, still=np.zeros_like(fresh.still), batch=p.batch, weights=p.weights, share=p.share)
    return setting, _rescale(setting, fresh, fresh.prior)


def _rescale(setting: Setting, problem: Problem, x: Array) -> Problem:
    """The problem with natural scales at unknowns x (nx,), which change accelerations by one hundredth, where any do."""
    nz, scale = problem.nz, problem.scale.copy()
    a, J = setting.regression.accelerations(x)
    with np.errstate(all="ignore"):
        size, slope = np.sqrt(np.nanmean(a**2)) or 1.0, np.sqrt(np.nanmean(J[:, :nz] ** 2, axis=0))
        unseen = ~(slope * np.where(x[:nz] != 0, np.abs(x[:nz]), 1.0) > UNSEEN * size)
        natural = np.where(unseen, 0.0, 0.01 * size / np.where(unseen, 1.0, slope))
    scale[:nz] = np.where(natural > 0, natural, scale[:nz])
    positive = np.pad(setting.pendulum.free.positive, (0, len(x) - nz))
    return replace(problem, scale=np.where(positive, np.minimum(scale, MOST_CHANGE), scale))


def shown_swings(setting: Setting, problem: Problem, x: Array, starts: Array) -> tuple[Swing, ...]:
    """The swings as the sensors show them at unknowns x (nx,) from the starts (2n, P) of the pieces, or infinite."""
    columns, shown = problem.show(x, starts, problem.batch.t), []
    for k, swing in enumerate(setting.swings):
        pieces = zip(np.flatnonzero(problem.batch.swing == k), cut_pieces(swing, problem.batch.longest), strict=True)
        shown.append(swing._replace(y=np.concatenate([columns[: len(piece.t), :, place] for place, piece in pieces])))
    return tuple(shown)


def _try_whole_swings(
    setting: Setting, problem: Problem, x: Array, angles: Sequence[Swing]
) -> tuple[Problem, Array, float]:
    """Whole swings at x (nx,), cut where they forget their starts (2n, P), and their misfit: 1 where a search can begin.

    The starts are first read from swings of joint angles.
    """
    longest, spread = max(swing.t[-1] - swing.t[0] for swing in setting.swings), spread_of(setting.swings)
    while True:
        whole = replace(problem, batch=batch(setting.swings, longest))
        starts = start_states(setting, whole, x, angles)
        J = whole.evaluate(x, starts).by_start
        growth = np.abs(J.reshape(len(J), -1, len(setting.columns), J.shape[-1]) / whole.weights[:, None])
        growth[..., len(setting.pendulum.moving) :] /= 2 * setting.pendulum.pace
        if growth.max() <= MOST_GROWTH or longest <= SHORT * setting.pendulum.pace:
            break
        longest /= 2
    whole = replace(whole, weights=1 / np.sqrt(NEAR**2 * spread**2 + setting.noise**2))
    solved = solve_starts(whole, x, starts)
    return whole, solved.starts, float((solved.r**2).sum() / (~np.isnan(whole.batch.y)).sum())


def _weigh(setting: Setting, problem: Problem, solved: Solved) -> Problem:
    """Weights by what is left over: each column and each piece counts by the inverse of its residuals."""
    seen = ~np.isnan(problem.batch.y)
    M, columns, P = seen.shape
    r = solved.r.reshape(P, M, columns).transpose(1, 2, 0) / problem.weights[:, None]

    def size(r: Array, axis: tuple[int, int]) -> Array:
        if setting.robust:
            return huber_scale(r, seen, axis)
        return np.sqrt((r**2).sum(axis) / np.maximum(seen.sum(axis), 1))

    weights = 1 / np.maximum(size(r, (0, 2)), setting.noise)
    piece = size(r * weights[:, None], (0, 1))
    share = np.ones_like(r) / np.clip(piece / np.median(piece), 1 / MOST_WEIGHT, MOST_WEIGHT)
    return replace(problem, weights=weights, share=share)


def count_outliers_less(setting: Setting, problem: Problem, x: Array, starts: Array) -> Problem:
    """The problem with less weight for outliers at unknowns x (nx,) and starts (2n, P), if the fit is robust."""
    if not setting.robust:
        return problem
    M, columns, P = problem.batch.y.shape
    r = problem.evaluate(x, starts).r
    less = np.sqrt(np.minimum(1.0, CORNER / np.maximum(np.abs(r), 1e-300)))
    return replace(problem, share=problem.share * less.reshape(P, M, columns).transpose(1, 2, 0))


def _finish(setting: Setting, problem: Problem, x: Array, solved: Solved, most: int = LAST) -> Solution:
    """The solution with weights by what is left over, from unknowns x (nx,) in `most` steps, and what is known of it."""
    full = replace(problem, share=1.0)
    solved = solve_starts(full, x, solved.starts, 0 if setting.robust or not most else MOST_START_STEPS)
    full = _weigh(setting, full, solved)
    x, solved, J = search(count_outliers_less(setting, full, x, solved.starts), x, solved.starts, most)
    seen = ~np.isnan(full.batch.y.transpose(2, 0, 1))
    if setting.robust:
        solved = solve_starts(full, x, solved.starts, 0)
        J = solved.rest(solved.J)
        solved = replace(solved, r=pseudo_residuals(solved.r, seen.reshape(len(J), -1)))
    shape = (len(J), -1, len(setting.columns))
    rest = solved.unexplained.reshape(shape)
    Q = solved.Q.reshape(*shape, solved.Q.shape[-1])
    worth = certainty(rest, J.reshape(*shape, len(x)), Q, full.scale, full.batch.swing, full.batch.t, seen)
    return Solution(full, x, *full.split(x), solved, worth)

"""The path of a point between samples, without corners where it is fast."""

import numpy as np

from pendpin.graphics.drawing import Drawing
from pendpin.ground.arrays import Array, Indices, Mask

TURN = 0.1  # rad: two straight pieces in a row turn by about that


def smooth_trail(drawing: Drawing, per_second: float, most: int) -> tuple[Array, Array]:
    """The trail of a drawing as `smooth` gives it; where its velocity is not known, differences of the points give it."""
    velocity = np.gradient(drawing.trail, drawing.t, axis=0) if drawing.velocity is None else drawing.velocity
    return smooth(drawing.t, drawing.trail, velocity, per_second, most)


def smooth(t: Array, points: Array, velocities: Array, per_second: float, most: int) -> tuple[Array, Array]:
    """Times (m,) and points (m, 3) along a path, from points (n, 3) and velocities (n, 3) at times t (n,).

    Between two samples it is the cubic through both points and velocities, or straight where the samples are too far
    apart for that. It is cut into pieces that turn by TURN and last 1/per_second in s at most, but no more than `most`.
    """
    pieces = np.concatenate([[0.0], np.cumsum(np.maximum(_turns(velocities) / TURN, np.diff(t) * per_second))])
    count = int(min(np.ceil(pieces[-1]) + 1, most))
    places = np.interp(np.linspace(0.0, pieces[-1], max(2, count)), pieces, np.arange(len(t)))
    times = np.interp(places, np.arange(len(t)), t)
    straight = np.stack([np.interp(times, t, x) for x in points.T], -1)
    between = np.minimum(places.astype(int), len(t) - 2)
    curved = _cubic(times, t, points, velocities, between)
    return times, np.where(_resolved(t, points, velocities)[between, None], curved, straight)


def _cubic(times: Array, t: Array, points: Array, velocities: Array, i: Indices) -> Array:
    """Cubics (m, 3) through points and velocities (n, 3) at both ends of the intervals i (m,), at times (m,) in s."""
    span = (t[i + 1] - t[i])[:, None]
    x = (times - t[i])[:, None] / span
    rise = (3 - 2 * x) * x**2 * (points[i + 1] - points[i])
    return points[i] + rise + span * x * (x - 1) * ((x - 1) * velocities[i] + x * velocities[i + 1])


def _turns(velocities: Array) -> Array:
    """The angles in rad between successive velocities (n, 3), (n-1,)."""
    before, after = velocities[:-1], velocities[1:]
    return np.arctan2(np.linalg.norm(np.cross(before, after), axis=-1), (before * after).sum(-1))


def _resolved(t: Array, points: Array, velocities: Array) -> Mask:
    """Which intervals (n-1,) are so short that the cubic stays as near to the samples as these are to one another.

    t (n,) in s, points (n, 3) in m, velocities (n, 3) in m/s.
    """
    steps, spans = np.diff(points, axis=0), np.diff(t)[:, None]
    away = [np.linalg.norm(v * spans - steps, axis=-1) for v in (velocities[:-1], velocities[1:])]
    lengths = np.pad(np.linalg.norm(steps, axis=-1), 1, mode="edge")
    return np.maximum(*away) / 4 <= lengths[:-2] + lengths[1:-1] + lengths[2:]

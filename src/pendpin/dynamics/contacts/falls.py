"""Falls of joints onto their stops: the scale of a bounce, and when the bounces of a series are too small to follow.

A joint that is accelerated towards a stop moves on the scale of its fall and not of a whole turn: an error of 1e-9 rad is
small for a swing and larger than a bounce of 1e-10 rad. The rates after the next impacts are then wrong, and their series
does not end. So every method integrates a fall with the tolerance times the height of the fall, and all
methods get the same bounces. The last is that which goes no farther than `REST`.

An impact gives rates to joints that dry friction held, however small they are. Those that stick again within `REST` rest at
once: else a hand that settles on its stops makes an arm stick and slip a million times in a microsecond.
"""

import math
from typing import NamedTuple

import numpy as np

from pendpin.dynamics.contacts.contacts import Contacts, Mode, Scales
from pendpin.ground.arrays import Array, Mask

REST = 1e-12  # rad, or of the length of a slide: a bounce that goes no farther ends in rest on the stop
LOW = 0.1  # rad, or of the length of a slide: from higher falls the tolerance of a swing is accurate enough
UNITS = 16.0  # of rounding: the least errors that a method has to keep to
RESOLVED = 64.0  # units of rounding of the stop's position and of the time that a bounce takes at least


class LowFall(NamedTuple):
    """The falls from less than `LOW`, which may be shorter than a step, and what is large and small while they last."""

    joints: Mask  # (nv,), which joints fall
    scales: Scales
    shortest: float  # s, of the times of the falls
    longest: float  # s


class Falls(NamedTuple):
    """The falls of the joints (nv,) onto the stops that they are accelerated to, at constant acceleration."""

    height: Array  # rad, from the stop to the highest point, before now or after; inf of joints that do not fall
    acceleration: Array  # rad/s², its size

    @property
    def rate(self) -> Array:
        """The rates (nv,) of the impacts, rad/s."""
        return np.sqrt(2 * self.acceleration * self.height)

    @property
    def time(self) -> Array:
        """From the stop up and back to it (nv,), s."""
        return np.sqrt(8 * self.height / np.where(self.acceleration > 0, self.acceleration, 1.0))

    def low(self, t: float, q: Array, scales: Scales, tolerance: float) -> LowFall | None:
        """The low falls at t in s and positions q (nv,); None if there are none.

        Times the tolerance, their scales are not below the rounding of positions and of times.
        """
        joints = self.height < LOW * scales.position
        if not joints.any():
            return None
        rounding = UNITS * (np.spacing(np.abs(q)) + math.ulp(t) * self.rate)
        height = np.maximum(np.maximum(self.height, REST * scales.position), rounding / tolerance)
        fall = self._replace(height=np.minimum(height, scales.position))
        smaller = scales._replace(
            position=np.where(joints, fall.height, scales.position),
            rate=np.where(joints, np.minimum(fall.rate, scales.rate), scales.rate),
        )
        times = np.maximum(self.time[joints], RESOLVED * math.ulp(t))
        return LowFall(joints, smaller, float(times.min()), float(times.max()))


def falls_of(contacts: Contacts, t: float, q: Array, v: Array, mode: Mode) -> Falls:
    """The falls at a time in s and a state q, v (nv,) in a mode."""
    a, _ = contacts.accelerate(t, q, v, mode)
    size = np.abs(a)
    stop = np.where(a > 0, contacts.upper, contacts.lower)
    rise = np.divide(v**2, 2 * size, out=np.full(len(a), np.inf), where=size > 0)
    return Falls(np.abs(stop - q) + rise, size)


def rates_and_mode(
    contacts: Contacts, t: float, q: Array, v: Array, scales: Scales, loose: Array | float = 0.0
) -> tuple[Array, Mode]:
    """The rates (nv,) after the impacts that are due at t in s and q, v (nv,), and the mode that follows.

    Joints whose bounces are too small come to rest. They may carry others into their stops, so this is repeated.
    """
    if not contacts.stops:
        return v, contacts.choose(t, q, v, scales, loose)
    resting = np.zeros(len(q), bool)
    for _ in range(2 * len(q) + 2):
        before, v = v, contacts.strike(q, v, t)
        mode = contacts.choose(t, q, v, scales, loose)
        small = _too_small(contacts, t, q, v, mode)
        if not small.any():
            return v, mode
        if (small & ~resting).any():
            # with the joints that are held or were stopped, and those that rested before: else joints kick each other off
            # their stops, less and less, without end
            resting |= small | mode.held | ((before != 0) & (v == 0))
            v = contacts.rest(q, v, resting.nonzero()[0])
        else:  # what others that stopped gave to joints at rest
            v = np.where(small, 0.0, v)
    return v, contacts.choose(t, q, v, scales, loose)


def _too_small(contacts: Contacts, t: float, q: Array, v: Array, mode: Mode) -> Mask:
    """The joints (nv,) whose motion is too small to follow: `REST` is farther than they go.

    These leave their stops and fall back, or slide, against friction or from it, so near to a standstill.
    """
    joints, _ = contacts.at_stops(q)
    leaving, sliding = np.zeros(len(q), bool), (contacts.static > 0) & (v != 0)
    leaving[joints] = v[joints] != 0
    if not (leaving | sliding).any():
        return leaving
    fall = falls_of(contacts, t, q, v, mode)
    least = np.maximum(REST * contacts.length, RESOLVED * np.spacing(np.abs(q)))
    short = (fall.height <= least) | ((fall.height < contacts.length) & (fall.time <= RESOLVED * math.ulp(t)))
    return (leaving & short) | (sliding & (v**2 <= 2 * fall.acceleration * least))

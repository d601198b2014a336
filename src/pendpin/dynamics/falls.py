"""Falls of joints onto their stops: the scale of a bounce, and when the bounces of a series are too small to follow.

A joint that is accelerated towards a stop moves on the scale of its fall and not of a whole turn: an error of 1e-9 rad is
small for a swing and larger than a bounce of 1e-10 rad. The rates after the next impacts are then wrong, and their series
does not end. So every method integrates a fall with the tolerance times the height of the fall, and all
methods get the same bounces. The last is that which goes no farther than `REST`.

An impact gives rates to joints that dry friction held, however small they are. Those that stick again within `REST` rest at
once: else a hand that settles on its stops makes an arm stick and slip a million times in a microsecond.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from pendpin.dynamics.contacts import ROUNDING, Contacts, Mode, Scales
from pendpin.ground.arrays import EPS, Array, Indices, Mask

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
        """The rates (nv,) of the impacts, rad/s; 0 of joints that are not accelerated."""
        return np.sqrt(2 * self.acceleration * np.where(self.acceleration > 0, self.height, 0.0))

    @property
    def time(self) -> Array:
        """From the stop up and back to it (nv,), s."""
        return np.sqrt(8 * self.height / np.where(self.acceleration > 0, self.acceleration, 1.0))

    def low(self, t: float, q: Array, scales: Scales, tolerance: float) -> LowFall | None:
        """The low falls at t in s and positions q (nv,); None if there are none."""
        # Times the tolerance, their scales are not below the rounding of positions and of times.
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
    """The rates (nv,) after the impacts that are due at t in s and q, v (nv,), and the mode that follows."""
    # Joints whose bounces are too small come to rest. They may carry others into their stops, so this is repeated.
    if not contacts.stops:
        return v, contacts.choose(t, q, v, scales, loose)
    resting, struck = np.zeros(len(q), bool), False
    for _ in range(2 * len(q) + 2):
        before, v = v, contacts.strike(q, v, t)
        struck = struck or bool((v != before).any())
        mode = contacts.choose(t, q, v, scales, loose)
        small = _too_small(contacts, t, q, v, mode, struck)
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


def _too_small(contacts: Contacts, t: float, q: Array, v: Array, mode: Mode, struck: bool) -> Mask:
    """The joints (nv,) whose motion is too small to follow: `REST` is farther than they go."""
    # These leave their stops and fall back, or slide after an impact, against friction or from it, so near to a standstill.
    joints, _ = contacts.at_stops(q)
    leaving, sliding = np.zeros(len(q), bool), (contacts.static > 0) & (v != 0) & struck
    leaving[joints] = v[joints] != 0
    if not (leaving | sliding).any():
        return leaving
    fall = falls_of(contacts, t, q, v, mode)
    least = np.maximum(REST * contacts.length, RESOLVED * np.spacing(np.abs(q)))
    short = (fall.height <= least) | ((fall.height < contacts.length) & (fall.time <= RESOLVED * math.ulp(t)))
    return (leaving & short) | (sliding & (v**2 <= 2 * fall.acceleration * least))


FEW_ROUNDINGS = 4.5 * EPS  # of a position or a rate of order one
SMALL = 1e-2  # of the tolerance: a guard less than this below 0 is not an event

# The kinds of guards: the rates of sliding joints; the distances of free joints to their stops; and of held joints the
# distances of the holding torque to its largest and to its least possible value.
RATE, UPPER, LOWER, MOST, LEAST = range(5)
_AMONG = np.array([1, 0, 0, 2, 2])  # positions, rates, holding torques it is
_TURNED = np.array([1.0, -1.0, 1.0, -1.0, 1.0])  # a rate the way it slides
_WHERE_HELD = np.array([[False], [False], [False], [True], [True]])  # whether it is of held joints or of the others


@dataclass(frozen=True, eq=False)
class Guards:
    """The m guards of a scene between two events: each a position, a rate or a torque, turned and shifted."""

    contacts: Contacts
    mode: Mode
    kind: Indices  # (m,)
    joint: Indices  # (m,)
    place: Indices  # (m,) of what it looks at, among positions, rates, holding torques
    turned: Array  # (m,) -1 or 1
    offset: Array  # (m,)
    floor: Array  # (m,), how far below 0 the guards may go without an event

    def values(self, t: Array, y: Array) -> Array:
        """The guards (n, m) at times t (n,) and states y (n, size)."""
        if self.mode.holds:
            y = np.concatenate([y[:, : 2 * len(self.mode.held)], self.contacts.hold(t, y, self.mode)], 1)
        return self.turned * y.take(self.place, 1) + self.offset

    def land(self, q: Array, v: Array, fired: list[int]) -> Array:
        """Set in q, v (nv,) what fired guards say exactly. Returns the way (nv,) in which joints start, or 0."""
        loose = np.zeros(len(v))
        v[self.mode.held] = 0.0
        for kind, joint in zip(self.kind[fired].tolist(), self.joint[fired].tolist(), strict=True):
            if kind == RATE:
                v[joint] = 0.0
            elif kind in (UPPER, LOWER):
                q[joint] = (self.contacts.upper if kind == UPPER else self.contacts.lower)[joint]
            else:
                loose[joint] = -1.0 if kind == MOST else 1.0
        return loose

    def changes(self, q: Array, fired: list[int], held: Mask) -> list[tuple[int, str]]:
        """The joints to which something happened as guards fired, and what (trajectory.KINDS); `held` (nv,) after it."""
        kinds: dict[int, str] = {}
        for joint in (held != self.mode.held).nonzero()[0].tolist():
            ends = not self.contacts.lower[joint] < q[joint] < self.contacts.upper[joint]
            kinds[joint] = "stick" if held[joint] else "release" if ends else "slip"
        for kind, joint in zip(self.kind[fired].tolist(), self.joint[fired].tolist(), strict=True):
            if kind in (UPPER, LOWER):
                kinds[joint] = "stop"
            elif kind == RATE and not held[joint]:
                kinds[joint] = "reverse"
        return sorted(kinds.items())


def guards_of(contacts: Contacts, q: Array, mode: Mode, scales: Scales, tolerance: float) -> Guards:
    """The guards of a mode from positions q (nv,) on."""
    (least, most), upper, lower = contacts.holding_range(q), contacts.upper, contacts.lower
    offsets = np.array([np.zeros(len(q)), upper, -lower, most, -least])
    there = np.isfinite(offsets) & (mode.held == _WHERE_HELD)
    there[RATE] &= (mode.sign != 0) & (contacts.static > 0)
    kind, joint = there.nonzero()
    rates, near = max(SMALL * tolerance, FEW_ROUNDINGS) * scales.rate, SMALL * tolerance * scales.position
    slack = ROUNDING * mode.torque
    floors = np.array([rates, near + FEW_ROUNDINGS * np.abs(upper), near + FEW_ROUNDINGS * np.abs(lower), slack, slack])
    turned = np.where(kind == RATE, mode.sign[joint], _TURNED[kind])
    place = _AMONG[kind] * len(q) + joint
    return Guards(contacts, mode, kind, joint, place, turned, offsets[kind, joint], floors[kind, joint])

"""Guards: functions of time and state that fall to 0 when a joint stops, hits a stop or starts to slide."""

from dataclasses import dataclass

import numpy as np

from pendpin.dynamics.contacts.contacts import ROUNDING, Contacts, Mode, Scales
from pendpin.ground.arrays import EPS, Array, Indices, Mask

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
        """The joints to which something happened at an event, and what (of pendpin.trajectory.KINDS).

        At positions q (nv,), by the guards that fired and the joints (nv,) that are held then.
        """
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
    (least, most), upper, lower = contacts.range(q), contacts.upper, contacts.lower
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

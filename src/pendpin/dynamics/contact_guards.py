"""Guards: functions of time and state that fall to 0 when a joint stops, hits a stop or starts to slide."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pendpin.arrays import Array, Indices, Mask
from pendpin.dynamics.contacts import Contacts, Mode, Scales

ROUNDING = 1e-15  # of a position or a rate of order one
SMALL = 1e-2  # of the tolerance: a guard so little below 0 is no event


@dataclass(frozen=True, eq=False)
class Guards:
    """The m guards of a scene between two events.

    In this order: rates of the sliding joints, distances of free joints to their upper and their lower stops, and the
    reserves of held joints: the distance of the holding torque to its largest and to its least possible value.
    """

    contacts: Contacts
    mode: Mode
    q: Array  # (nv,) at the last event
    torque: Array  # (nv,) N m, of order one for the joints that are held

    @cached_property
    def joints(self) -> tuple[Indices, ...]:
        """The indices (k,) of the joints of each of the five kinds of guards."""
        held, contacts = self.mode.held, self.contacts
        slides = ~held & (self.mode.sign != 0) & (contacts.static > 0)
        least, most = self._range
        below, above = ~held & np.isfinite(contacts.upper), ~held & np.isfinite(contacts.lower)
        kinds = (slides, below, above, held & np.isfinite(most), held & np.isfinite(least))
        return tuple(np.flatnonzero(kind) for kind in kinds)

    @cached_property
    def _range(self) -> tuple[Array, Array]:
        """The least and the largest torque (nv,) in N m that can hold the joints."""
        return self.contacts.range(self.q)

    def values(self, t: Array, q: Array, v: Array) -> Array:
        """The guards (n, m) at times t (n,) and states q, v (n, nv)."""
        slide, below, above, most, least = self.joints
        columns = [self.mode.sign[slide] * v[:, slide]]
        columns += [self.contacts.upper[below] - q[:, below], q[:, above] - self.contacts.lower[above]]
        if len(most) or len(least):
            holding = self.contacts.hold(t, q, v, self.mode)
            columns += [self._range[1][most] - holding[:, most], holding[:, least] - self._range[0][least]]
        return np.concatenate(columns, 1)

    def floor(self, scales: Scales, tolerance: float) -> Array:
        """How far below 0 the guards may go without an event, (m,)."""
        slide, below, above, most, least = self.joints
        limits = np.abs(np.concatenate([self.contacts.upper[below], self.contacts.lower[above]]))
        rates = max(SMALL * tolerance, ROUNDING) * scales.rate[slide]
        distances = SMALL * tolerance * scales.position[np.concatenate([below, above])] + ROUNDING * limits
        return np.concatenate([rates, distances, self.contacts.slack(self.torque)[np.concatenate([most, least])]])

    def land(self, q: Array, v: Array, fired: Mask) -> tuple[Array, Array, Array]:
        """q, v (nv,) with the values of fired guards (m,) set exactly, and the way (nv,) in which joints start, or 0."""
        q, v, loose = q.copy(), v.copy(), np.zeros_like(v)
        ends = np.cumsum([len(joints) for joints in self.joints])[:-1]
        slide, below, above, most, least = (
            joints[part] for joints, part in zip(self.joints, np.split(fired, ends), strict=True)
        )
        v[self.mode.held] = v[slide] = 0.0
        q[below], q[above] = self.contacts.upper[below], self.contacts.lower[above]
        loose[most], loose[least] = -1.0, 1.0
        return q, v, loose


def guards_of(contacts: Contacts, t: float, q: Array, v: Array, mode: Mode, scales: Scales) -> Guards:
    """The guards of a mode from time t and state q, v (nv,) on."""
    _, holding = contacts.accelerate(t, q, v, mode)
    return Guards(contacts, mode, q, contacts.torques(holding, scales))

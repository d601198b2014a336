"""Sampled torques: the output of a function at its instants, held until the next one (a zero-order hold)."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from pydantic import PrivateAttr

from pendpin.effects import Effect, Torque
from pendpin.effects.pace import Pace
from pendpin.errors import InputError
from pendpin.ground.arrays import EPS, Array, Indices

MOST = 5_000_000  # instants of a run: 40 MB for each joint
NEAR = (
    2 * EPS
)  # of a time: closer to an instant it is at it. Steps end twice as far from corners (motion_without_events)


class HeldTorque(Torque):
    """A Torque with `every` in the dynamics of one run, which integrates with what is held.

    As long as no run has begun it is the function itself. During one it is what was sampled last; afterwards, for
    accelerations and work at the samples, the recorded output.
    """

    _effect: Torque = PrivateAttr()
    _joints: Indices = PrivateAttr()
    _start: float = PrivateAttr(0.0)  # s
    _given: int = PrivateAttr(0)  # outputs that an earlier run has recorded: they are not computed again
    _values: Array | None = PrivateAttr(None)  # (m, k) N m, at the instants; 0 where they are not known yet
    _current: Array | None = PrivateAttr(None)  # (k,) N m, during an integration

    @classmethod
    def of(cls, effect: Torque, joints: Indices) -> "HeldTorque":
        """The effect on the joints (k,), by their indices in the model."""
        held = cls.model_construct(**effect.given())
        held._effect, held._joints = effect, joints
        return held

    def since(self, start: float) -> tuple[Effect, float]:
        """Its instants are counted from the start of a run."""
        return self, 0.0

    def pace(self, begin: float, end: float, negligible: float) -> Pace:
        """A corner at every instant; between them nothing changes. Raises InputError for too many instants."""
        if end / self._interval > MOST:
            raise InputError(f"torque: every = {self._interval:g} s makes over {MOST:,} instants in {end:g} s")
        corners = self._interval * np.arange(1, self._place(end) + 1)
        corners = corners[corners < end * (1 - NEAR)]
        return Pace(corners, np.full(len(corners) + 1, np.inf))

    def torques(self, t: Any, q: Array, v: Array, xp: Any = np) -> Array:
        """What is held at t in s, (k,) N m."""
        if self._current is not None:
            return self._current.copy()
        if self._values is None:
            return self._effect.torques(t, q, v)
        return self._values[self._place(t - self._start)].copy()

    def begin(self, start: float, end: float, recorded: Array | None = None) -> None:
        """Make room for a run from `start` in s that lasts to `end` in s since then, with the outputs `recorded` (m, k).

        Raises InputError for outputs that are not of these joints.
        """
        self._start, room = start, np.zeros((self._place(end) + 1, len(self._joints)))
        self._given = 0 if recorded is None else min(len(recorded), len(room))
        if recorded is not None:
            if recorded.shape[1:] != room.shape[1:]:
                raise InputError(
                    f"the run's outputs of a torque are of {recorded.shape[1:]} joints, not {room.shape[1:]}"
                )
            room[: self._given] = recorded[: self._given]
        self._values, self._current = room, None

    def is_instant(self, t: float) -> bool:
        """Whether t, in s since the start, is an instant but for its rounding."""
        return abs(t - self._interval * self._place(t)) <= self._slack(t)

    def sample(self, t: float, q: Array, v: Array) -> None:
        """Hold what the function returns at the instant t, in s since the start, from q, v (nv,); or what was given."""
        place = self._place(t)
        if place >= self._given:
            instant = self._start + self._interval * place
            self.record[place] = self._effect.torques(instant, q[self._joints], v[self._joints])
        self._current = self.record[place]

    def recall(self, t: float, values: Array) -> None:
        """Go on from t, in s since the start, with the outputs (m, k) up to there."""
        if values is not self.record:
            self.record[:] = values
        self._current = self.record[self._place(t)]

    def finish(self) -> None:
        """The integration is over: from now on the record answers by time."""
        self._current = None

    @property
    def record(self) -> Array:
        """The outputs (m, k) in N m at all instants of the run; the array itself, in which a run writes."""
        assert self._values is not None
        return self._values

    def until(self, t: float) -> Array:
        """The outputs (m, k) in N m up to t in s since the start, and those that were given."""
        return self.record[: max(self._given, self._place(t) + 1)].copy()

    @property
    def recorded(self) -> bool:
        """Whether a run has begun."""
        return self._values is not None

    @property
    def _interval(self) -> float:
        assert self.every is not None
        return self.every

    def _slack(self, t: float) -> float:
        return NEAR * (abs(self._start) + abs(t))

    def _place(self, t: float) -> int:
        """Which instant is the last one at t in s since the start."""
        place = int(t / self._interval)
        return place + 1 if self._interval * (place + 1) - t <= self._slack(t) else place


def recall_outputs(held: Sequence[HeldTorque], run: Any, end: float, start: float) -> None:
    """Give sampled torques the outputs that a run has recorded, for a motion to `end` in s since `start` in s.

    Raises InputError for a run of other torques.
    """
    if len(held) != len(run.held):
        raise InputError(f"this run has outputs of {len(run.held)} sampled torques, and its scene has {len(held)}")
    for one, outputs in zip(held, run.held, strict=True):
        one.begin(start, end, outputs)

"""The hand-derived chain equations as an engine: O(n) in time and memory, for chains of any length."""

from collections.abc import Callable

import numpy as np

from pendpin.effects import Motion
from pendpin.engines.base import AngleEngine, Derivative, Loads, ProgressCallback, Sample, count_calls
from pendpin.equations.base import PHI, THETA, split_by_rod
from pendpin.equations.chain import solution
from pendpin.equations.chain.kinematics import motion
from pendpin.ground.arrays import Array, Indices, applied
from pendpin.model.build import FLIP, SIGNS, Model

BATCH = 1 << 13  # rods solved at once: what they need stays in the fast memory of a processor


class LongChain(AngleEngine):
    """Every joint's reactions as the unknowns of one banded system; y = (q, v)."""

    name = "chain"

    def __init__(self, model: Model, loads: Loads) -> None:
        super().__init__(model, loads)
        assert model.chain is not None
        self._chain = model.chain

    def derivative(self, progress: ProgressCallback) -> tuple[Derivative, Callable[[], int]]:
        """(v, q'') from one banded solve."""
        nv = len(self.model.joints)

        def derivative(dy: Array, t: float, y: Array) -> None:
            dy[:nv] = y[nv:]
            dy[nv:] = self._solve(np.array([t]), y[None, :nv], y[None, nv:]).acceleration.reshape(-1)

        return count_calls(derivative, progress)

    def motion(self, y: Array) -> Motion:
        """Poses and velocities of all rods from y = (q, v), (2 nv,)."""
        return self._motion(*split_by_rod(y.reshape(2, -1)))

    def evaluate(self, t: Array, q: Array, v: Array, torque: Array | None = None) -> Sample:
        """Solves of some states at a time; the wrench on a massless cross is its rod's, in the cross's frame."""
        size, a, wrench = max(1, BATCH // self._chain.n), np.empty(q.shape), np.empty((*q.shape, 6))
        states = (t, q, v) if torque is None else (t, q, v, torque)
        for part in (slice(i, i + size) for i in range(0, len(t), size)):
            block = self._solve(*(x[part] for x in states))
            a[part] = block.acceleration.reshape(-1, q.shape[1])
            wrench[part, PHI] = block.wrench * np.tile(SIGNS, 2)
            s, c = np.sin(q[part, PHI, None]), np.cos(q[part, PHI, None])
            x, y, z = (block.wrench[..., i::3] for i in range(3))
            of_cross = wrench[part, THETA]
            of_cross[..., ::3], of_cross[..., 1::3], of_cross[..., 2::3] = c * x + s * z, -y, s * x - c * z
        return Sample(a, wrench)

    def accelerate(self, t: float, q: Array, v: Array, torque: Array | None = None) -> Array:
        """q'' (nv,) rad/s² from one banded solve, with torques (nv,) added."""
        extra = None if torque is None else torque[None]
        return self._solve(np.array([t]), q[None], v[None], extra).acceleration.reshape(-1)

    def compliance(self, q: Array, joints: Indices) -> Array:
        """Columns (nv, k) of the inverse mass matrix at q (nv,), one solve for each of k joints."""
        k, shape = len(joints), (len(joints), self._chain.n, 2)
        torque = np.zeros((k, len(q)))
        torque[np.arange(k), joints] = 1.0
        angles = np.broadcast_to(split_by_rod(q), shape)
        unit_responses = solution.solve(self._chain, angles, np.zeros(shape), np.zeros(3), torque=torque.reshape(shape))
        return unit_responses.acceleration.reshape(k, -1).T

    def _solve(self, t: Array, q: Array, v: Array, extra: Array | None = None) -> solution.ChainSolution:
        """The chain equations at times (n,) and states (n, nv), all at once."""
        loads = self.loads
        angles, rates = split_by_rod(q), split_by_rod(v)
        torque, force, moment = extra, None, None
        if loads.torque is not None:
            of_effects = np.array([loads.torque(*state) for state in zip(t, q, v, strict=True)])
            torque = of_effects if extra is None else of_effects + extra
        if torque is not None:
            torque = torque.reshape(angles.shape)
        if loads.wrench is not None:
            force, moment = (x * SIGNS for x in loads.wrenches(t, self._motion(angles, rates)))
        field = loads.constant if loads.varying is None else np.array([loads.field(time) for time in t])
        return solution.solve(self._chain, angles, rates, field * SIGNS, torque=torque, force=force, moment=moment)

    def _motion(self, q: Array, v: Array) -> Motion:
        """Poses and velocities in W of n rods with angles and rates q, v (..., n, 2)."""
        moving = motion(self._chain, q, v)
        start = np.zeros((*q.shape[:-2], 1, 3))
        return Motion(
            np.concatenate([start, moving.tips[..., :-1, :]], -2) * SIGNS,
            FLIP @ moving.frames @ FLIP,
            np.concatenate([start, moving.tip_velocities[..., :-1, :]], -2) * SIGNS,
            applied(moving.frames, moving.omega) * SIGNS,
        )

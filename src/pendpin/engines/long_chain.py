"""The hand-derived chain equations as an engine: O(n) in time and memory, for chains of any length."""

from collections.abc import Callable

import numpy as np

from pendpin.derivations import chain
from pendpin.derivations.base import Array
from pendpin.derivations.chain_kinematics import motion
from pendpin.engines.base import Derivative, Engine, Loads, Motion, Sample, Watch, counted
from pendpin.model import FLIP, Model

SIGNS = np.diag(FLIP)


class LongChain(Engine):
    """Every joint's reactions as the unknowns of one banded system; y = (q, v)."""

    name = "chain"

    def __init__(self, model: Model, loads: Loads) -> None:
        super().__init__(model, loads)
        assert model.chain is not None
        self._chain = model.chain

    def derivative(self, watch: Watch) -> tuple[Derivative, Callable[[], int]]:
        """As `Engine.derivative`."""
        nv = len(self.model.joints)

        def derivative(dy: Array, t: float, y: Array) -> None:
            dy[:nv] = y[nv:]
            dy[nv:] = self._solve(t, y[:nv], y[nv:]).acceleration.reshape(-1)

        return counted(derivative, watch)

    def evaluate(self, t: Array, q: Array, v: Array) -> Sample:
        """As `Engine.evaluate`; the wrench on the massless cross is that on its rod, in the frame of the cross."""
        a, wrench = np.empty(q.shape), np.empty((*q.shape, 6))
        for i in range(len(q)):
            found = self._solve(t[i], q[i], v[i])
            a[i] = found.acceleration.reshape(-1)
            wrench[i, 1::2] = found.wrench * np.tile(SIGNS, 2)
            wrench[i, ::2] = _on_cross(found.wrench, q[i, 1::2])
        return Sample(a, wrench)

    def _solve(self, t: float, q: Array, v: Array) -> chain.ChainSolution:
        loads = self.loads
        angles, rates = q.reshape(-1, 2), v.reshape(-1, 2)
        torque = None if loads.torque is None else loads.torque(t, q, v).reshape(-1, 2)
        force, moment = None, None
        if loads.wrench is not None:
            force, moment = (x * SIGNS for x in loads.wrench(t, self._motion(angles, rates)))
        field = loads.field(t) * SIGNS
        return chain.solve(self._chain, angles, rates, field, torque=torque, force=force, moment=moment)

    def _motion(self, q: Array, v: Array) -> Motion:
        found = motion(self._chain, q, v)
        start = np.zeros((1, 3))
        return Motion(
            np.concatenate([start, found.tips[:-1]]) * SIGNS,
            FLIP @ found.frames @ FLIP,
            np.concatenate([start, found.tip_velocities[:-1]]) * SIGNS,
            np.einsum("nij,nj->ni", found.frames, found.omega) * SIGNS,
        )


def _on_cross(wrench: Array, phi: Array) -> Array:
    """Wrenches (n, 6) given in rods' body frames, in the link frames of their crosses."""
    s, c = np.sin(phi)[:, None], np.cos(phi)[:, None]
    x, y, z = (wrench.reshape(-1, 2, 3)[..., i] for i in range(3))
    return (np.stack([c * x + s * z, y, c * z - s * x], -1) * SIGNS).reshape(-1, 6)

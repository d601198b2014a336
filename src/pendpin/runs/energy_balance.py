"""The work of every effect: from its potential if it has one, else integrated with the motion."""

import numpy as np

from pendpin.dynamics.binding import Accounts
from pendpin.dynamics.binding.acting import in_order
from pendpin.dynamics.binding.bound import State
from pendpin.dynamics.dynamics import Dynamics
from pendpin.effects import Idle
from pendpin.engines import Derivative, Engine
from pendpin.ground.arrays import Array


class EnergyBalance:
    """The work of each kind of effect in one scene.

    `engine` integrates the motion: that of the dynamics; if that is compiled, one whose state holds the work too.
    """

    def __init__(self, dynamics: Dynamics) -> None:
        effects, accounts = dynamics.effects, Accounts.of(dynamics.effects, dynamics.potentials)
        self.kinds, self._nv = accounts.kinds, len(dynamics.model.joints)
        self._idle = tuple(effect.kind for effect in effects if isinstance(effect, Idle))
        self.engine: Engine = dynamics.compiled(accounts) if dynamics.engine.compiles else dynamics.engine
        self._powers = dynamics.binding.powers(accounts)
        accounted = zip(in_order(effects), dynamics.potentials, strict=True)
        self._offered = [
            (self.kinds.index(effect.kind), place)
            for place, ((effect, _), potential) in enumerate(accounted)
            if potential is not None and not isinstance(effect, Idle)
        ]

    def powers(self, t: float, y: Array) -> Array:
        """The power (kinds,) in W of the effects without a potential, at t in s since the start and the engine's state y."""
        nv = self._nv
        return np.array(self._powers(State(t, y[:nv], y[nv : 2 * nv], lambda: self.engine.motion(y))), float)

    def with_work(self, derivative: Derivative, size: int) -> Derivative:
        """The derivative of (y, work of each account), from that of the engine, of states y (size,)."""

        if self.engine.compiles:
            return derivative

        def both(dy: Array, t: float, y: Array) -> None:
            derivative(dy[:size], t, y[:size])
            dy[size:] = self.powers(t, y[:size])

        return both

    def close(self, work: Array, potentials: Array) -> dict[str, Array]:
        """The work of each kind (n,) in J, from what was integrated (n, kinds) and the effects' potentials (n, effects)."""
        total = work.copy()
        for account, place in self._offered:
            total[:, account] += potentials[0, place] - potentials[:, place]
        return dict.fromkeys(self._idle, np.zeros(len(work))) | dict(zip(self.kinds, total.T, strict=True))

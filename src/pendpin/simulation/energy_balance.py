"""The work of every effect: from its potential if it has one, else integrated with the motion."""

from collections.abc import Callable

import numpy as np

from pendpin.arrays import Array
from pendpin.dynamics.binding import bodies_of, body_wrench, field_since, in_order, joint_torque, since, surroundings
from pendpin.dynamics.dynamics import Dynamics, Potential
from pendpin.effects import BodyEffect, ContactEffect, Effect, FieldEffect, Idle, JointEffect, Motion
from pendpin.engines import Derivative

Power = Callable[[float, Array], float]  # t, y of the engine -> W


class EnergyBalance:
    """The work of each kind of effect in one scene."""

    def __init__(self, dynamics: Dynamics) -> None:
        ordered = in_order(dynamics.effects)
        self.kinds = tuple(dict.fromkeys(effect.kind for effect, _ in ordered if not isinstance(effect, Idle)))
        self._idle = tuple(effect.kind for effect, _ in ordered if isinstance(effect, Idle))
        self._powers: list[tuple[int, Power]] = []
        self._potentials: list[tuple[int, Potential]] = []
        complete = surroundings(dynamics.effects, start=dynamics.start)
        for (effect, where), potential in zip(ordered, dynamics.potentials, strict=True):
            if isinstance(effect, Idle):
                continue
            account = self.kinds.index(effect.kind)
            if potential is not None:
                self._potentials.append((account, potential))
            elif not isinstance(effect, ContactEffect):
                self._powers.append((account, _power(dynamics, effect, where, complete)))

    def powers(self, t: float, y: Array) -> Array:
        """The power (kinds,) in W of the effects without a potential, at t in s since the start and the engine's state y."""
        out = np.zeros(len(self.kinds))
        for account, power in self._powers:
            out[account] += power(t, y)
        return out

    def with_work(self, derivative: Derivative, size: int) -> Derivative:
        """The derivative of (y, work of each account), from that of y (size,)."""

        def both(dy: Array, t: float, y: Array) -> None:
            derivative(dy[:size], t, y[:size])
            dy[size:] = self.powers(t, y[:size])

        return both

    def close(self, work: Array, q: Array, poses: Array) -> dict[str, Array]:
        """The work of each kind (n,) in J, from what was integrated (n, kinds) and the potentials along q (n, nv)."""
        total = work.copy()
        for account, potential in self._potentials:
            values = potential(q, poses)
            total[:, account] += values[0] - values
        return dict.fromkeys(self._idle, np.zeros(len(work))) | dict(zip(self.kinds, total.T, strict=True))


def _power(dynamics: Dynamics, effect: Effect, where: str, complete: Callable[[float, Motion], Motion]) -> Power:
    """The power in W of one effect, as a function of t in s and the engine's state y (size,)."""
    model, engine, start = dynamics.model, dynamics.engine, dynamics.start
    bodies, nv = bodies_of(model), len(model.joints)
    if isinstance(effect, JointEffect):
        torque = since(start, effect, joint_torque(model, effect, where))
        return lambda t, y: float(torque(t, y[:nv], y[nv:]) @ y[nv:])
    if isinstance(effect, FieldEffect):
        field = field_since(start, effect, "field")
        return lambda t, y: float(bodies.mass @ (_centre_velocities(bodies.com, engine.motion(y)) @ field(t)))
    assert isinstance(effect, BodyEffect)
    wrench = since(start, effect, body_wrench(model, effect, where))

    def power(t: float, y: Array) -> float:
        motion = engine.motion(y)
        force, moment = wrench(t, complete(t, motion))
        return float((force * _centre_velocities(bodies.com, motion) + moment * motion.spin).sum())

    return power


def _centre_velocities(com: Array, motion: Motion) -> Array:
    """Velocities (n, 3) in m/s, W, of the centres of mass com (n, 3) in link frames."""
    return motion.velocity + np.cross(motion.spin, motion.levers(com))

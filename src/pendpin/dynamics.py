"""A model with its effects bound once: accelerations, joint wrenches, energy; nothing is evaluated for the rest."""

from collections.abc import Callable
from typing import Any

import numpy as np

from pendpin.derivations.base import Array
from pendpin.effects import Effect, FieldEffect
from pendpin.errors import InputError
from pendpin.model import Model, build, pinocchio
from pendpin.scene import Scene
from pendpin.trajectory import Reactions

Derivative = Callable[[Array, float, Array], None]  # f(dy, t, y) fills dy

WATCH_EVERY = 2048  # evaluations between two calls of a watcher


class Dynamics:
    """The equations of motion of one scene. It owns its Pinocchio data: use one in each thread.

    q, v are (nv,), in model order; angles in rad, slides in m.
    """

    def __init__(self, model: Model, effects: tuple[Effect, ...] = ()) -> None:
        pin = pinocchio()
        self.model = model
        fields = [effect for effect in effects if isinstance(effect, FieldEffect)]
        self._constant = sum((e.field(0.0) for e in fields if e.constant), np.zeros(3))
        self._varying = tuple(e for e in fields if not e.constant)
        self._pin = pin.Model(model.pin)
        self._pin.gravity = pin.Motion(self._constant, np.zeros(3))
        self._data = self._pin.createData()
        self._no_torque = np.zeros(self._pin.nv)

    def field(self, t: float) -> Array:
        """The sum of the uniform acceleration fields at time t, (3,) m/s², W."""
        return sum((e.field(t) for e in self._varying), self._constant.copy())

    def acceleration(self, t: float, q: Array, v: Array) -> Array:
        """q'' (nv,) at time t by the articulated-body algorithm. Raises InputError for arrays of another shape."""
        q, v = self._state(q, v)
        self._set_field(t)
        return np.array(pinocchio().aba(self._pin, self._data, q, v, self._no_torque))

    def wrenches(self, t: float, q: Array, v: Array) -> Array:
        """What each joint's parent exerts on its child, (joints, 6): force N, then moment N m, in the joint's frame."""
        q, v = self._state(q, v)
        a = self.acceleration(t, q, v)
        pinocchio().rnea(self._pin, self._data, q, v, a)
        return np.array([self._data.f[joint].vector for joint in range(1, self._pin.njoints)])

    def energy(self, q: Array, v: Array) -> tuple[float, float]:
        """Kinetic energy and the potential of the conservative effects, J; zero potential at W's origin."""
        pin, (q, v) = pinocchio(), self._state(q, v)
        self._pin.gravity.linear = self._constant
        kinetic = pin.computeKineticEnergy(self._pin, self._data, q, v)
        return kinetic, pin.computePotentialEnergy(self._pin, self._data, q)

    def derivative(self, watch: Callable[[float], None]) -> tuple[Derivative, Callable[[], int]]:
        """The first-order form for solvers, f(dy, t, y) that fills dy with y = (q, v), and the count of its calls.

        `watch` is called with t now and then; what it raises ends the run.
        """
        pin, data, tau = self._pin, self._data, self._no_torque
        aba, nv = pinocchio().aba, self._pin.nv
        state = rates = q = v = dq = dv = np.empty(0)
        set_field = self._set_field if self._varying else None
        calls = 0

        def derivative(dy: Array, t: float, y: Array) -> None:
            nonlocal state, rates, q, v, dq, dv, calls
            if y is not state:  # solvers hand in the same arrays again and again: cut them once
                state, q, v = y, y[:nv], y[nv:]
            if dy is not rates:
                rates, dq, dv = dy, dy[:nv], dy[nv:]
            calls += 1
            if not calls % WATCH_EVERY:
                watch(t)
            if set_field:
                set_field(t)
            dq[:] = v
            dv[:] = aba(pin, data, q, v, tau)

        return derivative, lambda: calls

    def _set_field(self, t: float) -> None:
        if self._varying:
            self._pin.gravity.linear = self.field(t)

    def _state(self, q: Any, v: Any) -> tuple[Array, Array]:
        q, v = np.asarray(q, float), np.asarray(v, float)
        for name, array in (("q", q), ("v", v)):
            if array.shape != (self._pin.nv,):
                raise InputError(
                    f"{name} has shape {array.shape}; this model has {self._pin.nv} joints: ({self._pin.nv},)"
                )
        return q, v


def bind(scene: Scene) -> Dynamics:
    """The dynamics of a scene. Raises InputError for a model that cannot be simulated."""
    return Dynamics(build(scene.model), scene.effects)


def reactions(model: Model, q: Array, wrench: Array) -> Reactions | None:
    """R1, R2, R3, M3, Mc (n, rods) from q (n, nv) and wrenches (n, joints, 6); None without universal joints."""
    if not model.rods:
        return None
    columns = []
    for rod in model.rods:
        R1, R2, minus_R3 = np.moveaxis(wrench[:, rod.phi, :3] @ rod.body, -1, 0)
        moment = wrench[:, rod.phi, 3:] @ rod.body
        s, c = np.sin(q[:, rod.phi]), np.cos(q[:, rod.phi])
        Mc = c * moment[:, 2] - s * moment[:, 0]  # along a3
        columns.append((R1, R2, -minus_R3, Mc * c, Mc))
    return Reactions(*(np.stack(column, -1) for column in zip(*columns, strict=True)))

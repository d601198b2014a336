"""Pinocchio on revolute and prismatic joints: any tree, a universal joint as two revolute ones."""

from collections.abc import Callable
from functools import cached_property, partial
from typing import Any

import numpy as np

from pendpin.effects import Motion
from pendpin.engines.base import CALLBACK_EVERY, CALLBACK_EVERY_SLOW, AngleEngine, Derivative, ProgressCallback, Sample
from pendpin.engines.external_forces import (
    centres_of,
    external_forces,
    forces,
    joints_of,
    motion_of,
    turn_into_joint_frames,
)
from pendpin.engines.hamilton import CanonicalForm, mirror_upper
from pendpin.engines.loads import Loads
from pendpin.ground.arrays import Array, Indices
from pendpin.model.bodies import pinocchio, with_gravity
from pendpin.model.build import Model


class Revolute(AngleEngine):
    """Accelerations by ABA, wrenches by RNEA; y = (q, v). It owns its Pinocchio data: use one in each thread."""

    name = "pinocchio"

    def __init__(self, model: Model, loads: Loads) -> None:
        super().__init__(model, loads)
        self._com, self._places = centres_of(model.bodies), joints_of(model.bodies)
        self._no_torque = np.zeros(len(model.joints))
        self._loaded = any((loads.varying, loads.torque, loads.wrench))

    @cached_property
    def _pin(self) -> Any:
        """The model in the constant fields, made where it is used: on compiled equations that may be nowhere."""
        return with_gravity(self.model.pin, self.loads.constant)

    @cached_property
    def _aba(self) -> Any:
        return pinocchio().aba

    @cached_property
    def _data(self) -> Any:
        """Pinocchio's data: half a second and 600 MB for 100 rods, only where they are used."""
        return pinocchio().Data(self._pin)

    def canonical(self) -> CanonicalForm:
        """The equations in positions and momenta."""
        return CanonicalForm(self.model, self.loads)

    def derivative(self, progress: ProgressCallback) -> tuple[Derivative, Callable[[], int]]:
        """(v, q'') by Pinocchio's ABA: one call of it where constant fields act alone."""
        pin, data, tau, nv, aba = self._pin, self._data, self._no_torque, self._pin.nv, self._aba
        accelerate = self.accelerate if self._loaded else None
        state = rates = q = v = dq = dv = np.empty(0)
        calls, every = 0, CALLBACK_EVERY_SLOW if self._loaded else CALLBACK_EVERY

        def derivative(dy: Array, t: float, y: Array) -> None:
            nonlocal state, rates, q, v, dq, dv, calls
            if y is not state:  # solvers pass the same arrays many times: slice them once
                state, q, v = y, y[:nv], y[nv:]
            if dy is not rates:
                rates, dq, dv = dy, dy[:nv], dy[nv:]
            calls += 1
            if not calls % every:
                progress(t)
            dq[:] = v
            dv[:] = accelerate(t, q, v) if accelerate else aba(pin, data, q, v, tau)

        return derivative, lambda: calls

    def motion(self, y: Array) -> Motion:
        """Poses and velocities of the bodies at y (2 nv,), by Pinocchio's forward kinematics."""
        nv = self._pin.nv  # ABA leaves the poses of an earlier call (docs/pinocchio_notes.md, 6)
        pinocchio().forwardKinematics(self._pin, self._data, y[:nv], y[nv:])
        return motion_of(self._data, self._places)

    def evaluate(self, t: Array, q: Array, v: Array, torque: Array | None = None) -> Sample:
        """ABA for accelerations (n, nv), then RNEA for wrenches (n, joints, 6), state by state."""
        a, wrench = np.empty(q.shape), np.empty((*q.shape, 6))
        extra, externals = [None] * len(q) if torque is None else torque, list[tuple[list, ...]]([()] * len(q))
        if self.loads.wrench is not None and len(q):  # Pinocchio's last argument for each state, evaluated together
            motions = [self.motion(y)[:4] for y in np.concatenate([q, v], 1)]
            origin, rotation, velocity, spin = (np.array(part) for part in zip(*motions, strict=True))
            motion = Motion(origin, rotation, velocity, spin)
            wrenches = turn_into_joint_frames(self._com, motion, *self.loads.wrenches(t, motion))
            externals = [(forces(rows, self._places, self._pin.njoints),) for rows in wrenches]
        rnea, reactions = pinocchio().rnea, [self._data.f[joint].vector for joint in range(1, self._pin.njoints)]
        for i in range(len(q)):
            a[i] = self.accelerate(t[i], q[i], v[i], extra[i], externals[i])
            # RNEA, though ABA has computed forces too: with external forces it leaves them out of data.f, and data.f[0] adds
            # up from call to call (docs/pinocchio_notes.md, 5).
            rnea(self._pin, self._data, q[i], v[i], a[i], *externals[i])
            wrench[i] = reactions  # they follow the data
        return Sample(a, wrench)

    def compliance(self, q: Array, joints: Indices) -> Array:
        """Columns (nv, k) of Pinocchio's inverse mass matrix at q (nv,)."""
        return mirror_upper(pinocchio().computeMinverse(self._pin, self._data, q))[:, joints]

    def accelerate(
        self, t: float, q: Array, v: Array, torque: Array | None = None, external: tuple[list, ...] | None = None
    ) -> Array:
        """q'' (nv,) in rad/s² by ABA, with torques (nv,) added; `external` is Pinocchio's last argument, if known."""
        if torque is None and not self._loaded:
            return self._aba(self._pin, self._data, q, v, self._no_torque)
        loads = self.loads
        if loads.varying:
            self._pin.gravity.linear = loads.field(t)
        tau = self._no_torque if loads.torque is None else loads.torque(t, q, v)
        tau = tau if torque is None else tau + torque
        if external is None:
            external = ()
            if loads.wrench is not None:
                wrench = partial(loads.wrench, t)
                external = (external_forces(self._pin, self._data, q, v, self._com, self._places, wrench),)
        return self._aba(self._pin, self._data, q, v, tau, *external)

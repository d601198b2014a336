"""Pinocchio on revolute and prismatic joints: any tree, a universal joint as two revolute ones.

Below it, body effects in Pinocchio's terms, and its model in Hamilton's form, positions and momenta, for implicit methods.
"""

from collections.abc import Callable, Sequence
from functools import cached_property, partial
from typing import Any, NamedTuple

import numpy as np

from pendpin.effects import Motion
from pendpin.engines.base import (
    CALLBACK_EVERY,
    CALLBACK_EVERY_QUICK,
    AngleEngine,
    Derivative,
    Loads,
    ProgressCallback,
    Sample,
)
from pendpin.ground.arrays import Array, Indices, cross
from pendpin.model.bodies import Body, in_mass_unit, mirror_upper, pinocchio, with_gravity
from pendpin.model.build import Model

DELTA = 1e-7  # rad, rad/s: of forward differences
Wrench = Callable[[Motion], tuple[Array, Array]]  # force N and moment N m about com, (n, 3), W


def external_forces(
    model: Any, data: Any, q: Array, v: Array, com: Array, joints: Sequence[int], wrench: Wrench
) -> list[Any]:
    """One pin.Force a joint, in its frame, at its origin, at Pinocchio's q, v, from a wrench about com (n, 3) m in W."""
    pinocchio().forwardKinematics(model, data, q, v)
    motion = motion_of(data, joints)
    return forces(turn_into_joint_frames(com, motion, *wrench(motion)), joints, len(data.oMi))


def turn_into_joint_frames(com: Array, motion: Motion, force: Array, moment: Array) -> Array:
    """Forces and moments (..., n, 3) in W about com (n, 3) as wrenches (..., n, 6) of joints; in their frames, as com."""
    linear, angular = ((part[..., None, :] @ motion.rotation)[..., 0, :] for part in (force, moment))  # R^T x
    return np.concatenate([linear, angular + cross(com, linear)], -1)


def forces(wrenches: Array, joints: Sequence[int], count: int) -> list[Any]:
    """One pin.Force for each of `count` joints of Pinocchio's model, from wrenches (n, 6) on those at `joints`."""
    pin = pinocchio()
    out = [pin.Force.Zero()] * count
    for joint, wrench in zip(joints, wrenches, strict=True):
        out[joint] = pin.Force(wrench)
    return out


def motion_of(data: Any, joints: Sequence[int]) -> Motion:
    """The motion of bodies from data whose forward kinematics has run; joints are their places in the model."""
    R = np.array([data.oMi[joint].rotation for joint in joints])
    twists = np.array([data.v[joint].vector for joint in joints]).reshape(-1, 2, 3)
    velocity, spin = (twists @ R.swapaxes(-1, -2)).swapaxes(0, 1)  # R x
    return Motion(np.array([data.oMi[joint].translation for joint in joints]), R, velocity, spin)


def joints_of(bodies: Sequence[Body]) -> list[int]:
    """The places of bodies in Pinocchio's model on revolute and prismatic joints."""
    return [body.joint + 1 for body in bodies]


class Canonical(NamedTuple):
    """What enters p = M v and p' = F at one state."""

    mass: Array  # (nv, nv), M = dp/dv
    coupling: Array  # (nv, nv), dp/dq at given v; its transpose is dF/dv, but for that of joint and body effects
    force: Array  # (nv,), F = dL/dq and what the effects add


class CanonicalForm:
    """p = M(q) v and p' = F(t, q, v) = (dp/dq)^T v / 2 - g(q) + the effects' generalised forces.

    (dp/dq)_ij = sum_k dM_ik/dq_j v_k is Pinocchio's derivative of RNEA at acceleration v and no rates; as the kinetic
    energy is v M v / 2, its derivative in q is half of (dp/dq)^T v. Gauss methods are symplectic in (q, p), which they
    are not in (q, v). It owns its Pinocchio data: use one in each thread.
    """

    def __init__(self, model: Model, loads: Loads) -> None:
        pin = self._pinocchio = pinocchio()
        self.model, self.loads = model, loads
        scaled, self._unit = in_mass_unit(model.pin)  # kg, of what Pinocchio returns
        self._bare, self._heavy = pin.Model(scaled), with_gravity(scaled, loads.constant)
        self._data, self._rest = pin.Data(self._bare), np.zeros(self._bare.nv)

    def momentum(self, q: Array, v: Array) -> Array:
        """p = M(q) v (nv,), kg m²/s."""
        return self._mass(q) @ v

    def velocity(self, q: Array, p: Array) -> Array:
        """v (nv,). Raises LinAlgError where the mass matrix is singular."""
        return np.asarray(np.linalg.solve(self._mass(q), p), float)

    def at(self, t: float, q: Array, v: Array) -> Canonical:
        """M, dp/dq and F at t in s and q, v (nv,); the arrays are copies."""
        pin, loads = self._pinocchio, self.loads
        dp, _, mass = pin.computeRNEADerivatives(self._bare, self._data, q, self._rest, v)
        coupling, mass = dp * self._unit, mirror_upper(mass) * self._unit
        if loads.varying:
            self._heavy.gravity.linear = loads.field(t)
        force = v @ coupling / 2 - pin.computeGeneralizedGravity(self._heavy, self._data, q) * self._unit
        if loads.torque is not None:
            force = force + loads.torque(t, q, v)
        if loads.wrench is not None:
            rest, com, joints = self._rest, self.model.body_arrays.com, joints_of(self.model.bodies)
            external = external_forces(self._bare, self._data, q, v, com, joints, partial(loads.wrench, t))
            force = force - pin.rnea(self._bare, self._data, q, rest, rest, external)
        return Canonical(mass, coupling, force)

    def slopes(self, t: float, q: Array, v: Array, now: Canonical, thorough: bool) -> tuple[Array, Array]:
        """dF/dq and dF/dv (nv, nv): those of fields, less what is of second order in v; or all, by differences."""
        if not thorough:
            slope = self._pinocchio.computeGeneralizedGravityDerivatives(self._heavy, self._data, q)
            return -slope * self._unit, now.coupling.T
        steps = DELTA * np.eye(len(q))
        in_q = np.array([self.at(t, q + step, v).force for step in steps]) - now.force
        if self.loads.torque is None and self.loads.wrench is None:
            return in_q.T / DELTA, now.coupling.T
        in_v = np.array([self.at(t, q, v + step).force for step in steps]) - now.force
        return in_q.T / DELTA, in_v.T / DELTA

    def _mass(self, q: Array) -> Array:
        """The mass matrix (nv, nv) in kg m², by CRBA."""
        return mirror_upper(self._pinocchio.crba(self._bare, self._data, q)) * self._unit


class Revolute(AngleEngine):
    """Accelerations by ABA, wrenches by RNEA; y = (q, v). It owns its Pinocchio data: use one in each thread."""

    name = "pinocchio"

    def __init__(self, model: Model, loads: Loads) -> None:
        super().__init__(model, loads)
        self._com, self._places = model.body_arrays.com, joints_of(model.bodies)
        self._no_torque = np.zeros(len(model.joints))
        self._loaded = any((loads.varying, loads.torque, loads.wrench))

    @cached_property
    def _pin_model(self) -> Any:
        """The model in the constant fields, made at its first use: a run on compiled equations may need none."""
        return with_gravity(self.model.pin, self.loads.constant)

    @cached_property
    def _aba(self) -> Any:
        return pinocchio().aba

    @cached_property
    def _data(self) -> Any:
        """Pinocchio's data: half a second and 600 MB for 100 rods, only where they are used."""
        return pinocchio().Data(self._pin_model)

    def derivative(self, progress: ProgressCallback) -> tuple[Derivative, Callable[[], int]]:
        """(v, q'') by Pinocchio's ABA: one call of it where constant fields act alone."""
        nv, pin, data, aba, tau = self._pin_model.nv, self._pin_model, self._data, self._aba, self._no_torque
        calls, loaded = 0, self._loaded
        every = CALLBACK_EVERY if loaded else CALLBACK_EVERY_QUICK

        def derivative(dy: Array, t: float, y: Array) -> None:  # which counts its calls itself: a layer takes 4 %
            nonlocal calls
            calls += 1
            if not calls % every:
                progress(t)
            q, v = y[:nv], y[nv:]
            dy[:nv] = v
            dy[nv:] = self.accelerate(t, q, v) if loaded else aba(pin, data, q, v, tau)

        return derivative, lambda: calls

    def motion(self, y: Array) -> Motion:
        nv = self._pin_model.nv  # ABA leaves the poses of an earlier call (docs/pinocchio_notes.md, 6)
        pinocchio().forwardKinematics(self._pin_model, self._data, y[:nv], y[nv:])
        return motion_of(self._data, self._places)

    def evaluate(self, t: Array, q: Array, v: Array, torque: Array | None = None) -> Sample:
        """ABA for accelerations (n, nv), then RNEA for wrenches (n, joints, 6), state by state."""
        a, wrench, extra = np.empty(q.shape), np.empty((*q.shape, 6)), [None] * len(q) if torque is None else torque
        rnea, reactions = pinocchio().rnea, [self._data.f[joint].vector for joint in range(1, self._pin_model.njoints)]
        for i in range(len(q)):
            external = self._external(t[i], q[i], v[i])
            a[i] = self.accelerate(t[i], q[i], v[i], extra[i], external)
            # RNEA, though ABA has computed forces too: with external forces it leaves them out of data.f, and data.f[0] adds
            # up from call to call (docs/pinocchio_notes.md, 5).
            rnea(self._pin_model, self._data, q[i], v[i], a[i], *external)
            wrench[i] = reactions  # they follow the data
        return Sample(a, wrench)

    def compliance(self, q: Array, joints: Indices) -> Array:
        return mirror_upper(pinocchio().computeMinverse(self._pin_model, self._data, q))[:, joints]

    def accelerate(
        self, t: float, q: Array, v: Array, torque: Array | None = None, external: tuple[list, ...] | None = None
    ) -> Array:
        """q'' (nv,) in rad/s² by ABA, with torques (nv,) added; `external` is Pinocchio's last argument, if known."""
        if torque is None and not self._loaded:
            return self._aba(self._pin_model, self._data, q, v, self._no_torque)
        loads = self.loads
        if loads.varying:
            self._pin_model.gravity.linear = loads.field(t)
        tau = self._no_torque if loads.torque is None else loads.torque(t, q, v)
        tau = tau if torque is None else tau + torque
        external = self._external(t, q, v) if external is None else external
        return self._aba(self._pin_model, self._data, q, v, tau, *external)

    def _external(self, t: float, q: Array, v: Array) -> tuple[list, ...]:
        """Pinocchio's last argument, of body effects, if there are any."""
        if self.loads.wrench is None:
            return ()
        wrench = partial(self.loads.wrench, t)
        return (external_forces(self._pin_model, self._data, q, v, self._com, self._places, wrench),)

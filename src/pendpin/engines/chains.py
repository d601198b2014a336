"""Chains of rods by the hand-derived equations, O(n), on angles and in directions; few thin rods on spherical joints.

A thin rod has no axial inertia: without joint effects its joint acts as a spherical joint, its direction is its complete
state, and only the angles are singular at phi = ±pi/2. Short chains of them use Pinocchio's spherical joints, long ones the
hand-derived equations in directions. Angles are computed from the directions, continuously.
"""

from abc import abstractmethod
from collections.abc import Callable
from functools import cached_property, partial
from math import cos, prod
from typing import Any

import numpy as np

from pendpin.effects import Motion
from pendpin.engines.base import AngleEngine, Derivative, Engine, Loads, ProgressCallback, Sample, count_calls
from pendpin.engines.machine.routines import OFF
from pendpin.engines.pinocchio import Revolute, external_forces
from pendpin.equations.base import PHI, THETA, split_by_rod
from pendpin.equations.chain import solution, thin
from pendpin.equations.chain.kinematics import ChainInertia, Joints, motion, rods_last
from pendpin.ground.arrays import Array, Indices, across, applied, cross
from pendpin.model.bodies import append_body, pinocchio, with_gravity
from pendpin.model.build import FLIP, SIGNS, Model

BATCH = 1 << 13  # rods solved at once: what they need stays in the fast memory of a processor
TURN = 0.2  # rad, of a rod from state to state: the interpolated path between them is then accurate to 1e-5 of it
# Where the product of cos(phi) of at most MAX_SPHERICAL thin rods is above this, ABA agrees with the chain equations within
# 3e-12 (2,400 random states, lengths and masses up to 100 : 1; 3e-14 up to 3 : 1). For one rod it agrees within 2e-14 up to
# the pole itself.
REGULAR = 0.1
MAX_SPHERICAL = 10  # rods; in longer chains Pinocchio's spherical joints lose digits (docs/pinocchio_notes.md)


class LongChain(AngleEngine):
    """Every joint's reactions as the unknowns of one banded system; y = (q, v)."""

    name = "chain"

    def __init__(self, model: Model, loads: Loads) -> None:
        super().__init__(model, loads)
        assert model.chain is not None
        self._chain = model.chain

    def derivative(self, progress: ProgressCallback) -> tuple[Derivative, Callable[[], int]]:
        def derivative(dy: Array, t: float, y: Array) -> None:
            q, v = y.reshape(2, -1)
            dy[:] = np.concatenate([v, self.accelerate(t, q, v)])

        return count_calls(derivative, progress)

    def motion(self, y: Array) -> Motion:
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
        field = loads.fields(t) * SIGNS
        return solution.solve(self._chain, angles, rates, field, torque=torque, force=force, moment=moment)

    def _motion(self, q: Array, v: Array) -> Motion:
        """Poses and velocities in W of n rods with angles and rates q, v (..., n, 2)."""
        moving, start = motion(self._chain, q, v), np.zeros((*q.shape[:-2], 1, 3))
        tips = moving.tips, moving.tip_velocities
        origin, velocity = (np.concatenate([start, x[..., :-1, :]], -2) * SIGNS for x in tips)
        return Motion(origin, FLIP @ moving.frames @ FLIP, velocity, applied(moving.frames, moving.omega) * SIGNS)


class Thin(Engine):
    """The common part of the two engines for thin rods: angles from directions, and evaluation at given angles."""

    unit = 3  # numbers of each of the unit vectors with which a state begins, one for each rod

    def __init__(self, model: Model, loads: Loads) -> None:
        super().__init__(model, loads)
        assert model.chain is not None
        self.chain, self._at_angles = model.chain, LongChain(model, loads)

    @abstractmethod
    def directions(self, y: Array) -> tuple[Array, Array]:
        """Unit directions of the rods and their rates, (n, rods, 3) in I, from states y (n, size)."""

    def unpack(self, t: Array, y: Array, near: Array) -> tuple[Array, Array]:
        """Angles and rates (n, nv) read from directions, with states between where a rod passes near a pole."""
        if not len(y):
            return np.empty((0, len(near))), np.empty((0, len(near)))
        d, rate = self.directions(y)
        kept, reading = np.arange(len(y)), self._read(t, d, rate, near)
        for _ in range(thin.REFINEMENTS):
            if not (coarse := thin.unresolved(t, reading)).any():
                break
            t, d, rate, kept = thin.refined(t, d, rate, kept, coarse)
            reading = self._read(t, d, rate, near)
        return reading.q[kept].reshape(len(y), -1), reading.v[kept].reshape(len(y), -1)

    def _read(self, t: Array, d: Array, rate: Array, near: Array) -> thin.Reading:
        """The angles of directions d, d' (k, n, 3); d'' is computed only at a pole, where a rate is read from it."""
        near = split_by_rod(near)
        reading = thin.read(d, rate, None, near)
        if (pole := (reading.across < 2 * thin.POLE).any(1)).any():
            bend = np.zeros_like(d)
            bend[pole] = self.accelerate_directions(t[pole], d[pole], rate[pole])
            reading = thin.read(d, rate, bend, near)
        return reading

    def density(self, y: Array) -> float:
        """The states per second between which no rod turns more than TURN relative to the one above; y (n, size)."""
        speed = np.linalg.norm(self.directions(y)[1], axis=-1)
        speed[:, 1:] += speed[:, :-1].copy()
        return float(speed.max()) / TURN

    def accelerate_directions(self, t: Array, d: Array, rate: Array) -> Array:
        """d'' (n, rods, 3) in I, at times (n,)."""
        loads, force, moment = self.loads, None, None
        if loads.wrench is not None:
            force, moment = (x * SIGNS for x in loads.wrenches(t, _motion(self.chain, d, rate)))
        return thin.solve(self.chain, d, rate, loads.fields(t) * SIGNS, force=force, moment=moment).acceleration

    def normalise(self, y: Array) -> None:
        """Unit directions, or quaternions, in a state (size,), where they are off; else rounding would add up."""
        vectors = y[: self.unit * self.chain.n].reshape(-1, self.unit)
        squares = np.einsum("ij,ij->i", vectors, vectors)
        if np.abs(squares - 1.0).max() > OFF:
            vectors /= np.sqrt(squares)[:, None]

    def motion(self, y: Array) -> Motion:
        d, rate = self.directions(y[None])
        return _motion(self.chain, d[0], rate[0])

    def evaluate(self, t: Array, q: Array, v: Array, torque: Array | None = None) -> Sample:
        """Accelerations (n, nv) and wrenches by the chain equations, whose reactions are regular at the pole too."""
        return self._at_angles.evaluate(t, q, v, torque)

    def accelerate(self, t: float, q: Array, v: Array) -> Array:
        """q'' (nv,): by ABA, a hundred times faster, for one rod, and where few rods are away from their poles."""
        few = len(q) <= 2 * MAX_SPHERICAL
        if len(q) == 2 or (few and abs(prod(map(cos, q[PHI].tolist()))) > REGULAR):
            return self._by_aba.accelerate(t, q, v)
        return self._at_angles.accelerate(t, q, v)

    @cached_property
    def _by_aba(self) -> Revolute:
        return Revolute(self.model, self.loads)


def _motion(chain: ChainInertia, d: Array, rate: Array) -> Motion:
    """The motion of rods that do not spin, from d and d' (..., rods, 3) in I; each in a frame with z along -d."""
    steps, speeds = (np.cumsum(chain.l[:, None] * x, -2) - chain.l[:, None] * x for x in (d, rate))
    z = -d * SIGNS
    x = across(z)
    return Motion(steps * SIGNS, np.stack([x, cross(z, x), z], -1), speeds * SIGNS, cross(d, rate) * SIGNS)


class Directions(Thin):
    """The chain equations in directions: O(n); y = (d, omega) of every rod, in I, with omega normal to d."""

    # With omega in place of d' a run takes as many steps, and its energy drifts 100 to 1,000 times less.

    name = "chain, in directions"

    def pack(self, q: Array, v: Array) -> Array:
        """(d, omega), (6 n,): unit directions in I, and angular velocities normal to them."""
        return _joined(*thin.directions(split_by_rod(q), split_by_rod(v)))

    def directions(self, y: Array) -> tuple[Array, Array]:
        """The first halves of the states, made unit, and omega x d."""
        d, omega = np.ascontiguousarray(y.T).reshape(2, -1, 3, len(y))  # samples last, for speed
        d = d / np.sqrt(np.add.reduce(d * d, 1))[:, None]
        return d.transpose(2, 0, 1), cross(omega, d, axis=1).transpose(2, 0, 1)

    def project(self, y: Array) -> Array:
        return _joined(*(part[0] for part in self.directions(y[None])))

    def derivative(self, progress: ProgressCallback) -> tuple[Derivative, Callable[[], int]]:
        """d' = omega x d, omega' = d x d''."""
        half = 3 * self.chain.n

        def derivative(dy: Array, t: float, y: Array) -> None:
            d, omega = y[:half].reshape(-1, 3), y[half:].reshape(-1, 3)
            rate = cross(omega, d)
            dy[:half] = rate.reshape(-1)
            dy[half:] = cross(d, self.accelerate_directions(np.array([t]), d[None], rate[None])[0]).reshape(-1)

        return count_calls(derivative, progress)


def _joined(d: Array, rate: Array) -> Array:
    """The state (6 n,) from directions and their rates (n, 3)."""
    return np.concatenate([d.reshape(-1), cross(d, rate).reshape(-1)])


class Spherical(Thin):
    """Pinocchio's spherical joints; y = (quaternions x y z w, angular velocities relative to the rod above, own frame)."""

    # Each rod is given an axial inertia and no spin about its axis: the spin stays zero and that inertia never matters.

    name, unit = "pinocchio, spherical joints", 4

    @cached_property
    def _pin_model(self) -> Any:
        """The chain on spherical joints in the constant fields, made at its first use; compiled equations need none."""
        pin, chain = pinocchio(), self.chain
        model, joint, offset = with_gravity(pin.Model(), self.loads.constant), 0, np.zeros(3)
        for i in range(chain.n):
            joint = model.addJoint(joint, pin.JointModelSpherical(), pin.SE3(np.eye(3), offset), f"spherical_{i + 1}")
            axial = chain.I1[i] + chain.m[i] * chain.h[i] ** 2  # any value but zero
            central = np.diag([chain.I1[i], chain.I2[i], axial])
            append_body(model, joint, pin.Inertia(chain.m[i], np.array([0, 0, -chain.h[i]]), central))
            offset = np.array([0, 0, -chain.l[i]])
        return model

    def pack(self, q: Array, v: Array) -> Array:
        """Unit quaternions and angular velocities of the relative rotations, (7 n,)."""
        joints = Joints.at(split_by_rod(q))
        spinless = joints.omega(rods_last(split_by_rod(v))).T * SIGNS * [1, 1, 0]
        relative = FLIP @ joints.R.transpose(2, 0, 1) @ FLIP
        quaternions = [pinocchio().Quaternion(R).coeffs() for R in relative]
        return np.concatenate([*quaternions, _relative(relative, spinless).reshape(-1)])

    def directions(self, y: Array) -> tuple[Array, Array]:
        R, omega = _absolute(y, self.chain.n)
        d = -R[..., 2]
        rate = cross(np.einsum("knij,knj->kni", R, omega), d)
        return d * SIGNS, rate * SIGNS

    def project(self, y: Array) -> Array:
        n = self.chain.n
        _, omega = _absolute(y[None], n)
        quaternions = y[: 4 * n].reshape(n, 4)
        unit = quaternions / np.linalg.norm(quaternions, axis=-1, keepdims=True)
        return np.concatenate([unit.reshape(-1), _relative(_rotations(unit), omega[0] * [1, 1, 0]).reshape(-1)])

    def derivative(self, progress: ProgressCallback) -> tuple[Derivative, Callable[[], int]]:
        """Quaternion rates and angular accelerations by Pinocchio's ABA."""
        pin, n, loads = self._pin_model, self.chain.n, self.loads
        data, aba, tau, cut = pinocchio().Data(pin), pinocchio().aba, np.zeros(pin.nv), 4 * n
        joints, com = range(1, n + 1), self.model.body_arrays.com

        def derivative(dy: Array, t: float, y: Array) -> None:
            q, v = y[:cut], y[cut:]
            if loads.varying:
                pin.gravity.linear = loads.field(t)
            rates = (q.reshape(n, 4) @ _QUATERNION_RATE).reshape(n, 4, 3)
            np.matmul(rates, v.reshape(n, 3, 1), out=dy[:cut].reshape(n, 4, 1))
            if loads.wrench is None:
                dy[cut:] = aba(pin, data, q, v, tau)
                return
            forces = external_forces(pin, data, q, v, com, joints, partial(loads.wrench, t))
            dy[cut:] = aba(pin, data, q, v, tau, forces)

        return count_calls(derivative, progress)


# The tensor T of q' = T q omega / 2 for q = (x, y, z, w) and omega in the body's frame, as (4, 12) for q @ T
_ROWS = "0 0 0 0 0 -1 0 1 0 -1 0 0  0 0 1 0 0 0 -1 0 0 0 -1 0  0 -1 0 1 0 0 0 0 0 0 0 -1  1 0 0 0 1 0 0 0 1 0 0 0"
_QUATERNION_RATE = np.array(_ROWS.split(), float).reshape(4, 12) / 2.0


def _rotations(quaternions: Array) -> Array:
    """Rotation matrices (..., 3, 3) of unit quaternions (..., 4), x y z w; SciPy's module takes 0.25 s to import."""
    x, y, z, w = np.moveaxis(quaternions, -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))


def _absolute(y: Array, n: int) -> tuple[Array, Array]:
    """Rotations (k, n, 3, 3), link frames in W, and angular velocities (k, n, 3), own frames, from states y (k, 7 n)."""
    quaternions = y[:, : 4 * n].reshape(-1, n, 4)
    R = _rotations(quaternions / np.linalg.norm(quaternions, axis=-1, keepdims=True))
    omega = y[:, 4 * n :].reshape(-1, n, 3).copy()
    for i in range(1, n):
        omega[:, i] += np.einsum("kij,ki->kj", R[:, i], omega[:, i - 1])
        R[:, i] = R[:, i - 1] @ R[:, i]
    return R, omega


def _relative(R: Array, omega: Array) -> Array:
    """Angular velocities relative to the rod above (n, 3), own frames, from relative rotations and absolute ones."""
    out = omega.copy()
    out[1:] -= np.einsum("nij,ni->nj", R[1:], omega[:-1])
    return out

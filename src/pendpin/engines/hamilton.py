"""Pinocchio's model in Hamilton's form: positions and momenta, with the derivatives that an implicit method needs."""

from functools import cache, partial
from typing import NamedTuple

import numpy as np

from pendpin.engines.external_forces import centres_of, external_forces, joints_of
from pendpin.engines.loads import Loads
from pendpin.ground.arrays import Array, Mask
from pendpin.model.bodies import in_mass_unit, pinocchio, with_gravity
from pendpin.model.build import Model

DELTA = 1e-7  # rad, rad/s: of forward differences


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
            rest, bodies, wrench = self._rest, self.model.bodies, partial(loads.wrench, t)
            external = external_forces(self._bare, self._data, q, v, centres_of(bodies), joints_of(bodies), wrench)
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


def mirror_upper(matrix: Array) -> Array:
    """A symmetric matrix (n, n) of which Pinocchio fills only the upper triangle."""
    return np.where(_below_diagonal(len(matrix)), matrix.T, matrix)


@cache
def _below_diagonal(n: int) -> Mask:
    """Where a matrix (n, n) is below its diagonal; kept, as a stage of a Gauss method asks for it several times."""
    return np.tri(n, k=-1, dtype=bool)

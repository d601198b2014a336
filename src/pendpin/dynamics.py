"""A model with its effects bound once: accelerations, joint wrenches, energy; nothing is evaluated for the rest."""

from collections.abc import Callable
from typing import Any

import numpy as np

from pendpin import kinematics
from pendpin.derivations.base import Array
from pendpin.effects import Bodies, BodyEffect, Effect, FieldEffect, JointEffect, Motion
from pendpin.engines import MAX_SPHERICAL, Directions, Engine, Loads, LongChain, Revolute, Spherical
from pendpin.errors import InputError
from pendpin.model import Model, build
from pendpin.scene import Scene
from pendpin.trajectory import Reactions


class Dynamics:
    """The equations of motion of one scene. Use one in each thread. q, v are (nv,) in model order; rad, m for slides."""

    def __init__(self, model: Model, effects: tuple[Effect, ...], engine: str = "auto") -> None:
        self.model = model
        self.loads = bind_loads(model, effects)
        self.engine = choose_engine(model, self.loads, engine)

    def acceleration(self, t: float, q: Array, v: Array) -> Array:
        """q'' (nv,) at time t. Raises InputError for arrays of another shape."""
        return self.engine.evaluate(np.array([t]), *self._states(q, v)).acceleration[0]

    def wrenches(self, t: float, q: Array, v: Array) -> Array:
        """What each joint's parent exerts on its child, (joints, 6): force N, then moment N m, in the joint's frame."""
        return self.engine.evaluate(np.array([t]), *self._states(q, v)).wrench[0]

    def energy(self, q: Array, v: Array) -> tuple[float, float]:
        """Kinetic energy and the potential of the conservative effects, J; zero potential at W's origin."""
        q, v = self._states(q, v)
        potential = kinematics.field_potential(self.model, kinematics.poses(self.model, q), self.loads.constant)
        return float(kinematics.kinetic_energy(self.model, q, v)[0]), float(potential[0])

    def _states(self, *arrays: Any) -> tuple[Array, ...]:
        nv = len(self.model.joints)
        states = [np.asarray(array, float) for array in arrays]
        for name, state in zip("qv", states, strict=True):
            if state.shape != (nv,):
                raise InputError(f"{name} has shape {state.shape}; this model has {nv} joints")
        return tuple(state[None] for state in states)


def bind_loads(model: Model, effects: tuple[Effect, ...]) -> Loads:
    """What the effects add, seam by seam. Raises InputError for a joint or link that the model lacks."""
    fields = [effect for effect in effects if isinstance(effect, FieldEffect)]
    constant = sum((e.field(0.0) for e in fields if e.constant), np.zeros(3))
    varying = [e.field for e in fields if not e.constant]
    torques = [_torque(model, e, f"effects[{i}]") for i, e in enumerate(effects) if isinstance(e, JointEffect)]
    wrenches = [_wrench(bodies_of(model), e) for e in effects if isinstance(e, BodyEffect)]
    return Loads(constant, _total(varying), _total(torques), _total_wrench(wrenches))


def chosen_joints(model: Model, effect: JointEffect, where: str) -> Any:
    """The places of an effect's joints in model order: a slice for all, else an index array."""
    if effect.joints is None:
        return slice(None)
    return np.array([model.index(name, f"{where}.joints") for name in effect.joints], dtype=int)


def _torque(model: Model, effect: JointEffect, where: str) -> Callable[[float, Array, Array], Array]:
    chosen, nv = chosen_joints(model, effect, where), len(model.joints)
    if effect.joints is None:
        return effect.torque

    def torque(t: float, q: Array, v: Array) -> Array:
        tau = np.zeros(nv)
        np.add.at(tau, chosen, effect.torque(t, q[chosen], v[chosen]))
        return tau

    return torque


def bodies_of(model: Model) -> Bodies:
    """The bodies of a model as arrays, one row each."""
    rows = [(body.mass, body.com, body.inertia, body.tip, body.radius) for body in model.bodies]
    return Bodies(*(np.array(column) for column in zip(*rows, strict=True)))


def _wrench(bodies: Bodies, effect: BodyEffect) -> Callable[[float, Motion], tuple[Array, Array]]:
    return lambda t, motion: effect.wrench(t, bodies, motion)


def _total(functions: list[Any]) -> Any:
    """One function that adds the values of several; None for none."""
    if len(functions) < 2:
        return functions[0] if functions else None
    first, *others = functions
    return lambda *args: sum((function(*args) for function in others), first(*args))


def _total_wrench(functions: list[Any]) -> Any:
    if len(functions) < 2:
        return functions[0] if functions else None

    def total(t: float, motion: Motion) -> tuple[Array, Array]:
        forces, moments = zip(*(function(t, motion) for function in functions), strict=True)
        return sum(forces), sum(moments)

    return total


def choose_engine(model: Model, loads: Loads, name: str) -> Engine:
    """The engine for a model; `name` is "auto", "pinocchio" or "chain".

    Pinocchio on revolute joints serves every tree that its memory holds. A chain of thin rods without joint effects
    is carried in directions, regular everywhere; a chain too long for Pinocchio goes on the chain equations. Raises
    InputError where the named engine cannot carry the model.
    """
    if name == "chain" and model.chain is None:
        raise InputError('solver.engine: "chain" needs a model of kind "chain"')
    if name == "pinocchio" and model.pin is None:
        raise InputError(f"solver.engine: {len(model.joints)} joints are too many for Pinocchio's memory; use \"chain\"")
    balls = model.chain is not None and model.chain.first_thin == 0 and loads.torque is None
    if balls and name != "chain" and len(model.rods) <= MAX_SPHERICAL:
        return Spherical(model, loads)
    if balls and name != "pinocchio":
        return Directions(model, loads)
    return LongChain(model, loads) if name == "chain" or model.pin is None else Revolute(model, loads)


def bind(scene: Scene) -> Dynamics:
    """The dynamics of a scene. Raises InputError for a model that cannot be simulated."""
    return Dynamics(build(scene.model), scene.effects, scene.solver.engine)


def reactions(model: Model, q: Array, wrench: Array, xp: Any = np) -> Reactions | None:
    """R1, R2, R3, M3, Mc (n, rods) from q (n, nv) and wrenches (n, joints, 6); None without universal joints."""
    if not model.rods:
        return None
    phi = [rod.phi for rod in model.rods]
    frames = np.array([rod.frame for rod in model.rods])
    R1, R2, minus_R3 = np.einsum("nri,rij->jnr", wrench[:, phi, :3], frames)
    M1, _, M3 = np.einsum("nri,rij->jnr", wrench[:, phi, 3:], frames)
    s, c = xp.sin(q[:, phi]), xp.cos(q[:, phi])
    Mc = c * M3 - s * M1  # along a3
    return Reactions(R1, R2, -minus_R3, Mc * c, Mc)

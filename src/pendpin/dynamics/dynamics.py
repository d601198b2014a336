"""A model with its effects bound once: accelerations, joint wrenches, energy, efforts; nothing is evaluated for the rest."""

import math
from collections.abc import Callable, Hashable
from copy import copy
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal

import numpy as np

from pendpin.dynamics.acting import HeldTorque, acting, recall_outputs
from pendpin.dynamics.binding import Accounts, Binding, BoundField, BoundTorque
from pendpin.dynamics.compiling import EquationsOfMotion, compile_engine, drop_zeros
from pendpin.dynamics.contacts import Contacts, bind_contacts
from pendpin.dynamics.samples import Sampler, compile_sampler
from pendpin.effects import ContactEffect, Effect
from pendpin.engines import MAX_SPHERICAL, AngleEngine, Directions, Engine, Loads, LongChain, Revolute, Spherical
from pendpin.engines.pinocchio import forces, joints_of, turn_into_joint_frames
from pendpin.errors import InputError, amount, shown
from pendpin.ground.arguments import numbers
from pendpin.ground.arrays import Array
from pendpin.model import kinematics
from pendpin.model.bodies import pinocchio, with_gravity
from pendpin.model.build import Model, build
from pendpin.model.notes import homes
from pendpin.scene import METHODS, Scene, chosen_scene, scene_of
from pendpin.scene.methods import Form
from pendpin.trajectory import HingeReactions, Reactions, RunRecord

CONTACTS = "contacts"  # dry friction and stops together


class Dynamics:
    """The equations of motion of one scene. Use one in each thread. q, v are (nv,) in model order; rad, m for slides.

    Its engine and loads count the time from `start` in s.
    """

    def __init__(
        self, model: Model, effects: tuple[Effect, ...], engine: str = "auto", form: Form = "any", start: float = 0.0
    ) -> None:
        if moved := homes(model.written or (), effects):  # inside the limits that act as written
            model = replace(model, home=np.array([moved.get(joint, 0.0) for joint in model.joints]))
        self.model, self.start, self.effects = model, start, acting(model, effects, start)
        effects = self.effects
        self.sampled_torques = tuple(effect for effect in effects if isinstance(effect, HeldTorque))
        self.binding = Binding(model, effects, start)
        self.loads = self.binding.loads
        touching = any(isinstance(effect, ContactEffect) for effect in effects)
        form = "angles" if touching else form
        self._base = choose_engine(model, self.loads, "auto" if engine == "compiled" else engine, form)
        self.contacts: Contacts | None = None
        if touching and isinstance(self._base, AngleEngine):
            self.contacts = bind_contacts(model, effects, self._base)
        self.engine: Engine = self.compiled() if engine == "compiled" else self._base
        self.potentials = [bound and bound.potential() for bound in self.binding.acts]
        self.conservative = all(potential is not None for potential in self.potentials)
        self._engines = dict[Hashable, Engine]()  # others of this model; not Dynamics, which would be a reference cycle
        self.sampled_effects = dict[tuple[int, float], tuple[Array, Array, Array]]()  # by place and duration: pace.py
        self.sampler: Sampler | None = None  # of samples in machine code, where these are used
        if model.make_pin is not None:
            # not `self`: a reference cycle would keep Pinocchio's data until the garbage collector runs
            uniform = self.loads.constant
            self.model = replace(model, make_pin=lambda: with_gravity(model.pin, uniform))

    def __repr__(self) -> str:
        return f"Dynamics of {amount(len(self.model.joints), 'joint')} on {self.engine.name}"

    def compiled(self, accounts: Accounts | None = None) -> Engine:
        """The equations in machine code, for thin rods in directions; with `accounts`, their work is in the state too."""
        engine = self._in_directions
        return compile_engine(EquationsOfMotion(engine, self.effects, self.start, accounts, self.contacts))

    @property
    def in_machine_code(self) -> "Dynamics":
        """The same dynamics on compiled equations; Pinocchio's data, which are large, are shared."""
        return self if self.engine.compiles else self._on("compiled", self.compiled)

    def _on(self, key: Hashable, make: Callable[[], Engine]) -> "Dynamics":
        """The same on another engine, which is made once."""
        if key not in self._engines:
            self._engines[key] = make()
        if self._engines[key] is self.engine:
            return self
        changed = copy(self)
        changed.engine = self._engines[key]
        return changed

    def in_motion(self, q: Array, v: Array, compiled: bool) -> "Dynamics":
        """The same for motions from q, v (nv,), `compiled` or not: what stays 0, as phi in a plane, is not integrated."""

        def make() -> Engine:
            base = self._in_directions if compiled else self.engine
            equations = EquationsOfMotion(base, self.effects, self.start)
            moving = base if self.contacts else drop_zeros(equations, q, v)
            if moving is base:
                return self.in_machine_code.engine if compiled else self.engine
            return compile_engine(equations._replace(engine=moving)) if compiled else moving

        return self._on(((q == 0).tobytes(), (v == 0).tobytes(), compiled), make)

    @property
    def _in_directions(self) -> Engine:
        """The engine whose equations are compiled: for thin rods the one in directions."""
        return Directions(self.model, self.loads) if isinstance(self._base, Spherical) else self._base

    def use_compiled_samples(self) -> None:
        """Compute samples in machine code where that is possible: those of rods with pendpin's own effects."""
        self.sampler = compile_sampler(self._base, self.effects, self.start)

    def sample(self, t: Array, q: Array, v: Array, torque: Array | None = None) -> tuple[Array, ...]:
        """Accelerations, wrenches, poses and kinetic energy at t (n,) since the start, of states q, v (n, nv).

        In machine code where it serves; where that finds no finite number, the engine's own equations say why.
        """
        parts = None if self.sampler is None else self.sampler(t, q, v, torque)
        return parts or (*self.engine.evaluate(t, q, v, torque), *kinematics.poses_and_energy(self.model, q, v))

    def acceleration(self, t: float, q: Array, v: Array) -> Array:
        """q'' (nv,) at time t. Raises InputError for arrays of another shape, and not finite."""
        return self.engine.accelerate(self._time(t), *self._checked_state(q, v))

    def wrenches(self, t: float, q: Array, v: Array) -> Array:
        """The wrench of each joint's parent on its child, (joints, 6): force N, then moment N m, in the joint's frame."""
        time, (q, v) = np.array([self._time(t)]), self._checked_state(q, v)
        return self.engine.evaluate(time, q[None], v[None]).wrench[0]

    def energy(self, q: Array, v: Array) -> tuple[float, float]:
        """Kinetic energy and the potential of the conservative effects, J, at q, v (nv,); 0 at W's origin."""
        q, v = self._checked_state(q, v)
        kinetic, potential = self.energies(q[None], v[None])
        return float(kinetic[0]), float(potential[0])

    def energies(self, q: Array, v: Array) -> tuple[Array, Array]:
        """Kinetic energy and the potential of the conservative effects, (n,) in J, at states q, v (n, nv)."""
        poses, kinetic = kinematics.poses_and_energy(self.model, q, v)
        return kinetic, self.potentials_at(q, poses).sum(1)

    def potentials_at(self, q: Array, poses: Array) -> Array:
        """The potential of each effect (n, effects) in J, 0 of one without, from q (n, nv) and the bodies' poses."""
        out = np.zeros((len(q), len(self.potentials)))
        for place, potential in enumerate(self.potentials):
            if potential is not None:
                out[:, place] = potential(q, poses)
        return out

    def _time(self, t: Any) -> float:
        """A time as the engine counts it. Raises InputError."""
        time = t if type(t) is float else numbers("t", t)[()]
        if getattr(time, "shape", ()) or not math.isfinite(time):
            raise InputError(f"t: {shown(t)} is not a finite number of seconds")
        return float(time) - self.start

    def _checked_state(self, q: Any, v: Any) -> tuple[Array, Array]:
        """Two arrays of floats (nv,). Raises InputError for another shape and what is not finite."""
        q, v, nv = numbers("q", q), numbers("v", v), len(self.model.joints)
        for name, state in (("q", q), ("v", v)):
            if state.shape != (nv,):
                raise InputError(f"{name} has shape {state.shape}; this model has {nv} joints")
            if not all(map(math.isfinite, state.tolist())):  # of two numbers a tenth of the time of NumPy's isfinite
                raise InputError(f"{name}: {shown(state.tolist())} are not finite numbers")
        return q, v


def choose_engine(model: Model, loads: Loads, name: str, form: Form = "any") -> Engine:
    """The engine for a model; `name` is "auto", "pinocchio" or "chain".

    Pinocchio on revolute joints computes every tree that its memory holds. A chain of thin rods without torques about its
    joints or about the rods is computed in directions, regular everywhere; a chain too long for Pinocchio with the chain
    equations. `form` limits the state: "angles" keeps thin rods on angles, "directions" does not use quaternions. Raises
    InputError if the named engine cannot compute the model.
    """
    if name == "chain" and model.chain is None:
        raise InputError('solver.engine: "chain" needs rods in a row on universal joints; leave it out')
    if name == "pinocchio" and model.make_pin is None:
        raise InputError(f'solver.engine: {len(model.joints)} joints are too many for Pinocchio\'s memory; use "chain"')
    thin = model.chain is not None and model.chain.first_thin == 0
    spherical = thin and loads.torque is None and not loads.axial and form != "angles"
    if spherical and form != "directions" and name != "chain" and len(model.rods) <= MAX_SPHERICAL:
        return Spherical(model, loads)
    if spherical and (form == "directions" or name != "pinocchio"):
        return Directions(model, loads)
    return LongChain(model, loads) if name == "chain" or model.make_pin is None else Revolute(model, loads)


def without_compiling(engine: Engine) -> Literal["pinocchio", "chain"]:
    """The name in a scene's solver of an engine that is not compiled."""
    return "chain" if isinstance(engine, LongChain | Directions) else "pinocchio"


def bind(scene: Scene | str | Path) -> Dynamics:
    """Build the dynamics of a scene once, for accelerations, wrenches and energies at any state.

    Args:
        scene: a Scene, or the path of a TOML file.

    Returns:
        The Dynamics: .acceleration(t, q, v), .wrenches(t, q, v), .energy(q, v), with q, v (nv,) in model order.

    Raises:
        InputError: for a model that cannot be simulated.
    """
    scene = chosen_scene(scene)
    method = scene.solver.method
    form = METHODS[method].state if method in METHODS else "any"
    return Dynamics(build(scene.model), scene.effects, scene.solver.engine, form, scene.start.time)


def loads_at(dynamics: Dynamics, q: Array, v: Array) -> tuple[Array | None, Array | None]:
    """What the effects exert at each state: torques (n, nv), and wrenches (n, joints, 6) at the joints, in their frames."""
    loads, tau, external = dynamics.loads, None, None
    if loads.torque is not None:
        tau = np.array([loads.torque(0.0, *state) for state in zip(q, v, strict=True)])
    if loads.wrench is not None:
        bodies, engine = dynamics.model.bodies, Revolute(dynamics.model, loads)
        com, joints = dynamics.model.body_arrays.com, [body.joint for body in bodies]
        external = np.zeros((*q.shape, 6))
        for i, state in enumerate(np.concatenate([q, v], -1)):
            motion = engine.motion(state)
            external[i, joints] = turn_into_joint_frames(com, motion, *loads.wrench(0.0, motion))
    return tau, external


def reactions(model: Model, q: Array, wrench: Array, xp: Any = np) -> Reactions | HingeReactions | None:
    """The reactions (n, rods) from q (n, nv) and wrenches (n, joints, 6); None where no rod has a joint of its own."""
    if not model.rods:
        return None
    last = [rod.last for rod in model.rods]
    frames = np.array([rod.frame for rod in model.rods]).transpose(1, 2, 0)[:, :, None]  # (3, 3, 1, rods)
    rows = np.ascontiguousarray(np.moveaxis(wrench, -1, 0)[..., last])  # (6, n, rods)
    (R1, R2, minus_R3), (M1, M2, M3) = (np.add.reduce(frames * part[:, None], 0) for part in (rows[:3], rows[3:]))
    s, c = xp.sin(q[:, last]), xp.cos(q[:, last])  # of phi, on a universal joint
    Mc = c * M3 - s * M1  # along a3
    kinds = np.array([rod.kind for rod in model.rods])
    if (kinds == "universal").all():
        return Reactions(R1, R2, -minus_R3, Mc * c, Mc)
    Mc, none = np.where(kinds == "universal", Mc, 0.0), np.zeros_like(Mc)
    M1 = np.select([kinds == "universal", kinds == "y"], [-Mc * s, M1], none)
    M3 = np.where(kinds == "universal", Mc * c, M3)
    return HingeReactions(R1, R2, -minus_R3, M1, np.where(kinds == "x", M2, none), M3, Mc)


# --- what acts on each joint of a run, effect by effect ---------------------------------------------------------------


def efforts(run: RunRecord) -> dict[str, Array]:
    """The generalised force of each kind of effect on each joint at the samples, (n, nv) in N m, N for slides.

    For a field and for wrenches on bodies it is J^T F (d'Alembert's principle), for a joint effect its torques. Dry friction
    and stops are "contacts": what the motion needs beyond all others. The sum of all is the inverse dynamics of the motion.
    Raises InputError where the run's scene cannot be built again, and for a chain too long
    for Pinocchio.
    """
    dynamics = bind(scene_of(run))
    recall_outputs(dynamics.sampled_torques, run, float(run.t[-1]) - dynamics.start, dynamics.start)
    if dynamics.model.pin is None:
        raise InputError(f"efforts: {len(run.joints)} joints are too many for Pinocchio's memory")
    pin, model = pinocchio(), dynamics.model.pin.copy()
    model.gravity = pin.Motion.Zero()
    engine, binding, bodies = Revolute(dynamics.model, dynamics.loads), dynamics.binding, dynamics.model.bodies
    data, heavy, still = model.createData(), model.copy(), np.zeros(model.nv)

    acts: list[Any] = [bound for bound in binding.acts if bound]
    out = {bound.effect.kind: np.zeros_like(run.q) for bound in acts}
    rest = np.zeros_like(run.q)
    for i, (t, q, v, a) in enumerate(zip((run.t - dynamics.start).tolist(), run.q, run.v, run.a, strict=True)):
        motion = engine.motion(np.concatenate([q, v]))
        for bound in acts:
            if isinstance(bound, BoundTorque):
                effort = bound.at(t, q, v)
            elif isinstance(bound, BoundField):
                heavy.gravity.linear = np.asarray(bound.at(t), float)
                effort = -pin.computeGeneralizedGravity(heavy, data, q)
            else:
                wrenches = turn_into_joint_frames(binding.bodies.com, motion, *bound.at(t, binding.complete(t, motion)))
                effort = -pin.rnea(model, data, q, still, still, forces(wrenches, joints_of(bodies), model.njoints))
            out[bound.effect.kind][i] += effort
        rest[i] = pin.rnea(model, data, q, v, a) - sum(one[i] for one in out.values())
    return out | ({CONTACTS: rest} if dynamics.contacts is not None else {})

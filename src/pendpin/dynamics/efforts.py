"""What acts on each joint of a run, effect by effect, and in words what a scene's dynamics evaluate."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from pendpin.dynamics.acting import recall_outputs
from pendpin.dynamics.binding import BoundField, BoundTorque
from pendpin.dynamics.dynamics import Dynamics, bind
from pendpin.effects import BodyEffect, ContactEffect, Effect, FieldEffect, Idle, JointEffect, Motion
from pendpin.engines import Revolute
from pendpin.engines.pinocchio import forces, joints_of, turn_into_joint_frames
from pendpin.errors import InputError
from pendpin.ground.arrays import Array
from pendpin.model.bodies import pinocchio
from pendpin.scene import scene_of
from pendpin.trajectory import RunRecord, Stats

CONTACTS = "contacts"  # dry friction and stops together
Effort = Callable[[float, Array, Array, Motion], Array]  # t since the start, q, v (nv,), motion -> (nv,)


def efforts(run: RunRecord) -> dict[str, Array]:
    """The generalised force of each kind of effect on each joint at the samples, (n, nv) in N m, N for slides.

    Of a field and of a wrench on a body by d'Alembert's principle, J^T F; of a joint effect its torques. What dry friction
    and stops exert is what the motion needs and nothing else gives: together they are "contacts". The sum of all is the
    inverse dynamics of the motion. Raises InputError where the run's scene cannot be built again, and for a chain too long
    for Pinocchio.
    """
    dynamics = bind(scene_of(run))
    recall_outputs(dynamics.sampled_torques, run, float(run.t[-1]) - dynamics.start, dynamics.start)
    if dynamics.model.pin is None:
        raise InputError(f"efforts: {len(run.joints)} joints are too many for Pinocchio's memory")
    pin, model = pinocchio(), dynamics.model.pin.copy()
    model.gravity = pin.Motion.Zero()
    data, engine, start = model.createData(), Revolute(dynamics.model, dynamics.loads), dynamics.start
    acts = [(bound.effect.kind, _effort(dynamics, bound, model)) for bound in dynamics.binding.acts if bound]
    kinds = dict.fromkeys(kind for kind, _ in acts)
    out = {kind: np.zeros_like(run.q) for kind in kinds}
    rest = np.zeros_like(run.q)
    for i, (t, q, v, a) in enumerate(zip(run.t - start, run.q, run.v, run.a, strict=True)):
        motion = engine.motion(np.concatenate([q, v]))
        for kind, effort in acts:
            out[kind][i] += effort(float(t), q, v, motion)
        rest[i] = pin.rnea(model, data, q, v, a) - sum(out[kind][i] for kind in kinds)
    return out | ({CONTACTS: rest} if dynamics.contacts is not None else {})


def _effort(dynamics: Dynamics, bound: Any, model: Any) -> Effort:
    """The generalised force of one effect. `model` is a pin.Model without gravity."""
    pin, model = pinocchio(), model.copy()
    data, complete, coms = model.createData(), dynamics.binding.complete, dynamics.binding.bodies.com

    def under_field(t: float, q: Array, v: Array, motion: Motion) -> Array:
        model.gravity.linear = np.asarray(bound.at(t), float)
        return -pin.computeGeneralizedGravity(model, data, q)

    def under_wrench(t: float, q: Array, v: Array, motion: Motion) -> Array:
        wrenches = turn_into_joint_frames(coms, motion, *bound.at(t, complete(t, motion)))
        external = forces(wrenches, joints_of(dynamics.model.bodies), model.njoints)
        still = np.zeros(len(q))
        return -pin.rnea(model, data, q, still, still, external)

    if isinstance(bound, BoundTorque):
        return lambda t, q, v, motion: bound.at(t, q, v)
    return under_field if isinstance(bound, BoundField) else under_wrench


# --- what acts in a scene: which engine, which interfaces of effects, and what one evaluation calls -----------------


def explain(dynamics: Dynamics, stats: Stats) -> tuple[str, ...]:
    """Lines of text for a person, in the order in which an evaluation goes; `stats` of the run, which chose its engine."""
    model, loads, effects = dynamics.model, dynamics.loads, dynamics.effects

    def names(of: Sequence[str]) -> str:
        more = f", ... ({len(of)} in all)" if len(of) > 6 else ""
        return ", ".join(of[:6]) + more if of else "none"

    def interface(title: str, chosen: list[Effect]) -> list[str]:
        return [f"{title}: {names([effect.kind for effect in chosen])}"] if chosen else []

    fields = [e for e in effects if isinstance(e, FieldEffect)]
    constant = names([e.kind for e in fields if e.constant])
    calls = {
        "the fields that vary with time": loads.varying is not None,
        "the joint torques": loads.torque is not None,
        "the kinematics of the bodies and the wrenches on them": loads.wrench is not None,
        "one solve for the accelerations": True,
        "another one for the torques that hold joints, if any are held": dynamics.contacts is not None,
    }
    one = stats.method == "taylor" or "compiled" in stats.engine
    called = "one compiled function of all this" if one else ", ".join(call for call, made in calls.items() if made)
    return (
        f"{len(model.joints)} joints, {len(model.bodies)} bodies; method: {stats.method}; engine: {stats.engine}",
        f"constant fields: {constant}, summed once: {np.array2string(loads.constant, precision=6)} m/s²",
        *interface("fields that vary with time", [e for e in fields if not e.constant]),
        *(f"joint torques: {e.kind} on {names(e.on or model.joints)}" for e in effects if isinstance(e, JointEffect)),
        *interface(
            "body wrenches, from the poses and velocities of all bodies",
            [e for e in effects if isinstance(e, BodyEffect)],
        ),
        *(f"events: {e.kind} on {names(e.joints or model.joints)}" for e in effects if isinstance(e, ContactEffect)),
        *interface("of strength 0, left out", [e for e in effects if isinstance(e, Idle)]),
        f"an evaluation calls: {called}",
    )

"""What each effect exerts on each joint: generalised forces at the samples of a run."""

from collections.abc import Callable
from typing import Any

import numpy as np

from pendpin.dynamics.binding.bound import BoundField, BoundTorque
from pendpin.dynamics.dynamics import Dynamics, bind
from pendpin.dynamics.held_torques import recall_outputs
from pendpin.effects import Motion
from pendpin.engines import Revolute
from pendpin.engines.pinocchio import forces, joints_of, turn_into_joint_frames
from pendpin.errors import InputError
from pendpin.ground.arrays import Array
from pendpin.model.bodies import pinocchio
from pendpin.scene import scene_of
from pendpin.trajectory import RunRecord

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
    if isinstance(bound, BoundTorque):
        return lambda t, q, v, motion: bound.at(t, q, v)
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

    return under_field if isinstance(bound, BoundField) else under_wrench

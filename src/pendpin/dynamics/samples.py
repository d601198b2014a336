"""What is computed at the samples of a run, as machine code: accelerations, wrenches, poses and the kinetic energy."""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np

from pendpin.dynamics import compiling
from pendpin.dynamics.binding import Binding
from pendpin.dynamics.compiling import BoundTree
from pendpin.dynamics.parameters import Parameters
from pendpin.effects import Effect
from pendpin.engines import Engine
from pendpin.engines.chains import Thin
from pendpin.engines.machine.tape import Recording, Tape
from pendpin.equations import recursion
from pendpin.equations.trees import joints_at, outward, place_joints, total
from pendpin.ground.arrays import Array, applied, cross, dot

PARTS = 3  # of what is given: positions, rates, further torques
MOST_SAMPLED = 20  # joints of a tree that is not a loop over rods, up to which its samples are compiled
_DOWN = np.array([0.0, 0.0, -1.0])  # along a rod, in its link frame


# At t (n,), q, v (n, nv), with further torques (n, nv) or None: accelerations (n, nv), wrenches (n, joints, 6) N, N m by
# each joint's parent, in its frame, poses (n, rods, 4, 4) in W, kinetic energy (n,) in J; None where a number is not finite
Sampler = Callable[..., tuple[Array, ...] | None]
# of t, q, v and further torques (w,) of a rod, or of all, as terms: their numbers, and the kinetic energy of all rods
Sampled = Callable[[Any, Array, Array, Array], tuple[Array, Any]]
# of the same and the external wrenches (w, 6): accelerations (w,) and wrenches (w, 6)
Equations = Callable[[Any, Array, Array, Array, Array | None], tuple[Array, Array]]


def compile_sampler(engine: Engine, effects: Sequence[Effect], start: float) -> Sampler | None:
    """The samples of rods with pendpin's own effects in machine code, at times since `start` in s; None of others."""
    model = engine.model
    few = model.alike or (model.rod_tree is not None and len(model.joints) <= MOST_SAMPLED)
    by_rod = model.alike and len(model.rods) > 1
    if not (few and compiling.compilable(model, effects)):
        return None
    effects, given = compiling.split_functions(model, effects, start)
    # Compiled apart from the equations of motion, which costs 15 to 20 ms in a first run: one function for both would change
    # the last digit of the accelerations at the samples (docs/accuracy.md).

    def recording(tape: Tape, numbers: Parameters, sampled: tuple[Any, Any]) -> Recording:
        """What is computed at a sample, recorded for one rod where they are alike; that of a single rod is written out."""
        rows, kinetic = sampled
        if by_rod:
            return Recording(tape, [], [kinetic], parts=PARTS, width=numbers.width, more_of_rod=list(rows))
        return Recording(tape, [], [*rows, kinetic], width=PARTS * len(model.joints))

    write = partial(_sampled, engine, effects, start)
    block, parameters = compiling.record_twice("samples", model, by_rod, write, recording, PARTS)
    parts, joints = parameters.rods, parameters.width

    def sample(t: Array, q: Array, v: Array, torque: Array | None = None) -> tuple[Array, ...] | None:
        torque = np.zeros_like(q) if torque is None else torque
        if given is not None:
            torque = torque + np.array([given(*state) for state in zip(t.tolist(), q, v, strict=True)])
        _, more = block.evaluated(t, np.concatenate([q, v, torque], 1))
        if not np.isfinite(more).all():
            return None
        rows = more[:, :-1].reshape(len(t), parts, -1)
        a, wrench = rows[..., :joints].reshape(len(t), -1), rows[..., joints : 7 * joints].reshape(len(t), -1, 6)
        placed = rows[..., 7 * joints :].reshape(len(t), -1, 3, 4)
        poses = np.zeros((*placed.shape[:2], 4, 4))
        poses[..., :3, :], poses[..., 3, 3] = placed, 1.0
        return a, wrench, poses, more[:, -1].copy()

    return sample


def _sampled(engine: Engine, effects: Sequence[Effect], start: float, numbers: Parameters) -> Sampled:
    thin, xp, binding = isinstance(engine, Thin), numbers.xp, Binding(engine.model, effects, start, numbers)
    numbers.constant((thin, numbers.by_rod))
    bound = BoundTree(binding)
    loads, bodies, tree = binding.loads, binding.bodies, bound.tree

    def on_angles(t: Any, q: Array, v: Array, more: Array, wrenches: Array | None) -> tuple[Array, Array]:
        """By the articulated bodies and Newton-Euler."""
        tau = more if loads.torque is None else more + loads.torque(t, q, v)
        field = loads.field(t)
        a = recursion.accelerations(tree, q, v, field, tau, wrenches, xp)
        return a, recursion.wrenches(tree, q, v, a, field, wrenches, xp)

    equations = _equations_of_directions(bound, compiling.thin_rods(engine.model, numbers)) if thin else on_angles

    def sampled(t: Any, q: Array, v: Array, more: Array) -> tuple[Array, Any]:
        links = bound.motion(q, v)
        a, wrench = equations(t, q, v, more, bound.external(t, q, v))
        poses = [np.concatenate([R, r[:, None]], 1) for R, r in place_joints(tree, q, xp)]
        frames = np.stack(poses)[bound.joints]
        moving = bodies.mass[:, None] * links.velocities(bodies.com) ** 2
        kinetic = total(moving + links.spin * applied(bodies.inertia, links.spin), xp) / 2  # J
        return np.concatenate([a, wrench.reshape(-1), frames.reshape(-1)]), kinetic

    return sampled


def _equations_of_directions(bound: BoundTree, chain: recursion.ThinRods) -> Equations:
    """Accelerations and wrenches of a thin rod, whose joint carries no moment, by the recursion in directions, in W here."""
    tree, xp = bound.tree, bound.xp

    def equations(t: Any, q: Array, v: Array, more: Array, external: Array | None) -> tuple[Array, Array]:
        _, signs, joints = joints_at(tree, q, xp)
        rates, force, moment = signs * v, None, None

        def turn(i: int, above: tuple[Array, Array]) -> tuple[tuple[Array, Array], tuple[Array, Array, Array]]:
            """How the frame of a joint turns: to W, its spin in itself, and what the rates add to its acceleration."""
            joint, (R, spin) = joints[i], above
            R, arriving = R @ joint.R, applied(joint.R.mT, spin)
            own = joint.axis * rates[i]
            return (R, arriving + own), (R, arriving + own, cross(arriving, own))

        turning = outward(turn, (np.eye(3), np.zeros(3)), tree.parents, xp)
        R, spin, _ = turning[1]
        if external is not None:
            f, about_joint = np.split(external[1], 2)
            force, moment = applied(R, f)[None], applied(R, about_joint - cross(chain.h[0] * _DOWN, f))[None]
        state = applied(R, _DOWN)[None], applied(R, cross(spin, _DOWN))[None]
        turned, reaction = recursion.thin_turning(chain, *state, bound.loads.field(t), force, moment, xp)
        across, reaction = (applied(R.mT, x[0]) for x in (turned, reaction))
        across = across - dot(spin, _DOWN) * cross(_DOWN, spin)  # of the frame, which spins with its angles
        forces = np.stack([applied(joints[1].R, reaction), reaction])
        of_theta = applied(joints[1].R.mT, joints[0].axis)

        def swing(i: int, alpha: Array) -> tuple[Array, Array]:
            """theta'' and phi'' (2,) from what turns the rod across its axis; along it the joint decides."""
            for joint, (_, _, coriolis) in zip(joints, turning, strict=True):
                alpha = applied(joint.R.mT, alpha) + coriolis
            theta, phi = (across - alpha)[0] / of_theta[0], (across - alpha)[1]
            return alpha + of_theta * theta + joints[1].axis * phi, np.array([theta, phi])

        a = signs * outward(swing, np.zeros(3), [-1], xp)[0]
        return a, np.concatenate([forces, np.zeros((2, 3))], -1)

    return equations

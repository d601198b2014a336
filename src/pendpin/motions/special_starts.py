"""Starts of two particular motions: rest in equilibrium, and a steady cone."""

from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Self

import numpy as np

from pendpin.dynamics.dynamics import Dynamics, bind
from pendpin.effects import Anchor
from pendpin.equations import exact
from pendpin.errors import InputError, MissingLibrary, say_note
from pendpin.ground.arguments import number
from pendpin.ground.arrays import TINY, Array
from pendpin.model.build import SIGNS, Model, start_state
from pendpin.scene import Chain, Scene, chosen_scene
from pendpin.scene import Start as StartRecord

Pull = Callable[[Array], Array]  # of q (nv,): the accelerations (nv,), or their derivatives (nv, nv)
REST = 1e-10  # of the largest acceleration seen: what is left at an equilibrium
UNSTABLE = 1e-9  # of the largest rate: what grows faster leaves a rest
ASIDE, AGAIN = 0.01, 3  # rad, how far an unstable rest is left, and how often
FAR = 100.0  # rad or m: what moves as far as this and has no equilibrium there never comes to rest
LOST = 1e9  # m: a slide is not followed farther
SMALL = 1e-8  # rad or m, of differences in place of derivatives
MOST = 1_500  # steps on the way to a rest: most scenes take some tens, a chain on a stiff anchor up to 1,400
SOFTER = tuple(10.0**k for k in range(-6, 1))  # of the stiffness of anchors that throw a rope about: they draw it first
TURN, OFF, NEGLIGIBLE = 0.3, 0.3, 1e-6  # rad or m that a step moves, the share it may be off, and what is no matter
MOST_GROWTH = 99.0  # e to this is the factor by which a step may grow: its square is still a number
LONG = 1e6  # s² of pseudo-time, until the slowest mode has decayed
NODDING = 0.01  # of the angle of a cone
UPRIGHT = 1e-12  # of a field: what it may have across the vertical


def _no_rest_error(model: Model, moved: Array) -> InputError:
    """The error that names the slide that moved (nv,) without end, if one did."""
    ways = np.where(model.slides, np.abs(moved), 0.0)
    if ways.max(initial=0.0) > FAR:
        name = model.joints[int(np.argmax(ways > ways.max() / 2))]  # the first of those that move alike
        return InputError(f"there is no equilibrium: {name} slides away; lock it or give it a spring")
    remedy = "give other positions, or remove effects that never come to rest"
    return InputError(f"start: there is no equilibrium near start.positions; {remedy}")


def _relax(scene: Scene, q: Array) -> Array:
    """The stable rest to which q (nv,) comes if its speed is its acceleration. InputError for what falls without end."""
    # By steps of the exponential Euler method, exact where accelerations are linear: what is stiff decays and what is
    # unstable grows, however long they are. A rest that is unstable is left along what grows first.

    def flow(a: Array) -> Array:  # what an acceleration moves in a step
        grown = np.expm1(np.minimum(step * np.real(values), MOST_GROWTH) + 1j * step * np.imag(values))
        share = np.divide(grown, values, out=np.full_like(grown, step), where=values != 0)
        return np.real(vectors @ (share * (inverse @ a)))

    dynamics, stiffness = bind(scene), _stiffness(scene)
    pull, model = _pull(dynamics, scene), dynamics.model
    begin, a, t, step, fits, left = q, pull(q), 0.0, 0.0, True, 0
    values, slopes = np.zeros(len(q)), np.zeros((len(q), len(q)))
    vectors, inverse, small = np.eye(len(q)), np.eye(len(q)), SMALL * np.eye(len(q))
    for _ in range(MOST):
        if fits:
            slopes = stiffness(q) if stiffness else np.array([pull(q + way) - a for way in small]).T / SMALL
            slopes = np.where(np.isfinite(slopes), slopes, 0.0)  # as at a pole
            with suppress(np.linalg.LinAlgError):  # else the last ones serve, as where two vectors are one
                found, ways = np.linalg.eig(slopes)
                values, vectors, inverse = found, ways, np.linalg.inv(ways)
            step = step or 1 / max(float(np.abs(slopes).sum(1).max()), 1.0)
        turn = flow(a)
        size, after = float(np.abs(turn).max()), pull(q + turn)
        with np.errstate(all="ignore"):
            off = np.abs(flow(after - a - slopes @ turn)).max() / (OFF * size + NEGLIGIBLE)  # from the linear motion
        if fits := bool(size <= TURN and off <= 1):
            q, a, t = q + turn, after, t + step
        step *= min(5.0, max(0.2, 0.8 / np.sqrt(max(off, (size / TURN) ** 2, 1e-3)))) if np.isfinite(off) else 0.2
        moved, k = np.abs(q - begin), int(np.argmax(np.real(values)))
        if moved[model.slides].max(initial=0.0) > LOST:
            raise _no_rest_error(model, q - begin)
        if moved[~model.slides].max(initial=0.0) > FAR:
            return q
        if t > LONG:
            if left == AGAIN or not stiffness or np.real(values[k]) <= UNSTABLE * np.abs(values).max():
                return q
            way, left, t, step, fits = np.real(vectors[:, k]), left + 1, 0.0, 0.0, True
            q = q + ASIDE * way / (np.abs(way).max() or 1.0)
            a = pull(q)
    raise _no_rest_error(model, q - begin)


def _pull(dynamics: Dynamics, scene: Scene) -> Pull:
    return lambda q: dynamics.acceleration(scene.start.time, q, np.zeros_like(q))


def _stiffness(scene: Scene) -> Pull | None:
    """The derivative (nv, nv) of the accelerations at rest by positions (nv,); None where a scene has none."""
    from pendpin.dynamics.derivatives import Variational  # here: pp.Start alone does not need derivatives

    try:
        equations = Variational(scene)
    except (InputError, MissingLibrary):
        return None
    return lambda q: equations.jacobian(0.0, q, np.zeros_like(q)).of_q


class Start(StartRecord):
    """When and where the motion starts, by joint name (what is left out is 0) or as a full list in model order."""

    @classmethod
    def at_rest(cls, scene: Scene | str | Path) -> Self:
        """The stable equilibrium of a scene nearest to its start's positions, with the effects as they are at the start.

        Friction is left out. Raises InputError if there is no equilibrium.
        """
        scene = chosen_scene(scene)
        dynamics, time = bind(scene), scene.start.time
        q, _ = start_state(dynamics.model, scene.start)
        loads, chain, along = dynamics.loads, dynamics.model.chain, SIGNS * dynamics.loads.field(0.0)
        acted_on = loads.torque or loads.wrench or dynamics.contacts or not along.any()
        rest, hangs = q, chain is not None and (chain.h > 0).all() and not acted_on
        if hangs:  # along the field; the chain's own equations need no data of Pinocchio, which take 0.2 s for 100 rods
            x, y, z = along / np.linalg.norm(along)
            hanging = np.zeros(len(q))
            hanging[:2] = np.arctan2(y, z), np.arctan2(x, np.hypot(y, z))
            rest = hanging + 2 * np.pi * np.round((q - hanging) / (2 * np.pi))
            dynamics = Dynamics(dynamics.model, scene.effects, "chain", start=time)

        pull = _pull(dynamics, scene)
        size = max(float(np.abs(pull(x)).max()) for x in (q, q + 0.5))
        if not hangs:
            held = [
                (f"effects[{i}].stiffness", e.stiffness) for i, e in enumerate(scene.effects) if isinstance(e, Anchor)
            ]
            try:
                rest = _relax(scene, q)
            except InputError:
                if not held:
                    raise
                for share in SOFTER:
                    rest = _relax(scene.replace({key: share * stiffness for key, stiffness in held}), rest)
        # where levers are so long, nothing turns
        lost = np.abs(rest - q)[dynamics.model.slides].max(initial=0.0) > LOST
        if lost or not np.abs(pull(rest)).max(initial=0.0) <= REST * size:
            raise _no_rest_error(dynamics.model, rest - q)
        contacts, joints = dynamics.contacts, dynamics.model.joints
        if contacts is not None and (beyond := (rest < contacts.lower) | (rest > contacts.upper)).any():
            i = int(np.argmax(beyond))
            stop = (contacts.lower if rest[i] < contacts.lower[i] else contacts.upper)[i]
            remedy = f"start there, with start.positions.{joints[i]} = {stop:g}, or move the stop"
            raise InputError(f"start: the equilibrium of {joints[i]} is beyond its stop at {stop:g}: {remedy}")
        rest = np.where(np.abs(rest) < TINY, 0.0, rest)
        return cls(time=time, positions=dict(zip(joints, rest.tolist(), strict=True)))

    @classmethod
    def conical(cls, scene: Scene | str | Path, angle: float) -> Self:
        """The steady cone of a single rod about the vertical, at an angle from it in rad: the tip runs round a circle.

        The rate Omega follows from Omega² cos(angle) = m g h / (I1 + m h²). Exact for a rod without inertia about its
        axis (radius 0, a point mass), where gravity alone acts. No other rod has a steady cone on a universal joint: its
        spin, -theta' sin(phi), changes round the circle, and with it an energy that is constant. It nods by about
        I3 / (I1 + m h²) sin(angle) tan²(angle); beyond 1 % of the angle that is noted. Raises InputError for scenes
        without a cone.
        """
        scene = chosen_scene(scene)
        dynamics = bind(scene)
        if not isinstance(scene.model, Chain) or len(dynamics.model.joints) != 2 or scene.model.count != 1:
            raise InputError("start: a steady cone needs a chain of one rod on a universal joint")
        angle = number("angle", angle, "between 0 and pi/2 rad", lambda angle: 0 < abs(angle) < np.pi / 2)
        field, rod = dynamics.loads.constant, scene.model.all_rods[0].properties
        if not (field[2] < 0 and np.abs(field[:2]).max() <= UPRIGHT * -field[2]):
            raise InputError("start: a steady cone needs gravity straight down")
        if rod.I1 != rod.I2:
            raise InputError("start: a steady cone needs a rod with I1 = I2")
        inertia = rod.I1 + rod.m * rod.h**2
        nod = rod.I3 / inertia * np.sin(abs(angle)) * np.tan(angle) ** 2
        if nod > NODDING * abs(angle):
            say_note(f"start: a thick rod has no steady cone; its angle changes by about {nod:.2g} rad", stacklevel=3)
        q, rate = np.array([0.0, float(angle)]), np.sqrt(-field[2] * rod.m * rod.h / (inertia * np.cos(angle)))
        along = np.array([exact.direction_rate(q, v) for v in np.eye(2)]).T  # (3, 2)
        v = np.linalg.lstsq(along, rate * np.cross([0.0, 0.0, 1.0], exact.direction(q)), rcond=None)[0]
        positions, velocities = (dict(zip(dynamics.model.joints, x.tolist(), strict=True)) for x in (q, v))
        return cls(time=scene.start.time, positions=positions, velocities=velocities)

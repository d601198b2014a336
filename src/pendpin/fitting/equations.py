"""The equations of a scene with free numbers, compiled: accelerations of the joints that move, and what holds a joint.

The articulated-body recursion runs once on heyoka's symbols with the free numbers as run-time parameters, so that one
call serves any number of states, each with parameters of its own. Joints that stay at rest (phi in a plane swing) are
left out, where their accelerations vanish whatever the others do.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from pydantic import Field
from scipy.integrate import RK45

from pendpin.dynamics.binding import Binding
from pendpin.dynamics.parameters import GIVEN
from pendpin.dynamics.symbols import external_wrenches
from pendpin.effects import ContactEffect, DryFriction, FieldEffect, Gravity, Motion
from pendpin.equations import recursion, trees
from pendpin.equations.numbers import symbols
from pendpin.errors import InputError
from pendpin.fitting.parameters import Free, replace_unchecked, substitute
from pendpin.ground.arrays import Array
from pendpin.ground.libraries import optional
from pendpin.model.bodies import tree_of
from pendpin.model.build import Model, build, start_state
from pendpin.scene import Chain, Rod, Scene

_AT_REST = 1e-10  # of the largest acceleration: what a joint at rest may accelerate by and stay


# J. R. Dormand, P. J. Prince, J. Comp. Appl. Math. 6 (1980), 19: the fifth order, as SciPy writes it
TIMES, WEIGHTS, STAGES = RK45.C, RK45.B, tuple(row[:i] for i, row in enumerate(RK45.A))

Function = Callable[[Array, Array], Array]  # states (2n + 1, C), parameters -> (outputs, C)


@dataclass(frozen=True, eq=False)
class Equations:
    """Compiled equations of the n joints that move, f of them with dry friction, over C states (2n + 1, C) at once.

    A state is positions, rates and the time. Parameters are (nz + f, C): the search coordinates, then the way that each
    joint with friction slides (-1, 1), or 0 for one that is held.
    """

    model: Model
    joints: tuple[int, ...]  # those that move, in model order
    rubbing: tuple[int, ...]  # those with dry friction, among the moving
    nz: int
    rate: Function  # accelerations (n, C)
    step: Function  # with the length of the step as a last parameter: states (2n + 1, C), accelerations (2 n, C) at its ends
    holding: Function | None  # (n f + f, C): columns of the inverse mass matrix, then what holds each joint at most
    outputs: Function  # joint angles (n, C), then tips (3 bodies, C) in m

    @property
    def rates(self) -> list[int]:
        """The rows of a state that hold the rates of joints with dry friction."""
        return [len(self.joints) + place for place in self.rubbing]

    def compliance(self, y: Array, pars: Array) -> tuple[Array, Array]:
        """Accelerations (n, f, C) for a unit torque on each joint with friction, and what can hold it (f, C) in N m."""
        assert self.holding is not None
        n, f = len(self.joints), len(self.rubbing)
        values = self.holding(y, pars)
        return values[: n * f].reshape(n, f, -1), values[n * f :]


def compile_equations(scene: Scene, free: Free, measured: Sequence[int]) -> Equations:
    """The equations of a scene, its free numbers being parameters; `measured` joints move in any case.

    Raises InputError for effects that a fit does not take, MissingLibrary without heyoka.
    """
    hy, model = optional("heyoka", "a fit", "heyoka"), build(scene.model)
    for i, effect in enumerate(scene.effects):
        if isinstance(effect, ContactEffect) and not isinstance(effect, DryFriction):
            raise InputError(f"effects[{i}]: a fit does not take {effect.kind}: measure swings that do not touch it")
    symbolic = _Symbolic(hy, scene, free, model)
    return symbolic.compiled(symbolic.moving(measured))


class _Symbolic:
    """A scene in symbols: its tree, its loads and its friction, from which functions of states are compiled."""

    def __init__(self, hy: Any, scene: Scene, free: Free, model: Model) -> None:
        if model.pin is None:
            raise InputError(f"model: {len(model.joints)} joints are too many for a fit")
        self.hy, self.scene, self.model, self.nz = hy, scene, model, len(free.start)
        values = free.values(np.array([hy.par[i] for i in range(self.nz)], dtype=object))
        self.symbolic = substitute(scene, free.keys, list(values), replace_unchecked)
        self.tree, self.model = _insert_rods(tree_of(model.pin), model, self.symbolic)
        smooth = tuple(_make_symbolic(e) for e in self.symbolic.effects if not isinstance(e, ContactEffect))
        self.loads = Binding(self.model, smooth, symbols()).loads
        self.frictions = [e for e in self.symbolic.effects if isinstance(e, DryFriction)]

    def moving(self, measured: Sequence[int]) -> tuple[int, ...]:
        """The joints that move once the measured ones do, and those that do not start at rest at 0."""
        q, v = start_state(self.model, self.scene.start)
        joints = set(measured) | set(np.flatnonzero((q != 0) | (v != 0)))
        while True:
            resting = [j for j in range(len(q)) if j not in joints]
            pushed = self._pushed([int(j) for j in sorted(joints)], resting)
            if not pushed:
                return tuple(sorted(int(j) for j in joints))
            joints |= set(pushed)

    def _pushed(self, joints: list[int], resting: list[int]) -> list[int]:
        """Those of the joints at rest that random states of the others accelerate."""
        if not resting:
            return []
        y, a = self._acceleration(joints, ())
        function = self._function(y, [*a[resting], *a])
        draw = np.random.default_rng(0)
        states = draw.normal(0.0, 1.0, (len(y), 8))
        sizes = np.abs(function(states, np.repeat(draw.uniform(0.9, 1.1, (self.nz, 1)), 8, 1)))
        largest = sizes[len(resting) :].max() or 1.0
        return [joint for joint, size in zip(resting, sizes.max(1), strict=False) if not size <= _AT_REST * largest]

    def compiled(self, joints: tuple[int, ...]) -> Equations:
        """The functions of the states of some joints."""
        rubbing = tuple(place for place, joint in enumerate(joints) if self._frictions_at(joint))
        y, accelerations = self._acceleration(joints, rubbing)
        holding = None
        if rubbing:
            holds = [sum(e.resistance()[1] for e in self._frictions_at(joints[place])) for place in rubbing]
            holding = self._function(y, [*self._columns(joints, rubbing, y), *holds])
        a = list(accelerations[list(joints)])
        step = self._function(y, self._step(y, a, self.hy.par[self.nz + len(rubbing)]))
        outputs = self._function(y, self._outputs(joints, y))
        return Equations(self.model, joints, rubbing, self.nz, self._function(y, a), step, holding, outputs)

    def _step(self, y: Array, a: list[Any], h: Any) -> list[Any]:
        """A step by h: states (2n + 1,), then accelerations (n,) at its two ends."""
        n, stages = len(a), []
        for row, c in zip(STAGES, TIMES, strict=True):
            moved = _move(y, h, row, stages) if stages else list(y[:-1])
            new = dict(zip(map(str, y), [*moved, y[-1] + c * h], strict=True)) if stages else {}
            stages.append([*moved[n:], *self.hy.subs([self.hy.expression(x) for x in a], new)])
        return [*_move(y, h, WEIGHTS, stages), y[-1] + h, *stages[0][n:], *stages[5][n:]]

    def _frictions_at(self, joint: int) -> list[DryFriction]:
        name = self.model.joints[joint]
        where = [self.model.joints if e.joints is None else e.joints for e in self.frictions]
        return [e for e, names in zip(self.frictions, where, strict=True) if name in names]

    def _states(self, joints: Sequence[int]) -> tuple[Array, Array, Array]:
        """The symbols (2n + 1,) of the moving joints and the time, and q, v (nv,) of all joints, the others at rest."""
        y = np.array(self.hy.make_vars(*(f"y{i}" for i in range(2 * len(joints))), "t"), dtype=object)
        q, v = np.zeros((2, len(self.model.joints)), dtype=object)
        q[list(joints)], v[list(joints)] = np.split(y[:-1], 2)
        return y, q, v

    def _acceleration(self, joints: Sequence[int], rubbing: Sequence[int]) -> tuple[Array, Array]:
        """The symbols (2n + 1,) and the accelerations (nv,) of all joints."""
        xp, (y, q, v) = symbols(), self._states(joints)
        torque = np.zeros(len(q), dtype=object)
        if self.loads.torque is not None:
            torque = torque + self.loads.torque(y[-1], q, v)
        for k, place in enumerate(rubbing):
            joint = joints[place]
            for effect in self._frictions_at(joint):
                torque[joint] -= self.hy.par[self.nz + k] * effect.sliding(v[joint], xp)
        external = None
        if self.loads.wrench is not None:
            external = external_wrenches(self.model, self.loads, GIVEN, self.tree, xp)(y[-1], q, v)
        field = np.array(self.loads.field(y[-1]), dtype=object)
        return y, recursion.accelerations(self.tree, q, v, field, torque, external, xp)

    def _columns(self, joints: tuple[int, ...], rubbing: tuple[int, ...], y: Array) -> list[Any]:
        """The inverse mass matrix, 1/(kg m²): rows of the n moving joints, columns of the f with friction; y (2n + 1,)."""
        q = np.zeros(len(self.model.joints), dtype=object)
        q[list(joints)] = y[: len(joints)]
        units = np.eye(len(q))[[joints[place] for place in rubbing]]
        still = np.zeros(len(q)), np.zeros(3)
        columns = [recursion.accelerations(self.tree, q, *still, unit, None, symbols()) for unit in units]
        return [column[joint] for joint in joints for column in columns]

    def _outputs(self, joints: tuple[int, ...], y: Array) -> list[Any]:
        """Joint angles (n,) and tips (bodies, 3) in m."""
        _, q, v = self._states(joints)
        motions = trees.motions(self.tree, q, v, symbols())
        motion = Motion(*motions).of(np.array([body.joint for body in self.model.bodies]))
        tips = motion.points(np.array([body.tip for body in self.model.bodies], dtype=object))
        return [*y[: len(joints)], *tips.reshape(-1)]

    def _function(self, y: Array, outputs: list[Any]) -> Function:
        """Outputs as a compiled function of states (2n + 1, C) and parameters."""
        compiled = self.hy.cfunc([self.hy.expression(x) for x in outputs], list(y), compact_mode=True)
        count, needed = len(outputs), compiled.nparams

        def function(y: Array, pars: Array) -> Array:
            some = np.ascontiguousarray(pars[:needed])
            return compiled(np.ascontiguousarray(y), outputs=np.empty((count, y.shape[1])), pars=some)

        return function


def _move(y: Array, h: Any, weights: Array, stages: list[list[Any]]) -> list[Any]:
    """States (2n,) moved from y (2n + 1,) by h times a weighted sum of stages."""
    slopes = zip(*stages, strict=True)
    return [
        x + h * sum(w * s for w, s in zip(weights.tolist(), slope, strict=True))
        for x, slope in zip(y, slopes, strict=False)
    ]


def _insert_rods(tree: trees.Tree, model: Model, scene: Scene) -> tuple[trees.Tree, Model]:
    """The tree and the model of a chain with the rods of a scene in symbols; others as they are."""
    if not isinstance(scene.model, Chain):
        return tree, model
    rods: tuple[Rod, ...] = scene.model.rods * scene.model.copies
    masses, coms, inertias, places = (np.array(x, dtype=object) for x in (*tree[5:], tree.translations))
    bodies = []
    for i, (rod, body) in enumerate(zip(rods, model.bodies, strict=True)):
        m, h, *principal = rod.properties
        zero = 0.0 * rod.length
        com, tip = (np.array([zero, zero, -x], dtype=object) for x in (h, rod.length))
        inertia = np.diag(np.array(principal, dtype=object))
        masses[body.joint], coms[body.joint], inertias[body.joint] = m, com, inertia
        if i + 1 < len(rods):
            places[body.joint + 1] = tip
        bodies.append(replace(body, mass=m, com=com, inertia=inertia, tip=tip, radius=rod.radius))
    changed = tree._replace(masses=masses, coms=coms, inertias=inertias, translations=places)
    return changed, replace(model, bodies=tuple(bodies))


class _TurnedGravity(FieldEffect):
    """Gravity whose acceleration or direction are symbols."""

    kind: str = Field("gravity", description="which effect it is")
    acceleration: Any = Field(description="m/s², a symbol")
    direction: Any = Field(description="in W, symbols")

    @property
    def constant(self) -> bool:
        """As `FieldEffect.constant`."""
        return True

    def field(self, t: Any, xp: Any = None) -> Array:
        """As `FieldEffect.field`."""
        direction = np.array(self.direction, dtype=object)
        return self.acceleration * direction / symbols().sqrt((direction * direction).sum())


def _make_symbolic(effect: Any) -> Any:
    if isinstance(effect, Gravity):
        return _TurnedGravity.model_construct(acceleration=effect.acceleration, direction=effect.direction)
    return effect

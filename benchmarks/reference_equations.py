"""The equations of a scene in symbols, for the reference motion."""

from typing import Any

import heyoka as hy
import numpy as np

import pendpin as pp
from pendpin.dynamics import parameters
from pendpin.dynamics.binding import Binding
from pendpin.effects import Motion, cross
from pendpin.equations import recursion, trees
from pendpin.model.build import Model

# --- equations in symbols -------------------------------------------------------------------------------------------


class Numbers:
    """numpy's functions over symbols with constants of one precision."""

    def __init__(self, number: Any) -> None:
        self._number = number
        self.asarray = np.frompyfunc(self.exactly, 1, 1)
        self.minimum = np.frompyfunc(lambda x, y: self._chosen(x, y, hy.lt), 2, 1)
        self.maximum = np.frompyfunc(lambda x, y: self._chosen(x, y, hy.gt), 2, 1)

    @staticmethod
    def _chosen(first: Any, second: Any, test: Any) -> Any:
        first, second = hy.expression(first), hy.expression(second)
        return hy.select(test(first, second), first, second)

    def exactly(self, x: Any) -> Any:
        """A double as a symbol; symbols as they are."""
        return x if isinstance(x, hy.expression) else hy.expression(self._number(float(x)))

    def __getattr__(self, name: str) -> Any:
        function = getattr(hy, name)
        return np.frompyfunc(lambda x: function(self.exactly(x)), 1, 1)


def _tree(model: pp.Chain, xp: Numbers) -> trees.Tree:
    """The rods as a tree of revolute joints, from the scene's own numbers."""
    q, n = xp.exactly, 2 * model.count
    axes, translations, masses, coms, inertias = [], [], [], [], []
    above = [0.0, 0.0, 0.0]
    for rod in model.all_rods:
        m, length, r, p = q(rod.mass), q(rod.length), q(rod.radius), q(rod.payload)
        h = length / q(2.0) if rod.com is None else q(rod.com)
        across = m * (q(3.0) * r * r + length * length) / q(12.0)
        principal = [across, across, m * r * r / q(2.0)] if rod.inertia is None else [q(x) for x in rod.inertia]
        if rod.payload:
            lever = m * (p / (m + p)) * (length - h) * (length - h)
            principal = [principal[0] + lever, principal[1] + lever, principal[2]]
            h, m = h + (length - h) * (p / (m + p)), m + p
        axes += [[-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]]
        translations += [above, [0.0, 0.0, 0.0]]
        masses += [0.0, m]
        coms += [[0.0] * 3, [0.0, 0.0, -h]]
        inertias += [np.zeros((3, 3)), np.diag(principal)]
        above = [0.0, 0.0, -length]
    columns = (xp.asarray(np.array(x, dtype=object)) for x in (translations, masses, coms, inertias))
    eyes = np.tile(np.eye(3), (n, 1, 1))
    return trees.Tree(tuple(range(-1, n - 1)), ("revolute",) * n, np.array(axes), eyes, *columns)


def accelerations(scene: pp.Scene, model: Model, effects: Any, number: Any) -> tuple[np.ndarray, np.ndarray]:
    """The state (2 nv,) and the accelerations (nv,) in symbols."""
    nv, xp = len(model.joints), Numbers(number)
    y = np.array(hy.make_vars(*(f"y{i}" for i in range(2 * nv))), dtype=object)
    q, v = np.split(y, 2)
    loads, tree = Binding(model, effects, scene.start.time, parameters.Numbers(xp)).loads, _tree(scene.model, xp)
    tau = None if loads.torque is None else loads.torque(hy.time, q, v)
    external = None
    if loads.wrench is not None:
        joints = [body.joint for body in model.bodies]
        motion = Motion(*(part[joints] for part in trees.motions(tree, q, v, xp)))
        linear, angular = ((part[:, None] @ motion.rotation)[:, 0] for part in loads.wrench(hy.time, motion))
        com = np.array([body.com for body in model.bodies])
        external = np.full((nv, 6), xp.exactly(0.0), dtype=object)
        external[joints] = np.concatenate([linear, angular + cross(com, linear)], -1)
    field = xp.asarray(np.asarray(loads.field(hy.time), dtype=object))
    return y, xp.asarray(recursion.accelerations(tree, q, v, field, tau, external, xp))

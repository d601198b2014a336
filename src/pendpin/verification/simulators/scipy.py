"""Plain SciPy around Pinocchio's aba: what a user would write.

With the derivatives of aba as the Jacobian Radau took at most a quarter less time, and LSODA twice as long on three
rods; neither uses them.
"""

import math
import warnings
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from pendpin.errors import RunError
from pendpin.ground.arrays import EPS, Array, Indices
from pendpin.ground.libraries import version
from pendpin.model.bodies import pinocchio
from pendpin.verification.simulators.base import NOT_FINITE, Look, Peer, PeerTask, Prepared, loading, peer

METHODS = ("DOP853", "RK45", "LSODA", "Radau")
LEAST_RELATIVE = 100 * EPS  # that SciPy takes

Derivative = Callable[[float, Array], Array]


def scipy_peers(task: PeerTask) -> Iterator[Peer]:
    """SciPy's methods. Raises InputError for a model that Pinocchio does not load."""
    library = f"scipy {version('scipy')}, pin {version('pin')}"
    with loading("pinocchio"):
        model = pinocchio().buildModelFromXML(task.text)
    model.gravity.linear = task.gravity
    names = list(model.names)[1:]
    places = np.array([names.index(name) for name in task.joints])
    right_hand_side = _right_hand_side(model)
    at_probe = right_hand_side(lambda: None)(0.0, _state(places, task.probe.q, task.probe.v))
    task.check("pinocchio", at_probe[model.nv + places])
    for method in METHODS:
        prepare = _motion(right_hand_side, places, method, task)
        yield peer(task, f"scipy {method.lower()}", library, "tolerance", prepare)


def _state(places: Indices, q: Array, v: Array) -> Array:
    """The state (2 nv,) from q, v (nv,), each joint at its place."""
    state = np.empty((2, len(places)))
    state[:, places] = q, v
    return state.ravel()


def _motion(
    right_hand_side: Callable[[Look], Derivative], places: Indices, method: str, task: PeerTask
) -> Callable[[float], Prepared]:
    """A function that prepares a run at a tolerance; places (nv,) are those of the joints in the state."""
    from scipy.integrate import solve_ivp

    def prepare(tolerance: float) -> Prepared:
        start, span, evaluations = _state(places, task.q, task.v), task.times[[0, -1]], 0
        options: dict[str, Any] = {"method": method, "rtol": max(tolerance, LEAST_RELATIVE), "atol": tolerance}

        def rows(look: Look) -> Iterator[Array]:
            nonlocal evaluations
            derivative = right_hand_side(look)
            with warnings.catch_warnings(action="ignore"):  # the failure says it
                solution = solve_ivp(derivative, span, start, t_eval=task.times, **options)
            evaluations = solution.nfev
            yield from np.reshape(solution.y, (len(start), -1))[places].T[1:]
            if not solution.success:
                raise RunError(solution.message)

        return Prepared(rows, lambda: (0, evaluations))

    return prepare


def _right_hand_side(model: Any) -> Callable[[Look], Derivative]:
    """What a user would write, and a guard: SciPy's loops do not end on NaN."""
    aba, data, nv, none = pinocchio().aba, model.createData(), model.nv, np.zeros(model.nv)

    def counted(look: Look) -> Derivative:
        def derivative(t: float, y: Array) -> Array:
            v = y[nv:]
            a = aba(model, data, y[:nv], v, none)
            if not math.isfinite(a @ a):
                raise RunError(NOT_FINITE)
            look()
            return np.concatenate([v, a])

        return derivative

    return counted

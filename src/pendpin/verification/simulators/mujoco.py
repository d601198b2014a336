"""MuJoCo: its compiled loop runs from output time to output time, with all but gravity disabled.

Disabling the rest makes a step cheaper by 6 to 20 %; the form of its Jacobians and mujoco.rollout make no difference.
`implicitfast` is `euler` where nothing damps; `implicit` is of first order too, and dearer.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from copy import copy
from importlib import import_module
from typing import Any

import numpy as np

from pendpin.errors import RunError
from pendpin.ground.arrays import Array
from pendpin.ground.libraries import version
from pendpin.integrators.fixed import count_equal_steps
from pendpin.verification.simulators.base import LEAST, Look, Peer, PeerTask, Prepared, loading, peer

STAGES = {"rk4": 4, "euler": 1, "implicitfast": 1}  # evaluations a step
STEPS_AT_ONCE = 1_000  # between two looks at the clock


def mujoco_peers(task: PeerTask) -> Iterator[Peer]:
    """MuJoCo's integrators. Raises InputError for a model that it does not take."""
    mujoco = import_module("mujoco")
    library = f"mujoco {version('mujoco')}"
    with loading("mujoco"):
        model = _model(mujoco, task)
    task.check("mujoco", _acceleration(mujoco, model, task))
    for name in STAGES:
        yield peer(task, f"mujoco {name}", library, "step", _motion(mujoco, model, name, task))


def _model(mujoco: Any, task: PeerTask) -> Any:
    """The model without what MuJoCo adds to massless bodies, and without its tests that reset a state."""
    model = mujoco.MjModel.from_xml_string(task.text)
    for sizes in (model.body_mass, model.body_inertia):
        sizes[sizes <= LEAST] = 0.0
    model.opt.gravity[:] = task.gravity
    names = {name for name in mujoco.mjtDisableBit.__members__ if name.startswith("mjDSBL_")} - {"mjDSBL_GRAVITY"}
    model.opt.disableflags = sum(getattr(mujoco.mjtDisableBit, name).value for name in names)
    return model


def _places(model: Any, task: PeerTask) -> tuple[Any, Any]:
    """Where the joints are in qpos and qvel."""
    joints = [model.joint(name) for name in task.joints]
    return np.array([joint.qposadr[0] for joint in joints]), np.array([joint.dofadr[0] for joint in joints])


def _acceleration(mujoco: Any, model: Any, task: PeerTask) -> Array:
    data, (at_q, at_v) = mujoco.MjData(model), _places(model, task)
    data.qpos[at_q], data.qvel[at_v] = task.probe.q, task.probe.v
    with _heard(mujoco):  # what is wrong shows in the numbers
        mujoco.mj_forward(model, data)
    return data.qacc[at_v]


def _motion(mujoco: Any, model: Any, name: str, task: PeerTask) -> Callable[[float], Prepared]:
    at_q, at_v = _places(model, task)

    def prepare(step: float) -> Prepared:
        stepped, data, count, taken = copy(model), mujoco.MjData(model), count_equal_steps(task.interval, step), 0
        stepped.opt.integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{name.upper()}")
        stepped.opt.timestep = task.interval / count
        qpos = data.qpos
        qpos[at_q], data.qvel[at_v] = task.q, task.v

        def rows(look: Look) -> Iterator[Array]:
            nonlocal taken
            with _heard(mujoco) as warnings:
                for _ in task.times[1:]:
                    for left in range(count, 0, -STEPS_AT_ONCE):
                        steps = min(left, STEPS_AT_ONCE)
                        mujoco.mj_step(stepped, data, steps)
                        taken += steps
                        if warnings:
                            raise RunError(warnings[0])
                        look()
                    yield qpos[at_q]

        return Prepared(rows, lambda: (taken, STAGES[name] * taken))

    return prepare


@contextmanager
def _heard(mujoco: Any) -> Iterator[list[str]]:
    """MuJoCo's warnings in a list; otherwise MuJoCo writes them to a file in the working directory."""
    before, warnings = mujoco.get_mju_user_warning(), []
    mujoco.set_mju_user_warning(warnings.append)
    try:
        yield warnings
    finally:
        mujoco.set_mju_user_warning(before)

"""A scene in other simulators and in plain SciPy, from one URDF text: what each reaches at its best, and in what time."""

from importlib.util import find_spec

import numpy as np

from pendpin.dynamics.dynamics import Dynamics
from pendpin.effects import Gravity
from pendpin.errors import InputError, MissingLibrary
from pendpin.model.build import build, start_state
from pendpin.scene import Scene
from pendpin.verification.simulators.base import Peer, PeerRun, PeerTask, Probe, same_for_all
from pendpin.verification.simulators.drake import drake_peers
from pendpin.verification.simulators.mujoco import mujoco_peers
from pendpin.verification.simulators.scipy import scipy_peers

MODULES = {"mujoco": "mujoco", "drake": "pydrake"}  # by the names of their packages


def peers(scene: Scene) -> tuple[Peer, ...]:
    """The peers that are installed, each with its model of the scene. Gravity is the one effect that they take.

    Without SciPy around Pinocchio for chains too long for Pinocchio's memory. Raises InputError for a scene with other
    effects, or that one of them does not take.
    """
    task, absent = task_of(scene), missing()
    made = {"mujoco": mujoco_peers, "drake": drake_peers, "scipy": scipy_peers}
    if build(scene.model).make_pin is None:
        del made["scipy"]
    return tuple(peer for name, make in made.items() if name not in absent for peer in make(task))


def missing() -> tuple[str, ...]:
    """The other simulators that are not installed, by the names of their packages."""
    return tuple(name for name, module in MODULES.items() if find_spec(module) is None)


def require_libraries() -> None:
    """Raises MissingLibrary without MuJoCo or Drake."""
    if names := missing():
        are = "is" if len(names) == 1 else "are"
        raise MissingLibrary(f"peers: {' and '.join(names)} {are} not installed: pip install mujoco drake")


def task_of(scene: Scene) -> PeerTask:
    """A scene as the peers get it; raises InputError for effects other than gravity."""
    for i, effect in enumerate(scene.effects):
        if not isinstance(effect, Gravity):
            raise InputError(f"effects[{i}]: {effect.kind}: other simulators are compared under gravity alone")
    dynamics = Dynamics(build(scene.model), scene.effects)
    model, gravity = dynamics.model, dynamics.loads.constant
    q, v = start_state(model, scene.start)
    at, rates = np.sin(1.0 + np.arange(2 * len(model.joints))).reshape(2, -1)  # any state will do
    probe = Probe(at, rates, dynamics.acceleration(0.0, at, rates))
    return PeerTask(*same_for_all(scene.model), model.joints, q, v, gravity, scene.times, probe)

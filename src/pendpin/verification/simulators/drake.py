"""Drake: a plant in continuous time, alone and without contact geometry, advanced from output time to output time.

Left out, after trials on one and three rods: bogacki_shampine3, which took as long as runge_kutta3 at low accuracy and
several times as long as runge_kutta5 at high; radau3, ten times as long or more; and the methods of first order, which
are far off. Two faults of Drake 1.51 are met here:
- After a step that error control rejects, runge_kutta5 begins again with the derivative of the rejected end: the plant's
  cache does not learn that the state is restored. It goes on rejecting, and its errors are up to some hundred times its
  tolerance. With fixed steps nothing is rejected, and that is its best.
- A trial step that overflows is tried again without end. So the first step is a small one.
"""

import math
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from pendpin.ground.arrays import Array
from pendpin.ground.libraries import version
from pendpin.integrators.fixed import count_equal_steps
from pendpin.verification.simulators.base import Kind, Look, Peer, PeerTask, Prepared, loading, peer

FIRST_TURN = 1e-3  # rad or so, in the first step
METHODS: dict[str, tuple[str, Kind]] = {
    "rk5 fixed": ("runge_kutta5", "step"),
    "rk5": ("runge_kutta5", "tolerance"),
    "rk3": ("runge_kutta3", "tolerance"),
}


def drake_peers(task: PeerTask) -> Iterator[Peer]:
    """Drake's integrators. Raises InputError for a model that it does not take."""
    library = f"drake {version('drake')}"
    with loading("drake"):
        plant = _plant(task)
    task.check("drake", _acceleration(plant, task))
    for name, (scheme, kind) in METHODS.items():
        yield peer(task, f"drake {name}", library, kind, _motion(plant, scheme, kind, task))


def _plant(task: PeerTask) -> Any:
    from pydrake.multibody.parsing import Parser  # pyright: ignore[reportMissingImports]
    from pydrake.multibody.plant import MultibodyPlant  # pyright: ignore[reportMissingImports]

    plant: Any = MultibodyPlant(time_step=0.0)
    Parser(plant).AddModelsFromString(task.text, "urdf")
    if task.support != "world":  # which is the world to Drake
        plant.WeldFrames(plant.world_frame(), plant.GetFrameByName(task.support))
    plant.mutable_gravity_field().set_gravity_vector(task.gravity)
    plant.Finalize()
    return plant


def _places(plant: Any, task: PeerTask) -> tuple[Any, Any]:
    """Where the joints are in positions and velocities."""
    joints = [plant.GetJointByName(name) for name in task.joints]
    return np.array([j.position_start() for j in joints]), np.array([j.velocity_start() for j in joints])


def _set(plant: Any, context: Any, task: PeerTask, q: Array, v: Array) -> None:
    """Put positions and velocities (nv,) of the scene into Drake's context."""
    at_q, at_v = _places(plant, task)
    positions, velocities = np.empty((2, len(q)))
    positions[at_q], velocities[at_v] = q, v
    plant.SetPositions(context, positions)
    plant.SetVelocities(context, velocities)


def _acceleration(plant: Any, task: PeerTask) -> Array:
    context = plant.CreateDefaultContext()
    _set(plant, context, task, task.probe.q, task.probe.v)
    return plant.EvalTimeDerivatives(context).get_generalized_velocity().CopyToVector()[_places(plant, task)[1]]


def _motion(plant: Any, scheme: str, kind: Kind, task: PeerTask) -> Callable[[float], Prepared]:
    at_q, _ = _places(plant, task)

    def prepare(setting: float) -> Prepared:
        simulator = _simulator(plant, scheme, kind, setting, task.interval)
        integrator, context = simulator.get_mutable_integrator(), simulator.get_mutable_context()
        _set(plant, context, task, task.q, task.v)
        if kind == "tolerance":
            integrator.request_initial_step_size_target(_first_step(plant, context))

        def rows(look: Look) -> Iterator[Array]:
            simulator.set_monitor(lambda context: look())
            simulator.Initialize()
            for t in task.times[1:]:
                simulator.AdvanceTo(t)
                yield plant.GetPositions(context)[at_q]

        return Prepared(rows, lambda: (integrator.get_num_steps_taken(), integrator.get_num_derivative_evaluations()))

    return prepare


def _simulator(plant: Any, scheme: str, kind: Kind, setting: float, interval: float) -> Any:
    from pydrake.systems.analysis import ApplySimulatorConfig, Simulator, SimulatorConfig  # pyright: ignore[reportMissingImports]

    config = SimulatorConfig(integration_scheme=scheme, publish_every_time_step=False)
    config.use_error_control = kind == "tolerance"
    if kind == "tolerance":
        config.accuracy = setting
    else:
        count = count_equal_steps(interval, setting)
        config.max_step_size = interval / count * (1 + 1e-12)  # so that rounding leaves no last sliver
    simulator = Simulator(plant)
    ApplySimulatorConfig(config, simulator)
    return simulator


def _first_step(plant: Any, context: Any) -> float:
    """A step in which little turns, s."""
    derivatives = plant.EvalTimeDerivatives(context)
    v, a = (
        float(np.abs(part.CopyToVector()).max())
        for part in (derivatives.get_generalized_position(), derivatives.get_generalized_velocity())
    )
    return FIRST_TURN / (1 + v + math.sqrt(a))

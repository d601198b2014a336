"""A scene in other simulators and in plain SciPy, from one URDF text: what each reaches at its best, and in what time."""

import math
import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from copy import copy
from dataclasses import dataclass
from functools import partial
from importlib import import_module
from importlib.util import find_spec
from typing import Any, Literal
from xml.etree import ElementTree

import numpy as np

from pendpin.dynamics.dynamics import Dynamics
from pendpin.effects import Gravity
from pendpin.errors import InputError, RunError, one_line
from pendpin.ground.arrays import EPS, Array
from pendpin.ground.libraries import version
from pendpin.integrators.fixed import count_equal_steps
from pendpin.model.bodies import pinocchio
from pendpin.model.build import build, start_state
from pendpin.model.urdf import has_inertia, read_urdf
from pendpin.model.write_models import LEAST, chain_urdf
from pendpin.scene import Chain, PinModel, Scene, UrdfModel

MODULES = {"mujoco": "mujoco", "drake": "pydrake"}  # by the names of their packages
SAME = 1e-6  # of the largest acceleration, or of 1 rad/s²: what a peer's may differ by
NOT_FINITE = "its state is not finite"

Kind = Literal["tolerance", "step"]
Look = Callable[[], None]  # at the clock; raises RunError when the time is up
Rows = Iterator[tuple[Array, int, int]]  # q (nv,) at each output time, and the steps and evaluations so far


@dataclass(frozen=True, eq=False)
class PeerTask:
    """A scene as the peers get it."""

    text: str  # URDF
    support: str  # the link that it hangs on
    joints: tuple[str, ...]  # in pendpin's model order
    q: Array  # (nv,) at the start
    v: Array  # (nv,)
    gravity: Array  # (3,) m/s², W
    times: Array  # (n,) s
    probe: tuple[Array, Array, Array]  # q, v (nv,) and their accelerations, which every peer's model has to have

    @property
    def interval(self) -> float:
        """The time from output to output, s."""
        return float(self.times[1]) if len(self.times) > 1 else 1.0

    def check(self, library: str, a: Array) -> None:
        """Raise InputError unless these accelerations (nv,) at the probe are right."""
        right = self.probe[2]
        off = np.abs(a - right).max() / max(1.0, np.abs(right).max())
        if not off < SAME:
            raise InputError(f"model: {library} makes another model of it: accelerations differ by {off:.1e}")


@dataclass(frozen=True, eq=False)
class PeerRun:
    """What one run reached, and what it took."""

    t: Array  # (n,) s, the output times reached
    q: Array  # (n, nv) in pendpin's model order
    steps: int  # 0 where the peer does not say
    evaluations: int  # of accelerations, 0 where the peer does not say
    seconds: float  # of integration with its sampling; building apart


@dataclass(frozen=True)
class Peer:
    """One method of another library, ready to run a scene."""

    name: str
    library: str  # with its version
    kind: Kind
    task: PeerTask
    start: Callable[[float, Look], Rows]  # with a setting; up to its first row the run is built

    def run(self, setting: float, limit: float = math.inf) -> PeerRun:
        """A run over scene.times with a tolerance, or in equal steps up to a step in s; `limit` is in s of processor time.

        Raises RunError for one that ends before its time, with what it reached as `partial`.
        """
        if not 0 < setting < math.inf:
            raise InputError(f"{self.name}: {self.kind} {setting:g} is not a positive number")

        def look() -> None:
            if time.thread_time() > begin + limit:
                raise RunError(f"took over {limit:g} s")

        rows, failure, begin = list[tuple[Array, int, int]](), "", math.inf
        try:
            for row in self.start(setting, look):
                rows.append(row)
                begin = min(begin, time.thread_time())  # what comes before the first row is building
        except Exception as error:  # each library has its own
            failure = one_line(str(error)) or type(error).__name__
        if not rows:
            raise RunError(failure)
        seconds = time.thread_time() - begin
        q = np.array([row for row, *_ in rows])
        if not (good := np.isfinite(q).all(1)).all():
            q, failure = q[: np.argmin(good)], failure or NOT_FINITE
        run = PeerRun(self.task.times[: len(q)], q, *rows[-1][1:], seconds)
        if failure:
            raise RunError(f"{failure}; it got to {run.t[-1]:g} s", run)
        return run


def peers(scene: Scene) -> tuple[Peer, ...]:
    """The installed peers, each with its model of the scene under gravity alone. Raises InputError for other scenes."""
    task, absent = task_of(scene), missing()  # those that most often reach an accuracy come first
    made = {"scipy": scipy_peers, "mujoco": mujoco_peers, "drake": drake_peers}
    if build(scene.model).make_pin is None:
        del made["scipy"]
    return tuple(peer for name, make in made.items() if name not in absent for peer in make(task))


def missing() -> tuple[str, ...]:
    """The other simulators that are not installed, by the names of their packages."""
    return tuple(name for name, module in MODULES.items() if find_spec(module) is None)


def task_of(scene: Scene) -> PeerTask:
    """A scene as the peers get it; raises InputError for effects other than gravity."""
    for i, effect in enumerate(scene.effects):
        if not isinstance(effect, Gravity):
            raise InputError(f"effects[{i}]: {effect.kind}: other simulators are compared under gravity alone")
    dynamics = Dynamics(build(scene.model), scene.effects)
    model, gravity = dynamics.model, dynamics.loads.constant
    q, v = start_state(model, scene.start)
    at, rates = np.sin(1.0 + np.arange(2 * len(model.joints))).reshape(2, -1)  # any state will do
    probe = (at, rates, dynamics.acceleration(0.0, at, rates))
    return PeerTask(*_shared_urdf(scene.model), model.joints, q, v, gravity, scene.times, probe)


@contextmanager
def _loading(library: str) -> Iterator[None]:
    """Errors that a library raises in the block become an InputError."""
    try:
        yield
    except Exception as error:
        raise InputError(f"model: {library} does not load it: {error}") from None


# --- one URDF text that all of them read to the same model ----------------------------------------------------------


def _shared_urdf(model: Chain | UrdfModel | PinModel) -> tuple[str, str]:
    """The model that pendpin simulates, without what is only drawn and what it leaves out, and the link it hangs on.

    MuJoCo gives every massless body the least that it takes. Where such a link is fixed to another and carries none, it
    is left out; the others say that they have no mass, as MuJoCo would else place its centre apart.
    """
    if isinstance(model, PinModel):
        raise InputError("model: other simulators take a chain of rods or a URDF, and this is a pin.Model")
    robot = ElementTree.fromstring(chain_urdf(model) if isinstance(model, Chain) else read_urdf(model).text)
    for parent, children in [(joint, "dynamics") for joint in robot.findall("joint")] + [(robot, "mujoco")]:
        for child in parent.findall(children):
            parent.remove(child)
    fixed = {c.get("link"): joint for joint in robot.iterfind("joint[@type='fixed']") for c in joint.iterfind("child")}
    while True:  # without links fixed to another that are massless and carry none, from the last on
        carriers = {parent.get("link") for parent in robot.iterfind("joint/parent")}
        bare = [x for x in robot.iterfind("link") if x.get("name") in fixed.keys() - carriers and not has_inertia(x)]
        if not bare:
            break
        for link in bare:
            robot.remove(link)
            robot.remove(fixed.pop(link.get("name")))
    hanging = {child.get("link") for child in robot.iterfind("joint/child")}
    root = next(name for link in robot.iterfind("link") if (name := link.get("name", "")) not in hanging)
    for link in robot.findall("link"):
        is_root = link.get("name") == root
        for part in [*link.findall("visual"), *(link.findall("inertial") if is_root else ())]:  # the root stands still
            link.remove(part)
        if not is_root and link.find("inertial") is None:
            inertial = ElementTree.SubElement(link, "inertial")
            ElementTree.SubElement(inertial, "mass", value="0")
            ElementTree.SubElement(inertial, "inertia", dict.fromkeys(("ixx", "iyy", "izz", "ixy", "ixz", "iyz"), "0"))
    least = {"boundmass": LEAST, "boundinertia": LEAST}
    ElementTree.SubElement(ElementTree.SubElement(robot, "mujoco"), "compiler", least)
    return ElementTree.tostring(robot, encoding="unicode"), root


# --- MuJoCo: its compiled loop runs from output time to output time, with all but gravity disabled ------------------
# Disabling the rest makes a step cheaper by 6 to 20 %; the form of its Jacobians and mujoco.rollout make no difference.
# `implicitfast` is `euler` where nothing damps; `implicit` is of first order too, and dearer.

STAGES = {"rk4": 4, "euler": 1, "implicitfast": 1}  # evaluations a step
STEPS_AT_ONCE = 1_000  # between two looks at the clock


def mujoco_peers(task: PeerTask) -> Iterator[Peer]:
    """MuJoCo's integrators. Raises InputError for a model that it does not take."""
    mujoco: Any = import_module("mujoco")
    with _loading("mujoco"):
        model = mujoco_model(mujoco, task)
    at_q, at_v = mujoco_places(model, task)
    probed = mujoco.MjData(model)
    probed.qpos[at_q], probed.qvel[at_v], _ = task.probe
    with _mujoco_warnings(mujoco):  # what is wrong shows in the numbers
        mujoco.mj_forward(model, probed)
    task.check("mujoco", probed.qacc[at_v])

    def start(name: str, step: float, look: Look) -> Rows:
        stepped, data, count = copy(model), mujoco.MjData(model), count_equal_steps(task.interval, step)
        stepped.opt.integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{name.upper()}")
        stepped.opt.timestep = task.interval / count
        qpos = data.qpos
        qpos[at_q], data.qvel[at_v] = task.q, task.v
        yield task.q, 0, 0
        with _mujoco_warnings(mujoco) as said:
            for taken in count * np.arange(1, len(task.times)):
                for left in range(count, 0, -STEPS_AT_ONCE):
                    mujoco.mj_step(stepped, data, min(left, STEPS_AT_ONCE))
                    if said:
                        raise RunError(said[0])
                    look()
                yield qpos[at_q], int(taken), STAGES[name] * int(taken)

    for name in STAGES:
        yield Peer(f"mujoco {name}", f"mujoco {version('mujoco')}", "step", task, partial(start, name))


def mujoco_model(mujoco: Any, task: PeerTask) -> Any:
    """The model without what MuJoCo adds to massless bodies, and without its tests that reset a state."""
    model = mujoco.MjModel.from_xml_string(task.text)
    for sizes in (model.body_mass, model.body_inertia):
        sizes[sizes <= float(LEAST)] = 0.0
    model.opt.gravity[:] = task.gravity
    names = {name for name in mujoco.mjtDisableBit.__members__ if name.startswith("mjDSBL_")} - {"mjDSBL_GRAVITY"}
    model.opt.disableflags = sum(getattr(mujoco.mjtDisableBit, name).value for name in names)
    return model


def mujoco_places(model: Any, task: PeerTask) -> tuple[Any, Any]:
    """Where the joints are in qpos and qvel."""
    joints = [model.joint(name) for name in task.joints]
    return np.array([joint.qposadr[0] for joint in joints]), np.array([joint.dofadr[0] for joint in joints])


@contextmanager
def _mujoco_warnings(mujoco: Any) -> Iterator[list[str]]:
    """MuJoCo's warnings in a list; otherwise MuJoCo writes them to a file in the working directory."""
    before, said = mujoco.get_mju_user_warning(), []
    mujoco.set_mju_user_warning(said.append)
    try:
        yield said
    finally:
        mujoco.set_mju_user_warning(before)


# --- Drake: a plant in continuous time, alone and without contact geometry, advanced from output time to output time ---
# Left out, after trials on one and three rods: bogacki_shampine3, which took as long as runge_kutta3 at low accuracy and
# several times as long as runge_kutta5 at high; radau3, ten times as long or more; and the methods of first order, which
# are far off. Two faults of Drake 1.51 are met here:
# - After a step that error control rejects, runge_kutta5 begins again with the derivative of the rejected end: the plant's
#   cache does not learn that the state is restored. It goes on rejecting, and its errors are up to some hundred times its
#   tolerance. With fixed steps nothing is rejected, and that is its best.
# - A trial step that overflows is tried again without end. So the first step is a small one.

FIRST_TURN = 1e-3  # rad or so, in the first step
DRAKE: dict[str, tuple[str, Kind]] = {
    "rk5 fixed": ("runge_kutta5", "step"),
    "rk5": ("runge_kutta5", "tolerance"),
    "rk3": ("runge_kutta3", "tolerance"),
}


def drake_peers(task: PeerTask) -> Iterator[Peer]:
    """Drake's integrators. Raises InputError for a model that it does not take."""
    from pydrake.systems.analysis import ApplySimulatorConfig, Simulator, SimulatorConfig  # pyright: ignore[reportMissingImports]

    with _loading("drake"):
        plant = drake_plant(task)
    at_q, at_v = _drake_places(plant, task)
    probed = plant.CreateDefaultContext()
    set_drake(plant, probed, task, *task.probe[:2])
    task.check("drake", plant.EvalTimeDerivatives(probed).get_generalized_velocity().CopyToVector()[at_v])

    def start(scheme: str, kind: Kind, setting: float, look: Look) -> Rows:
        config = SimulatorConfig(integration_scheme=scheme, publish_every_time_step=False)
        config.use_error_control = kind == "tolerance"
        if kind == "tolerance":
            config.accuracy = setting
        else:  # a little longer, so that rounding leaves no last sliver
            config.max_step_size = task.interval / count_equal_steps(task.interval, setting) * (1 + 1e-12)
        simulator = Simulator(plant)
        ApplySimulatorConfig(config, simulator)
        integrator, context = simulator.get_mutable_integrator(), simulator.get_mutable_context()
        set_drake(plant, context, task, task.q, task.v)
        if kind == "tolerance":  # a first step in which little turns
            rates = plant.EvalTimeDerivatives(context)
            parts = rates.get_generalized_position(), rates.get_generalized_velocity()
            v, a = (float(np.abs(part.CopyToVector()).max()) for part in parts)
            integrator.request_initial_step_size_target(FIRST_TURN / (1 + v + math.sqrt(a)))
        yield task.q, 0, 0
        simulator.set_monitor(lambda context: look())
        simulator.Initialize()
        for t in task.times[1:]:
            simulator.AdvanceTo(t)
            counts = integrator.get_num_steps_taken(), integrator.get_num_derivative_evaluations()
            yield plant.GetPositions(context)[at_q], *counts

    for name, how in DRAKE.items():
        yield Peer(f"drake {name}", f"drake {version('drake')}", how[1], task, partial(start, *how))


def drake_plant(task: PeerTask) -> Any:
    """The model of a task in Drake."""
    from pydrake.multibody.parsing import Parser  # pyright: ignore[reportMissingImports]
    from pydrake.multibody.plant import MultibodyPlant  # pyright: ignore[reportMissingImports]

    plant: Any = MultibodyPlant(time_step=0.0)
    Parser(plant).AddModelsFromString(task.text, "urdf")
    if task.support != "world":  # which is the world to Drake
        plant.WeldFrames(plant.world_frame(), plant.GetFrameByName(task.support))
    plant.mutable_gravity_field().set_gravity_vector(task.gravity)
    plant.Finalize()
    return plant


def _drake_places(plant: Any, task: PeerTask) -> tuple[Any, Any]:
    """Where the joints are in positions and velocities."""
    joints = [plant.GetJointByName(name) for name in task.joints]
    return np.array([j.position_start() for j in joints]), np.array([j.velocity_start() for j in joints])


def set_drake(plant: Any, context: Any, task: PeerTask, q: Array, v: Array) -> None:
    """Put positions and velocities (nv,) of the scene into Drake's context."""
    at_q, at_v = _drake_places(plant, task)
    positions, velocities = np.empty((2, len(q)))
    positions[at_q], velocities[at_v] = q, v
    plant.SetPositions(context, positions)
    plant.SetVelocities(context, velocities)


# --- plain SciPy around Pinocchio's aba: what a user would write ----------------------------------------------------
# With the derivatives of aba as the Jacobian Radau took at most a quarter less time, and LSODA twice as long on three
# rods; neither uses them.


def scipy_peers(task: PeerTask) -> Iterator[Peer]:
    """SciPy's methods. Raises InputError for a model that Pinocchio does not load."""
    from scipy.integrate import solve_ivp

    with _loading("pinocchio"):
        model: Any = pinocchio().buildModelFromXML(task.text)
    model.gravity.linear = task.gravity
    names, nv = list(model.names)[1:], model.nv
    places = np.array([names.index(name) for name in task.joints])
    aba, data, none = pinocchio().aba, model.createData(), np.zeros(nv)

    def state(q: Array, v: Array) -> Array:
        y = np.empty((2, nv))
        y[:, places] = q, v
        return y.ravel()

    def derivative(t: float, y: Array, look: Look) -> Array:
        v = y[nv:]
        a = aba(model, data, y[:nv], v, none)
        if not math.isfinite(a @ a):  # SciPy's loops do not end on NaN
            raise RunError(NOT_FINITE)
        look()
        return np.concatenate([v, a])

    def start(method: str, tolerance: float, look: Look) -> Rows:
        begin = state(task.q, task.v)
        options: Any = {"method": method, "rtol": max(tolerance, 100 * EPS), "atol": tolerance}  # of rtol the least
        options |= {"t_eval": task.times, "args": (look,)}
        yield task.q, 0, 0
        with warnings.catch_warnings(action="ignore"):  # the failure says it
            solution = solve_ivp(derivative, task.times[[0, -1]], begin, **options)
        for q in np.reshape(solution.y, (len(begin), -1))[places].T[1:]:
            yield q, 0, solution.nfev
        if not solution.success:
            raise RunError(solution.message)

    task.check("pinocchio", derivative(0.0, state(*task.probe[:2]), lambda: None)[nv + places])
    library = f"scipy {version('scipy')}, pin {version('pin')}"
    for method in ("DOP853", "RK45", "LSODA", "Radau"):
        yield Peer(f"scipy {method.lower()}", library, "tolerance", task, partial(start, method))

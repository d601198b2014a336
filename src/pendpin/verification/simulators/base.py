"""What every peer offers, how it is run and timed, and the check that its model is the scene's."""

import math
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Literal, NamedTuple, Protocol
from xml.etree import ElementTree

import numpy as np

from pendpin.errors import InputError, RunError, one_line
from pendpin.ground.arrays import Array
from pendpin.model.urdf import Element, has_inertia, read_urdf
from pendpin.model.write_models import chain_urdf
from pendpin.scene import Chain, PinModel, UrdfModel

LIMIT = 60.0  # s of processor time that a run may take
SAME = 1e-6  # of the largest acceleration, or of 1 rad/s²: what a peer's may differ by
NOT_FINITE = "its state is not finite"

Kind = Literal["tolerance", "step"]
Look = Callable[[], None]  # at the clock; raises RunError when the time is up


@dataclass(frozen=True, eq=False)
class PeerRun:
    """What one run reached, and what it took."""

    t: Array  # (n,) s, the output times reached
    q: Array  # (n, nv) in pendpin's model order
    steps: int  # 0 where the peer does not say
    evaluations: int  # of accelerations, 0 where the peer does not say
    seconds: float  # of integration with its sampling; building apart
    failure: str | None = None  # why it ended before its time


class Runner(Protocol):
    """A run over scene.times from scene.start, afresh at every call, with a tolerance or a step in s.

    A step is the largest that is taken: the time from output to output is cut into equal steps. Raises InputError for a
    setting that is not a positive number; what else goes wrong is the run's failure.
    """

    def __call__(self, setting: float, limit: float = LIMIT) -> PeerRun: ...


@dataclass(frozen=True)
class Peer:
    """One method of another library, ready to run a scene."""

    name: str
    library: str  # with its version
    kind: Kind
    run: Runner


class Probe(NamedTuple):
    """A state in pendpin's model order and its accelerations, each (nv,): every peer's model has to have the same."""

    q: Array
    v: Array
    a: Array


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
    probe: Probe

    @property
    def interval(self) -> float:
        """The time from output to output, s."""
        return float(self.times[1]) if len(self.times) > 1 else 1.0

    def check(self, library: str, a: Array) -> None:
        """Raise InputError unless these accelerations (nv,) at the probe are right."""
        off = np.abs(a - self.probe.a).max() / max(1.0, np.abs(self.probe.a).max())
        if not off < SAME:
            raise InputError(f"model: {library} makes another model of it: accelerations differ by {off:.1e}")


class Prepared(NamedTuple):
    """A run that is built and not begun."""

    rows: Callable[[Look], Iterator[Array]]  # q (nv,) at each output time after the first
    counts: Callable[[], tuple[int, int]]  # steps and evaluations so far


def peer(task: PeerTask, name: str, library: str, kind: Kind, prepare: Callable[[float], Prepared]) -> Peer:
    """A peer from what prepares its runs."""

    def run(setting: float, limit: float = LIMIT) -> PeerRun:
        if not 0 < setting < math.inf:
            raise InputError(f"{name}: {kind} {setting:g} is not a positive number")
        motion, rows, failure = prepare(setting), [task.q], None
        begin = time.thread_time()

        def look() -> None:
            if time.thread_time() > begin + limit:
                raise RunError(f"took over {limit:g} s")

        try:
            rows.extend(motion.rows(look))
        except Exception as error:  # each library has its own
            failure = one_line(str(error)) or type(error).__name__
        seconds = time.thread_time() - begin
        q = np.array(rows)
        if not (good := np.isfinite(q).all(1)).all():
            q, failure = q[: np.argmin(good)], failure or NOT_FINITE
        if failure:
            failure += f"; it got to {task.times[len(q) - 1]:g} s"
        return PeerRun(task.times[: len(q)], q, *motion.counts(), seconds, failure)

    return Peer(name, library, kind, run)


@contextmanager
def loading(library: str) -> Iterator[None]:
    """What a library raises in the block is said as InputError."""
    try:
        yield
    except Exception as error:
        raise InputError(f"model: {library} does not load it: {error}") from None


# --- one URDF text that MuJoCo --------------------------------------------------------------------------------------

LEAST = 1e-15  # kg and kg m² of a moving body: what MuJoCo takes
_TENSOR = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")


def same_for_all(model: Chain | UrdfModel | PinModel) -> tuple[str, str]:
    """The model that pendpin simulates, without what is only drawn and what it leaves out, and the link it hangs on.

    MuJoCo gives every massless body the least that it takes. Where such a link is fixed to another and carries none, it
    is left out; the others say that they have no mass, as MuJoCo would else place its centre apart.
    """
    if isinstance(model, PinModel):
        raise InputError("model: other simulators take a chain of rods or a URDF, and this is a pin.Model")
    robot = ElementTree.fromstring(chain_urdf(model) if isinstance(model, Chain) else read_urdf(model).text)
    for joint in robot.findall("joint"):
        _drop(joint, joint.findall("dynamics"))
    _drop(robot, robot.findall("mujoco"))
    while tips := _massless_tips(robot):
        _drop(robot, tips)
    hanging = {child.get("link") for child in robot.iterfind("joint/child")}
    root = next(name for link in robot.iterfind("link") if (name := link.get("name", "")) not in hanging)
    for link in robot.findall("link"):
        _drop(link, link.findall("visual"))
        if link.get("name") == root:
            _drop(link, link.findall("inertial"))  # it stands still
        elif link.find("inertial") is None:
            inertial = ElementTree.SubElement(link, "inertial")
            ElementTree.SubElement(inertial, "mass", value="0")
            ElementTree.SubElement(inertial, "inertia", dict.fromkeys(_TENSOR, "0"))
    least = {"boundmass": repr(LEAST), "boundinertia": repr(LEAST)}
    ElementTree.SubElement(ElementTree.SubElement(robot, "mujoco"), "compiler", least)
    return ElementTree.tostring(robot, encoding="unicode"), root


def _drop(parent: Element, children: list[Element]) -> None:
    for child in children:
        parent.remove(child)


def _massless_tips(robot: Element) -> list[Element]:
    """The massless links that are fixed to another and carry none, with their joints."""
    carriers = {parent.get("link") for parent in robot.iterfind("joint/parent")}
    fixed = {c.get("link"): joint for joint in robot.iterfind("joint[@type='fixed']") for c in joint.iterfind("child")}
    tips = []
    for link in robot.iterfind("link"):
        name = link.get("name")
        if name in fixed and name not in carriers and not has_inertia(link):
            tips += [link, fixed[name]]
    return tips

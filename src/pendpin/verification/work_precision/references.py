"""The reference solution of a motion: two computations by different families of methods, which must agree.

Each is computed twice, with its finest setting and a coarser one; the difference estimates its error. If the two differ by
much more than these errors, one of them is wrong, and there is no reference.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from pendpin.dynamics.acting import acting
from pendpin.dynamics.compiling import compilable
from pendpin.dynamics.dynamics import bind
from pendpin.effects import Gravity
from pendpin.engines import Compiled
from pendpin.equations import exact
from pendpin.errors import InputError, attempt
from pendpin.ground.arrays import EPS, Array
from pendpin.integrators import FEW_JOINTS, MAX_JOINTS, uncompiled
from pendpin.model.build import build, start_state
from pendpin.model.kinematics import marks, scale, tip_distance
from pendpin.runs.simulate import run_within
from pendpin.scene import Scene
from pendpin.trajectory import RunRecord

SAME = 1e-9  # of the largest rate: difference of two equations by rounding
LARGE = 200  # joints: a Jacobian of more takes minutes, in which nothing stops it
STATES = 8  # at which equations are compared
CONTRADICTION = 100.0  # times the estimated errors of the two, and their rounding


@dataclass(frozen=True, eq=False)
class Solution:
    """One computation of a motion, as far as it came."""

    name: str  # its family, method and equations
    tips: Array  # (n, rods, 3) m, W
    doubt: Array  # (n,) estimated error: the distance to its own coarser run, over the length
    rounding: float  # over the length
    halted: bool = False  # whether it was stopped before the end of the scene


@dataclass(frozen=True, eq=False)
class Reference:
    """The motion up to the time at which it is no longer accurate enough."""

    tips: Array  # (n, rods, 3) m, W, of the first solution
    t: Array  # (n,) s
    error: float  # how far the two solutions are apart at most, over the length
    solutions: tuple[str, str]
    duration: float  # s, of the scene
    halted: bool = False  # whether it ends because longer runs would take too long

    @property
    def horizon(self) -> float:
        """The end of the reference, s since the start."""
        return float(self.t[-1])


Maker = Callable[[Scene, float], Solution]  # with the limit of each run, s


def reference(scene: Scene, error: float, solutions: Sequence[Maker] | None = None, limit: float = np.inf) -> Reference:
    """The motion of a scene, to within `error` of its length, at its output times up to its horizon.

    The first two of `solutions` that can run the scene are used; by default the exact solution if there is one, a power
    series, a Runge-Kutta method, collocation, if possible each on different equations. Each takes two runs, which are
    stopped after `limit` s of processor time.
    Raises InputError if fewer than two can run the scene, if they contradict each other, or do not agree to `error`.
    """
    length, computed = scale(build(scene.model)), list[Solution]()
    for maker in SOLUTIONS if solutions is None else solutions:
        solution, _ = attempt(partial(maker, scene, limit))
        computed += [solution] if solution else []  # else it is not for this scene
        if len(computed) == 2:
            break
    else:
        few = f"two families of methods are needed, and only {len(computed)} can run this scene"
        raise InputError(f"no reference solution: {few}")
    one, other = computed
    n = min(len(one.tips), len(other.tips))
    gap = np.maximum.accumulate(tip_distance(one.tips[:n], other.tips[:n], length))
    doubt = np.maximum.accumulate(one.doubt[:n] + other.doubt[:n]) + one.rounding + other.rounding
    if (against := gap > CONTRADICTION * doubt).any():
        i = int(np.argmax(against))
        apart = f"differ by {gap[i]:.1e} of the length at {scene.times[i]:.3g} s"
        errors = f"where their estimated errors are {doubt[i]:.1e}: one of them is wrong"
        raise InputError(f"no reference: {one.name} and {other.name} {apart}, {errors}")
    good = int(np.argmax(np.append(gap > error, True)))
    halted = good == n and (one.halted or other.halted)
    if good < min(2, len(scene.times)):
        slow = "the first output time takes too long; give more samples, or take --thorough"
        apart = f"two methods agree to {gap[:2].max():.1e} of the length at best, not {error:g}"
        raise InputError(f"no reference: {slow if halted else apart}")
    known = float(max(gap[good - 1], EPS))
    return Reference(one.tips[:good], scene.times[:good], known, (one.name, other.name), scene.duration, halted)


def by_elliptic_functions(scene: Scene, limit: float) -> Solution:
    """A single rod under gravity that is a spherical pendulum or swings in a plane. Raises InputError for any other."""
    model, effects = build(scene.model), scene.effects
    if model.chain is None or model.chain.n != 1 or len(effects) != 1 or not isinstance(effects[0], Gravity):
        raise InputError("no exact solution")
    field = effects[0].field(0.0)
    if not field[2] < 0 or field[:2].any():
        raise InputError("no exact solution")
    gravity, (q, v), rod = float(-field[2]), start_state(model, scene.start), model.rods[0].inertia
    in_plane = next((i for i in (0, 1) if not q[1 - i] and not v[1 - i]), None)
    if rod is None or rod.h <= 0 or (rod.I3 and in_plane is None):
        raise InputError("no exact solution")
    axis = in_plane or 0
    reduced = (rod.I1, rod.I2)[axis] / rod.m / rod.h + rod.h  # I1 = I2 where I3 = 0
    if rod.I3:
        angles = np.zeros((len(scene.times), 2))
        angles[:, axis] = exact.planar(q[axis], v[axis], reduced, gravity, scene.times)
        direction = exact.direction(angles)
    else:
        direction = exact.spherical(exact.direction(q), exact.direction_rate(q, v), reduced, gravity, scene.times)
    tips, exactly = direction[:, None] * scale(model), np.zeros(len(direction))
    return Solution("elliptic functions in 100 digits", tips, exactly, EPS)


def on_recursion(scene: Scene) -> Scene:
    """The scene on the recursion in machine code where it can be compiled, which is fast."""
    compiles = compilable(model := build(scene.model), acting(model, scene.effects))
    return scene.with_solver(engine="compiled") if compiles else scene


def _integrate(
    family: str,
    method: str,
    fine: float,
    coarse: float,
    equations: Callable[[Scene], Scene] = on_recursion,
    most: float = np.inf,
) -> Maker:
    """A method at two tolerances, on a choice of equations (series have their own), for up to `most` joints."""

    def solve(scene: Scene, limit: float) -> Solution:
        model = build(scene.model)
        if len(model.joints) > most:
            raise InputError("too many joints")
        scene = scene.by(method, fine)
        if method == "taylor":
            scene, on = scene.with_solver(engine="auto"), "of the recursion"
        else:
            scene = equations(scene)
            on = f"on {bind(scene).engine.name}"
        runs = [run_within(limit, scene.by(method, setting)) for setting in (fine, coarse)]
        n = min(len(run.t) for run in runs)
        one, other = (marks(model, run.tips[:n], run.q[:n]) for run in runs)
        doubt, rounding = tip_distance(one, other, scale(model)), EPS * runs[0].stats.steps
        return Solution(f"{family} ({method}) {on}", one, doubt, rounding, n < len(scene.times))

    return solve


def refuse_other_equations(scene: Scene, run: RunRecord) -> None:
    """Raise InputError if machine code, where there is any, differs from Pinocchio's equations at states of a run."""
    engine = bind(on_recursion(scene)).engine
    if not isinstance(engine, Compiled):
        return
    one, other = (which.derivative(lambda t: None)[0] for which in (engine, engine.base))
    for i in np.linspace(0, len(run.t) - 1, STATES, dtype=int):
        y = engine.pack(run.q[i], run.v[i])
        rates = np.zeros((2, len(y)))
        for row, derivative in zip(rates, (one, other), strict=True):
            derivative(row, float(scene.times[i]), y)
        if (off := np.abs(np.subtract(*rates)).max() / max(1.0, np.abs(rates).max())) > SAME:
            raise InputError(f"no reference: {engine.name} and {engine.base.name} differ by {off:.1e} in y'")


# Series of more joints compile long; Pinocchio's accelerations are slower than the recursion, and independent of it.
by_series = _integrate("power series", "taylor", 1e-18, 1e-16, most=MAX_JOINTS)
by_runge_kutta = _integrate("Runge-Kutta", "dop853", 1e-14, 1e-13, uncompiled)
by_collocation = _integrate("collocation", "radau", 1e-11, 1e-10)
SOLUTIONS: tuple[Maker, ...] = (by_elliptic_functions, by_series, by_runge_kutta, by_collocation)
QUICK: tuple[Maker, ...] = (  # the same within a limit of time
    by_elliptic_functions,
    _integrate("power series", "taylor", 1e-18, 1e-16, most=FEW_JOINTS),
    _integrate("Runge-Kutta", "dop853", 1e-14, 1e-13),
    _integrate("multistep", "lsoda", 1e-13, 1e-12, most=LARGE),
    _integrate("order 5", "rk45", 1e-12, 1e-11),  # for scenes that are too large for other families
)

"""Random scenes in which something acts for a short time, and their motion by an integration that knows when.

Wind with gusts and drag across the flow; a pivot moved by a pulse in a CSV; pulses and tables in a torque of one's own;
sampled torques. One rod is integrated here: Lagrange's equations, drag by Gauss points crowded where the flow is least, the
spline of SciPy, SciPy's DOP853 from one instant of change to the next. Two rods are run by pendpin at 1e-13, twice, with
hundreds of output times around the change; where a torque joins points of a table, from one point to the next.
"""

import math
import tempfile
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from random import Random
from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import solve_ivp
from scipy.interpolate import make_interp_spline

import pendpin as pp
from pendpin import effects as fx
from pendpin.effects.pace import Pace

KINDS = {"wind": 25, "track": 35, "pulse": 15, "table": 15, "sampled": 10}
SHAPES: dict[str, Callable[[Any], Any]] = {
    "smooth step": lambda s: s * s * (3 - 2 * s),
    "minimum jerk": lambda s: s**3 * (10 - 15 * s + 6 * s * s),
    "bump": lambda s: (1 - np.cos(2 * np.pi * s)) / 2,
    "ramp": lambda s: s,
    "half sine": lambda s: np.sin(np.pi * s),
}
NODES, WEIGHTS = np.polynomial.legendre.leggauss(60)
SAMPLES = (2, 20, 200)
TOLERANCE = 1e-13
CLOSE = 300  # output times around the change


class Timed(NamedTuple):
    """A scene, when it changes abruptly, and the torque of time (if it has one) with the place of its joint."""

    kind: str
    scene: pp.Scene
    changes: np.ndarray  # s
    torque: Callable[[float], float] | None = None
    joint: int = 0


def timed_case(seed: int, number: int) -> Timed:
    """The scene of a number, with the method and accuracy that are asked."""
    random = Random(f"timed {seed} {number}")
    kind = random.choices(list(KINDS), list(KINDS.values()))[0]
    count, duration = random.choice((1, 1, 2)), random.uniform(1.5, 3 if kind in ("pulse", "table", "sampled") else 8)
    rods = [
        pp.Rod(length=random.uniform(0.3, 1.5), mass=random.uniform(0.3, 3), radius=random.uniform(0.01, 0.04))
        for _ in range(count)
    ]
    positions = [random.uniform(-0.8, 0.8) for _ in range(2 * count)]
    rates = [random.gauss(0, 0.7) * random.choice((0, 1)) for _ in range(2 * count)]
    effects: list[fx.Effect] = [fx.Gravity()]
    if random.random() < 0.3:
        effects.append(fx.Viscous(coefficient=random.uniform(0.001, 0.1)))
    if kind == "wind" or random.random() < 0.15:
        effects.append(_wind(random))
    begin, name = random.uniform(0.1, 0.8) * duration, "theta" if random.random() < 0.5 else "phi"
    joint = name if count == 1 else f"{name}_{random.choice((1, 2))}"
    changes, torque = np.zeros(0), None
    if kind == "track":
        track, changes = _track(random, begin, duration, f"{seed}_{number}")
        effects.append(track)
    elif kind in ("pulse", "table"):
        torque, changes, shortest = (_pulse if kind == "pulse" else _table)(random, begin, duration)
        declared = random.choice(({}, {"gradual": True}, {"shortest": shortest, "gradual": True}))
        effects.append(fx.Torque(lambda t, q, v: np.array([torque(t)]), joints=[joint], **declared))
    elif kind == "sampled":
        gain, every = random.uniform(0.1, 1.0), 10 ** random.uniform(-2, -0.7)
        changes = every * np.arange(1, math.ceil(duration / every))
        law = lambda t, q, v: np.array([-gain * q[0] - 0.2 * gain * v[0] + 0.1 * math.sin(3 * t)])  # noqa: E731
        effects.append(fx.Torque(law, joints=[joint], every=every))
    method = random.choices(("auto", "dop853", "rk45", "lsoda"), (12, 4, 2, 1))[0]
    solver = pp.Solver(samples=random.choice(SAMPLES), method=method, accuracy=10 ** random.uniform(-8.5, -3))
    start = pp.Start(positions=positions, velocities=rates)
    scene = pp.Scene(duration=duration, model=pp.Chain(rods=rods), start=start, effects=effects, solver=solver)
    return Timed(kind, scene, changes, torque, 0 if name == "theta" else 1)


def _wind(random: Random) -> fx.Drag:
    gust = {"gust": tuple(random.gauss(0, 2) for _ in range(3)), "frequency": 10 ** random.uniform(-0.5, 1.7)}
    wind = tuple(random.gauss(0, 2) for _ in range(3))
    return fx.Drag(density=10 ** random.uniform(0, 3), wind=wind, **(gust if random.random() < 0.6 else {}))


def _track(random: Random, begin: float, duration: float, name: str) -> tuple[fx.Support, np.ndarray]:
    """A pulse of the pivot in 6 to 40 rows, 1 to 10 ms apart, with all digits or with five or six decimals."""
    interval, points, size = round(random.uniform(1e-3, 1e-2), 4), random.randint(6, 40), random.uniform(0.003, 0.05)
    rows, digits = np.arange(math.ceil(duration / interval) + 2), random.choice((None, None, 6, 5))
    first = min(int(begin / interval), len(rows) - points - 2)
    x = size * SHAPES[random.choice(list(SHAPES))](np.clip((rows - first) / points, 0, 1))
    way = np.array([random.gauss(0, 1) for _ in range(3)])
    path = np.outer(x, way / np.linalg.norm(way))
    path = path if digits is None else np.round(path, digits)
    file = Path(tempfile.gettempdir()) / f"timed_{name}.csv"
    lines = (f"{i * interval:.10g},{p[0]!r},{p[1]!r},{p[2]!r}" for i, p in zip(rows, path.tolist(), strict=True))
    file.write_text("\n".join(lines))
    return fx.Support(csv=file), np.array([float(f"{i * interval:.10g}") for i in rows])


def _pulse(random: Random, begin: float, duration: float) -> tuple[Callable[[float], float], np.ndarray, float]:
    width = 10 ** random.uniform(-2.3, -0.7)
    size = random.uniform(0.002, 0.04) / width
    shapes: dict[str, Callable[[float], float]] = {
        "bell": lambda t: size * math.exp(-(((t - begin) / width * 4) ** 2)),
        "rectangle": lambda t: size * (begin <= t < begin + width),
        "half sine": lambda t: size * math.sin(math.pi * (t - begin) / width) if begin < t < begin + width else 0.0,
        "triangle": lambda t: size * max(0.0, 1 - abs(t - begin) / width),
    }
    return shapes[random.choice(list(shapes))], np.array([begin - width, begin, begin + width]), width / 4


def _table(random: Random, begin: float, duration: float) -> tuple[Callable[[float], float], np.ndarray, float]:
    """A torque that joins the points of a table by straight lines: a pulse, or noise."""
    interval = random.uniform(1e-3, 2e-2)
    t = np.arange(0, duration + 2 * interval, interval)
    noise = np.random.default_rng(random.randrange(10**6))
    width = 10 ** random.uniform(-1.5, -0.5)
    bell = random.uniform(0.002, 0.04) / width * np.exp(-(((t - begin) / width * 2) ** 2))
    values = bell if random.random() < 0.5 else 0.3 * np.cumsum(noise.normal(size=len(t))) * math.sqrt(interval)
    return lambda now: float(np.interp(now, t, values)), t, interval


class _Joined(fx.Torque):
    """A torque that is smooth between known times in s: the integration restarts at each."""

    points: tuple[float, ...]

    def pace(self, begin: float, end: float, negligible: float) -> Pace:
        points = np.array([t for t in self.points if begin < t < end])
        return Pace(points, np.full(len(points) + 1, np.inf))


# --- the true motion ------------------------------------------------------------------------------------------------


def timed_tips(case: Timed) -> tuple[np.ndarray, float]:
    """Tips (n, rods, 3) in m, W, at the output times, and their doubt in m."""
    if len(case.scene.model.all_rods) == 1 and case.kind != "sampled":
        return _integrate_one_rod(case), 1e-11
    times = np.array(case.scene.times)
    span = case.changes[[0, -1]] if len(case.changes) else np.zeros(2)
    close = np.linspace(max(span[0], 0), min(span[1], case.scene.duration), CLOSE)
    dense = np.unique(np.concatenate([times, close]))
    methods = (
        ("dop853", TOLERANCE),
        ("dop853", 3 * TOLERANCE) if case.kind in ("pulse", "table") else ("rk45", TOLERANCE),
    )
    grids = (dense, np.unique(np.concatenate([times, close[:-1] + np.diff(close) / 3])))
    scene = case.scene
    if case.kind == "table":
        joined = [
            _Joined(effect.function, joints=effect.joints, gradual=True, points=tuple(case.changes.tolist()))
            if isinstance(effect, fx.Torque)
            else effect
            for effect in scene.effects
        ]
        scene = scene.replace(effects=joined)
    one, other = (
        pp.simulate(scene, method=method, tolerance=setting, times=grid).tips[np.searchsorted(grid, times)]
        for (method, setting), grid in zip(methods, grids, strict=True)
    )
    return one, float(np.linalg.norm(one - other, axis=-1).max())


def _integrate_one_rod(case: Timed) -> np.ndarray:
    scene, rod = case.scene, case.scene.model.all_rods[0]
    by_kind = {effect.kind: effect for effect in scene.effects}
    drag, viscous, support = (by_kind.get(kind) for kind in ("drag", "viscous", "support"))
    p, damping = rod.properties, viscous.coefficient if viscous else 0.0
    J, I3 = p.I1 + p.m * p.h**2, p.I3
    spline = None
    if support:
        rows = np.loadtxt(support.csv, delimiter=",")
        spline = make_interp_spline(rows[:, 0], rows[:, 1:], k=5)
        velocity, acceleration = spline.derivative(1), spline.derivative(2)

    def rate(t: float, y: np.ndarray) -> np.ndarray:
        (sa, sb), (ca, cb), v = np.sin(y[:2]), np.cos(y[:2]), y[2:]
        axes = np.array([[0.0, -ca * cb, sa * cb], [cb, sa * sb, ca * sb]])  # changes of the direction with both angles
        along, field = np.array([sb, -sa * cb, -ca * cb]), np.array([0.0, 0.0, -9.81])
        load = -damping * v
        if spline is not None:
            field = field - acceleration(t)
        if drag:
            air = np.array(drag.wind) + (np.array(drag.gust) * math.sin(drag.frequency * t) if drag.gust else 0.0)
            air = air - (velocity(t) if spline is not None else 0.0)
            across, turning = air - along * (along @ air), v @ axes
            cut = min(max(turning @ across / max(turning @ turning, 1e-300) / rod.length, 0.0), 1.0)
            near = ((1 + NODES) / 2) ** 2
            for s, length in ((cut * (1 - near), cut), (cut + (1 - cut) * near, 1 - cut)):
                u = s[:, None] * rod.length * turning - across
                pull = -drag.quadratic * rod.radius * np.linalg.norm(u, axis=1)[:, None] * u
                load = load + rod.length**2 * axes @ ((WEIGHTS * (1 + NODES) / 2 * length * s) @ pull)
        load = load + p.m * p.h * axes @ field
        if case.torque is not None:
            load[case.joint] += case.torque(t)
        M, twist = J * cb**2 + I3 * sb**2, (J - I3) * cb * sb
        return np.array([*v, (load[0] + 2 * twist * v[0] * v[1]) / M, (load[1] - twist * v[0] ** 2) / J])

    times, y = (
        np.array(scene.times),
        np.concatenate([np.array(scene.start.positions), np.array(scene.start.velocities)]),
    )
    inside = case.changes[(case.changes > 0) & (case.changes < scene.duration)]
    if case.kind == "track":  # where the track rests, its rows are no corners
        inside = inside[np.abs(acceleration(inside)).max(1) > 1e-13]
    bounds, rows = np.concatenate([[0.0], inside, [scene.duration]]), [y[:2]]
    for a, b in pairwise(bounds):
        due = times[(times > a) & (times <= b)]
        t = np.unique(np.concatenate([due, [b]]))
        low, high = (a, b) if case.torque is None else (a + 1e-15 * scene.duration, b - 1e-15 * scene.duration)
        one_sided = lambda s, y, low=low, high=high: rate(min(max(s, low), high), y)  # noqa: E731  its own side of a jump
        found = solve_ivp(one_sided, (a, b), y, "DOP853", t, rtol=TOLERANCE, atol=TOLERANCE).y
        rows += list(found[:2, np.searchsorted(t, due)].T)
        y = found[:, -1]
    q = np.array(rows)
    sines, cosines = np.sin(q), np.cos(q)
    along = [sines[:, 1], -sines[:, 0] * cosines[:, 1], -cosines[:, 0] * cosines[:, 1]]
    return rod.length * np.stack(along, -1)[:, None]

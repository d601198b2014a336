"""Reference motions of chains, far below the rounding of doubles, by integrators that pendpin does not use.

A scene without contacts is first computed by DOP853 and RK45 on compiled equations at their finest; two that agree a
hundred times better than asked are enough. Else the scene's numbers are taken as the doubles that they are; what follows
from them (rod properties, accelerations by the articulated-body recursion on symbols) has 19 digits, or 33: Taylor series
by heyoka in that precision. Quadratic drag, and dry friction and stops on a single rod, whose two axes do not couple: DOP853
in 19 digits, from event to event, written here. Chains with contacts: DOP853 and RK45 of pendpin at their finest, whose
events are found by one and the same search. Each motion is computed twice, by two methods, with the start off by ten units
of rounding, or with a looser tolerance; their distance estimates its error.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import heyoka as hy
import mpmath
import numpy as np
from scipy.integrate import DOP853

import pendpin as pp
from pendpin import effects as fx
from pendpin.model.build import Model, build, start_state
from pendpin.model.kinematics import chain_length, poses, tip_distance, tips
from reference_equations import accelerations

LONG = np.longdouble
QUAD = hy.real128
LONG_EPS, QUAD_EPS = 1.1e-19, 1.9e-34
COMPACT = 2  # joints, above which the code is compiled in compact form
PATIENCE = 60.0  # s, for one of two runs
FAR = 1e3  # rad, beyond which 33 digits are needed for whole turns
CONTACTS = (fx.DryFriction, fx.Stop)
A, B, C = (np.array(x[:12], dtype=LONG) for x in (DOP853.A, DOP853.B, DOP853.C))
E3, E5 = (np.array(x, dtype=LONG) for x in (DOP853.E3, DOP853.E5))


class Reference(NamedTuple):
    """Tips (n, rods, 3) in m, W, and how far two computations of them are apart, (n,) over the length."""

    tips: np.ndarray
    doubt: np.ndarray


def reference(scene: pp.Scene, doubt: float = 0.0) -> Reference:
    """The motion of a chain at its output times; computed in more digits if two methods differ by more than `doubt`."""
    model = build(scene.model)
    touching = any(isinstance(effect, CONTACTS) for effect in scene.effects)
    if not touching or len(scene.model.all_rods) > 1:
        found = _by_two_methods(scene, 1e-12 if touching else 1e-13, "auto" if touching else "compiled")
        if touching or found.doubt[-1] <= doubt:
            return found
    smooth = [effect for effect in scene.effects if not isinstance(effect, CONTACTS)]
    if _all_smooth(scene):
        number = QUAD if np.abs(start_state(model, scene.start)[0]).max() > FAR else LONG
        series = _series(scene, model, number, 1e-22 if number is QUAD else 1e-19)
        runs = [_by_series(scene, model, series, number, units) for units in (0.0, 10.0)]
    else:
        rate = _compiled(scene, model, smooth)
        runs = [_by_steps(scene, model, rate, tolerance) for tolerance in (3e-16, 1e-14)]
    return _compared(scene, *(tips(model, poses(model, q)) for q in runs))


def _by_two_methods(scene: pp.Scene, tolerance: float, engine: str) -> Reference:
    """The motion by DOP853 and by RK45 of pendpin on one engine."""
    scene, runs = scene.model_copy(update={"solver": scene.solver.with_settings(engine=engine)}), []
    for method in ("rk45", "dop853"):
        try:
            runs.append(pp.simulate(scene.by(method, tolerance), limit=PATIENCE).tips)
        except pp.RunError as error:
            runs.append(error.partial.tips)
    return _compared(scene, *runs)


def _all_smooth(scene: pp.Scene) -> bool:
    return all(effect.smooth for effect in scene.effects)


def _compared(scene: pp.Scene, one: np.ndarray, other: np.ndarray) -> Reference:
    """Tips (n, rods, 3) of two computations, as far as they go."""
    n = min(len(one), len(other))
    gap = np.append(
        tip_distance(one[:n], other[:n], chain_length(build(scene.model))), np.full(len(scene.times) - n, np.inf)
    )
    padded = np.concatenate([one[:n], np.repeat(one[n - 1 : n], len(scene.times) - n, 0)])
    return Reference(padded, np.maximum.accumulate(gap))


# --- smooth motions -------------------------------------------------------------------------------------------------


def _series(scene: pp.Scene, model: Model, number: Any, tolerance: float) -> Any:
    """heyoka's integrator of the scene."""
    y, a = accelerations(scene, model, scene.effects, number)
    nv = len(model.joints)
    return hy.taylor_adaptive(
        list(zip(y, [*y[nv:], *a], strict=True)),
        np.zeros(2 * nv, dtype=number),
        tol=number(tolerance),
        fp_type=number,
        compact_mode=nv > COMPACT,
    )


def _by_series(scene: pp.Scene, model: Model, series: Any, number: Any, units: float) -> np.ndarray:
    """Angles (n, nv) less whole turns, from a start that is off by so many of its units of rounding."""
    nv, unit = len(model.joints), LONG_EPS if number is LONG else QUAD_EPS
    state = np.concatenate(start_state(model, scene.start))
    shift = units * unit * np.abs(state)  # what is exactly 0, as in a plane motion, stays 0
    series.time = number(0.0)
    series.state[:] = [number(float(x)) + number(float(off)) for x, off in zip(state, shift, strict=True)]
    rows = [_less_turns(series.state[:nv])]
    for t in scene.times[1:]:
        if series.propagate_until(number(float(t)))[0] != hy.taylor_outcome.time_limit:
            break
        rows.append(_less_turns(series.state[:nv]))
    return np.array(rows)


def _less_turns(q: Any) -> np.ndarray:
    with mpmath.workdps(40):
        turn = 2 * mpmath.pi
        exact = [mpmath.mpf(str(x) if not isinstance(x, float) else x) for x in q]
        return np.array([float(x - turn * mpmath.nint(x / turn)) for x in exact])


# --- drag, friction and stops ---------------------------------------------------------------------------------------


def _compiled(scene: pp.Scene, model: Model, effects: Any) -> Callable[[Any, np.ndarray], np.ndarray]:
    """Accelerations (nv,) at a time and state (2 nv,), in 19 digits."""
    y, a = accelerations(scene, model, effects, LONG)
    function = hy.cfunc(list(a), list(y), fp_type=LONG, compact_mode=True)
    return lambda t, y: function(y, time=LONG(t))


class Axes(NamedTuple):
    """Dry friction and stops on the two axes of a single rod, (2,) each."""

    kinetic: np.ndarray
    static: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
    restitution: np.ndarray


def _axes(scene: pp.Scene, model: Model) -> Axes:
    nv = len(model.joints)
    out = Axes(np.zeros(nv), np.zeros(nv), np.full(nv, -np.inf), np.full(nv, np.inf), np.zeros(nv))
    for effect in scene.effects:
        if isinstance(effect, CONTACTS):
            for i in range(nv) if effect.joints is None else [model.index(name, "") for name in effect.joints]:
                if isinstance(effect, fx.Stop):
                    out.lower[i] = -np.inf if effect.lower is None else effect.lower
                    out.upper[i] = np.inf if effect.upper is None else effect.upper
                    out.restitution[i] = effect.restitution
                else:
                    out.kinetic[i] = effect.kinetic
                    out.static[i] = effect.kinetic if effect.static is None else effect.static
    return out


def _by_steps(scene: pp.Scene, model: Model, smooth: Callable[[Any, np.ndarray], np.ndarray], tolerance: float) -> Any:
    """Angles (n, nv), by DOP853 from event to event."""
    nv, axes = len(model.joints), _axes(scene, model)
    touching = bool(axes.static.any() or np.isfinite(axes.lower).any() or np.isfinite(axes.upper).any())
    assert not touching or nv == 2, "contacts of a single rod only"
    y, t = np.concatenate(start_state(model, scene.start)).astype(LONG), LONG(0)
    motion = _Stepper(scene, smooth, axes, nv, tolerance)
    rows, h = [y[:nv].astype(float)], LONG(1e-4 * scene.duration)
    mode = motion.mode_after(t, y)
    for end in scene.times[1:].astype(LONG):
        while t < end:
            t, y, h, mode = motion.step(t, y, min(h, end - t), mode, end)
        rows.append(y[:nv].astype(float))
    return np.array(rows)


class _Stepper:
    """Steps of DOP853 that end at events. A mode holds per axis: the sign of sliding, 0 for held, 2 for no friction."""

    def __init__(self, scene: pp.Scene, smooth: Any, axes: Axes, nv: int, tolerance: float) -> None:
        self.smooth, self.axes, self.nv, self.tolerance = smooth, axes, nv, LONG(tolerance)
        rod = scene.model.all_rods[0].properties
        self.J1, self.J2, self.I3 = rod.I1 + rod.m * rod.h**2, rod.I2 + rod.m * rod.h**2, rod.I3
        self.touching = bool(axes.static.any() or np.isfinite(axes.lower).any() or np.isfinite(axes.upper).any())
        self.longest = LONG(scene.duration / 200)

    def mass(self, q: np.ndarray) -> np.ndarray:
        return np.array([self.J1 * np.cos(q[1]) ** 2 + self.I3 * np.sin(q[1]) ** 2, LONG(self.J2)])

    def rate(self, t: Any, y: np.ndarray, mode: np.ndarray) -> np.ndarray:
        nv = self.nv
        v = y[nv:]
        a = self.smooth(t, np.ascontiguousarray(y))
        if self.touching:
            a = a - np.where(abs(mode) == 1, mode * self.axes.kinetic, 0) / self.mass(y[:nv])
            v, a = np.where(mode == 0, 0, v), np.where(mode == 0, 0, a)
        return np.concatenate([v, a])

    def mode_after(self, t: Any, y: np.ndarray) -> np.ndarray:
        """The mode of a state: axes at rest are held where friction or a stop can hold them. Impacts are applied to y."""
        nv, axes = self.nv, self.axes
        mode = np.full(nv, 2)
        if not self.touching:
            return mode
        q, v = y[:nv], y[nv:]
        for i in range(nv):
            at_upper, at_lower = q[i] >= axes.upper[i], q[i] <= axes.lower[i]
            if (at_upper and v[i] > 0) or (at_lower and v[i] < 0):
                v[i] = -axes.restitution[i] * v[i]
        pull = self.smooth(t, np.ascontiguousarray(y)) * self.mass(q)
        for i in range(nv):
            at_upper, at_lower = q[i] >= axes.upper[i], q[i] <= axes.lower[i]
            if v[i] == 0:
                stop = (at_upper and pull[i] > 0) or (at_lower and pull[i] < 0)
                if stop or (axes.static[i] > 0 and abs(pull[i]) <= axes.static[i]):
                    mode[i] = 0
                else:
                    mode[i] = np.sign(pull[i]) if axes.static[i] > 0 else 2
            elif axes.static[i] > 0:
                mode[i] = np.sign(v[i])
        return mode

    def guards(self, t: Any, y: np.ndarray, mode: np.ndarray) -> np.ndarray:
        """Above 0 until an event."""
        nv, axes, big = self.nv, self.axes, LONG(1)
        q, v = y[:nv], y[nv:]
        slide = np.where(abs(mode) == 1, mode * v, big)
        inside = np.where(mode != 0, np.minimum(axes.upper - q, q - axes.lower), big)
        pull = self.smooth(t, np.ascontiguousarray(y)) * self.mass(q) if (mode == 0).any() else np.zeros(nv)
        up, low = np.where(q >= axes.upper, np.inf, axes.static), np.where(q <= axes.lower, np.inf, axes.static)
        hold = np.where(mode == 0, np.minimum(up - pull, pull + low), big)
        return np.concatenate([slide, np.minimum(inside, 1e3), np.minimum(hold, 1e3)])

    def step(self, t: Any, y: np.ndarray, h: Any, mode: np.ndarray, end: Any) -> tuple[Any, ...]:
        h = min(h, self.longest)
        while True:
            new, error = self.advanced(t, y, h, mode)
            if error <= 1:
                break
            h = h * max(LONG(0.2), LONG(0.9) * error ** (LONG(-1) / 8))
        grown = h * min(LONG(4), LONG(0.9) * max(error, LONG(1e-12)) ** (LONG(-1) / 8))
        if not self.touching or (self.guards(t + h, new, mode) >= 0).all():
            return t + h if h < end - t else end, new, grown, mode
        low, high = LONG(0), h
        for _ in range(70):
            middle = (low + high) / 2
            found, _ = self.advanced(t, y, middle, mode)
            fired = (self.guards(t + middle, found, mode) < 0).any()
            low, high = (low, middle) if fired else (middle, high)
        new, _ = self.advanced(t, y, high, mode)
        hit = self.guards(t + high, new, mode) < 0
        for i in np.flatnonzero(hit[: self.nv]):
            new[self.nv + i] = 0
        for i in np.flatnonzero(hit[self.nv : 2 * self.nv]):
            q = new[i]
            new[i] = (
                self.axes.upper[i] if abs(self.axes.upper[i] - q) < abs(q - self.axes.lower[i]) else self.axes.lower[i]
            )
            if abs(new[self.nv + i]) < 1e-9 * self.axes.restitution[i]:
                new[self.nv + i] = 0
        return t + high, new, h, self.mode_after(t + high, new)

    def advanced(self, t: Any, y: np.ndarray, h: Any, mode: np.ndarray) -> tuple[np.ndarray, Any]:
        """The state after a step, and its error over the tolerance."""
        k = np.zeros((13, len(y)), dtype=LONG)
        k[0] = self.rate(t, y, mode)
        for s in range(1, 12):
            k[s] = self.rate(t + C[s] * h, y + h * (A[s, :s] @ k[:s]), mode)
        new = y + h * (B @ k[:12])
        k[12] = self.rate(t + h, new, mode)
        scale = self.tolerance * (1 + np.maximum(abs(y), abs(new)))
        e5, e3 = ((E @ k) / scale for E in (E5, E3))
        s5, s3 = (e5**2).sum(), (e3**2).sum()
        error = h * s5 / np.sqrt((s5 + LONG(0.01) * s3) * len(y)) if s5 else LONG(0)
        return new, error

"""Sections, doublings and basins: their time beside heyoka by hand, Feigenbaum's ratio, runs of one's own.

    python benchmarks/sections.py [--short]

First 200 motions of a planar double pendulum at one energy with 300 crossings each at a tolerance of 1e-9: pendpin's
`portrait`, and heyoka's batch with Lagrange's equations and events written by hand, in one process, in seconds of processor
time. Then the period doublings of the damped driven pendulum, each located by its multiplier -1, and the ratios of their
distances, which tend to 4.669. Last the basins of the same pendulum, from 100 x 80 starts, and cells of them against runs of
one's own: whether two cells have one number just where their own runs end on one cycle.
"""

import argparse
import time
from typing import Any

import heyoka as hy
import numpy as np

import pendpin as pp
from pendpin import effects as fx

DOUBLE = pp.Scene(
    model=pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0)] * 2),
    effects=[fx.Gravity()],
    start=pp.Start(positions={"theta_1": 1.0, "theta_2": 0.3}),
    duration=10.0,
    solver=pp.Solver(tolerance=1e-9),
)
WIDTH = 8
TO = (1.0825, 1.0835, 1.08305, 1.08285, 1.08278)  # where the branch of twice the period is followed to


class ByHand:
    """Lagrange's equations of two equal thin rods in absolute angles, with an event where the first one rises through 0."""

    def __init__(self) -> None:
        a1, a2, u1, u2 = hy.make_vars("a1", "a2", "u1", "u2")
        g, c, s = 9.81, hy.cos(a1 - a2), hy.sin(a1 - a2)
        m11, m12, m22 = 4 / 3, c / 2, 1 / 3
        f1 = -s * u2**2 / 2 - 1.5 * g * hy.sin(a1)
        f2 = s * u1**2 / 2 - 0.5 * g * hy.sin(a2)
        det = m11 * m22 - m12 * m12
        system = [(a1, u1), (a2, u2), (u1, (m22 * f1 - m12 * f2) / det), (u2, (m11 * f2 - m12 * f1) / det)]
        rising = hy.nt_event_batch(hy.sin(a1), Note(), direction=hy.event_direction.positive)
        self.series = hy.taylor_adaptive_batch(system, np.zeros((4, WIDTH)), tol=1e-9, nt_events=[rising])

    def points(self, starts: np.ndarray, count: int) -> np.ndarray:
        """The first crossings (n, count, 2), theta_2 and its rate, from starts (n, 4): both angles, both rates."""
        out, note = np.full((len(starts), count, 2), np.nan), self.series.nt_events[0].callback
        for first in range(0, len(starts), WIDTH):
            rows = np.resize(np.arange(first, min(first + WIDTH, len(starts))), WIDTH)
            note.points, end = [[] for _ in rows], 0.0
            self.series.state[:] = starts[rows].T
            self.series.set_time(0.0)
            while min(map(len, note.points)) < count:
                end += 50.0
                self.series.propagate_until(end)
            for place, row in enumerate(rows):
                out[row] = note.points[place][:count]
        return out


class Note:
    """Notes the second rod where the first hangs; half a turn away its sine is 0 too."""

    points: list[list[tuple[float, float]]]

    def __call__(self, series: Any, t: float, direction: int, place: int) -> None:
        series.update_d_output(np.full(WIDTH, t))
        a1, a2, u1, u2 = series.d_output[:, place]
        if np.cos(a1) > 0 and t > 0:
            self.points[place].append((a2 - a1, u2 - u1))


def beside(starts: int, count: int) -> None:
    """The table of times."""
    section = pp.sections.crossing("theta_1", of=("theta_2", "theta_2_rate"), count=count)
    portrait = pp.sections.portrait(DOUBLE, section, starts, -10.0)
    q, v = (np.array([getattr(s, name) for s in portrait.starts])[:, ::2] for name in ("positions", "velocities"))
    states = np.concatenate([np.cumsum(q, 1), np.cumsum(v, 1)], 1)
    hand = ByHand()
    least = {"pendpin": np.inf, "heyoka by hand": np.inf}
    for _ in range(3):
        for name, run in (
            ("pendpin", lambda: pp.sections.portrait(DOUBLE, section, starts, -10.0)),
            ("heyoka by hand", lambda: hand.points(states, count)),
        ):
            begin = time.process_time()
            run()
            least[name] = min(least[name], time.process_time() - begin)
    early = np.abs(hand.points(states, count)[:, 0] - portrait.values[:, 0]).max()
    print(f"{starts} motions, {count} crossings each; their first points differ by {early:.1e} at most")
    for name, seconds in least.items():
        print(f"  {name:16} {seconds:8.3f} s of processor   {seconds / least['heyoka by hand']:5.2f} times")


def driven(amplitude: float, duration: float) -> pp.Scene:
    """The damped driven pendulum, in seconds of the small swing."""
    effects = [fx.Gravity(acceleration=1.0), fx.Viscous(coefficient=0.5)]
    motor = fx.Motor(joint="theta", amplitude=amplitude, frequency=2 / 3)
    point = pp.Chain(rods=[pp.Rod(length=1.0, mass=0.0, payload=1.0)])
    start = pp.Start(positions={"theta": -1.8598}, velocities={"theta": -0.8392})
    return pp.Scene(model=point, effects=[*effects, motor], start=start, duration=duration)


def doublings(steps: int) -> None:
    """The table of doublings."""
    scene = driven(1.06, 30.0)
    key, places = "effects[2].amplitude", list[float]()
    branch = pp.follow(pp.periodic_orbit(scene), key, 1.075)
    for step in range(steps):
        change = next(change for change in branch.bifurcations if change.kind == "period doubling")
        places.append(change.value)
        gaps = np.diff(places)
        ratio = f"{gaps[-2] / gaps[-1]:.4f}" if len(gaps) > 1 else ""
        print(f"  {2**step:3} periods of the drive to {2 ** (step + 1):3}: amplitude {change.value:.10f}   {ratio}")
        if step < steps - 1:
            branch = pp.follow(change.orbit, key, TO[step], onto="doubled")


def basins(shape: tuple[int, int], cells: int) -> None:
    """The basins at an amplitude with cycles of three and of four periods, and cells of them by runs of one's own."""
    period = 3 * np.pi
    scene = driven(1.0809, 85 * period).with_solver(tolerance=1e-9)
    keys = ("start.positions.theta", "start.velocities.theta")
    axes = [np.linspace(-most, most, count) for most, count in zip((3.0, 2.0), shape, strict=True)]
    begin = time.process_time()
    data = pp.sweep(scene, dict(zip(keys, axes, strict=True)), ["attractor"])
    seconds, numbers = time.process_time() - begin, data["attractor"].values
    print(f"basins of {numbers.size} starts in {seconds:.1f} s of processor; {np.isnan(numbers).sum()} did not settle")
    random, own = np.random.default_rng(0), list[tuple[float, np.ndarray]]()
    while len(own) < cells:
        place = tuple(random.integers(shape))
        if not np.isnan(numbers[place]):
            start = {key: float(axis[i]) for key, axis, i in zip(keys, axes, place, strict=True)}
            run = pp.simulate(scene.replace(start | {"duration": 150 * period}), times=period * np.arange(139, 151))
            states = np.stack([np.cos(run["theta"]), np.sin(run["theta"]), run["theta_rate"]], 1)
            own.append((numbers[place], states[-12:]))
    wrong = sum(
        (one == other) != (np.abs(points[:, None] - those[None]).max(-1).min(1).max() < 1e-3)
        for one, points in own
        for other, those in own
    )
    kinds = "; ".join(data["attractor"].attrs["attractors"])
    print(f"  {kinds}: {wrong} of {cells**2} pairs of cells are not as their own runs say")


def main() -> None:
    """Print all of it."""
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--short", action="store_true", help="8 motions of 10 crossings, two doublings, 48 starts")
    short = options.parse_args().short
    beside(8 if short else 200, 10 if short else 300)
    print("period doublings of x'' + x'/2 + sin x = a cos(2 t/3), and the ratios of their distances")
    doublings(2 if short else 5)
    basins((8, 6) if short else (100, 80), 5 if short else 100)


if __name__ == "__main__":
    main()

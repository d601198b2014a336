"""Nothing is missed: random pulses, grazing stops, rates that touch zero, release times under beating motors.

Every draw has an exact solution. `python benchmarks/events.py [draws] [seed]` prints, for each kind and method, how many
draws there were, how many were missed, and the largest error. The tests have the same laws on fewer draws.
"""

import math
import sys
import warnings
from collections.abc import Callable
from typing import Literal, NamedTuple

import numpy as np
from rich.console import Console
from rich.table import Table
from scipy import optimize

import pendpin as pp
from pendpin.effects import DryFriction, JointEffect, Motor, Stop
from pendpin.effects.pace import Pace
from pendpin.errors import Note

METHODS = ("dop853", "rk45", "rk23", "radau", "bdf", "lsoda")
MULTISTEP = ("bdf", "lsoda")
ROD = pp.Chain(rods=(pp.Rod(length=1.0, mass=1.0, radius=0.05),))
INERTIA = ROD.rods[0].properties.I1 + 0.25  # kg m² about the joint

warnings.simplefilter("ignore", Note)  # of stops beyond a whole turn


class Pulse(JointEffect):
    """A Gaussian torque about theta, with the impulse given."""

    kind: Literal["pulse"] = "pulse"
    at: float  # s
    width: float  # s
    impulse: float  # N m s

    @property
    def on(self):
        """The joint it acts on."""
        return ("theta",)

    def torques(self, t, q, v, xp=np):
        """Torque (1,) in N m."""
        return np.array([self.impulse / self.width / np.sqrt(np.pi) * xp.exp(-(((t - self.at) / self.width) ** 2))])

    def pace(self, begin, end, negligible):
        """Its width, near it."""
        return Pace(self.at + np.array([-7, 7]) * self.width, np.array([np.inf, self.width, np.inf]))


class Draw(NamedTuple):
    """What came out of one run."""

    missed: bool
    error: float  # in s where the kind is one of times, else in rad/s


def run_of(effects, method, tolerance, duration, q=0.0, v=0.0) -> pp.Trajectory:
    """A rod whose theta alone moves."""
    start = pp.Start(positions={"theta": q}, velocities={"theta": v})
    solver = pp.Solver(samples=2, method=method, tolerance=tolerance)
    return pp.simulate(pp.Scene(duration=duration, model=ROD, start=start, effects=effects, solver=solver))


def pulse(random: np.random.Generator, method: str) -> Draw:
    """A pulse 0.1 to 1000 times shorter than a step of 0.1 s, anywhere in 2 to 100 s of rest."""
    duration, width = 10 ** random.uniform(0.3, 2), 10 ** random.uniform(-4, 0)
    at = random.uniform(0.0, duration)
    run = run_of([Pulse(at=at, width=width, impulse=0.1)], method, 1e-8, duration)
    past = (math.erf((duration - at) / width) + math.erf(at / width)) / 2
    error = abs(run.v[-1, 0] - 0.1 * past / INERTIA)
    return Draw(error > 1e-3, error)


def grazing(random: np.random.Generator, method: str) -> Draw:
    """A constant torque turns the joint round a hair beyond an elastic stop."""
    depth, rate, torque = 10 ** random.uniform(-9, -3), random.uniform(0.5, 5), random.uniform(0.2, 3)
    a = torque / INERTIA
    speed = math.sqrt(2 * a * depth)
    hit, after = (rate - speed) / a, random.uniform(0.05, 0.5)
    stop = Stop(upper=rate**2 / (2 * a) - depth, restitution=1.0, joints=["theta"])
    tolerance = 1e-12 if method in MULTISTEP else 1e-10
    run = run_of([Motor(joint="theta", torque=-torque), stop], method, tolerance, hit + after, v=rate)
    return Draw(run.stats.events != 1, abs(run.v[-1, 0] + speed + a * after) / (2 * a))


def touching(random: np.random.Generator, method: str) -> Draw:
    """The rate of a sliding joint would go below 0 by a hair: it stops there, and is held."""
    dip, frequency, phase = 10 ** random.uniform(-6, -2), random.uniform(0.5, 20), random.uniform(0.3, 2.5)
    swing = 1.0 / (INERTIA * frequency)
    start = swing * (1 + math.sin(phase)) - dip
    touch = (1.5 * math.pi - math.acos(1 - dip / swing) - phase) / frequency
    way = (swing - dip) * touch + swing / frequency * (math.cos(phase) - math.cos(frequency * touch + phase))
    motor = Motor(joint="theta", torque=0.2, amplitude=1.0, frequency=frequency, phase=phase + math.pi / 2)
    friction = DryFriction(kinetic=0.2, static=5.0, joints=["theta"])
    run = run_of([motor, friction], method, 1e-8 if method == "rk23" else 1e-10, touch + 1.0, v=start)
    return Draw(run.stats.events != 1 or run.v[-1, 0] != 0, abs(run.q[-1, 0] - way))


def loosening(random: np.random.Generator, method: str) -> Draw:
    """A joint at rest comes loose at the first instant at which two beating motors pass what holds it."""
    frequency, beat, share = random.uniform(20, 300), random.uniform(0.5, 3), random.uniform(0.3, 0.99)
    size, kinetic = 0.5 / share, 0.5

    def torque(t):
        return size * (np.sin(frequency * t) - np.sin((frequency + beat) * t))

    def impulse(t):
        return size * (math.cos((frequency + beat) * t) / (frequency + beat) - math.cos(frequency * t) / frequency)

    t = np.arange(0.0, 2 * math.pi / beat, 0.001 * math.pi / frequency)
    first = int(np.argmax(np.abs(torque(t)) > 1))
    loose = optimize.brentq(lambda t: abs(torque(t)) - 1, t[first - 1], t[first], xtol=1e-15)
    way, after = np.sign(torque(loose)), 0.1 / frequency
    motors = [
        Motor(joint="theta", amplitude=s * size, frequency=w) for s, w in ((1, frequency), (-1, frequency + beat))
    ]
    friction = DryFriction(kinetic=kinetic, static=1.0, joints=["theta"])
    run = run_of([*motors, friction], method, 1e-11, loose + after)
    exact = (impulse(loose + after) - impulse(loose) - way * kinetic * after) / INERTIA
    return Draw(run.stats.events != 1, abs(run.v[-1, 0] - exact) * INERTIA / (1 - kinetic))


KINDS: dict[str, tuple[Callable[[np.random.Generator, str], Draw], str]] = {
    "pulses": (pulse, "rad/s"),
    "grazing an elastic stop": (grazing, "s"),
    "a rate that touches zero": (touching, "rad"),
    "release under beating motors": (loosening, "s"),
}


def main(draws: int = 100, seed: int = 0) -> None:
    """Print the table; exit status 1 where anything is missed."""
    table = Table("kind", "method", "draws", "missed", "largest error", "unit")
    missed = 0
    for kind, (law, unit) in KINDS.items():
        for method in METHODS:
            random = np.random.default_rng(seed)
            found = [law(random, method) for _ in range(draws)]
            lost = sum(draw.missed for draw in found)
            missed += lost
            table.add_row(kind, method, str(draws), str(lost), f"{max(draw.error for draw in found):.1e}", unit)
    Console().print(table)
    sys.exit(int(missed > 0))


if __name__ == "__main__":
    main(*map(int, sys.argv[1:3]))

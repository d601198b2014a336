"""A parameter study: how far does a crane's load swing, and how hard does it pull, by rope length and trolley ramp?

The trolley is brought from rest to 2 m/s within the ramp; the load of 2,000 kg hangs on a light rope. Two maps are drawn.
Run it:   python examples/crane_study.py     (some seconds; needs the extras fast and sweep)
"""

from typing import Any, ClassVar, Literal

import numpy as np

import pendpin as pp
from pendpin.effects import FrameEffect
from pendpin.effects.pace import Pace
from pendpin.ground.records import Number, Positive
from pendpin.sweeps.figure import save_map

LENGTHS = np.linspace(5.0, 25.0, 41)  # m
RAMPS = np.linspace(1.0, 12.0, 45)  # s


class Trolley(FrameEffect):
    """The support runs along x, from rest to `speed` (m/s): v = speed (1 + tanh u) / 2, u = 3 (t - ramp) / ramp.

    From 5 to 95 % of the speed it takes about the ramp (s).
    """

    kind: Literal["trolley"] = "trolley"
    parameters: ClassVar[tuple[str, ...]] = ("ramp", "speed")
    ramp: Positive
    speed: Number = 2.0

    def pace(self, begin: float, end: float, negligible: float) -> Pace:
        return Pace.even(self.ramp / 3)

    def position(self, t: Any, xp: Any = np) -> Any:
        u = 3 * (t - self.ramp) / self.ramp
        return np.multiply.outer(self.speed / 2 * (t + self.ramp / 3 * xp.log(xp.exp(u) + xp.exp(-u))), [1.0, 0, 0])

    def velocity(self, t: Any, xp: Any = np) -> Any:
        return np.multiply.outer(self.speed / 2 * (1 + xp.tanh(3 * (t - self.ramp) / self.ramp)), [1.0, 0, 0])

    def acceleration(self, t: Any, xp: Any = np) -> Any:
        bell = 1 - xp.tanh(3 * (t - self.ramp) / self.ramp) ** 2
        return np.multiply.outer(1.5 * self.speed / self.ramp * bell, [1.0, 0, 0])


scene = pp.Scene(
    duration=60.0,  # s
    model=pp.Chain(rods=[pp.Rod(length=10.0, mass=20.0, payload=2000.0)]),  # m, kg: a rope and its load
    effects=[pp.effects.Gravity(), Trolley(ramp=5.0)],
    solver=pp.Solver(tolerance=1e-9, samples=601),
)
found = pp.sweep(scene, {"effects[1].ramp": RAMPS, "model.rods[0].length": LENGTHS}, ["swing", "R3.max"])
found["swing"] *= 180 / np.pi
found["R3.max"] /= 2020 * 9.81
for name, words, unit in (
    ("swing", "largest swing", "degrees"),
    ("R3.max", "largest rope force", "weights of rope and load"),
    ("ramp", "trolley ramp", "s"),
    ("length", "rope length", "m"),
):
    found[name].attrs.update(long_name=words, units=unit)

save_map(found, "crane_swing.png", "swing")
save_map(found, "crane_force.png", "R3.max")
short, long = (float(found.swing[0].sel(length=x, method="nearest")) for x in (5.0, 25.0))
gentle = float(found.swing[-1].max())
print(f"A ramp of {RAMPS[0]:g} s swings the load by {short:.0f} degrees on 5 m of rope and by {long:.0f} on 25 m;")
print(f"a ramp of {RAMPS[-1]:g} s swings it by {gentle:.1f} degrees at most.")
print(f"The rope pulls with up to {float(found['R3.max'].max()):.3f} times its weight and that of the load.")

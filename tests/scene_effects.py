"""Random effects for the rods of a random scene, of sizes that go with them."""

import math
from pathlib import Path
from random import Random
from typing import Any

Table = dict[str, Any]

CONTACTS = ("stop", "dry_friction")
KINDS = {
    "viscous": 18,
    "spring": 16,
    "motor": 16,
    "push": 14,
    "drag": 14,
    "support": 12,
    "rotation": 12,
    "dry_friction": 14,
    "stop": 14,
}
SPECIAL = (0.0, -0.0, 1e-300, 5e-324, 1e-9, 1e-3, 1.0, 1e3, 1e9)


class EffectMaker:
    """The effects of one scene; `wild` 0, 1, 2 is how far from the plausible its numbers may be."""

    def __init__(self, random: Random, csv: Path) -> None:
        self.random, self.csv = random, csv
        self.wild = random.choices((0, 1, 2), (60, 25, 15))[0]
        self.rods: list[Table] = []
        self.fast = 1.0  # rad/s, about: the fastest there is
        self.time = self.random.choice((1e9, 1e6, 3600.0, -5.0, 0.1, 1.7e9)) if self.chance(0.12) else 0.0

    # --- numbers ----------------------------------------------------------------------------------------------------

    def chance(self, share: float) -> bool:
        return self.random.random() < share

    def one_of(self, weights: dict[Any, int]) -> Any:
        return self.random.choices(list(weights), list(weights.values()))[0]

    def size(self, *decades: float) -> float:
        """A number above 0, even in its logarithm, within so many decades of 1: one entry for each degree of wildness."""
        most = decades[min(self.wild, len(decades) - 1)]
        return 10 ** self.random.uniform(-most, most)

    def amount(self, typical: float) -> float:
        """Not below 0: about so much; the wild ones anything up to 1e9 times, or 0, or a special number."""
        if self.wild == 2 and self.chance(0.3):
            return self.random.choice(SPECIAL)
        if self.chance(0.04):
            return 0.0
        return min(typical * self.size(1, 2, 4), 1e9)

    def vector(self, typical: float) -> list[float]:
        size = self.amount(typical)
        return [size * self.random.choice((0.0, 1.0, self.random.gauss(0, 1))) for _ in range(3)]

    def hurry(self, rate: float) -> None:
        """Something is this fast, in rad/s."""
        if math.isfinite(rate):
            self.fast = max(self.fast, rate)

    # --- what the rods are like ---------------------------------------------------------------------------------------

    @property
    def least_inertia(self) -> float:
        """About the least that turns about a joint, kg m²."""
        return min((r["mass"] + r.get("payload", 0.0)) * r["length"] ** 2 / 3 for r in self.rods)

    @property
    def weight(self) -> float:
        """About the torque of gravity on the last joint, N m."""
        last = self.rods[-1]
        return 9.81 * (last["mass"] + last.get("payload", 0.0)) * last["length"] / 2

    def joint(self) -> str:
        return f"{self.random.choice(('theta', 'phi'))}_{self.random.randint(1, len(self.rods))}"

    def some_joints(self) -> Table:
        if self.chance(0.5):
            return {}
        return {"joints": sorted({self.joint() for _ in range(self.random.randint(1, 3))})}

    # --- the effects ------------------------------------------------------------------------------------------------

    def effects(self) -> list[Table]:
        wanted = self.random.choices(range(5), (30, 30, 20, 12, 8))[0]
        kinds = [self.one_of(KINDS) for _ in range(wanted)]
        return ([self.gravity()] if self.chance(0.88) else []) + [getattr(self, kind)() for kind in kinds]

    def gravity(self) -> Table:
        out: Table = {"kind": "gravity"}
        if self.chance(0.3):
            strong = [1.62, 24.8, 0.0] + [1e-12, 1e-3, 1e3, 1e6] * (self.wild > 0)
            out["acceleration"] = self.random.choice(strong)
        if self.chance(0.15):
            out["direction"] = [self.random.choice((0.0, 1.0, self.random.gauss(0, 1))) for _ in range(2)] + [-1.0]
        shortest = min(rod["length"] for rod in self.rods)
        self.hurry(math.sqrt(out.get("acceleration", 9.81) / shortest))
        return out

    def viscous(self) -> Table:
        coefficient = self.amount(0.05 * self.weight)
        self.hurry(0.3 * coefficient / self.least_inertia)
        return {"kind": "viscous", "coefficient": coefficient} | self.some_joints()

    def spring(self) -> Table:
        stiffness = self.amount(2 * self.weight)
        self.hurry(math.sqrt(stiffness / self.least_inertia))
        rest = self.random.choice((0.0, 0.0, 0.3, -1.0, math.pi))
        return {"kind": "spring", "stiffness": stiffness, "rest": rest} | self.some_joints()

    def motor(self) -> Table:
        out: Table = {"kind": "motor", "joint": self.joint()}
        match self.one_of({"steady": 3, "sine": 3, "hold": 4}):
            case "steady":
                out["torque"] = self.amount(0.2 * self.weight) * self.random.choice((-1, 1))
                self.hurry(math.sqrt(abs(out["torque"]) / self.least_inertia))
            case "sine":
                out |= {"amplitude": self.amount(0.3 * self.weight), "frequency": self.frequency()}
                out |= {"phase": 0.5, "torque": 0.1 * out["amplitude"]} if self.chance(0.3) else {}
                self.hurry(math.sqrt(out["amplitude"] / self.least_inertia))
            case _:
                out |= {"target": self.random.uniform(-2, 2), "proportional": self.amount(5 * self.weight)}
                out |= {"derivative": self.amount(self.weight)} if self.chance(0.7) else {}
                self.hurry(math.sqrt(out["proportional"] / self.least_inertia))
                self.hurry(0.3 * out.get("derivative", 0.0) / self.least_inertia)
        return out

    def frequency(self) -> float:
        rate = self.random.choice((1.0, 5.0)) * self.size(1, 2, 4)
        self.hurry(rate)
        return rate

    def push(self) -> Table:
        number = self.random.randrange(len(self.rods))
        length = self.rods[number]["length"]
        out: Table = {"kind": "push", "link": f"rod_{number + 1}", "force": self.vector(0.3 * self.weight / length)}
        if self.chance(0.3):
            out["point"] = length * self.random.choice((0.0, 0.5, 1.0, -2.0))
        if self.chance(0.25):
            out["torque"] = self.vector(0.1 * self.weight)
        if self.chance(0.3):
            out |= {"amplitude": self.vector(0.3 * self.weight / length), "frequency": self.frequency()}
        strength = max(map(abs, out["force"])) * length + max(map(abs, out.get("torque", [0.0])))
        self.hurry(math.sqrt(strength / self.least_inertia))
        return out

    def drag(self) -> Table:
        out: Table = {"kind": "drag"}
        if self.chance(0.5):
            out["density"] = self.random.choice((0.0, 1.2, 1000.0))
        if self.chance(0.4):
            out["linear"] = self.amount(0.1)
        if self.chance(0.4):
            out["wind"] = self.vector(3.0)
        if self.chance(0.3):
            out |= {"gust": self.vector(2.0), "frequency": self.frequency()}
        if self.chance(0.5):
            out["diameter"] = self.rods[0]["length"] * self.size(1, 1, 2) / 20
        if self.chance(0.3):
            out["buoyancy"] = True
        return out

    def support(self) -> Table:
        typical = 0.1 * self.rods[0]["length"]
        if self.chance(0.35):
            self.write_path(typical)
            return {"kind": "support", "csv": str(self.csv)}
        return {
            "kind": "support",
            "amplitude": self.vector(typical),
            "frequency": self.frequency(),
            "phase": self.random.choice((0.0, 0.7)),
        }

    def write_path(self, typical: float) -> None:
        """A smooth path over 25 s, of 2 to 200 rows."""
        count, steps = self.random.choice((2, 5, 40, 200)), self.random.uniform(0.3, 3.0)
        times = [25.0 * i / (count - 1) for i in range(count)]
        rows = [(self.time + t, *(typical * math.sin(steps * t * (1 + 0.3 * k)) for k in range(3))) for t in times]
        self.csv.write_text("t,x,y,z\n" + "".join(",".join(map(repr, row)) + "\n" for row in rows))

    def rotation(self) -> Table:
        if self.chance(0.4):
            return {"kind": "rotation", "latitude": self.random.choice((0.0, 48.9, -90.0))}
        rate = self.vector(1.0)
        self.hurry(max(map(abs, rate)))
        return {"kind": "rotation", "rate": rate}

    def dry_friction(self) -> Table:
        kinetic = self.amount(0.05 * self.weight)
        out: Table = {"kind": "dry_friction", "kinetic": kinetic} | self.some_joints()
        if self.chance(0.6):
            out["static"] = kinetic * self.random.choice((1.0, 1.3, 2.0)) + (self.chance(0.2) and 1e-3)
        return out

    def stop(self) -> Table:
        width = self.random.choice((0.3, 0.8, 1.5, math.pi / 2))
        sides = self.one_of({"both": 6, "lower": 2, "upper": 2})
        out: Table = {"kind": "stop", "restitution": self.random.choice((0.0, 0.0, 0.3, 0.8, 1.0))}
        out |= {"lower": -width * self.random.choice((1.0, 0.5, 1e-6))} if sides != "upper" else {}
        out |= {"upper": width * self.random.choice((1.0, 0.5, 1e-6))} if sides != "lower" else {}
        return out | self.some_joints()

"""Random scenes: everything that a scene can hold, most of it plausible, a good part extreme, each from its seed alone."""

import math
from pathlib import Path
from random import Random
from typing import Any, NamedTuple

Table = dict[str, Any]

ADAPTIVE = ("dop853", "rk45", "rk23", "radau", "bdf", "lsoda")
FIXED = ("gauss2", "gauss4", "gauss6", "rk4", "euler")
METHODS = dict(zip(("auto", *ADAPTIVE, "taylor", *FIXED), (24, 15, 9, 5, 7, 5, 7, 3, 4, 5, 4, 7, 5), strict=True))
ENGINES = {"auto": 74, "pinocchio": 10, "chain": 10, "compiled": 4}
RODS = {1: 34, 2: 26, 3: 14, 4: 8, 5: 6, 6: 4, 7: 4, 8: 4}
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
MOST_COMPILED = 2  # rods on symbols, in most scenes: more compile for seconds
LIMITS = {0.25: 92, 2.0: 6, 10.0: 2}  # s
SPECIAL = (0.0, -0.0, 1e-300, 5e-324, 1e-9, 1e-3, 1.0, 1e3, 1e9)


class Case(NamedTuple):
    """A scene as plain data, as in a scene file, and how it is run."""

    scene: Table
    ledger: bool
    limit: float  # s


def case_of(seed: int, number: int, folder: Path) -> Case:
    """The case of this number; a csv that it names is written to `folder`."""
    return _Maker(Random(f"{seed} {number}"), folder / f"path_{seed}_{number}.csv").case()


class _Maker:
    """One scene in the making: `wild` 0, 1, 2 is how far from the plausible its numbers may be."""

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

    # --- the model --------------------------------------------------------------------------------------------------

    def model(self) -> Table:
        count, all_thin = self.one_of(RODS), self.chance(0.3)
        first = self.rod(all_thin)
        alike = self.chance(0.3)
        self.rods = [dict(first) if alike else self.rod(all_thin) for _ in range(count)]
        if self.wild == 2 and self.chance(0.3):  # heavy and light ones in turn
            ratio = 10 ** self.random.uniform(-6, 6)
            for rod in self.rods[1::2]:
                rod["mass"] = min(max(rod["mass"] * ratio, 1e-9), 1e9)
        if count % 2 == 0 and self.chance(0.1):
            self.rods = self.rods[: count // 2] * 2
            return {"kind": "chain", "rods": self.rods[: count // 2], "copies": 2}
        return {"kind": "chain", "rods": self.rods}

    def rod(self, thin: bool) -> Table:
        length, mass = self.size(0.6, 1.5, 3), self.size(0.7, 2, 6)
        rod: Table = {"length": length, "mass": mass}
        if not thin:
            shares = {0.0: 20, 1e-4: 5, 0.003: 15, 0.02: 30, 0.1: 15}
            rod["radius"] = length * self.one_of(shares | ({1e-9: 5, 1.0: 5, 10.0: 5} if self.wild else {}))
        match self.one_of({"uniform": 60, "payload": 14, "point": 10, "com": 8, "inertia": 8}):
            case "payload":
                rod["payload"] = mass * self.size(1, 2, 6)
            case "point":
                rod |= {"mass": 0.0, "payload": mass}
            case "com":
                rod["com"] = length * self.random.choice((0.1, 0.3, 0.9, 1.0, 1.5, -0.4, 1e-3))
            case "inertia":
                across = mass * length**2 * self.size(1, 2, 4)
                along = across * self.random.choice((0.0, 1e-6, 0.01, 1.0, 1.9))
                rod["inertia"] = [across, across if thin or not along else across * self.random.uniform(1, 1.5), along]
        if thin:
            rod.pop("radius", None)
            rod |= {"inertia": [*rod["inertia"][:2], 0.0]} if "inertia" in rod else {}
        return rod

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

    # --- the start --------------------------------------------------------------------------------------------------

    def start(self, effects: list[Table]) -> Table:
        n = len(self.rods)
        names = [f"{angle}_{i}" for i in range(1, n + 1) for angle in ("theta", "phi")]
        limits = [limit for e in effects if e["kind"] == "stop" for limit in (e.get("lower"), e.get("upper")) if limit]
        q, v = dict.fromkeys(names, 0.0), dict.fromkeys(names, 0.0)
        spread = 0.25 * min((abs(limit) for limit in limits), default=4.0)
        for name in names:
            q[name] = self.random.uniform(-spread, spread)
            v[name] = self.random.choice((0.0, 1.0, 3.0)) * self.random.gauss(0, 1)
        self.place(q, limits)
        self.set_off(v)
        start: Table = {"positions": q, "velocities": v}
        if self.chance(0.1):
            start = {"positions": list(q.values()), "velocities": list(v.values())}
        return start | ({"time": self.time} if self.time else {})

    def place(self, q: Table, limits: list[float]) -> None:
        """The odd places to start from."""
        some = [name for name in q if self.chance(0.5)] or list(q)
        match self.one_of({"as it is": 62, "upright": 7, "pole": 8, "near pole": 5, "stop": 12, "beyond": 2, "far": 2}):
            case "upright":
                q |= dict.fromkeys(q, 0.0) | {"theta_1": math.pi + self.random.choice((0.0, 1e-15, 1e-6))}
            case "pole":
                q |= {name: self.random.choice((-1, 1)) * math.pi / 2 for name in some if name.startswith("phi")}
            case "near pole":
                away = 10 ** self.random.uniform(-12, -2)
                q |= {name: math.pi / 2 - away for name in some if name.startswith("phi")}
            case "stop" if limits:
                q |= dict.fromkeys(some, self.random.choice(limits))
            case "beyond" if limits:
                q |= dict.fromkeys(some, 1.5 * self.random.choice(limits))
            case "far":
                q |= dict.fromkeys(some, 10 ** self.random.uniform(1, 10))

    def set_off(self, v: Table) -> None:
        """The rates to start with: what there is, none, or far more."""
        match self.one_of(
            {"as it is": 70, "rest": 17, "fast": 8, "huge": 5 * (self.wild > 0), "beyond": self.wild > 1}
        ):
            case "rest":
                v |= dict.fromkeys(v, 0.0)
            case "fast":
                v |= {name: v[name] * 10 ** self.random.uniform(0, 2) for name in v}
            case "huge":
                v |= {name: v[name] * 10 ** self.random.uniform(2, 6) for name in v}
            case "beyond":
                v |= dict.fromkeys(list(v)[:1], 10 ** self.random.choice((12, 12, 60, 100)))
        self.hurry(max(map(abs, v.values())))

    # --- how it is solved -------------------------------------------------------------------------------------------

    def case(self) -> Case:
        model, effects = self.model(), self.effects()
        start, duration = self.start(effects), self.duration()
        scene = {"duration": duration, "model": model, "start": start, "effects": effects}
        kinds = {effect["kind"] for effect in effects}
        solver = self.solver(duration, kinds)
        ledger = solver["method"] != "taylor" and self.chance(0.3 if kinds <= {"gravity", "spring"} else 0.75)
        return Case(scene | {"solver": solver}, ledger, self.one_of(LIMITS))

    def duration(self) -> float:
        """Most last for a few swings of what is fastest; up to 20 s."""
        if self.chance(0.03):
            return self.random.choice((0.0, 1e-12, 1e-300, 1e-3))
        if self.chance(0.02):
            return 20.0
        return min(10 ** self.random.uniform(-0.5, 1.3) / self.fast, 20.0)

    def solver(self, duration: float, kinds: set[str]) -> Table:
        method, engine = self.one_of(METHODS), self.one_of(ENGINES)
        if self.chance(0.95):  # else what does not go together is left to be refused
            method, engine = self.matched(method, engine, kinds)
        out: Table = {"method": method, "engine": engine}
        if self.chance(0.02):
            out["accuracy"] = 10 ** self.random.uniform(-8, -1)
        elif method in FIXED:
            out["step"] = max(duration, 1e-300) / 10 ** self.random.uniform(-0.3, 3.3)
            if self.chance(0.03):
                out["step"] = self.random.choice((1e-300, 1e-9, 1.0, 1e6))
        elif self.chance(0.9):
            least = -18 if method == "taylor" else -14
            out["tolerance"] = 10 ** self.random.uniform(*self.random.choice(((least, -1), (-12, -6), (-9, -3))))
        many = duration < 1e-9 or self.chance(0.85)
        out |= {"samples": self.random.choice((1, 2, 3, 11, 31, 101, 301))} if many and duration else {}
        return out

    def matched(self, method: str, engine: str, kinds: set[str]) -> tuple[str, str]:
        """A method and an engine that take these effects, and compile in a moment."""
        smooth = len(self.rods) <= MOST_COMPILED and not kinds & {"stop", "dry_friction", "drag"}
        if (kinds & set(CONTACTS) and method in FIXED) or (method == "taylor" and not smooth):
            method = self.random.choice(("auto", *ADAPTIVE))
        if method == "taylor" or (engine == "compiled" and not smooth) or method.startswith("gauss"):
            engine = "auto"
        return method, engine

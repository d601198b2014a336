"""Random scenes: everything that a scene can hold, most of it plausible, a good part extreme, each from its seed alone."""

import math
from pathlib import Path
from random import Random
from typing import NamedTuple

from scene_effects import CONTACTS, EffectMaker, Table

ADAPTIVE = ("dop853", "rk45", "rk23", "radau", "bdf", "lsoda")
FIXED = ("gauss2", "gauss4", "gauss6", "rk4", "euler")
METHODS = dict(zip(("auto", *ADAPTIVE, "taylor", *FIXED), (24, 15, 9, 5, 7, 5, 7, 3, 4, 5, 4, 7, 5), strict=True))
ENGINES = {"auto": 74, "pinocchio": 10, "chain": 10, "compiled": 4}
RODS = {1: 34, 2: 26, 3: 14, 4: 8, 5: 6, 6: 4, 7: 4, 8: 4}
MOST_COMPILED = 2  # rods on symbols, in most scenes: more compile for seconds
LIMITS = {0.25: 92, 2.0: 6, 10.0: 2}  # s


class Case(NamedTuple):
    """A scene as plain data, as in a scene file, and how it is run."""

    scene: Table
    energy_balance: bool
    limit: float  # s


def case_of(seed: int, number: int, folder: Path) -> Case:
    """The case of this number; a csv that it names is written to `folder`."""
    return _Maker(Random(f"{seed} {number}"), folder / f"path_{seed}_{number}.csv").case()


class _Maker(EffectMaker):
    """One scene in the making."""

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
        energy_balance = solver["method"] != "taylor" and self.chance(0.3 if kinds <= {"gravity", "spring"} else 0.75)
        return Case(scene | {"solver": solver}, energy_balance, self.one_of(LIMITS))

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

"""A chain of rods that is given as a scene: a system of that scene's own dynamics."""

import re

import numpy as np

from pendpin.doctor.systems.base import Formula, Quantities, Spec, Values
from pendpin.doctor.systems.tables import Row, Variant, table_spec
from pendpin.dynamics.dynamics import bind
from pendpin.effects import Gravity
from pendpin.errors import InputError, amount
from pendpin.scene import Chain, Scene

MOST_RODS = 6  # of a chain whose equations anybody writes down


def scene_spec(scene: Scene) -> Spec:
    """What is true of a scene of a few rods. Raises InputError for any other."""
    if not isinstance(scene.model, Chain) or scene.model.count > MOST_RODS:
        raise InputError(f"scene: equations are checked for chains of up to {MOST_RODS} rods")
    dynamics, rods = bind(scene), scene.model.all_rods
    joints = tuple(name.replace("_", "") for name in dynamics.model.joints)  # theta1, phi1, ...
    printed = {name: re.sub(r"(\d+)$", r"_\1", name) for name in joints}  # theta_1
    gravity = (float(effect.acceleration) for effect in scene.effects if isinstance(effect, Gravity))
    values = {"g": next(gravity, 0.0)}
    rows, one = [Row(name, "1", text) for name, text in printed.items()], len(rods) == 1
    for i, rod in enumerate(rods, start=1):
        m, h, *inertias = rod.properties
        values |= {f"m{i}": m, f"l{i}": rod.length, f"h{i}": h}
        values |= {f"I{i}{k}": inertia for k, inertia in enumerate(inertias, start=1)}
        rows += [Row(f"{name}{i}", unit, f"{name}_{i} {name}") for name, unit in (("m", "kg"), ("l", "m"), ("h", "m"))]
        rows += [Row(f"I{i}{k}", "kg m2", f"I_{i}{k} I_{i},{k}{f' I_{k}' * one}") for k in (1, 2, 3)]
        rows += [Row(f"{c}{i}", "m", f"{c}_{i}{f' {c}' * one}") for c in "xyz"]
    rows += [Row("g", "m/s2", "g"), Row("T", "N m", "T K E_k"), Row("V", "N m", "V U E_p")]
    rows += [Row("L", "N m", "L ℒ", "T - V"), Row("E", "N m", "E H", "T + V")]
    rows += [Row(f"p{name}", "N m s", f"p_{name} p_{text}") for name, text in printed.items()]

    def states(q: Quantities) -> list[Values]:
        """The angles and rates (n, nv) at the states."""
        return [np.stack([q[d + name] for name in joints], -1) for d in ("", "d")]

    def solve(q: Quantities) -> dict[str, Values]:
        accelerations = np.array([dynamics.acceleration(0.0, *state) for state in zip(*states(q), strict=True)])
        return {f"dd{name}": accelerations[:, i] for i, name in enumerate(joints)}

    def energy(index: int) -> Formula:
        return lambda q: dynamics.energies(*states(q))[index]

    def momentum(name: str) -> Formula:
        return lambda q: q.derivative(energy(0), f"d{name}")

    title = f"the scene's chain of {amount(len(rods), 'rod')}"
    variant = Variant("scene", title, {"coordinates": joints, "parameters": tuple(values)}, {}, rows)
    more = {f"p{name}": momentum(name) for name in joints} | {"T": energy(0), "V": energy(1)}
    return table_spec(variant, solve, more, values=values, analytic=False)

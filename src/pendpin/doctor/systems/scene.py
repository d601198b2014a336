"""A chain of rods given as a scene: the equations of the text are compared with that scene's dynamics."""

import numpy as np

from pendpin.doctor.systems.base import ENERGY_SUMS, Formula, Quantities, Spec, Values
from pendpin.doctor.systems.tables import Table, table_spec
from pendpin.dynamics.dynamics import Dynamics, bind
from pendpin.effects import Gravity
from pendpin.errors import InputError
from pendpin.scene import Chain, Scene

MOST_RODS = 6  # of a chain whose equations anybody writes down


def scene_spec(scene: Scene) -> Spec:
    """What is true of a scene of a few rods. Raises InputError for any other."""
    if not isinstance(scene.model, Chain) or scene.model.count > MOST_RODS:
        raise InputError(f"scene: equations are checked for chains of up to {MOST_RODS} rods")
    dynamics = bind(scene)
    rods = scene.model.all_rods
    joints = tuple(name.replace("_", "") for name in dynamics.model.joints)  # theta1, phi1, ...
    values = {"g": _gravity(scene)}
    for i, rod in enumerate(rods, start=1):
        m, h, *inertias = rod.properties
        values |= {f"m{i}": m, f"l{i}": rod.length, f"h{i}": h}
        values |= {f"I{i}{k}": inertia for k, inertia in enumerate(inertias, start=1)}
    return table_spec(
        "scene",
        f"the scene's chain of {len(rods)} rod{'s' * (len(rods) > 1)}",
        Table(_table(joints, len(rods))),
        joints,
        tuple(values),
        _formulas(dynamics, joints),
        lambda q: _accelerations(dynamics, joints, q),
        values=values,
        analytic=False,
    )


def _gravity(scene: Scene) -> float:
    """The acceleration of gravity in m/s², 0 where there is none."""
    return next((float(effect.acceleration) for effect in scene.effects if isinstance(effect, Gravity)), 0.0)


def _table(joints: tuple[str, ...], rods: int) -> str:
    """The names: those of one rod need no index."""
    rows = [f"{name} | 1 | {_printed(name)}" for name in joints]
    for i in range(1, rods + 1):
        rows += [f"{name}{i} | {unit} | {name}_{i} {name}" for name, unit in (("m", "kg"), ("l", "m"), ("h", "m"))]
        rows += [f"I{i}{k} | kg m2 | I_{i}{k} I_{i},{k}{f' I_{k}' * (rods == 1)}" for k in (1, 2, 3)]
        rows += [f"{c}{i} | m | {c}_{i}{f' {c}' * (rods == 1)}" for c in "xyz"]
    rows += ["g | m/s2 | g", "T | N m | T K E_k", "V | N m | V U E_p", "L | N m | L", "E | N m | E H"]
    rows += [f"p{name} | N m s | p_{name} p_{_printed(name)}" for name in joints]
    return "\n".join(rows)


def _printed(joint: str) -> str:
    """theta1 as theta_1."""
    letter = joint.rstrip("0123456789")
    return f"{letter}_{joint[len(letter) :]}".rstrip("_")


def _stacked(names: tuple[str, ...], q: Quantities) -> Values:
    return np.stack([q[name] for name in names], -1)


def _accelerations(dynamics: Dynamics, joints: tuple[str, ...], q: Quantities) -> dict[str, Values]:
    angles, rates = _stacked(joints, q), _stacked(tuple(f"d{name}" for name in joints), q)
    accelerations = np.array([dynamics.acceleration(0.0, a, b) for a, b in zip(angles, rates, strict=True)])
    return {f"dd{name}": accelerations[:, i] for i, name in enumerate(joints)}


def _formulas(dynamics: Dynamics, joints: tuple[str, ...]) -> dict[str, Formula]:
    def energy(index: int) -> Formula:
        def value(q: Quantities) -> Values:
            pairs = zip(_stacked(joints, q), _stacked(tuple(f"d{name}" for name in joints), q), strict=True)
            return np.array([dynamics.energy(a, b)[index] for a, b in pairs])

        return value

    formulas: dict[str, Formula] = {"T": energy(0), "V": energy(1), **ENERGY_SUMS}
    for name in joints:
        formulas[f"p{name}"] = lambda q, name=name: q.derivative(lambda there: there["T"], f"d{name}")
    return formulas

"""A rod on a universal joint: what every quantity truly is, in the convention of the text, for any type of number.

The formulas are those of docs/derivation.md. The accelerations and reactions come from pendpin.equations, run on floats,
50-digit numbers or symbols.
"""

import re
from dataclasses import replace
from typing import Any

import numpy as np

from pendpin.doctor.reading.names import ANGLES, SHORT_FUNCTIONS, UNIT_VECTORS
from pendpin.doctor.systems import rod_names
from pendpin.doctor.systems.base import ENERGY_SUMS, Formula, Quantities, Spec, Values, cross, dot
from pendpin.equations import newton_euler
from pendpin.equations.base import RodInertia

RODS = ("point", "thin", "uniform", "symmetric", "general")
PARAMETERS = {
    "point": ("m", "l", "g"),
    "thin": ("m", "l", "g"),
    "uniform": ("m", "l", "g", "r"),
    "symmetric": ("m", "l", "g", "h", "I1", "I3", "r"),
    "general": ("m", "l", "g", "h", "I1", "I2", "I3", "r"),
}


def solve(q: Quantities) -> dict[str, Values]:
    """The accelerations and reactions of the true motion."""
    zero, convention = q.number(0), q.convention
    field = np.stack([zero, zero, q["g"] + zero], -1)
    angles, rates = (np.stack([q[f"{d}theta*"], q[f"{d}phi*"]], -1) for d in ("", "d"))
    inertia: Any = [q[name] for name in ("m", "h", "I1", "I2", "I3")]
    answer = newton_euler.solve(RodInertia(*inertia), angles, rates, field, q.xp)
    sign = convention.along
    unknowns = {"R1": answer.R1, "R2": sign * answer.R2, "R3": answer.R3, "M3": sign * answer.M3}
    names = ("ddphi", "ddtheta") if convention.swapped else ("ddtheta", "ddphi")
    return unknowns | {names[0]: convention.theta * answer.theta_dd, names[1]: convention.phi * answer.phi_dd}


def combined(q: Quantities, *components: Values) -> Values:
    """The vector with these components (n,) in the frame B of docs/derivation.md, marked by a star."""
    return sum((c * q[f"b{i}*"] for i, c in enumerate(components, start=1)), start=q.number(0))


def _angle(name: str, other: str) -> Formula:
    """An angle of docs/derivation.md, or its rate, from those of the text."""

    def value(q: Quantities) -> Values:
        sign = q.convention.theta if "theta" in name else q.convention.phi
        return sign * q[other if q.convention.swapped else name]

    return value


def _stacked(*names: str) -> Formula:
    """A vector in I from names or whole numbers, - for the opposite."""

    def one(q: Quantities, name: str) -> Values:
        if name in ("0", "1"):
            return q.number(int(name))
        product = q.number(1)
        for factor in name.lstrip("-").split():
            product = product * q[factor]
        return -product if name.startswith("-") else product

    return lambda q: np.stack([one(q, name) for name in names])


def _inertia(index: int) -> Formula:
    def value(q: Quantities) -> Values:
        m, l = q["m"], q["l"]  # noqa: E741
        square = m * l * l / q.number(12)
        if q.system.kind in ("point", "thin"):
            return square * q.number(1 if q.system.kind == "thin" and index < 3 else 0)
        r = q["r"]
        return m * r * r / q.number(2) if index == 3 else square + m * r * r / q.number(4)

    return value


def _component(vector: str, axis: str) -> Formula:
    return lambda q: dot(q[vector], q[axis])


def _cosines(source: str, target: str) -> Formula:
    """The matrix that turns components in one frame into those in another."""

    def value(q: Quantities) -> Values:
        first, second = (target, source) if not q.convention.transposed else (source, target)
        return np.stack([np.stack([dot(q[row], q[column]) for column in AXES[second]]) for row in AXES[first]])

    return value


AXES = {"I": ("xhat", "yhat", "zhat"), "A": ("a1", "a2", "a3"), "B": ("b1", "b2", "b3")}


def turned(q: Quantities, rows: Values) -> Values:
    """A tensor given by its components (3, 3, n) in B, in I."""
    axes = [q[axis] for axis in AXES["B"]]
    parts = (rows[i, j] * axes[i][:, None] * axes[j][None] for i in range(3) for j in range(3))
    return sum(parts, start=q.number(0))


def _inertia_tensor(q: Quantities, letter: str = "I") -> Values:
    rows = [[q[f"{letter}{i + 1}"] if i == j else q.number(0) for j in range(3)] for i in range(3)]
    return turned(q, np.array(rows))


def _acceleration(q: Quantities) -> Values:
    """h b3'' of docs/derivation.md, section 2."""
    s, c, dt, dp, two = q["s*"], q["c*"], q["dtheta*"], q["dphi*"], q.number(2)
    transverse = q["ddtheta*"] * c - two * dt * dp * s
    return q["h"] * combined(q, q["ddphi*"] + dt * dt * s * c, transverse, -(dp * dp + dt * dt * c * c))


def _alpha(q: Quantities) -> Values:
    s, c, dt, dp = q["s*"], q["c*"], q["dtheta*"], q["dphi*"]
    return combined(q, -q["ddtheta*"] * c + dt * dp * s, q["ddphi*"], -q["ddtheta*"] * s - dt * dp * c)


def balances(q: Quantities) -> tuple[Values, Values, Values]:
    """What the balances of forces, of moments about G and about the joint leave over, vectors (3, n) in I."""
    force = q["m"] * q["aG"] - q["R"] - q["weight"]
    spin, momentum = (np.stack([dot(row, q[name]) for row in q["inertia"]]) for name in ("alpha", "omega"))
    about_g = spin + cross(q["omega"], momentum) + cross(q["rG"], q["R"]) - q["M"]
    return force, about_g, about_g + cross(q["rG"], force)


def _kinetic(q: Quantities) -> Values:
    turning = sum((q[f"I{i}"] * q[f"w{i}"] ** 2 for i in (1, 2, 3)), start=q.number(0))
    return (q["m"] * dot(q["vG"], q["vG"]) + turning) / q.number(2)


def _along(name: str) -> Formula:
    return lambda q: q.convention.along * q[name]


def _function(name: str, angle: str) -> Formula:
    return lambda q: getattr(q.xp, name)(q[angle])


def _axis(name: str, conventions: tuple[str, ...]) -> Formula:
    return lambda q: (-1 if q.convention.z in conventions else 1) * q[f"{name}*"]


FORMULAS: dict[str, Formula] = {
    **{f"{d}theta*": _angle(f"{d}theta", f"{d}phi") for d in ("", "d", "dd")},
    **{f"{d}phi*": _angle(f"{d}phi", f"{d}theta") for d in ("", "d", "dd")},
    "st*": lambda q: q.xp.sin(q["theta*"]),
    "ct*": lambda q: q.xp.cos(q["theta*"]),
    "s*": lambda q: q.xp.sin(q["phi*"]),
    "c*": lambda q: q.xp.cos(q["phi*"]),
    **{f"{f[0]}_{angle}": _function(f, angle) for f in ("sin", "cos") for angle in ("theta", "phi")},
    "x*": _stacked("1", "0", "0"),
    "y*": _stacked("0", "1", "0"),
    "z*": _stacked("0", "0", "1"),
    "a2*": _stacked("0", "ct*", "-st*"),
    "a3*": _stacked("0", "st*", "ct*"),
    "b1*": _stacked("c*", "-st* s*", "-ct* s*"),
    "b2*": lambda q: q["a2*"],
    "b3*": _stacked("s*", "st* c*", "ct* c*"),
    "a1": lambda q: q["x*"],
    "b1": lambda q: q["b1*"],
    **{name: _along(f"{name}*") for name in ("a2", "a3", "b2", "b3")},
    "xhat": _axis("x", ()),
    "yhat": _axis("y", ("up",)),
    "zhat": _axis("z", ("up", "mirrored")),
    **{f"C_{a}{b}": _cosines(a, b) for a in "IAB" for b in "IAB" if a != b},
    "h": lambda q: q["l"] / q.number(1 if q.system.kind == "point" else 2),
    "I1": _inertia(1),
    "I2": lambda q: q["I1"],
    "I3": _inertia(3),
    "J1": lambda q: q["I1"] + q["m"] * q["h"] ** 2,
    "J2": lambda q: q["I2"] + q["m"] * q["h"] ** 2,
    "J3": lambda q: q["I3"],
    "inertia": _inertia_tensor,
    "inertiaO": lambda q: _inertia_tensor(q, "J"),
    "Fg": lambda q: q["m"] * q["g"],
    "field": lambda q: q["g"] * q["z*"],
    "weight": lambda q: q["m"] * q["field"],
    "rG": lambda q: q["h"] * q["b3*"],
    "rT": lambda q: q["l"] * q["b3*"],
    "vG": lambda q: q["h"] * combined(q, q["dphi*"], q["dtheta*"] * q["c*"]),
    "aG": _acceleration,
    "omega": lambda q: combined(q, -q["dtheta*"] * q["c*"], q["dphi*"], -q["dtheta*"] * q["s*"]),
    "alpha": _alpha,
    "speed": lambda q: q.xp.sqrt(dot(q["vG"], q["vG"])),
    **{c: _component("rG", f"{c}hat") for c in "xyz"},
    **{f"{c}T": _component("rT", f"{c}hat") for c in "xyz"},
    **{f"v{c}": _component("vG", f"{c}hat") for c in "xyz"},
    **{f"a{c}": _component("aG", f"{c}hat") for c in "xyz"},
    **{f"w{c}": _component("omega", f"{c}hat") for c in "xyz"},
    **{f"wd{c}": _component("alpha", f"{c}hat") for c in "xyz"},
    **{f"vc{i}": _component("vG", f"b{i}") for i in "123"},
    **{f"ac{i}": _component("aG", f"b{i}") for i in "123"},
    **{f"w{i}": _component("omega", f"b{i}") for i in "123"},
    **{f"wd{i}": _component("alpha", f"b{i}") for i in "123"},
    "R": lambda q: combined(q, q["R1"], q.convention.along * q["R2"], -q["R3"]),
    "Mc": lambda q: q["M3"] / q["c*"],
    "M": lambda q: q.convention.along * q["Mc"] * q["a3*"],
    "M1": _component("M", "b1"),
    "M2": _component("M", "b2"),
    "T": _kinetic,
    "V": lambda q: -q["m"] * q["g"] * q["h"] * q["c*"] * q["ct*"],
    **ENERGY_SUMS,
}


_COMMON = ("theta", "phi", "dtheta", "dphi", "ddtheta", "ddphi", "m", "l", "g", "R1", "R2", "R3", "M3", "Mc", "Fg")
_ANY = ("h", "I1", "I2", "I3", "J1", "J2", "J3")
_OTHERS = {"point": (), "thin": (), "uniform": ("r", "I1", "I2", "I3"), "symmetric": _ANY, "general": _ANY}
_FAMILIES = """x y z; vx vy vz; ax ay az; w1 w2 w3; wd1 wd2 wd3; ac1 ac2 ac3; vc1 vc2 vc3; I1 I2 I3 J1 J2 J3; T V L E
wx wy wz; xT yT zT; M1 M2 M3 Mc; rG vG aG rT; omega alpha; h l r; R M"""
_EXTRA = "ddtheta ddphi R1 R2 R3 M3 Mc I1 I2 I3 J1 J2 J3 h theta phi x y z vx vy vz w1 w2 w3"
_DIFFERENCES = ("I1 - I3", "I2 - I3", "J1 - I3", "J2 - I3", "I2 - I1", "J2 - J1")
_TITLES = {"point": "a point mass on a massless rod", "thin": "a uniform thin rod", "general": "any rod"}
_TITLES |= {"uniform": "a uniform rod of radius r", "symmetric": "any rod with I1 = I2"}


def _laws(q: Quantities) -> list[Values]:
    """What each balance leaves over, (n,): forces, moments about G and about the joint, along the axes of B and A."""
    return [dot(vector, q[axis]) for vector in balances(q) for axis in ("b1", "b2", "b3", "a1")]


def _spec(rod: str) -> Spec:
    families = [tuple(names.split()) for names in re.split(r"[;\n]", _FAMILIES)]
    families += [tuple(sorted(UNIT_VECTORS)), tuple(sorted(rod_names.MATRICES)), SHORT_FUNCTIONS]
    return Spec(
        kind=rod,
        title=_TITLES[rod],
        coordinates=ANGLES,
        parameters=PARAMETERS[rod],
        unknowns=rod_names.UNKNOWNS,
        formulas=FORMULAS,
        solve=solve,
        words=rod_names.meanings,
        dimensions=rod_names.DIMENSION_OF,
        printed=rod_names.LATEX,
        still=frozenset(rod_names.STILL),
        common=(*_COMMON, *_OTHERS[rod]),
        families=tuple(families),
        vectors=frozenset(rod_names.VECTORS),
        matrices=frozenset(rod_names.MATRICES),
        directions=("b1", "b2", "b3", "a1", "a2", "a3", "xhat", "yhat", "zhat"),
        moving=("dtheta", "dphi", "sin theta", "cos theta", "sin phi", "cos phi"),
        extra=(*_EXTRA.split(), *_DIFFERENCES),
        laws=_laws,
    )


SPECS = {rod: _spec(rod) for rod in RODS}


def slender(spec: Spec) -> Spec:
    """The same rod without inertia about its axis."""
    zero = {name: (lambda q: q.number(0)) for name in ("I3", "J3")}
    kept = tuple(name for name in spec.parameters if name not in zero)
    return replace(spec, parameters=kept, formulas={**spec.formulas, **zero})

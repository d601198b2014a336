"""What every quantity of a rod truly is, in the convention of a text, for any type of number.

The formulas are those of docs/derivation.md. The accelerations and reactions come from pendpin.equations, run on floats,
50-digit numbers or symbols.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pendpin.equations import newton_euler
from pendpin.equations.base import RodInertia

Values = NDArray[Any]  # (n,), (3, n) or (3, 3, n): scalars, vectors in I, tensors in I

RODS = ("point", "thin", "uniform", "symmetric", "general")
COORDINATES = ("theta", "phi", "dtheta", "dphi")
PARAMETERS = {
    "point": ("m", "l", "g"),
    "thin": ("m", "l", "g"),
    "uniform": ("m", "l", "g", "r"),
    "symmetric": ("m", "l", "g", "h", "I1", "I3", "r"),
    "general": ("m", "l", "g", "h", "I1", "I2", "I3", "r"),
}


@dataclass(frozen=True)
class Convention:
    """How a text differs from the convention of docs/derivation.md."""

    theta: int = 1  # -1: counter-clockwise positive
    phi: int = 1  # -1: reversed
    swapped: bool = False  # phi is the first angle, theta the second
    z: str = "down"  # "up": y and z of I reversed; "mirrored": z alone
    along: int = 1  # -1: b3 points from the tip to the joint, and b2, a2, a3 are reversed with it
    transposed: bool = False  # direction cosine matrices with rows and columns exchanged

    @property
    def words(self) -> str:
        """The differences, in words; empty where there are none."""
        found = {
            "theta is positive counter-clockwise": self.theta < 0,
            "phi is reversed": self.phi < 0,
            "the names of the angles are swapped": self.swapped,
            "z points up": self.z != "down",
            "b3 points from the tip to the joint": self.along < 0,
            "direction cosine matrices are transposed": self.transposed,
        }
        return ", ".join(text for text, differs in found.items() if differs)


@dataclass(frozen=True)
class Pendulum:
    """What equations are about: the kind of rod, one of RODS, and the convention of the text."""

    rod: str
    convention: Convention = Convention()


class Quantities:
    """Every quantity by its name, computed once and when it is asked for.

    `base` holds arrays (n,) of the coordinates, rates, accelerations, parameters and reactions R1, R2, R3, M3 of the
    text; `xp` the functions of their number type.
    """

    def __init__(self, base: Mapping[str, Values], pendulum: Pendulum, xp: Any) -> None:
        self.pendulum, self.xp, self.base = pendulum, xp, base
        self.rod, self.convention = pendulum.rod, pendulum.convention
        self._known: dict[str, Values] = dict(base)

    def __getitem__(self, name: str) -> Values:
        """A quantity: scalars (n,), vectors (3, n) and tensors (3, 3, n) in I. Raises KeyError for an unknown name."""
        if name not in self._known:
            self._known[name] = FORMULAS[name](self)
        return self._known[name]

    def __contains__(self, name: str) -> bool:
        """Whether a name has a meaning."""
        return name in self._known or name in FORMULAS

    def number(self, value: int) -> Values:
        """A whole number, for every state."""
        return self.xp.asarray(np.full(self.base["theta"].shape, value, dtype=object if self.xp is not np else float))


def solved(known: Quantities) -> Quantities:
    """The same states with the accelerations and reactions that the true motion has."""
    zero, convention = known.number(0), known.convention
    field = np.stack([zero, zero, known["g"] + zero], -1)
    q, v = (np.stack([known[f"{d}theta*"], known[f"{d}phi*"]], -1) for d in ("", "d"))
    inertia: Any = [known[name] for name in ("m", "h", "I1", "I2", "I3")]
    answer = newton_euler.solve(RodInertia(*inertia), q, v, field, known.xp)
    sign = convention.along
    unknowns = {"R1": answer.R1, "R2": sign * answer.R2, "R3": answer.R3, "M3": sign * answer.M3}
    angles = {"theta": convention.theta * answer.theta_dd, "phi": convention.phi * answer.phi_dd}
    names = ("ddphi", "ddtheta") if convention.swapped else ("ddtheta", "ddphi")
    rates = {names[0]: angles["theta"], names[1]: angles["phi"]}
    return Quantities({**known.base, **unknowns, **rates}, known.pendulum, known.xp)


def dot(a: Values, b: Values) -> Values:
    """Of two vectors (3, n)."""
    return (a * b).sum(0)


def cross(a: Values, b: Values) -> Values:
    """Of two vectors (3, n)."""
    return np.stack([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def combined(q: Quantities, *components: Values) -> Values:
    """The vector with these components (n,) in the frame B of docs/derivation.md, marked by a star."""
    return sum((c * q[f"b{i}*"] for i, c in enumerate(components, start=1)), start=q.number(0))


def _angle(name: str, other: str) -> Callable[[Quantities], Values]:
    """An angle of docs/derivation.md, or its rate, from those of the text."""

    def value(q: Quantities) -> Values:
        sign = q.convention.theta if "theta" in name else q.convention.phi
        return sign * q[other if q.convention.swapped else name]

    return value


def _stacked(*names: str) -> Callable[[Quantities], Values]:
    """A vector in I from names or whole numbers, - for the opposite."""

    def one(q: Quantities, name: str) -> Values:
        if name in ("0", "1"):
            return q.number(int(name))
        product = q.number(1)
        for factor in name.lstrip("-").split():
            product = product * q[factor]
        return -product if name.startswith("-") else product

    return lambda q: np.stack([one(q, name) for name in names])


def _inertia(index: int) -> Callable[[Quantities], Values]:
    def value(q: Quantities) -> Values:
        m, l = q["m"], q["l"]  # noqa: E741
        square = m * l * l / q.number(12)
        if q.rod in ("point", "thin"):
            return square * q.number(1 if q.rod == "thin" and index < 3 else 0)
        r = q["r"]
        return m * r * r / q.number(2) if index == 3 else square + m * r * r / q.number(4)

    return value


def _component(vector: str, axis: str) -> Callable[[Quantities], Values]:
    return lambda q: dot(q[vector], q[axis])


def _cosines(source: str, target: str) -> Callable[[Quantities], Values]:
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


def _inertia_tensor(q: Quantities) -> Values:
    rows = [[q[f"I{i + 1}"] if i == j else q.number(0) for j in range(3)] for i in range(3)]
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


def _along(name: str) -> Callable[[Quantities], Values]:
    return lambda q: q.convention.along * q[name]


def _function(name: str, angle: str) -> Callable[[Quantities], Values]:
    return lambda q: getattr(q.xp, name)(q[angle])


def _axis(name: str, conventions: tuple[str, ...]) -> Callable[[Quantities], Values]:
    return lambda q: (-1 if q.convention.z in conventions else 1) * q[f"{name}*"]


FORMULAS: dict[str, Callable[[Quantities], Values]] = {
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
    "h": lambda q: q["l"] / q.number(1 if q.rod == "point" else 2),
    "I1": _inertia(1),
    "I2": lambda q: q["I1"],
    "I3": _inertia(3),
    "J1": lambda q: q["I1"] + q["m"] * q["h"] ** 2,
    "J2": lambda q: q["I2"] + q["m"] * q["h"] ** 2,
    "J3": lambda q: q["I3"],
    "inertia": _inertia_tensor,
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
    "L": lambda q: q["T"] - q["V"],
    "E": lambda q: q["T"] + q["V"],
}

"""A rod on a universal joint: what every quantity truly is, how it is written, and the special cases of each kind of rod.

The formulas are those of docs/derivation.md, in the convention of the text, for any type of number; names of that page's own
convention end in _. The accelerations and reactions come from pendpin.equations, run on floats, 50-digit numbers or symbols.
"""

from dataclasses import replace
from typing import Any

import numpy as np

from pendpin.doctor.reading.names import SHORT_FUNCTIONS, UNIT_VECTORS, Written
from pendpin.doctor.systems.base import Formula, Quantities, Spec, Values, dot, with_zeros
from pendpin.doctor.systems.tables import Variant, names_written, plain_name, table_spec, variants
from pendpin.equations import newton_euler
from pendpin.equations.base import RodInertia

AXES = {"I": ("xhat", "yhat", "zhat"), "A": ("a1", "a2", "a3"), "B": ("b1", "b2", "b3")}
VECTORS = UNIT_VECTORS | {"field", "weight", "rG", "vG", "aG", "omega", "alpha", "R", "rT", "M"}
MATRICES = {f"C_{a}{b}" for a in "IAB" for b in "IAB" if a != b} | {"inertia", "inertiaO"}


def solve(q: Quantities) -> dict[str, Values]:
    """The accelerations and reactions of the true motion."""
    zero, convention = q.number(0), q.convention
    field = np.stack([zero, zero, q["g"] + zero], -1)
    angles, rates = (np.stack([q[f"{d}theta_"], q[f"{d}phi_"]], -1) for d in ("", "d"))
    inertia: Any = [q[name] for name in ("m", "h", "I1", "I2", "I3")]
    answer = newton_euler.solve(RodInertia(*inertia), angles, rates, field, q.xp)
    sign = convention.along
    unknowns = {"R1": answer.R1, "R2": sign * answer.R2, "R3": answer.R3, "M3": sign * answer.M3}
    names = ("ddphi", "ddtheta") if convention.swapped else ("ddtheta", "ddphi")
    return unknowns | {names[0]: convention.theta * answer.theta_dd, names[1]: convention.phi * answer.phi_dd}


def turned(q: Quantities, rows: Values) -> Values:
    """A tensor given by its components (3, 3, n) in B, in I."""
    axes = [q[axis] for axis in AXES["B"]]
    parts = (rows[i, j] * axes[i][:, None] * axes[j][None] for i in range(3) for j in range(3))
    return sum(parts, start=q.number(0))


def _tensor(letter: str) -> Formula:
    """The inertia tensor about G or the joint, in I."""

    def value(q: Quantities) -> Values:
        rows = [[q[f"{letter}{i + 1}"] if i == j else q.number(0) for j in range(3)] for i in range(3)]
        return turned(q, np.array(rows))

    return value


def _cosines(source: str, target: str) -> Formula:
    """The matrix that turns components in one frame into those in another."""

    def value(q: Quantities) -> Values:
        first, second = (target, source) if not q.convention.transposed else (source, target)
        return np.stack([np.stack([dot(q[row], q[column]) for column in AXES[second]]) for row in AXES[first]])

    return value


_OF_ARRAYS: dict[str, Formula] = {f"C_{a}{b}": _cosines(a, b) for a in "IAB" for b in "IAB" if a != b}
_OF_ARRAYS |= {"inertia": _tensor("I"), "inertiaO": _tensor("J")}
KINDS = {variant.kind: variant for variant in variants("rod")}
RODS = tuple(KINDS)
_RATES = {row.quantity: row.rate for row in KINDS["thin"].rows if row.rate}
_WRITTEN = names_written({row.quantity: row.written for row in KINDS["thin"].rows})


def meanings(written: Written) -> tuple[str, ...]:
    """What a printed symbol can mean, the likeliest first; none for one that is not known."""
    names = _WRITTEN.get("*" * written.styled + plain_name(written.letter + written.index), ())
    if written.styled and written.letter in ("I", "J", "g"):  # a tensor and the field, whatever their index
        names = names or _WRITTEN["*" + written.letter]
    if written.letter == "C":  # direction cosines
        names = tuple({f"C_{written.frames}"} & MATRICES)
    for _ in range(written.dots):
        names = tuple(_RATES[name] for name in names if name in _RATES)
    return names


def _spec(variant: Variant) -> Spec:
    """One kind of rod: it has reactions, vectors and matrices, and names of its own for rates."""
    about = {key: tuple(words) for key, words in variant.about.items()}
    alike = (tuple(names.split()) for names in " ".join(about["alike"]).split(";"))
    return replace(
        table_spec(variant, solve, _OF_ARRAYS),
        unknowns=about["unknowns"],
        words=meanings,
        still=frozenset(about["still"]),
        common=about["common"],
        families=(*alike, tuple(sorted(UNIT_VECTORS)), tuple(sorted(MATRICES)), SHORT_FUNCTIONS),
        arrays=frozenset(VECTORS | MATRICES),
        extra=about["terms"],
    )


SPECS: dict[str, Spec] = {kind: _spec(variant) for kind, variant in KINDS.items()}

# other rods that an equation may be about: words, what it is then, how a text says it, and what an equation on it lacks
_THIN, _BOB = r"\bthin\b|slender", r"point mass|\bbob\b|massless|string|simple pendulum"
_SLENDER = with_zeros(SPECS["symmetric"], ("I3", "J3"))  # without inertia about its axis
_OTHERS: dict[str, tuple[str, Spec, str, frozenset[str]]] = {
    "slender": ("I3 = 0 and I1 = I2, as for a thin rod", _SLENDER, _THIN, frozenset(("I3", "J3"))),
    "thin": ("it is a uniform thin rod", SPECS["thin"], _THIN, frozenset(("I3", "J3", "h", "r"))),
    "uniform": ("it is a uniform rod of radius r", SPECS["uniform"], "uniform|cylinder|homogeneous", frozenset("h")),
    "equal": ("I1 = I2", SPECS["symmetric"], r"symmetric|I_?1\s*=\s*I_?2", frozenset(("I1", "I2", "J1", "J2"))),
    "point": ("it is a point mass on a massless rod", SPECS["point"], _BOB, frozenset(("I3", "J3", "h", "r"))),
}
_TRIED = {"general": "slender thin uniform equal point", "symmetric": "slender thin uniform point"}
_TRIED |= {"uniform": "thin point", "thin": "uniform point", "point": "thin"}
SPECIAL = {kind: [_OTHERS[name] for name in names.split()] for kind, names in _TRIED.items()}

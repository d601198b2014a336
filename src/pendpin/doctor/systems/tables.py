"""Systems that are described by a table: names of quantities, their units, how they are written, and their formulas.

A body is a point mass at the end of its length, a uniform rod, or any body with its centre of mass at h and the inertia I
about it. In a formula of its table across(x), high(x) and rise(x) are how far to the side and up the end of a unit link is,
and how fast it rises, as POSES says. A chain of rods that is given as a scene is a table too, of that scene's own dynamics.
"""

import re
from collections.abc import Callable, Mapping
from functools import cache
from typing import Any

import numpy as np

from pendpin.doctor.reading.names import Written
from pendpin.doctor.systems.base import (
    UNITS,
    Dimension,
    Formula,
    Quantities,
    Spec,
    Values,
    dot,
    formulas,
    inverse,
    names_written,
    plain_name,
    read_table,
)
from pendpin.dynamics.dynamics import bind
from pendpin.effects import Gravity
from pendpin.errors import InputError, amount
from pendpin.scene import Chain, Scene

# positions and mass matrices: they have no unit of time, and yet they move
MOVING = re.compile(r"r[Gp12A]|q|mass|M\d\d|[xy][0123p]?|z|e[rtp]")
MOST_RODS = 6  # of a chain whose equations anybody writes down
BODIES = {  # in words; its centre of mass h and the inertia I about it, where these are no parameters
    "any": ("any rigid body", {}),
    "point": ("a point mass on a string or massless rod", {"h": "l", "I": "0*m"}),
    "uniform": ("a uniform rod", {"h": "l/2", "I": "m*l**2/12"}),
    "tip": ("masses with an inertia at the ends of massless rods", {"h": "l"}),
}
POSES = {  # from where angles are measured, in words; and across, high and rise
    "down": ("the vertical", "sin", "-cos", "sin"),
    "up": ("upright", "sin", "cos", "-sin"),
    "horizontal": ("the horizontal", "cos", "sin", "cos"),
}
_NO_INERTIA = ("I", "I1", "I2", "k")  # names that a text on point masses does not use
OTHER_WAY = ", positive the other way"
_COMMON = """
g | m/s2 | g G g_0
L | N m | L | T - V
E | N m | E H | T + V
ex | 1 | *e_x *i *e_1 *u_x *x *E_x | vector(1, 0)
ey | 1 | *e_y *j *e_2 *u_y *y *E_y | vector(0, 1)
ez | 1 | *e_z *k *e_3 *u_z *z *E_z | 1
"""
_GREEK = ("theta", "phi", "alpha", "beta", "psi", "omega", "tau", "gamma")


def table_spec(
    kind: str,
    title: str,
    table: str,
    coordinates: tuple[str, ...],
    parameters: tuple[str, ...],
    more: Mapping[str, Formula],
    solve: Callable[[Quantities], dict[str, Values]] | None = None,
    absent: tuple[str, ...] = (),
    atoms: tuple[str, ...] = (),
    extra: tuple[str, ...] = (),
    **others: Any,
) -> Spec:
    """A system of scalars, whose accelerations `solve` gives, or its mass matrix, mass, and its forces, force_.

    `table` has lines such as "p | N m s | p p_theta L_O | J*dtheta": name, unit, writings, and the formula of what is no
    coordinate or parameter; `more` holds formulas beside these, and `absent` names that are not written. `atoms` are sines
    and cosines that a missing term may have besides those of each angle, `extra` its other quantities.
    """
    rows = read_table(table)
    every = {**formulas({name: text for name, _, _, text in rows if text}), **more}
    ends = [name[1:] for name in every if re.fullmatch(r"y[pG]?\d?", name) and f"x{name[1:]}" in (*every, *coordinates)]
    every |= formulas({f"r{end}": f"vector(x{end}, y{end})" for end in ends})  # for which a text may have a name
    dimensions = {name: powers for name, unit, _, _ in rows if (powers := UNITS[unit]) is not None}
    timeless = {
        name for name, unit in dimensions.items() if unit[2] == 0 and name in every and not MOVING.fullmatch(name)
    }
    still = frozenset(timeless | ({*parameters} & dimensions.keys())) - {*coordinates}
    for name in coordinates:
        kg, m, s = dimensions[name]
        dimensions |= {f"d{name}": (kg, m, s - 1), f"dd{name}": (kg, m, s - 2)}
    places = tuple(f"{axis}{end}" for end in ends for axis in "xy" if f"{axis}{end}" in every)
    dimensions |= {f"d{name}": (0, 1, -1) for name in places}
    written = names_written({name: writings for name, _, writings, _ in rows if name not in absent})

    @cache
    def words(one: Written) -> tuple[str, ...]:
        """The meanings of a printed symbol; the rate of x is dx, and what is fixed has none."""
        key = plain_name(one.letter + one.index)
        names = (one.styled and written.get("*" + key)) or written.get(key, ())
        moving = (name for name in names if not (one.dots and (name in still or name in parameters)))
        return tuple("d" * one.dots + name for name in moving if not one.frames)

    def accelerations(q: Quantities) -> dict[str, Values]:
        rows = inverse(q["mass"], q)
        return {f"dd{name}": dot(row, q["force_"]) for name, row in zip(coordinates, rows, strict=True)}

    rates, unknowns = (tuple(order + name for name in coordinates) for order in ("d", "dd"))
    angles = [name for name in coordinates if dimensions[name] == (0, 0, 0)]
    families: dict[Dimension, list[str]] = {}  # the names of each dimension, any of which may be mistaken for another
    for name, unit in dimensions.items():
        if name in {*coordinates, *parameters, *unknowns, *every, *rates} or name.lstrip("d") in places:
            families.setdefault(unit, []).append(name)
    return Spec(
        kind=kind,
        title=title,
        coordinates=coordinates,
        parameters=parameters,
        unknowns=unknowns,
        formulas=every,
        solve=solve or accelerations,
        words=words,
        dimensions=dimensions,
        printed={name: _latex(name, (*coordinates, *places)) for name in dimensions},
        still=still,
        common=(*coordinates, *rates, *unknowns, *parameters),
        families=tuple(map(tuple, families.values())),
        moving=(*rates, *(f"{f} {angle}" for angle in angles for f in ("sin", "cos")), *atoms),
        extra=(*unknowns, *extra, *coordinates),
        **others,
    )


def body_spec(
    table: str, moving: str, fixed: str, body: str, pose: str, more: Mapping[str, str], marks: str, **others: Any
) -> Spec:
    """A system from its table with what all share, for one kind of body and one pose; `others` as in table_spec.

    Of the parameters, `fixed`, a * is the place of those of the bodies, each with one of the `marks`; what `more` formulas
    give is none.
    """
    given = BODIES[body][1]
    texts = {f"{n}{i}".strip(): re.sub(r"\b[mlh]\b", rf"\g<0>{i}", given[n]) for n in given for i in marks} | dict(more)
    own = " ".join(f"{name}{i}" for name in "hI" for i in marks)
    names = tuple(name for name in fixed.replace("*", own).split() if name not in texts)
    words: dict[str, str] = dict(zip(("across", "high", "rise"), POSES[pose][1:], strict=True))
    rows = re.sub(rf"\b(?:{'|'.join(words)})\b", lambda word: words[word[0]], _COMMON + table.strip())
    others["absent"] = (*_NO_INERTIA * (body == "point"), *others.get("absent", ()))
    return table_spec(table=rows, coordinates=tuple(moving.split()), parameters=names, more=formulas(texts), **others)


def _latex(name: str, coordinates: tuple[str, ...]) -> str:
    """A name as it is printed where the text does not print it: ddtheta1 is \\ddot{\\theta}_1."""
    dots = next((n for n in (2, 1) if name[:n] == "d" * n and name[n:] in coordinates), 0)
    letter = name[dots:].rstrip("0123456789")
    index = f"_{name[dots + len(letter) :]}".removesuffix("_")
    letter = "\\" + letter if letter in _GREEK else letter
    return rf"\{'d' * dots}ot{{{letter}}}{index}" if dots else letter + index


def scene_spec(scene: Scene) -> Spec:
    """What is true of a scene of a few rods. Raises InputError for any other."""
    if not isinstance(scene.model, Chain) or scene.model.count > MOST_RODS:
        raise InputError(f"scene: equations are checked for chains of up to {MOST_RODS} rods")
    dynamics, rods = bind(scene), scene.model.all_rods
    joints = tuple(name.replace("_", "") for name in dynamics.model.joints)  # theta1, phi1, ...
    printed = {name: re.sub(r"(\d+)$", r"_\1", name) for name in joints}  # theta_1
    gravity = (float(effect.acceleration) for effect in scene.effects if isinstance(effect, Gravity))
    values = {"g": next(gravity, 0.0)}
    rows, one = [f"{name} | 1 | {text}" for name, text in printed.items()], len(rods) == 1
    for i, rod in enumerate(rods, start=1):
        m, h, *inertias = rod.properties
        values |= {f"m{i}": m, f"l{i}": rod.length, f"h{i}": h}
        values |= {f"I{i}{k}": inertia for k, inertia in enumerate(inertias, start=1)}
        rows += [f"{name}{i} | {unit} | {name}_{i} {name}" for name, unit in (("m", "kg"), ("l", "m"), ("h", "m"))]
        rows += [f"I{i}{k} | kg m2 | I_{i}{k} I_{i},{k}{f' I_{k}' * one}" for k in (1, 2, 3)]
        rows += [f"{c}{i} | m | {c}_{i}{f' {c}' * one}" for c in "xyz"]
    rows += ["g | m/s2 | g", "T | N m | T K E_k", "V | N m | V U E_p", "L | N m | L | T - V", "E | N m | E H | T + V"]
    rows += [f"p{name} | N m s | p_{name} p_{text} | slope('T', 'd{name}')" for name, text in printed.items()]

    def states(q: Quantities) -> list[Values]:
        """The angles and rates (n, nv) at the states."""
        return [np.stack([q[d + name] for name in joints], -1) for d in ("", "d")]

    def solve(q: Quantities) -> dict[str, Values]:
        accelerations = np.array([dynamics.acceleration(0.0, *state) for state in zip(*states(q), strict=True)])
        return {f"dd{name}": accelerations[:, i] for i, name in enumerate(joints)}

    def energy(index: int) -> Formula:
        return lambda q: dynamics.energies(*states(q))[index]

    title = f"the scene's chain of {amount(len(rods), 'rod')}"
    more, table = {"T": energy(0), "V": energy(1)}, "\n".join(rows)
    return table_spec("scene", title, table, joints, tuple(values), more, solve, values=values, analytic=False)

"""Systems that are described by a table: the names of their quantities as they are written, and formulas for each."""

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from pendpin.doctor.reading.names import Written
from pendpin.doctor.systems.base import Dimension, Formula, Quantities, Spec, Values

# what a quantity is measured in, as powers of kg, m, s; - for components of several kinds
UNITS: dict[str, Dimension | None] = {
    "-": None,
    "1": (0, 0, 0),
    "kg": (1, 0, 0),
    "m": (0, 1, 0),
    "s": (0, 0, 1),
    "1/s": (0, 0, -1),
    "m/s": (0, 1, -1),
    "m/s2": (0, 1, -2),
    "kg m2": (1, 2, 0),
    "N": (1, 1, -2),
    "N m": (1, 2, -2),
    "N m s": (1, 2, -1),
}
Solve = Callable[[Quantities], dict[str, Values]]
_GREEK = ("theta", "phi", "alpha", "beta", "psi", "omega", "tau", "gamma")


class Table:
    """Names, units and writings of quantities, from lines such as "theta | 1 | theta q q_1"; `absent` have no name."""

    def __init__(self, text: str, absent: tuple[str, ...] = ()) -> None:
        rows = [[cell.strip() for cell in line.split("|")] for line in text.strip().splitlines()]
        self.units = {name: powers for name, unit, _ in rows if (powers := UNITS[unit]) is not None}
        ranked: dict[str, list[tuple[int, str]]] = {}
        for name, _, writings in rows:
            for rank, one in enumerate(writings.split() if name not in absent else ()):
                ranked.setdefault(one, []).append((rank, name))
        self.written = {one: tuple(name for _, name in sorted(names)) for one, names in ranked.items()}

    def words(self, fixed: frozenset[str], written: Written) -> tuple[str, ...]:
        """The meanings of a printed symbol; the rate of x is dx, and what is fixed has none."""
        index = written.index.replace("{", "").replace("}", "").replace(" ", "")
        key = written.letter + (f"_{index}" if index else "")
        names = self.written.get("*" + key, ()) if written.styled else ()
        names = [name for name in names or self.written.get(key, ()) if not (written.dots and name in fixed)]
        return tuple("d" * written.dots + name for name in names if not written.frames)


def table_spec(
    kind: str,
    title: str,
    table: Table,
    coordinates: tuple[str, ...],
    parameters: tuple[str, ...],
    formulas: Mapping[str, Formula],
    solve: Solve,
    atoms: tuple[str, ...] = (),
    extra: tuple[str, ...] = (),
    **others: Any,
) -> Spec:
    """A system of scalars, whose accelerations `solve` gives.

    `atoms` are sines and cosines that a missing term may have besides those of each angle, `extra` its other quantities.
    """
    dimensions = _dimensions(table, coordinates)
    rates, unknowns = (tuple(order + name for name in coordinates) for order in ("d", "dd"))
    angles = [name for name in coordinates if dimensions[name] == (0, 0, 0)]
    positions = MOVING & formulas.keys()
    timeless = {name for name, unit in table.units.items() if unit[2] == 0 and name in formulas} - positions
    still = frozenset(timeless | ({*parameters} & table.units.keys())) - {*coordinates}
    return Spec(
        kind=kind,
        title=title,
        coordinates=coordinates,
        parameters=parameters,
        unknowns=unknowns,
        formulas=formulas,
        solve=solve,
        words=partial(table.words, still | {*parameters}),
        dimensions=dimensions,
        printed={name: _latex(name, coordinates) for name in dimensions},
        still=still,
        common=(*coordinates, *rates, *unknowns, *parameters),
        families=_families(dimensions, {*coordinates, *parameters, *unknowns, *formulas, *rates}),
        moving=(*rates, *(f"{f} {angle}" for angle in angles for f in ("sin", "cos")), *atoms),
        extra=(*unknowns, *extra, *coordinates),
        **others,
    )


def _dimensions(table: Table, coordinates: tuple[str, ...]) -> dict[str, Dimension]:
    """Those of the table's quantities, and of rates and accelerations."""
    dimensions: dict[str, Dimension] = dict(table.units)
    for name in coordinates:
        kg, m, s = dimensions[name]
        dimensions |= {f"d{name}": (kg, m, s - 1), f"dd{name}": (kg, m, s - 2)}
    return dimensions


def _families(dimensions: dict[str, Dimension], names: set[str]) -> tuple[tuple[str, ...], ...]:
    """The names of each dimension, any of which may be mistaken for another."""
    groups: dict[Dimension, list[str]] = {}
    for name, unit in dimensions.items():
        if name in names:
            groups.setdefault(unit, []).append(name)
    return tuple(tuple(group) for group in groups.values())


# positions and mass matrices: they have no unit of time, and yet they move
MOVING = {*["rG", "q", "mass", "M11", "M12", "M22", "x", "y", "x1", "y1", "x2", "y2", "xp", "yp", "z"]}


def _latex(name: str, coordinates: tuple[str, ...]) -> str:
    """A name as it is printed where the text does not print it: ddtheta1 is \\ddot{\\theta}_1."""
    for coordinate in coordinates:
        for order in (2, 1):
            if name == "d" * order + coordinate:
                letter, index = _split(coordinate)
                return rf"\{'d' * order}ot{{{letter}}}{index}"
    return "".join(_split(name))


def _split(name: str) -> tuple[str, str]:
    letter = name.rstrip("0123456789")
    index = name[len(letter) :]
    return ("\\" + letter if letter in _GREEK else letter), f"_{index}" if index else ""

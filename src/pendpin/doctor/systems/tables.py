"""Systems that are described by a table: the names of their quantities as they are written, and formulas for each."""

from collections.abc import Callable, Mapping
from typing import Any

from pendpin.doctor.reading.names import Written
from pendpin.doctor.systems.base import Dimension, Formula, Quantities, Spec, Values

# what a quantity is measured in, as powers of kg, m, s
UNITS: dict[str, Dimension] = {
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
_GREEK = ("theta", "phi", "alpha", "beta", "psi", "omega", "tau", "gamma")


class Table:
    """Names, units and writings of quantities, from lines such as "theta | 1 | theta q q_1"."""

    def __init__(self, text: str) -> None:
        rows = [[cell.strip() for cell in line.split("|")] for line in text.strip().splitlines()]
        self.units: dict[str, Dimension] = {name: UNITS[unit] for name, unit, _ in rows}
        ranked: dict[str, list[tuple[int, str]]] = {}
        for name, _, writings in rows:
            for rank, one in enumerate(writings.split()):
                ranked.setdefault(one, []).append((rank, name))
        self.written = {one: tuple(name for _, name in sorted(found)) for one, found in ranked.items()}
        self.fixed: frozenset[str] = frozenset()  # names that have no rate

    def words(self, written: Written) -> tuple[str, ...]:
        """The meanings of a printed symbol; the rate of x is dx."""
        index = written.index.replace("{", "").replace("}", "").replace(" ", "")
        key = written.letter + (f"_{index}" if index else "")
        names = [name for name in self.written.get(key, ()) if not (written.dots and name in self.fixed)]
        return tuple("d" * written.dots + name for name in names if not written.frames)


def table_spec(
    kind: str,
    title: str,
    table: Table,
    coordinates: tuple[str, ...],
    parameters: tuple[str, ...],
    unknowns: tuple[str, ...],
    formulas: Mapping[str, Formula],
    solve: Callable[[Quantities], dict[str, Values]],
    atoms: tuple[str, ...] = (),
    extra: tuple[str, ...] = (),
    **others: Any,
) -> Spec:
    """A system of scalars. `atoms` are sines and cosines that a missing term may have besides those of each angle."""
    dimensions: dict[str, Dimension] = dict(table.units)
    for name in coordinates:
        kg, m, s = dimensions[name]
        dimensions |= {f"d{name}": (kg, m, s - 1), f"dd{name}": (kg, m, s - 2)}
    angles = [name for name in coordinates if dimensions[name] == (0, 0, 0)]
    circular = tuple(f"{f} {angle}" for angle in angles for f in ("sin", "cos"))
    rates = tuple(f"d{name}" for name in coordinates)
    still = frozenset(
        name for name in table.units if name in parameters or (dimensions[name][2] == 0 and name in formulas)
    )
    still -= {*coordinates, *(name for name in formulas if name in MOVING)}
    table.fixed = still | {*parameters}
    groups: dict[Dimension, list[str]] = {}
    for name, unit in dimensions.items():
        if name in (*coordinates, *parameters, *unknowns, *formulas, *rates):
            groups.setdefault(unit, []).append(name)
    return Spec(
        kind=kind,
        title=title,
        coordinates=coordinates,
        parameters=parameters,
        unknowns=unknowns,
        formulas=formulas,
        solve=solve,
        words=table.words,
        dimensions=dimensions,
        printed={name: _latex(name, coordinates) for name in dimensions},
        still=still,
        common=(*coordinates, *rates, *unknowns, *parameters),
        families=tuple(tuple(group) for group in groups.values()),
        moving=(*rates, *circular, *atoms),
        extra=(*unknowns, *extra, *coordinates),
        **others,
    )


MOVING = {"x", "y", "x1", "y1", "x2", "y2", "xp", "yp", "z"}  # positions, which have no unit of time


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

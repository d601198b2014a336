"""Systems that are described by a table: the names of their quantities as they are written, and formulas for each."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
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
        self.written = {one: tuple(name for _, name in sorted(found)) for one, found in ranked.items()}
        self.fixed: frozenset[str] = frozenset()  # names that have no rate

    def words(self, written: Written) -> tuple[str, ...]:
        """The meanings of a printed symbol; the rate of x is dx."""
        index = written.index.replace("{", "").replace("}", "").replace(" ", "")
        key = written.letter + (f"_{index}" if index else "")
        names = self.written.get("*" + key, ()) if written.styled else ()
        names = [name for name in names or self.written.get(key, ()) if not (written.dots and name in self.fixed)]
        return tuple("d" * written.dots + name for name in names if not written.frames)


@dataclass(frozen=True)
class Motion:
    """Coordinates, parameters, the quantities that follow from these, and the accelerations of the coordinates."""

    coordinates: tuple[str, ...]
    parameters: tuple[str, ...]
    formulas: Mapping[str, Formula]
    solve: Callable[[Quantities], dict[str, Values]]

    @property
    def unknowns(self) -> tuple[str, ...]:
        """The accelerations."""
        return tuple(f"dd{name}" for name in self.coordinates)

    @property
    def rates(self) -> tuple[str, ...]:
        """The rates of the coordinates."""
        return tuple(f"d{name}" for name in self.coordinates)


def table_spec(
    kind: str,
    title: str,
    table: Table,
    motion: Motion,
    atoms: tuple[str, ...] = (),
    extra: tuple[str, ...] = (),
    **others: Any,
) -> Spec:
    """A system of scalars. `atoms` are sines and cosines that a missing term may have besides those of each angle."""
    dimensions = _dimensions(table, motion)
    angles = [name for name in motion.coordinates if dimensions[name] == (0, 0, 0)]
    still = _still(table, motion)
    table.fixed = still | {*motion.parameters}
    return Spec(
        kind=kind,
        title=title,
        coordinates=motion.coordinates,
        parameters=motion.parameters,
        unknowns=motion.unknowns,
        formulas=motion.formulas,
        solve=motion.solve,
        words=table.words,
        dimensions=dimensions,
        printed={name: _latex(name, motion.coordinates) for name in dimensions},
        still=still,
        common=(*motion.coordinates, *motion.rates, *motion.unknowns, *motion.parameters),
        families=_families(dimensions, motion),
        moving=(*motion.rates, *(f"{f} {angle}" for angle in angles for f in ("sin", "cos")), *atoms),
        extra=(*motion.unknowns, *extra, *motion.coordinates),
        **others,
    )


def _dimensions(table: Table, motion: Motion) -> dict[str, Dimension]:
    """Those of the table's quantities, and of rates and accelerations."""
    found: dict[str, Dimension] = dict(table.units)
    for name in motion.coordinates:
        kg, m, s = found[name]
        found |= {f"d{name}": (kg, m, s - 1), f"dd{name}": (kg, m, s - 2)}
    return found


def _still(table: Table, motion: Motion) -> frozenset[str]:
    """What does not move: parameters, and formulas without a unit of time but for positions."""
    follows = {name for name, unit in table.units.items() if unit[2] == 0 and name in motion.formulas}
    given = {name for name in motion.parameters if name in table.units}
    return frozenset(follows | given) - {*motion.coordinates, *(MOVING & motion.formulas.keys())}


def _families(dimensions: dict[str, Dimension], motion: Motion) -> tuple[tuple[str, ...], ...]:
    """The quantities of each dimension, any of which may be mistaken for another."""
    known = {*motion.coordinates, *motion.parameters, *motion.unknowns, *motion.formulas, *motion.rates}
    groups: dict[Dimension, list[str]] = {}
    for name, unit in dimensions.items():
        if name in known:
            groups.setdefault(unit, []).append(name)
    return tuple(tuple(group) for group in groups.values())


# positions and mass matrices, which have no unit of time
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

"""Systems that are described by files: plane.md, double.md and so on, one for each family, read once.

A file has tables: what the system is, the choices of which each combination is a system of its own, and its quantities with
their units, how they are written, and their formulas. docs/systems.md shows these tables, and says how they are read.
"""

import re
from collections import defaultdict
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from importlib import resources
from itertools import product
from types import MappingProxyType
from typing import Any, NamedTuple

from pendpin.doctor.reading.names import GREEK, Written
from pendpin.doctor.systems.base import Dimension, Formula, Quantities, Spec, Values, dot, formulas, inverse

# what a quantity is measured in, as powers of kg, m, s; - for what has several units, or what no text names
UNITS: dict[str, Dimension | None] = {"-": None, "1": (0, 0, 0), "kg": (1, 0, 0), "kg m": (1, 1, 0), "m": (0, 1, 0)}
UNITS |= {"s": (0, 0, 1), "1/s": (0, 0, -1), "1/s2": (0, 0, -2), "m/s": (0, 1, -1), "m/s2": (0, 1, -2)}
UNITS |= {"kg m2": (1, 2, 0), "N": (1, 1, -2), "N m": (1, 2, -2), "N m s": (1, 2, -1), "N/m": (1, 0, -2)}
# a row with one of these is several: of rates, angles, bodies and axes
MARKS = {"{d}": ("", "d", "dd"), "{q}": ("theta", "phi"), "{n}": "12", "{i}": "123", "{c}": "xyz"}
# indices of the centre of mass, of energies, and of how a frame turns
INDICES = {"~": "_ _G _C _CG _cm _com _GO _OG", "%": "_ _k _c _p _kin _pot _tot", "&": "_ _B _BI _IB _AB"}
POSED = ("across", "high", "rise")  # functions that are a sine or a cosine in each pose
_POSED = re.compile(rf"\b(?:{'|'.join(POSED)})(?=\()")
# positions and mass matrices: they have no unit of time, and yet they move
MOVING = re.compile(r"path|r[Gp12A]|q|mass|M\d\d|[xy][0123p]?|z|e[rtp]")

Table = list[list[str]]  # the cells of its head and of each row


class Row(NamedTuple):
    """A quantity: its name, its unit, how it is written, and the formula of what is no coordinate or parameter."""

    quantity: str
    unit: str
    written: str = ""
    formula: str = ""
    printed: str = ""  # where the text does not print it
    rate: str = ""  # of the rod: its name, where it has a letter of its own

    @property
    def dimension(self) -> Dimension | None:
        """Its unit as powers of kg, m, s."""
        return UNITS[self.unit]


@dataclass(frozen=True)
class Variant:
    """One combination of the choices of a file: what it says about such a system, what they give, and its quantities."""

    kind: str
    title: str
    about: Mapping[str, Sequence[str]]
    given: Mapping[str, str]
    rows: list[Row]


@cache
def read_tables(name: str) -> list[Table]:
    """The tables of a file of this folder."""
    text = resources.files("pendpin.doctor.systems").joinpath(f"{name}.md").read_text(encoding="utf-8")
    tables = list[Table]()
    for block in re.findall(r"(?:^\|.*\n)+", text, re.M):
        head, _, *lines = block.replace("`", "").splitlines()
        for mark, values in MARKS.items():
            lines = [line.replace(mark, value) for line in lines for value in (values if mark in line else ("",))]
        tables.append([[cell.strip() for cell in line.split("|")[1:-1]] for line in (head, *lines)])
    return tables


def plain_name(word: str) -> str:
    """A word whatever its index is set in: m_p, m_{P} and mp are one, as l_c1, l_{c,1}, l_{c_1} and lc1; c_{1+2} is c_12."""
    plain = re.sub(r"[{}\s,_/+]", "", word)
    return plain[:1] + (plain[1:] if plain[1:] == "M" else plain[1:].lower())  # T_M beside T_m


def names_written(writings: Mapping[str, str]) -> dict[str, tuple[str, ...]]:
    """What a word may mean, the likeliest first, from the writings of each name, its likeliest first.

    A * stands before what is printed with a hat or in bold type, a + before what may be printed either way, and @ for the
    axis of the name, as a number or a letter; a last sign of INDICES for each of its indices.
    """
    ranked: dict[str, list[tuple[int, str]]] = {}
    for name, every in writings.items():
        axis = re.search(r"[123xyz]", name)
        pair = next((pair for pair in ("1x", "2y", "3z") if axis and axis[0] in pair), "")
        words = (one[:-1] + index for one in every.split() for index in INDICES.get(one[-1], one[-1]).split())
        for rank, one in enumerate(words):
            for word in {one.replace("@", mark) for mark in pair} if "@" in one else (one,):
                styles = ("", "*") if word[0] == "+" else ("*" * (word[0] == "*"),)
                for style in styles:
                    ranked.setdefault(style + plain_name(word.lstrip("*+")), []).append((rank, name))
    return {word: tuple(dict.fromkeys(name for _, name in sorted(names))) for word, names in ranked.items()}


def read_choices(tables: list[Table]) -> dict[str, dict[str, tuple[str, dict[str, str]]]]:
    """The choices that tables offer: of each of its kinds how a title names it, and the formulas that it gives."""
    pairs = lambda cell: dict(pair.split(" = ") for pair in cell.split("; ") if pair)  # noqa: E731
    return {head[0]: {kind: (words, pairs(gives)) for kind, words, gives in rows} for head, *rows in tables}


*_SHARED_CHOICES, _SHARED_QUANTITIES = read_tables("common")
SHARED = read_choices(_SHARED_CHOICES)


def variants(name: str, **chosen: str) -> Iterator[Variant]:
    """Each combination of the choices of a file; `chosen` names the kinds of some of them in place of the file."""
    (_, *lines), *own, (head, *rows) = read_tables(name)
    about, choices = dict(lines) | chosen, SHARED | read_choices(own)
    names = [key for key in dict.fromkeys([*about, *(table[0][0] for table in own)]) if key in choices]
    for kinds in product(*(about[name].split() if name in about else choices[name] for name in names)):
        words, given = dict[str, str](), dict[str, str]()
        for choice, kind in zip(names, kinds, strict=True):
            words[choice], formulas_of_kind = choices[choice][kind]
            given |= formulas_of_kind
        posed = {function: given.pop(function) for function in POSED if function in given}
        in_pose = lambda cell, posed=posed: _POSED.sub(lambda match: posed[match[0]], cell)  # noqa: E731
        kind = about["kind"].format(**dict(zip(names, kinds, strict=True)))
        yield Variant(
            kind=" ".join(word for word in kind.split() if word != "-"),
            title=" ".join(about["title"].format(**words).split()),
            about={key: _kept(cell, kinds) for key, cell in about.items()},
            given=given,
            rows=[Row(**dict(zip(head, map(in_pose, row), strict=True))) for row in rows],
        )


def _kept(cell: str, kinds: Collection[str]) -> list[str]:
    """The words of a cell; those with kinds in brackets only where one of these is chosen."""
    pairs = re.findall(r"([^\s\[]+)(?:\[(\S+)\])?", cell)
    return [word for word, only in pairs if not only or {*only.split(",")} & {*kinds}]


def table_spec(
    variant: Variant,
    solve: Callable[[Quantities], dict[str, Values]] | None = None,
    more: Mapping[str, Formula] = MappingProxyType({}),
    **others: Any,
) -> Spec:
    """A system of scalars, whose accelerations `solve` gives, or its mass matrix, mass, and its forces, force_.

    `more` holds formulas beside those of its rows.
    """
    about, rows = defaultdict(tuple, variant.about), variant.rows
    coordinates = tuple(about["coordinates"])
    parameters = tuple(name for name in about["parameters"] if name not in variant.given)
    texts = {row.quantity: row.formula for row in rows if row.formula and row.quantity not in parameters}
    every = {**formulas(texts | dict(variant.given)), **more}

    dimensions = {row.quantity: powers for row in rows if (powers := row.dimension) is not None}
    timeless = {name for name, unit in dimensions.items() if unit[2] == 0 and name in every}
    timeless = {name for name in timeless if not MOVING.fullmatch(name)}
    still = frozenset(timeless | ({*parameters} & dimensions.keys())) - {*coordinates}
    for name in coordinates:
        kg, m, s = dimensions[name]
        dimensions |= {f"d{name}": (kg, m, s - 1), f"dd{name}": (kg, m, s - 2)}
    places = tuple(name for name in every if re.fullmatch(r"[xy]p?\d?", name))
    dimensions |= {f"d{name}": (0, 1, -1) for name in places}
    printed = {row.quantity: row.printed for row in rows}
    written = names_written({row.quantity: row.written for row in rows if row.quantity not in about["unwritten"]})

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
    families: dict[Dimension, list[str]] = {}  # the names of each dimension, any of which may be mistaken for another
    for name, unit in dimensions.items():
        if name in {*coordinates, *parameters, *unknowns, *every, *rates} or name.lstrip("d") in places:
            families.setdefault(unit, []).append(name)
    return Spec(
        kind=variant.kind,
        title=variant.title,
        coordinates=coordinates,
        parameters=parameters,
        unknowns=unknowns,
        formulas=every,
        solve=solve or accelerations,
        words=words,
        dimensions=dimensions,
        printed={name: printed.get(name) or _latex(name, (*coordinates, *places)) for name in dimensions},
        still=still,
        common=(*coordinates, *rates, *unknowns, *parameters),
        families=tuple(map(tuple, families.values())),
        turning=(*(name for name in coordinates if dimensions[name] == (0, 0, 0)), *about["differences"]),
        extra=(*unknowns, *about["terms"], *coordinates),
        **others,
    )


def _latex(name: str, coordinates: tuple[str, ...]) -> str:
    """A name as it is printed where the text does not print it: ddtheta1 is \\ddot{\\theta}_1."""
    dots = next((n for n in (2, 1) if name[:n] == "d" * n and name[n:] in coordinates), 0)
    letter = name[dots:].rstrip("0123456789")
    index = f"_{name[dots + len(letter) :]}".removesuffix("_")
    letter = "\\" + letter if letter in GREEK else letter
    return rf"\{'d' * dots}ot{{{letter}}}{index}" if dots else letter + index


def family(name: str, **chosen: str) -> list[Spec]:
    """The systems of a file, as `variants` lists them."""
    shared = [Row(*cells) for cells in _SHARED_QUANTITIES[1:]]
    found = []
    for variant in variants(name, **chosen):
        numbers = {
            name: float(number) for name, number in (pair.split("=") for pair in variant.about.get("values", ()))
        }
        found.append(table_spec(replace(variant, rows=shared + variant.rows), values=numbers))
    return found


BODIES, POSES = SHARED["bodies"].keys(), SHARED["pose"].keys()
FAMILIES = {
    "plane": family("plane"),
    "moved": family("moved"),
    "elastic": family("elastic"),
    "pulled": family("pulled"),
    "cart-pole": family("cart-pole"),
    "cart-double": family("cart-double"),
    "double": [spec for spec in family("double") if not {"tip", "equal"} <= {*spec.kind.split()}],
    "triple": family("triple"),
    "acrobot": family("double", angles="relative", equal="-", drive="acrobot both"),
    "polar": family("polar"),
    "conical": family("conical"),
    "turning": family("turning"),
    "coupled": family("coupled"),
    "furuta": family("furuta"),
}

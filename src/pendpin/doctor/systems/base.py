"""A system of mechanics as the doctor needs it: names, random states, and every quantity computed when it is asked for."""

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field, replace
from functools import cache, cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pendpin.doctor.reading.names import Written
from pendpin.doctor.reading.tree import Unread

Values = NDArray[Any]  # (n,), (k, n) or (k, j, n): scalars, vectors, matrices, at n states
Formula = Callable[["Quantities"], Values]
Words = Callable[[Written], tuple[str, ...]]
Dimension = tuple[int, int, int]  # powers of kg, m, s

STATES = 60  # half of them share the parameters of the other half
LOADS = ("F", "tau1", "tau2")  # parameters that are small where the motion is
STEP = 1e-3  # of the inner of two derivatives: the eighth order leaves 1e-12 of functions that vary within 0.1 rad
DIGITS_STEP = "1e-6"  # the same in 50 digits: 1e-40
MOST_NESTED = 3  # derivatives of derivatives
STENCIL = ((1, 4, 5), (2, -1, 5), (3, 4, 105), (4, -1, 280))  # central differences of eighth order


NUMBERS = ("sin", "cos", "sqrt", "pi")  # what a formula may use of its type of number
SIGNS = ("theta_sign", "phi_sign", "swapped", "along", "y_sign", "z_sign")  # and of the convention
FUNCTIONS = {*NUMBERS, "dot", "vector", *SIGNS}


@cache
def formula(text: str) -> Formula:
    """A formula from its text in Python: names are quantities, or those of FUNCTIONS.

    Vectors are arrays (3, n), scalars (n,): `vector` stacks scalars to a vector, and vectors to a matrix.
    """
    code = compile(text, text, "eval")
    names = [name for name in code.co_names if name not in FUNCTIONS]

    def value(q: "Quantities") -> Values:
        found = eval(code, q.functions, {name: q[name] for name in names})  # a table's text, never a document's
        return found if isinstance(found, np.ndarray) else q.number(found)

    return value


def formulas(texts: Mapping[str, str]) -> dict[str, Formula]:
    """Formulas from their texts."""
    return {name: formula(text) for name, text in texts.items()}


@dataclass(frozen=True)
class Convention:
    """How a text on a rod differs from the convention of docs/derivation.md."""

    theta: int = 1  # -1: counter-clockwise positive
    phi: int = 1  # -1: reversed
    swapped: bool = False  # phi is the first angle, theta the second
    z: str = "down"  # "up": y and z of I reversed; "mirrored": z alone
    along: int = 1  # -1: b3 points from the tip to the joint, and b2, a2, a3 are reversed with it
    transposed: bool = False  # direction cosine matrices with rows and columns exchanged

    @property
    def differences(self) -> tuple[str, ...]:
        """Each difference, in words."""
        return tuple(words for field, value, words in DIFFERENCES.values() if getattr(self, field) == value)

    @property
    def words(self) -> str:
        """The differences in one line."""
        return ", ".join(self.differences)


DIFFERENCES: dict[str, tuple[str, Any, str]] = {  # by its name in --convention: the field, its value, and in words
    "theta-ccw": ("theta", -1, "theta is positive counter-clockwise"),
    "phi-reversed": ("phi", -1, "phi is reversed"),
    "swapped": ("swapped", True, "the names of the angles are swapped"),
    "z-up": ("z", "up", "z points up"),
    "z-mirrored": ("z", "mirrored", "z points up and y as usual"),
    "b3-up": ("along", -1, "b3 points from the tip to the joint"),
    "transposed": ("transposed", True, "direction cosine matrices are transposed"),
}


@dataclass(frozen=True, eq=False)
class Spec:
    """What is true of a kind of system.

    `solve` gives the unknowns, accelerations and reactions, of the true motion. `families` are names that are written one
    for another.
    """

    kind: str
    title: str  # as in "for a uniform thin rod"
    coordinates: tuple[str, ...]
    parameters: tuple[str, ...]
    unknowns: tuple[str, ...]
    formulas: Mapping[str, Formula]
    solve: Callable[["Quantities"], dict[str, Values]]
    words: Words
    dimensions: Mapping[str, Dimension]
    printed: Mapping[str, str]  # the names in LaTeX
    still: frozenset[str]  # what does not move
    common: tuple[str, ...] = ()  # names that any other may have been mistaken for
    families: tuple[tuple[str, ...], ...] = ()
    arrays: frozenset[str] = frozenset()  # vectors and matrices
    turning: tuple[str, ...] = ()  # what stands in sines and cosines: angles, their differences
    extra: tuple[str, ...] = ()  # atoms of which one may stand in a monomial
    values: Mapping[str, float] = field(default_factory=dict)  # parameters that are numbers
    analytic: bool = True  # whether its formulas take complex numbers and symbols

    @property
    def rates(self) -> tuple[str, ...]:
        """The rates of the coordinates."""
        return tuple(f"d{name}" for name in self.coordinates)

    @property
    def state(self) -> tuple[str, ...]:
        """Coordinates and rates."""
        return (*self.coordinates, *self.rates)

    @property
    def moving(self) -> tuple[str, ...]:
        """Atoms of monomials: rates, sines and cosines."""
        return (*self.rates, *(f"{name} {angle}" for angle in self.turning for name in ("sin", "cos")))

    def momentum(self, coordinate: str) -> str:
        """The name of a coordinate's momentum; empty where it has none."""
        return next((p for p in (f"p{coordinate}", f"p{coordinate[-1]}", "p") if p in self.formulas), "")


@cache
def unloaded(spec: Spec) -> Spec:
    """The same system without the loads that may act on it."""
    return with_zeros(spec, [name for name in LOADS if name in spec.parameters])


def with_zeros(spec: Spec, names: Collection[str]) -> Spec:
    """The same system in which some parameters are 0."""
    kept = tuple(name for name in spec.parameters if name not in names)
    zeros = formulas(dict.fromkeys(names, "0"))
    return replace(spec, parameters=kept, formulas={**spec.formulas, **zeros}) if names else spec


@dataclass(frozen=True)
class System:
    """What the equations of a text are about, in the convention of the text."""

    spec: Spec
    convention: Convention = Convention()
    scale: float = 1.0  # of the states and loads: tiny where only terms of the first order count

    @property
    def kind(self) -> str:
        """Its name in --rod and --system."""
        return self.spec.kind


class Quantities:
    """Every quantity by its name, computed once and when it is asked for.

    `base` holds arrays (n,) of the coordinates, rates and parameters, and of the unknowns where they are free; `xp` the
    functions of their number type. `true` says that the unknowns are those of the true motion.
    """

    def __init__(self, base: Mapping[str, Values], system: System, xp: Any, true: bool = False, depth: int = 0) -> None:
        self.system, self.xp, self.base, self.true, self.depth = system, xp, base, true, depth
        self.spec, self.convention = system.spec, system.convention
        self.shape = np.shape(base[system.spec.coordinates[0]])
        self._values: dict[str, Values] = dict(base)
        self._numbers: dict[int, Values] = {}
        self._moved: dict[tuple[str, int], Quantities] = {}

    @cached_property
    def functions(self) -> dict[str, Any]:
        """What FUNCTIONS are for these numbers and this convention."""
        own, numbers = self.convention, {name: getattr(self.xp, name) for name in NUMBERS}
        vector = lambda *rows: np.stack([r if isinstance(r, np.ndarray) else self.number(r) for r in rows])  # noqa: E731
        up_down = -1 if own.z == "up" else 1, 1 if own.z == "down" else -1
        signs = dict(zip(SIGNS, (own.theta, own.phi, own.swapped, own.along, *up_down), strict=True))
        return numbers | signs | {"dot": dot, "vector": vector}

    def __getitem__(self, name: str) -> Values:
        """A quantity: scalars (n,), vectors (3, n) and tensors (3, 3, n) in I. Raises KeyError for an unknown name."""
        if name not in self._values:
            if self.true and name in self.spec.unknowns:
                self._values |= self.spec.solve(self)
            elif name in self.spec.formulas:
                self._values[name] = self.spec.formulas[name](self)
            elif name[:1] == "d" and name[1:] in self and name[1:] not in self.base:
                self._values[name] = self.derivative(lambda q: q[name[1:]], "t")
            else:
                raise KeyError(name)
        return self._values[name]

    def __contains__(self, name: str) -> bool:
        """Whether a name has a meaning."""
        spec = self.spec
        here = name in self._values or name in spec.formulas or (self.true and name in spec.unknowns)
        return here or (name[:1] == "d" and name[1:] in self and name[1:] not in self.base)

    def number(self, value: int) -> Values:
        """A whole number, for every state."""
        if value not in self._numbers:
            kind = float if self.xp is np else object
            self._numbers[value] = self.xp.asarray(np.full(self.shape, value, dtype=kind))
            self._numbers[value].setflags(write=False)  # it is shared
        return self._numbers[value]

    def direction(self, variable: str) -> dict[str, Values]:
        """How the state moves: along the motion for t, or one coordinate or rate alone."""
        if variable != "t":
            return {variable: self.number(1)}
        lost: Any = np.nan  # where an acceleration is not known: it spoils what depends on it
        moves = {rate[1:]: self[rate] for rate in self.spec.rates}
        known = ((rate, f"d{rate}") for rate in self.spec.rates)
        moves |= {"t": self.number(1)} if "t" in self.base else {}
        return moves | {rate: self[name] if name in self else self.number(1) * lost for rate, name in known}

    def derivative(self, function: Formula, variable: str) -> Values:
        """The derivative of a function of the state, in time along the motion or by a coordinate or rate.

        Of real numbers by a complex step, which has no rounding; within that by central differences. Of polynomials by
        the rules. Raises Unread where the rate of an acceleration or reaction is needed and not known.
        """
        if self.depth == MOST_NESTED:
            raise Unread(f"more than {MOST_NESTED} derivatives of each other")
        if hasattr(self.xp, "derivative"):
            return self.xp.derivative(self, function, variable)
        with np.errstate(all="ignore"):  # what is not finite is refused where it is compared
            rate = self._slope(function, variable)
        if variable == "t" and (rate != rate).any() and not all(f"d{name}" in self for name in self.spec.rates):
            raise KeyError("the rate of an acceleration")
        return rate

    def _slope(self, function: Formula, variable: str) -> Values:
        real = self.spec.analytic and self.xp is np and not np.iscomplexobj(next(iter(self.base.values())))
        if real:
            return np.imag(function(self._at(variable, 0, 1e-30j))) / 1e-30
        step = STEP if self.xp is np else self.xp.asarray(DIGITS_STEP)
        total: Any = 0
        for k, above, below in STENCIL:
            there, back = (function(self._at(variable, i, i * step)) for i in (k, -k))
            total = total + (there - back) * self.number(above) / self.number(below)
        return total / step

    def _at(self, variable: str, index: int, step: Any) -> "Quantities":
        """The quantities at a state moved by a step; the unknowns are solved for again, or not known there."""
        if (variable, index) not in self._moved:
            gone = self.spec.unknowns if variable == "t" else ()
            base = {name: value for name, value in self.base.items() if name not in gone}
            zero = 0 * step  # so that all are complex where one is
            base = {name: value + zero for name, value in base.items()} if np.iscomplexobj(step) else base
            base |= {name: self[name] + rate * step for name, rate in self.direction(variable).items()}
            self._moved[variable, index] = Quantities(base, self.system, self.xp, self.true, self.depth + 1)
        return self._moved[variable, index]


@cache
def random_states(system: System, instead: tuple[tuple[str, float | Formula], ...] = ()) -> Quantities:
    """Quantities at random states of the true motion.

    `instead` gives parts of the state or parameters a value, or one that the others determine.
    """
    base = random_base(system.spec, STATES)
    base |= {name: base[name] * system.scale for name in (*system.spec.state, *LOADS) if name in base}
    for name, value in instead:
        if name in base:
            base[name] = value(Quantities(base, system, np)) if callable(value) else np.full(STATES, value)
    return Quantities(base, system, np, true=True)


def random_base(spec: Spec, count: int, seed: int = 0) -> dict[str, Values]:
    """Random states (count,): angles off the axes, rates of both signs, parameters between 0.5 and 2."""
    random = np.random.default_rng(seed)
    half = count // 2
    base = {name: random.uniform(0.15, 1.4, count) * random.choice([-1, 1], count) for name in spec.state}
    for name in (one for one in spec.coordinates if spec.dimensions.get(one) == (0, 1, 0)):
        base[name] = np.abs(base[name])  # as the length of a spring
    for name in spec.parameters:
        base[name] = np.tile(np.exp(random.uniform(-0.7, 0.7, half)), 2)
        if name in spec.values:
            base[name] = np.full(count, spec.values[name])
    if "t" in base:
        base["t"] = random.uniform(0.5, 2, count)
    return base


@cache
def free_states(system: System) -> Quantities:
    """Quantities at random states in which accelerations and reactions are random too, off the true motion."""
    random = np.random.default_rng(3)
    free = {name: random.uniform(0.5, 2, STATES) for name in system.spec.unknowns}
    return Quantities(random_base(system.spec, STATES, seed=2) | free, system, np)


def dot(a: Values, b: Values) -> Values:
    """The dot product of two vectors (3, n)."""
    return (a * b).sum(0)


def cross(a: Values, b: Values) -> Values:
    """The cross product of two vectors (3, n)."""
    return np.stack([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def inverse(matrix: Values, quantities: Quantities) -> Values:
    """The inverse of a matrix (k, k, n), by elimination: its pivots are not 0, as those of a mass matrix."""
    k, (zero, one) = len(matrix), map(quantities.number, (0, 1))
    rows = [np.stack([*matrix[i], *(one if i == j else zero for j in range(k))]) for i in range(k)]
    with np.errstate(all="ignore"):
        for i in range(k):
            rows[i] = rows[i] / rows[i][i]
            rows = [row if j == i else row - row[i] * rows[i] for j, row in enumerate(rows)]
    return np.stack(rows)[:, k:]

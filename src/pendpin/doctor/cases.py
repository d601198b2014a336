"""An equation with its reading and what is found about it so far, and from which wrong one another follows."""

from contextlib import suppress
from dataclasses import replace
from functools import cached_property
from itertools import combinations

import numpy as np

from pendpin.doctor.checking.check import lagrange_residuals
from pendpin.doctor.checking.evaluation import Equation
from pendpin.doctor.checking.residuals import TOLERANCE, holds, stack_residuals
from pendpin.doctor.printed import Printed
from pendpin.doctor.reading.names import LENGTH, MASS
from pendpin.doctor.reading.tree import Node, Unread, Written, names_in, parts
from pendpin.doctor.recognition import Reading
from pendpin.doctor.report import Finding
from pendpin.doctor.systems.base import Dimension, Quantities, System, Values, random_states

RATIO = 1e-7  # of two residuals that are multiples of each other: of second derivatives eight digits are left


class Case:
    """An equation, its reading, and what is found about it so far."""

    def __init__(self, finding: Finding, one: Printed, reading: Reading) -> None:
        self.finding, self.one, self.reading = finding, one, reading
        self.system, self.spec = reading.system, reading.system.spec
        side = one.sides[0] if one.sides else None
        self.left: Written | None = side.written if side and side.kind == "symbol" else None  # what stands alone there

    @property
    def confirmed(self) -> bool:
        """Whether it holds, if only under a condition."""
        return self.finding.verdict in ("holds", "holds if")

    @property
    def is_true(self) -> bool:
        """Whether it holds and is more than a definition."""
        return self.confirmed and self.finding.equation is not None and self.finding.kind != "definition"

    @property
    def mends_itself(self) -> bool:
        """Whether its first mend is of the equation, and not of a definition that it uses."""
        return bool(self.finding.mends) and " in the definition of " not in self.finding.mends[0].words

    @property
    def entry(self) -> str:
        """What its first side means where that is a symbol, before the text gives it another meaning."""
        return str(self.one.sides[0].value) if self.one.sides and self.one.sides[0].kind == "symbol" else ""

    @cached_property
    def written(self) -> set[Written]:
        """The names that stand in it."""
        return {part.written for part in parts(self.one.sides) if part.written}

    @cached_property
    def measures(self) -> dict[Written, Values]:
        """The values of its names that mean masses, or lengths which do not change."""
        spec, true, found = self.spec, random_states(self.system), dict[Written, Values]()
        for part in parts(self.one.sides) if self.finding.equation else ():
            what = self.finding.equation.meaning(str(part.value)) if self.finding.equation else ""
            if (
                part.kind == "symbol"
                and part.written
                and what in spec.still
                and spec.dimensions.get(what) in (MASS, LENGTH)
            ):
                found[part.written] = true[what]
        return found

    @cached_property
    def motions(self) -> list[Quantities]:
        """The motions that it allows though it is wrong, with as many of Lagrange's equations as that needs.

        It is a law of accelerations, or an energy that takes the place of the true one.
        """
        names = [f"dd{name}" for name in self.spec.coordinates]
        true, law = random_states(self.system), self.finding.equation
        if law is None or "mass" not in self.spec.formulas or not (self.is_energy or law.names & {*names}):
            return []
        if law.energies and not self.is_energy:
            return []

        def off(q: Quantities) -> Values:
            if not self.is_energy:
                return stack_residuals(law, q, plain=True)
            wrong, right = (lagrange_residuals(side, law, q) for side in (law.sides[-1], law.sides[0]))
            forces = np.einsum("ijn,jn->in", q["mass"], np.stack([q[name] for name in names])) - q["force_"]
            return forces + (right - wrong if self.meaning() == "V" else wrong - right)

        base = {**true.base, **{name: true[name] for name in self.spec.unknowns}}
        found = list[Quantities]()
        with suppress(Unread, KeyError, ValueError, np.linalg.LinAlgError), np.errstate(all="ignore"):
            trials = ({one: true[one] * 0 + float(one == name) for one in names} for name in ("", *names))
            at_rest, *moved = (off(Quantities(base | trial, self.system, np)) for trial in trials)
            slopes = np.array([there - at_rest for there in moved])  # (coordinates, rows, n)
            kept = np.flatnonzero(np.abs(slopes).max((0, 2)) > TOLERANCE * np.abs(slopes).max())[: len(names)]
            for others in map(list, combinations(range(len(names)), len(names) - len(kept))):
                rows = np.concatenate([slopes[:, kept].transpose(1, 0, 2), true["mass"][others]])
                offs = np.concatenate([at_rest[kept], -true["force_"][others]])
                solution = np.linalg.solve(rows.transpose(2, 0, 1), -offs.T[..., None])[..., 0].T
                there = Quantities(base | dict(zip(names, solution, strict=True)), self.system, np)
                found += [there] * (self.is_energy or holds(law, there))
        return found

    @property
    def is_energy(self) -> bool:
        """Whether it gives the kinetic or potential energy, or the Lagrangian."""
        return self.left is not None and len(self.one.sides) > 1 and self.meaning() in ("T", "V", "L")

    def meaning(self) -> str:
        """What its first side means, if that is a name."""
        name = str(self.one.sides[0].value)
        return self.finding.equation.meaning(name) if self.finding.equation else name

    @property
    def unit(self) -> Dimension | None:
        """The powers of kg, m, s of what its first side means; of a state none, which may get any name."""
        return None if self.meaning() in self.spec.state else self.spec.dimensions.get(self.meaning())

    def says(self, **said: object) -> None:
        """Another finding takes the place of what was found."""
        self.finding = replace(self.finding, **said)

    def doubt(self, words: str, **said: object) -> None:
        """It is no accusation, and holds no longer, if words say why."""
        if words:
            self.says(**{"verdict": "not checked", "remark": words, "mends": (), "proved": False, **said})


def plain(name: Written) -> str:
    """A name as it is typed."""
    return name.letter + ("_" + name.index if name.index else "")


def size_of(one: Printed) -> int:
    """How many numbers, letters, sums, products and the like an equation has."""
    return sum(1 for _ in parts(one.sides))


def says(one: Printed) -> bool:
    """Whether an equation says more than names."""
    return any(part.kind in ("sum", "product", "power", "derivative") for part in parts(one.sides))


def find_source(equation: Equation, wrong: list[Case], system: System) -> int:
    """The first wrong equation that another one follows from; 0 for none.

    What it is off by, in each of its components, is what an earlier one is off by, or what follows of that for the motion.
    """
    states, known = random_states(system), list[tuple[int, np.ndarray]]()
    with suppress(Unread, KeyError, ValueError):
        off = stack_residuals(equation, states, plain=True)
        for source in wrong:
            number, other = source.finding.number, source.finding.equation
            assert other is not None
            with suppress(Unread, KeyError, ValueError):
                known += [(number, row) for row in stack_residuals(other, states, plain=True)]
        rows = [row for row in off if np.abs(row).max() > TOLERANCE * np.abs(off).max()]
        sources = [next((number for number, other in known if _is_multiple(row, other)), 0) for row in rows]
        if source := min(sources, default=0):
            return source
    if equation.energies or not equation.names & {f"dd{name}" for name in system.spec.coordinates}:
        return 0
    with np.errstate(all="ignore"):
        alike = (case for case in wrong if case.system is system)
        return next((one.finding.number for one in alike if any(holds(equation, there) for there in one.motions)), 0)


def is_contradicted(case: Case, others: list[Case]) -> bool:
    """Whether others of its system would not hold, were it right: in no motion that it allows they all do.

    What gives the whole Lagrangian or energy contradicts any wrong law. Of what is no law nothing is known.
    """
    laws = [one for one in others if one is not case and one.is_true and one.spec is case.spec and says(one.one)]
    given = {one.meaning() for one in laws if one.left}
    if case.meaning() in map(case.spec.momentum, case.spec.coordinates):
        return bool(given & {"T", "L", "E"})
    if _is_between_laws(case, others):
        return True
    every = [one.finding.equation for one in laws if one.finding.equation]
    whole = given & {"L", "E"} or {"T", "V"} <= given
    return not case.motions or bool(whole) or not any(all(holds(one, q) for one in every) for q in case.motions)


def is_last_law(case: Case, others: list[Case]) -> bool:
    """Whether it is a law of accelerations, and the laws of all other coordinates hold."""
    accelerations = {f"dd{name}" for name in case.spec.coordinates}
    true = [one.finding.equation for one in others if one.is_true and one.spec is case.spec and says(one.one)]
    own = case.finding.equation.names & accelerations if case.finding.equation else set[str]()
    given = [law.names for law in true if law and law.names & accelerations]
    return bool(own) and len(given) >= len(accelerations) - 1 > 0 and not accelerations - own.union(*given)


def _is_between_laws(case: Case, others: list[Case]) -> bool:
    """Whether its mend changes a term of two rates, and the laws of all other coordinates hold: these fix that term.

    Both come from one mass matrix: r theta'^2 in the law of r is 2 r' theta' in that of theta.
    """
    equation, spec, true = case.finding.equation, case.spec, random_states(case.system)
    if equation is None or not (case.mends_itself and is_last_law(case, others)):
        return False
    base = {**true.base, **{name: true[name] for name in spec.unknowns}}
    slow, fast = (
        Quantities(base | {name: times * true[name] for name in spec.rates}, case.system, np) for times in (1, 2)
    )
    with suppress(Unread, KeyError, ValueError), np.errstate(all="ignore"):
        right = case.finding.mends[0].equation
        before, after = (
            stack_residuals(equation, q, plain=True) - stack_residuals(right, q, plain=True) for q in (slow, fast)
        )
        return bool(np.abs(after - 4 * before).max() < RATIO * np.abs(after).max())
    return False


def _is_multiple(one: np.ndarray, other: np.ndarray) -> bool:
    """Whether one residual is another times what depends on the parameters alone, which halves of the states share."""
    if one.shape != other.shape or not np.abs(other).min() > 0:
        return False
    first, second = np.split(one / other, 2)
    half = len(one) // 2
    if np.array_equal(one[:half], one[half:]):  # of parameters alone it is always that, and has to be a number
        return bool(np.ptp(first) <= RATIO * np.abs(first).max())
    return bool(np.abs(first - second).max() <= RATIO * np.abs(first).max())


def meanings_used(equation: Equation) -> list[tuple[str, Node]]:
    """The symbols of the text that an equation uses, also through definitions, and what they are in it."""
    names = sorted(names_in(equation.sides, equation.definitions) & equation.definitions.keys())
    return [(name.partition("@")[0], equation.definitions[name]) for name in names]  # of what is computed twice each

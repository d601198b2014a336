"""How well the equation doctor finds faults: random single changes of right equations, and right equations rewritten.

    python benchmarks/doctor.py [--mutations 200] [--rewritings 100] [--seed 0] [--by-hand] [--show]

Equations are changed as Python syntax trees, which the doctor knows nothing of, and printed in four notations. A mend
counts as the true one if the mended equation is the original up to a constant factor, every symbol taken as independent.
Those of printed/by_hand.txt were written by hand, in other notations and with other faults.
"""

import argparse
import ast
import random
import time
from itertools import pairwise
from pathlib import Path

import numpy as np
import sympy as sp

from pendpin.analysis.doctor.checking.evaluation import Context, evaluate
from pendpin.analysis.doctor.checking.mechanics import RODS, Pendulum, Quantities
from pendpin.analysis.doctor.checking.residuals import TOLERANCE, Equation, free_states, random_states, relative_error
from pendpin.analysis.doctor.diagnose import diagnose
from pendpin.analysis.doctor.mending.laws import standing
from pendpin.analysis.doctor.reading.documents import unwrapped
from pendpin.analysis.doctor.reading.grammar import parse
from pendpin.analysis.doctor.reading.names import MATRICES, VECTORS
from pendpin.analysis.doctor.reading.tree import Unread, symbols
from printed.algebra import rewritten
from printed.changes import changed
from printed.notations import NOTATIONS, PRINTED, noted

FOLDER = Path(__file__).with_name("printed")


def equations() -> list[tuple[str, str]]:
    """The right equations, each with the kind of rod that it is about."""
    found: list[tuple[str, str]] = []
    rods: list[str] = []
    for line in (FOLDER / "equations.txt").read_text().splitlines():
        if line.startswith("#"):
            rods = line[1:].split()
        else:
            found += [(rod, line) for rod in rods]
    return sorted(found, key=lambda pair: RODS.index(pair[0]))


EQUATIONS = equations()


class Independent(Quantities):
    """Every symbol an independent random number or vector: what is printed counts, not what holds in mechanics."""

    def __init__(self) -> None:
        self.rod, self.xp, self.base, self._known = "thin", np, {"theta": np.zeros(40)}, {}

    def __getitem__(self, name: str) -> np.ndarray:
        """Random, but always the same for a name."""
        if name not in self._known:
            seed = np.random.default_rng(abs(hash(name)) % 2**32)
            shape = (3, 40) if name in VECTORS else (3, 3, 40) if name in MATRICES else (40,)
            self._known[name] = seed.uniform(0.3, 2.0, shape)
        return self._known[name]

    def __contains__(self, name: str) -> bool:
        """Every name."""
        return True


WORLD = Independent()


def left_over(text: str) -> np.ndarray:
    """Left minus right of an equation, every symbol independent."""
    sides = parse(text)[0]
    meanings = {name: "rG" if name == "r" else name for side in sides for name in symbols(side)}
    try:
        values = [
            evaluate(side, Context(WORLD, {}, meanings={k: v for k, v in meanings.items() if k != "r"}))
            for side in sides
        ]
    except Unread:  # a number is added to a vector
        return np.full(1, np.nan)
    return (values[0] - (values[1] if len(values) > 1 else 0)).ravel()


def same(first: str, second: str, rod: str = "") -> bool:
    """Whether two equations are the same but for a factor; with a rod, also where F_g is m g, a1 is x and the like."""
    found = _proportional(left_over(first), left_over(second))
    if found or not rod:
        return found
    world = free_states(Pendulum(rod))
    pairs = [[evaluate(side, Context(world, {})).ravel() for side in parse(text)[0]] for text in (first, second)]
    return all(a.shape == b.shape and np.allclose(a, b, rtol=1e-9) for a, b in zip(*pairs, strict=True))


def _proportional(a: np.ndarray, b: np.ndarray) -> bool:
    if a.shape != b.shape or not np.abs(b).max() > 0:
        return False
    ratio = a[np.argmax(np.abs(b))] / b[np.argmax(np.abs(b))]
    if np.abs(a - ratio * b).max() <= 1e-9 * np.abs(a).max():
        return True
    if np.abs(b).min() == 0:
        return False
    parameters = [WORLD[name] for name in ("m", "l")] if len(a) == len(WORLD["m"]) else []
    return any(np.ptp(a / b * p**k) <= 1e-9 * np.abs(a / b * p**k).max() for p in parameters for k in (1, -1))


def mutations(count: int, seed: int, show: bool) -> tuple[int, int, int]:
    """How often the true mend is first, and how often a wrong equation is said to hold or not read."""
    chance = random.Random(seed)
    first = wrong = done = 0
    while done < count:
        rod, text = chance.choice(EQUATIONS)
        notation = NOTATIONS[done % len(NOTATIONS)]
        kind, new = changed(text, chance)
        if not kind or same(text, new) or not fails(new, rod):
            continue
        done += 1
        began = time.process_time()
        finding = diagnose([noted(new, notation)], rod=rod).findings[0]
        seconds = time.process_time() - began
        wrong += finding.verdict == "holds"
        good = bool(finding.mends) and same(text, finding.mends[0].latex, rod)
        first += good
        if show and (not good or seconds > 5):
            found = finding.mends[0].latex if finding.mends else finding.remark
            print(
                f"{rod} {kind} [{notation}] {seconds:.1f} s\n  was    {text}\n  is     {finding.latex}"
                f"\n  found  {finding.verdict}: {found}"
            )
    return first, wrong, done


def fails(text: str, rod: str) -> bool:
    """Whether a changed equation is wrong: some changes are none, as cos for cos of an angle that does not enter.

    This is asked of the truth in plain notation; one that cannot be evaluated is wrong.
    """
    errors = []
    for equation in Equation(tuple(parse(text)[0])).readings():
        try:
            errors.append(relative_error(equation, random_states(Pendulum(rod))))
        except Unread:
            continue
    return min(errors, default=1.0) > TOLERANCE


def rewritings(count: int, seed: int, show: bool) -> tuple[int, int]:
    """How many right equations are said to fail or cannot be read, of how many."""
    chance = random.Random(seed)
    scalar = [
        (rod, text)
        for rod, text in EQUATIONS
        if not ({*["b1", "b2", "b3", "a1", "a2", "a3", "omega", "a_G"]} & set(_words(text)))
    ]
    bad = 0
    for done in range(count):
        rod, text = chance.choice(scalar)
        left, right = (sp.sympify(side) for side in text.split(" = "))
        left, right = rewritten(left, right, chance)
        names = {sp.Symbol(name): latex for name, latex in PRINTED.items()}
        in_latex = f"{sp.latex(left, symbol_names=names)} = {sp.latex(right, symbol_names=names)}"
        printed = [in_latex, f"{left} = {right}", sp.Eq(left, right, evaluate=False)][done % 3]
        finding = diagnose([printed], rod=rod).findings[0]
        if finding.verdict != "holds":
            bad += 1
            if show:
                print(
                    f"{rod}\n  was  {text}\n  is   {finding.latex}"
                    f"\n  found {finding.verdict} {finding.error:.2g} {finding.remark}"
                )
    return bad, count


def _words(text: str) -> list[str]:
    return [
        node.id
        for side in text.split(" = ")
        for node in ast.walk(ast.parse(side, mode="eval"))
        if isinstance(node, ast.Name)
    ]


def by_hand(show: bool) -> tuple[int, int, int, int]:
    """Of the equations by hand: how many right ones hold, of how many; how many true mends are first, of how many."""
    lines = (FOLDER / "by_hand.txt").read_text().splitlines()
    right = [line[2:] for line in lines if line.startswith("= ")]
    wrong = [(line[2:], after[2:]) for line, after in pairwise(lines) if line.startswith("! ")]
    held = [line for line in right if diagnose(line).ok]
    healed = [pair for pair in wrong if _healed(*pair)]
    if show:
        print("\n".join([*(set(right) - set(held)), *(text for text, _ in set(wrong) - set(healed))]))
    return len(held), len(right), len(healed), len(wrong)


def _healed(text: str, good: str) -> bool:
    """Whether the first mend of the equation that fails is the good one, off the true motion too."""
    found = diagnose(text)
    mend = next((finding.mends[0] for finding in found.wrong if finding.mends), None)
    if mend is None:
        return False
    meant = Equation(tuple(parse(unwrapped(good)[0])[0]), meanings=mend.equation.meanings, frame=mend.equation.frame)
    a, b = (standing(equation, found.pendulum)[0] for equation in (meant, mend.equation))
    return a.shape == b.shape and bool(np.abs(a - b).max() < 1e-7)


def main() -> None:
    """Print both rates."""
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("--mutations", type=int, default=200)
    arguments.add_argument("--rewritings", type=int, default=100)
    arguments.add_argument("--seed", type=int, default=0)
    arguments.add_argument("--by-hand", action="store_true", help="also those written by hand")
    arguments.add_argument("--show", action="store_true", help="print what is not found")
    options = arguments.parse_args()
    began = time.process_time()
    first, wrong, count = mutations(options.mutations, options.seed, options.show)
    if count:
        print(
            f"{count} single changes in four notations: the true mend is named first in {first / count:.1%}; "
            f"{wrong} said to hold"
        )
    if options.by_hand:
        held, right, healed, wrong = by_hand(options.show)
        print(
            f"by hand: {held} of {right} right equations hold; the true mend of {wrong} wrong ones is first in {healed}"
        )
    bad, total = rewritings(options.rewritings, options.seed, options.show)
    print(
        f"{total} right equations rewritten: {bad} said to fail or not read; "
        f"{time.process_time() - began:.0f} s of CPU in all"
    )


if __name__ == "__main__":
    main()

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
from collections import Counter
from itertools import pairwise
from pathlib import Path
from zlib import crc32

import numpy as np
import sympy as sp

from pendpin.doctor.checking.evaluation import Equation, evaluate
from pendpin.doctor.checking.residuals import TOLERANCE, ZERO, relative_error
from pendpin.doctor.diagnose import diagnose
from pendpin.doctor.mending.mends import standing
from pendpin.doctor.reading.documents import read_text
from pendpin.doctor.reading.grammar import parse
from pendpin.doctor.reading.names import Vocabulary
from pendpin.doctor.reading.tree import Unread
from pendpin.doctor.recognition import read
from pendpin.doctor.systems.base import Quantities, System, free_states, random_states
from pendpin.doctor.systems.rod import MATRICES, RODS, SPECS, VECTORS
from printed.algebra import rewritten
from printed.changes import changed
from printed.notations import NOTATIONS, PRINTED, noted
from printed.sheets import by_hand as handwritten
from printed.sheets import texts

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
        super().__init__({"theta": np.zeros(40)}, System(SPECS["thin"]), np)
        self._values = {}

    def __getitem__(self, name: str) -> np.ndarray:
        """Random, but always the same for a name."""
        if name not in self._values:
            seed = np.random.default_rng(crc32(name.encode()))
            shape = (3, 40) if name in VECTORS else (3, 3, 40) if name in MATRICES else (40,)
            self._values[name] = seed.uniform(0.3, 2.0, shape)
        return self._values[name]

    def __contains__(self, name: str) -> bool:
        """Every name."""
        return True


WORLD = Independent()
WORDS = Vocabulary(SPECS["thin"])


def left_over(text: str) -> np.ndarray:
    """Left minus right of an equation, every symbol independent."""
    sides = parse(text, WORDS)[0]
    meanings = {name: "rG" if name == "r" else name for side in sides for name in side.names}
    try:
        values = [
            evaluate(side, Equation((ZERO,), meanings={k: v for k, v in meanings.items() if k != "r"}).context(WORLD))
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
    world = free_states(System(SPECS[rod]))
    pairs = [
        [evaluate(side, Equation((ZERO,)).context(world)).ravel() for side in parse(text, WORDS)[0]]
        for text in (first, second)
    ]
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
    for equation in Equation(tuple(parse(text, WORDS)[0])).readings(WORDS):
        try:
            errors.append(relative_error(equation, random_states(System(SPECS[rod]))))
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
    meant = Equation(tuple(parse(good, WORDS)[0]), meanings=mend.equation.meanings, frame=mend.equation.frame)
    a, b = (standing(equation, found.system) for equation in (meant, mend.equation))
    return a.shape == b.shape and bool(np.abs(a - b).max() < 1e-7)


def sheets(show: bool) -> dict[str, int]:
    """The verdicts on whole texts of right equations: ten systems in ten notations, and texts written by hand."""
    counts: Counter[str] = Counter()
    written = [(title, "by hand", text) for title, text in handwritten()]
    for title, notation, text in [*written, *((title, notation, text) for title, notation, text, _ in texts())]:
        found = diagnose(text)
        counts.update(finding.verdict for finding in found.findings)
        for finding in found.findings if show else ():
            if finding.verdict in ("fails", "not checked"):
                print(f"{title} [{notation}] {finding.verdict}: {finding.latex}\n  {finding.remark}")
    return dict(counts)


def planted(count: int, seed: int, show: bool) -> tuple[Counter[str], int, int, float]:
    """Of texts with one fault: the verdicts on it, how often its true mend is first, how many others are accused.

    And the longest time to an answer, in seconds of the processor.
    """
    chance = random.Random(seed)
    right = texts()
    verdicts: Counter[str] = Counter()
    first = accused = done = 0
    longest = 0.0
    while done < count:
        title, notation, text, equations = chance.choice(right)
        i = chance.randrange(len(equations))
        kind, new = changed(equations[i], chance)
        if not kind or new.count(" = ") != 1 or same_text(equations[i], new):
            continue
        done += 1
        [(_, _, wrong, _)] = texts(lambda k, line, i=i, new=new: new if k == i else line, title, notation)
        began = time.process_time()
        report = diagnose(wrong)
        seconds = time.process_time() - began
        longest = max(longest, seconds)
        finding = report.findings[i]
        verdicts[finding.verdict] += 1
        accused += sum(f.verdict == "fails" for f in report.findings) - (finding.verdict == "fails")
        good = bool(finding.mends) and as_before(finding.mends[0].equation, text, i, report.system)
        first += good
        if show and not (good and finding.verdict == "fails"):
            print(
                f"{title} [{notation}] {kind}: {equations[i]} -> {new}\n  {finding.verdict} {finding.condition}",
                end=" ",
            )
            print(
                f"{finding.remark} {[mend.words for mend in finding.mends]} {report.title} {seconds:.1f} s", flush=True
            )
    return verdicts, first, accused, longest


def same_text(first: str, second: str) -> bool:
    """Whether two equations in Python text are proportional, every symbol a positive number of its own."""
    names = sorted({*_words(first), *_words(second)} - {"sin", "cos", "tan", "sqrt"})
    known = {name: sp.Symbol(name) for name in names}
    pairs = [[sp.sympify(side, locals=known) for side in text.split(" = ")] for text in (first, second)]
    ratios = []
    for seed in (1, 2, 3):
        values = dict(zip(map(sp.Symbol, names), np.random.default_rng(seed).uniform(0.3, 2, len(names)), strict=True))
        a, b = ([complex(side.subs(values)) for side in pair] for pair in pairs)
        ratios.append((a[0] - a[1]) / (b[0] - b[1]) if b[0] != b[1] else np.inf)
    return bool(np.ptp(np.real(ratios)) < 1e-9 and np.abs(np.imag(ratios)).max() < 1e-9)


def as_before(mended: Equation, text: str, index: int, system: System) -> bool:
    """Whether a mended equation is the right one, off the true motion too."""
    original = read(read_text(text), {}).equations[index]
    for equation in original.readings():
        try:
            a, b = (standing(one, system) for one in (equation, mended))
        except (Unread, KeyError):
            continue
        if a.shape == b.shape and np.abs(a - b).max() < 1e-7:
            return True
    return False


def main() -> None:
    """Print both rates."""
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("--mutations", type=int, default=200)
    arguments.add_argument("--rewritings", type=int, default=100)
    arguments.add_argument("--seed", type=int, default=0)
    arguments.add_argument("--by-hand", action="store_true", help="also those written by hand")
    arguments.add_argument("--sheets", action="store_true", help="also whole texts of right equations")
    arguments.add_argument("--planted", type=int, default=0, help="whole texts with one fault: how many")
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
    if options.sheets:
        print(f"right equations in whole texts: {sheets(options.show)}")
    if options.planted:
        found, first, accused, seconds = planted(options.planted, options.seed, options.show)
        print(
            f"{options.planted} texts with a fault: {found['fails']} found and {found['holds if']} hold under a condition, "
            f"{first} mended first, {accused} others accused, {found['holds']} said to hold; {seconds:.1f} s at most"
        )
    bad, total = rewritings(options.rewritings, options.seed, options.show)
    print(
        f"{total} right equations rewritten: {bad} said to fail or not read; "
        f"{time.process_time() - began:.0f} s of CPU in all"
    )


if __name__ == "__main__":
    main()

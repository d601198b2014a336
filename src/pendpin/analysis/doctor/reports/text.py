"""A diagnosis as text and as records for machines."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from pendpin.analysis.doctor.checking import exact
from pendpin.analysis.doctor.checking.mechanics import AXES, COORDINATES, PARAMETERS, Pendulum, Quantities, dot
from pendpin.analysis.doctor.checking.residuals import Equation, residuals
from pendpin.analysis.doctor.diagnosis import Diagnosis, Finding
from pendpin.analysis.doctor.mending.mends import Mend
from pendpin.analysis.doctor.reading.names import UNKNOWNS
from pendpin.analysis.doctor.reading.tree import Unread
from pendpin.errors import one_line

STYLES = {"holds": "green", "fails": "bold red", "unread": "yellow"}
RODS = {"point": "a point mass on a massless rod", "thin": "a uniform thin rod", "general": "any rod"}
RODS |= {"uniform": "a uniform rod of radius r", "symmetric": "any rod with I1 = I2"}
MOST_PRINTED = 20_000  # characters of an equation in a record
Line = tuple[str, str]  # text and its style


def records(diagnosis: Diagnosis) -> list[dict[str, Any]]:
    """One record an equation: number, latex, kind, verdict, proved, error, mends (docs/doctor.md)."""
    return [_record(finding, diagnosis) for finding in diagnosis.findings]


def _record(finding: Finding, diagnosis: Diagnosis) -> dict[str, Any]:
    error = finding.error if np.isfinite(finding.error) else 1e300
    return {
        "number": finding.number,
        "latex": shortened(finding.latex, MOST_PRINTED),
        "kind": finding.kind,
        "verdict": finding.verdict,
        "proved": finding.proved,
        "error": error,
        "mends": [
            {
                "latex": mend.latex,
                "words": mend.words,
                "residual": residual(mend.equation, diagnosis.pendulum),
            }
            for mend in finding.mends
        ],
        "place": finding.place,
        "remark": finding.remark,
        "when": finding.when,
        "scaling": finding.scaling,
        "dimensions": finding.dimensions,
    }


def residual(equation: Equation, pendulum: Pendulum) -> str:
    """Left minus right as text for sympy, in the coordinates, parameters and reactions of the text.

    Of several equal sides the first two that are not the same for every motion; of vectors the components along b1, b2, b3.
    """
    symbolic = exact.printed_quantities(pendulum)
    found = []
    try:
        pairs = zip(residuals(equation, symbolic), _vanishing(equation, pendulum), strict=True)
        for (rows, _), zero in pairs:
            found.append((_text(rows, equation, symbolic, zero), zero))
    except Unread:
        return ""
    return next((text for text, zero in found if not zero), found[0][0])


def _vanishing(equation: Equation, pendulum: Pendulum) -> list[bool]:
    """Of each pair of sides whether they are the same whatever accelerations and reactions are."""
    base = exact.polynomial_base((*COORDINATES, *PARAMETERS[pendulum.rod], *UNKNOWNS))
    quantities = Quantities(base, pendulum, exact.polynomials())
    try:
        return [all(row[0].zero for row in rows) for rows, _ in residuals(equation, quantities)]
    except exact.Unprovable:
        return [False] * max(1, len(equation.sides) - 1)


def _text(rows: Any, equation: Equation, quantities: Quantities, zero: bool) -> str:
    count = len(rows)
    if count == 1:
        return "0" if zero else str(rows[0][0])
    if count == 3 and not zero:
        rows = [dot(np.asarray(rows), quantities[axis]) for axis in AXES["B"]]
    width = {4: 2, 9: 3}.get(count, 1)
    entries = ["0" if zero else str(row[0]) for row in rows]
    lines = (", ".join(entries[i : i + width]) for i in range(0, count, width))
    return f"Matrix([{', '.join(f'[{line}]' for line in lines)}])"


def text(diagnosis: Diagnosis) -> str:
    """The whole report as plain text."""
    return "\n".join("".join(part for part, _ in line) for line in lines(diagnosis))


def lines(diagnosis: Diagnosis) -> Iterator[list[Line]]:
    """The report line by line, each in parts with their styles."""
    for finding in diagnosis.findings:
        yield from _of_finding(finding)
    yield []
    for remark in diagnosis.remarks:
        yield [(remark, "")]
    for shared in diagnosis.shared:
        yield [(shared_words(shared.old, shared.new, shared.numbers), "bold")]
    if diagnosis.harm is not None:
        yield from ([(line, "")] for line in diagnosis.harm.words)
    yield [(summary(diagnosis), "bold")]


def summary(diagnosis: Diagnosis) -> str:
    """How many equations hold, fail and could not be read."""
    verdicts = [finding.verdict for finding in diagnosis.findings]
    counts = {word: verdicts.count(word) for word in STYLES}
    counts["unread"] -= (defined := sum(finding.kind == "definition" for finding in diagnosis.findings))
    counted = f"{counts['holds']} hold, {counts['fails']} fail, {counts['unread']} are not checked"
    counted += f", {defined} define a symbol" * bool(defined)
    return f"Of {len(verdicts)} equations {counted}; for {RODS[diagnosis.pendulum.rod]}."


def shared_words(old: str, new: str, numbers: tuple[int, ...]) -> str:
    """One mend of several equations, in words."""
    listed = ", ".join(map(str, numbers[:-1])) + f" and {numbers[-1]}"
    return f"{new} for {old} heals equations {listed}{known(old, new)}."


def known(old: str, new: str) -> str:
    """What is known of a change that is often needed."""
    short = [
        t.replace(" ", "").replace("{", "").replace("}", "").replace("*", "").replace("\\frac", "") for t in (old, new)
    ]
    if short[0] in ("ml^23", "ml^2/3", "ml2/3") and short[1] in ("ml^212", "ml^2/12", "ml2/12"):
        return ": m l²/3 is the inertia about the joint, m l²/12 that about G"
    if short[1] in ("ml^23", "ml^2/3", "ml2/3") and short[0] in ("ml^212", "ml^2/12", "ml2/12"):
        return ": m l²/12 is the inertia about G, m l²/3 that about the joint"
    return ""


def _of_finding(finding: Finding) -> Iterator[list[Line]]:
    head: list[Line] = [(f"{finding.number:3} ", ""), (f"{word(finding):6}", STYLES[finding.verdict])]
    printed = one_line(finding.latex)
    if finding.verdict == "unread":
        yield [*head, (f" {finding.place}: {one_line(finding.remark)}: {shortened(printed, 60)}", "")]
        return
    yield [*head, (f" {finding.kind}: {shortened(printed, 300)}", "")]
    if finding.verdict == "fails":
        yield [(f"      {finding.place}: {failure(finding)}", "")]
        yield from _of_mends(finding.mends)
    elif finding.remark or not finding.proved:
        yield [("      " + (finding.remark or "not proved, but it holds to 35 digits at 500 random states"), "dim")]


def word(finding: Finding) -> str:
    """The verdict as it is shown: a definition is given, and was read."""
    return "given" if finding.kind == "definition" else finding.verdict


def failure(finding: Finding) -> str:
    """How an equation fails, in words."""
    parts = [f"off by {finding.error:.2g} of its terms, {finding.when}"]
    if finding.scaling:
        parts.append(f"in proportion to {finding.scaling}")
    if finding.dimensions:
        parts.append(f"dimensions do not agree: {finding.dimensions}")
    if finding.remark:
        parts.append(finding.remark)
    return "; ".join(parts)


def _of_mends(mends: tuple[Mend, ...]) -> Iterator[list[Line]]:
    if not mends:
        yield [("      no simple mend found", "yellow")]
    for rank, mend in enumerate(mends):
        yield [("      mend: " if not rank else "      or:   ", "green"), (mend.words + known(mend.old, mend.new), "")]
        yield [("            ", ""), *_marked(mend)]


def _marked(mend: Mend) -> list[Line]:
    """The mended equation, its changed characters marked."""
    parts, shift = [], 0
    place, end_of_it = mend.span
    for start, end, new in sorted(mend.splices):
        parts.append((mend.text[place : start + shift], ""))
        place = start + shift + len(new)
        parts.append((mend.text[start + shift : place], "reverse"))
        shift += len(new) - (end - start)
    parts.append((mend.text[place:end_of_it], ""))
    return [(" ".join(part.split("\n")), style) for part, style in parts if part]


def shortened(text: str, most: int) -> str:
    """A text, cut where it is longer."""
    return text if len(text) <= most else f"{text[: most - 3]}..."

"""A diagnosis as text and as records for machines."""

import re
from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np

from pendpin.doctor.checking import exact
from pendpin.doctor.checking.residuals import Equation, residuals
from pendpin.doctor.findings import VERDICTS, Finding, Findings, Shared
from pendpin.doctor.mending.mends import Mend
from pendpin.doctor.reading.tree import Unread
from pendpin.doctor.systems.base import Quantities, System, dot
from pendpin.doctor.systems.rod import AXES
from pendpin.errors import one_line

STYLES = {"holds": "green", "holds if": "green", "fails": "bold red", "not checked": "yellow"}
MOST_PRINTED = 20_000  # characters of an equation in a record
MOST_SYMBOLS = 6  # of those that are not known, in the first lines
MOST_LISTED = 8  # equations or lines in a row
Line = tuple[str, str]  # text and its style


def records(diagnosis: Findings) -> list[dict[str, Any]]:
    """One record an equation: number, latex, kind, verdict, proved, error, mends (docs/doctor.md)."""
    return [_record(finding, diagnosis) for finding in diagnosis.findings]


def _record(finding: Finding, diagnosis: Findings) -> dict[str, Any]:
    error = finding.error if np.isfinite(finding.error) else 1e300
    return {
        "number": finding.number,
        "latex": shortened(finding.latex, MOST_PRINTED),
        "kind": finding.kind,
        "verdict": finding.verdict,
        "condition": finding.condition,
        "proved": finding.proved,
        "error": error,
        "mends": [
            {
                "latex": mend.latex,
                "words": mend.words,
                "residual": residual(mend.equation, diagnosis.system),
            }
            for mend in finding.mends
        ],
        "place": finding.place,
        "remark": finding.remark,
        "when": finding.when,
        "dimensions": finding.dimensions,
        "follows": finding.follows,
    }


def residual(equation: Equation, system: System) -> str:
    """Left minus right as text for sympy, in the coordinates, parameters and reactions of the text.

    Of several equal sides the first two that are not the same for every motion; of vectors the components along b1, b2, b3.
    Empty for an expression that is not a fraction of polynomials in these and their sines and cosines.
    """
    if not system.spec.analytic:
        return ""
    quantities = exact.polynomial_states(system, False)
    try:
        texts = [_text(rows, quantities) for rows, _ in residuals(equation, quantities)]
    except (Unread, exact.Unprovable):
        return ""
    return next((text for text in texts if re.search(r"[a-z1-9]", text.replace("Matrix", ""))), texts[0])


def _text(rows: Any, quantities: Quantities) -> str:
    """The rows of a residual; "sin theta" is a generator of the polynomials."""
    if len(rows) == 3:
        rows = [dot(np.asarray(rows), quantities[axis]) for axis in AXES["B"]]
    entries = ["0" if row[0].zero else f"({row[0].num})/({row[0].den})" for row in rows]
    entries = [re.sub(r"\b(sin|cos) (\w+)", r"\1(\2)", entry.removesuffix("/(1)")) for entry in entries]
    width = {4: 2, 9: 3}.get(len(rows), 1)
    lines = (", ".join(entries[i : i + width]) for i in range(0, len(rows), width))
    return entries[0] if len(rows) == 1 else f"Matrix([{', '.join(f'[{line}]' for line in lines)}])"


def text(diagnosis: Findings) -> str:
    """The whole report as plain text."""
    return "\n".join("".join(part for part, _ in line) for line in lines(diagnosis))


def lines(diagnosis: Findings) -> Iterator[list[Line]]:
    """The report line by line, each in parts with their styles."""
    first, *others = first_screen(diagnosis)
    yield [(first, "bold red" if diagnosis.wrong or diagnosis.doubtful else "bold")]
    for line in others:
        yield [(line, "")]
    for finding in diagnosis.findings:
        yield from _of_finding(finding)
    yield []
    for shared in diagnosis.shared:
        yield [(shared_words(shared), "bold")]
    for line in last_lines(diagnosis):
        yield [(line, "bold")]


def first_screen(diagnosis: Findings) -> list[str]:
    """What a reader wants to know first: which line is wrong, as what the text was read, what symbols are to be said."""
    read_as = f"Read as equations of {diagnosis.title}." if diagnosis.system_is_known else diagnosis.remarks[0]
    answer = [read_as] if diagnosis.system_is_known or not diagnosis.wrong else []
    if diagnosis.wrong:
        first, *others = diagnosis.wrong
        mend = f": {first.mends[0].words}" if first.mends else ""
        answer.insert(0, f"Equation {first.number}, {first.place}, is the first wrong one{mend}.")
        later = [one for one in others if one.follows == first.number]
        if later:
            answer.append(f"{_listed(later)} {'follows' if len(later) == 1 else 'follow'} from it.")
        if rest := [one for one in others if one not in later]:
            answer.append(f"Wrong too: {_listed(rest)}.")
    if diagnosis.doubtful:
        answer.append(
            f"As it is read here, this does not hold, and no small change mends it: {_listed(diagnosis.doubtful)}."
        )
    answer += diagnosis.remarks[0 if diagnosis.system_is_known else 1 :]
    if diagnosis.system_is_known and (said := unchecked(diagnosis)):
        answer.append(said)
    return answer


def _listed(findings: Iterable[Finding]) -> str:
    """Some equations by their numbers and places."""
    found = list(findings)
    shown = [f"{one.number} ({one.place})" for one in found[:MOST_LISTED]]
    return ", ".join(shown) + (f" and {len(found) - MOST_LISTED} more" if len(found) > MOST_LISTED else "")


def unchecked(diagnosis: Findings) -> str:
    """How many equations could not be read, and what to write so that they are checked; empty where there are none."""
    left = [one for one in diagnosis.unchecked if not one.when]
    if not left:
        return ""
    symbols = {name.lstrip("?"): "" for one in left for name in one.unknown}
    count = f"{len(left)} of {len(diagnosis.findings)} equations {'is' if len(left) == 1 else 'are'} NOT CHECKED"
    if not symbols:
        return f"{count}; the reasons are below."
    pairs = [f"{name}={_likely(name, diagnosis.system)}" for name in list(symbols)[:MOST_SYMBOLS]]
    return f"{count}; say what these symbols are: --symbols {','.join(pairs)}"


def _likely(name: str, system: System) -> str:
    """What an unknown symbol probably is: F_1 a force of the joint."""
    force = re.fullmatch(r"[FNSXQP]_([123])", name)
    return f"R_{force[1]}" if force and f"R{force[1]}" in system.spec.unknowns else "..."


def summary(diagnosis: Findings) -> str:
    """How many equations hold, fail and could not be read."""
    verdicts = [finding.verdict for finding in diagnosis.findings]
    counts = [verdicts.count(verdict) for verdict in VERDICTS]
    words = ("hold", "hold under a condition", "fail", "are not checked")
    alone = ("holds", "holds under a condition", "fails", "is not checked")
    said = [(n, one if n == 1 else many) for n, one, many in zip(counts, alone, words, strict=True)]
    counted = ", ".join(f"{count} {word}" for count, word in said if count or word != words[1])
    return f"{len(verdicts)} equations of {diagnosis.title}: {counted}."


def last_lines(diagnosis: Findings) -> list[str]:
    """What was counted, and what was not looked at."""
    answer = [summary(diagnosis)]
    if diagnosis.doubtful and not diagnosis.wrong:
        answer.append("Some does not hold as it is read, so this does not prove that all is right (exit status 1).")
    if diagnosis.skipped:
        shown = ", ".join(diagnosis.skipped[:MOST_LISTED])
        more = f" and {len(diagnosis.skipped) - MOST_LISTED} more" if len(diagnosis.skipped) > MOST_LISTED else ""
        answer.append(f"Not looked at, though it holds an equals sign: {shown}{more}.")
    return answer


def shared_words(shared: Shared) -> str:
    """One mend of several equations, in words."""
    *others, last = map(str, shared.numbers)
    listed = f"{', '.join(others)} and {last}"
    return f"{shared.new} for {shared.old} heals equations {listed}{explain_change(shared.old, shared.new)}."


def explain_change(old: str, new: str) -> str:
    """Why a change that is often needed is right; empty for others."""
    short = [
        t.replace(" ", "").replace("{", "").replace("}", "").replace("*", "").replace("\\frac", "") for t in (old, new)
    ]
    if short[0] in ("ml^23", "ml^2/3", "ml2/3") and short[1] in ("ml^212", "ml^2/12", "ml2/12"):
        return ": m l²/3 is the inertia about the joint, m l²/12 that about G"
    if short[1] in ("ml^23", "ml^2/3", "ml2/3") and short[0] in ("ml^212", "ml^2/12", "ml2/12"):
        return ": m l²/12 is the inertia about G, m l²/3 that about the joint"
    return ""


def _of_finding(finding: Finding) -> Iterator[list[Line]]:
    head: list[Line] = [(f"{finding.number:3} ", ""), (finding.verdict, STYLES[finding.verdict])]
    printed = one_line(finding.latex)
    if finding.verdict == "not checked":
        yield [*head, (f"  {finding.place}: {one_line(finding.remark)}: {shortened(printed, 60)}", "")]
        return
    condition = f" {finding.condition}" * bool(finding.condition)
    yield [*head, (f"{condition}  {finding.kind}: {shortened(printed, 300)}", "")]
    if finding.verdict == "fails":
        yield [(f"      {finding.place}: {failure(finding)}", "")]
        yield from _of_mends(finding.mends)
    elif finding.remark or not (finding.proved or finding.condition or finding.kind == "definition"):
        yield [("      " + (finding.remark or "not proved, but it holds to 30 digits at 60 random states"), "dim")]
    elif finding.mends:
        yield [("      without that condition: ", "dim"), (finding.mends[0].words, "")]


def failure(finding: Finding) -> str:
    """How an equation fails, in words."""
    parts = [f"off by {finding.error:.2g} of its terms, {finding.when}"]
    if finding.dimensions:
        parts.append(f"dimensions do not agree: {finding.dimensions}")
    if finding.remark:
        parts.append(finding.remark)
    return "; ".join(parts)


def _of_mends(mends: tuple[Mend, ...]) -> Iterator[list[Line]]:
    if not mends:
        yield [("      no simple mend found", "yellow")]
    for rank, mend in enumerate(mends):
        label = "      mend: " if not rank else "      or:   "
        yield [(label, "green"), (mend.words + explain_change(mend.old, mend.new), "")]
        yield [("            ", ""), *((part, "reverse" if new else "") for part, new in marked(mend))]


def marked(mend: Mend) -> list[tuple[str, bool]]:
    """The mended equation in parts, each with whether it is new."""
    place, end_of_it = mend.span
    parts = []
    for start, end in mend.changed:
        parts += [(mend.text[place:start], False), (mend.text[start:end], True)]
        place = end
    parts.append((mend.text[place:end_of_it], False))
    return [(" ".join(part.split("\n")), new) for part, new in parts if part]


def shortened(text: str, most: int) -> str:
    """A text, cut where it is longer."""
    return text if len(text) <= most else f"{text[: most - 3]}..."

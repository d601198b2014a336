"""A diagnosis shown: as text, as records for machines, and as one HTML page with equations and mends as they are printed."""

import html
import re
from collections.abc import Iterable, Iterator
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np

from pendpin.doctor.checking.exact import in_symbols
from pendpin.doctor.checking.residuals import TOLERANCE, Equation, residuals
from pendpin.doctor.findings import VERDICTS, Finding, Findings, Shared
from pendpin.doctor.mending.mends import Mend
from pendpin.doctor.reading.tree import Unread
from pendpin.doctor.systems.base import System, dot, free_states
from pendpin.doctor.systems.rod import AXES
from pendpin.errors import one_line
from pendpin.ground.files import write_whole

STYLES = {"holds": "green", "holds if": "green", "fails": "bold red", "not checked": "yellow"}
MOST_PRINTED, MOST_ON_PAGE = 20_000, 2_000  # characters of an equation in a record, and on a page
MOST_SYMBOLS = 6  # of those that are not known, in the first lines
MOST_LISTED = 8  # equations or lines in a row
Line = list[tuple[str, str]]  # pieces of text, each with its style

# --- for machines ---------------------------------------------------------------------------------------------------


def records(diagnosis: Findings) -> list[dict[str, Any]]:
    """One record an equation: number, latex, kind, verdict, proved, error, mends (docs/doctor.md)."""
    return [
        {
            "number": finding.number,
            "latex": shortened(finding.latex, MOST_PRINTED),
            "kind": finding.kind,
            "verdict": finding.verdict,
            "condition": finding.condition,
            "proved": finding.proved,
            "error": finding.error if np.isfinite(finding.error) else 1e300,
            "mends": [
                {"latex": mend.latex, "words": mend.words, "residual": residual(mend.equation, diagnosis.system)}
                for mend in finding.mends
            ],
            "place": finding.place,
            "remark": finding.remark,
            "when": finding.when,
            "dimensions": finding.dimensions,
            "follows": finding.follows,
        }
        for finding in diagnosis.findings
    ]


def residual(equation: Equation, system: System) -> str:
    """Left minus right as text for sympy, in the coordinates, parameters and reactions of the text.

    Of several equal sides the first two that are not the same for every motion; of vectors the components along b1, b2, b3.
    Empty for what no formula gives, as the dynamics of a scene.
    """
    if not system.spec.analytic:
        return ""
    try:
        quantities = in_symbols(system)
        numbers, symbols = (residuals(equation, q, plain=True) for q in (free_states(system), quantities))
    except Unread:
        return ""
    for (values, size), (rows, _) in zip(numbers, symbols, strict=True):
        if np.abs(values).max() > TOLERANCE * size.max():
            rows = [dot(rows, quantities[axis]) for axis in AXES["B"]] if len(rows) == 3 else rows
            width = {4: 2, 9: 3}.get(len(rows), 1)
            entries = [str(row[0]) for row in rows]
            lines = (f"[{', '.join(entries[i : i + width])}]" for i in range(0, len(entries), width))
            return entries[0] if len(entries) == 1 else f"Matrix([{', '.join(lines)}])"
    return "0"


# --- as text --------------------------------------------------------------------------------------------------------


def text(diagnosis: Findings) -> str:
    """The whole report as plain text."""
    return "\n".join("".join(part for part, _ in line) for line in lines(diagnosis))


def lines(diagnosis: Findings) -> Iterator[Line]:
    """The report line by line, each in parts with their styles."""
    first, *others = first_screen(diagnosis)
    yield [(first, "bold red" if diagnosis.wrong or diagnosis.doubtful else "bold")]
    yield from ([(line, "")] for line in others)
    for finding in diagnosis.findings:
        yield from _of_finding(finding)
    yield []
    yield from ([(line, "bold")] for line in (*map(shared_words, diagnosis.shared), *last_lines(diagnosis)))


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
        one = len(diagnosis.doubtful) == 1
        said = f"Equation{'s' * (not one)} {_listed(diagnosis.doubtful)} {'does' if one else 'do'} not hold as read"
        said += " here, and may be wrong or meant otherwise; the reasons are below."
        answer.insert(len(answer) if diagnosis.wrong or not diagnosis.system_is_known else 0, said)
    answer += diagnosis.remarks[0 if diagnosis.system_is_known else 1 :]
    left = [one for one in diagnosis.unchecked if not one.when] if diagnosis.system_is_known else []
    if left:  # and what to write so that they are checked
        count = f"{len(left)} of {len(diagnosis.findings)} equations {'is' if len(left) == 1 else 'are'} NOT CHECKED"
        symbols = list(dict.fromkeys(name.lstrip("?") for one in left for name in one.unknown))
        pairs = ",".join(f"{name}={_likely(name, diagnosis.system)}" for name in symbols[:MOST_SYMBOLS])
        why = f"say what these symbols are: --symbols {pairs}" if symbols else "the reasons are below."
        answer.append(f"{count}; {why}")
    return answer


def _listed(findings: Iterable[Finding]) -> str:
    """Some equations by their numbers and places."""
    return _few([f"{one.number} ({one.place})" for one in findings])


def _few(items: Iterable[str]) -> str:
    """The first items of a list, and how many more there are."""
    every = list(items)
    return ", ".join(every[:MOST_LISTED]) + f" and {len(every) - MOST_LISTED} more" * (len(every) > MOST_LISTED)


def _likely(name: str, system: System) -> str:
    """What an unknown symbol probably is: F_1 a force of the joint."""
    force = re.fullmatch(r"[FNSXQP]_([123])", name)
    return f"R_{force[1]}" if force and f"R{force[1]}" in system.spec.unknowns else "..."


def last_lines(diagnosis: Findings) -> list[str]:
    """How many equations hold, fail and could not be read, and what was not looked at."""
    verdicts = [finding.verdict for finding in diagnosis.findings]
    words = ("hold", "hold under a condition", "fail", "are not checked")
    alone = ("holds", "holds under a condition", "fails", "is not checked")
    said = [(verdicts.count(one), *pair) for one, *pair in zip(VERDICTS, alone, words, strict=True)]
    counted = ", ".join(f"{n} {one if n == 1 else many}" for n, one, many in said if n or many != words[1])
    answer = [f"{len(verdicts)} equation{'s' * (len(verdicts) != 1)} of {diagnosis.title}: {counted}."]
    if diagnosis.doubtful and not diagnosis.wrong:
        answer.append("Some does not hold as it is read, so this does not prove that all is right (exit status 1).")
    if diagnosis.skipped:
        answer.append(f"Not looked at, though it holds an equals sign: {_few(diagnosis.skipped)}.")
    return answer


def shared_words(shared: Shared) -> str:
    """One mend of several equations, in words."""
    *others, last = map(str, shared.numbers)
    listed = f"{', '.join(others)} and {last}"
    return f"{shared.new} for {shared.old} heals equations {listed}{explain_change(shared.old, shared.new)}."


def explain_change(old: str, new: str) -> str:
    """Why a change that is often needed is right; empty for others."""
    short = [re.sub(r"[ {}*/]|\\frac|\^", "", text) for text in (old, new)]
    about = {"ml23": "m l²/3 is the inertia about the joint", "ml212": "m l²/12 is the inertia about G"}
    if {*short} != {*about}:
        return ""
    return f": {about[short[0]]}, {about[short[1]].replace('is the inertia', 'that')}"


def _of_finding(finding: Finding) -> Iterator[Line]:
    head: Line = [(f"{finding.number:3} ", ""), (finding.verdict, STYLES[finding.verdict])]
    printed = one_line(finding.latex)
    if finding.verdict == "not checked":
        yield [*head, (f"  {finding.place}: {one_line(finding.remark)}: {shortened(printed, 60)}", "")]
        return
    condition = f" {finding.condition}" * bool(finding.condition)
    yield [*head, (f"{condition}  {finding.kind}: {shortened(printed, 300)}", "")]
    if finding.verdict == "fails":
        yield [(f"      {finding.place}: {failure(finding)}", "")]
        if not finding.mends:
            yield [("      no simple mend found", "yellow")]
        for rank, mend in enumerate(finding.mends):
            label = "      mend: " if not rank else "      or:   "
            yield [(label, "green"), (mend.words + explain_change(mend.old, mend.new), "")]
            yield [("            ", ""), *((part, "reverse" if new else "") for part, new in marked(mend))]
    elif finding.remark or not (finding.proved or finding.condition or finding.kind == "definition"):
        yield [("      " + (finding.remark or "compared in floats, not to 25 digits"), "dim")]
    elif finding.mends:
        yield [("      without that condition: ", "dim"), (finding.mends[0].words, "")]


def failure(finding: Finding) -> str:
    """How an equation fails, in words."""
    dimensions = f"dimensions do not agree: {finding.dimensions}" if finding.dimensions else ""
    off = f"off by {finding.error:.2g} of its terms, {finding.when}"
    return "; ".join(filter(None, (off, dimensions, finding.remark)))


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


# --- as a page ------------------------------------------------------------------------------------------------------


def write_report(path: Path, diagnosis: Findings) -> Path:
    """Write the report as a page, whole or not at all. Raises InputError where the path refuses."""
    return write_whole(path, lambda file: file.write(page(diagnosis).encode(errors="replace")))


def page(diagnosis: Findings) -> str:
    """The report as HTML that needs no network: verdicts, equations as they are printed, mends with what is new marked."""
    parts = {
        "summary": "".join(f"<p>{html.escape(line)}</p>" for line in first_screen(diagnosis)),
        "shared": "".join(f"<p><strong>{html.escape(shared_words(one))}</strong></p>" for one in diagnosis.shared),
        "equations": "\n".join(_card(finding) for finding in diagnosis.findings),
        "last": "".join(f"<p>{html.escape(line)}</p>" for line in last_lines(diagnosis)),
    }
    template = resources.files("pendpin.doctor").joinpath("report.html").read_text(encoding="utf-8")
    for name, part in parts.items():
        template = template.replace("{{" + name + "}}", part)
    return template


def _card(finding: Finding) -> str:
    """One equation, its verdict, and what mends it."""
    head = (("place", finding.place), ("badge", finding.verdict), ("kind", finding.kind))
    spans = "".join(f'<span class="{name}">{html.escape(said)}</span>' for name, said in head if said != "unread")
    printed = shortened(one_line(finding.latex), MOST_ON_PAGE)
    body = [f"<header>{spans}</header>", f"<pre>{html.escape(printed)}</pre>"]
    if finding.condition:
        body.append(f"<p><strong>holds if {html.escape(finding.condition)}</strong></p>")
    if finding.verdict == "fails":
        body.append(f"<p>{html.escape(failure(finding))}</p>")
        for rank, mend in enumerate(finding.mends):
            words = f"{'Or' if rank else 'Mend'}: {html.escape(mend.words + explain_change(mend.old, mend.new))}"
            pieces = ((html.escape(part), new) for part, new in marked(mend))
            mended = "".join(f'<span class="changed">{part}</span>' if new else part for part, new in pieces)
            body.append(f'<div class="mend"><p>{words}</p><pre>{mended}</pre></div>')
    elif finding.remark:
        body.append(f"<p class='remark'>{html.escape(finding.remark)}</p>")
    style = finding.verdict.replace(" ", "-")
    return f'<article class="{style}" id="equation-{finding.number}">{"".join(body)}</article>'

"""A diagnosis shown: as text, as records for machines, and as one HTML page with equations and mends as they are printed."""

import html
import re
from collections import Counter
from collections.abc import Iterable, Iterator
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np

from pendpin.doctor.checking.exact import in_symbols
from pendpin.doctor.checking.residuals import TOLERANCE, Equation, residuals
from pendpin.doctor.findings import Finding, Findings, Shared
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
    names = ("number", "latex", "kind", "verdict", "condition", "proved", "error", "mends")
    names += ("place", "remark", "when", "dimensions", "follows")
    answers = []
    for finding in diagnosis.findings:
        record = {name: getattr(finding, name) for name in names}
        record["latex"] = shortened(finding.latex, MOST_PRINTED)
        record["error"] = finding.error if np.isfinite(finding.error) else 1e300
        record["mends"] = [
            {"latex": mend.latex, "words": mend.words, "residual": residual(mend.equation, diagnosis.system)}
            for mend in finding.mends
        ]
        answers.append(record)
    return answers


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
    """What a reader wants to know first: which line is wrong and why, as what the text was read, what symbols to say."""
    wrong, doubtful, known = diagnosis.wrong, diagnosis.doubtful, diagnosis.system_is_known
    count, answer = len(diagnosis.findings), list[str]()
    if wrong:
        first, *others = wrong
        mend = f": {first.mends[0].words}" if first.mends else ""
        answer.append(f"Equation {first.number}, {first.place}, is the first wrong one{mend}.")
        later = [one for one in others if one.follows == first.number]
        rest = [one for one in others if one not in later]
        said = [f"{len(wrong)} of {count} equations {'fail' if others else 'fails'}"]
        said += [f"{_listed(later)} {'follow' if later[1:] else 'follows'} from it"] if later else []
        said += [f"{_listed(rest)} {'are' if rest[1:] else 'is'} wrong too"] if rest else []
        answer.append(f"{'; '.join(said)}.")
    doubt = list[str]()
    if doubtful:
        verb = f"s {_listed(doubtful)} do" if doubtful[1:] else f" {_listed(doubtful)} does"
        doubt = [f"Equation{verb} not hold as read here, and may be wrong or meant otherwise; the reasons are below."]
    read_as = [f"Read as equations of {diagnosis.title}."] if known else [diagnosis.remarks[0]] if not wrong else []
    answer += [*read_as, *doubt] if wrong or not known else [*doubt, *read_as]
    answer += diagnosis.remarks[0 if known else 1 :]
    left = [one for one in diagnosis.unchecked if not one.when] if known else []
    if left:  # and what to write so that they are checked
        symbols = list(dict.fromkeys(name.lstrip("?") for one in left for name in one.unknown))
        pairs = ",".join(f"{name}={_likely(name, diagnosis.system)}" for name in symbols[:MOST_SYMBOLS])
        why = f"say what these symbols are: --symbols {pairs}" if symbols else "the reasons are below."
        answer.append(f"{len(left)} of {count} equations {'are' if left[1:] else 'is'} NOT CHECKED; {why}")
    elif not wrong and not doubtful and known:
        answer.insert(0, "Nothing is wrong in what is checked." if diagnosis.skipped else "Nothing is wrong.")
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
    counts, doubtful = Counter[str](), diagnosis.doubtful
    for finding in diagnosis.findings:
        state = finding.kind == "condition"
        counts["doubtful" if finding in doubtful else "state" if state else finding.verdict] += 1
    words = {"holds": ("holds", "hold"), "holds if": ("holds under a condition", "hold under a condition")}
    words |= {"fails": ("fails", "fail"), "doubtful": ("does not hold as read", "do not hold as read")}
    words |= {
        "not checked": ("is not checked", "are not checked"),
        "state": ("gives a value or names", "give values or names"),
    }
    said = ", ".join(f"{counts[kind]} {both[counts[kind] != 1]}" for kind, both in words.items() if counts[kind])
    count = len(diagnosis.findings)
    answer = [f"{count} equation{'s' * (count != 1)} of {diagnosis.title}: {said}."]
    if diagnosis.wrong:
        answer[0] += f" The first wrong one is equation {diagnosis.wrong[0].number}, {diagnosis.wrong[0].place}."
    elif diagnosis.doubtful:
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
    parts.append((mend.text[place:end_of_it].rstrip().removesuffix("\\\\"), False))
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

    def paragraphs(said: Iterable[str]) -> list[str]:
        """Lines of text, in which numbers of equations lead to their cards."""
        link = r'<a href="#equation-\1">\1</a>\2'
        number = re.compile(r"(?<!\d)(\d+)( [(]|, )(?=line )")
        return [f"<p>{number.sub(link, html.escape(line))}</p>" for line in said]

    first = paragraphs(first_screen(diagnosis))
    if diagnosis.wrong and diagnosis.wrong[0].mends:
        first[1:1] = ["<p>Mended:</p>", _mended(diagnosis.wrong[0].mends[0])]
    parts = {
        "summary": "".join(first),
        "shared": "".join(paragraphs(map(shared_words, diagnosis.shared))),
        "equations": "\n".join(_card(finding) for finding in diagnosis.findings),
        "last": "".join(paragraphs(last_lines(diagnosis))),
    }
    template = resources.files("pendpin.doctor").joinpath("report.html").read_text(encoding="utf-8")
    for name, part in parts.items():
        template = template.replace("{{" + name + "}}", part)
    return template


def _mended(mend: Mend) -> str:
    """A mended equation, what is new marked."""
    pieces = ((html.escape(part), new) for part, new in marked(mend))
    before, after = '<span class="changed">', "</span>"
    return f"<pre>{''.join(before + part + after if new else part for part, new in pieces)}</pre>"


def _card(finding: Finding) -> str:
    """One equation, its verdict, and what mends it."""
    head = (("place", f"{finding.number}, {finding.place}"), ("badge", finding.verdict), ("kind", finding.kind))
    spans = "".join(f'<span class="{name}">{html.escape(said)}</span>' for name, said in head if said != "unread")
    printed = shortened(one_line(finding.latex), MOST_ON_PAGE)
    body = [f"<header>{spans}</header>", f"<pre>{html.escape(printed)}</pre>"]
    if finding.condition:
        body.append(f"<p><strong>holds if {html.escape(finding.condition)}</strong></p>")
    if finding.verdict == "fails":
        body.append(f"<p>{html.escape(failure(finding))}</p>")
        for rank, mend in enumerate(finding.mends):
            words = f"{'Or' if rank else 'Mend'}: {html.escape(mend.words + explain_change(mend.old, mend.new))}"
            body.append(f'<div class="mend"><p>{words}</p>{_mended(mend)}</div>')
    elif finding.remark:
        body.append(f"<p class='remark'>{html.escape(finding.remark)}</p>")
    style = finding.verdict.replace(" ", "-")
    return f'<article class="{style}" id="equation-{finding.number}">{"".join(body)}</article>'

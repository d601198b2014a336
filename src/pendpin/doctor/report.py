"""What is found about the equations of a document, shown as a report, as records for machines and as one HTML page."""

import html
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from importlib import resources
from typing import Any

import numpy as np

from pendpin.doctor.checking.check import in_symbols
from pendpin.doctor.checking.residuals import TOLERANCE, Equation, residuals
from pendpin.doctor.mending.mends import Mend
from pendpin.doctor.reading.tree import Unread
from pendpin.doctor.recognition import UNKNOWN
from pendpin.doctor.systems.base import System, dot, free_states
from pendpin.doctor.systems.rod import AXES
from pendpin.errors import amount, brief, one_line
from pendpin.ground.report import Report, Result, Styled

# the verdicts and how many of them are counted, of one and of several; those that are doubtful or give a state apart
COUNTED = {
    "holds": ("holds", "hold"),
    "holds if": ("holds under a condition", "hold under a condition"),
    "fails": ("fails", "fail"),
    "doubtful": ("does not hold as read", "do not hold as read"),
    "not checked": ("is not checked", "are not checked"),
    "state": ("gives a value or names", "give values or names"),
}
STYLES = {"holds": "green", "holds if": "green", "fails": "bold red", "not checked": "yellow"}
# what is said below an equation: how far it is indented on a terminal, and its style
BELOW = {"why": (6, ""), "none": (6, "yellow"), "mend": (6, ""), "mended": (12, ""), "remark": (6, "dim")}
MOST_PRINTED, MOST_ON_PAGE = 20_000, 2_000  # characters of an equation in a record, and on a page
MOST_SYMBOLS = 6  # of those that are not known, in the first lines
MOST_LISTED = 8  # equations or lines in a row
RECORDED = "number latex kind verdict condition proved error place remark when dimensions follows"
# of the usual names of the inertia: why one that stands for the other is wrong
INERTIAS = {"ml23": "m l²/3 is the inertia about the joint", "ml212": "m l²/12 is the inertia about G"}


@dataclass(frozen=True, eq=False, repr=False)
class Finding:
    """What is found about one equation: holds, holds if, fails or not checked; `condition` says when it holds."""

    number: int
    latex: str
    place: str
    kind: str
    verdict: str
    condition: str = ""
    proved: bool = False
    error: float = 0.0  # relative to its terms
    remark: str = ""
    when: str = ""
    dimensions: str = ""
    mends: tuple[Mend, ...] = ()
    equation: Equation | None = None
    follows: int = 0  # the number of the wrong equation that it follows from; 0 for none
    unknown: tuple[str, ...] = ()  # the symbols for want of which it is not checked

    def __repr__(self) -> str:
        return brief(f"Finding: equation {self.number}, {self.place}, {self.kind}: {self.verdict}. {self.latex}")

    @property
    def doubtful(self) -> bool:
        """Whether it does not hold as it is read, without a small change that would show what is wrong."""
        return self.verdict == "not checked" and bool(self.when)

    def below(self) -> Iterator[tuple[str, list[tuple[str, str]]]]:
        """Why it fails and what mends it, or a remark: what each line is, of BELOW, and its pieces with their styles."""
        if self.verdict == "fails":
            off = f"off by {self.error:.2g} of its terms, {self.when}"
            dimensions = f"dimensions do not agree: {self.dimensions}" if self.dimensions else ""
            yield "why", [(f"{self.place}: {'; '.join(filter(None, (off, dimensions, self.remark)))}", "")]
            if not self.mends:
                yield "none", [("no simple mend found", "")]
            for rank, mend in enumerate(self.mends):
                words = mend.words + explain_change(mend.old, mend.new)
                yield "mend", [("or:   " if rank else "mend: ", "green"), (words, "")]
                yield "mended", [(part, "reverse" * new) for part, new in mend.pieces]
        elif self.verdict != "not checked":
            exact = self.proved or self.condition or self.kind == "definition"
            if said := self.remark or ("" if exact else "compared in floats, not to 25 digits"):
                yield "remark", [(said, "")]
            elif self.mends:
                yield "mend", [("without that condition: ", "dim"), (self.mends[0].words, "")]


@dataclass(frozen=True, eq=False, repr=False)
class Diagnosis(Result):
    """Every equation with its verdict, for the system that they were checked for."""

    findings: tuple[Finding, ...]
    system: System
    title: str
    remarks: tuple[str, ...] = ()
    skipped: tuple[str, ...] = ()  # the lines with an equals sign that were not read as equations

    @property
    def ok(self) -> bool:
        """Whether some equation, no definition, holds, if only under a condition, and none fails or is doubtful."""
        verdicts = {finding.verdict for finding in self.findings if finding.kind != "definition"}
        return bool(verdicts & {"holds", "holds if"}) and "fails" not in verdicts and not self.doubtful

    @property
    def wrong(self) -> tuple[Finding, ...]:
        """The equations that fail."""
        return tuple(finding for finding in self.findings if finding.verdict == "fails")

    @property
    def doubtful(self) -> tuple[Finding, ...]:
        """The equations that do not hold as they are read, and may be wrong or meant otherwise."""
        return tuple(finding for finding in self.findings if finding.doubtful)

    @property
    def shared(self) -> list[tuple[str, str, list[int]]]:
        """The changes that mend several equations: what is replaced, by what, and the numbers of the equations."""
        groups: dict[tuple[str, str], list[int]] = {}
        for finding in self.wrong:
            if finding.mends and (mend := finding.mends[0]).old and mend.new:
                groups.setdefault((mend.old, mend.new), []).append(finding.number)
        return [(*pair, numbers) for pair, numbers in groups.items() if len(numbers) > 1]

    def report(self) -> Report:
        """The report line by line, the findings as data (docs/doctor.md), and the first line where all is not well."""
        first, *others = first_screen(self)
        lines = [Styled([(first, "bold" if not self.wrong and not self.doubtful else "bold red")]), *others]
        for one in self.findings:
            condition, printed = f" {one.condition}" * bool(one.condition), one_line(one.latex)
            about = f"{condition}  {one.kind}: {brief(printed, 300)}"
            if one.verdict == "not checked":
                about = f"  {one.place}: {one_line(one.remark)}: {brief(printed, 60)}"
            lines.append(Styled([(f"{one.number:3} ", ""), (one.verdict, STYLES[one.verdict]), (about, "")]))
            for what, pieces in one.below():
                indent, style = BELOW[what]
                lines.append(Styled([(" " * indent, ""), *((text, own or style) for text, own in pieces)]))
        lines += ["", *(Styled([(line, "bold")]) for line in last_lines(self))]
        return Report(lines, self.to_json(), None if self.ok else first)

    def to_json(self) -> list[dict[str, Any]]:
        """One record an equation for machines: number, latex, kind, verdict, proved, error, mends (docs/doctor.md)."""
        records = [{name: getattr(finding, name) for name in RECORDED.split()} for finding in self.findings]
        for finding, record in zip(self.findings, records, strict=True):
            mends = [
                {"latex": mend.latex, "words": mend.words, "residual": residual(mend.equation, self.system)}
                for mend in finding.mends
            ]
            record |= {"latex": brief(finding.latex, MOST_PRINTED), "mends": mends}
        return records

    def page(self) -> str:
        """The report as HTML that needs no network: equations as they are printed, what is new in mends marked."""
        first = _paragraphs(first_screen(self))
        if self.wrong and self.wrong[0].mends:
            first[1:1] = ["<p>Mended:</p>", _block("mended", [*self.wrong[0].below()][2][1])]
        last, cards = "".join(_paragraphs(last_lines(self))), "\n".join(map(_card, self.findings))
        parts = {"summary": "".join(first), "equations": cards, "last": last}
        template = resources.files("pendpin.doctor").joinpath("report.html").read_text(encoding="utf-8")
        return re.sub(r"\{\{(\w+)\}\}", lambda match: parts[match[1]], template)


def first_screen(diagnosis: Diagnosis) -> list[str]:
    """What a reader wants to know first: which line is wrong and why, as what the text was read, what symbols to say."""
    wrong, doubtful, known = diagnosis.wrong, diagnosis.doubtful, diagnosis.title != UNKNOWN
    count, answer = len(diagnosis.findings), list[str]()
    if wrong:
        first, *others = wrong
        mend = f": {first.mends[0].words}" if first.mends else ""
        answer.append(f"Equation {first.number}, {first.place}, is the first wrong one{mend}.")
        later, rest = ([one for one in others if (one.follows == first.number) is here] for here in (True, False))
        said = [f"{len(wrong)} of {count} equations {'fail' if others else 'fails'}"]
        said += [f"{_listed(later, 'follows', 'follow')} from it"] * bool(later)
        said += [f"{_listed(rest, 'is', 'are')} wrong too"] * bool(rest)
        answer.append(f"{'; '.join(said)}.")
    read_as, *remarks = [f"Read as equations of {diagnosis.title}."] * known + [*diagnosis.remarks]
    why = "not hold as read here, and may be wrong or meant otherwise; the reasons are below."
    doubt = [f"Equation{'s' * bool(doubtful[1:])} {_listed(doubtful, 'does', 'do')} {why}"] * bool(doubtful)
    answer += [read_as, *doubt, *remarks] if wrong or not known else [*doubt, read_as, *remarks]

    unchecked = [one for one in diagnosis.findings if one.verdict == "not checked" and one.kind != "condition"]
    if known and (left := [one for one in unchecked if not one.when]):  # and what to write so that they are checked
        symbols = list(dict.fromkeys(name.lstrip("?") for one in left for name in one.unknown))
        pairs = ",".join(f"{name}=..." for name in symbols[:MOST_SYMBOLS])
        why = f"say what these symbols are: --symbols {pairs}" if symbols else "the reasons are below."
        answer.append(f"{len(left)} of {count} equations {'are' if left[1:] else 'is'} NOT CHECKED; {why}")
    elif not wrong and not doubtful and known:
        answer.insert(0, "Nothing is wrong in what is checked." if diagnosis.skipped else "Nothing is wrong.")
    return answer


def last_lines(diagnosis: Diagnosis) -> list[str]:
    """The mends that several equations share, how many hold, fail and could not be read, and what was not looked at."""
    answer = []
    for old, new, numbers in diagnosis.shared:
        listed = f"{', '.join(map(str, numbers[:-1]))} and {numbers[-1]}"
        answer.append(f"{new} for {old} heals equations {listed}{explain_change(old, new)}.")
    kind = lambda one: "doubtful" if one.doubtful else "state" if one.kind == "condition" else one.verdict  # noqa: E731
    counts = Counter(map(kind, diagnosis.findings))
    said = ", ".join(f"{counts[kind]} {both[counts[kind] != 1]}" for kind, both in COUNTED.items() if counts[kind])
    answer.append(f"{amount(len(diagnosis.findings), 'equation')} of {diagnosis.title}: {said}.")
    if diagnosis.wrong:
        answer[-1] += f" The first wrong one is equation {diagnosis.wrong[0].number}, {diagnosis.wrong[0].place}."
    elif diagnosis.doubtful:
        answer.append("Not every equation holds as it is read: this does not prove that all is right (exit status 1).")
    if diagnosis.skipped:
        answer.append(f"Not looked at, though it holds an equals sign: {_few(diagnosis.skipped)}.")
    return answer


def _listed(findings: Sequence[Finding], one: str, several: str) -> str:
    """Some equations by their numbers and places, and what is said of one or of several."""
    return f"{_few([f'{found.number} ({found.place})' for found in findings])} {several if findings[1:] else one}"


def _few(every: Sequence[str]) -> str:
    """The first of some words, and how many more there are."""
    return ", ".join(every[:MOST_LISTED]) + f" and {len(every) - MOST_LISTED} more" * (len(every) > MOST_LISTED)


def explain_change(old: str, new: str) -> str:
    """Why a change that is often needed is right; empty for others."""
    about = [INERTIAS.get(re.sub(r"[ {}*/]|\\frac|\^", "", text), "") for text in (old, new)]
    return f": {about[0]}, {about[1].replace('is the inertia', 'that')}" if all(about) and old != new else ""


@np.errstate(all="ignore")
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


def _paragraphs(said: Iterable[str]) -> list[str]:
    """Lines of text for a page, in which numbers of equations lead to their cards."""
    link, number = r'<a href="#equation-\1">\1</a>\2', re.compile(r"(?<!\d)(\d+)( [(]|, )(?=line )")
    return [f"<p>{number.sub(link, html.escape(line))}</p>" for line in said]


def _block(what: str, pieces: list[tuple[str, str]]) -> str:
    """What is said below an equation, for a page; what is new in a mended one is marked."""
    marked = (('<span class="changed">', "</span>") if style == "reverse" else ("", "") for _, style in pieces)
    text = "".join(f"{start}{html.escape(part)}{end}" for (part, _), (start, end) in zip(pieces, marked, strict=True))
    return f"<pre>{text}</pre>" if what == "mended" else f'<p class="{what}">{text}</p>'


def _card(finding: Finding) -> str:
    """One equation on a page, its verdict, and what mends it."""
    head = (("place", f"{finding.number}, {finding.place}"), ("badge", finding.verdict), ("kind", finding.kind))
    spans = "".join(f'<span class="{name}">{html.escape(said)}</span>' for name, said in head if said != "unread")
    printed = html.escape(brief(one_line(finding.latex), MOST_ON_PAGE))
    condition = f"<p><strong>holds if {html.escape(finding.condition)}</strong></p>" if finding.condition else ""
    below = [*finding.below()] or [("remark", [(finding.remark, "")])] * bool(finding.remark)
    body = f"<header>{spans}</header><pre>{printed}</pre>{condition}{''.join(_block(*one) for one in below)}"
    return f'<article class="{finding.verdict.replace(" ", "-")}" id="equation-{finding.number}">{body}</article>'

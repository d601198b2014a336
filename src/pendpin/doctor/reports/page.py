"""A diagnosis as one HTML page: equations in MathML, verdicts, mends, and the printed motion beside the true one."""

import html
import json
import re
from contextlib import suppress
from importlib import resources
from pathlib import Path

import numpy as np

from pendpin.doctor.findings import Finding, Findings
from pendpin.doctor.mending.mends import Mend
from pendpin.doctor.reading.grammar import parse
from pendpin.doctor.reading.names import Vocabulary, raw
from pendpin.doctor.reading.tree import Unread
from pendpin.doctor.reports.harm import Harm
from pendpin.doctor.reports.mathml import equation, part
from pendpin.doctor.reports.text import STYLES, explain_change, failure, shared_words, shortened, summary, unchecked
from pendpin.ground.files import write_whole

PER_SECOND = 30  # poses of the animation
_PHRASES = re.compile(
    r"(\bthe (?:sign of|factor|term|\w+)\b|\bshould be\b|\bis (?:missing(?: in| after)?|too many|wrong)\b"
    r"|\bare exchanged\b|\bfor\b|\bheals equations .*|,? \band\b|, (?:in|where)[a-z ]+$)"
)


def write_report(path: Path, diagnosis: Findings) -> Path:
    """Write the report, whole or not at all. Raises InputError where the path refuses."""
    return write_whole(path, lambda file: file.write(page(diagnosis).encode(errors="replace")))


def page(diagnosis: Findings) -> str:
    """The report as HTML that needs no network."""
    left = [unchecked(diagnosis)] if diagnosis.unchecked and diagnosis.system_is_known else []
    parts = {
        "summary": _text(summary(diagnosis)),
        "remarks": "".join(f"<p>{_text(remark)}</p>" for remark in (*left, *diagnosis.remarks)),
        "shared": "".join(f"<p><strong>{_typeset(shared_words(shared))}</strong></p>" for shared in diagnosis.shared),
        "harm": _harm(diagnosis.harm),
        "equations": "\n".join(_card(finding) for finding in diagnosis.findings),
    }
    template = resources.files("pendpin.doctor.reports").joinpath("report.html").read_text(encoding="utf-8")
    for name, text in parts.items():
        template = template.replace("{{" + name + "}}", text)
    return template


def _text(text: str) -> str:
    return html.escape(text)


def _card(finding: Finding) -> str:
    """One equation, its verdict, and what mends it."""
    assert finding.verdict in STYLES
    printed = (
        equation(finding.equation.sides) if finding.equation else f"<pre>{_text(shortened(finding.latex, 2000))}</pre>"
    )
    head = (("number", str(finding.number)), ("badge", finding.verdict), ("kind", _text(finding.kind)))
    spans = "".join(f'<span class="{name}">{text}</span>' for name, text in head)
    body = [f"<header>{spans}</header>", printed]
    if finding.condition:
        body.append(f"<p><strong>holds if {_text(finding.condition)}</strong></p>")
    if finding.verdict == "fails":
        body.append(f"<p>{_text(finding.place)}: {_text(failure(finding))}</p>")
        body += [_mend(mend, rank) for rank, mend in enumerate(finding.mends)] or ["<p>No simple mend found.</p>"]
        body.append(f"<details><summary>Source</summary><pre>{_text(finding.latex)}</pre></details>")
    elif finding.remark:
        body.append(f"<p class='remark'>{_text(finding.place)}: {_text(finding.remark)}</p>")
    return (
        f'<article class="{finding.verdict.replace(" ", "-")}" id="equation-{finding.number}">{"".join(body)}</article>'
    )


def _mend(mend: Mend, rank: int) -> str:
    words = f"{'Mend' if not rank else 'Or'}: {_typeset(mend.words)}{_text(explain_change(mend.old, mend.new))}"
    marked = tuple((start, max(end, start + 1)) for start, end in mend.changed)  # where something is gone, what follows
    typeset = equation(mend.equation.sides, marked)
    return f'<div class="mend"><p>{words}</p>{typeset}<pre>{_text(mend.latex)}</pre></div>'


def _typeset(words: str) -> str:
    """Words on mends, their formulas typeset where they are in LaTeX and can be read alone."""
    return "".join(_formula(piece) if "\\" in piece else _text(piece) for piece in _PHRASES.split(words))


def _formula(text: str) -> str:
    with suppress(Unread, ValueError):
        [[side]] = parse(text, Vocabulary(raw))
        return f" <math>{part(side, ())}</math> "
    return _text(text)


def _harm(harm: Harm | None) -> str:
    """The words on the harm, and the animation where the motion differs."""
    if harm is None:
        return ""
    words = "".join(f"<p>{_text(line)}</p>" for line in harm.words)
    if not len(harm.t):
        return f"<section>{words}</section>"
    step = max(1, round(1 / ((harm.t[1] - harm.t[0]) * PER_SECOND)))
    data = {
        name: np.round(values[::step], 4).tolist()
        for name, values in (("t", harm.t), ("real", harm.true), ("printed", harm.printed))
    }
    legend = "<p><span class='real'>true</span> (solid) and <span class='printed'>as printed</span> (dashed)</p>"
    canvas = '<canvas id="motion" width="760" height="380"></canvas><p id="clock"></p>'
    poses = f'<script type="application/json" id="data">{json.dumps(data)}</script>'
    return f"<section><h2>What the wrong equations do</h2>{words}{legend}{canvas}{poses}</section>"

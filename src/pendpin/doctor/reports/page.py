"""A diagnosis as one HTML page: verdicts, equations as they are printed, mends with what is new marked."""

import html
from importlib import resources
from pathlib import Path

from pendpin.doctor.findings import Finding, Findings
from pendpin.doctor.mending.mends import Mend
from pendpin.doctor.reports.text import (
    STYLES,
    explain_change,
    failure,
    first_screen,
    last_lines,
    marked,
    shared_words,
    shortened,
)
from pendpin.errors import one_line
from pendpin.ground.files import write_whole

MOST_PRINTED = 2000  # characters of an equation


def write_report(path: Path, diagnosis: Findings) -> Path:
    """Write the report, whole or not at all. Raises InputError where the path refuses."""
    return write_whole(path, lambda file: file.write(page(diagnosis).encode(errors="replace")))


def page(diagnosis: Findings) -> str:
    """The report as HTML that needs no network."""
    parts = {
        "summary": "".join(f"<p>{_text(line)}</p>" for line in first_screen(diagnosis)),
        "shared": "".join(f"<p><strong>{_text(shared_words(shared))}</strong></p>" for shared in diagnosis.shared),
        "equations": "\n".join(_card(finding) for finding in diagnosis.findings),
        "last": "".join(f"<p>{_text(line)}</p>" for line in last_lines(diagnosis)),
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
    head = (("place", finding.place), ("badge", finding.verdict), ("kind", finding.kind))
    spans = "".join(f'<span class="{name}">{_text(text)}</span>' for name, text in head if text != "unread")
    body = [f"<header>{spans}</header>", f"<pre>{_text(shortened(one_line(finding.latex), MOST_PRINTED))}</pre>"]
    if finding.condition:
        body.append(f"<p><strong>holds if {_text(finding.condition)}</strong></p>")
    if finding.verdict == "fails":
        body.append(f"<p>{_text(failure(finding))}</p>")
        body += [_mend(mend, rank) for rank, mend in enumerate(finding.mends)]
    elif finding.remark:
        body.append(f"<p class='remark'>{_text(finding.remark)}</p>")
    style = finding.verdict.replace(" ", "-")
    return f'<article class="{style}" id="equation-{finding.number}">{"".join(body)}</article>'


def _mend(mend: Mend, rank: int) -> str:
    words = f"{'Mend' if not rank else 'Or'}: {_text(mend.words + explain_change(mend.old, mend.new))}"
    text = "".join(
        f'<span class="changed">{_text(part)}</span>' if style else _text(part) for part, style in marked(mend)
    )
    return f'<div class="mend"><p>{words}</p><pre>{text}</pre></div>'

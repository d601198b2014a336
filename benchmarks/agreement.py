"""Writes the table and the picture of docs/agreement.md.

python benchmarks/agreement.py          # some minutes: every case by every method
python benchmarks/agreement.py --quick  # dop853 alone, and nothing is written
"""

import sys
from pathlib import Path

from pages import write_between_marks
from pendpin.graphics.style import write_figure
from pendpin.verification.agreement import AgreementReport, draw_motions, published_cases, validate

DOCS = Path(__file__).parents[1] / "docs"


def table(report: AgreementReport) -> list[str]:
    """A row for each published quantity: bound, the best and the worst difference with their methods."""
    lines = ["| case | quantity | bound | smallest difference | largest difference |", "|---|---|---|---|---|"]
    for worst in report.worst:
        rows = [row for row in report.comparisons if (row.case, row.quantity) == (worst.case, worst.quantity)]
        best = min(rows, key=lambda row: row.measured if row.measured is not None else float("inf"))
        shown = ["failed" if r.measured is None else f"{r.measured:.1e} {r.unit}" for r in (best, worst)]
        cells = (worst.case, worst.quantity, f"{worst.bound:.0e} {worst.unit}")
        lines.append(f"| {' | '.join(cells)} | {shown[0]}, {best.method} | {shown[1]}, {worst.method} |")
    return lines


def sources() -> list[str]:
    """Where the numbers of each case come from."""
    return [
        f"- **{name}**: {case.title}. Numbers by {case.origin}. {case.source}.{' ' + case.note if case.note else ''}"
        for name, case in published_cases().items()
    ]


def main() -> int:
    """Run the cases and rewrite the page's table, list and picture."""
    quick = "--quick" in sys.argv
    report = validate(methods=["dop853"] if quick else None, progress=print)
    lines = [*table(report), "", *sources(), "", *(f"- Left out: {line}." for line in report.left_out)]
    print("\n".join(lines))
    if not quick:
        write_between_marks(DOCS / "agreement.md", "table", lines)
        write_figure(DOCS / "images" / "agreement.png", lambda: draw_motions(list(published_cases())))
    return int(bool(report.broken))


if __name__ == "__main__":
    sys.exit(main())

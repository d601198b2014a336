"""Writes the figures into docs/hard_cases_catalogue.md and docs/hard_cases.md, from the JSON that the command prints.

pendpin hard --json > hard.json
pendpin hard --peers --json > peers.json
python benchmarks/hard_cases.py hard.json peers.json [another folder of the two pages]
"""

import sys
from itertools import groupby
from json import loads
from pathlib import Path
from typing import Any

from pages import write_between_marks
from pendpin.verification.hardcases.base import GROUPS

DOCS = Path(__file__).parents[1] / "docs"


def number(value: float | None) -> str:
    """A figure in a cell."""
    return "none" if value is None else "0" if value == 0 else f"{value:.1e}"


def settings(method: dict[str, float]) -> str:
    """A method's setting in words."""
    return ", ".join(f"{name} {value:g}{' s' if name == 'step' else ''}" for name, value in method.items())


def case_lines(case: dict[str, Any], rows: list[dict[str, Any]]) -> list[str]:
    """One case: its text, its bound, and a row for each method."""
    lines = [f"### {case['name']}: {case['title']}", "", f"{case['physics']} {case['why']}", ""]
    lines += [f"Measured: {case['figure']}. Bound {number(case['bound'])}: {case['derivation']}.", ""]
    lines += ["| method | setting | measured | verdict | s |", "|---|---|---|---|---|"]
    for row in rows:
        setting = settings(case["methods"].get(row["method"], {}))
        cells = (row["method"], setting, number(row["measured"]), row["verdict"], f"{row['seconds']:.2f}")
        lines.append(f"| {' | '.join(cells)} |")
    return [*lines, *(f"\n{row['method']}: {row['failure']}" for row in rows if row["failure"]), ""]


def figures(found: dict[str, Any]) -> list[str]:
    """All cases, group by group."""
    rows = {case["name"]: [r for r in found["outcomes"] if r["case"] == case["name"]] for case in found["cases"]}
    lines = []
    for group, cases in groupby(found["cases"], key=lambda case: case["group"]):
        lines += [f"## {group}. {GROUPS[group]}", ""]
        for case in cases:
            lines += case_lines(case, rows[case["name"]])
    return lines


def survivors(found: dict[str, Any]) -> list[str]:
    """A row for each case, a column for each simulator: the figure, bold within the bound; then the failures."""
    methods = list(dict.fromkeys(row["method"].split(",")[0] for row in found["outcomes"]))
    lines = [f"| case | bound | {' | '.join(methods)} |", "|---|---|" + "---|" * len(methods)]
    reasons: dict[str, list[str]] = {}
    for name, rows in groupby(found["outcomes"], key=lambda row: row["case"]):
        cells, bound = {}, 0.0
        for row in rows:
            method, bound = row["method"].split(",")[0], row["bound"]
            if row["failure"]:
                reasons.setdefault(f"{method}: {row['failure'].split('; it got')[0]}", []).append(name)
            text = "failed" if row["measured"] is None else number(row["measured"])
            cells[method] = f"**{text}**" if row["ok"] else text
        lines.append(f"| {name} | {number(bound)} | {' | '.join(cells.get(method, '') for method in methods)} |")
    held = {
        method: sum(r["ok"] for r in found["outcomes"] if r["method"].split(",")[0] == method) for method in methods
    }
    total = len({row["case"] for row in found["outcomes"]})
    lines += [
        "",
        "Within the bound: " + ", ".join(f"{method} {count}" for method, count in held.items()) + f" of {total}.",
        "",
    ]
    return lines + [f"- {reason} ({', '.join(names)})" for reason, names in reasons.items()]


def main() -> None:
    """Read the two files of figures and rewrite the two pages."""
    folder = Path(sys.argv[3]) if len(sys.argv) > 3 else DOCS
    parts = (("figures", figures, "hard_cases_catalogue.md"), ("peers", survivors, "hard_cases.md"))
    for (name, part, page), file in zip(parts, sys.argv[1:3], strict=False):
        write_between_marks(folder / page, name, part(loads(Path(file).read_text())))


if __name__ == "__main__":
    main()

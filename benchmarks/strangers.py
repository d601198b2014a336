"""How the equation doctor does on texts that nobody of this project wrote, against truth tables that were fixed before.

    python benchmarks/strangers.py --texts DIR [--rows open sealed] [--planted] [--only NAME ...] [--show] [--sources]

The texts are encyclopaedias, lecture notes, READMEs, blogs and code of others and are not part of this repository. DIR is a
folder that holds them under their own names; what it lacks is named with the place where it is to be had, and --sources
names all: a file of a repository at a commit and the lines of it that were taken. strangers/open.toml and
strangers/sealed.toml hold the rows: line (and `to`), the columns `span` of one of several equations in these lines, and
whether it is right, wrong (with the fault and the right form) or undecidable (a slip, or a convention that the text
leaves open: either verdict is fair). `follows`: wrong only because it continues a wrong one. `plants`: single changes of
right rows. `known = false`: no system of pendpin; what is right there is at best not checked.

Only the public result of pp.diagnose is read: findings with a place, an equation, a verdict and mends.
"""

import argparse
import difflib
import hashlib
import re
import tempfile
import time
import tomllib
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pendpin as pp

FOLDER = Path(__file__).with_name("strangers")
NEAR = 3  # lines between the place that a finding names and its row: a display may be named by its first line
ALIKE = 0.55  # of the shorter of two equations that must be in the other for a finding to be about a row
CONTAINED = 0.85  # of a row that must be in the finding of another for it to be part of it
LONGER = 1.3  # a finding that is so many times as long as its row is a chain of several
_NAMES = re.compile(r"[\w.()\[\]]+\s*=\s*[\w.()\[\]]+")  # no more than two
_LAYOUT = re.compile(
    r"\\(?:left|right|[bB]igg?[lr]?|[dt]?frac|quad|qquad|displaystyle|text|mathrm|operatorname|begin|end|tag)\b"
    r"|\\[,;:! ]|[\s&{}$`*·]|\\\\"
)


@dataclass(frozen=True)
class Row:
    """One equation of a text and what is true of it."""

    line: int
    to: int
    equation: str
    truth: str
    kind: str = "statement"
    follows: bool = False


@dataclass(frozen=True)
class Said:
    """What the doctor says of one equation."""

    line: int
    equation: str
    verdict: str
    condition: str
    mend: str


@dataclass
class Outcome:
    """The verdict on each row of a text, what is accused outside the table, and processor seconds."""

    rows: list[tuple[Row, str, list[Said]]] = field(default_factory=list)
    outside: list[Said] = field(default_factory=list)
    seconds: float = 0.0
    error: str = ""


def rows_of(table: dict[str, Any], text: str) -> list[Row]:
    """The rows of a table, each with its equation cut out of the text."""
    lines = text.splitlines()
    rows = []
    for entry in table["rows"]:
        line, to = entry["line"], entry.get("to", entry["line"])
        whole = "\n".join(lines[line - 1 : to])
        start, end = entry.get("span", (0, len(whole)))
        equation = whole[start:end]
        rows.append(
            Row(line, to, equation, entry["truth"], entry.get("kind", "statement"), entry.get("follows", False))
        )
    return rows


def said_of(path: Path) -> tuple[list[Said], float, str]:
    """The findings of a file, processor seconds, and the error if the doctor could not read it."""
    began = time.process_time()
    try:
        diagnosis: Any = pp.diagnose(path)
    except pp.PendpinError as error:
        return [], time.process_time() - began, str(error)
    except Exception as error:  # a text on which the doctor breaks is counted, and the others are still examined
        return [], time.process_time() - began, f"BROKEN: {type(error).__name__}: {error}"
    seconds = time.process_time() - began
    said = []
    for finding in diagnosis.findings:
        place = re.search(r"\d+", str(getattr(finding, "line", "") or getattr(finding, "place", "")))
        equation = str(getattr(finding, "latex", "") or getattr(finding, "text", ""))
        mends = getattr(finding, "mends", ())
        mend = str(getattr(mends[0], "latex", mends[0])) if mends else ""
        condition = str(getattr(finding, "condition", ""))
        said.append(Said(int(place[0]) if place else 0, equation, finding.verdict, condition, mend))
    return said, seconds, ""


def likeness(first: str, second: str) -> float:
    """The part of the shorter equation, without layout, that is found in the other, in runs of three signs or more."""
    a, b = (_LAYOUT.sub("", text) for text in (first, second))
    if min(len(a), len(b)) == 0:
        return 0.0
    blocks = difflib.SequenceMatcher(None, a, b, autojunk=False).get_matching_blocks()
    common = sum(block.size for block in blocks if block.size >= min(3, len(a), len(b)))
    return common / min(len(a), len(b)) - 0.1 * abs(len(a) - len(b)) / max(len(a), len(b))


def judge(rows: list[Row], said: list[Said]) -> tuple[list[tuple[Row, str, list[Said]]], list[Said]]:
    """Each row with its verdict and findings; and the findings that accuse what is not in the table.

    A finding belongs to the row near its line that it is most like. A chain in one finding contains several rows: if it
    fails it belongs to the wrong one among them, else to all that have no finding of their own. A row fails if a finding of
    it fails, and holds if one holds and none fails.
    """
    found: dict[int, list[Said]] = {}
    outside = []
    for one in said:
        most = (
            LONGER * len(one.equation) if _NAMES.fullmatch(one.equation) else float("inf")
        )  # omega' = a is no a = ...
        near = [i for i, row in enumerate(rows) if is_near(one, row) and len(row.equation.strip()) < most]
        scores = {i: likeness(one.equation, rows[i].equation) for i in near}
        best = max(scores, key=lambda i: (scores[i], -abs(rows[i].line - one.line)), default=None)
        if best is not None and one.verdict == "fails" and len(one.equation) > LONGER * len(rows[best].equation):
            best = next((i for i in scores if rows[i].truth == "wrong" and scores[i] >= CONTAINED), best)
        if best is not None and scores[best] >= ALIKE:
            found.setdefault(best, []).append(one)
        elif one.verdict == "fails":
            outside.append(one)
    for i in set(range(len(rows))) - set(found):
        whole = [one for one in said if one.verdict != "fails" and is_near(one, rows[i])]
        found[i] = [one for one in whole if likeness(one.equation, rows[i].equation) >= CONTAINED][:1]
    judged = []
    for i, row in enumerate(rows):
        verdicts = [one.verdict for one in found.get(i, [])]
        fails, holds = "fails" in verdicts, any(verdict.startswith("holds") for verdict in verdicts)
        judged.append((row, "fails" if fails else "holds" if holds else "not checked", found.get(i, [])))
    return judged, outside


def is_near(one: Said, row: Row) -> bool:
    """Whether a finding is named at the lines of a row, or within a display around it."""
    return row.line - NEAR - one.equation.count("\n") <= one.line <= row.to + NEAR


def examine(table: dict[str, Any], text: str, rows: list[Row]) -> Outcome:
    """What the doctor says of a text, row by row."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / table["file"]
        path.write_text(text, encoding="utf-8")
        said, seconds, error = said_of(path)
    judged, outside = judge(rows, said)
    return Outcome(judged, outside, seconds, error)


def planted(text: str, plant: dict[str, Any]) -> str:
    """A text with one change: `cut` signs of a line from column `at` on give way to `put`."""
    lines = text.splitlines(keepends=True)
    line = lines[plant["line"] - 1]
    lines[plant["line"] - 1] = line[: plant["at"]] + plant["put"] + line[plant["at"] + plant["cut"] :]
    return "".join(lines)


def whereabouts(table: dict[str, Any]) -> str:
    """Where a text is to be had."""
    if "repository" not in table:
        return f"{table['file']}: {table['address']}"
    first, last = table["lines"]
    place = f"github {table['repository']} at {table['commit'][:12]}, {table['path']}"
    return f"{table['file']}: {place}, lines {first} to {last}"


def text_of(table: dict[str, Any], folders: list[Path]) -> str:
    """The text of a table from the first folder that holds it unchanged; empty if none does."""
    for folder in folders:
        path = folder / table["file"]
        if path.exists():
            data = path.read_bytes()
            if hashlib.sha256(data).hexdigest().startswith(table["sha256"]):
                return data.decode("utf-8")
            print(f"{path} is not the text of the table: its hash differs")
    return ""


def show(name: str, outcome: Outcome) -> None:
    """Every row of a text on which doctor and table disagree, or that is not checked."""
    print(f"\n{name}: {outcome.seconds:.1f} s {outcome.error}")
    for row, verdict, said in outcome.rows:
        agree = (row.truth, verdict) in (("right", "holds"), ("wrong", "fails"))
        mark = "  " if agree or row.truth == "undecidable" else "! " if verdict != "not checked" else "? "
        note = f"   -> {said[0].mend}" if verdict == "fails" and said else ""
        condition = next((one.condition for one in said if one.condition), "")
        equation = " ".join(row.equation.split())[:110]
        print(f"  {mark}{row.line:4} {row.truth:11} {verdict:11} {condition} {equation}{note[:140]}")
    for one in outcome.outside:
        print(f"  !! {one.line:4} accused, not in the table: {' '.join(one.equation.split())[:110]} -> {one.mend[:80]}")


def report(title: str, outcomes: dict[str, tuple[dict[str, Any], Outcome]]) -> None:
    """The confusion table of many texts with precision and recall."""
    count: Counter[tuple[str, str]] = Counter()
    for _, outcome in outcomes.values():
        count.update((row.truth, verdict) for row, verdict, _ in outcome.rows)
    parts = {truth: sum(count[truth, v] for v in ("holds", "fails", "not checked")) for truth in ("right", "wrong")}
    outside = sum(len(outcome.outside) for _, outcome in outcomes.values())
    first = [
        verdict for _, o in outcomes.values() for row, verdict, _ in o.rows if row.truth == "wrong" and not row.follows
    ]
    known = [
        verdict
        for table, o in outcomes.values()
        if table.get("known", True)
        for row, verdict, _ in o.rows
        if row.truth == "right"
    ]
    seconds = [outcome.seconds for _, outcome in outcomes.values()]
    accused = count["wrong", "fails"] + count["right", "fails"]
    print(f"\n{title}: {len(outcomes)} texts")
    print(f"{'':12}{'holds':>8}{'fails':>8}{'not checked':>14}{'sum':>8}")
    for truth in ("right", "wrong", "undecidable"):
        cells = [count[truth, verdict] for verdict in ("holds", "fails", "not checked")]
        print(f"{truth:12}{cells[0]:8}{cells[1]:8}{cells[2]:14}{sum(cells):8}")
    print(f"accusations that are true: {share(count['wrong', 'fails'], accused)}; {outside} more outside the table")
    print(f"right equations accused: {share(count['right', 'fails'], parts['right'])}")
    print(f"right equations that hold: {share(count['right', 'holds'], parts['right'])}")
    print(f"  of systems that pendpin knows: {share(sum(v == 'holds' for v in known), len(known))}")
    print(f"wrong equations found: {share(count['wrong', 'fails'], parts['wrong'])}")
    print(f"  that do not follow from an earlier one: {share(sum(v == 'fails' for v in first), len(first))}")
    held = [said for _, o in outcomes.values() for row, v, said in o.rows if (row.truth, v) == ("wrong", "holds")]
    bare = sum(any(one.verdict == "holds" for one in said) for said in held)
    print(f"wrong equations said to hold: {bare}, and {len(held) - bare} under a condition")
    if broken := [name for name, (_, outcome) in outcomes.items() if outcome.error.startswith("BROKEN")]:
        print(f"texts on which the doctor breaks: {', '.join(broken)}")
    average = sum(seconds) / max(len(seconds), 1)
    print(f"processor seconds a text: {average:.2f} on average, {max(seconds, default=0):.1f} at most")


def share(part: int, whole: int) -> str:
    """A part of a whole, with its percentage."""
    return f"{part} of {whole}" + (f" ({100 * part / whole:.0f} %)" if whole else "")


def plant_all(tables: list[tuple[dict[str, Any], str]], shown: bool) -> None:
    """Each plant in its text: whether the changed equation fails, and who else is accused that was not before."""
    verdicts: Counter[str] = Counter()
    first = bystanders = 0
    for table, text in tables:
        if not table.get("plants"):
            continue
        before = examine(table, text, rows_of(table, text))
        for plant in table["plants"]:
            changed = planted(text, plant)
            rows = rows_of(table, changed) if "span" not in str(table["rows"]) else spans_moved(table, changed, plant)
            outcome = examine(table, changed, rows)
            hit = [i for i, row in enumerate(rows) if row.line <= plant["line"] <= row.to and row.truth == "right"]
            hit = [i for i in hit if rows[i].equation != before.rows[i][0].equation] or hit
            verdict = "not checked"
            for i in hit:
                verdict = outcome.rows[i][1] if verdict != "fails" else verdict
            others = [
                row.line
                for i, (row, now, _) in enumerate(outcome.rows)
                if i not in hit and row.truth == "right" and now == "fails" and before.rows[i][1] != "fails"
            ]
            verdicts[verdict] += 1
            bystanders += len(others)
            mend = next((one.mend for i in hit for one in outcome.rows[i][2] if one.verdict == "fails"), "")
            old = text.splitlines()[plant["line"] - 1]
            healed = bool(mend) and likeness(mend, old) > likeness(mend, changed.splitlines()[plant["line"] - 1])
            first += healed
            if shown or verdict != "fails":
                line = " ".join(changed.splitlines()[plant["line"] - 1].split())[:100]
                print(f"  {table['name']} {plant['kind']}: {verdict}; others accused {others}")
                print(f"      {line}\n      -> {mend[:110]}")
    total = sum(verdicts.values())
    print(f"\nplanted faults: {share(verdicts['fails'], total)} found, {verdicts['holds']} said to hold,", end=" ")
    print(f"{verdicts['not checked']} not checked; the first mend is nearer to the original in {first};", end=" ")
    print(f"{bystanders} right equations accused with them")


def spans_moved(table: dict[str, Any], changed: str, plant: dict[str, Any]) -> list[Row]:
    """The rows of a changed text: columns behind the change in its line move with it."""
    moved = {**table, "rows": []}
    shift = len(plant["put"]) - plant["cut"]
    lines = changed.splitlines()
    for entry in table["rows"]:
        entry = dict(entry)
        if "span" in entry and entry["line"] <= plant["line"] <= entry.get("to", entry["line"]):
            at = sum(len(line) + 1 for line in lines[entry["line"] - 1 : plant["line"] - 1]) + plant["at"]
            entry["span"] = [column + shift * (column > at) for column in entry["span"]]
        moved["rows"].append(entry)
    return rows_of(moved, changed)


def main() -> None:
    """Read the arguments, run, print."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--texts", type=Path, nargs="*", default=[], help="folders that hold the texts")
    parser.add_argument("--rows", nargs="*", default=["open", "sealed"], help="tables: names in strangers/, or files")
    parser.add_argument("--only", nargs="*", help="names of texts")
    parser.add_argument("--planted", action="store_true", help="the planted faults in place of the texts as they are")
    parser.add_argument("--show", action="store_true", help="every row")
    parser.add_argument("--sources", action="store_true", help="only where the texts are to be had")
    choices = parser.parse_args()
    for name in choices.rows:
        path = Path(name) if name.endswith(".toml") else FOLDER / f"{name}.toml"
        if not path.exists():
            print(f"{path.name}: no such table")
            continue
        tables = tomllib.loads(path.read_text(encoding="utf-8"))["text"]
        tables = [table for table in tables if not choices.only or table["name"] in choices.only]
        if choices.sources:
            print("\n".join(whereabouts(table) for table in tables))
            continue
        pairs = [(table, text_of(table, choices.texts)) for table in tables]
        for table, text in pairs:
            if not text:
                print(f"missing: {whereabouts(table)}")
        present = [(table, text) for table, text in pairs if text]
        if choices.planted:
            plant_all(present, choices.show)
            continue
        outcomes = {}
        for table, text in present:
            outcomes[table["name"]] = (table, examine(table, text, rows_of(table, text)))
            if choices.show:
                show(table["name"], outcomes[table["name"]][1])
        report(path.stem, outcomes)


if __name__ == "__main__":
    main()

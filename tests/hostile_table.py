"""The table of docs/hostile_input.md: `python tests/hostile_table.py` runs every case and counts by surface."""

import re
import sys
from collections import Counter
from pathlib import Path
from typing import Any

import pytest

import bad_runs

FILES = ("test_bad_input.py", "test_odd_input.py", "test_hostile_surroundings.py")
SURFACES = ("scene", "URDF", "CSV", "saved run", "command line", "surroundings")
ON_THE_COMMAND_LINE = {case.name for case in (*bad_runs.TARGETS, *bad_runs.USAGE)}
TESTS = {
    "test_bad_input_ends_in_one_line": "refused",
    "test_odd_input_runs": "taken",
    "test_implausible_inertia_is_a_finding": "taken",
    "test_what_a_urdf_says_and_pendpin_leaves_out_is_noted": "taken",
    "test_odd_names_are_drawn": "taken",
}
WORKS = ("test_poor_settings", "test_tiny_terminal", "test_two_views")  # surroundings that change nothing


def surface(name: str) -> str:
    """What a case comes in by."""
    if name in ON_THE_COMMAND_LINE:
        return "command line"
    kinds = {"scene": "scene", "urdf": "URDF", "name": "URDF", "csv": "CSV", "plot": "saved run", "view": "saved run"}
    return kinds.get(name.split(":")[0], "command line")


class Tally:
    """A plugin of pytest that counts outcomes."""

    def __init__(self) -> None:
        self.counts = Counter[tuple[str, str]]()

    def pytest_runtest_logreport(self, report: Any) -> None:
        """Book one test: skipped ones are no cases."""
        if report.when == "call" and report.outcome != "skipped":
            file, test, name = re.fullmatch(r"(.*)::(\w+)(?:\[(.*)\])?", report.nodeid, re.DOTALL).groups()
            around = "hostile_surroundings" in file
            expected = TESTS.get(test) if not around else "taken" if test.startswith(WORKS) else "refused"
            if expected:
                place = "surroundings" if around else surface(name)
                self.counts[place, expected if report.outcome == "passed" else "fault"] += 1


def main() -> int:
    """Run the cases and print the table."""
    tally, folder = Tally(), Path(__file__).parent
    status = pytest.main([*(str(folder / name) for name in FILES), "-q", "-n0"], plugins=[tally])
    print("| by way of | cases | refused in one line | taken | anything else |\n|---|---|---|---|---|")
    for place in SURFACES:
        refused, taken, fault = (tally.counts[place, outcome] for outcome in ("refused", "taken", "fault"))
        print(f"| {place} | {refused + taken + fault} | {refused} | {taken} | {fault} |")
    return int(status)


if __name__ == "__main__":
    sys.exit(main())

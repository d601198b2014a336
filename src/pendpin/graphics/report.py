"""What is said of a run: on the terminal, and on one page to print or send, of several runs side by side too.

A page has the scene, the figure and the table of method, accuracy, checks, energy, events and versions.
"""

import html
import json
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from pendpin.errors import PendpinError, amount, moment
from pendpin.graphics.figure import draw
from pendpin.graphics.page import base64_of
from pendpin.graphics.style import picture_of
from pendpin.ground.libraries import VERSION
from pendpin.ground.report import Report, Table
from pendpin.model.notes import as_written, leaving
from pendpin.scene import scene_of
from pendpin.scene.toml import scene_text
from pendpin.trajectory import RunRecord

MOST_EVENTS = 40  # in a list
MOST_TEXT = 20_000  # letters of a scene
MOST_OF_A_NOTE = 400  # letters
ANSWERS = ("at rest from", "largest swing", "largest tilt", "farthest sideways", "R3 largest")  # on the terminal
Check = Callable[[RunRecord], str]  # what a cross-check along a run says; "" where there is none


def page_report(runs: Sequence[Any], check: Check | None = None) -> str:
    """The report on one run, or on several to be compared, as HTML without a network address."""
    columns = list[dict[str, str]]()
    for run in runs:  # how it was computed, its summary, its events and the versions
        column = {"time": f"{moment(run.t[0])} to {moment(run.t[-1])} s, {amount(len(run.t), 'sample')}"}
        column |= dict(_rows(run, check(run) if check else ""))
        column |= {name: str(figure) for name, figure in run.summary().items()}
        if run.events:  # how many of each kind, and the first of them
            kinds = ", ".join(f"{count} {kind}" for kind, count in Counter(event.kind for event in run.events).items())
            first = [f"{moment(event.t)} s: {event.joint} {event.kind}" for event in run.events[:MOST_EVENTS]]
            rest = [f"and {len(run.events) - MOST_EVENTS} more"] * (len(run.events) > MOST_EVENTS)
            column["events"] = "\n".join([kinds, *first, *rest])
        columns.append(column | {"version": f"pendpin {VERSION}"})

    names = dict.fromkeys(name for column in columns for name in column)
    cells = {name: "".join(f"<td>{_text(column.get(name, ''))}</td>" for column in columns) for name in names}
    body = "".join(f"<tr><th>{_text(name)}</th>{row}</tr>" for name, row in cells.items())
    figure = base64_of(picture_of(draw(runs)))
    scenes = list[str]()
    for run in runs:  # as TOML, or, where a scene file cannot hold it, as JSON
        try:
            text = scene_text(scene_of(run), Path.cwd())
        except (PendpinError, OSError):
            text = json.dumps(run.scene, indent=1, default=str)
        scenes.append(text if len(text) <= MOST_TEXT else f"{text[:MOST_TEXT]}\n...")

    alt = "Energy, positions, reactions and paths of the tip"
    return (
        f"<h2>{_text(runs[0].title)}</h2><div class=wide><table>{body}</table></div>"
        f'<h2>Figure</h2><div class="wide"><img src="data:image/png;base64,{figure}" alt="{alt}"></div>'
        f"<h2>Scene</h2>{''.join(f'<pre>{_text(scene)}</pre>' for scene in dict.fromkeys(scenes))}"
    )


def run_report(run: Any, checked: str) -> Report:
    """What the command prints of a run: counts, times, its checks and what it answers; as data everything."""
    energy, stats = run.energy(), run.stats
    data = asdict(stats) | {"energy_drift": energy.drift if stats.conservative else None}
    if run.work:
        data |= {"work": {kind: float(work[-1]) for kind, work in run.work.items()}, "energy_balance": run.imbalance}
    data["summary"] = {name: figure._asdict() for name, figure in run.summary().items()}
    data["joint_events"] = [event._asdict() for event in run.events]

    # how far a pendulum swings, later too if that is less, what it pulls, and when it comes to rest
    rows, summary = [*_rows(run, checked)], run.summary()
    for name in (name for name in ANSWERS if name in summary):
        later = summary.get(f"{name}, second half")
        less = later if later and later.value < summary[name].value else None
        after = f"; after half the time {less.value:.6g} {less.unit}" if less else ""
        rows.append((name, f"{summary[name]}{after}"))
    rows += [("extremes", summary.remark)] if summary.remark else []
    return Report((Table(("run", ""), rows),), data)


def _text(text: str) -> str:
    return html.escape(text).replace("\n", "<br>")


def _rows(run: Any, checked: str) -> Iterator[tuple[str, str]]:
    """How a run was computed, what its checks say, and where the energy went; rows without an answer are left out."""
    stats = run.stats
    if stats.evaluations:  # a mode of small motions is not integrated
        yield "method", f"{stats.method}, {stats.setting} ({stats.library} {stats.version})"
        yield "engine", stats.engine
    if written := as_written(run):
        yield "as written", written
    if stats.evaluations:
        before = f", {stats.all_seconds:.4f} s with the runs before it" if stats.all_seconds else ""
        yield "cost", f"{stats.steps} steps, {stats.evaluations} evaluations, {stats.seconds:.4f} s{before}"
    if stats.compile_seconds:
        yield "compiling", f"{stats.compile_seconds:.4f} s"
    if stats.accuracy:
        error = "no estimate" if stats.error is None else f"{stats.error:.1e} of the length estimated"
        yield "accuracy", f"{error}, {stats.accuracy:g} asked"
    if stats.stopped:
        yield "ended early", stats.stopped[:MOST_OF_A_NOTE]
    if checked:
        yield "cross-check", checked
    if stats.conservative:
        yield "energy drift", f"{run.energy().drift:.1e} of the energy exchanged"
    for kind, work in run.work.items():
        yield f"work of {kind}", f"{work[-1] - work[0]:+.6g} J"
    if run.work:
        yield "kinetic energy", f"{run.kinetic[-1] - run.kinetic[0]:+.6g} J"
        yield "energy balance off by", f"{run.imbalance:.1e} of the energy exchanged"
    elif not stats.conservative:
        change = float(np.diff(run.energy().total[[0, -1]])[0])
        yield "energy change", f"{change:+.6g} J; --energy-balance (energy_balance=True) gives the work of each effect"
    if stats.notes:
        yield "notes", "\n".join(note[:MOST_OF_A_NOTE] for note in stats.notes)
    if left := leaving(run):
        yield "slid away", "\n".join(left)

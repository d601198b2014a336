"""Passes along a chain of any length, recorded once for a rod: what the equations carry from rod to rod becomes a loop.

The equations see a chain of one rod (pendpin.equations.trees): it hangs on what a pass carries outward, and what a pass
carries inward hangs on it. Most of what is carried has structure: entries that stay 0, or entries that are equal, as those
of a symmetric matrix. A body is recorded until this structure no longer changes: first as if a rod passed on what it
receives, then with each entry on its own that turned out to differ.
"""

from collections.abc import Callable, Hashable, Sequence
from functools import partial
from types import SimpleNamespace
from typing import Any

import numpy as np

from pendpin.engines.machine.tape import Cell, Pass, Tape, Term, recorded
from pendpin.equations.trees import Step, inward_steps, outward_steps
from pendpin.ground.arrays import Array

Body = Callable[[Any], Any]  # what arrives at a rod -> what it passes on


def recorded_by_rod(tape: Tape) -> Any:
    """The functions of the number type, as `recorded`, with passes over all rods of a chain on this tape."""
    passes = {"outward": _record_outward, "inward": _record_inward, "total": _record_total}
    return SimpleNamespace(**vars(recorded()), **{name: partial(function, tape) for name, function in passes.items()})


def _record_outward(tape: Tape, step: Step, base: Any, parents: Sequence[int]) -> list[Any]:
    """The results of a step outward at the links (n,) of one rod; `base` is what the first rod of the chain receives."""
    done: list[tuple[Any, Any]] = []

    def body(arriving: Any) -> Any:
        done[:] = outward_steps(step, arriving, parents)
        return done[-1][0]

    _record(tape, False, body, base, body(base))
    return [result for _, result in done]


def _record_inward(
    tape: Tape, step: Step, own: Sequence[Any], join: Callable[[Any, Any], Any], parents: Sequence[int]
) -> list[Any]:
    """The results of a step inward at the links (n,) of one rod; nothing hangs on the last rod of the chain."""
    done: list[tuple[Any, Any]] = []

    def body(arriving: Any) -> Any:
        done[:] = inward_steps(step, [*own[:-1], join(own[-1], arriving)], join, parents)
        return done[0][0]

    passed = inward_steps(step, own, join, parents)[0][0]
    _record(tape, True, body, _rebuilt(passed, [0.0] * len(_entries(passed))), passed)
    return [result for _, result in done]


def _record_total(tape: Tape, x: Array) -> Any:
    """The sum of the numbers (k,) of all rods."""
    own = np.sum(x)
    return _record(tape, False, lambda before: before + own, np.zeros(1), np.array([own]))[0]


def _record(tape: Tape, is_inward: bool, body: Body, first: Any, second: Any) -> Any:
    """Record a pass that begins with `first` and passes on `second`; returns what it carries at its end."""
    number, start, passed = len(tape.passes), _entries(first), _entries(second)
    tape.passes.append(Pass(is_inward, []))
    histories, classes = [(_label(x),) for x in start], None
    while True:
        histories = [(*history, _label(x)) for history, x in zip(histories, passed, strict=True)]
        before, classes = classes, _classes(tape, histories)
        if classes == before:
            break
        arriving = list(start)
        for i, cell in enumerate(classes):
            if cell is not None:
                arriving[i] = tape.carried(number, cell)
        passed = _entries(body(_rebuilt(first, arriving)))
    cells = {cell: Cell(*map(tape.placed, pair)) for cell, *pair in zip(classes, start, passed, strict=True)}
    tape.passes[number] = Pass(is_inward, [cells[cell] for cell in range(len(set(classes) - {None}))])
    return _rebuilt(
        first, [x if cell is None else tape.last(number, cell) for cell, x in zip(classes, start, strict=True)]
    )


def _label(x: Any) -> Hashable:
    """What two entries have in common that are the same: a number, or a place on the tape."""
    return ("at", x.place) if isinstance(x, Term) else float(x)


def _classes(tape: Tape, histories: Sequence[tuple[Hashable, ...]]) -> list[int | None]:
    """The cell of each entry, by what it was from rod to rod: none if that is always the same, one for equal entries."""
    cells: dict[Hashable, int] = {}

    def is_same(history: tuple[Hashable, ...]) -> bool:
        label = history[0]
        return len(set(history)) == 1 and not (isinstance(label, tuple) and tape.by_rod[label[1]])

    return [None if is_same(history) else cells.setdefault(history, len(cells)) for history in histories]


def _entries(x: Any) -> list[Any]:
    """The entries of an array, or of all arrays of a tuple."""
    return [entry for part in (x if isinstance(x, tuple) else (x,)) for entry in np.asarray(part, dtype=object).flat]


def _rebuilt(like: Any, entries: Sequence[Any]) -> Any:
    """Entries in the arrays of `like`."""
    if not isinstance(like, tuple):
        out = np.empty(np.shape(like), dtype=object)
        out.ravel()[:] = entries
        return out
    ends = np.cumsum([np.size(part) for part in like])
    parts = [_rebuilt(part, entries[end - np.size(part) : end]) for part, end in zip(like, ends, strict=True)]
    return like._make(parts) if hasattr(like, "_make") else tuple(parts)  # type: ignore[attr-defined]

"""Several runs in one drawing: the first as it is, the others as ghosts."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from pendpin.graphics.compare import distance, labels_of, rows_within
from pendpin.graphics.drawing import Drawing, Quantity
from pendpin.graphics.run_drawing import drawing_of
from pendpin.trajectory import RunRecord


def compared_drawing(runs: Sequence[RunRecord]) -> Drawing:
    """The drawing of the first run, the others in it as ghosts. Raises InputError as `drawing_of`."""
    if len(runs) == 1:
        return drawing_of(runs[0])
    first, *rest = (replace(drawing_of(run), label=label) for run, label in zip(runs, labels_of(runs), strict=True))
    others = tuple(_within(drawing, run, runs[0]) for drawing, run in zip(rest, runs[1:], strict=True))
    return replace(first, others=others, extent=max(drawing.extent for drawing in (first, *rest)))


def _within(drawing: Drawing, run: RunRecord, first: RunRecord) -> Drawing:
    """A ghost in the time of the first run, with the distance of their tips as a quantity, without what it hangs from."""
    rows = rows_within(run, first)
    cut: dict[str, Any] = {name: getattr(drawing, name)[rows] for name in ("t", "poses", "trail")}
    velocity = None if drawing.velocity is None else drawing.velocity[rows]
    quantities = tuple(quantity._replace(values=quantity.values[rows]) for quantity in drawing.quantities)
    quantities += (Quantity("distance", "m", distance(run, first)),)
    cut["shapes"] = tuple(shape for shape in drawing.shapes if shape.body != drawing.support)
    return replace(drawing, **cut, velocity=velocity, forces=None, moments=None, quantities=quantities)

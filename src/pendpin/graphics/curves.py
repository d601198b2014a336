"""What the page plots against time: every quantity of a run by name, and the plots that are offered at once."""

import numpy as np

from pendpin.graphics.drawing import Curve, Plot, Quantity
from pendpin.graphics.panels import BLACK, COLORS, joints_shown, rods_shown
from pendpin.trajectory import RunRecord
from pendpin.trajectory.columns import DRIFT, place_of, unit_of
from pendpin.trajectory.parts import Reactions

MOST_QUANTITIES = 600  # of a page; of longer chains those of the first, the middle and the last rod come first


def quantities_of(run: RunRecord) -> tuple[Quantity, ...]:
    """The quantities of a run, at most MOST_QUANTITIES, in the order of `run.names`; the energy drift last, if any."""
    names = [name for name in run.names if name != "t"]
    if len(names) > MOST_QUANTITIES:
        first = sorted(names, key=lambda name: not _is_shown(run, name))  # stable: shown ones first, else as they come
        names = sorted(first[:MOST_QUANTITIES], key=run.names.index)
    names += [DRIFT] * run.stats.conservative
    return tuple(Quantity(name, unit_of(run, name), np.asarray(run[name], float)) for name in names)


def left_out(run: RunRecord) -> tuple[str, ...]:
    """A note that a page does not offer every quantity of a long chain."""
    count = len(run.names) - 1  # without t
    if count <= MOST_QUANTITIES:
        return ()
    return (f"{MOST_QUANTITIES} of {count} quantities can be plotted here; pendpin plot and run.plot draw any",)


def _is_shown(run: RunRecord, name: str) -> bool:
    """Whether a quantity belongs to the whole run, to a joint that moves most or to a rod that is shown."""
    part, index = place_of(run, name)
    if part in "qva":
        return index[-1] in joints_shown(run)
    return part not in ("wrench", "tips", *Reactions._fields) or (
        part in Reactions._fields and index[-1] in rods_shown(run)
    )


def plots_of(run: RunRecord) -> tuple[Plot, ...]:
    """Several quantities together: energies, positions, rates, reactions; those that begin the page come first."""
    joints, least = joints_shown(run), float(run.potential.min())
    some = f", {len(joints)} of {len(run.joints)} joints" * (len(joints) < len(run.joints))
    energy = (
        Curve("kinetic", "kinetic", COLORS[1]),
        Curve("potential", "potential", COLORS[0], least),
        Curve("energy", "sum", BLACK, least),
    )
    positions = _curves([run.joints[joint] for joint in joints])
    rates = _curves([f"{run.joints[joint]}_rate" for joint in joints])
    plots = [Plot("Energy, potential above its least", energy), Plot(f"Position{some}", positions)]
    return (*plots, *_reactions(run), Plot(f"Rates{some}", rates))


def _reactions(run: RunRecord) -> list[Plot]:
    """R1, R2, R3 of a single rod; of several the tension of those that are shown; the moments where there are any."""
    if run.rod_reactions is None:
        return []
    rods, count = rods_shown(run), run.rod_reactions.R3.shape[1]
    some = f", {len(rods)} of {count} rods" * (len(rods) < count)
    if count == 1:
        return [Plot("Reactions R1, R2, R3", _curves(["R1", "R2", "R3"])), Plot("Moments", _curves(["M3", "Mc"]))]
    each = [Plot(f"Reactions of rod {i + 1}", _curves([f"R{k}_{i + 1}" for k in (1, 2, 3)])) for i in rods]
    return [
        Plot(f"Tension R3{some}", _curves([f"R3_{i + 1}" for i in rods])),
        *each,
        Plot(f"Moment Mc{some}", _curves([f"Mc_{i + 1}" for i in rods])),
    ]


def _curves(names: list[str]) -> tuple[Curve, ...]:
    return tuple(Curve(name, name, color) for name, color in zip(names, COLORS, strict=False))

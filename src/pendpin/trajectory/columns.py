"""The quantities of a run by name, one dimension each, as in the figure and the CSV."""

from typing import Any

import numpy as np

from pendpin.errors import InputError, nearest_or_all, shown
from pendpin.ground.arrays import Array
from pendpin.trajectory.parts import HingeReactions

Place = tuple[str, Any]  # the array of a run, and the index of the column in it

AXES = "xyz"
ENERGIES = ("kinetic", "potential", "energy")
UNITS = {"t": "s", "q": "rad", "v": "rad/s", "a": "rad/s²", "tips": "m"} | dict.fromkeys(("R1", "R2", "R3"), "N")
UNITS |= dict.fromkeys(("M1", "M2", "M3", "Mc"), "N m") | dict.fromkeys(ENERGIES, "J")
UNITS |= {"omega": "rad/s", "swing": "rad", "angular_momentum": "kg m²/s"}
OF_CHAINS = ("omega", "angular_momentum")  # computed from the model of a chain when the first is asked for
DRIFT = "energy_drift"  # not a column of a table: it counts from the first sample that is asked for
EFFORTS = "efforts"  # neither are they: computed when the first is asked for
WRENCH = ("Fx", "Fy", "Fz", "Mx", "My", "Mz")
NOTHING = 1e-12  # of the largest force, or of that times the model's size: a force or moment below is rounding


def columns(run: Any) -> dict[str, Place]:
    """Where each quantity of a run is, by its name, in the order of a table (docs/python.md).

    R1_1 to Mc_1 are those of rod 1, R1 of a single rod. The energy drift and the efforts are quantities, not columns;
    tip_x_2 of two rods is a second name of tip_x, and no column either. Of a chain all are relative to the support.
    """
    joints, tips = run.joints, run.tips.shape[1]
    places: dict[str, Place] = {"t": ("t", ...)}
    for name, part in (("", "q"), ("_rate", "v"), ("_acceleration", "a")):
        for j, joint in enumerate(joints):
            key = f"{joint}{name}"
            taken = key in places or key in ENERGIES
            places[f"{key} (joint)" if taken else key] = (part, (..., j))
    reactions = run.rod_reactions
    rods, names = (0, ()) if reactions is None else (reactions.R1.shape[1], reactions._fields)
    of_rods: list[tuple[str, str, Any]] = [(name, name, ()) for name in names]  # name, array, index behind the rod
    if is_chain(run):
        of_rods += [("tension", "R3", ()), *((f"omega{k + 1}", "omega", (k,)) for k in range(3))]
    absent = list[tuple[str, ...]]()  # moments that the joint of a rod cannot carry: they are 0, and no quantities
    for number in (f"_{i + 1}" * (tips > 1) for i in range(rods)):
        theta, phi = f"theta{number}" in joints, f"phi{number}" in joints
        of_hinge = ("M1", "M2") if theta and phi else ("M1", "Mc") if theta else ("M2", "Mc")
        absent.append(of_hinge if isinstance(reactions, HingeReactions) else ())
    for name, part, index in of_rods:
        for i in (i for i in range(rods) if name not in absent[i]):
            places[f"{name}_{i + 1}" if rods > 1 else name] = (part, (..., i, *index))
    if not rods:
        for j, joint in enumerate(joints):
            places |= {f"{joint}_{axis}": ("wrench", (..., j, k)) for k, axis in enumerate(WRENCH)}
    for i in (tips - 1, *range(tips - 1)):
        number = f"_{i + 1}" if i < tips - 1 else ""
        places |= {f"tip_{axis}{number}": ("tips", (..., i, k)) for k, axis in enumerate(AXES)}
    if is_chain(run):
        places["swing"] = ("swing", ...)
        places |= {f"angular_momentum_{axis}": ("angular_momentum", (..., k)) for k, axis in enumerate(AXES)}
    places |= {f"work_{kind}": (kind, ...) for kind in run.work}
    return places | {name: (name, ...) for name in ENERGIES}


def is_chain(run: Any) -> bool:
    """Whether a run is of a chain of rods, whose model its scene holds."""
    return run.rod_reactions is not None and (run.scene.get("model") or {}).get("kind") == "chain"


def swing(run: Any) -> Array:
    """The angle (n,) rad of the line from the support to the last tip from straight down: that of a load on a rope."""
    x, y, z = run.tips[:, -1].T
    return np.arctan2(np.hypot(x, y), -z)


def unit_of(run: Any, name: str) -> str:
    """The unit of a quantity, "" of the energy drift; that of a joint is not known where the run's URDF is gone."""
    if str(name) == DRIFT:
        return ""
    part, index = place_of(run, name)
    if part == "wrench":
        return "N" if index[-1] < 3 else "N m"
    if part == EFFORTS:
        return "N" if run.joints[index[-1]] in run.slides else "N m"
    unit = UNITS.get(part, "J")  # of works
    if part not in "qva":
        return unit
    slide = unit.replace("rad", "m")
    return f"{unit} or {slide}" if run.slides is None else slide if run.joints[index[-1]] in run.slides else unit


def place_of(run: Any, name: str) -> Place:
    """Where a quantity of a run is, by its name. Raises InputError that says which name was probably meant."""
    if not isinstance(name, str):
        raise InputError(f"{shown(name)} is not the name of a quantity; to_pandas(*names) makes a table of several")
    places = run.places
    if name.startswith("effort_") and name not in places:  # of each kind of effect and joint; none of a record
        kinds = getattr(run, "computed_efforts", ())
        places = {f"effort_{k}_{joint}": (EFFORTS, (k, j)) for k in kinds for j, joint in enumerate(run.joints)}
    tips = run.tips.shape[1]
    if name not in places and (tips == 1 or name.startswith("tip_")):
        unnumbered = name.removesuffix(f"_{tips}")  # tip_x_2 of two rods is tip_x, theta_1 of a single rod theta
        name = unnumbered if unnumbered in places else name
    if name not in places:
        without_works = name.startswith("work_") and not run.work
        remedy = "; energy_balance=True (--energy-balance) adds the works"
        hint = remedy if without_works else nearest_or_all(name, tuple(places))
        raise InputError(f"{shown(name)} is not a quantity of this run{hint}")
    return places[name]


def column(run: Any, name: Any) -> Array:
    """One quantity of a run by its name, (n,); energy_drift and effort_ of each kind of effect and joint too. InputError."""
    if str(name) == DRIFT:
        if not run.stats.conservative:
            why = "an effect of this run has no potential; work_ of each effect explains its energy"
            raise InputError(f"energy_drift: {why}")
        energy = run.energy()
        return (energy.total - energy.total[:1]) / energy.exchanged[-1:]
    part, index = place_of(run, name)
    if part == "energy":
        return run.kinetic + run.potential
    if part == EFFORTS:
        kind, joint = index
        return run.computed_efforts[kind][:, joint]
    if part in run.work:
        return run.work[part]
    if part == "swing":
        return swing(run)
    if part in OF_CHAINS and not hasattr(type(run), part):
        raise InputError(f"{name}: a record alone has none; Trajectory.of(record) computes it")
    array = getattr(run.rod_reactions, part) if part in HingeReactions._fields else getattr(run, part)
    return np.asarray(array[index])


TABLES = (".csv", ".txt")

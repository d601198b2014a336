"""What free swings tell where they do not tell the numbers themselves: ratios to the first moment of the last rod.

A swing under gravity shows no scale of mass: with all inertias, first moments and frictions multiplied by one number the
motion stays the same.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from pendpin.fitting.parameters import Free, replace_unchecked, substitute
from pendpin.fitting.uncertainty import Certainty
from pendpin.ground.arrays import Array
from pendpin.scene import Chain, Scene


class Combination(NamedTuple):
    """A determined function of free numbers that are not determined themselves."""

    name: str
    value: float
    error: float | None  # standard error; None where the fit gives none
    unit: str

    def __str__(self) -> str:
        error = "" if self.error is None else f" +- {self.error:.2g}"
        return f"{self.name} = {self.value:.6g}{error} {self.unit}".rstrip()


def combinations(scene: Scene, free: Free, z: Array, certainty: Certainty, unsure: set[str]) -> tuple[Combination, ...]:
    """The ratios of a chain that the data determine, of those that hold an undetermined number; z (nz,).

    They have errors if the data are long enough.
    """
    if not isinstance(scene.model, Chain) or not unsure:
        return ()
    determined = []
    for name, unit, function in _ratios(scene, free, unsure):
        values = free.values(z)
        gradient = np.zeros(len(certainty.scale))
        gradient[: len(z)] = _gradient(function, values) @ free.gradients(z)
        if certainty.determined(gradient):
            error = certainty.error(gradient) if certainty.enough else None
            determined.append(Combination(name, float(function(values)), error, unit))
    return tuple(determined)


def _ratios(scene: Scene, free: Free, unsure: set[str]) -> list[tuple[str, str, Callable[[Array], float]]]:
    """Name, unit and function of the K free numbers (K,), of each ratio that holds an undetermined number."""
    moments = lambda values: _moments(substitute(scene, free.keys, list(values), replace_unchecked))  # noqa: E731
    assert isinstance(scene.model, Chain)
    last = scene.model.count - 1
    ratios: list[tuple[str, str, Callable[[Array], float]]] = []
    for i in range(last + 1):
        of = f"rod {i + 1}" + " with all below" * (i < last)
        about, first = f"inertia of {of} about its joint", f"first moment of {of}"
        ratios.append((f"{about} / {first}", "m", lambda v, i=i: moments(v)[0][i] / moments(v)[1][i]))
        if i < last:
            ratio = f"{first} / first moment of rod {last + 1}"
            ratios.append((ratio, "", lambda v, i=i: moments(v)[1][i] / moments(v)[1][last]))
    for row, key in enumerate(free.keys):
        if key.startswith("effects") and key in unsure:
            name = f"{key} / first moment of rod {last + 1}"
            ratios.append((name, "", lambda v, row=row: v[row] / moments(v)[1][last]))
    return ratios


def _moments(scene: Scene) -> tuple[Array, Array]:
    """Each rod's inertia about its joint (kg m²) and first moment (kg m), with the masses that hang on its tip."""
    assert isinstance(scene.model, Chain)
    rods = scene.model.all_rods
    below, inertia, first = 0.0, [], []
    for rod in reversed(rods):
        m, h, I1, _, _ = rod.properties
        inertia.append(I1 + m * h * h + below * rod.length**2)
        first.append(m * h + below * rod.length)
        below += m
    return np.array(inertia[::-1]), np.array(first[::-1])


def _gradient(function: Callable[[Array], float], values: Array) -> Array:
    """Central differences (K,)."""
    steps = 1e-6 * np.where(values != 0, np.abs(values), 1.0)
    return np.array([(function(values + d) - function(values - d)) / (2 * d.sum()) for d in np.diag(steps)])

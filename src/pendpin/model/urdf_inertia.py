"""The inertia of a URDF's links: numbers that are broken are refused, numbers that no real body has are findings."""

from collections.abc import Iterator

import numpy as np

from pendpin.errors import InputError, shown
from pendpin.ground.arrays import Array
from pendpin.model.bodies import LEAST_MASS, mass_unit
from pendpin.model.urdf_xml import Element, needed, number

_ROUNDING = 1e-3  # of the sum of all three: what numbers written with four digits may miss in the triangle inequality
_NEGATIVE = 1e-9  # of the largest: what rounding may leave below zero
_MOMENTS = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
_AS_WRITTEN = "no real body has this inertia; accelerations are computed as written"


def check_inertial(where: str, inertial: Element) -> None:
    """Raise InputError where <inertial> lacks a number, has one that is none, or a negative mass."""
    mass = number(where, needed(where, inertial, "mass"), "value")
    if mass < 0:
        raise InputError(f"{where}: mass {mass:g} kg is negative")
    if 0 < mass < LEAST_MASS:
        raise InputError(
            f"{where}: mass {mass:g} kg is too small to compute with; the least is {LEAST_MASS:g} kg, or 0"
        )
    _tensor(inertial, where)


def inertia_findings(links: dict[str, Element]) -> Iterator[str]:
    """What is implausible in the inertia of links that passed the check: link, numbers, and what follows."""
    for name, link in links.items():
        inertial = link.find("inertial")
        reason = None if inertial is None else _implausible(inertial)
        if reason:
            yield f"link {shown(name)}: {reason}: {_AS_WRITTEN}"


def _implausible(inertial: Element) -> str | None:
    tensor, mass = _tensor(inertial), float(needed("", inertial, "mass").get("value", ""))
    size = np.abs(tensor).max() or 1.0
    small, middle, large = np.linalg.eigvalsh(tensor / size)
    slack = _ROUNDING * (abs(small) + abs(middle) + abs(large))
    a, b, c = (f"{value * size:.6g}" for value in (small, middle, large))
    values = f"principal inertia {a}, {b} and {c} kg m²"
    if mass == 0 and tensor.any():
        return f"{values} with a mass of 0"
    if small < -_NEGATIVE:
        return f"{values}, {a} is negative"
    if large > small + middle + slack:
        return f"{values}, {c} > {a} + {b}"
    return None


def use_mass_unit(links: dict[str, Element]) -> float:
    """Write masses and inertias in a unit in which Pinocchio adds them up; returns the unit in kg."""
    inertials = [link.find("inertial") for link in links.values()]
    parts = [needed("", inertial, tag) for inertial in inertials if inertial is not None for tag in ("mass", "inertia")]
    moments = [abs(float(part.get(key, "0"))) for part in parts[1::2] for key in _MOMENTS]
    unit = mass_unit([float(mass.get("value", "")) for mass in parts[::2]], moments)
    for part in parts if unit != 1.0 else ():
        for key in ("value", *_MOMENTS):
            if key in part.attrib:
                part.set(key, repr(float(part.attrib[key]) / unit))
    return unit


def _tensor(inertial: Element, where: str = "") -> Array:
    """The central inertia (3, 3) kg m², in the axes of <origin>."""
    values = needed(where, inertial, "inertia")
    xx, xy, xz, yy, yz, zz = (number(where, values, key) for key in _MOMENTS)
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])

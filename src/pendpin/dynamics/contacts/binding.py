"""Contacts: those of the joints from the dry friction and the stops of a scene."""

from collections.abc import Sequence

import numpy as np

from pendpin.dynamics.binding.acting import chosen_joints, in_order
from pendpin.dynamics.contacts.contacts import Contacts
from pendpin.effects import ContactEffect, DryFriction, Effect
from pendpin.engines import AngleEngine
from pendpin.errors import InputError, shown
from pendpin.ground.arrays import Array
from pendpin.model.build import Model
from pendpin.model.kinematics import scale


def bind_contacts(model: Model, effects: Sequence[Effect], engine: AngleEngine) -> Contacts:
    """The contacts of a scene, joint by joint.

    Friction adds up. Of several limits on one side of a joint the tighter holds, with its own restitution; of equal ones
    that with the smaller restitution. Raises InputError for joints that are unknown or named twice, and for stops that
    leave a joint no room.
    """
    nv = len(model.joints)
    acts = [(effect, where) for effect, where in in_order(effects) if isinstance(effect, ContactEffect)]
    none = np.zeros(nv, np.result_type(float, *(x for effect, _ in acts for x in effect.resistance())))  # varied.py
    kinetic, static, falling = dict[str, Array](), none.copy(), []
    reach, restitution = np.full((2, nv), np.inf), np.zeros((2, nv))  # reach: minus the lower limit, and the upper one
    kinds, places = np.full((2, nv), "", dtype=object), np.full((2, nv), "", dtype=object)
    for effect, where in acts:
        joints = chosen_joints(model, effect.joints, f"{where}.joints")
        slide, hold = effect.resistance()
        static[joints] += hold
        if isinstance(effect, DryFriction) and effect.stribeck is not None:
            falling.append((np.isin(np.arange(nv), joints).astype(float), effect))
        if isinstance(effect, DryFriction):
            kinetic.setdefault(effect.kind, none.copy())[joints] += slide
        low, high, back = effect.limits()
        for side, limit in enumerate((-low, high)):
            tighter = (limit < reach[side]) | ((limit == reach[side]) & (back < restitution[side]))
            at = np.intersect1d(joints, np.flatnonzero(tighter))
            reach[side, at], restitution[side, at], kinds[side, at], places[side, at] = limit, back, effect.kind, where
    lower, upper = -reach[0], reach[1]
    _refuse_no_room(model, lower, upper, places)
    total = sum(kinetic.values(), none)
    limits = (lower, upper, restitution)
    lengths = np.where(model.slides, scale(model), 1.0)
    return Contacts(engine, lengths, total, static, *limits, tuple(kinetic.items()), kinds, tuple(falling))


def _refuse_no_room(model: Model, lower: Array, upper: Array, places: Array) -> None:
    """Raise InputError where lower >= upper (nv,); places (2, nv) names the effects that set the limits."""
    for joint in np.flatnonzero(lower >= upper):
        below, above = places[:, joint]
        raise InputError(
            f"{below} and {above}: their stops leave joint {shown(model.joints[joint])} no room: "
            f"one keeps it above {lower[joint]:g}, the other below {upper[joint]:g}"
        )


def check_start(contacts: Contacts, model: Model, q: Array) -> None:
    """Raise InputError if positions q (nv,) are beyond a stop."""
    for name, x, low, high in zip(model.joints, q, contacts.lower, contacts.upper, strict=True):
        if not low <= x <= high:
            raise InputError(f"start.positions.{name}: {x:g} is beyond its stop at {low if x < low else high:g}")

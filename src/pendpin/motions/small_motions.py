"""The rest of a scene and the small motions about it; whether a rest, or a driven periodic motion, is stable."""

from typing import NamedTuple

import numpy as np

from pendpin.dynamics.acting import expand_as_written
from pendpin.dynamics.derivatives import Variational, refuse_poles
from pendpin.dynamics.vibrations import Matrices, Vibrations, is_stable, matrices, spectrum, vibrations
from pendpin.effects import ContactEffect
from pendpin.ground.arrays import Array
from pendpin.model.build import build, start_state
from pendpin.motions.periodic import drive_of, periodic_orbit
from pendpin.motions.special_starts import at_rest
from pendpin.scene import Scene, Start

REST = 1e-9  # of the accelerations that a turn by 1 rad causes: a start with less is a rest


class SmallMotions(NamedTuple):
    """The small motions of a scene about its rest."""

    scene: Scene  # which starts at the rest
    q: Array  # (nv,) rad, the rest
    matrices: Matrices
    vibrations: Vibrations


def rest_of(scene: Scene) -> Start:
    """The stable rest of a scene near its start; friction and stops are left out. Raises InputError if there is none."""
    acts = expand_as_written(build(scene.model), scene.effects)
    free = tuple(effect for effect in acts if not isinstance(effect, ContactEffect))
    return at_rest(scene.model_copy(update={"effects": free}))


def small_motions(scene: Scene) -> SmallMotions:
    """The small motions about the rest near the scene's start, with the effects as they are at the start's time.

    Raises InputError where there is no rest, and for effects without derivatives; MissingLibrary without llvmlite.
    """
    rest = rest_of(scene)
    still, (q, v) = scene.model_copy(update={"start": rest}), start_state(build(scene.model), rest)
    refuse_poles(build(scene.model), q)
    linear = matrices(still, q, v, np.zeros(len(q)))
    return SmallMotions(still, q, linear, vibrations(linear))


def largest_multiplier(scene: Scene) -> float:
    """The size of the largest multiplier of the periodic motion near the scene's start; above 1 it is unstable.

    Raises InputError for a scene without one drive, RunError where no periodic motion is found.
    """
    return float(np.abs(periodic_orbit(scene).multipliers).max())


def stable(scene: Scene) -> bool:
    """Whether a driven scene's periodic motion near its start is stable; without a drive, its start if that is a rest.

    A start that is not a rest stands for the rest near it.
    """
    if drive_of(scene) is not None:
        return periodic_orbit(scene).stable
    equations = Variational(scene)
    q, v = start_state(equations.model, scene.start)
    refuse_poles(equations.model, q)
    jacobian = equations.jacobian(0.0, q, v)
    if v.any() or np.abs(jacobian.acceleration).max() > REST * max(1.0, np.abs(jacobian.of_q).max()):
        return small_motions(scene).vibrations.stable
    A = np.block([[np.zeros_like(jacobian.of_q), np.eye(len(q))], [jacobian.of_q, jacobian.of_v]])
    return is_stable(*spectrum(A)[:2])

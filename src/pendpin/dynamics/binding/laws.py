"""The law of one effect, as a function of the time since the start of the run."""

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from pendpin.dynamics.parameters import GIVEN, Numbers
from pendpin.effects import Bodies, Drag, Effect, Motion, Motor, Push, Support
from pendpin.effects.base import returned
from pendpin.errors import InputError, PendpinError, shown

WRENCH = "a force", "a moment"
LATEST = 340  # digits: more than a time times a frequency can have before its point


def law(effect: Effect, name: str, xp: Any = np, numbers: Numbers = GIVEN) -> Callable[..., Any]:
    """A method of an effect, by its name. That of a user's own class gets copies, and what it returns is checked."""
    method = partial(getattr(numbers.effect(effect), name), xp=xp)
    if type(effect).__module__.startswith("pendpin."):
        return method
    what, kind = f"effects: {effect.kind}: its {name}", float if xp is np else object

    def checked(t: Any, *state: Any) -> Any:
        output = method(t, *map(_copy, state))
        if name != "wrench":
            return returned(what, output, state[0].shape if state else (3,), kind)
        if not isinstance(output, tuple | list) or len(output) != len(WRENCH):
            raise InputError(f"{what} returned {shown(output)}, where {' and '.join(WRENCH)} are wanted")
        return tuple(returned(what, part, state[0].com.shape, kind) for part in output)

    return checked


def _copy(part: Any) -> Any:
    """A copy of an array, or of each array in bodies or a motion: a law that works in place changes no state."""
    if isinstance(part, Bodies | Motion):
        return part._make(map(_copy, part))
    return part.copy() if isinstance(part, np.ndarray) else part


def since(start: float, effect: Effect, function: Any, numbers: Numbers = GIVEN) -> Any:
    """A function of time of one effect, as a function of the time since `start` in s: late times then lose no digits."""
    if not start:
        return function
    early = numbers(_reduce_to_first_period(start, effect))
    return lambda t, *state: function(early + t, *state)


def _reduce_to_first_period(start: float, effect: Effect) -> Any:
    """The time at which a sinusoid first has the phase that it has at `start`, in s; for other effects `start`."""
    if not start or not isinstance(effect, Drag | Motor | Push | Support) or effect.frequency is None:
        return start
    from mpmath import mp, mpf

    frequency = np.real(effect.frequency)  # complex where derivatives by it are wanted (varied.py)
    with mp.workdps(LATEST):
        early = float(mp.fmod(mpf(start) * mpf(frequency), 2 * mp.pi) / frequency)
    if isinstance(effect.frequency, complex):  # frequency early changes with the frequency like frequency start
        return early + (start - early) / frequency * (effect.frequency - frequency)
    return early


def readable(effect: Effect, where: str, xp: Any, function: Any) -> Any:
    """A function of an effect; what it does not do on numbers other than NumPy's floats is said in one line."""
    if xp is np:
        return function

    def named(*state: Any) -> Any:
        try:
            return function(*state)
        except PendpinError:
            raise
        except Exception as error:
            raise InputError(
                f"{where}: {effect.kind} does not run on symbols ({error}): write it with + - * / ** and the functions "
                "of xp, or let its property `smooth` be False"
            ) from None

    return named

"""What an estimated error assumes of a user's own effects, which nobody can see from outside: notes that name them.

A step may jump over a force that acts within a milliradian; runs that all do so agree. Notes say which effects do not
declare that they are smooth, and where along the run one was seen not to be.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from pendpin.dynamics.dynamics import Dynamics
from pendpin.dynamics.timing import action, declared_smooth, timing, users_own
from pendpin.effects import Effect, Torque
from pendpin.effects.pace import BLOCK, Pace, measure_pace, remove_jumps
from pendpin.ground.arrays import Array
from pendpin.scene import Scene
from pendpin.trajectory import RunRecord

FINEST = 2.5e-4  # rad and m: two points of the probe are at most so far apart
FEWEST, MOST = 4096, 16384  # points along a run
STEP = 0.25  # of the time between two jumps: a step that cannot jump over both
VISIBLE = 1e-3  # of an effect's largest value: above what interpolation between samples does to it
SHORT = 0.1  # of the run's mean step: a change so short may lie between the evaluations of all steps
SHORT_STEPS = 1e6  # at most, of a run that sees what longer steps may jump over: about a minute in Python
APART = 4.0  # times: changes with time that are known are not what the probe looks for, if they are about as short


class Rough(NamedTuple):
    """Where along a run an effect changes abruptly with positions or rates, and how briefly."""

    name: str
    t: float  # s
    shortest: (
        float  # s, the longest step that cannot jump over it; inf where it cannot be measured, as of a single jump
    )


def describe_assumptions(scene: Scene, rough: Sequence[Rough]) -> tuple[str, ...]:
    """Notes on the user's own effects of a scene, with what was seen of them along its run."""
    users = [(i, effect) for i, effect in enumerate(scene.effects) if users_own(effect) and not effect.idle]
    notes = [note for i, effect in users for note in _note_declaration(f"effects[{i}] ({effect.kind})", effect)]
    notes += [
        f"{one.name} changes abruptly with position or rate near t = {one.t:.6g} s: the estimated error may be too "
        "small; compare with a run whose steps are much shorter than the change"
        for one in rough
    ]
    return tuple(notes)


def probe_effects(dynamics: Dynamics, duration: float, run: RunRecord) -> list[Rough]:
    """Where the user's own effects change abruptly along a run; none after impacts, where all signals jump."""
    places = [i for i, effect in enumerate(dynamics.effects) if users_own(effect)]
    if not places or len(run.t) < 2 or dynamics.contacts:
        return []
    pace = timing(dynamics, dynamics.effects, run.q[0], run.v[0], duration, None).pace
    roughest = [_roughest(dynamics, i, run, pace) for i in places]
    return [one for one in roughest if one is not None]


def _note_declaration(name: str, effect: Effect) -> list[str]:
    """A note on an effect that does not declare that it is smooth, or that it is not."""
    smooth = declared_smooth(effect)
    if smooth:
        return []
    if smooth is None:
        declaration = "gradual" if isinstance(effect, Torque) else "smooth"
        return [
            f"{name} does not declare that it is smooth in positions and rates: the estimated error assumes it, and what "
            f"acts within a short step may be missed; if it is, declare `{declaration}`"
        ]
    return [f"{name} is not smooth: the estimated error assumes that no step jumps over what it does"]


def _roughest(dynamics: Dynamics, i: int, run: RunRecord, pace: Pace) -> Rough | None:
    """The first time of the run at which an effect changes abruptly with the state; None if the probe sees no such place.

    Changes that the pace in time declares or has found, in s since the start, do not count.
    """
    from scipy.interpolate import CubicHermiteSpline  # late: it takes 0.3 s

    since = run.t - run.t[0]
    q, v = CubicHermiteSpline(since, run.q, run.v), CubicHermiteSpline(since, run.v, run.a)

    def values(t: float) -> Array:
        return np.nan_to_num(action(dynamics, dynamics.effects, i, q(t), v(t))(t))

    path = float(np.abs(run.v).max()) * float(since[-1])
    blocks = int(np.clip(path / FINEST, FEWEST, MOST) - 1) // BLOCK
    t = np.linspace(0.0, since[-1], (BLOCK << blocks.bit_length()) + 1)
    places, others = remove_jumps(values, t, np.array([values(float(time)) for time in t]), VISIBLE)
    rough, group = measure_pace(t, others, VISIBLE), 4 * t[1]
    short = max(group, SHORT * since[-1] / max(run.stats.steps, 1))
    ends, brief = np.append(rough.corners, since[-1]), rough.shortest <= short
    jumps, narrow = (
        [place for place in some if not _is_of_time(pace, float(place), group)] for some in (places, ends[brief])
    )
    if not jumps and not narrow:
        return None
    steps = [*(STEP * np.diff(jumps)), *(rough.shortest[brief] if narrow else ())]
    first = float(run.t[0]) + min(*jumps, *narrow, np.inf)
    return Rough(f"effects[{i}] ({dynamics.effects[i].kind})", first, float(min(steps, default=np.inf)))


def _is_of_time(pace: Pace, place: float, group: float) -> bool:
    """Whether a change at a place in s is one with time, that the pace has."""
    near = np.array([place - group, place, place + group])
    return bool((pace.at(near) < APART * group).any() or (np.abs(pace.corners - place) <= group).any())

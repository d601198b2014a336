"""What each part of a model is worth: fits without each effect that brakes, and with parts that the scene lacks."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from pendpin.effects import Drag, DryFriction, Gravity, Viscous
from pendpin.effects.base import JointNames
from pendpin.errors import InputError
from pendpin.fitting.fitting import Setting, Solution, count_outliers_less, with_scene
from pendpin.fitting.parameters import substitute
from pendpin.fitting.prediction import predict
from pendpin.fitting.problem import search, solve_starts
from pendpin.fitting.report import Fit
from pendpin.fitting.uncertainty import CORNER, correlation_time, huber_scale
from pendpin.ground.arrays import Array
from pendpin.scene import Chain, Scene

MOST = 24  # steps of a search, from the fitted numbers
CALLED_FOR = 6.0  # of the criterion: strong evidence (R. Kass, A. Raftery, J. Am. Stat. Assoc. 90 (1995), 773)
AGAINST = 1.01  # times the held-out error without a part: it does not help
SMALL = 1e-5  # of the largest torque of gravity: first guess of a friction, so that a search begins near the fit
SLOW = 5.0  # rad/s: first guess of a Stribeck speed
SLENDER = 20.0  # length over diameter: first guess of a rod in the air
_Other = tuple[str, bool, Scene, Sequence[str]]  # name, whether it is there, the scene without or with it, what is free


@dataclass(frozen=True)
class Part:
    """A part of a model, and what leaving it out or taking it in changes."""

    name: str
    present: bool  # in the scene: the changes are those of leaving it out
    rms: float  # of the residuals over those of the fit
    criterion: float  # change of the Bayesian information criterion for having the part; negative is better
    hold_out: float | None  # change of the held-out rms, over that of the fit

    @property
    def needed(self) -> bool:
        """Whether the data need it, and held-out swings, if there are any, do not speak against it."""
        change = self.hold_out or 1.0
        worse = 1 / change if self.present else change
        return self.criterion < -CALLED_FOR and worse < AGAINST

    def __str__(self) -> str:
        what = "without" if self.present else "with"
        hold_out = "" if self.hold_out is None else f", held out {self.hold_out:.3f}"
        changes = f"residuals {what} it: {self.rms:.3f} times{hold_out}; criterion {self.criterion:+.0f}"
        return f"{self.name}: {'needed' if self.needed else 'not needed'} ({changes})"


class _Model(NamedTuple):
    """A scene with fitted numbers."""

    setting: Setting
    solution: Solution
    scene: Scene  # with the fitted numbers in it
    keys: Sequence[str]  # of the free numbers


def explain_residual(fit: Fit, progress: Callable[[str], None] = lambda what: None) -> Fit:
    """The fit with what each part of its model is worth, and what parts that it lacks would be."""
    # Of the parts that it lacks, the best one that is needed is taken in before the others are compared again, so that
    # none is needed only because it resembles another. The parts that it has are compared beside those taken in: a
    # friction that stood in for drag, or was hidden by it, is seen only then.

    def compare(others: Iterable[_Other]) -> list[tuple[Part, _Model]]:  # each fitted from the model that there is
        compared = []
        for name, present, scene, keys in others:
            progress(f"{'without' if present else 'with'} {name}")
            with suppress(InputError):  # the scene without this part does not fit together
                other = _refit(fit, now.solution, scene, keys)
                compared.append((_compare(name, present, fit, now, other), other))
        return compared

    first, taken = _Model(fit.setting, fit.solution, fit.scene, fit.setting.pendulum.free.keys), list[Part]()
    omitted = {name for name, *_ in _omissions(first)}
    progress("the fit as it is")
    now = _refit(fit, first.solution, first.scene, first.keys)
    while True:
        others = sorted(compare(_additions(now)), key=lambda other: other[0].criterion)
        part, best = next((other for other in others if other[0].needed), (None, now))
        if part is None:
            break
        taken.append(part)
        now = _refit(fit, best.solution, best.scene, best.keys)
    present = (other for other in _omissions(now) if other[0] in omitted)
    parts = [*taken, *(part for part, _ in [*others, *compare(present)])]
    return replace(fit, parts=tuple(sorted(parts, key=lambda part: part.criterion)))


def _refit(fit: Fit, near: Solution, scene: Scene, keys: Sequence[str]) -> _Model:
    """A search over whole swings from the numbers of a scene and the starts of a solution, with the weights of the fit."""
    of_fit = fit.solution
    counted = count_outliers_less(fit.setting, of_fit.problem, of_fit.x, of_fit.solved.starts)
    setting, problem = with_scene(fit.setting, counted, scene, keys)
    free = setting.pendulum.free
    x = np.concatenate([free.start, near.offsets[: len(problem.prior) - len(free.start)]])
    x, solved, _ = search(problem, x, near.solved.starts, MOST)
    solution = Solution(problem, x, *problem.split(x), solved, of_fit.certainty)
    return _Model(setting, solution, substitute(scene, free.keys, free.values(solution.z)), keys)


def _compare(name: str, present: bool, fit: Fit, now: _Model, other: _Model) -> Part:
    """The part's worth, from fits with and without it."""
    residuals = list[Array]()  # (P, M columns, 1) that no start explains
    for model in (now, other):
        solution = model.solution
        if model.setting.robust:  # cut off as their scale is computed
            off = solve_starts(replace(solution.problem, share=1.0), solution.x, solution.solved.starts, 0).r
            most = CORNER * huber_scale(off, off != 0, None)
            residuals.append(np.clip(off, -most, most)[..., None])
        else:
            residuals.append(solution.solved.unexplained)
    r, other_r = residuals
    rss, other_rss = float((r**2).sum()), float((other_r**2).sum())
    samples = max((r != 0).sum() / (2 * correlation_time(r)), 10.0)
    more = other.solution.problem.nz - now.solution.problem.nz
    change = samples * np.log(other_rss / rss) + more * np.log(samples)
    hold_out = None
    if fit.hold_out:
        part = float(np.mean(~np.concatenate(fit.hold_out.compared)))
        errors = [predict(*model[:2], fit.hold_out.swings, part, interval=False).errors() for model in (now, other)]
        hold_out = float(np.sqrt(np.nanmean(errors[1] ** 2) / np.nanmean(errors[0] ** 2)))
    return Part(name, present, float(np.sqrt(other_rss / rss)), float(-change if present else change), hold_out)


def _omissions(now: _Model) -> Iterator[_Other]:
    scene, keys = now.scene, now.keys
    for i, effect in enumerate(scene.effects):
        here, where = f"effects[{i}]", f"effects[{i}], {effect.kind}"
        rest = [key for key in keys if not key.startswith(f"{here}.")]
        zeros: dict[str, Any] = {f"{here}.{name}": 0.0 for name in effect.resistances}
        if isinstance(effect, DryFriction):
            zeros |= {f"{here}.static": None, f"{here}.stribeck": None}
        if any(getattr(effect, name) or f"{here}.{name}" in keys for name in effect.resistances):
            with suppress(InputError):  # a number of a user's own effect that cannot be 0
                without = scene.replace(zeros)
                if not without.effects[i].idle:  # it does more than to brake, and that stays
                    where, rest = f"{where}: {', '.join(effect.resistances)}", [key for key in keys if key not in zeros]
                yield where, True, without, rest
        if isinstance(effect, DryFriction) and effect.stribeck is not None:
            plain = DryFriction(kinetic=effect.static or effect.kinetic, joints=effect.joints)
            kinetic = [key for key in keys if key == f"{here}.kinetic"]
            yield f"{where}: stribeck", True, scene.replace({here: plain}), [*rest, *kinetic]


def _additions(now: _Model) -> Iterator[_Other]:
    scene, keys = now.scene, now.keys
    kinds, many, model = {effect.kind for effect in scene.effects}, len(scene.effects), scene.model
    weights = [9.81 * rod.properties.m * rod.length for rod in model.all_rods] if isinstance(model, Chain) else [1.0]
    size = SMALL * sum(weights)
    length = min(rod.length for rod in model.rods) if isinstance(model, Chain) else 1.0
    drag = Drag(diameter=length / SLENDER, coefficient=0.01)
    for effect in (Viscous(coefficient=size / SLOW), DryFriction(kinetic=size), drag):  # of others no guess is known
        if effect.kind not in kinds:
            more = [f"effects[{many}].{name}" for name in effect.resistances]
            yield effect.kind, False, scene.replace(effects=(*scene.effects, effect)), [*keys, *more]
    for i, effect in enumerate(scene.effects):
        if isinstance(effect, DryFriction) and effect.stribeck is None:
            low, high = 0.98 * effect.kinetic, 1.02 * effect.kinetic + size
            falling = DryFriction(kinetic=low, static=high, stribeck=SLOW, joints=effect.joints)
            more = [f"effects[{i}].{name}" for name in ("kinetic", "static", "stribeck")]
            rest = [key for key in keys if key not in more]
            changed = scene.replace({f"effects[{i}]": falling})
            yield f"effects[{i}], dry_friction: stribeck", False, changed, [*rest, *more]
        if isinstance(effect, Gravity) and not any(key.startswith(f"effects[{i}].direction") for key in keys):
            yield "tilt of gravity", False, scene, [*keys, f"effects[{i}].direction[1]"]
    bearing = scene.model.bearing if isinstance(scene.model, Chain) else ()
    lengths = (f"model.rods[{i}].length" for i in bearing)
    if missing := [key for key in lengths if key not in keys]:
        yield "other lengths of rods", False, scene, [*keys, *missing]

    pendulum = now.setting.pendulum  # a friction for each of the joints that move, in place of one for several
    moving = [pendulum.model.joints[joint] for joint in pendulum.moving]
    for i, effect in enumerate(scene.effects):
        if not (isinstance(effect, JointNames) and effect.resistances):
            continue
        first, *rest = [name for name in moving if effect.joints is None or name in effect.joints] or [None]
        names = [key.rpartition(".")[2] for key in keys if key.startswith(f"effects[{i}].")]
        if rest and names:
            more = [f"effects[{many + k}].{name}" for k in range(len(rest)) for name in names]
            where = f"effects[{i}], {effect.kind}: one for each joint"
            one, *others = (type(effect)(**effect.given() | {"joints": (name,)}) for name in (first, *rest))
            effects = (*scene.effects[:i], one, *scene.effects[i + 1 :], *others)
            yield where, False, scene.replace(effects=effects), [*keys, *more]

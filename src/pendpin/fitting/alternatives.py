"""What each part of a model is worth: fits without each friction and drag, and with parts that the scene lacks."""

from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from pendpin.effects import Drag, DryFriction, Gravity, Viscous
from pendpin.errors import InputError
from pendpin.fitting.fitting import Setting, Solution, with_scene
from pendpin.fitting.parameters import replace_checked, substitute
from pendpin.fitting.prediction import predict
from pendpin.fitting.problem import search
from pendpin.fitting.report import Fit
from pendpin.fitting.uncertainty import correlation_time
from pendpin.scene import Chain, Scene

MOST = 24  # steps of a search, from the fitted numbers
CALLED_FOR = 6.0  # of the criterion: strong evidence (R. Kass, A. Raftery, J. Am. Stat. Assoc. 90 (1995), 773)
AGAINST = 1.01  # times the held-out error without a part: it does not help
SMALL = 1e-5  # of the largest torque of gravity: first guess of a friction, so that a search begins near the fit
SLOW = 5.0  # rad/s: first guess of a Stribeck speed
SLENDER = 20.0  # length over diameter: first guess of a rod in the air
_Other = tuple[str, bool, Scene, list[str]]  # name, whether it is there, the scene without or with it, what is free


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

    omitted, taken = {other[0] for other in _omissions(fit.scene, [*fit.setting.pendulum.free.keys])}, []
    progress("the fit as it is")
    now = _refit(fit, fit.solution, fit.scene, [*fit.setting.pendulum.free.keys])
    while True:
        others = sorted(compare(_additions(now)), key=lambda other: other[0].criterion)
        best = next((other for other in others if other[0].needed), None)
        if best is None:
            break
        taken.append(best[0])
        now = _refit(fit, best[1].solution, best[1].scene, [*best[1].setting.pendulum.free.keys])
    present = (other for other in _omissions(now.scene, [*now.setting.pendulum.free.keys]) if other[0] in omitted)
    parts = [*taken, *(part for part, _ in [*others, *compare(present)])]
    return replace(fit, parts=tuple(sorted(parts, key=lambda part: part.criterion)))


def _refit(fit: Fit, near: Solution, scene: Scene, keys: list[str]) -> _Model:
    """A search over whole swings from the numbers of a scene and the starts of a solution, with the weights of the fit."""
    setting, problem = with_scene(fit.setting, fit.solution.problem, scene, keys)
    x = np.concatenate(
        [setting.pendulum.free.start, near.offsets[: len(problem.prior) - len(setting.pendulum.free.start)]]
    )
    x, solved, _ = search(problem, x, near.solved.starts, MOST)
    solution, free = Solution(problem, x, *problem.split(x), solved, fit.solution.certainty), setting.pendulum.free
    fitted = substitute(scene, free.keys, free.values(solution.z).tolist(), replace_checked)
    return _Model(setting, solution, fitted)


def _compare(name: str, present: bool, fit: Fit, now: _Model, other: _Model) -> Part:
    """The part's worth, from fits with and without it."""
    rss, other_rss = (float((model.solution.solved.unexplained**2).sum()) for model in (now, other))
    r = now.solution.solved.r
    samples = max((r != 0).sum() / (2 * correlation_time(r[:, :, None])), 10.0)
    more = other.solution.problem.nz - now.solution.problem.nz
    change = samples * np.log(other_rss / rss) + more * np.log(samples)
    hold_out = None
    if fit.hold_out:
        part = float(np.mean(~np.concatenate(fit.hold_out.compared)))
        errors = [predict(*model[:2], fit.hold_out.swings, part, interval=False).errors() for model in (now, other)]
        hold_out = float(np.sqrt(np.nanmean(errors[1] ** 2) / np.nanmean(errors[0] ** 2)))
    return Part(name, present, float(np.sqrt(other_rss / rss)), float(-change if present else change), hold_out)


def _omissions(scene: Scene, keys: list[str]) -> Iterator[_Other]:
    for i, effect in enumerate(scene.effects):
        rest = [key for key in keys if not key.startswith(f"effects[{i}].")]
        where = f"effects[{i}], {effect.kind}"
        if isinstance(effect, Viscous):
            yield where, True, _change(scene, i, Viscous(**effect.given() | {"coefficient": 0.0})), rest
        if isinstance(effect, DryFriction):
            yield where, True, _change(scene, i, DryFriction(kinetic=0.0, joints=effect.joints)), rest
        if isinstance(effect, DryFriction) and effect.stribeck is not None:
            size = effect.static or effect.kinetic
            plain = DryFriction(kinetic=size, joints=effect.joints)
            kinetic = [key for key in keys if key == f"effects[{i}].kinetic"]
            yield f"{where}: stribeck", True, _change(scene, i, plain), [*rest, *kinetic]
        if isinstance(effect, Drag) and effect.coefficient:
            yield where, True, _change(scene, i, replace_checked(effect, {"coefficient": 0.0})), rest


def _additions(now: _Model) -> Iterator[_Other]:
    scene, keys = now.scene, [*now.setting.pendulum.free.keys]
    kinds, many, model = {effect.kind for effect in scene.effects}, len(scene.effects), scene.model
    weights = [9.81 * rod.properties.m * rod.length for rod in model.all_rods] if isinstance(model, Chain) else [1.0]
    size = SMALL * sum(weights)
    length = min(rod.length for rod in model.rods) if isinstance(model, Chain) else 1.0
    drag = Drag(diameter=length / SLENDER, coefficient=0.01)
    for effect in (Viscous(coefficient=size / SLOW), DryFriction(kinetic=size), drag):
        if effect.kind not in kinds:
            key = f"effects[{many}].{'kinetic' if isinstance(effect, DryFriction) else 'coefficient'}"
            yield effect.kind, False, replace_checked(scene, {"effects": (*scene.effects, effect)}), [*keys, key]
    for i, effect in enumerate(scene.effects):
        if isinstance(effect, DryFriction) and effect.stribeck is None:
            low, high = 0.98 * effect.kinetic, 1.02 * effect.kinetic + size
            falling = DryFriction(kinetic=low, static=high, stribeck=SLOW, joints=effect.joints)
            more = [f"effects[{i}].{name}" for name in ("kinetic", "static", "stribeck")]
            rest = [key for key in keys if key not in more]
            yield f"effects[{i}], dry_friction: stribeck", False, _change(scene, i, falling), [*rest, *more]
        if isinstance(effect, Gravity) and not any(key.startswith(f"effects[{i}].direction") for key in keys):
            yield "tilt of gravity", False, scene, [*keys, f"effects[{i}].direction[1]"]
    bearing = scene.model.bearing if isinstance(scene.model, Chain) else ()
    lengths = (f"model.rods[{i}].length" for i in bearing)
    if missing := [key for key in lengths if key not in keys]:
        yield "other lengths of rods", False, scene, [*keys, *missing]

    pendulum = now.setting.pendulum  # a friction for each of the joints that move, in place of one for several
    moving = [pendulum.model.joints[joint] for joint in pendulum.moving]
    for i, effect in enumerate(scene.effects):
        if not isinstance(effect, Viscous | DryFriction):
            continue
        first, *rest = [name for name in moving if effect.joints is None or name in effect.joints] or [None]
        names = [key.rpartition(".")[2] for key in keys if key.startswith(f"effects[{i}].")]
        if rest and names:
            more = [f"effects[{many + k}].{name}" for k in range(len(rest)) for name in names]
            apart = _change(scene, i, replace_checked(effect, {"joints": (first,)}))
            copies = (replace_checked(effect, {"joints": (name,)}) for name in rest)
            wider = replace_checked(apart, {"effects": (*apart.effects, *copies)})
            yield f"effects[{i}], {effect.kind}: one for each joint", False, wider, [*keys, *more]


def _change(scene: Scene, place: int, effect: Any) -> Scene:
    effects = [*scene.effects]
    effects[place] = effect
    return replace_checked(scene, {"effects": tuple(effects)})

"""The hard cases: scenes that break simulators, each with a bound from physics or analysis (docs/hard_cases.md).

scenes/ has the scene of each case, catalogue.toml its texts and methods; rods.py and chains.py its measure and bound;
base.py the record of a case. Here they are run: each on its methods, or in MuJoCo, Drake and SciPy on Pinocchio's
accelerations, each at its best setting.
"""

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cache, partial
from math import isfinite
from typing import Any

import numpy as np

from pendpin.errors import MissingLibrary, amount, attempt
from pendpin.ground.report import Report, Table
from pendpin.model import kinematics
from pendpin.model.build import build
from pendpin.motions.trajectory import Trajectory, simulate
from pendpin.scene import Scene
from pendpin.trajectory import Derived, Stats
from pendpin.verification import Claim, Claims, Progress, choose_cases, collect, name_once, simulators
from pendpin.verification.hardcases import chains, rods
from pendpin.verification.hardcases.base import FOLDER, Case, Solve, scene

CASES = {case.name: case for case in sorted((*rods.CASES, *chains.CASES), key=lambda case: case.group)}
FIELDS = ("name", "group", "title", "physics", "why", "figure", "bound", "derivation", "methods")  # of a case, in JSON


@dataclass(frozen=True)
class Outcome(Claim):
    """The result of one case on one method."""

    seconds: float
    claimed: bool = True  # False for other simulators
    left_out: bool = False  # whether it needs a library that is not installed

    def __str__(self) -> str:
        return f"{self.case} on {self.method}: {self.failure or f'{self.measured:.3g} is above {self.bound:.3g}'}"

    @property
    def verdict(self) -> str:
        if self.left_out:
            return "left out"
        if self.claimed:
            return super().verdict
        return "holds" if self.ok else "fails"


@dataclass(frozen=True, repr=False)
class HardReport(Claims):
    """The outcomes so far, and their cases."""

    outcomes: tuple[Outcome, ...]
    cases: tuple[Case, ...]
    stopped: bool = False  # by the user, before the end

    @property
    def broken(self) -> tuple[Outcome, ...]:
        return tuple(outcome for outcome in self.outcomes if outcome.claimed and not outcome.ok)

    def report(self) -> Report:
        """What was measured of each case on each method, which runs failed, and how many claims are broken."""
        rows = []
        for name, o in zip(name_once([o.case for o in self.outcomes]), self.outcomes, strict=True):
            measured = "none" if o.measured is None else f"{o.measured:.1e}"
            rows.append((name, o.method, measured, f"{o.bound:.1e}", o.verdict, f"{o.seconds:.2f}"))
        words = [f"{o.case} on {o.method}: {o.failure}" for o in self.outcomes if o.failure]
        if claims := [o.seconds for o in self.outcomes if o.claimed]:
            words.append(f"{amount(len(claims), 'claim')}, {len(self.broken)} broken, {sum(claims):.0f} s")
        outcomes = [asdict(o) | {"ok": o.ok, "verdict": o.verdict} for o in self.outcomes]
        described = [{name: getattr(case, name) for name in FIELDS} for case in self.cases]
        data = {"ok": not self.broken, "stopped": self.stopped, "outcomes": outcomes, "cases": described}
        head = ("case", "method", "measured", "bound", "verdict", "seconds")
        return Report((Table(head, rows), *words), data, self.fault)


def catalogue_report() -> Report:
    """The names of the hard cases, their titles and bounds."""
    rows = [(case.name, case.title, f"{case.bound:.1e}") for case in CASES.values()]
    data = [{name: getattr(case, name) for name in ("name", "title", "figure", "bound")} for case in CASES.values()]
    table, where = Table(("case", "what", "bound"), rows), FOLDER / "scenes"
    return Report((table, f"`pendpin run` takes their scenes: {where}"), data)


def hard(
    names: Sequence[str] = (), full: bool = True, peers: bool = False, progress: Progress = lambda what: None
) -> HardReport:
    """Run the hard cases with these names, or all of them, on their methods.

    full=False runs the short forms. With `peers`, other simulators and "auto" run the short forms of the cases in which
    only gravity acts. `progress` is called with the name of the case and method. After Ctrl-C the report holds the
    outcomes so far. Raises InputError for an unknown case, MissingLibrary for a missing simulator.
    """
    cases = tuple(choose_cases(CASES, names, "hard").values())
    if peers:  # the short forms that others can run: measured by their angles, or by tips compared with pendpin's
        if names := simulators.missing():
            are = "is" if len(names) == 1 else "are"
            raise MissingLibrary(f"peers: {' and '.join(names)} {are} not installed: pip install mujoco drake")
        direct = [case for case in cases if case.group in GRAVITY_ALONE and case.name not in NOT_FOR_PEERS]
        compared = [_against_ours(case, COMPARED[case.name]) for case in cases if case.name in COMPARED]
        cases = tuple(sorted([*direct, *compared], key=lambda case: case.group))
        outcomes = (outcome for case in cases for outcome in _run_on_peers(case, progress))
    else:
        outcomes = (run_case(case, method, full, progress) for case in cases for method in case.methods)
    results, stopped = collect(outcomes)
    return HardReport(results, cases, stopped)


def run_case(case: Case, method: str, full: bool, progress: Progress = lambda what: None) -> Outcome:
    """One case on one of its methods, with its setting."""
    progress(f"{case.name} on {method}")
    setting: dict[str, Any] = dict(case.methods[method])
    return _measure(case, method, lambda scene: simulate(scene, method=method, **setting), full)


def _measure(case: Case, method: str, solve: Solve, full: bool) -> Outcome:
    """One case solved by `solve`; an error of the run is an outcome too."""
    begin = time.process_time()
    figure, error = attempt(lambda: float(case.measure(solve, full)))  # JSON takes no NumPy numbers
    failure = error and str(error)
    if figure is not None and not isfinite(figure):
        figure, failure = None, "its numbers are not finite"
    missing, seconds = isinstance(error, MissingLibrary), time.process_time() - begin
    return Outcome(case.name, method, figure, case.bound, failure, seconds, claimed=not missing, left_out=missing)


# --- the short forms in other simulators ----------------------------------------------------------------------------

LIMIT = 20.0  # s that a run may take
CLOSE = 1e-6  # of the chain's length: the bound where tips are compared with pendpin's at a tight tolerance
SIMULATORS: Mapping[str, tuple[Callable[..., Iterator[simulators.Peer]], str, tuple[float, ...]]] = {
    # its peers, its best method, and settings from coarse to fine: steps as fractions of the duration, or tolerances
    "MuJoCo RK4": (simulators.mujoco_peers, "mujoco rk4", (1e-3, 1e-4, 1e-5)),
    "Drake RK5": (simulators.drake_peers, "drake rk5", (1e-9, 1e-12)),
    "SciPy DOP853": (simulators.scipy_peers, "scipy dop853", (1e-9, 1e-12)),
}
GRAVITY_ALONE = (1, 2, 3, 5, 6, 7, 12, 13, 14, 15)  # groups whose figures come from angles alone, but for some cases
NOT_FOR_PEERS = (  # other effects than gravity; figures that need rates or pendpin's settings; starts at other times
    *("pole-torque-thick", "pole-phi-torque-thin", "pole-torque-thin", "swings-in-space", "triple-1e4"),
    *("late", "late-driven", "chaos-methods", "chaos-back", "reversed"),
)
COMPARED: Mapping[str, Callable[[], Scene]] = {  # by the distance of tips to pendpin's
    **{f"cone-{rate:g}": partial(scene, f"cone-{rate:g}", chains.turns(rate)) for rate in (1e2, 1e3, 1e4)},
    "swings-in-space": partial(scene, "swings-in-space", {"duration": 40.0, "solver.samples": 41}),
    "triple-1e4": partial(scene, "triple-1e4", {"duration": 3.0}),
    "chain-100": partial(chains.tumbling, "chain-100", {"duration": 0.1}),
    "whip": partial(scene, "whip", chains.SHORT_WHIP),
    "chaos-methods": partial(chains.wild, 5.0),
}


def _against_ours(case: Case, make_scene: Callable[[], Scene]) -> Case:
    """A case whose figure is the distance of tips to pendpin's."""
    ours = cache(lambda: simulate(make_scene(), method="dop853", tolerance=1e-13))

    def measure(solve: Solve, full: bool) -> float:
        length = kinematics.chain_length(build(make_scene().model))
        return float(kinematics.tip_distance(solve(make_scene()).tips, ours().tips, length).max())

    words = {"figure": "distance to pendpin's tips at tolerance 1e-13, over the chain's length", "derivation": "chosen"}
    return replace(case, measure=measure, bound=CLOSE, **words)


def _run_on_peers(case: Case, progress: Progress) -> Iterator[Outcome]:
    """A case on `auto` and on other simulators: the best of some settings, none finer after a run longer than LIMIT."""
    yield replace(run_case(case, "auto", False, progress), claimed=False)
    for name, (make_peers, method, settings) in SIMULATORS.items():
        progress(f"{case.name} on {name}")
        outcomes: list[Outcome] = []
        for setting in settings:
            solve = partial(_run_peer, make_peers, method, setting)
            outcomes.append(replace(_measure(case, f"{name}, {setting:g}", solve, full=False), claimed=False))
            if outcomes[-1].seconds > LIMIT:
                break
        yield min(outcomes, key=lambda o: np.inf if o.measured is None else o.measured)


def _run_peer(make_peers: Callable[..., Any], method: str, setting: float, scene: Scene) -> Trajectory:
    """A scene run by another simulator; NaN for what it does not compute. Raises RunError if it does not reach its end."""
    peer = next(peer for peer in make_peers(simulators.task_of(scene)) if peer.name == method)
    setting *= (scene.duration or 1.0) if peer.kind == "step" else 1.0
    run = peer.run(setting, LIMIT)
    model, (n, nv) = build(scene.model), run.q.shape
    unknown, wrench = np.full((n, nv), np.nan), np.full((n, nv, 6), np.nan)
    tips = kinematics.tips(model, kinematics.poses(model, run.q))
    how: Any = {"method": peer.name, "library": peer.library, "version": "", "engine": ""}
    how |= {"tolerance": None, "step": None, peer.kind: setting}
    counts: Any = {"steps": run.steps, "evaluations": run.evaluations, "seconds": run.seconds}
    stats = Stats(**how, **counts, events=0, compile_seconds=0.0)
    derived = Derived(unknown, wrench, unknown[:, 0], unknown[:, 0], tips, None)
    return Trajectory(joints=model.joints, t=run.t, q=run.q, v=unknown, derived=derived, stats=stats)

"""Agreement with published results: cases of other simulators, benchmarks and closed forms (`pendpin validate`).

To add a case: a TOML file in cases/, with its source, its scene, what is compared and the published numbers. It is run by
every method that can run it, and once to a target accuracy. reference.py writes reference numbers for other engines.
"""

import html
import tomllib
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from functools import cache, partial
from io import StringIO
from itertools import chain
from math import ceil
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from pendpin.dynamics.vibrations import matrices, vibrations
from pendpin.errors import InputError, MissingLibrary, amount, attempt, find, inside
from pendpin.graphics.figure import draw_path
from pendpin.graphics.style import new_figure, styled
from pendpin.ground.arguments import function, names_in, number_at
from pendpin.ground.arrays import Array
from pendpin.ground.files import fill_template
from pendpin.ground.records import Number, Positive, Record, Vector
from pendpin.ground.report import Report, Table
from pendpin.model import kinematics
from pendpin.model.build import build, start_state
from pendpin.model.kinematics import scale
from pendpin.motions.periodic import periodic_orbit
from pendpin.motions.trajectory import Trajectory, simulate
from pendpin.scene import METHODS, Scene
from pendpin.scene.methods import Accuracy, Method
from pendpin.verification import Claim, Claims, Progress, choose_cases, collect, name_once

FOLDER = Path(__file__).parent / "cases"
WINDOW = 0.02  # of a published bound of stability: where the verdict is looked for to change


class Published(Record):
    """What a published quantity needs in any case."""

    name: str = Field(description="what the source publishes")
    unit: str = Field(description="its unit")
    bound: Positive = Field(description="in that unit: how far the published numbers themselves may be off")
    because: str = Field(description="where the bound comes from")


class Frequencies(Published):
    """Natural frequencies in rad/s of small motions about the scene's start, a rest."""

    values: tuple[Number, ...] = Field(description="the published numbers, rising")
    every: int = Field(1, description="how many modes share each of them: 2 where both directions are alike")

    def compute(self, scene: Scene) -> Array:
        """The lowest natural frequencies of a scene, as many as are published."""
        q, v = start_state(build(scene.model), scene.start)
        omega = vibrations(matrices(scene, q, v, np.zeros(len(q)))).omega
        return omega[:: self.every][: len(self.values)]


class StabilityBounds(Published):
    """Values of a number of the scene at which its periodic motion becomes stable, or unstable."""

    values: tuple[Number, ...] = Field(description="the published numbers, rising")
    key: str = Field(description="the key path of the number")

    def compute(self, scene: Scene) -> Array:
        """Where the multipliers of the scene's motion leave the unit circle, next to each published value."""
        number_at(scene, self.key)  # a key that is none is refused

        def is_stable(value: float) -> bool:
            return periodic_orbit(scene.replace({self.key: value})).stable

        found = []
        for value in self.values:
            low, high = (1 - WINDOW) * value, (1 + WINDOW) * value
            before = is_stable(low)
            if before == is_stable(high):
                low = high = float("nan")  # no change of stability is near
            for _ in range(40 if low < high else 0):  # 2e-2 to a rounding
                middle = (low + high) / 2
                low, high = (middle, high) if is_stable(middle) == before else (low, middle)
            found.append((low + high) / 2)
        return np.array(found)


class Quantity(Published):
    """One published quantity: what it is in a run, in whose axes, and its values at some times."""

    of: Literal["angle", "rate", "centre of mass", "tip", "force", "moment"] = Field(description="what it is in a run")
    at: str = Field(description="the joint of an angle, rate, force or moment; the link of a centre of mass or tip")
    frame: Literal["world", "parent", "child"] = Field("world", description="of forces and moments")
    on: Literal["child", "parent"] = Field("child", description="what a force or moment acts on")
    axes: tuple[Vector, ...] = Field(
        ((1, 0, 0), (0, 1, 0), (0, 0, 1)), description="the source's axes in pendpin's frame"
    )
    offset: Number = Field(0.0, description="added to an angle, rad")
    columns: tuple[str, ...] = Field(description="the source's names of the components")
    values: tuple[tuple[Number, ...], ...] = Field(description="rows: the time in s, then a number for each column")

    @property
    def times(self) -> Array:
        """When the values were published, (k,) s."""
        return np.array(self.values)[:, 0]

    def difference(self, run: Trajectory) -> float:
        """The largest difference of any published number to a run at the same time, in the quantity's unit."""
        axes = np.array(self.axes, float)
        if self.of == "angle":
            observed = run[self.at][:, None] + self.offset
        elif self.of == "rate":
            observed = run[f"{self.at}_rate"][:, None]
        elif self.of in ("force", "moment"):
            part = slice(3) if self.of == "force" else slice(3, 6)
            observed = run.express(self.at, self.frame, on=self.on)[:, part] @ axes.T
        else:
            model = build(run.source.model)
            place = find(tuple(body.link for body in model.bodies), self.at, "at:")
            body = model.bodies[place]
            point = np.array([*(body.tip if self.of == "tip" else body.com), 1.0])
            observed = kinematics.poses(model, run.q)[:, place, :3] @ point @ axes.T
        samples = np.searchsorted(run.t, self.times - 1e-12 * run.t[-1])
        return float(np.abs(observed[samples] - np.array(self.values)[:, 1:]).max())


class Case(Record):
    """A published case: its source, its scene and what is compared."""

    title: str = Field(description="the motion in a few words")
    source: str = Field(description="the citation, with its repository and file or its pages")
    origin: str = Field(description="which program or formula gave the numbers")
    note: str = Field("", description="what is particular about the case")
    settings: dict[str, Positive] = Field(default_factory=dict, description="tolerances and steps other than the usual")
    leave_out: dict[str, str] = Field(default_factory=dict, description="methods that cannot run it, and why")
    accuracy: Accuracy = Field(1e-9, description="target of the run whose claim is tested")
    scene: Scene = Field(description="the scene whose run is compared")
    quantities: tuple[Quantity, ...] = Field((), description="what is compared along the motion")
    frequencies: tuple[Frequencies, ...] = Field((), description="natural frequencies that are compared")
    stability: tuple[StabilityBounds, ...] = Field((), description="bounds of stability that are compared")

    @model_validator(mode="after")
    def _something_is_compared(self) -> Self:
        if not (self.quantities or self.frequencies or self.stability):
            raise ValueError("nothing is compared: give quantities, frequencies or stability")
        return self

    @property
    def times(self) -> tuple[float, ...]:
        """The start, and every time at which something was published, s."""
        published = np.concatenate([[0.0], *(quantity.times for quantity in self.quantities)])
        return tuple(np.unique(published).tolist())


@cache
def published_cases() -> dict[str, Case]:
    """All cases, by the names of their files; a URDF that a scene names is relative to its file. Raises InputError."""
    cases = {}
    for path in sorted(FOLDER.glob("*.toml")):
        raw = tomllib.loads(path.read_text(encoding="utf-8"))
        model = raw["scene"]["model"]
        if "path" in model:
            model["path"] = path.parent / model["path"]
        with inside(path.name):
            cases[path.stem] = Case(**raw)
    return cases


# --- every case by every method -------------------------------------------------------------------------------------

# Errors of these settings are a hundred times below the tightest bound of the cases that use them; a case names others.
USUAL = {"dop853": 1e-11, "rk45": 1e-11, "rk23": 1e-9, "radau": 1e-10, "bdf": 1e-10, "lsoda": 1e-11, "taylor": 1e-16}
USUAL |= {"gauss2": 2e-4, "gauss4": 2e-3, "gauss6": 5e-3, "rk4": 1e-3, "euler": 5e-6}  # steps in s
TO_ACCURACY = "accuracy"  # in place of a method: the run whose estimate of its own error is tested too


@dataclass(frozen=True)
class Comparison(Claim):
    """One published quantity against one run; the figure is the largest difference, in the quantity's unit."""

    source: str
    quantity: str
    unit: str

    def __str__(self) -> str:
        why = self.failure or f"{self.measured:.3g} {self.unit} is above {self.bound:.3g}"
        return f"{self.case}, {self.quantity}, by {self.method}: {why}"


@dataclass(frozen=True, repr=False)
class AgreementReport(Claims):
    """The comparisons so far, and what was left out with the reasons."""

    comparisons: tuple[Comparison, ...]
    left_out: tuple[str, ...] = ()
    stopped: bool = False  # True if the user stopped it before the end

    @property
    def broken(self) -> tuple[Comparison, ...]:
        return tuple(row for row in self.comparisons if not row.ok)

    @property
    def worst(self) -> tuple[Comparison, ...]:
        """Of each quantity the method that differs most; a run that failed counts as that."""
        rows: dict[tuple[str, str], list[Comparison]] = {}
        for row in self.comparisons:
            rows.setdefault((row.case, row.quantity), []).append(row)

        def difference(row: Comparison) -> float:
            return np.inf if row.measured is None or np.isnan(row.measured) else row.measured

        return tuple(max(some, key=difference) for some in rows.values())

    def report(self) -> Report:
        """Of each published quantity the method that differs most; the runs that failed; what was left out; the counts."""
        rows = []
        for name, r in zip(name_once([row.case for row in self.worst]), self.worst, strict=True):
            difference = "failed" if r.measured is None else f"{r.measured:.1e} {r.unit}"
            rows.append((name, r.quantity, f"{r.bound:.1e} {r.unit}", difference, r.method, r.verdict))
        words = [f"{row.case} by {row.method}: {row.failure}" for row in self.comparisons if row.failure]
        words += [f"left out: {line}" for line in self.left_out]
        words += [f"{amount(len(self.comparisons), 'comparison')}, {len(self.broken)} beyond the bound"]
        data = [asdict(row) | {"holds": row.ok} for row in self.comparisons]
        data = [{"difference": row.pop("measured")} | row for row in data]
        head = ("case", "quantity", "bound", "largest difference", "by", "")
        return Report((Table(head, rows), *words), data, self.fault)


def sources_report() -> Report:
    """The published cases with what they compare and where the numbers come from."""
    cases = published_cases()
    rows = [(name, case.title, case.origin, case.source) for name, case in cases.items()]
    data = [{"case": name} | case.model_dump(mode="json") for name, case in cases.items()]
    return Report((Table(("case", "motion", "numbers by", "source"), rows),), data)


def validate(
    names: Sequence[str] = (), methods: Sequence[str] | None = None, progress: Progress = lambda what: None
) -> AgreementReport:
    """Run published cases and compare them with their published numbers.

    After Ctrl-C the report holds the comparisons so far.

    Args:
        names: of the cases; all if empty.
        methods: the methods to run them by; all that can run a case if absent. "accuracy" stands for a run to the case's
            target accuracy, whose claimed error is added to the bound of positions.
        progress: called with the case and the method.

    Returns:
        The report: each difference beside its bound.

    Raises:
        InputError: for unknown names.
    """
    cases = choose_cases(published_cases(), names, "validate")
    methods = None if methods is None else names_in("methods", methods, (*METHODS, TO_ACCURACY))
    progress = function("progress", progress)
    left_out: list[str] = []
    found = (_compare(name, case, methods, progress, left_out) for name, case in cases.items())
    rows, stopped = collect(chain.from_iterable(found))
    return AgreementReport(rows, tuple(left_out), stopped)


def _compare(
    name: str, case: Case, methods: Sequence[str] | None, progress: Progress, left_out: list[str]
) -> Iterator[Comparison]:
    """The comparisons of a case: near its rest or orbit, then along its motion by each method."""
    for near in (*case.frequencies, *case.stability):
        by = "linear model" if isinstance(near, Frequencies) else "multipliers"
        progress(f"{name} by the {by}")
        found, error = attempt(partial(near.compute, case.scene))
        if isinstance(error, MissingLibrary):
            left_out.append(f"{name} by the {by}: {error}")
            continue
        off = None if found is None else max(np.abs(found - np.array(near.values)).tolist())
        yield Comparison(name, by, off, near.bound, error and str(error), case.source, near.name, near.unit)
    for method in (methods or (TO_ACCURACY, *METHODS)) if case.quantities else ():
        like = method if method in (TO_ACCURACY, *USUAL) else _alike(METHODS[method])
        if like in case.leave_out:
            left_out.append(f"{name} by {method}: {case.leave_out[like]}")
            continue
        progress(f"{name} by {method}")
        scene, how, by = case.scene, {"accuracy": case.accuracy}, f"accuracy {case.accuracy:g}"
        if method != TO_ACCURACY:
            scene, how, by = scene.by(method, case.settings.get(like, USUAL[like])), {}, method
        run, error = attempt(partial(simulate, scene, times=case.times, **how))
        if isinstance(error, MissingLibrary):
            left_out.append(f"{name} by {method}: {error}")
            continue
        for quantity in case.quantities:  # a failed run is a comparison of each
            off, bound = run and quantity.difference(run), quantity.bound
            if run and run.stats.error is not None and quantity.of in ("centre of mass", "tip"):
                bound += run.stats.error * scale(build(run.source.model))  # its claim is a part of the length
            yield Comparison(name, by, off, bound, error and str(error), case.source, quantity.name, quantity.unit)


def _alike(added: Method) -> str:
    """The method of USUAL whose setting an added one takes: the nearest below in its order, with the smallest setting."""
    known = [METHODS[name] for name in USUAL if METHODS[name].setting == added.setting]
    order = lambda method: method.order or 1.0  # noqa: E731
    lower = [method for method in known if order(method) <= order(added)] or known
    highest = max(map(order, lower))
    return min((method.name for method in lower if order(method) == highest), key=USUAL.__getitem__)


# --- the agreement with published results as one HTML page ----------------------------------------------------------

SHOWN = 10.0  # s, of a longer motion: later swings lie on top of the first
SAMPLES, COLUMNS = 1001, 4  # of each path; of the figure


def agreement_page(report: AgreementReport) -> str:
    """The report as HTML that needs no network: the worst method of each quantity, then sources and motions."""
    cases = {row.case: published_cases()[row.case] for row in report.comparisons}
    motions = StringIO()
    with styled():
        draw_motions(list(cases)).savefig(motions, format="svg")
    words = {name: f"{x.title}. Numbers by {x.origin}. {x.source}. {x.note}" for name, x in cases.items()}
    sources = "\n".join(f"<li><strong>{name}</strong>: {html.escape(text)}</li>" for name, text in words.items())
    svg = motions.getvalue()[motions.getvalue().index("<svg") :]
    return fill_template(__name__, "page.html", table=report.report()._repr_html_(), motions=svg, sources=sources)


@styled()
def draw_motions(names: list[str]) -> Any:
    """A figure with the path of the tip of each case that has one, seen where it is widest: from above where it is level."""
    names = [name for name in names if published_cases()[name].quantities]
    rows = max(1, ceil(len(names) / COLUMNS))
    figure = new_figure(3.2 * COLUMNS, 3.2 * rows)
    axes = np.ravel(figure.subplots(rows, COLUMNS, squeeze=False))
    for ax, name in zip(axes, names, strict=False):
        case = published_cases()[name]
        run = simulate(case.scene, duration=min(case.times[-1], SHOWN), samples=SAMPLES)
        wide, deep, high = np.ptp(run.tips[:, -1], axis=0)
        draw_path(ax, run, "above" if high < 1e-3 * max(wide, deep) else "side" if wide > deep else "front")
        ax.set_title(name)
    for ax in axes[len(names) :]:
        ax.set_axis_off()
    return figure

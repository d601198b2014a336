"""Every figure that pendpin draws, by its laws: one look, one way to write units, no text outside, no legend on a frame."""

import ast
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg

import pendpin as pp
from fit_scenes import ANGLE, scene_of, swings_of
from pendpin.graphics.style import STYLE
from pendpin.stability.sections import bifurcation, portrait, strobe
from pendpin.stability.sections.points import read_crossing
from pendpin.sweeps.figure import draw_map
from pendpin.verification.agreement import draw_motions
from pendpin.verification.work_precision.report import Curve, Point, draw_cost
from test_work_precision_report import REPORT

SOURCE = Path(pp.__file__).parent
# Units that an axis may bear, and what has none.
UNITS = {"s", "m", "rad", "rad/s", "rad/s²", "N", "N m", "J", "1/s", "degrees", "rad or m", "kg m²/s", "N m s/rad"}
PURE = {"energy drift", "energy_drift", "autocorrelation", "size of the largest multiplier"}
PURE |= {"largest error of a tip over the chain's length; more accurate to the right"}
ROUNDING = 1.0  # pixel: places are whole ones


def double() -> pp.Scene:
    return pp.Scene(
        duration=3.0,
        model=pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0, radius=0.01)], copies=2),
        start=pp.Start(positions={"theta_1": 1.0, "phi_2": 0.3}),
        effects=[pp.effects.Gravity()],
    )


def driven() -> pp.Scene:
    motor = pp.effects.Motor(joint="theta", amplitude=0.5, frequency=3.0)
    rod = pp.Chain(rods=[pp.Rod(length=1.0, mass=1.0, radius=0.01)])
    effects = [pp.effects.Gravity(), pp.effects.Viscous(coefficient=0.05), motor]
    return pp.Scene(duration=1.0, model=rod, start=pp.Start(positions=[0.3, 0.0]), effects=effects)


def run_figure(*names: str, copies: int = 1, compared: bool = False) -> Any:
    scene = double().replace({"model.copies": 2 * copies})
    run = pp.simulate(scene, samples=61, tolerance=1e-6)
    return run.plot(*names, compare=pp.simulate(scene, samples=61, method="rk4", step=0.01) if compared else None)


def fit_figure(region: bool) -> Any:
    """Of two swings and one that is held out, or the region of two numbers of it."""
    scene = scene_of(1, pp.effects.Viscous(coefficient=2e-4), data=ANGLE)
    free = ["model.rods[0].com", "effects[1].coefficient"]
    fitted = pp.fit(scene, swings_of(scene, [0.5], [1.0]), free, hold_out=swings_of(scene, [0.8], seed=1))
    return fitted.plot_region(*free).figure if region else fitted.plot()


def swept(*keys: str) -> Any:
    pytest.importorskip("xarray")
    values = {key: list(np.linspace(0.5, 2.5, 4)) for key in keys}
    return draw_map(
        pp.sweep(double().replace(duration=0.5), values, measure=["swing" if len(keys) < 2 else "flip_time"])
    )


def many_curves(count: int) -> Any:
    """A report on so many methods, some of which end at one place."""
    curves = [
        Curve(f"method {k}", "", "step", tuple(Point(h, h**4, (1 + k // 3) * 1e-3 / h, 1, 1) for h in (0.3, 0.1, 0.03)))
        for k in range(count)
    ]
    return replace(REPORT, curves=(*curves, *REPORT.curves))


def section() -> Any:
    place = read_crossing("theta_1 = 0, rising", ("theta_2", "theta_2_rate"), 5, 0)
    return portrait(double(), place, 2, -10.0).plot().figure


def diagram() -> Any:
    at = strobe(None, of=("theta",), count=5, skip=2)
    return bifurcation(driven(), "effects[2].frequency", [3.0, 3.2], at).plot().figure


# By the function that draws: the file and its name, or the class and its method.
FIGURES: dict[str, list[Callable[[], Any]]] = {
    "graphics/figure.py draw": [
        run_figure,
        partial(run_figure, copies=10),
        partial(run_figure, compared=True),
        partial(run_figure, "theta_1", "R3_1", "energy_drift"),
        partial(run_figure, "theta_1", "phi_1", "theta_1_rate", "kinetic", compared=True),
    ],
    "graphics/figure.py plot": [lambda: run_figure("theta_1")],
    "stability/lyapunov.py plot": [lambda: pp.lyapunov(double(), duration=1.0).plot().figure],
    "stability/modes.py plot": [lambda: pp.modes(double()).plot()],
    "stability/sections/diagrams.py plot": [section, diagram],
    "stability/branches.py plot": [
        lambda: pp.follow(pp.periodic_orbit(driven()), "effects[2].frequency", 3.1).plot().figure
    ],
    "fitting/report.py draw_fit": [lambda: fit_figure(False)],
    "fitting/report.py plot_region": [lambda: fit_figure(True)],
    "sweeps/figure.py draw_map": [
        lambda: swept("start.positions.theta_1"),
        lambda: swept("start.positions.theta_1", "model.rods[0].length"),
    ],
    "verification/work_precision/report.py draw_cost": [lambda: draw_cost(REPORT), lambda: draw_cost(many_curves(22))],
    "verification/agreement/__init__.py draw_motions": [lambda: draw_motions(["adams-2", "conical"])],
}


def test_every_figure_is_here() -> None:
    """What draws is styled and in the table above; a figure is made nowhere else, films apart."""
    styled, makers = set(), set()
    for path in SOURCE.rglob("*.py"):
        name, text = path.relative_to(SOURCE).as_posix(), path.read_text()
        for node in ast.walk(ast.parse(text)) if "styled" in text or "matplotlib" in text else ():
            if isinstance(node, ast.FunctionDef) and "styled()" in map(ast.unparse, node.decorator_list):
                styled.add(f"{name} {node.name}")
            if isinstance(node, ast.ImportFrom) and node.module in ("matplotlib.figure", "matplotlib.pyplot"):
                makers.add(name)
    assert styled == set(FIGURES)
    makers = {name for name in makers if not name.startswith("examples/")}  # which a wheel holds beside the package
    assert makers == {"graphics/style.py", "graphics/view.py"}


@pytest.mark.parametrize(("name", "place"), [(name, i) for name, all_ in FIGURES.items() for i in range(len(all_))])
def test_a_figure_keeps_the_laws(name: str, place: int) -> None:
    figure = FIGURES[name][place]()
    FigureCanvasAgg(figure).draw()
    shown = [ax for ax in figure.axes if ax.axison]
    for ax in shown:
        for text in (ax.get_xlabel(), ax.get_ylabel()):
            quantity, _, unit = text.rpartition(" (")
            assert text in PURE or text == "" or (quantity and unit.removesuffix(")") in UNITS), text
            assert not text.startswith("time") or text.endswith(" (s)")
        assert {ax.xaxis.label.get_size(), ax.yaxis.label.get_size()} == {STYLE["axes.labelsize"]}
        if ax.get_label() != "<colorbar>":
            assert not ax.spines["top"].get_visible()
            assert not ax.spines["right"].get_visible()
    frame, renderer = figure.bbox, figure.canvas.get_renderer()

    def within(box: Any, outer: Any) -> bool:
        return bool(
            box.x0 >= outer.x0 - ROUNDING
            and box.x1 <= outer.x1 + ROUNDING
            and box.y0 >= outer.y0 - ROUNDING
            and box.y1 <= outer.y1 + ROUNDING
        )

    for ax in shown:
        assert within(ax.get_tightbbox(renderer), frame), f"{name}: {ax.get_ylabel()} leaves the figure"
    legends = [*figure.legends, *(ax.get_legend() for ax in shown if ax.get_legend())]
    for legend in legends:
        box = legend.get_window_extent(renderer)
        assert within(box, frame), f"{name}: a legend leaves the figure"
        for ax in shown:
            inside = within(box, ax.bbox)
            assert inside or not box.padded(-ROUNDING).overlaps(ax.bbox), f"{name}: a legend lies on a frame"


def test_other_models_are_drawn_by_the_same_quantity() -> None:
    """Beside the tensions of two rods, that of one alone; and no number reaches the name of its axis."""
    several, scene = pp.simulate(double(), samples=61), driven().replace(duration=3.0)
    figure = several.plot(compare=pp.simulate(scene, samples=61))
    renderer = FigureCanvasAgg(figure).get_renderer()
    figure.draw(renderer)
    names = {ax.get_ylabel(): ax.get_legend_handles_labels()[1] for ax in figure.axes}
    assert names["tension R3 (N)"] == ["rod 1", "rod 2", "R3"]
    for ax in figure.axes:
        name, numbers = ax.yaxis.label.get_window_extent(renderer), ax.yaxis.get_ticklabels(which="both")
        assert name.x1 <= min(text.get_window_extent(renderer).x0 for text in numbers if text.get_text())

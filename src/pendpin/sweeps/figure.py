"""The result of a sweep as a report, and as one figure: a line for one dimension, a map for two, small maps for three."""

import json
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

from pendpin.errors import InputError, not_one_of
from pendpin.graphics.style import BESIDE, COLORS, GREY, SHADE, new_figure, styled, with_unit, write_figure
from pendpin.ground.arrays import Array, Mask
from pendpin.ground.report import Report, Table
from pendpin.sweeps.attractors import KINDS
from pendpin.sweeps.attractors import NAME as ATTRACTOR
from pendpin.sweeps.measures import MEASURES
from pendpin.sweeps.plan import short_names
from pendpin.sweeps.store import NOT_RUN

DOUBTFUL = 1e-3  # of a measure's range: a spread beyond is hatched
DIVERGED = 1e-2  # a divergence beyond is hatched
DECADES = 100.0  # largest over least value, beyond which colours are logarithmic
MOST_PANELS = 12
MOST_REASONS = 5  # why cases have no values, the commonest


def sweep_report(dataset: Any) -> Report:
    """The range of each measure over the cases that were run, and why others could not be."""
    why = dataset["why"].values
    run, reasons = why != NOT_RUN, Counter(str(reason) for reason in why.flat if reason and reason != NOT_RUN)
    figures = {"least": np.min, "median": np.median, "most": np.max}
    measures, rows, kinds = {}, [], list[tuple[str, int]]()
    for name in names_of(dataset):
        values = dataset[name].values[run]
        good = values[np.isfinite(values)]
        ranges = {figure: float(of(good)) if good.size else np.nan for figure, of in figures.items()}
        measures[name] = ranges | {"none": values.size - good.size}
        kinds += [(kind, int((values == i).sum())) for i, kind in enumerate(dataset[name].attrs.get(KINDS, []), 1)]
        rows.append((label(name, dataset), *(f"{x + 0.0:.6g}" for x in ranges.values()), f"{measures[name]['none']}"))
    counts = {"cases": why.size, "not_run": int((~run).sum()), "failed": reasons.total()}
    waiting = f"; {counts['not_run']} not run yet" if counts["not_run"] else ""
    words = [f"  attractor {kind}: {cases} cases" for kind, cases in kinds]
    if lost := measures.get(ATTRACTOR, {}).get("none"):
        words.append(f"  {ATTRACTOR}: {lost} of {run.sum()} cases did not settle")
    words += [f"{counts['cases']} cases; {counts['failed']} could not be run{waiting}"]
    words += [f"  {times} x {reason}" for reason, times in reasons.most_common(MOST_REASONS)]
    if len(reasons) > MOST_REASONS:
        words += [f"  ... and {len(reasons) - MOST_REASONS} more reasons"]
    fault = f"no case could be run: {reasons.most_common(1)[0][0]}" if reasons.total() == why.size else None
    return Report((Table(("measure", *figures, "no value"), rows), *words), counts | {"measures": measures}, fault)


def save_map(dataset: Any, path: str | Path, measure: str | None = None) -> Path:
    """Write the figure of one measure, the first unless named, to a .png, .pdf or .svg. Raises InputError."""
    return write_figure(path, lambda: draw_map(dataset, measure))


@styled()
def draw_map(dataset: Any, measure: str | None = None) -> Any:
    """The figure of one measure. Raises InputError for one that is not there, or more than three dimensions."""
    name = chosen(dataset, measure)
    values, doubtful = dataset[name], doubtful_cells(dataset, name)
    dims = [str(dim) for dim in values.dims]
    if len(dims) == 1:
        figure, y = new_figure(8.0, 4.5), values.values
        ax, varied = figure.subplots(), short_names(dataset.attrs["keys"]) if "keys" in dataset.attrs else dims
        across = dims[0] if dims[0] in varied else varied[0]  # of samples the first number that is varied
        x = dataset[across].values
        if across == dims[0]:
            ax.plot(x, y, color=COLORS[0])
            ax.plot(x[doubtful], y[doubtful], "x", color=COLORS[1], label="two tolerances disagree")
            if doubtful.any():
                ax.legend(**BESIDE)
        else:
            ax.plot(x, y, ".", color=COLORS[0], markersize=3)
        ax.set_xlabel(label(across, dataset))
        ax.set_ylabel(label(name, dataset))
        return figure
    if len(dims) == 2:
        return _maps(name, dims, dataset, [(values.values, doubtful, "")])
    if len(dims) == 3 and values.shape[0] <= MOST_PANELS:
        titles = (f"{label(dims[0], dataset)} = {x:.4g}" for x in dataset[dims[0]].values)
        return _maps(name, dims[1:], dataset, list(zip(values.values, doubtful, titles, strict=True)))
    shape = " x ".join(str(n) for n in values.shape)
    few = f"up to three dimensions, the first of up to {MOST_PANELS}"
    raise InputError(f"a sweep of {shape} cases has no figure: {few}")


def chosen(dataset: Any, measure: str | None) -> str:
    """The name of a measure, the first unless named. Raises InputError for one that is not there."""
    names = names_of(dataset)
    if measure is not None and measure not in names:
        raise InputError(f"measure: {not_one_of(measure, names)}")
    return names[0] if measure is None else measure


def names_of(dataset: Any) -> list[str]:
    """The names of the measures in a result."""
    return [str(name) for name in dataset.data_vars if name != "why"]


def doubtful_cells(dataset: Any, name: str) -> Mask:
    """The cases (dims) that were run and whose measure cannot be trusted, because two tolerances disagree."""
    values, run = dataset[name].values, dataset["why"].values == ""
    finite = values[np.isfinite(values)]
    limit = DOUBTFUL * (np.ptp(finite) if finite.size else 0.0)
    if f"{name}.spread" in dataset:
        return run & ~(dataset[f"{name}.spread"].values <= limit)
    if "divergence" in dataset and name != "divergence":
        return run & ~(dataset["divergence"].values <= DIVERGED)
    return np.zeros(values.shape, bool)


def label(name: str, dataset: Any) -> str:
    """A measure or a varied number as an axis names it, with its unit, unless the attributes long_name and units differ."""
    attributes = dataset[name].attrs
    key = attributes.get("key", name)
    text, unit = attributes.get("long_name", name if key.startswith("start.") else key), attributes.get("units", "")
    return with_unit(text, unit)


def _maps(name: str, dims: list[str], dataset: Any, panels: list[tuple[Array, Mask, str]]) -> Any:
    """Maps of panels (values (m, n), doubtful (m, n), title), one scale of colours; m goes to the right, n up."""
    from matplotlib.patches import Patch

    columns = min(len(panels), 4)
    rows = -(-len(panels) // columns)
    figure = new_figure(2.0 + 4.6 * columns if columns > 1 else 7.6, 1.2 + 4.4 * rows)
    axes = figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True)
    x, y = (dataset[dim].values for dim in dims)
    kinds = dataset[name].attrs.get(KINDS, [])
    colours = _colours([np.where(doubtful, np.nan, values) for values, doubtful, _ in panels], len(kinds))
    mesh: Any = None
    for ax, (values, doubtful, text) in zip(axes.flat, panels, strict=False):
        ax.set_facecolor(SHADE)  # where there is no value
        mesh = ax.pcolormesh(x, y, np.where(doubtful, np.nan, values).T, shading="nearest", rasterized=True, **colours)
        if doubtful.any():
            ax.contourf(x, y, doubtful.T.astype(float), levels=[0.5, 1.5], colors="none", hatches=["////"])
        ax.grid(visible=False)
        ax.set_title(text)
    for ax in axes[-1]:
        ax.set_xlabel(label(dims[0], dataset))
    for ax in axes[:, 0]:
        ax.set_ylabel(label(dims[1], dataset))
    for ax in axes.flat[len(panels) :]:
        ax.remove()
    bar = figure.colorbar(mesh, ax=axes, label=label(name, dataset), shrink=0.9)
    if 0 < len(kinds) <= len(COLORS):
        bar.set_ticks(range(1, len(kinds) + 1), labels=kinds)
    patches, hatched = list[Any](), "two tolerances disagree"
    if any(doubtful.any() for _, doubtful, _ in panels):
        patches.append(Patch(facecolor=SHADE, hatch="////", edgecolor=GREY, label=hatched))
    if any((np.isnan(values) & ~doubtful).any() for values, doubtful, _ in panels):
        patches.append(Patch(facecolor=SHADE, label=describe_empty_cells(name, dataset)))
    if patches:
        figure.legend(handles=patches, loc="outside lower center", ncols=len(patches))
    return figure


def describe_empty_cells(name: str, dataset: Any) -> str:
    """What a cell without a value means, such as: did not turn over in 10 s."""
    measure = MEASURES.get(name.removesuffix(".spread"))
    text = "did not settle" if name == ATTRACTOR else measure.without if measure else "no value"
    duration = json.loads(dataset.attrs.get("scene", "{}")).get("duration")
    if duration is not None and text != "no value":
        text += f" in {duration:g} s"
    return text if (dataset["why"].values == "").all() else f"{text}, or not run"


def _colours(arrays: list[Array], kinds: int) -> dict[str, Any]:
    """Perceptual colours over the range of all (m, n): symmetric where they have both signs, logarithmic over decades."""
    from matplotlib.colors import ListedColormap, LogNorm

    if 0 < kinds <= len(COLORS):  # numbers of a few kinds have a colour each
        return {"cmap": ListedColormap(COLORS[:kinds]), "vmin": 0.5, "vmax": kinds + 0.5}
    values = np.concatenate([array[np.isfinite(array)].ravel() for array in arrays])
    low, high = (float(values.min()), float(values.max())) if values.size else (0.0, 1.0)
    if low < 0 < high:
        most = max(-low, high)
        return {"cmap": "RdBu_r", "vmin": -most, "vmax": most}
    if low > 0 and high > DECADES * low:
        return {"cmap": "viridis", "norm": LogNorm(low, high)}
    return {"cmap": "viridis", "vmin": low, "vmax": high if high > low else low + 1.0}

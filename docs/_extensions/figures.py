"""Pictures of the gallery: figures that a script holds by a name, as `figure = run.plot()`, appear after its block.

Each script begins with the look of pendpin's own figures. Its picture in the gallery is its first figure, drawn small, so
that its letters can be read there; a script that moves names a frame of its player instead.
"""

import shutil
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

SMALL = 4.0  # inches at least, the width of a small figure; 0.7 of it is the height, as of a frame of a player
SHRINK = 0.55  # of a large figure


def scrape(block: Any, block_vars: dict[str, Any], gallery_conf: dict[str, Any]) -> str:
    """Save each new figure of a block; sphinx-gallery calls this after every block of a script."""
    from sphinx_gallery.scrapers import figure_rst

    names = block_vars["example_globals"]
    shown = names.setdefault("_figures_shown", [])
    new = [thing for thing in names.values() if isinstance(thing, Figure) and not any(thing is old for old in shown)]
    paths = []
    for figure, path in zip(new, block_vars["image_path_iterator"], strict=False):
        figure.savefig(path, dpi=100)
        save_small(figure, small_picture(Path(path)))
        shown.append(figure)
        paths.append(path)
    return figure_rst(paths, gallery_conf["src_dir"])


def small_picture(path: Path) -> Path:
    """Where the small version of a picture of the gallery stands: docs/gallery/images/small."""
    return path.parent / "small" / path.name


def save_small(figure: Figure, path: Path) -> None:
    """The same figure on less paper, without what would lie on its curves there."""
    path.parent.mkdir(exist_ok=True)
    size = figure.get_size_inches().copy()
    width = max(SMALL, SHRINK * size[0])
    hidden: list[Any] = [*figure.legends, *(legend for ax in figure.axes if (legend := ax.get_legend()))]
    hidden += [figure._suptitle] if figure._suptitle else []
    if len(figure.axes) > 2:
        hidden += [axis.label for ax in figure.axes for axis in (ax.xaxis, ax.yaxis)]
    figure.set_size_inches(width, 0.7 * width)
    for part in hidden:
        part.set_visible(False)
    figure.savefig(path, dpi=480 / width)
    for part in hidden:
        part.set_visible(True)
    figure.set_size_inches(size)


def show_small(app: Any) -> None:
    """Put the small figures where sphinx-gallery has put its thumbnails; called after it."""
    for thumbnail in (Path(app.srcdir) / "gallery" / "images" / "thumb").glob("sphx_glr_*_thumb.png"):
        script = thumbnail.stem.removeprefix("sphx_glr_").removesuffix("_thumb")
        small = small_picture(thumbnail.parents[1] / f"sphx_glr_{script}_001.png")
        if small.exists() and not (Path(app.srcdir) / "images" / "gallery" / f"{script}.png").exists():
            shutil.copyfile(small, thumbnail)


def reset(gallery_conf: dict[str, Any], name: str) -> None:
    """Give matplotlib the look of pendpin; sphinx-gallery calls this before every script."""
    import matplotlib as mpl

    from pendpin.graphics.style import STYLE

    mpl.rcdefaults()
    mpl.use("agg")
    mpl.rcParams.update(STYLE)


def setup(app: Any) -> dict[str, bool]:
    """Sphinx calls this."""
    app.connect("builder-inited", show_small, priority=900)
    return {"parallel_read_safe": True}

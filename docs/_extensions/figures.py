"""Pictures of the gallery: figures that a script holds by a name, as `figure = run.plot()`, appear after its block.

Each script begins with the look of pendpin's own figures.
"""

from typing import Any

from matplotlib.figure import Figure


def scrape(block: Any, block_vars: dict[str, Any], gallery_conf: dict[str, Any]) -> str:
    """Save each new figure of a block; sphinx-gallery calls this after every block of a script."""
    from sphinx_gallery.scrapers import figure_rst

    names = block_vars["example_globals"]
    shown = names.setdefault("_figures_shown", [])
    new = [thing for thing in names.values() if isinstance(thing, Figure) and not any(thing is old for old in shown)]
    paths = []
    for figure, path in zip(new, block_vars["image_path_iterator"], strict=False):
        figure.savefig(path, dpi=100)
        shown.append(figure)
        paths.append(path)
    return figure_rst(paths, gallery_conf["src_dir"])


def reset(gallery_conf: dict[str, Any], name: str) -> None:
    """Give matplotlib the look of pendpin; sphinx-gallery calls this before every script."""
    import matplotlib as mpl

    from pendpin.graphics.style import STYLE

    mpl.rcdefaults()
    mpl.use("agg")
    mpl.rcParams.update(STYLE)

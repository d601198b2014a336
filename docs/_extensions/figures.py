"""Pictures of the gallery: figures that a script holds by a name, as `figure = run.plot()`, appear after its block.

Each script begins with the look of pendpin's own figures. Its picture in the gallery is its first figure, drawn small, so
that its letters can be read there; a script that moves names a frame of its player instead.
"""

import re
import shutil
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

SMALL = 4.0  # inches at least, the width of a small figure; 0.7 of it is the height, as of a frame of a player
SHRINK = 0.55  # of a large figure
GROUPS = {  # the scripts of the gallery under its headings, by number; what is in none stands last
    "Rods, chains and robots": (1, 2, 3, 29, 13, 14, 18, 25),
    "Cables and loads": (4, 21, 5, 6, 28, 27),
    "Effects": (9, 10, 8, 7, 22),
    "Accuracy": (16, 15, 23, 11, 12, 24),
    "Studies": (17, 30, 31, 26, 20, 19),
}
ENTRY = re.compile(r'\.\. raw:: html\n\n    <div class="sphx-glr-thumbcontainer".*?</div>\n    </div>\n', re.DOTALL)
OPEN, CLOSE = ('.. raw:: html\n\n    <div class="sphx-glr-thumbnails">\n', ".. raw:: html\n\n    </div>\n")


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


def group(app: Any) -> None:
    """Arrange the gallery's page under headings; called after sphinx-gallery, which writes one list."""
    page = Path(app.srcdir) / "gallery" / "index.rst"
    text = page.read_text(encoding="utf-8")
    entries = {int(re.search(r"plot_(\d+)", entry)[1]): entry for entry in ENTRY.findall(text)}
    pages = {int(re.search(r"plot_(\d+)", line)[1]): line for line in re.findall(r"^   /gallery/plot_.*$", text, re.M)}
    known = [number for numbers in GROUPS.values() for number in numbers]
    groups = GROUPS | {"Further": tuple(number for number in entries if number not in known)}
    lines = "\n".join(pages[number] for numbers in groups.values() for number in numbers)
    parts = [text[: text.index(OPEN)], f".. toctree::\n   :hidden:\n\n{lines}\n"]
    for title, numbers in groups.items():
        if numbers:
            parts += [f"{title}\n{'-' * len(title)}\n", OPEN, *(entries[number] for number in numbers), CLOSE]
    page.write_text("\n".join(parts), encoding="utf-8")


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
    app.connect("builder-inited", group, priority=900)
    return {"parallel_read_safe": True}

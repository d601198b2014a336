"""Store what the gallery of the site shows of each example that moves: a frame of its player, in docs/images/gallery.

python tests/store_thumbnails.py [NAME ...]
python tests/store_thumbnails.py player      # the README's first picture, docs/images/player.png

A script of docs/gallery_scripts names its picture by a line `# sphinx_gallery_thumbnail_path`. Chromium draws the frames.
"""

import os
import sys
import tempfile
from io import BytesIO
from pathlib import Path

import numpy as np
from PIL import Image

import pendpin as pp
from browser import Browser, chromium
from pendpin.scene import builtin_scene

DOCS = Path(__file__).parents[1] / "docs"
SCRIPTS, PICTURES = DOCS / "gallery_scripts", DOCS / "images" / "gallery"
SIZE = (960, 672)  # pixels of a page
SHOWN = (480, 336)  # pixels of a picture
PLAYER = (1100, 720)  # pixels of the README's
VIVID = 0.25  # difference of two colours of a pixel, of what moves; the ground and the sky are pale
FRAMES = {  # what the player is asked for, by the address of its page
    "plot_01_one_rod": "t=2.1&reactions=on",
    "plot_02_double_pendulum": "t=3.4",
    "plot_03_triple_pendulum": "t=4.2",
    "plot_04_cable": "t=1.0",
    "plot_06_crane": "t=9",
    "plot_08_kapitza": "t=0.4",
    "plot_09_dry_friction": "t=1.2",
    "plot_10_stop": "t=0.9",
    "plot_11_through_the_pole": "t=1.3&view=corner",
    "plot_13_cone": "t=3.2&frames=on",
    "plot_14_upright": "t=9.3",
    "plot_18_panda": "t=0.4&reactions=on",
    "plot_21_cable_in_wind": "t=5.5",
    "plot_22_carousel": "t=7.5&view=above",
    "plot_25_two_runs": "t=4.0",
    "plot_28_two_loads": "t=4.3&reactions=on",
    "plot_29_acrobot": "t=2.5",
}
ASIDE = "#closeup, #letters-close, header, #views, #plots, #bar, #report { display: none !important; }"
HIDE = f"document.head.appendChild(document.createElement('style')).textContent = {ASIDE!r}"
DRAWN = "new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))"


def page_of(script: Path, folder: Path) -> Path:
    """The player of the run that a script of the gallery makes, as a page in a folder."""
    names: dict = {"__name__": "gallery"}
    os.chdir(DOCS.parent)  # scripts name examples/crane.toml
    exec(compile(script.read_text(encoding="utf-8"), str(script), "exec"), names)  # our own text
    run: pp.Trajectory = names["one"] if "compare=" in script.read_text(encoding="utf-8") else names["run"]
    player = run.animate(compare=names["other"]) if "compare=" in script.read_text(encoding="utf-8") else run.animate()
    return player.save(folder / f"{script.stem}.html")


def cropped(pixels: np.ndarray) -> Image.Image:
    """What moves in a picture (rows, columns, 3), from 0 to 1, with some room around it."""
    rows, columns = np.nonzero(np.ptp(pixels, axis=2) > VIVID)
    (left, right), (top, bottom) = np.percentile(columns, [0.5, 99.5]), np.percentile(rows, [0.1, 99.9])
    width = min(SIZE[0], 1.25 * max(right - left, (bottom - top) * SIZE[0] / SIZE[1], SIZE[0] / 3))
    height = width * SIZE[1] / SIZE[0]
    x = np.clip((left + right - width) / 2, 0, SIZE[0] - width)
    y = np.clip((top + bottom - height) / 2, 0, SIZE[1] - height)
    whole = Image.fromarray(np.round(pixels * 255).astype(np.uint8))
    return whole.resize(SHOWN, Image.Resampling.LANCZOS, (x, y, x + width, y + height))


def draw_player(browser: Browser, folder: Path) -> None:
    """The whole page of the built-in rod, as the first command of the README makes it, with its reactions."""
    address = pp.simulate(builtin_scene()).animate().save(folder / "player.html").as_uri()
    with browser.open(f"{address}#t=2.1&reactions=on", PLAYER) as page:
        page.resize(*PLAYER)
        page.evaluate(DRAWN)
        picture = Image.fromarray(np.round(page.picture() * 255).astype(np.uint8))
    picture.save(DOCS / "images" / "player.png", optimize=True)
    print(DOCS / "images" / "player.png")


def main(names: list[str]) -> None:
    """Draw the player and the frames of all scripts of the table, or those named."""
    PICTURES.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as folder, chromium() as browser:
        for name in names or ["player", *FRAMES]:
            if name == "player":
                draw_player(browser, Path(folder))
                continue
            address = page_of(SCRIPTS / f"{name}.py", Path(folder)).as_uri()
            with browser.open(f"{address}#{FRAMES[name]}", SIZE) as page:
                page.resize(*SIZE)
                page.evaluate(HIDE)
                page.evaluate(DRAWN)
                picture = cropped(page.picture())
            with BytesIO() as file:
                picture.quantize(256, Image.Quantize.FASTOCTREE).save(file, "PNG", optimize=True)
                (PICTURES / f"{name}.png").write_bytes(file.getvalue())
            print(PICTURES / f"{name}.png")


if __name__ == "__main__":
    main(sys.argv[1:])

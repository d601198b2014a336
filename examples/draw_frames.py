"""The drawings of docs/derivation.md: frames, angles and reactions of one rod, and the angles of a chain.

Directions come from the formula of the derivation, and pendpin's own tip has to lie where the drawn rod ends.
Run it:   python examples/draw_frames.py docs/images
"""

import sys
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import FancyArrowPatch

import pendpin as pp

THETA, PHI = 0.75, 0.62  # rad, of the one rod
CHAIN = ((0.75, 0.6), (-0.75, 0.45))  # rad, theta and phi of two rods, each relative to the rod above
NAMES = ("theta", "phi")
GRAVITY = pp.effects.Gravity()
EYE = np.array([1.0, -0.62, 0.42])  # W, from where the drawing is seen
GREY, AXIS, ANGLE = "#8a94a3", "#2d3748", "#b7410e"
BODY, FORCE, ROD = "#2b6cb0", "#6b46c1", "#e7b793"


def turned(theta: float, phi: float) -> np.ndarray:
    """b1, b2, b3 in the frame above, as columns (3, 3): docs/derivation.md, section 1."""
    s, c, st, ct = np.sin(phi), np.cos(phi), np.sin(theta), np.cos(theta)
    return np.array([[c, 0, s], [-st * s, ct, st * c], [-ct * s, -st, ct * c]])


def seen(points: Any) -> np.ndarray:
    """Points (..., 3) of the frame I (z down) as the eye sees them, (..., 2)."""
    back = EYE / np.linalg.norm(EYE)
    right = np.cross([0, 0, 1], back) / np.hypot(*back[:2])
    return (np.asarray(points) * [1, -1, -1]) @ np.stack([right, np.cross(back, right)], -1)


class Sheet:
    """One axes to draw on, in vectors of the frame I."""

    def __init__(self, ax: Any, title: str) -> None:
        self.ax = ax
        ax.set_aspect("equal")
        ax.set_axis_off()
        ax.set_title(title, fontsize=12, pad=14)
        ax.margins(0.09)

    def line(self, points: Any, color: str, width: float = 1.2, style: Any = "-") -> None:
        self.ax.plot(*seen(points).T, color=color, linewidth=width, linestyle=style, solid_capstyle="round")

    def arrow(self, start: Any, along: Any, color: str, name: str, heads: int = 1, width: float = 1.6) -> None:
        """An arrow, its name beyond its head; two heads for a moment."""
        start, along = np.asarray(start, float), np.asarray(along, float)
        for part in (1.0, 0.9)[:heads]:
            ends = seen([start, start + part * along])
            look = {"color": color, "linewidth": width, "mutation_scale": 11, "shrinkA": 0, "shrinkB": 0}
            self.ax.add_patch(FancyArrowPatch(*ends, arrowstyle="-|>", **look))
        ends = seen([start, start + along])
        across, up = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
        side = "left" if across > 0.5 else "right" if across < -0.5 else "center"
        place = ends[1] + [0.035 * across, 0.05 * up]
        self.ax.text(*place, name, color=color, ha=side, va="center", fontsize=12)

    def text(self, place: Any, name: str, color: str) -> None:
        self.ax.text(*seen(place), name, color=color, ha="center", va="center", fontsize=12)

    def arc(self, centre: Any, first: Any, last: Any, radius: float, name: str, at: float = 0.5) -> None:
        """The arc of an angle from one direction to another, an arrow's head at its end, its name `at` a part of it."""
        first, last = (np.asarray(v) / np.linalg.norm(v) for v in (first, last))
        angle = np.arccos(first @ last)
        u = np.linspace(0, 1, 40)[:, None]
        points = centre + radius * (np.sin((1 - u) * angle) * first + np.sin(u * angle) * last) / np.sin(angle)
        self.line(points[:-1], ANGLE, 1.6)
        look = {"color": ANGLE, "mutation_scale": 10, "shrinkA": 0, "shrinkB": 0}
        self.ax.add_patch(FancyArrowPatch(*seen(points[[-4, -1]]), arrowstyle="-|>", **look))
        middle = (1 - at) * first + at * last
        self.text(centre + (radius + 0.07) * middle / np.linalg.norm(middle), name, ANGLE)

    def rod(self, start: Any, b: np.ndarray, length: float = 1.0) -> None:
        self.line([start, start + length * b[:, 2]], ROD, 7)
        self.ax.plot(*seen(start), "o", color=AXIS, markersize=6, zorder=5)

    def support(self) -> None:
        x, y = 0.11 * np.eye(3)[0], 0.11 * np.eye(3)[1]
        corners = [x + y, x - y, -x - y, -x + y]
        self.ax.fill(*seen(np.array(corners) - [0, 0, 0.02]).T, color="#cbd5e0", zorder=0)


def draw_angles(sheet: Sheet) -> None:
    """Frames W, I and B, the joint's axes, the two angles, and the rod's own axes."""
    x, y, z = np.eye(3)
    b, o = turned(THETA, PHI), np.zeros(3)
    after_theta = turned(THETA, 0.0)[:, 2]
    sheet.support()
    sheet.rod(o, b)
    sheet.line([o, 0.92 * after_theta], GREY, 1.0, (0, (4, 3)))
    for along, name in ((-y, "$y_W$"), (-z, "$z_W$")):
        sheet.arrow(o, 0.36 * along, AXIS, name)
    for along, name in ((y, "$y_I$"), (1.9 * z, "$z_I$")):
        sheet.arrow(o, 0.36 * along, GREY, name)
    sheet.arrow(o, 0.5 * x, AXIS, r"$x_W=x_I=a_1$")
    sheet.arrow(o, 0.34 * b[:, 1], BODY, "$a_2$")
    a3 = np.cross(x, b[:, 1])
    sheet.arrow(o, 0.2 * a3, BODY, "")
    sheet.text(0.2 * a3 + 0.1 * b[:, 1], "$a_3$", BODY)  # beside the dashed line
    sheet.arc(o, z, after_theta, 0.56, r"$\theta$")
    sheet.arc(o, after_theta, b[:, 2], 0.78, r"$\phi$")
    G = 0.5 * b[:, 2]
    sheet.ax.plot(*seen(G), "o", color="white", markeredgecolor=AXIS, markersize=7, zorder=6)
    sheet.text(G - 0.09 * b[:, 0] - 0.03 * b[:, 1], "$G$", AXIS)
    for k, size in ((0, 0.26), (1, 0.26), (2, 0.68)):
        sheet.arrow(G, size * b[:, k], BODY, f"$b_{k + 1}$")


def measure(ax: Any, start: np.ndarray, end: np.ndarray, name: str) -> None:
    """A length beside the rod, with its name."""
    look = {"color": GREY, "mutation_scale": 10, "shrinkA": 0, "shrinkB": 0}
    ax.add_patch(FancyArrowPatch(start, end, arrowstyle="<|-|>", **look))
    ax.text(*(start + end) / 2, name, ha="center", va="center", fontsize=12, color=AXIS, backgroundcolor="white")


def draw_reactions(sheet: Sheet) -> None:
    """What acts on the rod: the joint's force and moment, each as it counts positive, its weight, h and l."""
    x = np.eye(3)[0]
    b, o = turned(THETA, PHI), np.zeros(3)
    sheet.rod(o, b)
    sheet.line([o, 0.95 * np.eye(3)[2]], GREY, 0.8, (0, (4, 3)))
    for k, size in ((0, 0.4), (1, 0.4), (2, -0.5)):
        sheet.arrow(o, size * b[:, k], FORCE, f"$R_{k + 1}$", width=2.0)
    sheet.arrow(o, 0.5 * np.cross(x, b[:, 1]), ANGLE, "$M_c$ (along $a_3$)", heads=2, width=2.0)
    G = 0.5 * b[:, 2]
    sheet.ax.plot(*seen(G), "o", color="white", markeredgecolor=AXIS, markersize=7, zorder=6)
    sheet.arrow(G, 0.42 * np.eye(3)[2], AXIS, "$m g$", width=2.0)
    sheet.arrow(o + b[:, 2], 0.16 * b[:, 2], BODY, "$b_3$")
    aside = seen(b[:, 2])[::-1] * [1, -1] / np.linalg.norm(seen(b[:, 2]))
    for end, name, off in ((0.5, "$h$", -0.27), (1.0, "$l$", -0.39)):
        measure(sheet.ax, seen(o) + off * aside, seen(end * b[:, 2]) + off * aside, name)


def draw_chain_angles(sheet: Sheet) -> None:
    """Two rods: the second one's angles count from the first one's axes."""
    o, above = np.zeros(3), np.eye(3)
    sheet.support()
    for i, (theta, phi) in enumerate(CHAIN, start=1):
        half, b = above @ turned(theta, 0.0), above @ turned(theta, phi)
        sheet.rod(o, b)
        sheet.line([o, o + 0.75 * above[:, 2]], GREY, 1.0, (0, (4, 3)))
        sheet.line([o, o + 0.75 * half[:, 2]], GREY, 1.0, (0, (1, 2)))
        sheet.arrow(o, 0.42 * above[:, 0], BODY, f"$a_{{1,{i}}}=" + ("x_I$" if i == 1 else "b_{1,1}$"))
        sheet.arrow(o, 0.34 * b[:, 1], BODY, f"$a_{{2,{i}}}$")
        sheet.arc(o, above[:, 2], half[:, 2], 0.5, rf"$\theta_{i}$", at=0.66)
        sheet.arc(o, half[:, 2], b[:, 2], 0.68, rf"$\phi_{i}$")
        o, above = o + b[:, 2], b
    sheet.arrow(o, 0.16 * above[:, 2], BODY, "$b_{3,2}$")


def draw_chain_reactions(sheet: Sheet) -> None:
    """The two rods taken apart at joint 2: what it exerts on rod 2, and the opposite on rod 1."""
    first, (theta, phi) = turned(*CHAIN[0]), CHAIN[1]
    b, end, apart = first @ turned(theta, phi), first[:, 2], np.array([0.0, 0.55, 0.85])
    a3 = np.cross(first[:, 0], b[:, 1])
    sheet.rod(np.zeros(3), first)
    sheet.rod(end + apart, b)
    sheet.line([end, end + apart], GREY, 0.8, (0, (1, 3)))
    for place, sign, name in ((end, -1, "-"), (end + apart, 1, "")):
        for k, size in ((0, 0.4), (1, 0.4), (2, -0.45)):
            sheet.arrow(place, sign * size * b[:, k], FORCE, f"${name}R_{{{k + 1},2}}$", width=2.0)
        sheet.arrow(place, sign * 0.45 * a3, ANGLE, f"${name}M_{{c,2}}$", heads=2, width=2.0)
    sheet.text(0.45 * end + [0, -0.26, 0], "rod 1", AXIS)
    sheet.text(end + apart + 0.7 * b[:, 2] + [0, -0.26, 0], "rod 2", AXIS)


def check_directions() -> None:
    """The drawn ends of the rods are the tips that pendpin computes."""
    for angles in (((THETA, PHI),), CHAIN):
        names = {f"{NAMES[k]}_{i + 1}": pair[k] for i, pair in enumerate(angles) for k in (0, 1)}
        rods = [pp.Rod(length=1.0, mass=1.0, radius=0.01)] * len(angles)
        scene = pp.Scene(duration=0.0, model=pp.Chain(rods=rods), start=pp.Start(positions=names), effects=[GRAVITY])
        end, above = np.zeros(3), np.eye(3)
        for pair in angles:
            above = above @ turned(*pair)
            end = end + above[:, 2]
        np.testing.assert_allclose(pp.simulate(scene).tips[0, -1], end * [1, -1, -1], atol=1e-14)


def main(folder: Path) -> None:
    """Write frames.png and frames_chain.png."""
    check_directions()
    sheets = {
        "frames.png": (("frames and angles", draw_angles), ("what acts on the rod", draw_reactions)),
        "frames_chain.png": (
            ("angles of a chain count from the rod above", draw_chain_angles),
            ("what joint 2 exerts on rod 2, and the opposite on rod 1", draw_chain_reactions),
        ),
    }
    for name, parts in sheets.items():
        figure = Figure(figsize=(11, 6.4), layout="tight")
        for ax, (title, draw) in zip(figure.subplots(1, 2), parts, strict=True):
            draw(Sheet(ax, title))
        figure.savefig(folder / name, dpi=110)
        print(folder / name)


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "."))

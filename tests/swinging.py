"""A rod that swings, as a drawing, and what is seen of it in a picture."""

import numpy as np
from scipy.spatial.transform import Rotation

from pendpin.graphics.drawing import WORLD, Drawing, Shape

ORANGE, STEEL, BLUE = 0xD9622B, 0x7A8696, 0x2B6CB0
LEFT, RIGHT = 1.5, 0.5  # s: when the rod of `swinging` is seen on the left and on the right


def pose(x: float = 0, y: float = 0, z: float = 0, turn: np.ndarray | None = None) -> np.ndarray:
    out = np.eye(4)
    out[:3, 3] = x, y, z
    out[:3, :3] = np.eye(3) if turn is None else turn
    return out


def swinging(seconds: float = 2.0, samples: int = 121, title: str = "A rod") -> Drawing:
    """A rod of 1 m that swings about x by 1 rad, once in 2 s: farthest along y at 0.5 s, along -y at 1.5 s."""
    t = np.linspace(0, seconds, samples)
    turns = Rotation.from_rotvec(np.outer(np.sin(np.pi * t), [1.0, 0, 0])).as_matrix()
    poses = np.tile(np.eye(4), (samples, 1, 1, 1))
    poses[:, 0, :3, :3] = turns
    sideways = Rotation.from_euler("y", 90, degrees=True).as_matrix()
    shapes = (
        Shape("box", (0.24, 0.24, 0.02), pose(z=0.04), STEEL, WORLD),
        Shape("sphere", (0.018,), pose(), STEEL, 0),
        Shape("cylinder", (0.008, 0.09), pose(turn=sideways), STEEL, WORLD),
        Shape("cylinder", (0.01, 1.0), pose(z=-0.5), ORANGE, 0),
    )
    return Drawing(title, t, poses, shapes, -turns[..., 2], 1.0)


def of_color(pixels: np.ndarray, color: int) -> np.ndarray:
    """Where in the picture, above the bar, a colour is seen, in whatever light: rows and columns (k, 2)."""
    wanted = np.array([(color >> 16) & 255, (color >> 8) & 255, color & 255]) / 255
    scene = pixels[:-100]
    brightness = scene.max(axis=-1, keepdims=True)
    near = np.abs(scene / np.maximum(brightness, 1e-9) - wanted / wanted.max()).max(axis=-1) < 0.08
    return np.argwhere(near & (brightness[..., 0] > 0.3))


def tip_side(pixels: np.ndarray) -> float:
    """How far right of its joint the rod's lower end is seen, in columns."""
    seen = of_color(pixels, ORANGE)
    assert len(seen) > 1000, "the rod is not seen"
    return seen[-20:, 1].mean() - seen[:20, 1].mean()

"""Robust fits: P. Huber's weights, the size of residuals without their outliers, and what errors are computed from."""

import numpy as np
from scipy.special import ndtr

from pendpin.ground.arrays import Array, Mask

# Standard deviations, from where on residuals count less: 95 % efficient (Huber, Robust Statistics, 1981).
CORNER = 1.345
BETA = 1 - 2 * ndtr(-CORNER) * (1 - CORNER**2) - 2 * CORNER * np.exp(-(CORNER**2) / 2) / np.sqrt(2 * np.pi)
STEPS = 40  # of the scale; each leaves less than half of the error where noise is normal


def huber_weights(r: Array) -> Array:
    """By what residuals r, in standard deviations, are multiplied before they are squared."""
    return np.sqrt(np.minimum(1.0, CORNER / np.maximum(np.abs(r), 1e-300)))


def huber_scale(r: Array, seen: Mask, axis: int | tuple[int, ...]) -> Array:
    """The standard deviation of residuals without their outliers: Huber's proposal 2; 0 where nothing was seen.

    It is that of a normal distribution where the squares, clipped at CORNER standard deviations, have their mean.
    """
    squares, count = np.where(seen, r, 0.0) ** 2, np.maximum(seen.sum(axis, keepdims=True), 1)
    variance = squares.sum(axis, keepdims=True) / count
    for _ in range(STEPS):
        variance = np.minimum(squares, CORNER**2 * variance).sum(axis, keepdims=True) / (BETA * count)
    return np.sqrt(np.squeeze(variance, axis))


def pseudo_residuals(r: Array, seen: Mask) -> Array:
    """What ordinary least squares would have to leave over, to give the numbers and errors of the robust fit.

    Clipped residuals over the part that is not clipped (J. Street, R. Carroll, D. Ruppert, Am. Stat. 42 (1988), 152).
    r is in standard deviations, and 0 where nothing was seen.
    """
    whole = np.mean(np.abs(r[seen]) <= CORNER)
    return np.clip(r, -CORNER, CORNER) / max(float(whole), 0.5)

"""Modes of hanging chains against Laguerre's zeros and against Pinocchio's derivatives with scipy.linalg.eigh.

    python benchmarks/modes.py [--rods 10 30 100 300 1000]

Point masses have omega² l / g at the zeros of the Laguerre polynomial L_n, each twice. Pinocchio's data take 600 MB for 100
rods, so it is asked up to there; its model and data are kept, and only its five lines are timed. Times are of the processor.
"""

import argparse
import time
from collections.abc import Callable
from typing import Any

import numpy as np
import pinocchio as pin
from scipy.linalg import eigh

import pendpin as pp
from pendpin.model.build import build

MOST_OF_PINOCCHIO = 100  # rods


def least(compute: Callable[[], Any]) -> tuple[Any, float]:
    """The result and the least processor time of three calls, in ms."""
    times = []
    for _ in range(3):
        begin = time.process_time()
        result = compute()
        times.append(time.process_time() - begin)
    return result, 1e3 * min(times)


def laguerre(n: int) -> np.ndarray:
    """The zeros of L_n: squares of the singular values of a bidiagonal matrix, which keep digits that eigenvalues lose."""
    return np.linalg.svd(np.diag(np.sqrt(np.arange(1, n + 1))) + np.diag(np.sqrt(np.arange(1, n)), 1))[1][::-1] ** 2


def chain(count: int, **rod: float) -> pp.Scene:
    return pp.Scene(model=pp.Chain(rods=[pp.Rod(**rod)], copies=count), effects=[pp.effects.Gravity()])


def by_pinocchio(scene: pp.Scene) -> tuple[np.ndarray, float]:
    """The frequencies in rad/s, and the time."""
    model = build(scene.model).pin.copy()
    model.gravity.linear = np.array([0.0, 0.0, -9.81])
    data, zero = model.createData(), np.zeros(model.nv)

    def compute() -> np.ndarray:
        stiffness = pin.computeRNEADerivatives(model, data, zero, zero, zero)[0]
        mass = pin.crba(model, data, zero)
        inverse = eigh(np.triu(mass) + np.triu(mass, 1).T, (stiffness + stiffness.T) / 2)[0]
        return np.sqrt(1 / inverse)[::-1]

    return least(compute)


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--rods", type=int, nargs="+", default=[10, 30, 100, 300, 1000])
    print(f"{'rods':>5} {'Laguerre':>10} {'modes, ms':>10} {'Pinocchio':>10} {'its ms':>8} {'times':>6}")
    for count in parser.parse_args().rods:
        found = pp.modes(chain(count, length=1.0, mass=0.0, payload=1.0))
        error = np.abs(found.omega**2 / np.repeat(laguerre(count) * 9.81, 2) - 1).max()
        thick = chain(count, length=1.0, mass=1.0, radius=0.05)
        modes, ms = least(lambda scene=thick: pp.modes(scene))
        row = f"{count:5} {error:10.1e} {ms:10.1f}"
        if count <= MOST_OF_PINOCCHIO:
            theirs, their_ms = by_pinocchio(thick)
            row += f" {np.abs(modes.omega / np.sort(theirs) - 1).max():10.1e} {their_ms:8.1f} {ms / their_ms:6.1f}"
        print(row, flush=True)


if __name__ == "__main__":
    main()

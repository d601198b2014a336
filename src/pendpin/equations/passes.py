"""Passes over the joints of a tree: outward from the base to the tips, inward from the tips to the base, and sums.

Every recursion is written as a step from one joint to the next. A namespace xp (numbers.py) that has these passes as
operations of its own records a step once, for a chain of any length: the tree is then that of one rod, and its base and its
last joint are where the neighbours hang.
"""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from pendpin.ground.arrays import Array

Step = Callable[[int, Any], tuple[Any, Any]]  # a joint, and what arrives there -> what it passes on, its result


def outward(step: Step, base: Any, parents: Sequence[int], xp: Any = np) -> list[Any]:
    """The results of a step at every joint, each from what its parent passes on; `base` for those with parent -1."""
    own = getattr(xp, "outward", None)
    return own(step, base, parents) if own else [result for _, result in outward_steps(step, base, parents)]


def outward_steps(step: Step, base: Any, parents: Sequence[int]) -> list[tuple[Any, Any]]:
    """What each joint passes on, and its result."""
    done: list[tuple[Any, Any]] = []
    for i, parent in enumerate(parents):
        done.append(step(i, done[parent][0] if parent >= 0 else base))
    return done


def inward(
    step: Step, own: Sequence[Any], join: Callable[[Any, Any], Any], parents: Sequence[int], xp: Any = np
) -> list[Any]:
    """The results of a step at every joint, from its `own` joined with what its children pass on."""
    recorded = getattr(xp, "inward", None)
    if recorded:
        return recorded(step, own, join, parents)
    return [result for _, result in inward_steps(step, own, join, parents)]


def inward_steps(
    step: Step, own: Sequence[Any], join: Callable[[Any, Any], Any], parents: Sequence[int]
) -> list[tuple[Any, Any]]:
    """What each joint passes on, and its result."""
    arriving, done = list(own), list[Any](own)
    for i in reversed(range(len(arriving))):
        done[i] = step(i, arriving[i])
        if parents[i] >= 0:
            arriving[parents[i]] = join(arriving[parents[i]], done[i][0])
    return done


def joined(one: Any, other: Any) -> Any:
    """The sum of two named tuples, number by number: what arrives from two children, for `inward`."""
    return one._make(x + y for x, y in zip(one, other, strict=True))


def total(x: Array, xp: Any = np) -> Any:
    """The sum of numbers (n,), of all joints or bodies."""
    own = getattr(xp, "total", None)
    return own(x) if own else np.sum(x)

"""The lanes: each integrates a first-order system over one stretch of output times."""

from pendpin.solvers.adaptive import NAMES as ADAPTIVE
from pendpin.solvers.adaptive import Adaptive
from pendpin.solvers.base import Lane, Memory, Run, Stretch
from pendpin.solvers.choice import FEW_JOINTS, automatic, lane_for, taylor_takes
from pendpin.solvers.taylor import MAX_JOINTS

__all__ = [
    "ADAPTIVE",
    "FEW_JOINTS",
    "MAX_JOINTS",
    "Adaptive",
    "Lane",
    "Memory",
    "Run",
    "Stretch",
    "automatic",
    "lane_for",
    "taylor_takes",
]

"""The lanes: each integrates a first-order system over one stretch of output times."""

from pendpin.solvers.adaptive import Adaptive
from pendpin.solvers.base import Lane, Run, Stretch
from pendpin.solvers.choice import automatic, lane_for
from pendpin.solvers.taylor import MAX_JOINTS

__all__ = ["MAX_JOINTS", "Adaptive", "Lane", "Run", "Stretch", "automatic", "lane_for"]

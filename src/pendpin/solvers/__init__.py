"""The lanes: each integrates a first-order system over one stretch of output times."""

from pendpin.solvers.adaptive import Adaptive
from pendpin.solvers.base import Lane, Run, Stretch
from pendpin.solvers.choice import lane_for

__all__ = ["Adaptive", "Lane", "Run", "Stretch", "lane_for"]

"""The methods: each integrates a first-order system over one segment of output times."""

from pendpin.integrators.adaptive import NAMES as ADAPTIVE
from pendpin.integrators.adaptive import Adaptive
from pendpin.integrators.base import Integrator, Memory, Run, Segment, StepPlan
from pendpin.integrators.choice import FEW_JOINTS, automatic, integrator_for, taylor_takes, uncompiled
from pendpin.integrators.taylor import MAX_JOINTS

__all__ = [
    "ADAPTIVE",
    "FEW_JOINTS",
    "MAX_JOINTS",
    "Adaptive",
    "Integrator",
    "Memory",
    "Run",
    "Segment",
    "StepPlan",
    "automatic",
    "integrator_for",
    "taylor_takes",
    "uncompiled",
]

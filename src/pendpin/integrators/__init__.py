"""The methods: each integrates a first-order system over one segment of output times.

May import: dynamics, engines and what is below them.
To add a method: a class in a file here, its name in scene/solver.py, and the place where it is made in choice.py.
"""

from pendpin.integrators.adaptive import NAMES as ADAPTIVE
from pendpin.integrators.base import Integrator, Memory, Run, Segment, StepPlan
from pendpin.integrators.choice import FEW_JOINTS, automatic, integrator_for, taylor_takes, uncompiled
from pendpin.integrators.taylor import MAX_JOINTS

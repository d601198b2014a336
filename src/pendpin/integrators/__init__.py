"""The methods: each integrates a first-order system over one segment of output times.

May import: dynamics, engines and what is below them.
To add a method: a class in a file here, and its record in scene/methods.py.
"""

from pendpin.integrators.base import Integrator, Memory, Run, Segment, StepPlan, Stop
from pendpin.integrators.choice import FEW_JOINTS, automatic, integrator_for, taylor_takes, uncompiled
from pendpin.integrators.taylor import MAX_JOINTS

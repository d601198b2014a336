"""The methods: each integrates a first-order system over one segment of output times.

May import: dynamics, engines and what is below them.
To add a method: a class in a file here, and its record in scene/methods.py. A method of one's own outside the package is a
class and a call of `add_method` (docs/how-to/own_method.md).
"""

from pendpin.integrators.base import Integrator, Memory, Run, Segment, StepPlan, Stop
from pendpin.integrators.choice import FEW_JOINTS, choose_method_and_engine, integrator_for, taylor_takes, uncompiled
from pendpin.integrators.fixed import FixedStep
from pendpin.integrators.taylor import MAX_JOINTS
from pendpin.scene import Method, add_method

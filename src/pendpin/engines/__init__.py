"""The engines: each computes a model's motion by its own equations, in its own coordinates.

May import: model, effects, equations and what is below them.
To add an engine: a class in a file here, and when it is taken in dynamics/dynamics.py (`choose_engine`).
"""

from pendpin.engines.base import (
    CALLBACK_EVERY,
    AngleEngine,
    Compiled,
    Derivative,
    Engine,
    GivenTorque,
    Loads,
    Moving,
    ProgressCallback,
    Sample,
)
from pendpin.engines.chains import MAX_SPHERICAL, Directions, LongChain, Spherical
from pendpin.engines.machine.llvm import Function, Values
from pendpin.engines.pinocchio import Canonical, CanonicalForm, Revolute

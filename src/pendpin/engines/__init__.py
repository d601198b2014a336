"""The engines: each computes a model's motion by its own equations, in its own coordinates."""

from pendpin.engines.base import WATCH_SLOW, AngleEngine, Derivative, Engine, Loads, Sample, Watch
from pendpin.engines.canonical import Canonical, CanonicalForm
from pendpin.engines.compiled import Compiled, Symbolic
from pendpin.engines.long_chain import LongChain
from pendpin.engines.revolute import Revolute
from pendpin.engines.thin import MAX_SPHERICAL, Directions, Spherical

__all__ = [
    "MAX_SPHERICAL",
    "WATCH_SLOW",
    "AngleEngine",
    "Canonical",
    "CanonicalForm",
    "Compiled",
    "Derivative",
    "Directions",
    "Engine",
    "Loads",
    "LongChain",
    "Revolute",
    "Sample",
    "Spherical",
    "Symbolic",
    "Watch",
]

"""The engines: each computes a model's motion by its own equations, in its own coordinates."""

from pendpin.engines.base import Derivative, Engine, Loads, Motion, Sample, Watch
from pendpin.engines.long_chain import LongChain
from pendpin.engines.revolute import Revolute

__all__ = ["Derivative", "Engine", "Loads", "LongChain", "Motion", "Revolute", "Sample", "Watch"]

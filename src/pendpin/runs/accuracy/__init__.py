"""Accuracy as the target: settings are refined until the error, estimated from several runs, is small enough.

May import: the rest of runs, but not simulate.py; integrators, dynamics and what is below them.
Each number of the search, with its reason, is in thresholds.py. To add a method: its record in scene/methods.py.
"""

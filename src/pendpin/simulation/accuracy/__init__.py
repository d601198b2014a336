"""Accuracy as the target: settings are refined until the error, estimated from several runs, is small enough.

May import: the rest of simulation, but not simulate.py; integrators, dynamics and what is below them.
To add a method: its order or its tolerances, in refinement.py.
"""

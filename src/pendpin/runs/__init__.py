"""Running a scene: simulate, target accuracy, the integration loop, checkpoints, limits, energy balance, batches.

May import: integrators, dynamics and what is below them.
To add what a run integrates beside its motion: a class like EnergyBalance in preparation.py, used in integration.py.
"""

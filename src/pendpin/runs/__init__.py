"""Running a scene: simulate, target accuracy, the integration loop, checkpoints, limits, energy balance, batches.

May import: integrators, dynamics and what is below them.
To add what a run does beside integrating (as the energy balance does): a file here, called from runs/run.py.
"""

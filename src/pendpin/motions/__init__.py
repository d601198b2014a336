"""What is asked of a run: the state at any time, crossings, sensitivities, periodic orbits, small motions, special starts.

May import: runs, integrators, dynamics and what is below them.
To add a question: a file here, and a method of Trajectory where users ask it of a run.
"""

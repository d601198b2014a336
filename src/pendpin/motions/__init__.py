"""What a user asks: `simulate`, and of a run the state at any time, crossings, sensitivities, orbits, rests, a cross-check.

May import: graphics, runs, integrators, dynamics and what is below them.
To add a question: a file here, and a method of Trajectory where users ask it of a run.
"""

"""Many runs at once: `simulate_many`, vectors of runs side by side, pools of workers.

May import: the rest of runs; integrators, dynamics and what is below them.
"""

"""Work and precision: what accuracy costs in time, for every method and for other simulators.

cost.py measures each method as a `Series` of runs against a reference solution (references.py); report.py says and draws
what was found.
May import: simulators, graphics, runs and what is below them; no other tool.
"""

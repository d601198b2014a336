"""Work and precision: what accuracy costs in time, for every method and for other simulators.

`cost` measures and `report` says what was found, in `curves`; a method that is measured is a `series` of runs against one
of the `references`.
May import: simulators, graphics, runs and what is below them; no other tool.
"""

"""Work and precision: what accuracy costs in time, for every method and for other simulators.

`cost` measures; `report` says and draws what was found. A method that is measured is a `series` of runs against one of
the `references`, which gives a curve.
May import: simulators, graphics, runs and what is below them; no other tool.
"""

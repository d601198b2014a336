"""Work and precision: what accuracy costs in time, for every method and for other simulators.

`cost` measures and `report` says what was found; a method that is measured is a `series` of runs against one of the
`references`. To add a method to the comparison, add its name in `cost`. Imports all rooms but the command line.
"""

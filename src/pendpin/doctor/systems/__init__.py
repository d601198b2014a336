"""The systems that the doctor knows: for each the names of its quantities, and what every quantity truly is.

A system is a record of formulas from a state to named quantities, each a line of text. To add one: a table of its names,
units, writings and formulas, and an entry in FAMILIES, in planar.py.

May import: reading, equations, scene, effects; tables.py also dynamics.
"""

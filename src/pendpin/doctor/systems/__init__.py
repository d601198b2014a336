"""The systems that the doctor knows: for each the names of its quantities, and what every quantity truly is.

A system is a record of formulas from a state to named quantities, each a line of a table in a Markdown file of this folder.
To add one: such a file, and a line in FAMILIES, in tables.py (docs/contributing/system.md).

May import: reading, equations, scene, effects; scene.py also dynamics.
"""

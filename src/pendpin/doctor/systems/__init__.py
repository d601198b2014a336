"""The systems that the doctor knows: for each the names of its quantities, and what every quantity truly is.

A system is a record of plain functions from a state to named quantities. To add one: its formulas and its words in a file
here, and one entry in known.py. May import: reading, equations.
"""

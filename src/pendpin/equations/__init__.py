"""Equations of motion derived by hand, one route a file: one rod, chains of rods, trees (docs/derivation*.md).

May import: the ground (errors, records, files, arrays). Never Pinocchio, never an engine. The routes for one
rod know only base.py, not each other.
To add a route: a new file here, and its name in motions/crosschecks/routes.py.
"""

"""Runs turned into reports: cross-check, work and precision, significance of effects, hard cases, other simulators.

May import: graphics, simulation and what is below them.
To add a hard case: a file of analysis/hardcases; another simulator: a file of analysis/simulators.
"""

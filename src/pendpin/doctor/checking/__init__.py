"""Equations against the truth: residuals at random states, proofs, special cases in which an equation holds.

May import: reading, systems, printed.py.
"""

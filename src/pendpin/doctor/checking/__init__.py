"""Equations against the truth: what each quantity truly is, in floats, 50 digits and symbols; residuals and proofs.

May import: reading, equations. To add a quantity: its formula in mechanics.py and its printed name in reading/names.py.
"""

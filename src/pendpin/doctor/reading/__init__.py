"""Printed equations read: text to tokens, tokens to trees that know their places, documents to statements.

May import: the ground. Nothing that is read is ever run; depth, length and exponents are bounded.
To add a LaTeX command: tokens.py. The names of quantities belong to each system: systems/.
"""

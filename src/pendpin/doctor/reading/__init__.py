"""Printed equations read: text to tokens, tokens to trees that know their places, documents to statements.

May import: errors, files. Nothing that is read is ever run; depth, length and exponents are bounded.
To add a LaTeX command: tokens.py. The printed names of quantities are those of each system: systems/
"""

"""Printed equations read: text to tokens, tokens to trees that know their places, documents to statements.

May import: errors, files. Nothing that is read is ever run; depth, length and exponents are bounded.
To add a printed name of a quantity: names.py; a LaTeX command: tokens.py.
"""

"""Equations as machine code.

tape, passes, tangents: the arithmetic as a list of operations, in loops over rods, with derivatives. text: what LLVM reads.
routines: what that calls, and what calls it. llvm: compiled in memory, and called.
May import: equations, ground and errors. To add an operation: tape.py, its derivative in tangents.py, its text in text.py.
"""

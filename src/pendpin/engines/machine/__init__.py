"""Equations as machine code: recorded on a tape, differentiated there, written for LLVM, compiled in memory.

tape, passes, tangents: the arithmetic as a list of operations. text, lines: its text, with sines and cosines. llvm, code:
what is called. May import: equations, ground and errors.
"""

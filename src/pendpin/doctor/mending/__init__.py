"""The smallest change that heals a wrong equation: what could be changed, what each change comes to, the text read again.

May import: checking, systems, reading, and printed.py. To add a kind of change: changes.py, one rule of the generator.
"""

"""The smallest change that heals a wrong equation: what each part would have to be, moves, and their texts read again.

May import: checking, reading. To add a kind of change: moves.py if it can be listed, additions.py if its size is not known.
"""

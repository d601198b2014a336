"""The commands, their tables and their progress. No physics.

May import: everything. To add a command: a function in cli/commands.py, and its table in cli/tables.py.
"""

from pendpin.cli.commands import main

__all__ = ["main"]

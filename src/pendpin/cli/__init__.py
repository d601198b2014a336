"""The commands, their tables and their progress. No physics.

May import: everything. To add a command: a file in cli/commands/ (cli/app.py lists them), and its table in cli/tables.py.
"""

from pendpin.cli.app import main

__all__ = ["main"]

"""The commands, their tables and their progress. No physics.

May import: everything. To add a command: a function in run.py, sweep.py or tools.py, listed in app.py.
Its result says in a report what is printed (ground/report.py); outputs.py prints it.
"""

import signal
import sys


def main() -> None:
    """Run the command line; Ctrl-C ends it in one line, also while it is being imported."""
    try:
        from pendpin.ground.libraries import heed_interrupts

        if signal.getsignal(signal.SIGINT) is signal.default_int_handler:  # a shell turns it off in the background
            heed_interrupts()
        from pendpin.cli.app import main as run

        run()
    except KeyboardInterrupt:
        print("pendpin: stopped by the user", file=sys.stderr)
        sys.exit(130)

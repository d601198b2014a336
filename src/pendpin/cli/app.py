"""The command line: its commands, and how each foreseen fault ends in one line."""

import atexit
import gc
import os
import sys
import warnings
from typing import Annotated, Any, NoReturn

import typer
from typer.core import TyperCommand, TyperGroup

from pendpin.cli.outputs import drop_output, prepare_streams, say
from pendpin.cli.run import new, plot, reference, run, schema, urdf, view
from pendpin.cli.sweep import fit, map_, sweep
from pendpin.cli.tools import bifurcation, check, cost, doctor, effects, hard, modes, section, stability, validate
from pendpin.errors import Interrupted, Note, PendpinError, one_line
from pendpin.ground.libraries import VERSION, abandoned

# what newer typers show of a value in the help, and what is shown here
PLAIN = {"<bool>": "", "<str>": "TEXT", "<list[str]>": "TEXT", "<path>": "PATH", "<list[Path]>": "PATH"}
PLAIN |= {"<int>": "INTEGER", "<int range>": "INTEGER", "<float>": "NUMBER", "<float range>": "NUMBER"}


class PlainHelp:
    """Help that names arguments as SCENE or RUN..., and the kinds of an option's values as PLAIN has them."""

    def get_params(self, ctx: Any) -> list[Any]:
        """The parameters with these names."""
        parameters: list[Any] = super().get_params(ctx)  # type: ignore[misc]
        for parameter in parameters:
            if parameter.param_type_name == "argument":
                name = (parameter.metavar or parameter.name).upper().removesuffix("...")
                name += "" if parameter.nargs == 1 else "..."
                shown = name if parameter.required else f"[{name}]"
                parameter.metavar = name
                parameter.display_type_rich = lambda ctx: None  # no type beside the name
                parameter._usage_display_name = lambda shown=shown: shown  # typer: {RUN...}...
            elif parameter.metavar is None and hasattr(parameter, "display_type"):
                parameter.metavar = PLAIN.get(parameter.display_type(ctx))
        return parameters


class Command(PlainHelp, TyperCommand):
    """One command."""


class Group(PlainHelp, TyperGroup):
    """All commands together."""


app = typer.Typer(
    name="pendpin",
    cls=Group,
    help="The 3D compound pendulum and chains of rods: simulate, cross-check, draw, animate.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)

INTERRUPTED = 130  # the status after Ctrl-C: 128 and the number of SIGINT
UsageError: Any = typer.BadParameter.__base__  # whatever is wrong with the command line itself


def main() -> None:
    """Run the command line: every foreseen fault ends in one line on stderr and exit status 1, wrong usage in 2."""
    prepare_streams()
    # Python's last search for cycles, as the process ends, finds nothing and takes 0.31 of the 2.33 s of processor of
    # `pendpin run` with its page and picture; frozen objects are left out of it.
    atexit.register(gc.freeze)
    warnings.simplefilter("ignore", Note)  # the commands print them as lines of their own
    try:
        status = app(prog_name="pendpin", standalone_mode=False)
        if status == INTERRUPTED:  # what newer typers make of Ctrl-C
            raise KeyboardInterrupt
        sys.stdout.flush()
        _leave(status or 0)
    except PendpinError as error:
        _fail(str(error), INTERRUPTED if isinstance(error, Interrupted) else 1)
    except UsageError as error:
        if len(sys.argv) < 2:
            sys.exit(2)  # the help has been printed
        known = {command.name or command.callback.__name__ for command in app.registered_commands if command.callback}
        command = error.ctx.command_path if error.ctx else " ".join(["pendpin", *known.intersection(sys.argv[1:2])])
        said = error.format_message().replace("Input should be", "it must be")  # as newer typers say it
        said = said if said.endswith("...") else said.removesuffix(".")
        _fail(f"{said}; see {command} --help", 2)
    except (KeyboardInterrupt, typer.Abort):
        _fail("stopped by the user", INTERRUPTED)
    except BrokenPipeError:  # the reader of our output is gone
        drop_output()
        sys.exit(1)
    except OSError as error:  # files that fail are InputErrors; this is the output, on a full disk or closed
        drop_output()
        _fail(f"{error.filename or 'the output cannot be written'}: {error.strerror or error}")
    except MemoryError:
        _fail("out of memory: ask for fewer samples or a smaller model")


def _fail(message: str, status: int = 1) -> None:
    try:
        sys.stdout.flush()
    except OSError:  # nobody takes what was printed
        drop_output()
    say(f"pendpin: {one_line(message)}")
    _leave(status)


def _leave(status: int) -> NoReturn:
    """End with a status, at once where --limit or Ctrl-C has left a thread in a compiler of LLVM, which cannot be stopped.

    Python would wait for that thread: 10 rods by taylor with --limit 4 then ended after 30 s, and end so after 8 s.
    """
    if any(thread.is_alive() for thread in abandoned):
        sys.stdout.flush()
        os._exit(status)
    sys.exit(status)


def _print_version(is_wanted: bool) -> None:
    if is_wanted:
        print(f"pendpin {VERSION}")
        raise typer.Exit


Version = Annotated[bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version.")]


@app.callback()
def options(version: Version = False) -> None:
    """The 3D compound pendulum and chains of rods: simulate, cross-check, draw, animate."""


COMMANDS = {  # in the order of the help
    "Simulate and show": (run, view, plot, new),
    "Check": (check, doctor, validate, hard),
    "Study": (cost, effects, modes, stability, section, bifurcation, sweep, map_),
    "Identify": (fit,),
    "Exchange": (urdf, reference, schema),
}
for panel, commands in COMMANDS.items():
    for command in commands:
        app.command(command.__name__.removesuffix("_"), cls=Command, rich_help_panel=panel)(command)

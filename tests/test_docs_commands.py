"""The reference's tables of commands say what each command's own help says."""

import re
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

from pendpin.cli.app import app

sys.path.append(str(Path(__file__).parents[1] / "docs" / "_extensions"))
pytest.importorskip("command_tables")
from command_tables import options_table, parameters

COMMANDS = {command.name or command.callback.__name__: command.callback for command in app.registered_commands}


@pytest.mark.parametrize("name", COMMANDS)
def test_the_table_has_every_option_of_the_help(name: str) -> None:
    """And no other; each has an anchor and says what it is for."""
    done = CliRunner().invoke(app, [name, "--help"], env={"COLUMNS": "300", "NO_COLOR": "1", "TERM": "dumb"})
    rows = list(parameters(COMMANDS[name]))
    helped = set(re.findall(r"^\W*(--[a-z][a-z-]*)", done.output, re.MULTILINE))
    assert helped == {word for row in rows for word in row.names if word.startswith("--")}
    assert all(row.meaning for row in rows)
    assert not re.search(r"^\W*\S+ +<|list\[|\}\.\.\.|Path", done.output, re.MULTILINE), "values in plain words"
    arguments = [row.names[0] for row in rows if not row.names[0].startswith("-")]
    taken = re.findall(rf"Usage: .* {name} \[OPTIONS\](.*)", done.output)
    assert re.findall(r"[A-Z]+", "".join(taken)) == arguments, "the usage line and the table name them alike"
    places = re.findall(r'id="([^"]+)"', options_table(COMMANDS[name]))
    assert len(places) == len(set(places)) == len(rows)

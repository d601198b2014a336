"""What a command takes, as a table: its arguments and options, each with an anchor (`run.html#option-duration`)."""

import inspect
import typing
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

from docstrings import escaped
from typer.models import ArgumentInfo, OptionInfo, ParameterInfo

VALUES = {str: "text", float: "number", int: "whole number", Path: "path", bool: ""}
HELP = "Show the command's help and end."


class Parameter(NamedTuple):
    """One row: how it is written, the kind of its value, its default and its meaning."""

    names: tuple[str, ...]
    value: str
    default: str
    meaning: str


def parameters(command: Callable[..., Any]) -> Iterator[Parameter]:
    """The arguments and options of a command in the order of its signature, and `--help`."""
    for parameter in inspect.signature(command, eval_str=True).parameters.values():
        said = [info for info in getattr(parameter.annotation, "__metadata__", ()) if isinstance(info, ParameterInfo)]
        if said and not said[0].hidden:
            yield _parameter(parameter.name, typing.get_args(parameter.annotation)[0], said[0], parameter.default)
    yield Parameter(("--help", "-h"), "", "", HELP)


def _parameter(name: str, kind: Any, info: ParameterInfo, default: Any) -> Parameter:
    types = [kind, *typing.get_args(kind), *(t for part in typing.get_args(kind) for t in typing.get_args(part))]
    is_option = isinstance(info, OptionInfo)
    kinds = [VALUES[t] for t in types if t in VALUES] or ["text"]
    value = info.metavar if is_option and info.metavar is not None else kinds[0]
    if info.min is not None:
        value += f", at least {info.min:,}"
    if info.max is not None:
        value += f", at most {info.max:,}"
    if any(typing.get_origin(t) is list for t in types):
        value += "; may be repeated" if is_option else "; one or several"
    names = (info.metavar or name.upper(),)
    if is_option:
        said = (info.default, *(info.param_decls or ()))  # in Annotated the first of the names stands for the default
        names = tuple(word for word in said if str(word).startswith("-")) or (f"--{name.replace('_', '-')}",)
    if default is inspect.Parameter.empty:
        shown = "required"
    else:
        shown = "" if default is None or default is False else f"``{default}``"
    return Parameter(names, escaped(value), shown, escaped(info.help or ""))


def usage(name: str, command: Callable[..., Any]) -> str:
    """One line: the command, and what it takes without a name."""
    words = []
    for parameter in inspect.signature(command, eval_str=True).parameters.values():
        hint = parameter.annotation
        for info in getattr(hint, "__metadata__", ()):
            if isinstance(info, ArgumentInfo):
                word = (info.metavar or parameter.name.upper()) + ("..." if "list[" in str(hint) else "")
                words.append(word if parameter.default is inspect.Parameter.empty else f"[{word}]")
    return " ".join(["$ pendpin", name, *words, "[OPTIONS]"])


def options_table(command: Callable[..., Any]) -> str:
    """The table in reStructuredText."""
    lines = [".. role:: anchor(raw)", "   :format: html", "", ".. list-table::", "   :header-rows: 1"]
    lines += ["   :widths: 22 20 12 46", "   :class: options", ""]
    lines += ["   * - option", "     - value", "     - default", "     - meaning"]
    for parameter in parameters(command):
        place = f"option-{parameter.names[0].lstrip('-').lower()}"
        code = ", ".join(f"<code>{name}</code>" for name in parameter.names)
        lines.append(f'   * - :anchor:`<a id="{place}" href="#{place}">{code}</a>`')
        lines += [f"     - {cell}".rstrip() for cell in parameter[1:]]
    return "\n".join(lines) + "\n"

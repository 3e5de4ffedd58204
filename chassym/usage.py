"""What typer finds wrong with the words of a command line, and what would be accepted, in one line."""

from __future__ import annotations

from typing import Any

import typer

# Typer depended on click and now brings its own copy along; this is the class of either.
UsageError: Any = typer.BadParameter.__bases__[0]
"""Raised for words that no command accepts."""


def explain(error: Any, program: Any) -> str:
    """One line about an error.

    Parameters
    ----------
    error
        A `UsageError`.
    program
        The group of all commands.
    """
    message = error.format_message().rstrip(".")
    if error.ctx is None:  # the parser does not know the command when it misses the value of an option
        options = [each for command in program.commands.values() for each in command.params]
        named = {_shown(each) for each in options if getattr(error, "option_name", None) in each.opts}
        return f"{message}; expected {', '.join(named)}"
    command = error.ctx.command
    accepted = getattr(command, "commands", None) or map(_shown, command.get_params(error.ctx))
    return f"{message}; {error.ctx.command_path} accepts {', '.join(accepted)}"


def _shown(parameter: Any) -> str:
    """An option with its value, an argument in brackets if it may be left out."""
    if parameter.param_type_name == "argument":
        return str(parameter.metavar if parameter.required else f"[{parameter.metavar}]")
    return " ".join(filter(None, ("/".join(parameter.opts), parameter.metavar)))

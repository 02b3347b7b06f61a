"""Errors of users: one line on standard error, and exit code 2."""

import sys
from pathlib import Path
from typing import Any, NoReturn

import typer
from typer.core import TyperGroup

from app.run_options import FORMER_OPTIONS
from app.terminal import Terminal
from config import UserError


def refuse(message: str) -> NoReturn:
    """Print a line on standard error and end with exit code 2."""
    Terminal(stderr=True).say(message)
    raise typer.Exit(UserError.exit_code)


class RefusingGroup(TyperGroup):
    """Commands whose user errors end as one line."""

    def invoke(self, ctx: Any) -> Any:
        """Run a command; a `UserError` is refused, and so is one without a needed argument."""
        try:
            return super().invoke(ctx)
        except Exception as error:
            told: Any = error
            kind = type(error).__name__  # of click, or of typer's copy of it
            if kind == "MissingParameter":
                what = told.param.opts[-1]
                what = what if what.startswith("-") else what.upper()
                refuse(f"{told.ctx.command_path}: {what} is missing: {told.param.help}")
            is_of_run = kind == "NoSuchOption" and told.ctx.info_name == "run"
            if is_of_run and (instead := FORMER_OPTIONS.get(told.option_name)):
                refuse(f"{told.option_name} is not an option any more; write {instead}")
            if not isinstance(error, UserError):
                raise
            refuse(str(error))
        finally:
            _warn_of_plugins()


def _warn_of_plugins() -> None:
    """Name the packages that could not be used, if this command looked at them."""
    if (language := sys.modules.get("trees.language")) is not None:
        for problem in language.plugin_problems():
            Terminal(stderr=True).say(f"warning: {problem}")


def find_tree(tree: str) -> Path:
    """The file of a task, by path or name; raises UnknownTreeError if there is none."""
    from trees import find

    return find(tree)


def task_parameters(values: list[str]) -> dict[str, str]:
    """Values of task parameters from texts `key=value`."""
    parameters = {}
    for value in values:
        key, equals, text = value.partition("=")
        if not equals or not key:
            refuse(f"-p {value}: a parameter is given as key=value, for example -p attempts=3")
        parameters[key] = text
    return parameters


def write(path: Path, text: str) -> None:
    """Write a file; one that cannot be written is refused."""
    try:
        path.write_text(text, encoding="utf-8")
    except OSError as error:
        refuse(f"{path}: cannot be written ({error.strerror}); name a file in a folder that exists")

"""The command line with what packages offer: entry points of the group `frankie_task.commands`.

Each is a function as typer takes them, or a `typer.Typer` with several.
"""

from functools import cache
from typing import Any

import typer
from typer.main import get_command

from app.commands.refuse import RefusingGroup
from app.terminal import Terminal
from config import DoorError, entries, find

GROUP = "frankie_task.commands"


class CommandLine(RefusingGroup):
    """The commands of the core, then those of packages, which are imported when they are asked for.

    A broken package takes only its own commands away; help names it in a warning.
    """

    def list_commands(self, ctx: Any) -> list[str]:
        """The names of the commands that help shows."""
        return super().list_commands(ctx) + [name for name in _offered_names() if _is_sound(name)]

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """A command by its name, None if there is none; DoorError: its package is broken."""
        own = super().get_command(ctx, cmd_name)
        return own or (_offered(cmd_name) if cmd_name in _offered_names() else None)


def _offered_names() -> list[str]:
    return sorted({entry.name for entry in entries(GROUP)})


def _is_sound(name: str) -> bool:
    try:
        _offered(name)
    except DoorError as error:
        Terminal(stderr=True).say(f"warning: {error}")
        return False
    return True


@cache
def _offered(name: str) -> Any:
    found: Any = find(GROUP, name, "command")
    if not isinstance(found, typer.Typer):
        one = typer.Typer(add_completion=False, rich_markup_mode=None)
        one.command(name)(found)
        found = one
    command = get_command(found)
    command.name = name
    return command

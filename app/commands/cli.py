"""Root of the command line; heavy imports are in functions, so that `--help` is quick.

Packages offer more commands: entry points of the group `frankie_task.commands`, each a function as
typer takes them, or a `typer.Typer` with several.
"""

import contextlib
import sys
from functools import cache
from pathlib import Path
from typing import Annotated, Any

import typer
from typer.main import get_command

from app.commands.authoring import authoring, dry
from app.commands.doctor import doctor, drivers
from app.commands.refuse import RefusingGroup, find_tree, refuse
from app.commands.review import explain, replay, runs, view
from app.commands.run_command import run
from app.terminal import Terminal
from config import DoorError, Severity, UserError, entries, find

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


app = typer.Typer(
    cls=CommandLine,
    add_completion=False,
    no_args_is_help=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    help="Taskable reactive mobile manipulation: a behaviour tree in YAML, a robot that does it.",
)

app.add_typer(authoring)
for command in (run, dry, runs, view, explain, replay, doctor, drivers):
    app.command()(command)


@app.command()
def check(
    trees: Annotated[
        list[str] | None,
        typer.Argument(help="Files of tasks or scenes, or names of shipped tasks."),
    ] = None,
    robot: Annotated[
        str, typer.Option(help="Who is to do it: `frankie`, `omni`, or a robot file.")
    ] = "frankie",
    places: Annotated[Path | None, typer.Option(help="Poses and regions of a site.")] = None,
    as_json: Annotated[
        bool, typer.Option("--json", help="Print the mistakes as a JSON list, with patches.")
    ] = False,
    explain: Annotated[
        str | None, typer.Option(help="Only explain a rule by its code, as R201.")
    ] = None,
) -> None:
    """Name every mistake in tasks and scenes; ends with exit code 2 if there is one."""
    from trees.site import check as mistakes_in

    console = Terminal()
    if explain is not None:
        from app.authoring import explained

        console.say(explained(explain))
        return
    if not trees:
        refuse("name a task, or a rule by --explain")
    paths, is_wrong = list(map(find_tree, trees)), False
    if as_json:
        import json

        from app.authoring import findings

        told = [one for path in paths for one in findings(path, robot, places)]
        typer.echo(json.dumps(told, indent=1))
        is_wrong = any(one["severity"] == Severity.ERROR.value for one in told)
    for path in [] if as_json else paths:
        mistakes = mistakes_in(path, robot=robot, places=places)
        for mistake in mistakes:
            console.say(f"{mistake} [{mistake.rule.code}]")
        if all(mistake.severity is Severity.WARNING for mistake in mistakes):
            console.say(f"{path}: good")
        else:
            is_wrong = True
    if is_wrong:
        raise typer.Exit(UserError.exit_code)


def main() -> None:
    """Entry point of `frankie-task`."""
    if sys.argv[1:2] == ["run"] and "--help" not in sys.argv:
        with contextlib.suppress(OSError):  # a closed terminal is reported at the end of the run
            print("frankie-task: loading", file=sys.stderr, flush=True)  # imports take seconds
    app()

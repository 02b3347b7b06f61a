"""Root of the command line; heavy imports are in functions, so that `--help` is quick."""

import contextlib
import gc
import sys
from pathlib import Path
from typing import Annotated

import typer
from typer.main import get_command_name, get_group

from app.commands.authoring import authoring, dry
from app.commands.doctor import doctor, drivers
from app.commands.offered_commands import CommandLine
from app.commands.refuse import find_tree, refuse
from app.commands.review import explain, replay, runs, view
from app.commands.run_command import run
from app.terminal import Terminal

app = typer.Typer(
    cls=CommandLine,
    add_completion=False,
    no_args_is_help=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    help="Taskable reactive mobile manipulation: a behaviour tree in YAML, a robot that does it.",
)

app.add_typer(authoring)
for command in (run, dry, runs, view, explain, replay):
    app.command()(command)
for about in (doctor, drivers):
    app.command()(about)


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
    from config import Severity, UserError
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


_SHORT = ("check", "draw", "nodes", "schema")


def main() -> None:
    """Entry point of `frankie-task`."""
    if sys.argv[1:2] and sys.argv[1] in _SHORT:
        gc.disable()
    if sys.argv[1:2] == ["run"] and "--help" not in sys.argv and not sys.stderr.isatty():
        with contextlib.suppress(OSError):  # a closed terminal is reported at the end of the run
            print("frankie-task: loading", file=sys.stderr, flush=True)  # imports take seconds
    get_group(_asked(*sys.argv[1:2]))()


def _asked(word: str = "") -> typer.Typer:
    """The command line with only the command that `word` calls, or all of it.

    To build a command takes milliseconds, and there are dozens.
    """
    commands = {
        info.name or get_command_name(info.callback.__name__): info
        for info in (*app.registered_commands, *authoring.registered_commands)
        if info.callback is not None
    }
    if word in commands:
        app.registered_commands, app.registered_groups = [commands[word]], []
    return app

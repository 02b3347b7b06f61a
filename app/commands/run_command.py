"""`frankie-task run`: its options and its output."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator
from dataclasses import MISSING, fields
from inspect import Parameter, Signature, signature
from pathlib import Path
from typing import IO, TYPE_CHECKING, Annotated, Any, get_args, get_origin

import typer

from app.choices import View
from app.commands.refuse import find_tree, task_parameters
from app.run_options import RunOptions
from app.terminal import Terminal

if TYPE_CHECKING:
    from app.core import Result


def finished(as_json: bool) -> Callable[[Result], str]:
    """A function that shows a result and returns its explanation, without the heading."""

    def show_and_explain(result: Result) -> str:
        from app.review import explain

        show_result(result, as_json)
        try:
            return str(explain(result.folder)).partition("\n\n")[2]
        except Exception as error:  # as when the disk is full
            return f"cannot be explained: {error}"

    return show_and_explain


def show_result(result: Result, as_json: bool) -> None:
    """Print a result for people and for programs."""
    for_people = Terminal(stderr=as_json)
    if as_json:
        _unless_closed(sys.stdout, lambda: print(result.summary.to_json(), flush=True))
    _unless_closed(for_people.file, lambda: result.summary.show(for_people))
    _unless_closed(for_people.file, lambda: for_people.say(_next(result)))


def _next(result: Result) -> str:
    """Where the run is, and the next command to try."""
    command, purpose = "explain", "says why"
    if result.summary.succeeded:
        command, purpose = "view --web", "shows it again"
    where = "" if result.folder.parent == Path("runs") else f" {result.folder}"
    return f"left in {result.folder}/\nnext: frankie-task {command}{where}   ({purpose})"


def say(text: str) -> None:
    """Print a line for the person at the terminal, if there is one."""
    terminal = Terminal(stderr=True)
    _unless_closed(terminal.file, lambda: terminal.say(text))


def _unless_closed(file: IO[str], write: Callable[[], object]) -> None:
    """Write; if nobody reads, discard output from now on."""
    try:
        write()
        file.flush()
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), file.fileno())


def run(
    *,
    as_json: Annotated[
        bool, typer.Option("--json", help="Print the summary as one JSON object.")
    ] = False,
    **options: Any,
) -> None:
    """Run a task; leaves a folder with a recording and a summary."""
    parameters, word = task_parameters(options.pop("parameters")), options.pop("tree")
    from app.core import End, run_task
    from hw import HardwareError

    chosen = RunOptions(tree=find_tree(word), parameters=parameters, shown=True, **options)
    try:
        result = run_task(chosen, finished=finished(as_json))
    except HardwareError as error:  # while connecting: a run that has begun ends with a summary
        say(str(error))
        raise typer.Exit(End.HARDWARE.exit_code) from None
    raise typer.Exit(result.outcome.end.exit_code)


_AS_WORDS = {"tree": str, "parameters": list[str]}  # what people write otherwise than programs


def _declared() -> Iterator[Parameter]:
    """The options of a run that people have, as typer takes them."""
    for one in fields(RunOptions):
        if get_origin(one.type) is not Annotated:
            continue
        kind, about = get_args(one.type)
        default = Parameter.empty if one.default is MISSING else one.default
        if one.default_factory is not MISSING:
            default = []
        if one.name == "view":
            default = View.AUTO  # people watch, programs do not
        kind = Annotated[_AS_WORDS.get(one.name, kind), about]
        yield Parameter(one.name, Parameter.KEYWORD_ONLY, default=default, annotation=kind)


_own = [one for one in signature(run, eval_str=True).parameters.values() if one.name != "options"]
run.__signature__ = Signature([*_declared(), *_own])  # type: ignore[attr-defined]

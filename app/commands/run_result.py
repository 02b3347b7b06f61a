"""What `frankie-task run` says when a run is over."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import IO, TYPE_CHECKING

from app.terminal import Terminal

if TYPE_CHECKING:
    from app.core import Result


def finished(as_json: bool) -> Callable[[Result], str]:
    """Shows a result, and explains it."""

    def told(result: Result) -> str:
        from app.review import explain

        show_result(result, as_json)
        try:
            return str(explain(result.folder))
        except Exception as error:  # as when the disk is full
            return f"cannot be explained: {error}"

    return told


def show_result(result: Result, as_json: bool) -> None:
    """What a run left, for people and for programs."""
    for_people = Terminal(stderr=as_json)
    if as_json:
        _unless_closed(sys.stdout, lambda: print(result.summary.to_json(), flush=True))
    _unless_closed(for_people.file, lambda: result.summary.show(for_people))
    _unless_closed(for_people.file, lambda: for_people.say(_next(result)))


def _next(result: Result) -> str:
    command, purpose = "explain", "says why"
    if result.summary.succeeded:
        command, purpose = "view --web", "shows it again"
    where = "" if result.folder.parent == Path("runs") else f" {result.folder}"
    return f"left in {result.folder}/\nnext: frankie-task {command}{where}   ({purpose})"


def say(text: str) -> None:
    """Say something to the person at the terminal, if there still is one."""
    terminal = Terminal(stderr=True)
    _unless_closed(terminal.file, lambda: terminal.say(text))


def _unless_closed(file: IO[str], write: Callable[[], object]) -> None:
    """Write; where nobody reads any more, be silent from now on: the exit code still tells."""
    try:
        write()
        file.flush()
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), file.fileno())

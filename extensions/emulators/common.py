"""Shared by all emulators: user errors, sockets, real-time priority, reported behaviours."""

import gc
import os
import socket
import subprocess
import sys
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple, TypeAlias

from config import UserError, suggest
from hw.system import run_at

Words: TypeAlias = Mapping[str, tuple[Callable[..., Any], str]]  # function and text by name


class Reported(NamedTuple):
    """Behaviour of a real machine that a public issue tracker reports."""

    what: str
    source: str


def reported(table: str) -> Mapping[str, Reported]:
    """The rows of a table, a line each: NAME | WHAT | SOURCE."""
    rows = [[cell.strip() for cell in line.split("|")] for line in table.strip().splitlines()]
    return {name: Reported(what, source) for name, what, source in rows}


def chosen(names: Sequence[str], table: Mapping[str, Reported], part: str) -> frozenset[str]:
    """The names as a set, each possibly several with commas; UserError: there is no such."""
    flat = [name.strip() for text in names for name in text.split(",") if name.strip()]
    for name in flat:
        if name not in table:
            hint = suggest(name, table)
            raise UserError(
                f"the emulated {part} has no reported behaviour called `{name}`; {hint}"
            )
    return frozenset(flat)


def act(words: Words, target: object, line: str) -> dict[str, Any]:
    """Do one command of a console to a target; its name and answer, or an error."""
    name, *arguments = line.split() or [""]
    if name not in words:
        return {"error": f"no such thing as `{name}`; {suggest(name, words)}"}
    try:
        return {"did": name, **(words[name][0](target, *arguments) or {})}
    except (TypeError, ValueError, KeyError) as error:
        return {"error": str(error)}


def set_options(options: object, values: Mapping[str, object]) -> None:
    """Set options by name; one of a part is named PART.NAME."""
    for name, value in values.items():
        target = options
        *parts, last = name.split(".")
        for part in parts:
            target = getattr(target, part)
        setattr(target, last, value)


def start_module(*words: str, memory: tuple[int, ...] = ()) -> subprocess.Popen[str]:
    """Run a module of ours in a process of its own, which Ctrl-C does not end."""
    return subprocess.Popen(
        [sys.executable, "-P", "-m", *words],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        pass_fds=memory,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
        start_new_session=True,
    )


def listen(host: str, port: int) -> socket.socket:
    """A listening socket."""
    try:
        return socket.create_server((host, port))
    except OSError as error:
        raise UserError(f"port {port} of {host}: {error.strerror}; choose another one") from error


def be_prompt(priority: int) -> None:
    """Ask for real-time priority, if it is granted, and keep the garbage collector short."""
    run_at(priority)
    gc.collect()
    gc.freeze()

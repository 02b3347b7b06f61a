"""`frankie-task emulate`: machines that are not there, for drivers to talk to."""

from __future__ import annotations

import sys
from contextlib import suppress
from typing import Annotated

import typer

from app.terminal import Terminal

app = typer.Typer(no_args_is_help=True, help="Servers that speak the protocols of real machines.")


@app.callback()
def emulate() -> None:
    """Servers that speak the protocols of real machines."""


@app.command()
def panda(
    host: Annotated[str, typer.Option(help="The address to listen on.")] = "127.0.0.1",
    version: Annotated[int, typer.Option(help="Of the research interface.", min=1)] = 5,
) -> None:
    """A Franka Panda with its hand, until Ctrl-C or the end of the input.

    Type words, and things happen to it; they are listed when it starts. The ports are those of the
    real one.
    """
    from hw.emulators.panda import ACTIONS, serve

    console = Terminal()
    for name, (_, what) in ACTIONS.items():
        console.say(f"{name}: {what}")
    with suppress(KeyboardInterrupt):
        serve(host, version=version, lines=sys.stdin, say=console.say)

"""`frankie-task serve` and `mcp`: tasks from a page, and from a language model."""

import signal
from contextlib import suppress
from pathlib import Path
from typing import Annotated

import typer

from app.choices import View
from app.terminal import Terminal, until_interrupted


def serve(
    folder: Annotated[Path, typer.Argument(help="With tasks; the shipped ones are there too.")] = (
        Path()
    ),
    armed: Annotated[
        bool, typer.Option("--arm-the-robot", help="A real robot moves only with this.")
    ] = False,
    view: Annotated[View, typer.Option(help="The 3-D viewer on the page: web or none.")] = View.WEB,
    port: Annotated[int | None, typer.Option(help="Of the page.", min=1, max=65535)] = None,
) -> None:
    """Serve one page that starts tasks, watches and stops them, and lists their runs."""
    from app.live import PageServer
    from app.serve import TaskDesk

    say = Terminal(stderr=True).say
    desk = TaskDesk(folder, armed=armed, view=view, say=say)
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    with PageServer(port, desk=desk) as server:
        desk.server = server
        with until_interrupted():
            say(f"tasks at {server.url}   (Ctrl-C ends it)")
        desk.close()


def mcp(
    folder: Annotated[
        Path,
        typer.Option(help="What the model reads and writes.", exists=True, file_okay=False),
    ] = Path(),
    port: Annotated[
        int | None, typer.Option(help="Serve HTTP here instead.", min=1, max=65535)
    ] = None,
) -> None:
    """Serve a language model by the Model Context Protocol, on standard input and output.

    It writes, checks and simulates tasks, and proposes them; it moves no real robot.
    """
    from app.agent import serve as serve_model

    with suppress(KeyboardInterrupt):
        serve_model(folder, port, Terminal(stderr=True).say)

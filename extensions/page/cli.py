"""`frankie-task serve` and `report`: pages of tasks and runs, and one of how a run ended."""

import signal
from pathlib import Path
from typing import Annotated

import typer

from app.choices import View
from app.commands import Run, Runs, said_losses, write
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
    from extensions.page.observer import require_server

    require_server()
    from extensions.page.desk import TaskDesk
    from extensions.page.server import PageServer

    say = Terminal(stderr=True).say
    desk = TaskDesk(folder, armed=armed, view=view, say=say)
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    with PageServer(port, desk=desk) as server:
        desk.server = server
        with until_interrupted():
            say(f"tasks at {server.url}   (Ctrl-C ends it)")
        desk.close()


def report(
    run: Run = "last",
    out: Annotated[Path, typer.Argument(help="The page to write.")] = Path("report.html"),
    runs: Runs = Path("runs"),
) -> None:
    """Write how a run ended as one page, with a map: what `explain` tells, to send and print."""
    from app.review import explain, find_run
    from extensions.page.explanation_page import explanation_page

    folder = find_run(run, runs)
    page = explanation_page(explain(folder))
    said_losses(folder)
    write(out, page)
    Terminal().say(f"{out}: written")

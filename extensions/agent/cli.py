"""`frankie-task mcp` and `ask`: tasks from a language model."""

import os
from contextlib import suppress
from pathlib import Path
from textwrap import indent
from typing import Annotated

import typer

from app.terminal import Terminal


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
    from extensions.agent.mcp_server import serve as serve_model

    with suppress(KeyboardInterrupt):
        serve_model(folder, port, Terminal(stderr=True).say)


def ask(
    request: Annotated[str, typer.Argument(help="What is to be done, in your words.")],
    model: Annotated[str, typer.Option(help="Its name at the endpoint.")],
    url: Annotated[str, typer.Option(help="Of an OpenAI-compatible endpoint.")] = (
        "http://127.0.0.1:8080/v1"
    ),
    key_variable: Annotated[
        str, typer.Option(help="The environment variable that has the key.")
    ] = "OPENAI_API_KEY",
    folder: Annotated[
        Path, typer.Option(help="What it may read and write.", exists=True, file_okay=False)
    ] = Path(),
    scene: Annotated[str, typer.Option(help="Where it is to be done, simulated.")] = "single",
    robot: Annotated[str, typer.Option(help="Whose description is used.")] = "frankie",
    rounds: Annotated[int, typer.Option(help="Of drafts, at most.", min=1, max=20)] = 4,
    patience: Annotated[float, typer.Option(help="For an answer [s].", min=1.0)] = 120.0,
) -> None:
    """Let a language model write a task, see it simulated, and say whether it is kept.

    It moves no real robot: you start what is kept. Exit code 1: no task is kept.
    """
    import asyncio

    from extensions.agent.ask import ask as ask_model
    from extensions.agent.ask import name_for
    from extensions.agent.endpoint import Endpoint
    from extensions.agent.tools import Tools
    from extensions.agent.workspace import Workspace

    endpoint = Endpoint(url, model, os.environ.get(key_variable, ""), patience)
    os.chdir(folder)
    tools, terminal, say = Tools(Workspace(Path())), Terminal(), Terminal(stderr=True).say
    done = ask_model(request, endpoint, tools, scene=scene, robot=robot, rounds=rounds, say=say)
    nearest = "\nThe nearest that can be done:" * bool(done.task)
    if done.failed:
        terminal.say(indent(done.failed, "  ").lstrip())
    elif done.cannot:
        terminal.say(f"It cannot be done: {' '.join(done.cannot.split())}{nearest}")
    if not done.task:
        raise typer.Exit(1)
    summary = done.summary or {}
    tried = asyncio.run(tools.dry(done.task))
    for told in (tools.draw(done.task), tried, tools.explain(done.run)):
        terminal.say(indent(told, "  "))  # so that no text of the task looks like a line of ours
    for name, on in summary["lies_on"].items():
        terminal.say(f"{name} lies on {on or 'nothing'}")
    terminal.say(f"frankie-task view --web {Path('runs', done.run)}   (shows it)")
    if not typer.confirm("Keep this task?", default=False):
        terminal.say("not kept")
        raise typer.Exit(1)
    terminal.say(tools.propose(name_for(request, Path()), done.task, request))

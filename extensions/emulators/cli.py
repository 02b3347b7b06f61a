"""`frankie-task emulate`: emulators of the machines that the drivers talk to."""

import sys
from collections.abc import Mapping
from contextlib import suppress
from importlib import import_module
from typing import Annotated, Any, TypeAlias

import typer

from app.terminal import Terminal, until_interrupted

app = typer.Typer(no_args_is_help=True, help="Servers that speak the protocols of real machines.")

AsReported: TypeAlias = Annotated[
    list[str] | None,
    typer.Option(
        "--as-reported",
        help="Ways of real ones, NAME,NAME; `list` names all, what they do, and who reported it.",
    ),
]


@app.command()
def omron(
    port: Annotated[int, typer.Option(help="Of ArNetworking; 0: any.", min=0, max=65535)] = 7272,
    arcl_port: Annotated[int, typer.Option(help="Of ARCL; 0: any.", min=0, max=65535)] = 7171,
    host: Annotated[str, typer.Option(help="The address to listen on.")] = "127.0.0.1",
    user: Annotated[str, typer.Option(help="Who may connect.")] = "frankie",
    password: Annotated[str, typer.Option(help="Of the user.")] = "",
    arcl_password: Annotated[str, typer.Option(help="Of ARCL; empty: no ARCL.")] = "adept",
    as_reported: AsReported = None,
) -> None:
    """An Omron LD-60 on an empty floor: ArNetworking and ARCL, until Ctrl-C."""
    from extensions.emulators.omron import EVERYTHING, OmronEmulator, Options

    console, ways = Terminal(), _ways("omron", as_reported)
    options = Options(
        host=host,
        port=port,
        arcl_port=arcl_port,
        users={user: (password, EVERYTHING)},
        arcl_password=arcl_password,
    )
    with OmronEmulator(options, **ways) as emulator, until_interrupted():
        console.say(f"ArNetworking at {host}:{emulator.port}, user {user}")
        if arcl_password:
            console.say(f"ARCL at {host}:{emulator.arcl_port}")


@app.command()
def panda(
    host: Annotated[str, typer.Option(help="The address to listen on.")] = "127.0.0.1",
    version: Annotated[int, typer.Option(help="Of the research interface.", min=1)] = 5,
    as_reported: AsReported = None,
) -> None:
    """A Franka Panda with its hand, until Ctrl-C or the end of the input.

    Type words, and things happen to it; they are listed when it starts. The ports are those of the
    real one.
    """
    from extensions.emulators.panda import ACTIONS, serve

    console, ways = Terminal(), _ways("panda", as_reported)
    _list(console, {name: what for name, (_, what) in ACTIONS.items()})
    with suppress(KeyboardInterrupt):
        serve(host, version=version, lines=sys.stdin, say=console.say, **ways)


@app.command()
def frankie(
    robot: Annotated[
        str, typer.Option(help="A robot file with `emulated`: addresses, accounts, site.")
    ] = "emulated",
    world: Annotated[
        str, typer.Option(help="What moves it: `kinematic` or `physics`.")
    ] = "kinematic",
    scene: Annotated[str, typer.Option(help="A shipped scene or a scene file.")] = "household",
    seed: Annotated[int, typer.Option(help="Of objects and camera noise.", min=0)] = 0,
    localisation: Annotated[
        str, typer.Option(help="How wrong it is about where it is: exact, good, poor, or a file.")
    ] = "good",
    as_reported: AsReported = None,
) -> None:
    """A whole Frankie in one simulated world, until Ctrl-C or the end of the input.

    Base, arm, hand and camera speak the protocols of the real ones. Type words, and things happen
    to it; they are listed when it starts.
    """
    from extensions.emulators.frankie import WORDS, FrankieEmulator, serve

    console, ways = Terminal(), _ways("frankie", as_reported)
    _list(console, {name: what for name, (_, what) in WORDS.items()})
    emulator = FrankieEmulator(
        robot, world=world, scene=scene, seed=seed, localisation=localisation, **ways
    )
    with suppress(KeyboardInterrupt):
        serve(emulator, lines=sys.stdin, say=console.say)


@app.command()
def realsense(
    port: Annotated[int, typer.Option(help="To listen on; 0: any.", min=0, max=65535)] = 7435,
    host: Annotated[str, typer.Option(help="The address to listen on.")] = "127.0.0.1",
    scene: Annotated[str, typer.Option(help="What it sees: a shipped scene or a file.")] = "single",
    seed: Annotated[int, typer.Option(help="Of the scene and the noise.")] = 0,
    as_reported: AsReported = None,
) -> None:
    """A RealSense D435 on a robot that stands in a scene, until Ctrl-C.

    It sends images to the driver, which feeds a software device of the vendor's library with them.
    """
    from extensions.emulators.realsense import Options, RealSenseEmulator, of_scene

    console, ways = Terminal(), _ways("realsense", as_reported)
    options, source = Options(host=host, port=port, seed=seed), of_scene(scene, seed)
    with RealSenseEmulator(source, options, **ways) as emulator, until_interrupted():
        console.say(f"RealSense at {emulator.address}, scene {scene}")


def _ways(part: str, names: list[str] | None) -> dict[str, Any]:
    """The argument for `--as-reported`; `list` prints all ways and ends."""
    if not names:
        return {}
    table = import_module(f"extensions.emulators.{part}").AS_REPORTED
    if "list" in names:
        _list(Terminal(), {name: f"{one.what} [{one.source}]" for name, one in table.items()})
        raise typer.Exit
    return {"as_reported": names}


def _list(console: Terminal, meanings: Mapping[str, str]) -> None:
    for name, what in meanings.items():
        console.say(f"{name}: {what}")

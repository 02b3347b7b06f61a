"""`frankie-task doctor`: checks installation, drivers and robot."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterable
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from app.commands.refuse import refuse
from app.terminal import Terminal

if TYPE_CHECKING:
    from hw.hardware import Finding
    from robots import Driver, RealRobot


def doctor(
    robot: Annotated[
        str | None, typer.Option(help="A robot file with hardware; without it the computer alone.")
    ] = None,
    write_site: Annotated[
        Path | None,
        typer.Option(help="Write the full-scale values that the base tells, for `full_scale`."),
    ] = None,
    armed: Annotated[
        bool, typer.Option("--arm-the-robot", help="In ROS 2: it moves a little, to see it rest.")
    ] = False,
    as_json: Annotated[bool, typer.Option("--json", help="A JSON object a line.")] = False,
) -> None:
    """Look at computer, drivers, robot; nothing moves unarmed. Ends with 3 if something is bad."""
    from app.core import End
    from hw import find_world
    from hw.hardware import examine
    from robots import load_real_robot

    console = Terminal(stderr=as_json)
    real = None if robot is None else load_real_robot(robot)
    if robot is not None and real is None:
        console.say(f"{robot}: it is described only, there is no `hardware` to look at")
    if real is None and write_site is not None:
        refuse("--write-site: add --robot FILE")
    is_emulated = real is not None and real.hardware.emulated is not None
    emulators: Any = find_world("emulated") if is_emulated else None
    with emulators.running(real) if emulators else nullcontext():
        bad = _tell(examine(real, armed=armed), console, as_json=as_json)
        if write_site is not None and real is not None:
            bad += not _write(real, write_site, console)
    if real is not None and real.hardware.emulated is None:
        console.say("docs/hardware.md lists what only the robot can settle")
    if bad:
        raise typer.Exit(End.HARDWARE.exit_code)


def drivers() -> None:
    """The drivers of the installed packages: kind, name, package, and options with defaults."""
    from robots import Driver, installed_drivers

    for one in installed_drivers():
        if isinstance(one, Driver):
            text = f"{one.kind:8} {one.name:12} {one.package:20} {_options(one)}"
            Terminal().say(text.rstrip())
        else:
            Terminal(stderr=True).say(f"warning: {one}")


def _options(driver: Driver) -> str:
    """Options of a driver; those without a default are required."""
    fields = {key: one for key, one in driver.options.model_fields.items() if key != "driver"}
    return ", ".join(
        key if one.is_required() else f"{key}={_short(one.default)}" for key, one in fields.items()
    )


def _short(default: object) -> str:
    from config.reader import StrictModel

    return "{...}" if isinstance(default, StrictModel) else repr(default)


def _tell(findings: Iterable[Finding], console: Terminal, *, as_json: bool) -> int:
    """Print findings as they come; returns the number of bad ones."""
    from hw.hardware import Verdict

    bad = 0
    for one in findings:
        bad += one.verdict is Verdict.BAD
        if as_json:
            row = {"about": one.about, "verdict": one.verdict.value, "text": one.text}
            sys.stdout.write(json.dumps(row) + "\n")
        else:
            console.say(f"{one.verdict.value:5} {one.about}: {one.text}")
    return bad


def _write(real: RealRobot, path: Path, console: Terminal) -> bool:
    from hw import HardwareError
    from hw.hardware import write_full_scale

    try:
        write_full_scale(real, path)
    except (HardwareError, OSError) as error:
        console.say(f"--write-site: {error}")
        return False
    console.say(f"write `full_scale: {path}` below `hardware.base` of {real.path.name}")
    return True

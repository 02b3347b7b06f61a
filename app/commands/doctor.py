"""`frankie-task doctor`: checks installation, drivers and robot.

Nothing moves, except the base with `--first-metre`, confirmed by a person.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from app.commands.refuse import refuse
from app.terminal import Terminal

if TYPE_CHECKING:
    from hw.hardware import Finding
    from robots import RealRobot


def doctor(
    robot: Annotated[
        str | None, typer.Option(help="A robot file with hardware; without it the computer alone.")
    ] = None,
    write_site: Annotated[
        Path | None,
        typer.Option(help="Write the full-scale values that the base tells, for `full_scale`."),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="A JSON object a line.")] = False,
    first_metre: Annotated[
        bool,
        typer.Option(
            "--first-metre",
            help="Then drive the base a metre, slowly, confirmed by you: told against measured "
            "speed. With --arm-the-robot only.",
        ),
    ] = False,
    arm_the_robot: Annotated[
        bool, typer.Option("--arm-the-robot", help="The base may move (--first-metre).")
    ] = False,
) -> None:
    """Look at computer, drivers and robot. Ends with 3 if something is bad.

    Nothing moves without --first-metre.
    """
    from app.core import End
    from hw.hardware import check_armed, emulating, examine
    from robots import load_real_robot

    console = Terminal(stderr=as_json)
    real = None if robot is None else load_real_robot(robot)
    if robot is not None and real is None:
        console.say(f"{robot}: it is described only, there is no `hardware` to look at")
    if real is None and (write_site is not None or first_metre):
        refuse(f"{'--first-metre' if first_metre else '--write-site'}: add --robot FILE")
    if first_metre and real is not None:
        check_armed(real, arm_the_robot)
        if real.hardware.emulated is None and not sys.stdin.isatty():
            refuse("--first-metre: a person confirms each step at a terminal, and this is none")
    with emulating(real):
        bad = _tell(examine(real), console, as_json=as_json)
        if first_metre and real is not None:
            bad += _drive(real, console, as_json=as_json)
        if write_site is not None and real is not None:
            bad += not _write(real, write_site, console)
    if real is not None and real.hardware.emulated is None:
        console.say("docs/hardware.md lists what only the robot can settle")
    if bad:
        raise typer.Exit(End.HARDWARE.exit_code)


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


def _drive(real: RealRobot, console: Terminal, *, as_json: bool) -> int:
    """The first metre: the number of bad findings."""
    from hw import HardwareError
    from hw.hardware import first_metre

    try:
        return _tell(first_metre(real, armed=True, confirm=_confirm), console, as_json=as_json)
    except HardwareError as error:
        console.say(f"--first-metre: {error}")
        return 1


def _confirm(question: str) -> bool:
    return typer.confirm(question, default=False, err=True)


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

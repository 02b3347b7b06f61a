"""`frankie-task doctor`: what is installed, reachable and calibrated; nothing moves."""

from __future__ import annotations

import json
import sys
from typing import Annotated

import typer

from app.terminal import Terminal


def doctor(
    robot: Annotated[
        str | None, typer.Option(help="A robot file with hardware; without it the computer alone.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="A JSON object a line.")] = False,
) -> None:
    """Look at computer, drivers and robot; nothing moves. Ends with 3 if something is bad."""
    from app.core import End
    from hw.hardware import UNSETTLED, Verdict, emulating, examine
    from robots import load_real_robot

    console, bad = Terminal(stderr=as_json), 0
    real = None if robot is None else load_real_robot(robot)
    if robot is not None and real is None:
        console.say(f"{robot}: it is described only, there is no `hardware` to look at")
    with emulating(real):
        for one in examine(real):
            bad += one.verdict is Verdict.BAD
            if as_json:
                told = {"about": one.about, "verdict": one.verdict.value, "text": one.text}
                sys.stdout.write(json.dumps(told) + "\n")
            else:
                console.say(f"{one.verdict.value:5} {one.about}: {one.text}")
    if real is not None and real.hardware.emulated is None:
        console.say("what only the robot can settle:")
        for what, how in UNSETTLED:
            console.say(f"  {what}: {how}")
    if bad:
        raise typer.Exit(End.HARDWARE.exit_code)

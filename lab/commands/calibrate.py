"""`frankie-task calibrate`: camera on the hand, arm on the base, and how late a robot follows."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from app.commands import Run, Runs, refuse
from app.terminal import Terminal

if TYPE_CHECKING:
    from pinocchio import SE3

    from lab.calibration import Board, Calibration
    from robots import RealRobot

app = typer.Typer(
    no_args_is_help=True,
    help="Find out where camera and arm are mounted, and how late the robot follows.",
)

_HARDWARE_FAULT = 3

RobotName = Annotated[str, typer.Option("--robot", help="The file of a real robot.")]
Simulate = Annotated[
    bool, typer.Option("--simulate", help="On rendered images; tells how wrong the result is.")
]
Columns = Annotated[int, typer.Option(help="Squares along the board.", min=3, max=10)]
Rows = Annotated[int, typer.Option(help="Squares across the board.", min=3, max=10)]
Square = Annotated[float, typer.Option(help="Edge of a square, as measured [mm].", min=5.0)]
Seed = Annotated[int, typer.Option(help="Of the postures and of what is simulated.", min=0)]


@app.command()
def board(
    out: Annotated[Path, typer.Argument(help="The picture to write (.png).")] = Path("board.png"),
    columns: Columns = 7,
    rows: Rows = 5,
    square: Square = 40.0,
) -> None:
    """Draw the board to print, at 300 dpi without scaling."""
    import cv2

    picture = _board(columns, rows, square).picture(round(square / 25.4 * 300.0))
    if not out.parent.is_dir() or out.suffix != ".png" or not cv2.imwrite(str(out), picture):
        refuse(f"{out}: cannot be written; give the name of a .png in a folder that exists")
    typer.echo(
        f"{out}: {columns * square:g} x {rows * square:g} mm at 300 dpi. Glue it on something "
        "flat, measure a square, and give that as --square."
    )


@app.command("hand-eye")
def hand_eye(
    robot: RobotName = "frankie",
    simulate: Simulate = False,
    arm_the_robot: Annotated[
        bool, typer.Option("--arm-the-robot", help="The arm may move: nothing is in its way.")
    ] = False,
    out: Annotated[Path, typer.Option(help="The file to write.")] = Path("hand_eye.yaml"),
    views: Annotated[int, typer.Option(help="Images to take.", min=13, max=200)] = 30,
    columns: Columns = 7,
    rows: Rows = 5,
    square: Square = 40.0,
    seed: Seed = 0,
) -> None:
    """Where the camera is on the hand: the arm looks at a board that lies still, from many sides.

    Begin with the hand about 0.4 m above the middle of the board, camera down. Joints then move by
    up to 0.9 rad from there, slowly; of obstacles only the board itself is known.
    """
    import numpy as np

    from lab import calibration as lab
    from robots import load_robot

    description, one = load_robot(robot), _board(columns, rows, square)
    rng, say = np.random.default_rng(seed), Terminal().say
    if simulate:
        rig = lab.SimulatedArm(description, one, lab.Noise(), rng)
        found = lab.calibrate_hand_eye(rig, description, one, views, rng)
        _accept(found, out, truth=rig.eTc)
        return
    with _faults_told(), lab.live_arm(_real(robot), armed=arm_the_robot) as live:
        found = lab.calibrate_hand_eye(live, description, one, views, rng, say)
    _accept(found, out)


@app.command("base-arm")
def base_arm(
    robot: RobotName = "frankie",
    simulate: Simulate = False,
    thickness: Annotated[float, typer.Option(help="Of the board [mm].", min=0.0)] = 0.0,
    out: Annotated[Path, typer.Option(help="The file to write.")] = Path("base_arm.yaml"),
    views: Annotated[int, typer.Option(help="Images to take.", min=13, max=200)] = 30,
    columns: Columns = 7,
    rows: Rows = 5,
    square: Square = 40.0,
    seed: Seed = 0,
) -> None:
    """Where the arm is on the base: a board lies on the floor, a person drives the base around it.

    The arm rests, the camera about 0.4 m above the floor, looking down. Stop so that the board is
    now here, now there in the image, and the base always turned differently. Do `hand-eye` first.
    """
    import numpy as np

    from lab import calibration as lab
    from robots import load_robot

    description, one = load_robot(robot), _board(columns, rows, square)
    say = Terminal().say
    if simulate:
        rng = np.random.default_rng(seed)
        rig = lab.SimulatedBase(description, one, lab.Noise(), rng, views)
        _accept(lab.calibrate_base_arm(rig, description, one), out, truth=rig.bTa)
        return
    remaining = views

    def ask() -> bool:
        nonlocal remaining
        if remaining == 0:
            return False
        remaining -= 1
        say(f"drive on, until the board is in view elsewhere, and stand; at most {remaining} more")
        say("Enter: take an image. End of input (Ctrl-D): the last one was enough.")
        return bool(sys.stdin.readline())

    with _faults_told(), lab.live_base(_real(robot), ask) as live:
        found = lab.calibrate_base_arm(live, description, one, 1e-3 * thickness, say)
    _accept(found, out)


@app.command()
def delays(run: Run = "last", runs: Runs = Path("runs")) -> None:
    """Measure how late a robot followed its commands in a run."""
    import numpy as np

    from app.review import find_run
    from lab.calibration import delays as measured

    console, found = Terminal(), measured(find_run(run, runs))
    for one in found:
        console.say(str(one))
    for key, part in (("base_lag", "base"), ("arm_lag", "joint")):
        if totals := [one.total for one in found if one.axis.startswith(part)]:
            console.say(f"{key}: {np.median(totals):.2f}")


def _real(robot: str) -> RealRobot:
    from robots import load_real_robot

    if (real := load_real_robot(robot)) is None:
        refuse(f"`{robot}` is a description: give the file of a real robot, or --simulate")
    return real


def _board(columns: int, rows: int, square: float) -> Board:
    from lab.calibration import Board

    edge = 1e-3 * square
    return Board(columns, rows, edge, 0.75 * edge)


def _accept(found: Calibration, out: Path, truth: SE3 | None = None) -> None:
    """Print a result; write it if it is good, refuse it if not."""
    from lab.calibration import difference

    for line in found.lines():
        typer.echo(line)
    if truth is not None:
        wrong = difference(found.transform, truth)
        typer.echo(f"wrong by {wrong.mm:.3f} mm and {wrong.deg:.4f} deg")
    found.require_good()
    found.write(out, "frankie-task calibrate")
    typer.echo(
        f"{out} written; in the robot file: `{found.key}: {out.name}`, with it in one folder"
    )


@contextmanager
def _faults_told() -> Iterator[None]:
    """End the command in one line at a hardware fault."""
    from hw import HardwareError

    try:
        yield
    except HardwareError as error:
        Terminal(stderr=True).say(str(error))
        raise typer.Exit(_HARDWARE_FAULT) from error

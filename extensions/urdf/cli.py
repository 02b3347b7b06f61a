"""`frankie-task robot`: robot files from URDFs, what is missing in them, and how they look."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from app.commands import RefusingGroup, find_tree, refuse
from app.terminal import Terminal

if TYPE_CHECKING:
    from robots import RobotDescription

app = typer.Typer(
    cls=RefusingGroup, no_args_is_help=True, help="Robot files: import from a URDF, check, show."
)

_Folder = Annotated[str, typer.Argument(help="A robot file, its folder, or a shipped robot.")]


@app.command("import")
def import_(
    urdf: Annotated[Path, typer.Argument(help="A URDF, or a .xacro file.")],
    arguments: Annotated[
        list[str] | None, typer.Argument(metavar="[NAME:=VALUE]...", help="Of a .xacro file.")
    ] = None,
    *,
    out: Annotated[Path, typer.Option("-o", "--out", help="New folder of the robot.")],
    srdf: Annotated[Path | None, typer.Option(help="MoveIt's file with arm and pairs.")] = None,
    base_frame: Annotated[str | None, typer.Option(help="Link below the arm.")] = None,
    tool_frame: Annotated[str | None, typer.Option(help="Link at the end of the arm.")] = None,
    drive: Annotated[
        str | None, typer.Option(help="`differential`, `omni`, or `none`: it stands still.")
    ] = None,
    gripper: Annotated[
        str | None, typer.Option(help="A part on the tool frame, for example `franka_hand`.")
    ] = None,
    approach: Annotated[
        str | None, typer.Option(help="Axis of the tool frame that points ahead: `x`, `-z` ...")
    ] = None,
    closing: Annotated[str | None, typer.Option(help="Axis along which fingers close.")] = None,
    camera_frame: Annotated[str | None, typer.Option(help="Link of the camera.")] = None,
    acceleration: Annotated[
        float | None, typer.Option(min=0.1, help="Of the joints [rad/s^2].")
    ] = None,
    base_size: Annotated[
        tuple[float, float, float] | None, typer.Option(help="Length, width, height [m].")
    ] = None,
    packages: Annotated[
        list[Path] | None, typer.Option(help="A folder with packages of meshes; repeatable.")
    ] = None,
) -> None:
    """Write a robot file from a URDF, and tell what was guessed and which option changes it."""
    from controller import bank
    from extensions.urdf.importing import ImportOptions, write_robot
    from robots import SHIPPED, load_robot

    axes = [f"{sign}{axis}" for axis in "xyz" for sign in ("", "-")]
    choices = {"--drive": (drive, ["differential", "omni", "none"])}
    choices |= {"--approach": (approach, axes), "--closing": (closing, axes)}
    parts = sorted(path.stem for path in (SHIPPED / "parts").glob("*hand*.yaml"))
    choices["--gripper"] = gripper, parts
    for option, (given, known) in choices.items():
        if given is not None and given not in known:
            refuse(f"{option} {given}: choose one of {', '.join(known)}")
    if wrong := [one for one in arguments or () if not one.partition(":=")[0] or ":=" not in one]:
        refuse(f"argument `{wrong[0]}`: write name:=value")
    options = ImportOptions(
        srdf=srdf,
        base_frame=base_frame,
        tool_frame=tool_frame,
        drive=drive,
        gripper=gripper,
        approach=approach,
        closing=closing,
        camera_frame=camera_frame,
        acceleration=acceleration,
        base_size=base_size,
        packages=packages or (),
        arguments=arguments or (),
    )
    console = Terminal()
    with Terminal(stderr=True).status(f"importing the shapes of {urdf.name} ..."):
        notes = write_robot(urdf, out, options)
    for line in notes:
        console.say(line)
    with Terminal(stderr=True).status("drawing postures ..."):  # here, not in the first run
        postures = bank(made := load_robot(out))
    console.say(f"dexterity: {_dexterity(made)}")
    console.say(f"gripper, for tasks that grasp: {_grasping(made, out)}")
    console.say(f"{out}: written, {len(postures.q)} postures drawn; next: frankie-task robot check")


@app.command()
def check(folder: _Folder) -> None:
    """Say what a robot can do, and what is missing for the rest."""
    from config import counted
    from controller import bank
    from robots import load_real_robot, load_robot

    console, robot = Terminal(), load_robot(folder)
    count = len(bank(robot).q)
    console.say(f"{robot.name}: {counted(len(robot.arm.joints), 'joint')}, {count} postures")
    console.say(f"dexterity: {_dexterity(robot)}")
    console.say("kinematic world: good")
    console.say(f"physical world: {_physics(robot) or 'good'}")
    console.say(f"gripper, for tasks that grasp: {_grasping(robot, folder)}")
    real = load_real_robot(folder)
    hardware = "a file with `hardware` that names this one is missing: docs/hardware.md"
    console.say(f"hardware: {hardware if real is None else 'see frankie-task doctor'}")


def _dexterity(robot: RobotDescription) -> str:
    """Of what it is, and what no posture has."""
    from controller import dexterity

    found = dexterity(robot)
    ways = ["along x", "along y", "turning"]
    base = [ways[int(robot.base.axes[:, one].argmax())] for one in found.base]
    of = f"of the arm and its base {' and '.join(base)}" if base else "of the arm"
    lacks = (
        "" if found.rank == 6 else f", in {found.rank} of 6 directions: some poses cannot be had"
    )
    return of + lacks


def _grasping(robot: RobotDescription, folder: str | Path) -> str:
    """Whether it can do what the shipped tasks ask of a gripper, or why not."""
    from config import Severity
    from hw.sim.objects import HOUSEHOLD
    from trees.site import check as mistakes_in

    thinnest = min(one.narrowest for one in HOUSEHOLD.values())
    if not robot.gripper.grasps:
        return "none: import it with --gripper"
    if robot.gripper.opening <= thinnest:
        wide, thin = 1e3 * robot.gripper.opening, 1e3 * thinnest
        return f"opens by {wide:.0f} mm, and the thinnest of the shipped objects is {thin:.0f} mm"
    found = mistakes_in(find_tree("pick_one"), robot=folder)
    wrong = [one for one in found if one.severity is Severity.ERROR]
    return f"not for `pick_one`: {wrong[0].message}; {wrong[0].hint}" if wrong else "good"


def _physics(robot: RobotDescription) -> str:
    """Why it cannot be in the physical world; empty if it can."""
    return "" if robot.arm.inertias else "the URDF has no inertia for every link"


@app.command()
def show(
    folder: _Folder,
    save: Annotated[Path | None, typer.Option(help="Write a .rrd file instead.")] = None,
) -> None:
    """Draw a robot as the controller sees it, in its ready posture."""
    from app.live import draw_robot
    from robots import load_robot

    draw_robot(load_robot(folder), save)

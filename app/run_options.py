"""Options of a run, each declared once: for programs, and for the command line.

Who has metadata of typer is an option of `frankie-task run`.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

from typer import Argument, Option

from app.choices import ObstacleSource, RegistrationForm, Speed, View

DEFAULT_SCENE = "household"

FORMER_OPTIONS = {
    "--view-host": "--view-address HOST",
    "--view-port": "--view-address HOST:PORT",
    "--web-port": "--view-address HOST:PORT",
    "--force-outcomes": "--approve, with which people may answer for a node on the page",
}
"""What to write instead of options that were removed."""


@dataclass(frozen=True, kw_only=True)
class RunOptions:
    """Options of a run."""

    tree: Annotated[Path, Argument(help="A task file, or the name of a shipped task.")]
    robot: Annotated[str, Option(help="Who does it: `frankie`, `omni`, or a robot file.")] = (
        "frankie"
    )
    world: Annotated[
        str,
        Option(
            help="What moves the robot: `kinematic`, `physics`, or what a package offers, as NAME "
            "or NAME:ARGUMENT; another word lists all."
        ),
    ] = "kinematic"
    armed: Annotated[bool, Option("--arm-the-robot", help="A real robot moves only with this.")] = (
        False
    )
    scene: Annotated[
        str | None,
        Option(help="A shipped scene or a scene file; default: what the task names."),
    ] = None
    localisation: Annotated[
        str | None,
        Option(
            help="How wrong a simulated robot is about where it is: exact, good (default), poor, "
            "or a file."
        ),
    ] = None
    registration: Annotated[
        RegistrationForm,
        Option(help="What is matched to the map to correct that: both, laser, camera, none."),
    ] = RegistrationForm.BOTH
    seed: Annotated[int, Option(help="Of objects and camera noise.", min=0)] = 0
    parameters: Annotated[
        Mapping[str, str], Option("--parameter", "-p", help="A task parameter, key=value.")
    ] = field(default_factory=dict)
    places: Annotated[
        Path | None,
        Option(help="A file with poses and regions of a site, instead of the task's own."),
    ] = None
    speed: Annotated[Speed, Option(help="Pace of simulated time.")] = Speed.MAX
    record: Annotated[Path, Option(help="Folder for the folders of runs.")] = Path("runs")
    replayable: Annotated[
        bool, Option("--replayable", help="Keep the camera's images too, for `replay`.")
    ] = False
    weights: Annotated[Path | None, Option(help="A file of weights of GG-CNN.")] = None
    obstacles: Annotated[
        ObstacleSource,
        Option(
            help="What tells what must not be hit: the map of what stands around, the points "
            "that the camera has seen, or both."
        ),
    ] = ObstacleSource.MAP
    map: Annotated[
        Path | None,
        Option(
            help="A scene file that says what stands around the robot; "
            "default: what a simulated world knows.",
        ),
    ] = None
    view: Annotated[
        View, Option(help="Watch in a window, in a browser, or not; auto: a window if possible.")
    ] = View.NONE
    view_address: Annotated[
        str,
        Option(
            help="Where to serve viewers, HOST or HOST:PORT, without a password; the live data of "
            "`--view web` is at the port after that."
        ),
    ] = "127.0.0.1"
    observers: Annotated[
        list[str],
        Option(
            "--with",
            help="Who else is told of the run, as `page`, where people pause, step and stop it, or "
            "`foxglove:8765`; another word lists what is installed.",
        ),
    ] = field(default_factory=list)
    approve: Annotated[
        bool,
        Option(
            "--approve",
            help="Each leaf that moves the robot waits for a person; on the page people may answer "
            "for any node.",
        ),
    ] = False
    paused: Annotated[bool, Option("--paused", help="Wait before the first tick.")] = False
    breaks: Annotated[
        list[str], Option("--break", help="Pause before this node: its name, key or path.")
    ] = field(default_factory=list)

    base_speed: float | None = None  # speed limit [m/s]; None for that of its description
    reverse_speed: float | None = None  # the same backwards [m/s]; None for the same share
    real_clock: bool = False  # a simulated robot that does not wait for its loop, as a real one
    acknowledge_after: float | None = None
    """For tests without a person: acknowledge and resume this long after the cause is over [s]."""
    shown: bool = False  # whether the terminal shows the tree
    recording: bool = True  # whether the motion is recorded for the viewer

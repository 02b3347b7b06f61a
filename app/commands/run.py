"""`frankie-task run`: its options and its output."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import IO, TYPE_CHECKING, Annotated

import typer

from app.choices import MotionForm, ObstacleSource, RegistrationForm, Speed, View
from app.commands.refuse import find_tree, refuse, task_parameters
from app.terminal import Loading, Terminal

if TYPE_CHECKING:
    from app.core import Result


def finished(as_json: bool) -> Callable[[Result], str]:
    """A function that shows a result and returns its explanation, without the heading."""

    def show_and_explain(result: Result) -> str:
        from app.review import explain

        show_result(result, as_json)
        try:
            return str(explain(result.folder)).partition("\n\n")[2]
        except Exception as error:  # as when the disk is full
            return f"cannot be explained: {error}"

    return show_and_explain


def show_result(result: Result, as_json: bool) -> None:
    """Print a result for people and for programs."""
    for_people = Terminal(stderr=as_json)
    if as_json:
        _unless_closed(sys.stdout, lambda: print(result.summary.to_json(), flush=True))
    _unless_closed(for_people.file, lambda: result.summary.show(for_people))
    _unless_closed(for_people.file, lambda: for_people.say(_next(result)))


def _next(result: Result) -> str:
    """Where the run is, and the next command to try."""
    command, purpose = "explain", "says why"
    if result.summary.succeeded:
        command, purpose = "view --web", "shows it again"
    where = "" if result.folder.parent == Path("runs") else f" {result.folder}"
    return f"left in {result.folder}/\nnext: frankie-task {command}{where}   ({purpose})"


def say(text: str) -> None:
    """Print a line for the person at the terminal, if there is one."""
    terminal = Terminal(stderr=True)
    _unless_closed(terminal.file, lambda: terminal.say(text))


def _unless_closed(file: IO[str], write: Callable[[], object]) -> None:
    """Write; if nobody reads, discard output from now on."""
    try:
        write()
        file.flush()
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), file.fileno())


def run(
    tree: Annotated[str, typer.Argument(help="A task file, or the name of a shipped task.")],
    robot: Annotated[
        str, typer.Option(help="Who does it: `frankie`, `omni`, or a robot file.")
    ] = "frankie",
    world: Annotated[
        str, typer.Option(help="What moves the robot: `kinematic` or `physics`.")
    ] = "kinematic",
    armed: Annotated[
        bool, typer.Option("--arm-the-robot", help="A real robot moves only with this.")
    ] = False,
    scene: Annotated[
        str | None,
        typer.Option(help="A shipped scene or a scene file; default: what the task names."),
    ] = None,
    localisation: Annotated[
        str | None,
        typer.Option(
            help="How wrong a simulated robot is about where it is: exact, good (default), poor, "
            "or a file."
        ),
    ] = None,
    registration: Annotated[
        RegistrationForm,
        typer.Option(help="What is matched to the map to correct that: both, laser, camera, none."),
    ] = RegistrationForm.BOTH,
    seed: Annotated[int, typer.Option(help="Of objects and camera noise.", min=0)] = 0,
    parameter: Annotated[
        list[str] | None, typer.Option("--parameter", "-p", help="A task parameter, key=value.")
    ] = None,
    places: Annotated[
        Path | None,
        typer.Option(help="A file with poses and regions of a site, instead of the task's own."),
    ] = None,
    speed: Annotated[Speed, typer.Option(help="Pace of simulated time.")] = Speed.MAX,
    record: Annotated[Path, typer.Option(help="Folder for the folders of runs.")] = Path("runs"),
    replayable: Annotated[
        bool, typer.Option("--replayable", help="Keep the camera's images too, for `replay`.")
    ] = False,
    weights: Annotated[Path | None, typer.Option(help="A file of weights of GG-CNN.")] = None,
    motion: Annotated[
        MotionForm,
        typer.Option(help="Base and arm as one, or base first and the arm by plans: the baseline."),
    ] = MotionForm.HOLISTIC,
    planning_time: Annotated[
        float, typer.Option(help="With --motion planning: stand so long for each plan [s].", min=0)
    ] = 0.05,
    obstacles: Annotated[
        ObstacleSource,
        typer.Option(
            help="What tells what must not be hit: the map of what stands around, the points "
            "that the camera has seen, or both."
        ),
    ] = ObstacleSource.MAP,
    site: Annotated[
        Path | None,
        typer.Option(
            "--map",
            help="A scene file that says what stands around the robot; "
            "default: what a simulated world knows.",
        ),
    ] = None,
    view: Annotated[
        View,
        typer.Option(
            help="Watch in a window, in a browser, in Foxglove, or not; auto: a window if possible."
        ),
    ] = View.AUTO,
    view_host: Annotated[
        str, typer.Option(help="Address to serve viewers on; there is no password.")
    ] = "127.0.0.1",
    view_port: Annotated[
        int | None, typer.Option(help="Of the live data.", min=1, max=65535)
    ] = None,
    web_port: Annotated[
        int | None, typer.Option(help="Of the page of --view web.", min=1, max=65535)
    ] = None,
    ros2: Annotated[
        bool, typer.Option("--ros2", help="Publish the run as ROS 2 topics on this computer.")
    ] = False,
    control: Annotated[
        bool, typer.Option("--control", help="Serve a page that pauses, steps and stops the run.")
    ] = False,
    control_port: Annotated[
        int | None, typer.Option(help="Of the page of --control.", min=1, max=65535)
    ] = None,
    control_pipe: Annotated[int | None, typer.Option(hidden=True)] = None,
    force: Annotated[
        bool, typer.Option("--force-outcomes", help="Let the page of --control answer for a node.")
    ] = False,
    approve: Annotated[
        bool, typer.Option("--approve", help="Each leaf that moves the robot waits for a person.")
    ] = False,
    paused: Annotated[bool, typer.Option("--paused", help="Wait before the first tick.")] = False,
    stop_before: Annotated[
        list[str] | None,
        typer.Option("--break", help="Pause before this node: its name, key or path."),
    ] = None,
    acknowledge_after: Annotated[
        float | None,
        typer.Option(
            help="For unattended tests: acknowledge and resume by itself after this [s].", min=0.0
        ),
    ] = None,
    groot2: Annotated[
        bool, typer.Option("--groot2", help="Serve Groot2, the tree editor.")
    ] = False,
    groot2_port: Annotated[
        int, typer.Option(help="Of --groot2; the next one is taken too.", min=1, max=65534)
    ] = 1667,
    fault: Annotated[
        list[str] | None,
        typer.Option(help="A fault, as reflex@12.5 or `frames lost@approach for 2`."),
    ] = None,
    as_json: Annotated[
        bool, typer.Option("--json", help="Print the summary as one JSON object.")
    ] = False,
) -> None:
    """Run a task; leaves a folder with a recording and a summary."""
    parameters = task_parameters(parameter or [])
    with Loading(f"{Path(tree).stem} on {Path(robot).stem}") as loading:
        from app.core import End, RunOptions, parse_fault, run_task
        from app.live import ControlOptions, ViewOptions
        from hw import HardwareError
        from robots import load_real_robot

        real = load_real_robot(robot)
        if ros2 and real and "ros2" in (real.hardware.base.driver, real.hardware.arm.driver):
            refuse("--ros2: this robot tells such topics itself, and would be heard twice")
        paced = speed is Speed.REAL or real is not None
        if paced and motion is MotionForm.PLANNING:
            refuse("--motion planning: plans are made within a tick, for simulation at --speed max")
        options = RunOptions(
            tree=find_tree(tree),
            robot=robot,
            world=world,
            armed=armed,
            motion=motion,
            planning_time=planning_time,
            obstacles=obstacles,
            map=site,
            scene=scene,
            localisation=localisation,
            registration=registration,
            seed=seed,
            parameters=parameters,
            places=places,
            paced=paced,
            shown=True,
            record=record,
            replayable=replayable,
            weights=weights,
            view=ViewOptions(view=view, host=view_host, port=view_port, web_port=web_port),
            ros2=ros2,
            control=ControlOptions(
                page=control or control_pipe is not None,
                remote=view is View.FOXGLOVE,
                page_port=control_port,
                pipe=control_pipe,
                paused=paused,
                breaks=tuple(stop_before or ()),
                groot=groot2,
                groot_port=groot2_port,
                force=force,
                approve=approve,
                acknowledge_after=acknowledge_after,
            ),
            faults=tuple(parse_fault(text) for text in fault or ()),
        )
        try:
            result = run_task(options, loading=loading, finished=finished(as_json))
        except HardwareError as error:  # while connecting: a run that has begun ends with a summary
            say(str(error))
            raise typer.Exit(End.HARDWARE.exit_code) from None
    raise typer.Exit(result.outcome.end.exit_code)

"""Starts a run: loads the task, connects the robot, opens controls and viewer."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import replace

from app.choices import VisionForm
from app.core.files.folder import SUMMARY
from app.core.observers import Instruments
from app.core.run import Run, scene_name, tell
from app.core.run_options import RunOptions
from app.core.setup import Setup, open_setup
from app.core.summary import Result
from app.live import OperatorConsole, PageServer, Viewer, WebViewer
from app.terminal import Loading
from config import Severity
from hw import WorldOptions
from perception import GraspDetector
from robots import load_robot
from trees.language import Task, TaskFileError, TreeNode, build, load, nodes_in_order
from trees.site import place_diagnostics


def run_task(
    options: RunOptions,
    *,
    interrupted: Callable[[], bool] = lambda: False,
    instruments: Instruments | None = None,
    loading: Loading | None = None,
    finished: Callable[[Result], str] | None = None,
    page_server: PageServer | None = None,
) -> Result:
    """Run a task.

    Args:
        options: of the run.
        interrupted: asked every tick whether to end, as Ctrl-C does.
        instruments: of a bench that measures or disturbs the run.
        loading: shows the progress until the robot can move.
        finished: gets the result and returns its explanation for the control page, which then
            stays until Ctrl-C; None closes the page with the run.
        page_server: serves the control page across several runs; None makes one if needed.

    Raises:
        UserError: bad input; nothing has moved.
        HardwareError: the robot cannot be connected.
    """
    loading, instruments = loading or Loading(), instruments or Instruments()
    loading("the task")
    viewer = Viewer(options.view, say=tell)
    task = load(options.tree, overrides=options.parameters, places=options.places)
    world = WorldOptions(
        scene=scene_name(options, task),
        seed=options.seed,
        base_speed=options.base_speed,
        reverse_speed=options.reverse_speed,
        paced=options.paced,
        beside=options.vision is VisionForm.BESIDE,
        armed=options.armed,
        announce=tell,
    )
    loading("the grasp network")
    gripper = load_robot(options.robot).gripper
    detector = GraspDetector(options.weights, options.network, gripper=gripper)
    loading("the robot and its world")
    with ExitStack() as page:
        with open_setup(
            options.robot,
            options.world,
            world,
            detector,
            options.vision,
            instruments.beneath,
            options.obstacles,
            options.map,
            options.motion,
            options.planning_time,
        ) as setup:
            nodes = nodes_in_order(build(task, setup.context))
            _check_places(options, task, setup)
            console = page.enter_context(_console(options, task, setup, nodes, viewer, page_server))
            loading("the recording and the viewer")
            run = Run(options, task, setup, nodes, console, viewer, instruments, interrupted)
            result = run.execute(loading)
        if setup.problems:
            warnings = [*result.summary.warnings, *setup.problems]
            summary = replace(result.summary, warnings=warnings).kept(result.folder / SUMMARY)
            result = result._replace(summary=summary)
        if finished is not None:
            console.stay(result.ending(finished(result)))
    return result


def _check_places(options: RunOptions, task: Task, setup: Setup) -> None:
    """Raise TaskFileError for what `check` refuses; warn of problems in a scene given by option."""
    fixtures = setup.truth.fixtures if setup.truth else ()
    robot = setup.robot.description
    own = bool(task.scene) and options.scene in (None, task.scene)
    certain = place_diagnostics(task, robot, fixtures if own else ())
    if errors := [one for one in certain if one.severity is Severity.ERROR]:
        raise TaskFileError(errors)
    for found in place_diagnostics(task, robot, fixtures):
        tell(str(replace(found, severity=Severity.WARNING)))


def _console(
    options: RunOptions,
    task: Task,
    setup: Setup,
    nodes: Sequence[TreeNode],
    viewer: Viewer,
    page_server: PageServer | None,
) -> OperatorConsole:
    embedded = viewer.server if viewer.page is not None else None
    return OperatorConsole(
        options.control,
        task=task.name,
        nodes=nodes,
        inject=setup.robot.inject,
        clear=setup.robot.clear,
        viewer=WebViewer(data=embedded.url) if embedded else None,
        say=tell,
        server=page_server,
    )

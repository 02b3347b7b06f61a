"""Starts a run: loads the task, connects the robot, opens controls and viewer."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from dataclasses import replace

from app.core.files.folder import SUMMARY
from app.core.run import Instruments, Run, tell
from app.core.setup import Setup, open_setup, supports
from app.core.snapshots import scene_view
from app.core.summary import Result
from app.live import LiveRun, OperatorConsole, RunInfo, ShownRun, Viewer, observers, tree_view
from app.run_options import DEFAULT_SCENE, RunOptions
from config import Severity
from hw import epoch
from perception import GraspDetector
from robots import KINDS, RobotDescription, load_real_robot, load_robot
from trees.language import Task, TaskFileError, TreeNode, build, load, nodes_in_order
from trees.site import furniture_diagnostics, place_diagnostics, scene_of


def run_task(
    options: RunOptions,
    *,
    interrupted: Callable[[], bool] = lambda: False,
    instruments: Instruments | None = None,
    finished: Callable[[Result], str] | None = None,
) -> Result:
    """Run a task.

    `interrupted` is asked every tick whether to end, as Ctrl-C does. `finished` gets the result and
    returns its explanation for the control page, which then stays until Ctrl-C; None closes the
    page with the run. Raises UserError: bad input, nothing has moved; HardwareError: the robot
    cannot be connected.
    """
    instruments = instruments or Instruments()
    viewer = Viewer(options, say=tell)
    task = load(options.tree, overrides=options.parameters, places=options.places)
    options = replace(options, scene=options.scene or scene_of(task) or DEFAULT_SCENE)
    robot = load_robot(options.robot)
    detector = GraspDetector.shipped(robot.gripper, options.weights)
    # Before the drivers wait for commands; told once the robot is not refused.
    too_slow = _too_slow(robot, detector) if load_real_robot(options.robot) else []
    with ExitStack() as page:
        opened, control = instruments.opened, instruments.controller
        with open_setup(options, detector, opened=opened, control=control, announce=tell) as setup:
            for text in too_slow:
                tell(f"warning: {text}")
            nodes = nodes_in_order(build(task, setup.context))
            _check_places(options, task, setup)
            scene = scene_view(
                setup.truth,
                setup.context.around.fixtures,
                nodes,
                estimated=setup.context.state.localised is not None,
            )
            info = _info(options, task, setup, nodes)
            tree = tuple(tree_view(nodes))
            shown = ShownRun(setup.robot.description, tree, scene, round(1e9 * epoch()))
            embedded = viewer.server if viewer.page is not None else None
            console = OperatorConsole(options, nodes, watched=bool(options.observers), say=tell)
            live = LiveRun(
                shown=shown,
                info=info,
                control=console.control,
                hooks=console.hooks,
                injector=setup.injector,
                may_force=options.approve,
                drivers=frozenset(_drivers(options)),
                viewer=embedded.url if embedded else None,
                say=tell,
            )
            told = page.enter_context(observers(options.observers, live))
            console.attend(told.values())
            result = Run(
                options=options,
                task=task,
                setup=setup,
                nodes=nodes,
                info=info,
                shown=shown,
                console=console,
                observers=told,
                viewer=viewer,
                instruments=instruments,
                interrupted=interrupted,
            ).execute()
        if setup.problems:
            warnings = [*result.summary.warnings, *setup.problems]
            summary = replace(result.summary, warnings=warnings).kept(result.folder / SUMMARY)
            result = result._replace(summary=summary)
        if finished is not None:
            explanation = finished(result)
            for name, one in told.items():
                try:
                    one.end(result.summary.achieved, explanation, stay=not console.left)
                except Exception as error:  # whatever it is, the run has ended well or not
                    tell(f"{name}: {type(error).__name__}: {error}")
    return result


def _too_slow(robot: RobotDescription, detector: GraspDetector) -> list[str]:
    """What this computer is too slow for, with a robot that does not wait."""
    from hw.hardware import Verdict, room

    return [one.text for one in room(robot, detector) if one.verdict is not Verdict.GOOD]


def _check_places(options: RunOptions, task: Task, setup: Setup) -> None:
    """Raise TaskFileError for what `check` refuses; warn of problems in a scene given by option."""
    fixtures = setup.truth.fixtures if setup.truth else ()
    robot = setup.robot.description
    own = bool(task.scene) and options.scene in (task.scene, scene_of(task))
    certain = furniture_diagnostics(task, setup.context.around.fixtures)
    certain += place_diagnostics(task, robot, fixtures if own else ())
    if errors := [one for one in certain if one.severity is Severity.ERROR]:
        raise TaskFileError(errors)
    for found in place_diagnostics(task, robot, fixtures):
        tell(str(replace(found, severity=Severity.WARNING)))


def _drivers(options: RunOptions) -> Iterator[str]:
    """The drivers of a real robot."""
    if (real := load_real_robot(options.robot)) is not None:
        parts = (getattr(real.hardware, kind) for kind in KINDS)
        yield from (part.driver for part in parts if part is not None)


def _info(options: RunOptions, task: Task, setup: Setup, nodes: Sequence[TreeNode]) -> RunInfo:
    real = load_real_robot(options.robot)
    where = [setup.world, str(options.scene), f"seed {options.seed}"]
    if real is not None:
        on = real.hardware
        parts = (on.base, on.arm, on.gripper, on.camera)
        where = [f"{one.driver} {getattr(one, 'address', '') or ''}".strip() for one in parts]
        where.append(f"{on.speed_percent:g} % speed")
    places = any(getattr(place.node, "key", "") == "place" for place in nodes)
    return RunInfo(
        task=task.name,
        description=task.description,
        where=" · ".join((setup.robot.description.name, *where)),
        objects=len(supports(setup.truth)) if places else 0,
        real=real is not None and options.armed,
    )

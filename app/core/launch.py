"""Starts a run (loads the task, connects the robot, opens controls and viewer), or one a save."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import ExitStack, nullcontext
from dataclasses import replace
from pathlib import Path
from typing import TypeAlias

from app.core.files.folder import SUMMARY
from app.core.outcome import End
from app.core.run import Instruments, Run, tell
from app.core.run_options import DEFAULT_SCENE, RunOptions
from app.core.setup import Setup, open_setup
from app.core.snapshots import scene_view
from app.core.summary import Result
from app.core.world_model import supports
from app.live import OperatorConsole, PageServer, Plan, RunInfo, Viewer
from app.terminal import Loading
from config import Severity
from hw import WallClock
from perception import GraspDetector
from robots import load_real_robot, load_robot
from trees.language import Task, TaskFileError, TreeNode, build, load, nodes_in_order
from trees.site import furniture_diagnostics, place_diagnostics, scene_of

_POLL_PERIOD = 0.2  # interval of looking for a saved file while nothing runs [s]


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

    `interrupted` is asked every tick whether to end, as Ctrl-C does. `loading` shows the progress
    until the robot can move. `finished` gets the result and returns its explanation for the control
    page, which then stays until Ctrl-C; None closes the page with the run. `page_server` serves the
    page across several runs. Raises UserError: bad input, nothing has moved; HardwareError: the
    robot cannot be connected.
    """
    loading, instruments = loading or Loading(), instruments or Instruments()
    loading("the task")
    viewer = Viewer(options.view, say=tell)
    task = load(options.tree, overrides=options.parameters, places=options.places)
    options = replace(options, scene=options.scene or scene_of(task) or DEFAULT_SCENE)
    loading("the grasp network")
    gripper = load_robot(options.robot).gripper
    detector = GraspDetector(options.weights, gripper=gripper)
    loading("the robot and its world")
    with ExitStack() as page:
        with open_setup(options, detector, beneath=instruments.beneath, announce=tell) as setup:
            nodes = nodes_in_order(build(task, setup.context))
            _check_places(options, task, setup)
            scene = scene_view(
                setup.truth,
                setup.context.fixtures,
                nodes,
                estimated=setup.context.state.localised is not None,
            )
            info = _info(options, task, setup, nodes)
            embedded = viewer.server if viewer.page is not None else None
            console = page.enter_context(
                OperatorConsole(
                    options.control,
                    info=info,
                    nodes=nodes,
                    inject=setup.robot.inject,
                    clear=setup.robot.clear,
                    viewer=embedded.url if embedded else None,
                    say=tell,
                    plan=Plan(scene, setup.robot.description.base.size),
                    server=page_server,
                )
            )
            loading("the recording and the viewer")
            run = Run(
                options,
                task,
                setup,
                nodes,
                info,
                scene,
                console,
                viewer,
                instruments,
                interrupted,
            )
            result = run.execute(loading)
        if setup.problems:
            warnings = [*result.summary.warnings, *setup.problems]
            summary = replace(result.summary, warnings=warnings).kept(result.folder / SUMMARY)
            result = result._replace(summary=summary)
        if finished is not None:
            console.stay(result.summary.achieved, finished(result))
    return result


def _check_places(options: RunOptions, task: Task, setup: Setup) -> None:
    """Raise TaskFileError for what `check` refuses; warn of problems in a scene given by option."""
    fixtures = setup.truth.fixtures if setup.truth else ()
    robot = setup.robot.description
    own = bool(task.scene) and options.scene in (task.scene, scene_of(task))
    certain = furniture_diagnostics(task, setup.context.fixtures)
    certain += place_diagnostics(task, robot, fixtures if own else ())
    if errors := [one for one in certain if one.severity is Severity.ERROR]:
        raise TaskFileError(errors)
    for found in place_diagnostics(task, robot, fixtures):
        tell(str(replace(found, severity=Severity.WARNING)))


def _info(options: RunOptions, task: Task, setup: Setup, nodes: Sequence[TreeNode]) -> RunInfo:
    real = load_real_robot(options.robot)
    where = (setup.robot.description.name, setup.world, str(options.scene))
    places = any(getattr(place.node, "key", "") == "place" for place in nodes)
    return RunInfo(
        task=task.name,
        description=task.description,
        where=" · ".join((*where, f"seed {options.seed}")),
        objects=len(supports(setup.truth)) if places else 0,
        real=real is not None and real.hardware.emulated is None,
    )


Saved: TypeAlias = Callable[[], bool]  # whether files have changed, appeared or gone


def saved_since(paths: Iterable[Path]) -> Saved:
    """Whether anything has changed since this call."""
    paths = tuple(paths)
    before = [_stamp(path) for path in paths]
    return lambda: [_stamp(path) for path in paths] != before


def _stamp(path: Path) -> tuple[int, int] | None:
    try:
        status = path.stat()
    except OSError:
        return None
    return status.st_mtime_ns, status.st_size


def again_on_save(
    tree: Path,
    overrides: Mapping[str, str],
    places: Path | None,
    *,
    act: Callable[[Saved], bool],
    say: Callable[[str], None],
    stopped: Callable[[], bool] = lambda: False,
) -> None:
    """Call `act` with a task each time it is saved, until a person stops it.

    A file with mistakes is reported, and the next save is awaited.

    `act` gets the detector of the next save and returns whether to end; `stopped` is asked between
    two saves. Raises UserError: bad input other than the task.
    """
    files, site = {tree}, [] if places is None else [places]
    clock = WallClock()
    try:
        while True:
            saved = saved_since([*files, *site])
            try:
                files = set(load(tree, overrides=overrides, places=places).files)
                saved = saved_since([*files, *site])
                if act(saved):
                    return
            except TaskFileError as error:
                say(str(error))
                files |= {mistake.path for mistake in error.diagnostics}
            next_is = "saved, starts anew" if saved() else "save it to run it again; Ctrl-C ends"
            say(f"{tree}: {next_is}")
            while not saved():
                if stopped():
                    return
                clock.sleep_until(clock.now() + _POLL_PERIOD)
    except KeyboardInterrupt:  # between two runs; in a run the session takes it
        return


def run_on_save(
    options: RunOptions, *, finished: Callable[[Result], str], say: Callable[[str], None]
) -> Result | None:
    """Run a task, and again in a fresh scene each time it is saved, until a person stops it.

    A save brings a moving robot to rest before the task restarts. The control page stays the same;
    `finished` returns the explanation of a run for it. Returns the last run; None if the task could
    not run at all. Raises UserError: bad input other than the task; nothing moves.
    """
    results: list[Result] = []
    control = options.control
    page = PageServer(control.page_port, again=True) if control.page else nullcontext()
    with page as server:

        def stopped() -> bool:
            return server is not None and server.stopped

        def act(saved: Saved) -> bool:
            result = run_task(options, interrupted=saved, finished=finished, page_server=server)
            results.append(result)
            return stopped() or (result.outcome.end is End.INTERRUPTED and not saved())

        again_on_save(
            options.tree, options.parameters, options.places, act=act, say=say, stopped=stopped
        )
        if server is not None:
            server.farewell()
    return results[-1] if results else None

"""Everything that `frankie-task run` puts together: task, scene, robot, recorder and session."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, ExitStack, nullcontext, suppress
from dataclasses import asdict, replace

from app.choices import VisionForm
from app.core.brought import brought, supports
from app.core.decisions import RecordedDecisions
from app.core.fault_schedule import FaultSchedule
from app.core.folder import RECORDING, SUMMARY, VIEWER_LOG, make_folder, texts
from app.core.instruments import Instruments
from app.core.interrupts import interrupts, leave, terminal_settings
from app.core.measurements import Measurements
from app.core.observers import Observers
from app.core.outcome import End, Outcome
from app.core.outputs import Outputs
from app.core.result import Result
from app.core.run_options import RunOptions
from app.core.session import Session, Tick
from app.core.setup import Setup, open_setup
from app.core.snapshots import Snapshots, scene_view
from app.core.summary import summarise
from app.live import (
    About,
    AnyRecorder,
    Moment,
    NoRecorder,
    OperatorConsole,
    PageServer,
    Recorder,
    RecorderError,
    RunDisplay,
    Viewer,
    WebViewer,
    tree_view,
)
from app.terminal import Loading, Terminal
from config import Severity
from controller import RobotModel
from hw import WorldOptions, stopwatch
from perception import GraspDetector
from robots import load_robot
from trees.language import Task, TaskFileError, TreeNode, build, load, nodes_in_order
from trees.site import place_diagnostics, scene_of

_SHORT_PATIENCE = 1.0
"""Time that the disk has for the rest of a run that is abandoned [s]."""


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
        options: what a person chose.
        interrupted: asked every tick whether to end, as Ctrl-C does.
        instruments: what a bench measures or disturbs the run with.
        loading: is told what is being loaded, and ended when the robot can move.
        finished: is told the result, and explains it for the control page, which then stays until
            Ctrl-C; without it the page ends with the run.
        page_server: serves the control page, before and after this run too.

    Raises:
        UserError: bad input; nothing has moved.
        HardwareError: the robot cannot be connected.
    """
    loading = loading or Loading()
    loading("the task")
    viewer = Viewer(options.view, say=_tell)
    task = load(options.tree, overrides=options.parameters, places=options.places)
    world = WorldOptions(
        scene=_scene(options, task),
        seed=options.seed,
        base_speed=options.base_speed,
        reverse_speed=options.reverse_speed,
        paced=options.paced,
        beside=options.vision is VisionForm.BESIDE,
        armed=options.armed,
        announce=_tell,
    )
    loading("the grasp network")
    gripper = load_robot(options.robot).gripper
    detector = GraspDetector(options.weights, options.network, gripper=gripper)
    tools, vision = instruments or Instruments(), options.vision
    loading("the robot and its world")
    with ExitStack() as page:
        with open_setup(
            options.robot,
            options.world,
            world,
            detector,
            vision,
            tools.beneath,
            options.obstacles,
            options.map,
            options.motion,
            options.planning_time,
        ) as setup:
            nodes = nodes_in_order(build(task, setup.context))
            _check_places(options, task, setup)
            embedded = viewer.server if viewer.page is not None else None
            room = page.enter_context(
                OperatorConsole(
                    options.control,
                    task=task.name,
                    nodes=nodes,
                    inject=setup.robot.inject,
                    clear=setup.robot.clear,
                    viewer=WebViewer(data=embedded.url) if embedded else None,
                    say=_tell,
                    server=page_server,
                )
            )
            loading("the recording and the viewer")
            result = _run(options, task, setup, nodes, room, viewer, interrupted, tools, loading)
        if setup.problems:
            warnings = [*result.summary.warnings, *setup.problems]
            summary = replace(result.summary, warnings=warnings).kept(result.folder / SUMMARY)
            result = result._replace(summary=summary)
        if finished is not None:
            room.stay(result.ending(finished(result)))
    return result


def _check_places(options: RunOptions, task: Task, setup: Setup) -> None:
    """Refuse what `check` does; warn of what is wrong in a scene that the task does not name.

    Raises:
        TaskFileError: the robot cannot be where the task sends it.
    """
    fixtures = setup.truth.fixtures if setup.truth else ()
    robot = setup.robot.description
    own = bool(task.scene) and options.scene in (None, task.scene)
    certain = place_diagnostics(task, robot, fixtures if own else ())
    if errors := [one for one in certain if one.severity is Severity.ERROR]:
        raise TaskFileError(errors)
    for found in place_diagnostics(task, robot, fixtures):
        _tell(str(replace(found, severity=Severity.WARNING)))


def _run(
    options: RunOptions,
    task: Task,
    setup: Setup,
    nodes: Sequence[TreeNode],
    room: OperatorConsole,
    viewer: Viewer,
    interrupted: Callable[[], bool],
    instruments: Instruments,
    loading: Loading,
) -> Result:
    """Run what has been put together, and keep all that it leaves."""
    log, tree = setup.context.log, tree_view(nodes)
    before, began = supports(setup.truth), setup.clock.now()
    snapshots = Snapshots(nodes, setup.truth)
    measurements = Measurements(limits=setup.model.limits)
    scene = _scene(options, task)
    behaviours = [place.node for place in nodes]
    faults = FaultSchedule(options.faults, setup.robot, behaviours, options.seed)
    instruments.begin(setup, nodes)
    known = asdict(options) | {"scene": scene, "pace": setup.robot.description.pace}
    folder = make_folder(options.record, task.name, texts(task, options.places), known)
    lossless = not options.paced
    outputs = Outputs(
        folder,
        task=task.name,
        nodes=nodes,
        robot=setup.recorded,
        attended=room.control.attended,
        lossless=lossless,
        frames=options.replayable,
    )
    recorder: AnyRecorder = NoRecorder()
    if options.recording:
        recorder = Recorder(
            folder / RECORDING,
            tree=tree,
            model=RobotModel(setup.robot.description),
            scene=scene_view(setup.truth, setup.context.fixtures, nodes),
            lossless=lossless,
            server=viewer.server,
        )
    begun, observers, terminal = stopwatch(), Observers(), terminal_settings()
    with (
        viewer.showing(folder / VIEWER_LOG),
        loading.ended(),
        room.open(),
        interrupts(room.leave, setup.robot.stop, End.INTERRUPTED.exit_code),
        _display(options, task, setup, nodes) as display,
    ):

        def tell(tick: Tick) -> None:
            seen = snapshots.of(tick)
            why = room.control.state.why if tick.paused else ""
            changed = outputs.update(seen, paused=tick.paused, why=why)
            room.control.node_changed(changed)
            observers.tell("the recording", lambda: recorder.record(seen))
            observers.tell("the controls", lambda: room.show(seen))
            if display is not None:
                moment = Moment(seen=seen, placed=log.placed, attempts=log.attempts, paused=why)
                observers.tell("the terminal", lambda: display.update(moment, changed=changed))

        def watch(tick: Tick) -> None:
            if interrupted():
                room.control.stop()
            observers.tell("the faults", lambda: faults.update(setup.clock.session.now()))
            observers.tell("the instruments", lambda: instruments.after(tick))
            observers.tell("what watches the run", lambda: tell(tick))

        def abandon(outcome: Outcome) -> None:
            observers.tell("the terminal", lambda: _tell(f"{outcome.reason}; the run is abandoned"))
            outputs.end(outcome, setup.clock.session.now())
            outputs.close(_SHORT_PATIENCE)
            leave(setup.robot.stop, outcome.end.exit_code, terminal)

        outcome = Session(
            root=room.root,
            context=setup.context,
            controller=setup.controller,
            gate=setup.gate,
            measurements=measurements,
            clock=setup.clock,
            control=RecordedDecisions(room.control, setup.recorded),
            watch=watch,
            abandon=abandon,
        ).run()
        room.finish()
        if display is not None:
            display.finish()
        real_seconds = stopwatch() - begun - measurements.paused_s
        outputs.end(outcome, setup.clock.session.now())
        warnings = [*observers.failures, *_closed(recorder), *outputs.close()]
        summary = summarise(
            task=task.name,
            robot=setup.robot.description.name,
            world=setup.world,
            scene=scene,
            seed=options.seed,
            outcome=outcome,
            objects=len(before),
            placed=brought(before, supports(setup.truth)),
            touches=setup.truth.touches if setup.truth else (),
            log=log,
            measurements=measurements,
            gate=setup.gate,
            duration=setup.clock.now().since(snapshots.began or began),
            paused=setup.clock.paused_s,
            real_seconds=real_seconds,
            perception_seconds=setup.vision.seconds,
            dropped_snapshots=recorder.dropped,
            warnings=warnings,
        )
    return Result(outcome, summary.kept(folder / SUMMARY), folder)


def _display(
    options: RunOptions, task: Task, setup: Setup, nodes: Sequence[TreeNode]
) -> AbstractContextManager[RunDisplay | None]:
    """What the terminal shows meanwhile, if anything."""
    if not options.shown:
        return nullcontext()
    where = (setup.robot.description.name, setup.world, _scene(options, task))
    places = any(getattr(place.node, "key", "") == "place" for place in nodes)
    about = About(
        task=task.name,
        where=" · ".join((*where, f"seed {options.seed}")),
        objects=len(supports(setup.truth)) if places else 0,
    )
    return RunDisplay(about, tree_view(nodes))


def _closed(recorder: AnyRecorder) -> list[str]:
    """Close a recorder; returns what went wrong, if anything."""
    try:
        recorder.close()
    except RecorderError as error:
        return [str(error)]
    return []


def _tell(text: str) -> None:
    """Say something to the person at the terminal."""
    with suppress(OSError):  # the terminal is gone
        Terminal(stderr=True).say(text)


def _scene(options: RunOptions, task: Task) -> str:
    """The scene that a person asked for, or the task, or the usual one."""
    return options.scene or scene_of(task) or "household"

"""Everything that `frankie-task run` puts together: task, scene, robot, recorder and session."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, replace
from os.path import relpath
from pathlib import Path
from typing import NamedTuple

from app.core.decisions import RecordedDecisions
from app.core.fault_schedule import FaultSchedule
from app.core.folder import PLACES, RECORDING, SUMMARY, TASK, VIEWER_LOG, make_folder
from app.core.instruments import Instruments
from app.core.interrupts import interrupts, leave, terminal_settings
from app.core.measurements import Measurements
from app.core.observers import Observers
from app.core.outcome import End, Outcome
from app.core.outputs import Outputs
from app.core.run_options import RunOptions
from app.core.session import Session, Tick
from app.core.setup import Setup, VisionForm, open_setup
from app.core.snapshots import Snapshots, scene_view
from app.core.summary import Summary, summarise
from app.live import (
    AnyRecorder,
    NoRecorder,
    OperatorConsole,
    Recorder,
    RecorderError,
    StatusLine,
    Viewer,
    WebViewer,
    tree_view,
)
from app.terminal import Terminal
from config import Severity
from controller import RobotModel
from hw import Truth, WorldOptions, stopwatch
from perception import GraspDetector
from robots import load_robot
from trees.language import Task, TaskFileError, TreeNode, build, load, nodes_in_order
from trees.site import place_diagnostics, scene_of

_SHORT_PATIENCE = 1.0
"""Time that the disk has for the rest of a run that is abandoned [s]."""


class Result(NamedTuple):
    """What a run leaves."""

    outcome: Outcome
    summary: Summary
    folder: Path


def run_task(
    options: RunOptions,
    *,
    interrupted: Callable[[], bool] = lambda: False,
    instruments: Instruments | None = None,
) -> Result:
    """Run a task.

    Args:
        options: what a person chose.
        interrupted: asked every tick whether to end, as Ctrl-C does.
        instruments: what a bench measures or disturbs the run with.

    Raises:
        UserError: bad input; nothing has moved.
        HardwareError: the robot cannot be connected.
    """
    viewer = Viewer(options.view, say=_tell)
    task = load(options.tree, overrides=options.parameters, places=options.places)
    world = WorldOptions(
        scene=_scene(options, task),
        seed=options.seed,
        paced=options.paced,
        beside=options.vision is VisionForm.BESIDE,
        armed=options.armed,
    )
    gripper = load_robot(options.robot).gripper
    detector = GraspDetector(options.weights, options.network, gripper=gripper)
    tools, vision = instruments or Instruments(), options.vision
    with open_setup(
        options.robot,
        options.world,
        world,
        detector,
        vision,
        tools.beneath,
        options.obstacles,
        options.map,
    ) as setup:
        if setup.note:
            _tell(setup.note)
        nodes = nodes_in_order(build(task, setup.context))
        _check_places(options, task, setup)
        room = OperatorConsole(
            options.control,
            task=task.name,
            nodes=nodes,
            inject=setup.robot.inject,
            clear=setup.robot.clear,
            viewer=_web_viewer(viewer),
            say=_tell,
        )
        with room:
            result = _run(options, task, setup, nodes, room, viewer, interrupted, tools)
    if not setup.problems:
        return result
    warnings = [*result.summary.warnings, *setup.problems]
    summary = replace(result.summary, warnings=warnings).kept(result.folder / SUMMARY)
    return result._replace(summary=summary)


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
) -> Result:
    """Run what has been put together, and keep all that it leaves."""
    log, tree = setup.context.log, tree_view(nodes)
    supports = _supports(setup.truth)
    snapshots = Snapshots(nodes, setup.truth)
    measurements = Measurements(limits=setup.model.limits)
    scene = _scene(options, task)
    behaviours = [place.node for place in nodes]
    faults = FaultSchedule(options.faults, setup.robot, behaviours, options.seed)
    instruments.begin(setup, nodes)
    known = asdict(options) | {"scene": scene, "pace": setup.robot.description.pace}
    folder = make_folder(options.record, task.name, _texts(task, options.places), known)
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
            scene=scene_view(setup.truth),
            lossless=lossless,
            server=viewer.server,
        )
    begun, observers, terminal = stopwatch(), Observers(), terminal_settings()
    began = setup.clock.now()
    with (
        viewer.showing(folder / VIEWER_LOG),
        room.open(),
        interrupts(room.control.stop, setup.robot.stop, End.INTERRUPTED.exit_code),
        StatusLine(tree) as status_line,
    ):

        def tell(tick: Tick) -> None:
            seen = snapshots.of(tick)
            why = room.control.state.why if tick.paused else ""
            changed = outputs.update(seen, paused=tick.paused, why=why)
            room.control.node_changed(changed)
            observers.tell("the recording", lambda: recorder.record(seen))
            observers.tell("the controls", lambda: room.show(seen))
            observers.tell(
                "the status line",
                lambda: status_line.update(seen, placed=log.placed, attempts=log.attempts),
            )

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
        real_seconds = stopwatch() - begun - measurements.paused_s
        duration = setup.clock.now().since(began)
        outputs.end(outcome, setup.clock.session.now())
        warnings = [*observers.failures, *_closed(recorder), *outputs.close()]
        summary = summarise(
            task=task.name,
            robot=setup.robot.description.name,
            world=setup.world,
            scene=scene,
            seed=options.seed,
            outcome=outcome,
            objects=len(supports),
            placed=_brought(supports, _supports(setup.truth)),
            touches=setup.truth.touches if setup.truth else (),
            log=log,
            measurements=measurements,
            gate=setup.gate,
            duration=duration,
            real_seconds=real_seconds,
            perception_seconds=setup.vision.seconds,
            dropped_snapshots=recorder.dropped,
            warnings=warnings,
        )
    return Result(outcome, summary.kept(folder / SUMMARY), folder)


def _closed(recorder: AnyRecorder) -> list[str]:
    """Close a recorder; returns what went wrong, if anything."""
    try:
        recorder.close()
    except RecorderError as error:
        return [str(error)]
    return []


def _web_viewer(viewer: Viewer) -> WebViewer | None:
    """Where the control page finds the viewer in the browser."""
    if viewer.page is None or viewer.server is None:
        return None
    return WebViewer(files=viewer.page.partition("/?")[0], data=viewer.server.url)


def _tell(text: str) -> None:
    """Say something to the person at the terminal."""
    with suppress(OSError):  # the terminal is gone
        Terminal(stderr=True).say(text)


def _scene(options: RunOptions, task: Task) -> str:
    """The scene that a person asked for, or the task, or the usual one."""
    return options.scene or scene_of(task) or "household"


def _texts(task: Task, places: Path | None) -> dict[str, str]:
    """The files of a task, the first as `task.yaml` and its subtrees where they are beside it."""
    site = {} if places is None else {PLACES: places.read_text(encoding="utf-8")}
    here = task.path.parent
    inner = {relpath(path, here): path.read_text(encoding="utf-8") for path in task.files[1:]}
    return inner | site | {TASK: task.text}


def _supports(truth: Truth | None) -> Mapping[str, str]:
    """What carries each object, by its name; nothing where nobody knows the world."""
    return truth.supports() if truth else {}


def _brought(before: Mapping[str, str], after: Mapping[str, str]) -> int:
    """How many objects stand on some other furniture than before, and not on the floor."""
    nowhere = ("", "hand", "floor")
    return sum(after[name] not in (*nowhere, before[name]) for name in before)

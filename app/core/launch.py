"""Everything that `frankie-task run` puts together: task, scene, robot, recorder and session."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, field
from os.path import relpath
from pathlib import Path
from typing import NamedTuple

from app.core.events import EVENTS, EventLog
from app.core.folder import BT_LOG, RECORDING, SUMMARY, VIEWER_LOG, make_folder, write_arrays
from app.core.interrupts import interrupts, leave, terminal_settings
from app.core.measurements import Measurements
from app.core.observers import Observers
from app.core.outcome import End, Outcome
from app.core.session import Session, Tick
from app.core.setup import Setup, VisionForm, open_setup
from app.core.snapshots import Snapshots, scene_view
from app.core.summary import Summary, summarise
from app.core.surfaces import unsupported_places
from app.live import (
    ControlOptions,
    OperatorConsole,
    Recorder,
    RecorderError,
    StatusLine,
    Viewer,
    ViewOptions,
    WebViewer,
    tree_view,
)
from app.terminal import Terminal
from controller import RobotModel
from hw import Truth, WorldOptions, stopwatch
from perception import GraspDetector
from robots import load_robot
from trees.btcpp import BtLog
from trees.language import Task, TreeNode, build, load, nodes_in_order


@dataclass(frozen=True, kw_only=True)
class RunOptions:
    """What a person may choose about a run."""

    tree: Path
    robot: str = "frankie"
    """The body: a shipped robot or a robot file."""
    world: str = "kinematic"
    """What moves it."""
    vision: VisionForm = VisionForm.STEP
    """How images are searched for grasps."""
    scene: str | None = None
    """A shipped scene or a scene file; None takes the one that the task names, or `household`."""
    seed: int = 0
    parameters: Mapping[str, str] = field(default_factory=dict)
    paced: bool = False
    """In real time instead of as fast as it goes."""
    record: Path = Path("runs")
    """Where the folder of the run is made."""
    weights: Path | None = None
    """A file of a grasp network; None takes a network that comes with the package."""
    network: str | None = None
    """Which of those; None takes the best."""
    view: ViewOptions = field(default_factory=ViewOptions)
    """How it is watched meanwhile."""
    control: ControlOptions = field(default_factory=ControlOptions)
    """What people have in hand meanwhile."""


class Result(NamedTuple):
    """What a run leaves."""

    outcome: Outcome
    summary: Summary
    folder: Path
    warning: str
    """What could not be kept of it; usually empty."""


def run_task(options: RunOptions, *, interrupted: Callable[[], bool] = lambda: False) -> Result:
    """Run a task.

    Args:
        options: what a person chose.
        interrupted: asked every tick whether to end, as Ctrl-C does.

    Raises:
        UserError: bad input; nothing has moved.
        HardwareError: the robot cannot be connected.
    """
    viewer = Viewer(options.view, say=_tell)
    task = load(options.tree, overrides=options.parameters)
    world = WorldOptions(
        scene=_scene(options, task),
        seed=options.seed,
        paced=options.paced,
        beside=options.vision is VisionForm.BESIDE,
    )
    gripper = load_robot(options.robot).gripper
    detector = GraspDetector(options.weights, options.network, gripper=gripper)
    with open_setup(options.robot, options.world, world, detector, options.vision) as setup:
        nodes = nodes_in_order(build(task, setup.context))
        for warning in unsupported_places(task, setup.truth.fixtures) if setup.truth else ():
            _tell(warning)
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
            return _run(options, task, setup, nodes, room, viewer, interrupted)


def _run(
    options: RunOptions,
    task: Task,
    setup: Setup,
    nodes: Sequence[TreeNode],
    room: OperatorConsole,
    viewer: Viewer,
    interrupted: Callable[[], bool],
) -> Result:
    """Run what has been put together, and keep all that it leaves."""
    log, tree = setup.context.log, tree_view(nodes)
    supports = _supports(setup.truth)
    snapshots = Snapshots(nodes, setup.truth)
    robot = setup.robot.description.name
    measurements = Measurements(limits=setup.model.limits)
    scene = _scene(options, task)
    folder = make_folder(
        options.record, task.name, _texts(task), asdict(options) | {"scene": scene}
    )
    recorder = Recorder(
        folder / RECORDING,
        tree=tree,
        model=RobotModel(setup.robot.description),
        scene=scene_view(setup.truth),
        lossless=not options.paced,
        server=viewer.server,
    )
    begun, observers, terminal = stopwatch(), Observers(), terminal_settings()
    with (
        viewer.showing(folder / VIEWER_LOG),
        room.open(),
        interrupts(room.control.stop, setup.robot.stop, End.INTERRUPTED.exit_code),
        EventLog(folder / EVENTS, task.name, nodes) as events,
        StatusLine(tree) as status_line,
    ):
        bt_log = BtLog(nodes)

        def tell(tick: Tick) -> None:
            seen = snapshots.of(tick)
            why = room.control.state.why if tick.paused else ""
            changed = events.update(seen, paused=tick.paused, why=why)
            room.control.node_changed(changed)
            observers.tell("the recording", lambda: recorder.record(seen))
            observers.tell(BT_LOG, lambda: bt_log.note(seen.stamp))
            observers.tell("the controls", lambda: room.show(seen))
            observers.tell(
                "the status line",
                lambda: status_line.update(seen, placed=log.placed, attempts=log.attempts),
            )

        def watch(tick: Tick) -> None:
            if interrupted():
                room.control.stop()
            observers.tell("what watches the run", lambda: tell(tick))

        def abandon(outcome: Outcome) -> None:
            observers.tell(EVENTS, lambda: events.end(outcome, setup.clock.session.now()))
            observers.tell("the terminal", lambda: _tell(f"{outcome.reason}; the run is abandoned"))
            leave(setup.robot.stop, outcome.end.exit_code, terminal)

        outcome = Session(
            root=room.root,
            context=setup.context,
            controller=setup.controller,
            gate=setup.gate,
            measurements=measurements,
            clock=setup.clock,
            control=room.control,
            watch=watch,
            abandon=abandon,
        ).run()
        real_seconds = stopwatch() - begun - measurements.paused_s
        duration = setup.clock.now().seconds
        events.end(outcome, setup.clock.session.now())
        warnings = [*observers.failures, *_kept(recorder, events, bt_log, measurements, folder)]
        summary = summarise(
            task=task.name,
            robot=robot,
            scene=scene,
            seed=options.seed,
            outcome=outcome,
            objects=len(supports),
            placed=_brought(supports, _supports(setup.truth)),
            log=log,
            measurements=measurements,
            gate=setup.gate,
            duration=duration,
            real_seconds=real_seconds,
            perception_seconds=setup.vision.seconds,
            dropped_snapshots=recorder.dropped,
            warnings=warnings,
        )
        warnings += _attempt(SUMMARY, lambda: summary.write(folder / SUMMARY))
    return Result(outcome, summary, folder, "; ".join(warnings))


def _kept(
    recorder: Recorder, events: EventLog, bt_log: BtLog, measurements: Measurements, folder: Path
) -> list[str]:
    """Keep what the run left; returns what could not be kept."""
    warnings = _attempt(RECORDING, recorder.close)
    if events.error is not None:
        warnings.append(f"{EVENTS} ends early ({events.error.strerror})")
    warnings += _attempt(BT_LOG, lambda: (folder / BT_LOG).write_bytes(bt_log.to_bytes()))
    warnings += _attempt(
        "commands and states",
        lambda: write_arrays(folder, commands=measurements.commands, states=measurements.states),
    )
    return warnings


def _attempt(name: str, keep: Callable[[], object]) -> list[str]:
    """Try to keep a part of what a run leaves; returns what went wrong, if anything."""
    try:
        keep()
    except RecorderError as error:
        return [str(error)]
    except OSError as error:
        return [f"{name} could not be written ({error.strerror})"]
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
    return options.scene or task.scene or "household"


def _texts(task: Task) -> dict[str, str]:
    """The files of a task, the first as `task.yaml` and its subtrees where they are beside it."""
    here = task.path.parent
    inner = {relpath(path, here): path.read_text(encoding="utf-8") for path in task.files[1:]}
    return inner | {"task.yaml": task.text}


def _supports(truth: Truth | None) -> Mapping[str, str]:
    """What carries each object, by its name; nothing where nobody knows the world."""
    return truth.supports() if truth else {}


def _brought(before: Mapping[str, str], after: Mapping[str, str]) -> int:
    """How many objects stand on some other furniture than before, and not on the floor."""
    nowhere = ("", "hand", "floor")
    return sum(after[name] not in (*nowhere, before[name]) for name in before)

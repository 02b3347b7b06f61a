"""Everything that `frankie-task run` puts together: task, scene, robot, recorder and session."""

from __future__ import annotations

import signal
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from pathlib import Path
from threading import Event
from typing import NamedTuple

from rich.console import Console

from app.folder import RECORDING, SUMMARY, VIEWER_LOG, make_folder, write_commands
from app.measure import Measurements
from app.monitor import Recorder, RecorderError, Viewer, ViewOptions
from app.outcome import Outcome
from app.session import Session, Tick
from app.status_line import StatusLine
from app.summary import Summary, summarise
from app.watching import scene_view, snapshot, tree_view
from behaviours import Context, Eyes
from controller import HolisticController, robot_model
from hw import SimClock, stopwatch
from hw.gate import Gate
from hw.sim import World, load_scene
from hw.sim.robot import SimRobot
from perception import GraspDetector
from trees.language import load, nodes_in_order

ROBOTS = {"sim": "frankie", "omni": "omni"}
"""What `--robot` accepts, and the model that it stands for."""


@dataclass(frozen=True, kw_only=True)
class RunOptions:
    """What a person may choose about a run."""

    tree: Path
    robot: str = "sim"
    scene: str = "household"
    seed: int = 0
    parameters: Mapping[str, str] = field(default_factory=dict)
    paced: bool = False
    """In real time instead of as fast as it goes."""
    record: Path = Path("runs")
    """Where the folder of the run is made."""
    weights: Path | None = None
    """Of the grasp network; None takes those that come with the package."""
    view: ViewOptions = field(default_factory=ViewOptions)
    """How it is watched meanwhile."""


class Result(NamedTuple):
    """What a run leaves."""

    outcome: Outcome
    summary: Summary
    folder: Path
    warning: str
    """What could not be kept of it; usually empty."""


def run_task(options: RunOptions) -> Result:
    """Run a task in simulation.

    Raises:
        TaskFileError, SceneError, WeightsError, FolderError, ViewError, RecorderError: bad input;
            nothing has moved.
    """
    viewer = Viewer(options.view, say=_tell)
    task = load(options.tree, overrides=options.parameters)
    world = load_scene(options.scene, options.seed)
    detector = GraspDetector(options.weights)
    model_name = ROBOTS[options.robot]
    clock = SimClock(pace=1.0 if options.paced else None)
    robot = SimRobot(robot_model(model_name), world, clock, seed=options.seed)
    controller = HolisticController(robot_model(model_name))
    limits = controller.model.limits
    gate = Gate(robot, limits, controller.settings.period)
    eyes = Eyes(robot, detector)
    context = Context(
        robot=robot, model=controller.model, clock=clock, eyes=eyes, state=robot.read()
    )
    root = task.build(context)
    nodes = nodes_in_order(root)
    measurements = Measurements(limits=limits)
    supports = _supports(world)

    folder = make_folder(options.record, task.name, task.text, asdict(options))
    recorder = Recorder(
        folder / RECORDING,
        tree=tree_view(nodes),
        model=robot_model(model_name),
        scene=scene_view(world),
        lossless=not options.paced,
        server=viewer.server,
    )
    begun = stopwatch()
    with (
        viewer.showing(folder / VIEWER_LOG),
        _interrupts() as interrupted,
        StatusLine(tree_view(nodes)) as status_line,
    ):

        def watch(tick: Tick) -> None:
            seen = snapshot(tick, nodes, world)
            recorder.record(seen)
            status_line.update(seen, placed=context.log.placed, attempts=context.log.attempts)

        outcome = Session(
            root=root,
            context=context,
            controller=controller,
            gate=gate,
            measurements=measurements,
            watch=watch,
            interrupted=interrupted.is_set,
        ).run()
        real_seconds = stopwatch() - begun
        robot.close()
        warning = _closed(recorder)
        write_commands(folder, measurements.commands)
        summary = summarise(
            task=task.name,
            robot=model_name,
            scene=options.scene,
            seed=options.seed,
            outcome=outcome,
            objects=len(world.objects),
            placed=_brought(supports, _supports(world)),
            log=context.log,
            measurements=measurements,
            gate=gate,
            duration=clock.now(),
            real_seconds=real_seconds,
            perception_seconds=eyes.seconds,
        )
        summary.write(folder / SUMMARY)
    return Result(outcome, summary, folder, warning)


def _tell(text: str) -> None:
    """Say something to the person at the terminal."""
    Console(stderr=True).print(text, soft_wrap=True, highlight=False, markup=False)


def _supports(world: World) -> dict[str, str]:
    """What carries every object."""
    return {thing.name: world.resting_on(thing) for thing in world.objects}


def _brought(before: dict[str, str], after: dict[str, str]) -> int:
    """How many objects stand on some other furniture than before, and not on the floor."""
    nowhere = ("", "hand", "floor")
    return sum(after[name] not in (*nowhere, before[name]) for name in before)


def _closed(recorder: Recorder) -> str:
    """Close a recorder; returns what went wrong, if anything."""
    try:
        recorder.close()
    except RecorderError as error:
        return str(error)
    return ""


@contextmanager
def _interrupts() -> Iterator[Event]:
    """An event that Ctrl-C and SIGTERM set instead of raising, as long as the context lasts."""
    event = Event()
    kinds = (signal.SIGINT, signal.SIGTERM)
    before = {kind: signal.signal(kind, lambda *_: event.set()) for kind in kinds}
    try:
        yield event
    finally:
        for kind, handler in before.items():
            signal.signal(kind, handler)

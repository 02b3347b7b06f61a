"""The life of a run: make its folder, run the session, tell the observers, write the summary."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, ExitStack, nullcontext, suppress
from dataclasses import asdict
from functools import partial
from os.path import isfile
from pathlib import Path

from app.core.decisions import RecordedDecisions
from app.core.fault_schedule import FaultSchedule
from app.core.files.folder import RECORDING, SUMMARY, VIEWER_LOG, make_folder, texts
from app.core.files.outputs import Outputs
from app.core.interrupts import interrupts, leave, terminal_settings
from app.core.measurements import Measurements
from app.core.outcome import End, Outcome
from app.core.run_options import RunOptions
from app.core.session import Tick
from app.core.setup import Setup
from app.core.snapshots import Snapshots
from app.core.summary import Result, Summary, localised_by, summarise
from app.core.world_model import delivered, supports
from app.live import (
    Moment,
    OperatorConsole,
    Recorder,
    RecorderError,
    RunDisplay,
    RunInfo,
    SceneView,
    ShownRun,
    Snapshot,
    View,
    Viewer,
    tree_view,
)
from app.terminal import Loading, Terminal
from config import counted
from controller import RobotModel
from hw import DEFAULT_LEVEL, Robot, epoch, stopwatch
from robots import load_real_robot
from trees.language import Task, TreeNode

_SHORT_PATIENCE = 1.0  # time for the disk to write the rest of an abandoned run [s]


class Observers:
    """Calls observers; one that raises is reported and not called again, and the run goes on."""

    def __init__(self) -> None:
        self._failed: dict[str, str] = {}

    def tell(self, name: str, call: Callable[[], object]) -> None:
        """Call an observer by its name for people, unless it has failed before."""
        if name in self._failed:
            return
        try:
            call()
        except BaseException as error:  # whatever it is, the robot must go on
            self._failed[name] = f"{name} ended early ({type(error).__name__}: {error})"

    @property
    def failures(self) -> tuple[str, ...]:
        """One text for each observer that failed."""
        return tuple(self._failed.values())


class Instruments:
    """Hooks of a bench into a run, to measure or disturb it; these do nothing."""

    def beneath(self, robot: Robot) -> Robot:
        """A robot in place of the one that faults are injected into."""
        return robot

    def begin(self, setup: Setup, nodes: Sequence[TreeNode]) -> None:
        """Called before the first tick, when the robot is connected."""

    def after(self, tick: Tick) -> None:
        """Called after every tick."""


class Run:
    """One run of a task on a connected robot."""

    def __init__(
        self,
        options: RunOptions,
        task: Task,
        setup: Setup,
        nodes: Sequence[TreeNode],
        info: RunInfo,
        scene: SceneView,
        console: OperatorConsole,
        viewer: Viewer,
        instruments: Instruments,
        interrupted: Callable[[], bool],
    ) -> None:
        self._options, self._task, self._setup, self._nodes = options, task, setup, nodes
        self._info, self._scene = info, scene
        self._console, self._viewer = console, viewer
        self._instruments, self._interrupted = instruments, interrupted
        self._supports, self._began = supports(setup.truth), setup.clock.now()
        self._snapshots = Snapshots(nodes, setup.truth)
        self._measurements = Measurements(limits=setup.model.limits)
        self._observers = Observers()
        self._faults = FaultSchedule(options.faults, setup.robot, [one.node for one in nodes])

    def execute(self, loading: Loading) -> Result:
        """Run the task; the outcome, the summary and the folder of the run."""
        setup = self._setup
        self._instruments.begin(setup, self._nodes)
        with ExitStack() as opened:
            self._senders = dict(self._make_senders(opened))  # first, as they may be refused
            self._folder = self._make_folder()
            self._outputs = self._make_outputs()
            self._recorder = self._make_recorder()
            senders = opened.pop_all()
        begun, self._terminal = stopwatch(), terminal_settings()
        with (
            self._viewer.showing(self._folder / VIEWER_LOG),
            loading.ended(),
            self._console.open(),
            interrupts(self._console.leave, setup.robot.stop, End.INTERRUPTED.exit_code),
            self._make_display() as self._display,
            senders,
        ):
            outcome = setup.session(
                self._console.root,
                RecordedDecisions(self._console.control, setup.recorded),
                self._watch,
                self._measurements,
                self._abandon,
            ).run()
            self._console.finish()
            real_seconds = stopwatch() - begun - self._measurements.paused_s
            self._outputs.end(outcome, setup.clock.session.now())
            summary = self._summary(outcome, real_seconds)
        return Result(outcome, summary.kept(self._folder / SUMMARY), self._folder)

    def _watch(self, tick: Tick) -> None:
        """Tell everybody about a tick."""
        if self._interrupted():
            self._console.control.stop()
        now, tell = self._setup.clock.session.now, self._observers.tell
        tell("the faults", lambda: self._faults.update(now()))
        tell("the instruments", lambda: self._instruments.after(tick))
        tell("what watches the run", lambda: self._show(tick))

    def _show(self, tick: Tick) -> None:
        seen, console, tell = self._snapshots.of(tick), self._console, self._observers.tell
        why = console.control.state.why if tick.paused else ""
        changed = self._outputs.update(seen, paused=tick.paused, why=why)
        for name, frame in seen.pictures:
            tell("the pictures", partial(self._outputs.picture, name, frame))
        console.control.node_changed(changed)
        if (recorder := self._recorder) is not None:
            tell("the recording", lambda: recorder.record(seen))
        for name, sender in self._senders.items():
            tell(name, partial(sender, seen))
        log = self._setup.context.log
        holds = log.in_hand is not None
        moment = Moment(seen, log.placed, log.attempts, why, holds, tick.too_slow)
        tell("the controls", lambda: console.show(moment, changed=changed))
        if (display := self._display) is not None:
            tell("the terminal", lambda: display.update(moment, changed=changed))

    def _abandon(self, outcome: Outcome) -> None:
        """End the process because a tick does not return; called from another thread."""
        setup = self._setup
        message = f"{outcome.reason}; the run is abandoned"
        try:
            self._observers.tell("the terminal", lambda: tell(message))
            self._outputs.end(outcome, setup.clock.session.now())
            self._outputs.close(_SHORT_PATIENCE)
        finally:
            leave(setup.robot.stop, outcome.end.exit_code, self._terminal)

    def _make_folder(self) -> Path:
        options, task, real = self._options, self._task, load_real_robot(self._options.robot)
        paths = {"map": options.map or (real.map if real else None), "scene": options.scene}
        paths["weights"] = options.weights
        chosen = asdict(options) | {key: _absolute(one) for key, one in paths.items()}
        chosen |= {
            "world": self._setup.world,
            "time_of_day": self._setup.context.began_at,
            "pace": self._setup.robot.description.pace,
        }
        return make_folder(
            options.record, task.name, texts(task, options.places, options.robot), chosen
        )

    def _make_outputs(self) -> Outputs:
        return Outputs(
            self._folder,
            task=self._task.name,
            nodes=self._nodes,
            robot=self._setup.recorded,
            attended=self._console.control.attended,
            lossless=not self._setup.clock.session.is_real,
            frames=self._options.replayable,
        )

    def _make_recorder(self) -> Recorder | None:
        if not self._options.recording:
            return None
        return Recorder(
            self._folder / RECORDING,
            tree=tree_view(self._nodes),
            model=RobotModel(self._setup.robot.description),
            scene=self._scene,
            lossless=not self._setup.clock.session.is_real,
            server=self._viewer.server,
        )

    def _make_senders(self, opened: ExitStack) -> Iterator[tuple[str, Callable[[Snapshot], None]]]:
        """What sends snapshots to other programs, with names for people."""
        view, robot = self._options.view, self._setup.robot.description
        tree = tuple(tree_view(self._nodes))
        run = ShownRun(robot, tree, self._scene, round(1e9 * epoch()))
        if self._options.ros2:
            from app.live.ros2 import published  # an extra

            yield "ROS 2", opened.enter_context(published(run))
        if view.view is View.FOXGLOVE:
            from app.live.ros2 import served  # an extra

            server = served(run, self._console.control, view.host, view.port, tell)
            yield "Foxglove", opened.enter_context(server)

    def _make_display(self) -> AbstractContextManager[RunDisplay | None]:
        if not self._options.shown:
            return nullcontext()
        return RunDisplay(self._info, tree_view(self._nodes))

    def _summary(self, outcome: Outcome, real_seconds: float) -> Summary:
        """Close recorder and outputs, and summarise the run."""
        setup, options, truth = self._setup, self._options, self._setup.truth
        lost = [*self._observers.failures, *self._close_recorder(), *self._outputs.close()]
        lost += filter(None, [self._measurements.failed_stop])
        return summarise(
            outcome,
            self._measurements,
            setup.context.log,
            truth.touches if truth else (),
            refusals=setup.gate.refusals,
            duration=setup.clock.now().since(self._snapshots.began or self._began),
            real_seconds=real_seconds,
            task=self._task.name,
            robot=setup.robot.description.name,
            world=setup.world,
            scene=str(options.scene) if truth else setup.map,
            seed=options.seed if truth else None,
            objects=len(self._supports) if truth else None,
            placed=delivered(self._supports, supports(truth)) if truth else None,
            lies_on=dict(supports(truth)),
            paused_s=round(setup.clock.paused_s, 3),
            perception_s=round(setup.vision.seconds, 2),
            localisation=localised_by(
                setup.context.localisation,
                options.localisation or DEFAULT_LEVEL if truth else "",
                options.registration,
            ),
            warnings=[*setup.context.log.warnings, *lost],
        )

    def _close_recorder(self) -> list[str]:
        """Close the recorder; returns what is missing in the recording, a line each."""
        if (recorder := self._recorder) is None:
            return []
        missing = f"the recording lacks {counted(recorder.dropped, 'tick')}: writing was too slow"
        problems = [missing] if recorder.dropped else []
        try:
            recorder.close()
        except RecorderError as error:
            problems.append(str(error))
        return problems


def tell(text: str) -> None:
    """Print a line for the person at the terminal."""
    with suppress(OSError):  # the terminal is gone
        Terminal(stderr=True).say(text)


def _absolute(named: Path | str | None) -> Path | str | None:
    """A file by a path that is good from every folder; what is no file stays as it is."""
    return Path(named).resolve() if named and isfile(named) else named

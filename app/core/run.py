"""The life of a run: make its folder, run the session, tell the observers, write the summary."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext, suppress
from dataclasses import asdict, dataclass
from os.path import isfile
from pathlib import Path

from app.core.base_lag import BaseLag
from app.core.decisions import RecordedDecisions
from app.core.files.folder import RECORDING, SUMMARY, VIEWER_LOG, make_folder, texts
from app.core.files.outputs import Outputs
from app.core.interrupts import interrupts, leave, terminal_settings
from app.core.measurements import Measurements
from app.core.outcome import End, Outcome
from app.core.session import Session, Tick
from app.core.setup import Setup, delivered, supports
from app.core.snapshots import Snapshots
from app.core.summary import Result, Summary, localised_by, summarise
from app.live import (
    Observer,
    OperatorConsole,
    Recorder,
    RecorderError,
    RunDisplay,
    RunInfo,
    ShownRun,
    Viewer,
)
from app.run_options import RunOptions
from app.terminal import Terminal
from config import counted
from controller import HolisticController, RobotModel
from hw import DEFAULT_LEVEL, Backend, stopwatch
from robots import load_real_robot
from trees.language import Task, TreeNode

_SHORT_PATIENCE = 1.0  # time for the disk to write the rest of an abandoned run [s]


class Watchers:
    """Calls who watches; one that raises is reported and not called again, and the run goes on."""

    def __init__(self) -> None:
        self._failed: dict[str, str] = {}

    def tell(self, name: str, call: Callable[..., object], *args: object) -> None:
        """Call somebody by a name for people, unless it has failed before."""
        if name in self._failed:
            return
        try:
            call(*args)
        except BaseException as error:  # whatever it is, the robot must go on
            self._failed[name] = f"{name} ended early ({type(error).__name__}: {error})"

    @property
    def failures(self) -> tuple[str, ...]:
        """One text for each that failed."""
        return tuple(self._failed.values())


class Instruments:
    """Hooks of a bench into a run, to measure or disturb it; these do nothing."""

    def opened(self, backend: Backend) -> Backend:
        """What is run in place of a robot in its world, not yet connected."""
        return backend

    def controller(self, model: RobotModel) -> HolisticController:
        """The controller."""
        return HolisticController(model)

    def begin(self, setup: Setup, nodes: Sequence[TreeNode]) -> None:
        """Called before the first tick, when the robot is connected."""

    def after(self, tick: Tick) -> None:
        """Called after every tick."""


@dataclass(kw_only=True, eq=False)
class Run:
    """One run of a task on a connected robot."""

    options: RunOptions
    task: Task
    setup: Setup
    nodes: Sequence[TreeNode]
    info: RunInfo
    shown: ShownRun
    console: OperatorConsole
    observers: Mapping[str, Observer]
    viewer: Viewer
    instruments: Instruments
    interrupted: Callable[[], bool]  # whether to end, asked at every tick

    def __post_init__(self) -> None:
        setup = self.setup
        self._supports, self._began = supports(setup.truth), setup.clock.now()
        self._snapshots = Snapshots(self.nodes, setup.truth)
        self._measurements = Measurements(limits=setup.context.model.limits)
        self._base_lag = BaseLag(setup.robot.description.base.lag)
        self._watchers = Watchers()

    def execute(self) -> Result:
        """Run the task; the outcome, the summary and the folder of the run."""
        setup = self.setup
        self.instruments.begin(setup, self.nodes)
        self._folder = self._make_folder()
        self._outputs = self._make_outputs()
        self._recorder = self._make_recorder()
        begun, self._terminal = stopwatch(), terminal_settings()
        with (
            self.viewer.showing(self._folder / VIEWER_LOG),
            self.console.open(),
            interrupts(self.console.leave, setup.robot.stop, End.INTERRUPTED.exit_code),
            self._make_display() as self._display,
        ):
            outcome = Session(
                setup,
                self.console.root,
                RecordedDecisions(self.console.control, setup.robot),
                self._watch,
                measurements=self._measurements,
                abandon=self._abandon,
            ).run()
            for name, observer in self.observers.items():
                self._watchers.tell(name, observer.finish)
            real_seconds = stopwatch() - begun - self._measurements.paused_s
            self._outputs.end(outcome, setup.clock.session.now())
            summary = self._summary(outcome, real_seconds)
        return Result(outcome, summary.kept(self._folder / SUMMARY), self._folder)

    def _watch(self, tick: Tick) -> None:
        """Tell everybody about a tick."""
        if self.interrupted():
            self.console.control.stop()
        tell = self._watchers.tell
        tell("the instruments", self.instruments.after, tick)
        state, now = tick.state, self.setup.clock.session.now()
        followed = state.stamp, state.base_twist, now, tick.applied.base_twist
        tell("the lag of the base", self._base_lag.note, *followed)
        tell("what watches the run", self._show, tick)

    def _show(self, tick: Tick) -> None:
        console, tell = self.console, self._watchers.tell
        why = console.control.state.why or "by a person"  # who may have resumed just now
        seen = self._snapshots.of(tick, why if tick.paused else "")
        self._outputs.update(seen)
        console.control.node_changed(seen.changed)
        for name, frame in seen.pictures:
            tell("the pictures", self._outputs.picture, name, frame)
        if (recorder := self._recorder) is not None:
            tell("the recording", recorder.record, seen)
        tell("the controls", console.show, seen)
        for name, observer in self.observers.items():
            tell(name, observer.show, seen)
        if (display := self._display) is not None:
            tell("the terminal", display.show, seen)

    def _abandon(self, outcome: Outcome) -> None:
        """End the process because a tick does not return; called from another thread."""
        setup = self.setup
        message = f"{outcome.reason}; the run is abandoned"
        try:
            self._watchers.tell("the terminal", tell, message)
            self._outputs.end(outcome, setup.clock.session.now())
            self._outputs.close(_SHORT_PATIENCE)
        finally:
            leave(setup.robot.stop, outcome.end.exit_code, self._terminal)

    def _make_folder(self) -> Path:
        options, task, real = self.options, self.task, load_real_robot(self.options.robot)
        paths = {"map": options.map or (real.map if real else None)}
        paths["scene"] = options.scene if self.setup.of_scene else None
        paths["weights"] = options.weights
        chosen = asdict(options) | {key: _absolute(one) for key, one in paths.items()}
        chosen |= {
            "world": self.setup.world,
            "real_time": self.setup.clock.session.is_real,
            "pace": self.setup.robot.description.pace,
        }
        return make_folder(
            options.record, task.name, texts(task, options.places, options.robot), chosen
        )

    def _make_outputs(self) -> Outputs:
        return Outputs(
            self._folder,
            task=self.task.name,
            nodes=self.nodes,
            robot=self.setup.robot,
            attended=self.console.control.attended,
            lossless=not self.setup.clock.session.is_real,
            frames=self.options.replayable,
        )

    def _make_recorder(self) -> Recorder | None:
        if not self.options.recording:
            return None
        return Recorder(
            self._folder / RECORDING,
            tree=self.shown.tree,
            model=RobotModel(self.setup.robot.description),
            scene=self.shown.scene,
            lossless=not self.setup.clock.session.is_real,
            server=self.viewer.server,
        )

    def _make_display(self) -> AbstractContextManager[RunDisplay | None]:
        if not self.options.shown:
            return nullcontext()
        return RunDisplay(self.info, self.shown.tree)

    def _summary(self, outcome: Outcome, real_seconds: float) -> Summary:
        """Close recorder and outputs, and summarise the run."""
        setup, options, truth = self.setup, self.options, self.setup.truth
        lost = [*self._watchers.failures, *self._close_recorder(), *self._outputs.close()]
        lost += filter(None, [self._measurements.failed_stop, self._base_lag.told])
        return summarise(
            outcome,
            self._measurements,
            setup.context.log,
            truth.touches if truth else (),
            refusals=setup.gate.refusals,
            duration=setup.clock.now().since(self._snapshots.began or self._began),
            real_seconds=real_seconds,
            task=self.task.name,
            robot=setup.robot.description.name,
            world=setup.world,
            scene=str(options.scene) if truth else setup.map,
            seed=options.seed if truth else None,
            objects=len(self._supports) if truth else None,
            placed=delivered(self._supports, supports(truth)) if truth else None,
            lies_on=dict(supports(truth)),
            paused_s=round(setup.clock.paused_s, 3),
            perception_s=round(setup.context.vision.seconds, 2),
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

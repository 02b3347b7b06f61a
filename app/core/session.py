"""Control loop: read the robot, tick the tree, step the controller, send through the gate.

Only the session commands motion. `Session.run` never raises: the end of the tree, an exception or
an interrupt becomes an outcome, and the robot is at rest when it returns. While paused, the loop
runs without the tree and brings the robot to rest as well.
"""

import gc
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from math import ceil

import numpy as np
from py_trees.behaviour import Behaviour
from py_trees.common import Status

from app.core.decisions import Decisions
from app.core.measurements import Measurements
from app.core.outcome import End, Outcome, Stage, last_ticked, outcome_of
from app.core.setup import Setup
from behaviours import Context, Intent
from config.poses import MapPose
from controller import Command, KinematicState, MotionGoal, StepReport
from hw import (
    SIMULATION,
    FaultKind,
    HardwareError,
    LoopBlockedError,
    Patience,
    Refusal,
    RobotState,
    Watchdog,
    stopwatch,
)
from trees.language import failed_node, intent_of

_LONGEST_STOP = 3.0  # longest time to come to rest [s]
_AT_REST = 1e-3  # slower is at rest [m/s or rad/s]


@dataclass(frozen=True, kw_only=True, eq=False)
class Tick:
    """One iteration of the loop, for observers."""

    number: int
    state: RobotState
    applied: Command
    report: StepReport
    goal: MotionGoal[MapPose] | None  # on the map; None while it is to rest
    context: Context
    seconds: float  # real time from the reading to the command [s]
    paused: bool  # whether the task's clock is held because a person has paused the tree
    too_slow: str = ""  # that the computer does not keep real time, for people


class NobodyHereError(HardwareError):
    """Only a person could let the run continue, and nobody attends it."""


class Session:
    """Runs one tree on one robot.

    The loop runs on the session clock, which is that of the task and held while paused. `control`
    are the decisions of people, asked every tick; `watch` is called after every tick and must not
    raise; `abandon` is called from another thread when a tick never returns, and ends the process.
    """

    def __init__(
        self,
        setup: Setup,
        root: Behaviour,
        control: Decisions,
        watch: Callable[[Tick], None] = lambda tick: None,
        *,
        measurements: Measurements | None = None,
        abandon: Callable[[Outcome], None] = lambda outcome: None,
    ) -> None:
        self._root, self._control = root, control
        self._context, self._clock = setup.context, setup.clock
        self._controller, self._gate = setup.controller, setup.gate
        self._measurements = measurements or Measurements(limits=setup.context.model.limits)
        patience = Patience() if self._clock.session.is_real else SIMULATION
        self._watchdog = Watchdog(
            self._context.robot.stop,
            lambda: abandon(self._outcome_of(LoopBlockedError())),
            patience,
        )
        self._watch = watch
        self._number, self._due, self._origin, self._began = 0, 0, 0.0, stopwatch()
        self._period, self._slipped = setup.controller.settings.period, 0.0
        self._stage = Stage.READ
        self._report: StepReport | None = None
        self._goal: MotionGoal[MapPose] | None = None  # on the map

    def run(self) -> Outcome:
        """Tick until the tree ends, an error or an interrupt, and bring the robot to rest."""
        self._origin, self._began = self._clock.session.now(), stopwatch()
        with _frozen_garbage(), ExitStack() as watched:
            outcome = self._guarded(lambda: self._run_tree(watched))
            rest = outcome
            if outcome.end in (End.SUCCESS, End.FAILURE):
                rest = self._guarded(self._come_to_rest)
            if rest.end is not End.SUCCESS:
                rest = self._guarded(self._brake)
            if rest.end is not End.SUCCESS:
                self._guarded(self._stop_robot)
            halted = self._guarded(self._halt_tree)
        self._clock.begin_tick()
        self._measurements.stalls = self._watchdog.stalls
        self._measurements.failed_stop = self._watchdog.failure
        return next((e for e in (outcome, rest, halted) if e.end is not End.SUCCESS), outcome)

    def _guarded(self, part: Callable[[], Outcome]) -> Outcome:
        """Run a part of the session; an exception becomes an outcome."""
        try:
            return part()
        except BaseException as error:  # the robot may be moving: nothing passes
            return self._outcome_of(error)

    def _outcome_of(self, error: BaseException) -> Outcome:
        too_slow = self._measurements.too_slow
        return outcome_of(error, self._stage, self._root, self._context, too_slow)

    def _run_tree(self, watched: ExitStack) -> Outcome:
        watched.enter_context(self._watchdog)
        while not self._control.stopped:
            if not self._tick():
                continue
            if self._root.status is Status.SUCCESS:
                return Outcome(end=End.SUCCESS, reason=self._root.feedback_message)
            if self._root.status is not Status.RUNNING:
                node = failed_node(self._root)
                why = node.feedback_message
                return Outcome(end=End.FAILURE, reason=why, node=node.name, where=node)
        why, where = "told to stop", last_ticked(self._root)
        return Outcome(end=End.INTERRUPTED, reason=why, where=where)

    def _tick(self) -> bool:
        context = self._context
        begun = stopwatch()
        state, now = self._read()
        if self._is_refused(state, now, begun):
            return False
        self._handle_faults(state)
        turn, intent = self._control.take_turn(), None
        if turn:
            self._clock.release()
            context.begin_tick(state)
            self._stage = Stage.TREE
            intent = intent_of(self._root, context)
        else:
            self._clock.hold()
            context.read(state)
        report = self._step(state, now, intent)
        if turn:
            context.end_tick(report)
        self._end_tick(state, begun, paused=not turn)
        return turn

    def _is_refused(self, state: RobotState, now: float, begun: float) -> bool:
        """Whether a reading cannot be believed: then nobody sees it, and the robot brakes."""
        if self._gate.judge(state, now) is not Refusal.READING:
            return False
        self._stage = Stage.SEND
        self._gate.send(self._gate.applied, state, now)
        self._wait(begun, paused=False)
        return True

    def _read(self) -> tuple[RobotState, float]:
        """The newest reading, with the fault of a lost robot, and the moment of this tick [s]."""
        self._watchdog.feed()
        self._stage = Stage.READ
        state = self._context.robot.read()
        if (lost := self._context.localisation.agreement.fault) is not None:
            state = replace(state, faults=(*state.faults, lost))
        return state, self._clock.begin_tick()

    def _step(self, state: RobotState, now: float, intent: Intent | None) -> StepReport:
        self._stage = Stage.CONTROL
        last = self._gate.continue_from(state, now)
        context, localisation = self._context, self._context.localisation
        here = KinematicState(localisation.mTb, state.q)
        self._goal = localisation.on_map(intent and intent.goal)
        command, self._report = self._controller.step(here, self._goal, last, context.surroundings)
        self._stage = Stage.SEND
        self._gate.send(command, state, self._clock.session.now())
        self._stage = Stage.WATCH
        return self._report

    def _handle_faults(self, state: RobotState) -> None:
        """Pause for faults that only a person may clear; NobodyHereError if nobody can."""
        faults = [fault for fault in state.faults if not fault.clearable]
        if self._gate.latched:
            pressed = [fault for fault in faults if fault.kind is FaultKind.EMERGENCY_STOP]
            text = pressed[0].text if pressed else "emergency stop"
            if not self._control.attended:
                raise NobodyHereError(f"{text}; nobody is here to acknowledge it")
            if self._control.emergency_stop(text, pressed=bool(pressed)):
                self._gate.acknowledge()
        elif faults and self._control.attended:
            self._control.pause(faults[0].text)
            self._context.localisation.agreement.acknowledge()  # by who resumes
        elif text := self._context.memory.faults.given_up:
            if not self._control.attended:
                raise NobodyHereError(f"{text}; nobody is here to see to it")
            self._control.pause(f"{text}; see to it, then resume")
            self._context.memory.faults.acknowledge()  # as nothing goes on before a person resumes

    def _end_tick(self, state: RobotState, begun: float, *, paused: bool) -> None:
        measurements, applied = self._measurements, self._gate.applied
        seconds = stopwatch() - begun
        measurements.reading(state)
        if not paused:
            measurements.ticks_s.append(seconds)
        if self._report is not None:
            tick = Tick(
                number=self._number,
                state=state,
                applied=applied,
                report=self._report,
                goal=self._goal,
                context=self._context,
                seconds=seconds,
                paused=self._clock.held,
                too_slow=measurements.too_slow,
            )
            self._watch(tick)
        measurements.late_ticks += not paused and stopwatch() - begun > self._period
        self._number += 1
        self._wait(begun, paused=paused)

    def _wait(self, begun: float, *, paused: bool) -> None:
        clock, period = self._clock.session, self._period
        if paused:
            self._control.wait(period - (stopwatch() - begun))
            self._measurements.paused_s += stopwatch() - begun
        self._due += 1
        due = self._origin + self._due * period
        late = clock.now() - due
        if clock.is_real and 0.0 < late < period:  # the next command may not follow any sooner
            self._origin, self._slipped = self._origin + late, self._slipped + late * (not paused)
        clock.sleep_until(due)
        late = clock.now() - due
        if late >= period * (1.0 - 1e-6):  # up to the next moment: other threads want time, too
            missed = ceil(late / period - 1e-6)
            self._due += missed
            clock.sleep_until(due + missed * period)
            self._measurements.missed_ticks += 0 if paused else missed
        real = stopwatch() - self._began - self._measurements.paused_s
        lost = clock.lost + self._measurements.missed_ticks * period + self._slipped
        self._measurements.keep_time(real, lost, robot_waits=not clock.is_real)

    def _come_to_rest(self) -> Outcome:
        for _ in range(round(_LONGEST_STOP / self._period)):
            begun = stopwatch()
            state, now = self._read()
            if self._is_refused(state, now, begun):
                continue
            self._context.begin_tick(state)
            self._context.end_tick(self._step(state, now, None))
            self._end_tick(state, begun, paused=False)
            if _is_at_rest(state):
                return Outcome(end=End.SUCCESS, reason="at rest")
        return _still_moving()

    def _brake(self) -> Outcome:
        self._goal = None
        for _ in range(round(_LONGEST_STOP / self._period)):
            begun = stopwatch()
            try:
                state, now = self._read()
            except LoopBlockedError:
                raise
            except BaseException:  # without readings the gate brakes all the same
                self._gate.brake(None, self._clock.session.now())
                self._wait(begun, paused=False)
                continue
            self._gate.brake(state, now)
            self._end_tick(state, begun, paused=False)
            if _is_at_rest(state):
                return Outcome(end=End.SUCCESS, reason="at rest")
        return _still_moving()

    def _halt_tree(self) -> Outcome:
        self._stage = Stage.TREE
        self._root.stop(Status.INVALID)
        return Outcome(end=End.SUCCESS, reason="halted")

    def _stop_robot(self) -> Outcome:
        self._stage = Stage.SEND
        self._context.robot.stop()
        return Outcome(end=End.SUCCESS, reason="stopped")


def _is_at_rest(state: RobotState) -> bool:
    return bool(np.abs((*state.base_twist, *state.qd)).max() < _AT_REST)  # NaN is not at rest


def _still_moving() -> Outcome:
    why = f"the robot still moves after {_LONGEST_STOP:g} s of braking"
    return Outcome(end=End.HARDWARE, reason=why)


@contextmanager
def _frozen_garbage() -> Iterator[None]:
    """Exclude existing objects from garbage collection, which would delay ticks by up to 0.1 s.

    What the process had frozen before stays so.
    """
    is_first = not gc.get_freeze_count()
    gc.freeze()
    try:
        yield
    finally:
        if is_first:
            gc.unfreeze()

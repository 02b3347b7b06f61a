"""The loop: read the robot, tick the tree, step the controller, pass the gate; again.

It is the only place that commands motion. Whatever happens, an end of the tree, an exception in a
leaf, an interrupt, the robot is brought to rest within its limits before `run` returns. While the
run is paused the loop goes on without the tree, which brings the robot to rest as well.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from traceback import format_exception

import numpy as np
from py_trees.behaviour import Behaviour
from py_trees.common import Status

from app.core.decisions import Decisions
from app.core.measurements import Measurements
from app.core.outcome import End, Outcome
from behaviours import Context, LeafCrashedError
from controller import Command, GoalError, HolisticController, StepReport
from hw import Gate, HardwareError, RobotState, TaskClock, stopwatch
from trees.language import Branch

_LONGEST_STOP = 3.0
"""Coming to rest is given up after this [s]."""
_AT_REST = 1e-3
"""Slower than this is at rest [m/s or rad/s]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Tick:
    """One iteration of the loop, for those who watch."""

    number: int
    state: RobotState
    applied: Command
    report: StepReport
    context: Context
    seconds: float
    """Real time from the reading to the command [s]."""
    paused: bool
    """Whether a person keeps the tree from being ticked."""


class Session:
    """Runs one tree on one robot.

    Args:
        root: the built tree.
        context: what its leaves share.
        controller: turns their goal into velocities.
        gate: stands before the robot.
        measurements: what is measured on the way.
        clock: the task's clock, held while paused; the loop itself runs on the session's behind it.
        control: what people want; asked every tick.
        watch: called after every tick.
    """

    def __init__(
        self,
        *,
        root: Behaviour,
        context: Context,
        controller: HolisticController,
        gate: Gate,
        measurements: Measurements,
        clock: TaskClock,
        control: Decisions,
        watch: Callable[[Tick], None],
    ) -> None:
        self._root = root
        self._context = context
        self._controller = controller
        self._gate = gate
        self._measurements = measurements
        self._clock = clock
        self._control = control
        self._watch = watch
        self._number = 0
        self._period = controller.settings.period

    def run(self) -> Outcome:
        """Tick until the tree ends or something else does, and bring the robot to rest."""
        outcome = self._guarded(self._run_tree)
        rest = self._guarded(self._come_to_rest)
        self._root.stop(Status.INVALID)
        if rest.end is not End.SUCCESS:
            self._context.robot.stop()
            return rest if outcome.end is End.SUCCESS else outcome
        return outcome

    def _guarded(self, part: Callable[[], Outcome]) -> Outcome:
        """Run a part of the session and put a name to whatever it raises."""
        try:
            return part()
        except LeafCrashedError as error:
            trace = "".join(format_exception(error.__cause__))
            leaf = last_ticked(self._root)
            return Outcome(
                end=End.CRASH, reason=str(error), node=error.leaf, where=leaf, trace=trace
            )
        except GoalError as error:
            setter = self._context.goal_of[0] if self._context.goal_of else None
            where = setter if isinstance(setter, Behaviour) else None
            name = where.name if where else ""
            return Outcome(end=End.CRASH, reason=str(error), node=name, where=where)
        except HardwareError as error:
            return Outcome(end=End.HARDWARE, reason=str(error), where=last_ticked(self._root))

    def _run_tree(self) -> Outcome:
        while not self._control.stopped:
            if not self._control.take_turn():
                self._clock.hold()
                self._tick(None)
                continue
            self._clock.release()
            self._tick(self._root.tick_once)
            if self._root.status is Status.SUCCESS:
                return Outcome(end=End.SUCCESS, reason=self._root.feedback_message)
            if self._root.status is not Status.RUNNING:
                node = failed_node(self._root)
                reason = node.feedback_message
                return Outcome(end=End.FAILURE, reason=reason, node=node.name, where=node)
        where = last_ticked(self._root)
        return Outcome(end=End.INTERRUPTED, reason="interrupted by a person", where=where)

    def _come_to_rest(self) -> Outcome:
        """Tick without the tree until nothing moves."""
        for _ in range(round(_LONGEST_STOP / self._period)):
            state = self._tick(lambda: None)
            if max(np.abs(state.base_twist).max(), np.abs(state.qd).max()) < _AT_REST:
                return Outcome(end=End.SUCCESS, reason="at rest")
        return Outcome(
            end=End.HARDWARE, reason=f"the robot still moves after {_LONGEST_STOP:g} s of braking"
        )

    def _tick(self, tick_tree: Callable[[], None] | None) -> RobotState:
        """One turn of the loop; returns the reading that it began with.

        Without `tick_tree` the run is paused: the robot comes to rest, and the context keeps goal
        and report, so that the leaf that continues finds the last report of the controller.
        """
        context, clock = self._context, self._clock.session
        begun = stopwatch()
        state = context.robot.read()
        self._measurements.reading(state)
        if tick_tree is None:
            context.state, goal = state, None
        else:
            context.begin_tick(state)
            tick_tree()
            goal = context.goal
        command, report = self._controller.step(state, goal, self._gate.applied)
        applied = self._gate.send(command, state, clock.now())
        if tick_tree is not None:
            context.end_tick(report)
        seconds = stopwatch() - begun
        self._measurements.ticks_s.append(seconds)
        self._watch(
            Tick(
                number=self._number,
                state=state,
                applied=applied,
                report=report,
                context=context,
                seconds=seconds,
                paused=tick_tree is None,
            )
        )
        self._measurements.late_ticks += stopwatch() - begun > self._period
        self._number += 1
        if tick_tree is None:
            self._control.wait(self._period - (stopwatch() - begun))
        clock.sleep_until(self._number * self._period)
        return state


def failed_node(root: Behaviour) -> Behaviour:
    """The deepest node that made a failed tree fail: down the last failed child of each node."""
    node = root
    while failed := [child for child in node.children if child.status is Status.FAILURE]:
        node = failed[-1]
    return node


def last_ticked(root: Behaviour) -> Behaviour:
    """The leaf that was ticked last, or was being ticked when an exception came."""
    node = root
    while isinstance(node, Branch) and node.current_child is not None:
        node = node.current_child
    return node

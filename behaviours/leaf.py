"""What every leaf of a task tree is, and how the tree language finds it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar

import py_trees
from py_trees.common import Status

from behaviours.context import Context
from controller import MotionGoal, StepReport
from hw import HardwareError, LoopBlockedError


class LeafCrashedError(Exception):
    """A leaf raised an exception: a mistake in its code, not in the task.

    Args:
        leaf: name of the node.
        error: what it raised.
    """

    def __init__(self, leaf: str, error: BaseException) -> None:
        super().__init__(f"{type(error).__name__}: {error}")
        self.leaf = leaf


class Leaf(py_trees.behaviour.Behaviour):
    """A behaviour that sets goals and reads the state, and never commands motion itself.

    A subclass names itself by `key` and declares what a task file may say about it as the
    keyword-only parameters of its constructor: their annotations are the types, their defaults the
    defaults, the `Args:` section of the class their descriptions. A parameter annotated `Key[T]` is
    a result that it writes.

    Args:
        name: the node's name in the tree.
        context: what all leaves of the tree share.
    """

    key: ClassVar[str]
    """The node's key in a task file, for example `navigate`."""

    def __init__(self, name: str, context: Context) -> None:
        super().__init__(name)
        self.context = context
        self.settings = context.settings

    def tick(self) -> Iterator[py_trees.behaviour.Behaviour]:
        """Tick once.

        Raises:
            LeafCrashedError: the leaf raised an exception; it says which leaf.
            HardwareError, KeyboardInterrupt: as they are; those are not the leaf's mistakes.
        """
        try:
            yield from super().tick()
        except (HardwareError, LeafCrashedError):
            raise
        except (KeyboardInterrupt, GeneratorExit, LoopBlockedError):
            raise
        except BaseException as error:  # a leaf that calls `sys.exit` crashes like any other
            raise LeafCrashedError(self.name, error) from error

    def running(self, message: str) -> Status:
        """Say what is under way."""
        self.feedback_message = message
        return Status.RUNNING

    def success(self, message: str) -> Status:
        """End well, saying how."""
        self.feedback_message = message
        return Status.SUCCESS

    def failure(self, reason: str) -> Status:
        """End badly, saying why."""
        self.feedback_message = reason
        return Status.FAILURE

    def fault(self) -> str | None:
        """What keeps the robot from moving, in words; None if nothing does."""
        return "; ".join(fault.text for fault in self.context.state.faults) or None

    @property
    def gripper_is_open(self) -> bool:
        """Whether the fingers count as open."""
        opening = self.context.robot.description.gripper.opening
        return self.context.state.gripper_width >= self.settings.fingers.open_share * opening

    @property
    def gripper_is_closed(self) -> bool:
        """Whether the fingers are so near to each other that they hold nothing."""
        return self.context.state.gripper_width < self.settings.fingers.closed

    def open_gripper(self) -> None:
        """Set the fingers moving to fully open; `fingers` tells when they rest."""
        opening = self.context.robot.description.gripper.opening
        self.grip(opening, self.settings.fingers.opening_force)

    def grip(self, width: float, force: float) -> None:
        """Set the fingers moving to a width [m] by a force [N]; `fingers` tells when they rest."""
        self.context.robot.grip(width, force)
        self._gripping_since = self.context.clock.now()

    def fingers(self, what: str) -> Status | None:
        """Wait for the fingers that `grip` has set moving.

        Args:
            what: they are doing, for example `closing`.

        Returns:
            RUNNING while they move, FAILURE when they move for too long, None once they rest.
        """
        state, waited = self.context.state, self.context.clock.now() - self._gripping_since
        patience = self.settings.fingers.patience
        if state.gripper_moving and waited > patience:
            return self.failure(f"the fingers still move after {patience:g} s")
        if state.gripper_moving or waited <= 0.0:
            return self.running(f"{what}, {1000 * state.gripper_width:.0f} mm")
        return None

    def pursue(self, goal: MotionGoal, phase: str = "") -> StepReport | None:
        """Leave a goal for the coming period.

        Args:
            goal: where to go.
            phase: which part of the behaviour it belongs to.

        Returns:
            The report of the controller about the goal of the last tick; None if that was not this
            leaf's or belonged to another phase.
        """
        context = self.context
        context.goal, context.goal_of = goal, (self, phase)
        return context.report if context.report_of == (self, phase) else None


class Condition(Leaf):
    """A question about the present state: success is yes, failure is no.

    It answers within the tick and leaves no goal, so it may be asked at any time: only a condition
    can guard a node (`while`, `unless`).
    """

    def tick(self) -> Iterator[py_trees.behaviour.Behaviour]:
        """Ask once.

        Raises:
            LeafCrashedError: as for every leaf, and when there is no answer yet.
        """
        yield from super().tick()
        if self.status is Status.RUNNING:
            raise LeafCrashedError(self.name, TypeError("a condition answers within one tick"))

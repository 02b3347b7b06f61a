"""What every leaf of a task tree is, and how the tree language finds it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import ClassVar

import py_trees
from py_trees.common import Status

from behaviours.context import Context
from behaviours.errors import LeafCrashedError, TwoGoalsError
from controller import MotionGoal, StepReport
from hw import HardwareError, LoopBlockedError


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
    goes_to: ClassVar[tuple[str, ...]] = ()
    """The parameters that name where the hand, the base or the arm has to get: `check` makes sure
    that the robot can be there."""
    surfaces: ClassVar[tuple[str, ...]] = ()
    """The parameters that name a region on whose floor something stands: `check` makes sure that
    there is a surface."""
    alike: ClassVar[tuple[str, ...]] = ()
    """The parameters that are compared, and so have values of one kind."""
    lasts: ClassVar[str] = ""
    """The parameter that says how long it takes at least [s]; empty if none does."""
    moves: ClassVar[bool] = True
    """Whether it may leave a goal. Of those that run at the same time only one may."""
    needs_robot: ClassVar[bool] = True
    """Whether it needs more than its arguments, the time and the log: a dry run runs the others."""
    is_condition: ClassVar[bool] = False
    """Whether it is a question about the present state; see `Condition`."""

    def __init__(self, name: str, context: Context) -> None:
        super().__init__(name)
        self.context = context
        self.settings = context.settings
        self.out_of_reach = False
        """Whether it has failed because nothing can get where it is to go."""

    @staticmethod
    def misfit(arguments: Mapping[str, object]) -> str:
        """What is wrong with arguments that are right one by one, then `; ` and a hint; or empty.

        `check` asks it before a run.

        Args:
            arguments: those that are given, by name; a value that is known only while the task runs
                is the `Key` that it comes from.
        """
        return ""

    @property
    def phase(self) -> str:
        """Which part of its work the leaf is in while it runs; empty if it has but one."""
        return ""

    def tick(self) -> Iterator[py_trees.behaviour.Behaviour]:
        """Tick once.

        Raises:
            LeafCrashedError: the leaf raised an exception; it says which leaf.
            HardwareError, KeyboardInterrupt: as they are; those are not the leaf's mistakes.
        """
        self.out_of_reach = False
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

    @property
    def fingers_have_opened(self) -> bool:
        """Whether something has pressed the fingers apart that were told to close."""
        width, closing = self.context.state.gripper_width, self.context.log.closing
        return closing is not None and width - closing.narrowest > self.settings.fingers.slack

    @property
    def empty_hand(self) -> str | None:
        """Why the hand holds nothing, in words; None if all that is known says that it does.

        An object keeps the fingers from getting where they were told to close to, after they have
        moved. What they hold when a task begins is known by their width alone.
        """
        width, closing = self.context.state.gripper_width, self.context.log.closing
        least = self.settings.fingers.least_motion
        if self.gripper_is_closed:
            return "the fingers closed on nothing"
        if closing is None:
            return "the fingers are open" if self.gripper_is_open else None
        if closing.begun_at - closing.narrowest < least:
            return "the fingers did not move"
        if self.fingers_have_opened:
            return "the fingers have opened"
        return "nothing stopped the fingers" if width - closing.target < least else None

    def open_gripper(self) -> None:
        """Set the fingers moving to fully open; `fingers` tells when they rest."""
        opening = self.context.robot.description.gripper.opening
        self.grip(opening, self.settings.fingers.opening_force)

    def opens_by(self, enough: float) -> float:
        """How far the fingers can open from here, or what is enough if that is less [m]."""
        fingers, opening = self.settings.fingers, self.context.robot.description.gripper.opening
        left = fingers.open_share * opening - self.context.state.gripper_width
        return max(min(enough, left), fingers.least_motion)

    def grip(self, width: float, force: float) -> None:
        """Set the fingers moving to a width [m] by a force [N]; `fingers` tells when they rest."""
        self.context.log.gripped(width, self.context.state.gripper_width)
        self.context.robot.grip(width, force)
        self._gripping_since = self.context.clock.now()

    def fingers(self, what: str) -> Status | None:
        """Wait for the fingers that `grip` has set moving.

        Args:
            what: they are doing, for example `closing`.

        Returns:
            RUNNING while they move, FAILURE when they do not move at all or for too long, None
            once they rest.
        """
        state, waited = self.context.state, self.context.clock.now() - self._gripping_since
        settings, grip = self.settings.fingers, self.context.log.grip
        has_moved = grip is not None and grip.moved >= settings.least_motion
        patience = settings.patience if state.gripper_moving else settings.start_patience
        if waited <= 0.0 or ((state.gripper_moving or not has_moved) and waited <= patience):
            return self.running(f"{what}, {1000 * state.gripper_width:.0f} mm")
        if not has_moved:
            return self.failure("the fingers did not move")
        if state.gripper_moving:
            return self.failure(f"the fingers still move after {patience:g} s")
        return None

    def pursue(self, goal: MotionGoal, phase: str = "") -> StepReport | None:
        """Leave a goal for the coming period.

        Args:
            goal: where to go.
            phase: which part of the behaviour it belongs to.

        Returns:
            The report of the controller about the goal of the last tick; None if that was not this
            leaf's or belonged to another phase.

        Raises:
            LeafCrashedError: another leaf that still runs has left a goal in this tick.
        """
        context = self.context
        other = context.goal_of[0] if context.goal_of else self
        if isinstance(other, Leaf) and other is not self and other.status is Status.RUNNING:
            error = TwoGoalsError(
                f"`{other.name}` and `{self.name}` both move the robot at the same time; "
                "let one run after the other"
            )
            raise LeafCrashedError(self.name, error) from error
        context.goal, context.goal_of = goal, (self, phase)
        return context.report if context.report_of == (self, phase) else None


class Condition(Leaf):
    """A question about the present state: success is yes, failure is no.

    It answers within the tick and leaves no goal, so it may be asked at any time: only a condition
    can guard a node (`while`, `unless`).
    """

    is_condition: ClassVar[bool] = True
    moves: ClassVar[bool] = False

    def tick(self) -> Iterator[py_trees.behaviour.Behaviour]:
        """Ask once.

        Raises:
            LeafCrashedError: as for every leaf, and when there is no answer yet.
        """
        yield from super().tick()
        if self.status is Status.RUNNING:
            raise LeafCrashedError(self.name, TypeError("a condition answers within one tick"))

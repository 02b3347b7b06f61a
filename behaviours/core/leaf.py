"""Base classes of the leaves of a task tree: `Leaf` and `Condition`."""

from collections.abc import Iterator, Mapping
from typing import ClassVar

import py_trees
from py_trees.common import Status

from behaviours.core.context import Context, Intent
from behaviours.core.errors import LeafCrashedError
from config.poses import OdometryPose
from controller import MotionGoal, StepReport
from hw import HardwareError, LoopBlockedError

CLOSED = 0.0015  # fingers nearer to each other than this hold nothing [m]
OPEN_SHARE = 0.95  # of the full opening, from which the fingers count as open
OPENING_FORCE = 20.0  # [N]
LEAST_MOTION = 0.0005  # a smaller motion of the fingers is none [m]
SLACK = 0.008  # fingers that open more have let go; less, and what they hold has turned [m]
_SETTLES = 0.003  # closed fingers that close by more have slipped off [m]
START_PATIENCE = 0.5  # a command to the fingers that has moved nothing by then has failed [s]
FINGER_PATIENCE = 3.0  # one that is not done by then has failed [s]
_PATIENCE = 1.0  # what a condition does not know by then, it will not know [s]


class Leaf(py_trees.behaviour.Behaviour):
    """A behaviour that sets goals and reads the state, and never commands motion itself.

    A subclass names itself by `key` and declares its parameters in a task file as the keyword-only
    parameters of its constructor: annotations are types, defaults defaults, and the `Args:` section
    of the class descriptions. A parameter annotated `Key[T]` is a result that it writes.

    Args:
        name: the node's name in the tree.
        context: shared by all leaves of the tree.
    """

    key: ClassVar[str]
    """The node's key in a task file, for example `navigate`."""
    goes_to: ClassVar[tuple[str, ...]] = ()
    """Parameters that name a goal pose or posture: `check` tests that the robot can reach it."""
    surfaces: ClassVar[tuple[str, ...]] = ()
    """Parameters that name a region with objects on its floor, or a point of a surface: `check`
    tests for one."""
    comparable: ClassVar[tuple[str, ...]] = ()
    """Parameters that are compared, and so need values of one type."""
    hand_before: ClassVar[str] = ""
    """What the hand has to be, `full` or `empty`, for it to do something; a condition then asks."""
    hand_after: ClassVar[str] = ""
    """What the hand is after a success, `full` or `empty`; as before without it."""
    opens_for: ClassVar[tuple[str, ...]] = ()
    """Parameters with a width that the fingers have to open to [mm]."""
    lasts: ClassVar[str] = ""
    """The parameter with the time that it always takes [s]."""
    base_rests: ClassVar[bool] = False
    """Whether the base stays where it is, or nearly so, though it moves the robot."""
    counts: ClassVar[str] = ""
    """The output with its answer, where it succeeds whatever it finds."""
    can_fail: ClassVar[bool] = True
    moves: ClassVar[bool] = True
    """Whether it may set a goal; of leaves that run at the same time only one may."""
    needs_robot: ClassVar[bool] = True
    """Whether it needs more than its arguments, the time and the log; a dry run runs the others."""
    is_condition: ClassVar[bool] = False

    def __init__(self, name: str, context: Context) -> None:
        super().__init__(name)
        self.context = context
        self.out_of_reach = False
        """Whether it has failed because its goal is unreachable."""

    @staticmethod
    def validate(arguments: Mapping[str, object]) -> str:
        """Why arguments are incompatible, then `; ` and a hint; empty if they are compatible.

        `check` calls it before a run.

        Args:
            arguments: those given, by name; a value that is known only during the run is its `Key`.
        """
        return ""

    @property
    def phase(self) -> str:
        """The phase of its work while it runs; empty if it has only one."""
        return ""

    def tick(self) -> Iterator[py_trees.behaviour.Behaviour]:
        """Tick once.

        Raises:
            LeafCrashedError: the leaf raised an exception; it names the leaf.
            HardwareError, KeyboardInterrupt: unchanged; they are no errors of the leaf.
        """
        self.out_of_reach = False
        try:
            yield from super().tick()
            if (context := self.context).log.last_grasp is not None:
                context.log.note_hand(
                    context.oTe, context.log.last_grasp, self.empty_hand, context.clock.now()
                )
        except (HardwareError, LeafCrashedError):
            raise
        except (KeyboardInterrupt, GeneratorExit, LoopBlockedError):
            raise
        except BaseException as error:  # a leaf that calls `sys.exit` crashes like any other
            raise LeafCrashedError(self.name, error) from error

    def running(self, message: str) -> Status:
        """RUNNING, with a feedback message."""
        self.feedback_message = message
        return Status.RUNNING

    def success(self, message: str) -> Status:
        """SUCCESS, with a feedback message."""
        self.feedback_message = message
        return Status.SUCCESS

    def failure(self, reason: str) -> Status:
        """FAILURE, with a feedback message."""
        self.feedback_message = reason
        return Status.FAILURE

    def fault(self) -> str | None:
        """The texts of the robot's faults; None if there are none."""
        return "; ".join(fault.text for fault in self.context.state.faults) or None

    @property
    def gripper_is_open(self) -> bool:
        """Whether the fingers count as open."""
        opening = self.context.robot.description.gripper.opening
        return self.context.state.gripper_width >= OPEN_SHARE * opening

    @property
    def gripper_is_closed(self) -> bool:
        """Whether the fingers are closed on nothing."""
        fingers = self.context.log.fingers
        return fingers.width - fingers.empty < CLOSED

    @property
    def fingers_have_opened(self) -> bool:
        """Whether the fingers have left what they closed on: as told, or pressed apart."""
        log, width = self.context.log, self.context.log.fingers.width
        if log.closing is None or log.grip is None:
            return False
        as_told = log.grip is not log.closing and width - log.grip.begun_at > LEAST_MOTION
        return as_told or width - log.closing.narrowest > SLACK

    @property
    def empty_hand(self) -> str | None:
        """Why the hand holds nothing; None if it seems to hold something.

        An object stops the closing fingers before their target, after they have moved, and keeps
        them there. When a task begins, only their width tells.
        """
        width, closing = self.context.log.fingers.width, self.context.log.closing
        if self.gripper_is_closed:
            return "the fingers closed on nothing"
        if closing is None:
            return "the fingers are open" if self.gripper_is_open else None
        if closing.begun_at - closing.narrowest < LEAST_MOTION:
            return "the fingers did not move"
        if self.fingers_have_opened:
            return "the fingers have opened"
        if closing.rested is not None and closing.rested - width > _SETTLES:
            return f"the fingers have slipped off, from {1000 * closing.rested:.0f} mm"
        return "nothing stopped the fingers" if width - closing.target < LEAST_MOTION else None

    def open_gripper(self, most: float | None = None) -> float:
        """Start to open the fingers, to a width [m] or fully; `fingers` tells when they rest.

        Returns how far they are sure to open [m].
        """
        opening = self.context.robot.description.gripper.opening
        width = opening if most is None else min(most, opening)
        self.grip(width, OPENING_FORCE)
        return max(OPEN_SHARE * width - self.context.state.gripper_width, LEAST_MOTION)

    def let_go(self, most: float | None = None) -> float:
        """Open the fingers on purpose, see `open_gripper`: what they held is not lost."""
        self.context.memory.letting_go = self
        return self.open_gripper(most)

    def grip(self, width: float, force: float) -> None:
        """Start to move the fingers to a width [m] by a force [N]; see `fingers`."""
        self.context.log.gripped(width)
        self.context.robot.grip(width, force)
        self._gripping_since = self.context.clock.now()

    def fingers(self, what: str) -> Status | None:
        """Wait for the fingers that `grip` has started.

        Args:
            what: they are doing, for example `closing`.

        Returns:
            RUNNING while they move, FAILURE when they do not move at all or for too long, None
            once they rest.
        """
        state, waited = self.context.state, self.context.clock.now() - self._gripping_since
        grip = self.context.log.grip
        has_moved = grip is not None and grip.moved >= LEAST_MOTION
        patience = FINGER_PATIENCE if state.gripper_moving else START_PATIENCE
        if waited <= 0.0 or ((state.gripper_moving or not has_moved) and waited <= patience):
            return self.running(f"{what}, {1000 * state.gripper_width:.0f} mm")
        if not has_moved:
            return self.failure("the fingers did not move")
        if state.gripper_moving:
            return self.failure(f"the fingers still move after {patience:g} s")
        return None

    def pursue(self, goal: MotionGoal[OdometryPose], phase: str = "") -> StepReport | None:
        """Set the goal for the coming period.

        Args:
            goal: where to go.
            phase: of the leaf, that the goal belongs to.

        Returns:
            The controller's report about the goal of the last tick; None if that was not this
            leaf's, or of another phase.

        Raises:
            TwoGoalsError: another running leaf has set a goal in this tick.
        """
        now, last = self.context.now, self.context.now.last
        now.intend(Intent(goal, self, phase))
        return now.report if last and (last.owner, last.phase) == (self, phase) else None


class Condition(Leaf):
    """A test of the present state: success is yes, failure is no, running is not known.

    It sets no goal: only a condition can guard a node (`while`, `unless`). It answers on what was
    measured now; who asks decides what follows from an answer that is not known.
    """

    is_condition: ClassVar[bool] = True
    moves: ClassVar[bool] = False
    overdue = False
    """Whether the answer has not been known for a second."""

    def tick(self) -> Iterator[py_trees.behaviour.Behaviour]:
        """Tick once; raises as every leaf does."""
        now = self.context.clock.now()
        if self.status is not Status.RUNNING:
            self._asked = now
        for node in super().tick():
            self.overdue = self.status is Status.RUNNING and now - self._asked >= _PATIENCE
            yield node

    def unknown(self, why: str) -> Status:
        """RUNNING: the answer is not known, and why."""
        return self.running(f"not known: {why}")

"""Behaviours `hand_over` and `receive`: give an object to a person, and take one."""

from abc import abstractmethod
from collections.abc import Callable
from typing import Annotated, ClassVar

from py_trees.common import Status

from behaviours.core.context import Context
from behaviours.core.leaf import CLOSED, Leaf
from behaviours.core.motion import Approach
from behaviours.core.parameter_types import Bounds, Lift, Speed, Timeout, ToolPose
from config.poses import OdometryPose
from controller import PoseGoal

_PULL = 0.001  # change of their width, at rest, by which fingers that hold something are pulled [m]
_PULLING = 0.5  # that it lasts: a bump is over [s]
_CREEP = 1.0  # a slower change than `_PULL` in this time is no pull, but the object settling [s]
_FORCE = 10.0  # of the fingers that feel and take something [N]
_SQUEEZE = 1.0  # how long what was felt has to stay between the fingers [s]
_ON_THE_WAY = 60.0  # longest way to the person [s]


class _HeldOut(Leaf):
    """The hand is held out at a pose, and the fingers do something there."""

    goes_to: ClassVar[tuple[str, ...]] = ("at",)
    _step: Callable[[], Status]

    def __init__(
        self, name: str, context: Context, at: ToolPose, speed: float, timeout: float
    ) -> None:
        super().__init__(name, context)
        self._at, self._speed, self._timeout = at, speed, timeout

    @property
    def phase(self) -> str:
        """`offer` once the hand is there, and `fingers` while they move."""
        return {self._come: "", self._offer: "offer"}.get(self._step, "fingers")

    def initialise(self) -> None:
        """Set out."""
        self._approach = Approach(self, self._goal, self._at.name, _ON_THE_WAY)
        self._step = self._come

    def update(self) -> Status:
        """One tick of the phase that it is in."""
        if fault := self.fault():
            return self.failure(fault)
        if self._step != self._come:
            self.pursue(self._goal(), "offer")
        return self._step()

    def _goal(self) -> PoseGoal[OdometryPose]:
        return PoseGoal(target=self._at.oTe, speed=self._speed)

    def _come(self) -> Status:
        status = self._approach.tick()
        if status is not Status.SUCCESS:
            return status
        self._begun = self._since = self._pulled_since = self.context.clock.now()
        self._width = self.context.log.fingers.width
        self._step = self._offer
        return self.running("holding the hand out")

    @abstractmethod
    def _offer(self) -> Status:
        """One tick of the hand at rest."""

    def _opening(self) -> Status | None:
        """None once the fingers are open."""
        if self.gripper_is_open:
            return None
        width = 1000 * self.context.state.gripper_width
        stopped = f"the fingers stopped at {width:.0f} mm"
        return self.fingers("opening") or self.failure(stopped)


class HandOver(_HeldOut):
    """Hold the object out to a person, wait until it is pulled, and open the fingers.

    It is pulled when the width between the fingers changes for half a second, as it turns, and they
    still hold it. What leaves them before they open may have fallen as well. Announce it by `say`.
    Fails with the object in the hand when nobody pulls in time; fails too when nothing is held or
    it left the fingers, the hand does not get there, the fingers do not open, or on a fault.

    Args:
        at: where the hand holds it out.
        speed_m_s: largest speed of the hand on its way there [m/s].
        timeout_s: how long it waits for a person [s].
    """

    key: ClassVar[str] = "hand_over"
    hand_before: ClassVar[str] = "full"
    hand_after: ClassVar[str] = "empty"

    def __init__(
        self,
        name: str,
        context: Context,
        *,
        at: ToolPose,
        speed_m_s: Speed = 0.5,
        timeout_s: Timeout = 30.0,
    ) -> None:
        super().__init__(name, context, at, speed_m_s, timeout_s)

    def _come(self) -> Status:
        if reason := self.empty_hand:
            return self.failure(f"nothing to hand over: {reason}")
        return super()._come()

    def _offer(self) -> Status:
        now, fingers = self.context.clock.now(), self.context.log.fingers
        if fingers.rest and (reason := self.empty_hand):
            return self.failure(f"it left the fingers before they opened, and may lie: {reason}")
        is_pulled = fingers.rest and abs(fingers.width - self._width) > _PULL
        if not is_pulled:
            self._width += (fingers.width - self._width) * min(1.0, (now - self._since) / _CREEP)
            self._pulled_since = now
        elif now - self._pulled_since >= _PULLING:
            self.let_go()
            if (carried := self.context.log.in_hand) is not None:
                carried.let_go = now
            self._step = self._let_go
            return self.running("letting go")
        if now - self._begun > self._timeout:
            return self.failure(f"nobody took it within {self._timeout:g} s")
        self._since = now
        return self.running(f"holding it out for {now - self._begun:.0f} s")

    def _let_go(self) -> Status:
        return self._opening() or self.success(f"handed over at {self._at.name}")


class Receive(_HeldOut):
    """Hold the open hand out to a person, and take what is between the fingers.

    Nothing sees there, so the fingers feel: they close gently again and again, and stay closed on
    what stops them wider apart than they closed on nothing before the hand set out, and still is
    there when they press again; else they open. Announce it by `say`. Fails when nothing is given
    in time, the hand does not get there, the fingers do not move, or on a fault.

    Args:
        at: where the hand is held out.
        every_s: how long the hand is open before the fingers feel [s].
        hangs_m: how far what is given may reach below the hand; `place` stops so high [m].
        speed_m_s: largest speed of the hand on its way there [m/s].
        timeout_s: how long it waits for a person [s].
    """

    key: ClassVar[str] = "receive"
    hand_before: ClassVar[str] = "empty"
    hand_after: ClassVar[str] = "full"

    def __init__(
        self,
        name: str,
        context: Context,
        *,
        at: ToolPose,
        every_s: Annotated[float, Bounds(least=0.5, most=60.0)] = 2.0,
        hangs_m: Lift = 0.1,
        speed_m_s: Speed = 0.5,
        timeout_s: Timeout = 30.0,
    ) -> None:
        super().__init__(name, context, at, speed_m_s, timeout_s)
        self._every, self._hangs = every_s, hangs_m

    def initialise(self) -> None:
        """Find where the fingers stop on nothing, and set out."""
        super().initialise()
        self._step, self._empties = self._try, not self.gripper_is_open
        self.open_gripper() if self._empties else self.grip(0.0, _FORCE)

    def _try(self) -> Status:
        """Drop what is held, close on nothing, and open."""
        fingers = self.context.log.fingers
        if (waiting := self._opening() if self._empties else self.fingers("closing")) is not None:
            return waiting
        if self._empties:
            self._empties = False
            self.grip(0.0, _FORCE)
            return self.running("closing on nothing")
        if not fingers.rest:
            return self.running("closed on nothing")
        fingers.empty = max(fingers.width, 0.0)
        self.open_gripper()
        self._step = self._come
        return self._come()

    def _come(self) -> Status:
        status = super()._come()
        if self._step == self._offer:
            self._step = self._open
        return status

    def _open(self) -> Status:
        if (opening := self._opening()) is not None:
            return opening
        self._since, self._step = self.context.clock.now(), self._offer
        return self._offer()

    def _offer(self) -> Status:
        now = self.context.clock.now()
        if now - self._begun > self._timeout:
            return self.failure(f"nothing was given within {self._timeout:g} s")
        if now - self._since < self._every:
            return self.running(f"holding the hand out for {now - self._begun:.0f} s")
        self.grip(0.0, _FORCE)
        self._step = self._feel
        return self.running("closing")

    def _feel(self) -> Status:
        context, log, now = self.context, self.context.log, self.context.clock.now()
        if (waiting := self.fingers("closing")) is not None:
            return waiting
        if not log.fingers.rest:
            return self.running("feeling what is there")
        if not self.empty_hand:
            self._felt, self._since, self._step = log.fingers.width, now, self._squeeze
            context.robot.grip(0.0, _FORCE)  # what stops them half way of themselves gives way
            return self.running("pressing what is there")
        return self._feel_again()

    def _feel_again(self) -> Status:
        self.open_gripper()
        self._step = self._open
        return self.running("nothing there yet")

    def _squeeze(self) -> Status:
        """Take what is still there; a finger that was felt is not."""
        context, log, now = self.context, self.context.log, self.context.clock.now()
        if self.empty_hand or log.fingers.width < self._felt - CLOSED:
            return self._feel_again()
        if now - self._since < _SQUEEZE or not log.fingers.rest:
            return self.running("pressing what is there")
        log.last_grasp, log.grip_height = context.oTe, self._hangs
        log.grip_outline = log.grip_opening = log.floor_error = None
        log.attempt(self._begun, now)
        return self.success(f"given something {1000 * log.fingers.width:.0f} mm wide")

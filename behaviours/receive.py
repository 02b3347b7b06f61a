"""Behaviour `receive`: take an object that a person holds between the fingers."""

from typing import Annotated, ClassVar

from py_trees.common import Status

from behaviours.core.context import Context
from behaviours.core.leaf import Leaf
from behaviours.core.motion import Approach
from behaviours.core.parameter_types import Bounds, Force, Lift, Speed, Timeout, ToolPose
from controller import PoseGoal

_ON_THE_WAY = 60.0  # longest way to the person [s]


class Receive(Leaf):
    """Hold the open hand out to a person, and take what is between the fingers.

    Nothing sees there, so the fingers feel: they close gently again and again, and stay closed on
    what stops them; else they open. Announce it by `say`. Fails when nothing is given in time, the
    hand does not get there, the fingers do not move, or on a fault.

    Args:
        at: where the hand is held out.
        every_s: how long the hand is open before the fingers feel [s].
        force_n: force of the fingers [N].
        hangs_m: how far what is given may reach below the hand; `place` stops so high [m].
        speed_m_s: largest speed of the hand on its way there [m/s].
        timeout_s: how long it waits for a person [s].
    """

    key: ClassVar[str] = "receive"
    goes_to: ClassVar[tuple[str, ...]] = ("at",)

    def __init__(
        self,
        name: str,
        context: Context,
        *,
        at: ToolPose,
        every_s: Annotated[float, Bounds(least=0.5, most=60.0)] = 2.0,
        force_n: Force = 10.0,
        hangs_m: Lift = 0.1,
        speed_m_s: Speed = 0.5,
        timeout_s: Timeout = 30.0,
    ) -> None:
        super().__init__(name, context)
        self._at, self._every, self._force = at, every_s, force_n
        self._hangs, self._speed, self._timeout = hangs_m, speed_m_s, timeout_s

    @property
    def phase(self) -> str:
        """`approach`, then `offer` and `feel` in turn."""
        return {self._offer: "offer", self._feel: "feel"}.get(self._step, "approach")

    def initialise(self) -> None:
        """Open the fingers, and set out."""
        if not self.gripper_is_open:
            self.open_gripper()
        self._approach = Approach(self, self._goal, self._at.name, _ON_THE_WAY)
        self._step, self._begun = self._come, self.context.clock.now()

    def update(self) -> Status:
        """One tick of the phase that it is in."""
        if fault := self.fault():
            return self.failure(fault)
        return self._step()

    def _goal(self) -> PoseGoal:
        return PoseGoal(wTe=self._at.wTe, speed=self._speed)

    def _come(self) -> Status:
        status = self._approach.tick()
        if status is Status.SUCCESS:
            self._begun = self._since = self.context.clock.now()
            self._step = self._offer
            return self.running("holding the hand out")
        return status

    def _offer(self) -> Status:
        """The hand is open."""
        now = self.context.clock.now()
        self.pursue(self._goal(), "offer")
        if not self.gripper_is_open:
            self._since = now
            waiting = self.fingers("opening")
            width = 1000 * self.context.state.gripper_width
            return waiting or self.failure(f"the fingers stopped at {width:.0f} mm")
        if now - self._begun > self._timeout:
            return self.failure(f"nothing was given within {self._timeout:g} s")
        if now - self._since < self._every:
            return self.running(f"holding the hand out for {now - self._begun:.0f} s")
        self.grip(0.0, self._force)
        self._step = self._feel
        return self.running("closing")

    def _feel(self) -> Status:
        """The fingers close."""
        context, log = self.context, self.context.log
        self.pursue(self._goal(), "offer")
        if (waiting := self.fingers("closing")) is not None:
            return waiting
        if self.empty_hand:
            self.open_gripper()
            self._step = self._offer
            return self.running("nothing there yet")
        log.last_grasp, log.grip_height = context.wTe, self._hangs
        log.grip_outline = log.grip_opening = log.floor_error = None
        log.attempt(self._begun, context.clock.now())
        return self.success(f"given something {1000 * context.state.gripper_width:.0f} mm wide")

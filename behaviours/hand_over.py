"""Behaviour `hand_over`: give what the hand holds to a person."""

from typing import ClassVar

from py_trees.common import Status

from behaviours.core.context import Context
from behaviours.core.leaf import Leaf
from behaviours.core.motion import Approach
from behaviours.core.parameter_types import Speed, Timeout, ToolPose
from controller import PoseGoal

_PULL = 0.001  # motion of the fingers that hold something by which they are pulled [m]
_ON_THE_WAY = 60.0  # longest way to the person [s]


class HandOver(Leaf):
    """Hold the object out to a person, wait until it is pulled, and open the fingers.

    It is pulled when the width between the fingers changes: as it turns, or as they close behind
    it. Announce it by `say`. Fails with the object in the hand when nobody pulls in time; fails
    too when nothing is held, the hand does not get there, the fingers do not open, or on a fault.

    Args:
        at: where the hand holds it out.
        speed_m_s: largest speed of the hand on its way there [m/s].
        timeout_s: how long it waits for a person [s].
    """

    key: ClassVar[str] = "hand_over"
    goes_to: ClassVar[tuple[str, ...]] = ("at",)

    def __init__(
        self,
        name: str,
        context: Context,
        *,
        at: ToolPose,
        speed_m_s: Speed = 0.5,
        timeout_s: Timeout = 30.0,
    ) -> None:
        super().__init__(name, context)
        self._at, self._speed, self._timeout = at, speed_m_s, timeout_s

    @property
    def phase(self) -> str:
        """`approach`, then `offer`, then `release`."""
        return {self._offer: "offer", self._open: "release"}.get(self._step, "approach")

    def initialise(self) -> None:
        """Set out."""
        self._approach = Approach(self, self._goal, self._at.name, _ON_THE_WAY)
        self._step = self._come

    def update(self) -> Status:
        """One tick of the phase that it is in."""
        if fault := self.fault():
            return self.failure(fault)
        return self._step()

    def _goal(self) -> PoseGoal:
        return PoseGoal(wTe=self._at.wTe, speed=self._speed)

    def _come(self) -> Status:
        if reason := self.empty_hand:
            return self.failure(f"nothing to hand over: {reason}")
        status = self._approach.tick()
        if status is not Status.SUCCESS:
            return status
        self._since, self._width = self.context.clock.now(), self.context.state.gripper_width
        self._step = self._offer
        return self.running("holding it out")

    def _offer(self) -> Status:
        context = self.context
        self.pursue(self._goal(), "offer")
        waited, width = context.clock.now() - self._since, context.state.gripper_width
        if self.empty_hand or abs(width - self._width) > _PULL:
            self.open_gripper()
            if (carried := context.log.in_hand) is not None:
                carried.let_go = context.clock.now()
            self._step = self._open
            return self.running("letting go")
        if waited > self._timeout:
            return self.failure(f"nobody took it within {self._timeout:g} s")
        return self.running(f"holding it out for {waited:.0f} s")

    def _open(self) -> Status:
        self.pursue(self._goal(), "offer")
        if self.gripper_is_open:
            return self.success(f"handed over at {self._at.name}")
        if (waiting := self.fingers("letting go")) is not None:
            return waiting
        width = 1000 * self.context.state.gripper_width
        return self.failure(f"not let go: the fingers stopped at {width:.0f} mm")

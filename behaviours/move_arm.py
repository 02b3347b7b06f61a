"""Behaviour `move_arm`: the arm to a posture, the base held."""

from math import radians
from typing import ClassVar

from py_trees.common import Status

from behaviours.core.context import Context
from behaviours.core.leaf import Leaf
from behaviours.core.motion import Approach
from behaviours.core.parameter_types import Posture, Timeout
from controller import PostureGoal

_TOLERANCE = 0.6  # of every joint [deg]


class MoveArm(Leaf):
    """Move the arm to joint positions, the base held as it is.

    The joints arrive together, and nothing but the robot itself and the floor is avoided on the
    way. Fails when the robot has a fault, no longer comes nearer, or the time is over.

    Args:
        to: a posture of the task file; `ready` is always there.
        timeout_s: give up after this [s].
    """

    key: ClassVar[str] = "move_arm"
    base_rests: ClassVar[bool] = True
    goes_to: ClassVar[tuple[str, ...]] = ("to",)

    def __init__(
        self,
        name: str,
        context: Context,
        *,
        to: Posture,
        timeout_s: Timeout = 20.0,
    ) -> None:
        super().__init__(name, context)
        self._to = to
        self._goal = PostureGoal(q=to.q, tolerance=radians(_TOLERANCE))
        self._timeout = timeout_s

    def initialise(self) -> None:
        """Start anew."""
        self._approach = Approach(self, lambda: self._goal, self._to.name, self._timeout)

    def update(self) -> Status:
        """One tick."""
        return self._approach.tick()

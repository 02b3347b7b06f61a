"""Behaviour `drive`: the base alone, to a pose or by a distance."""

from math import radians
from typing import ClassVar

import numpy as np
import pinocchio as pin
from pinocchio import SE3
from py_trees.common import Status

from behaviours.core.arguments import validate_drive
from behaviours.core.context import Context
from behaviours.core.leaf import Leaf
from behaviours.core.motion import Approach
from behaviours.core.parameter_types import BaseDistance, BasePose, Timeout, Turn
from controller import BaseGoal

_CERTAIN = 0.02  # uncertainty of the base from where the map tells how far it goes [m]
_ASTRAY = 0.1  # by which the map may find that a distance was another one than odometry tells [m]


class Drive(Leaf):
    """Drive the base, the arm held as it is.

    Say either where `to`, or how far from here: it first turns, then goes forward. A base that has
    a front goes backwards if `forward_m` is negative. Fails when the robot has a fault, no longer
    comes nearer, or the time is over, and where the base got to another place than its wheels tell.

    Args:
        to: a base pose of the task file.
        forward_m: how far to go forward; negative is backwards [m].
        turn_deg: how far to turn first; positive is to the left [deg].
        timeout_s: give up after this [s].
    """

    key: ClassVar[str] = "drive"
    goes_to: ClassVar[tuple[str, ...]] = ("to",)
    validate = staticmethod(validate_drive)

    def __init__(
        self,
        name: str,
        context: Context,
        *,
        to: BasePose | None = None,
        forward_m: BaseDistance = 0.0,
        turn_deg: Turn = 0.0,
        timeout_s: Timeout = 60.0,
    ) -> None:
        super().__init__(name, context)
        if wrong := self.validate({"to": to, "forward_m": forward_m, "turn_deg": turn_deg}):
            raise ValueError(wrong)
        self._to, self._forward, self._turn, self._timeout = to, forward_m, turn_deg, timeout_s

    def initialise(self) -> None:
        """Start anew, from where the base stands now."""
        self._begun, self._drift, self._vague = self.context.state.oTb, None, 0.0
        if (to := self._to) is not None:
            self._approach = Approach(self, lambda: BaseGoal(target=to.oTb), to.name, self._timeout)
        else:
            turn = pin.utils.rotate("z", radians(self._turn))
            way = SE3(turn, turn @ np.array([self._forward, 0.0, 0.0]))
            self._drift = self.context.drift()
            self._vague = self.context.localisation.uncertainty
            goal = BaseGoal(target=self._begun * way, reverse=self._forward < 0.0)
            parts = [f"{self._turn:g}°"] * (self._turn != 0.0)
            parts += [f"{self._forward:g} m"] * (self._forward != 0.0)
            target = f"the end of {' and '.join(parts)}"
            self._approach = Approach(self, lambda: goal, target, self._timeout)

    def update(self) -> Status:
        """One tick."""
        here = self.context.localisation
        if self._drift is not None and self._vague > _CERTAIN >= max(
            here.uncertainty, here.pending
        ):
            self._drift, self._vague = self.context.drift(), here.uncertainty
        status = self._approach.tick()
        if status is not Status.SUCCESS or self._drift is None:
            return status
        oTb = self.context.state.oTb
        way, by_map = self._begun.actInv(oTb), (self._drift() * self._begun).actInv(oTb)
        astray = float(np.linalg.norm(way.translation - by_map.translation))
        if astray > _ASTRAY + self._vague:
            return self.failure(f"{self.feedback_message}, but by the map {astray:.2f} m away")
        return status

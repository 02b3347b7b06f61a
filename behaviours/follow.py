"""Keep over an object that moves, as the camera sees it, until it stands still."""

from __future__ import annotations

from math import atan2
from typing import ClassVar, TypeAlias

import numpy as np
import numpy.typing as npt
import pinocchio as pin
from pinocchio import SE3
from py_trees.common import Status

from behaviours.context import Context
from behaviours.leaf import Leaf, Progress, remaining
from behaviours.named import Region
from behaviours.occupancy import Occupancy, Thing
from controller import PoseGoal

Array: TypeAlias = npt.NDArray[np.float64]

_THING = 2e-4
"""What covers less than this, seen from above, is not followed [m^2]."""
_SAME = 0.10
"""A thing that has jumped farther than this since the last picture is another one [m]."""
_STILL = 0.01
"""An object that has not left a circle of this radius stands still [m]."""
_KEPT_UP = 0.05
"""Nearer than this to where it wants to be, the hand keeps up with the object [m]."""


class Follow(Leaf):
    """Keep the hand over an object that moves, until it stands still.

    Of several objects it takes the one nearest to the hand. Fails when the object is out of sight
    or out of the region, the hand cannot keep up, or the robot has a fault.

    Args:
        within: region of the task file in which the object moves.
        height_m: of the hand over the floor of the region [m].
        still_s: succeed when the object has stood still for so long [s]; null follows for ever.
        patience_s: give up after not seeing it for this long [s].
    """

    key: ClassVar[str] = "follow"

    def __init__(
        self,
        name: str,
        context: Context,
        *,
        within: Region,
        height_m: float = 0.3,
        still_s: float | None = 2.0,
        patience_s: float = 1.5,
    ) -> None:
        super().__init__(name, context)
        self._within = within
        self._height = height_m
        self._still = still_s
        self._patience = patience_s

    def initialise(self) -> None:
        """Start to look; the hand keeps the turn about the vertical that it has."""
        context = self.context
        self._seen = self._still_since = context.clock.now()
        self._thing: Array | None = None
        self._anchor = np.full(3, np.inf)
        self._progress = Progress()
        x_axis = context.wTe.rotation[:, 0]
        self._rotation = pin.rpy.rpyToMatrix(np.pi, 0.0, atan2(x_axis[1], x_axis[0]))

    def update(self) -> Status:
        """One tick."""
        if fault := self.fault():
            return self.failure(fault)
        context, now = self.context, self.context.clock.now()
        self._look()
        if now - self._seen > self._patience:
            reason = (
                "no camera frame"
                if context.vision.is_blind(context.state.stamp)
                else "nothing to follow"
            )
            return self.failure(f"{reason} for {self._patience:g} s")
        if self._thing is None:
            return self.running("looking for something to follow")
        above = SE3(self._rotation, self._thing + np.array([0.0, 0.0, self._height]))
        report = self.pursue(PoseGoal(wTe=above, speed=0.5, straight=True))
        if np.linalg.norm(self._thing - self._anchor) > _STILL:
            self._anchor, self._still_since = self._thing, now
        if report is None:
            return self.running("seen, setting out")
        if report.position_error < _KEPT_UP:
            self._progress = Progress()
        elif self._progress.stalled(remaining(report), now):
            return self.failure(f"cannot keep up, {report.position_error:.2f} m behind")
        still = now - self._still_since
        if self._still is not None and still >= self._still and report.position_error < _KEPT_UP:
            return self.success(f"it has stood still for {still:.1f} s")
        return self.running(f"following, {report.position_error:.3f} m behind")

    def _look(self) -> None:
        """See in a new picture where the thing is now."""
        frame = self.context.vision.new_frame()
        if frame is None:
            return
        with self.context.vision.timed():
            occupancy = Occupancy(self._within, cell=0.008, stride=3)
            occupancy.add(frame)
            seen = occupancy.things(_THING)
        before = self.context.wTe.translation if self._thing is None else self._thing
        reach = np.inf if self._thing is None else _SAME
        things = [(_apart(thing, before), thing) for thing in seen]
        distance, nearest = min(things, key=lambda near: near[0], default=(np.inf, None))
        if nearest is not None and distance < reach:
            self._thing, self._seen = nearest.centre, self.context.clock.now()


def _apart(thing: Thing, point: Array) -> float:
    """Distance of a thing from a (3,) point, seen from above [m]."""
    return float(np.linalg.norm((thing.centre - point)[:2]))

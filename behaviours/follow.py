"""Behaviour `follow`: keep the hand over a moving object."""

from typing import ClassVar

import numpy as np
from pinocchio import SE3
from py_trees.common import Status

from behaviours.core.context import Context
from behaviours.core.directions import looking_down
from behaviours.core.leaf import Leaf
from behaviours.core.motion import Progress
from behaviours.core.parameter_types import Distance, Duration, Region
from behaviours.views.survey import glance
from controller import Array, PoseGoal
from perception import Segment

_SPEED = 0.5  # [m/s]
_SMALLEST_AREA = 2e-4  # of an object that is followed, seen from above [m^2]
_SAME_OBJECT = 0.10  # an object farther from its place in the last picture is another one [m]
_STILL_RADIUS = 0.01  # an object that does not leave this circle stands still [m]
_PATIENCE = 1.5  # without seeing the object [s]
_KEEPING_UP = 0.05  # position error below which the hand keeps up [m]


class Follow(Leaf):
    """Keep the hand over an object that moves, until it stands still.

    Of several objects it takes the one nearest to the hand. Fails when the object is out of sight
    or out of the region, the hand cannot keep up, or the robot has a fault.

    Args:
        within: region of the task file in which the object moves.
        height_m: of the hand over the floor of the region [m].
        still_s: succeed when the object has stood still for so long [s]; null follows for ever.
    """

    key: ClassVar[str] = "follow"
    surfaces: ClassVar[tuple[str, ...]] = ("within",)

    def __init__(
        self,
        name: str,
        context: Context,
        *,
        within: Region,
        height_m: Distance = 0.3,
        still_s: Duration | None = 2.0,
    ) -> None:
        super().__init__(name, context)
        self._within, self._height, self._still = within, height_m, still_s

    def initialise(self) -> None:
        """Start to look; the hand keeps its turn about the vertical."""
        context = self.context
        self._seen = self._still_since = context.clock.now()
        self._object: Array | None = None
        self._anchor = np.full(3, np.inf)
        self._progress = Progress(context)
        self._rotation = looking_down(context.oTe.rotation[:, 0])

    def update(self) -> Status:
        """One tick."""
        if fault := self.fault():
            return self.failure(fault)
        context, now = self.context, self.context.clock.now()
        self._look()
        if now - self._seen > _PATIENCE:
            reason = context.vision.blindness(context.state.stamp) or "nothing to follow"
            return self.failure(f"{reason} for {_PATIENCE:g} s")
        if self._object is None:
            return self.running("looking for something to follow")
        above = SE3(self._rotation, self._object + np.array([0.0, 0.0, self._height]))
        report = self.pursue(PoseGoal(target=above, speed=_SPEED, straight=True))
        if np.linalg.norm(self._object - self._anchor) > _STILL_RADIUS:
            self._anchor, self._still_since = self._object, now
        if report is None:
            return self.running("seen, setting out")
        keeps_up = report.position_error < _KEEPING_UP
        if keeps_up:
            self._progress = Progress(context)
        elif self._progress.is_stuck(report):
            behind = f"cannot keep up, {report.position_error:.2f} m behind"
            return self.failure(behind + self._progress.because)
        still = self._seen - self._still_since
        if self._still is not None and still >= self._still and keeps_up:
            return self.success(f"it has stood still for {still:.1f} s")
        return self.running(f"following, {report.position_error:.3f} m behind")

    def _look(self) -> None:
        """Find the object in a new frame."""
        vision = self.context.vision
        frame = vision.new_frame()
        if frame is None or vision.blindness(self.context.state.stamp):
            return
        with vision.timed():
            seen = glance(self.context, self._within, frame).segments(_SMALLEST_AREA)
        before = self.context.oTe.translation if self._object is None else self._object
        reach = np.inf if self._object is None else _SAME_OBJECT
        distances = [(_distance(segment, before), segment) for segment in seen]
        distance, nearest = min(distances, key=lambda pair: pair[0], default=(np.inf, None))
        if nearest is not None and distance < reach:
            self._object, self._seen = nearest.centre, self.context.clock.now()


def _distance(segment: Segment, point: Array) -> float:
    """Distance of an object from a (3,) point, seen from above [m]."""
    return float(np.linalg.norm((segment.centre - point)[:2]))

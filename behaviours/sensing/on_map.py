"""Places on the map the points that the robot remembers in the world."""

from math import hypot

from pinocchio import SE3

from behaviours.sensing.localisation import Localiser
from controller import PointCloud

_STILL = 0.002  # a smaller correction, at the robot, moves nothing on the map yet [m]


class CloudOnMap:
    """Places on the map the points that the robot remembers in the world."""

    def __init__(self) -> None:
        self._placed: tuple[PointCloud, SE3, PointCloud] | None = None

    def __call__(self, cloud: PointCloud, here: Localiser) -> PointCloud:
        """The same object until what is remembered changes or the map has moved noticeably."""
        if (mTw := here.mTw) is None or not cloud:
            return cloud
        if self._placed is not None and self._placed[0] is cloud:
            base = here.mTb.translation
            shift = self._placed[1].act(mTw.actInv(base)) - base
            if hypot(*shift.tolist()) < _STILL:
                return self._placed[2]
        self._placed = cloud, mTw, cloud.moved(mTw)
        return self._placed[2]

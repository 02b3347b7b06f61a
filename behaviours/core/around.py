"""What surrounds the robot, by the map and by what camera and laser show."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import hypot

import numpy as np
from pinocchio import SE3

from behaviours.sensing.depth_obstacles import NO_POINTS, DepthObstacles
from behaviours.sensing.laser_obstacles import LaserObstacles, Scans
from behaviours.sensing.localiser import Localiser
from behaviours.sensing.vision import Vision
from controller import Array, Obstacle, PointCloud
from hw import LaserScan, RobotState
from robots import Geom

_STILL = 0.002  # a smaller correction, at the robot, moves no points on the map yet [m]


@dataclass(kw_only=True, eq=False)
class Around:
    """What surrounds the robot."""

    fixtures: tuple[Geom, ...] = ()  # on the map
    obstacles: Callable[[float], Sequence[Obstacle]] = lambda stamp: ()
    """Moving obstacles on the map, at a time of the session's clock [s]."""
    depth_obstacles: DepthObstacles | None = None  # seen by the camera; None: switched off

    def __post_init__(self) -> None:
        self.scans = Scans()
        self._laser_obstacles = LaserObstacles()
        self._joined = self.fixtures, self.fixtures, self.fixtures
        self._seen: tuple[PointCloud, Array, PointCloud] = NO_POINTS, np.zeros((0, 3)), NO_POINTS
        self._placed = NO_POINTS, SE3.Identity(), NO_POINTS

    def moving(self, stamp: float, here: Localiser) -> list[Obstacle]:
        """Moving obstacles, in odometry."""
        moving, oTm = self.obstacles(stamp), here.oTm
        if oTm is None:
            return list(moving)
        return [Obstacle(one.geom.moved(oTm), oTm.rotation @ one.velocity) for one in moving]

    def look(
        self,
        state: RobotState,
        here: Localiser,
        vision: Vision,
        scan: Callable[[], LaserScan | None],
        held: Sequence[Geom],
    ) -> None:
        """Take what laser and camera show in this tick; what is held, in e, is not around."""
        if here.mTo is None and self.depth_obstacles is None:
            return
        walkers = [one.geom for one in self.moving(state.stamp, here)]
        if here.mTo is not None:
            self._laser_obstacles.look(scan(), walkers)
        if self.depth_obstacles is not None:
            self.depth_obstacles.look(vision, state, held, walkers)

    def standing(self, here: Localiser, hit: tuple[Geom, ...]) -> tuple[Geom, ...]:
        """Fixtures where they stand, and what was `hit`; the same tuple until one changes."""
        fixtures = here.furniture.standing(self.fixtures)
        if self._joined[0] is not fixtures or self._joined[1] is not hit:
            self._joined = fixtures, hit, (fixtures + hit if hit else fixtures)
        return self._joined[2]

    def points(self, here: Localiser) -> PointCloud | None:
        """What camera and laser have seen, on the map; None where neither is used.

        The laser's points count where the map may be wrong about its furniture or the base. The
        same object until there are others, or the map has moved noticeably.
        """
        camera, mTo = self.depth_obstacles, here.mTo
        if camera is None and mTo is None:
            return None
        both = NO_POINTS if camera is None else camera.cloud, self._laser_obstacles.points
        if self._seen[0] is not both[0] or self._seen[1] is not both[1]:
            points = np.concatenate([both[0].points, both[1]])
            self._seen = *both, PointCloud(points) if len(both[1]) else both[0]
        seen, base = self._seen[2], here.mTb.translation
        if mTo is None:
            return seen
        shift = self._placed[1].act(mTo.actInv(base)) - base
        if self._placed[0] is not seen or hypot(*shift.tolist()) >= _STILL:
            self._placed = seen, mTo, seen.moved(mTo)
        return self._placed[2]

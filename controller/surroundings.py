"""Obstacles around the robot: fixtures, moving obstacles, loose and held objects, depth points."""

from __future__ import annotations

from dataclasses import dataclass

from pinocchio import SE3

from config.arrays import Array, Indices
from config.poses import MapFromOdometry, MapPose
from robots import Geom


class PointCloud:
    """Immutable points (N, 3) on the map [m] with a k-d tree for nearest-point queries."""

    def __init__(self, points: Array) -> None:
        self.points = points
        self._mTp: MapPose | None = None
        """The frame in which the tree has the points; None for the world."""
        self._tree = None
        if len(points):
            from scipy.spatial import cKDTree  # slow to import; see `HolisticController`

            self._tree = cKDTree(points, balanced_tree=False)

    def nearest(self, places: Array) -> tuple[Array, Indices]:
        """Distances (F,) from places (F, 3) to the nearest points [m], and their indices (F,)."""
        assert self._tree is not None, "there are no points"
        if self._mTp is not None:
            places = (places - self._mTp.translation) @ self._mTp.rotation
        distances, numbers = self._tree.query(places)
        return distances, numbers

    def moved(self, T: SE3) -> PointCloud:
        """The same points, moved by T; the tree is shared."""
        cloud = PointCloud.__new__(PointCloud)
        cloud.points = self.points @ T.rotation.T + T.translation
        cloud._mTp = T if self._mTp is None else T * self._mTp
        cloud._tree = self._tree
        return cloud


@dataclass(frozen=True, eq=False)
class Obstacle:
    """A moving obstacle."""

    geom: Geom  # its present shape on the map
    velocity: Array  # (3,) of its centre, in the axes of the map [m/s]; it does not turn


@dataclass(frozen=True, kw_only=True, eq=False)
class Surroundings:
    """Everything the robot must not hit; the floor is always included.

    What is computed from `fixtures` and `loose`, such as a map, is cached as long as they are the
    same objects.
    """

    fixtures: tuple[Geom, ...] = ()  # static obstacles on the map
    moving: tuple[Obstacle, ...] = ()
    loose: tuple[Geom, ...] = ()
    """Objects on fixtures, on the map. The arm's links and the camera avoid them; the hand, which
    works among them, and the base do not."""
    depth_points: PointCloud | None = None
    """Surface points seen by a depth camera; a new object for every frame."""
    held: tuple[Geom, ...] = ()
    """Shapes of the held object in e: they move with the robot and avoid obstacles too."""
    mTo: MapFromOdometry | None = None
    """The odometry frame on the map, in which velocities of goals are measured; None where it is
    the world."""
    uncertainty: float = 0.0
    """How far off fixtures may be because the robot knows its place only so well: two standard
    deviations [m]."""

    def has_shapes_of(self, other: Surroundings) -> bool:
        """Whether all shapes are the same, wherever the moving obstacles are."""
        same = self.held is other.held and self.loose is other.loose
        return same and self.stands_like(other)

    def stands_like(self, other: Surroundings) -> bool:
        """Whether fixtures and shapes of moving obstacles are the same."""
        if self.fixtures is not other.fixtures or len(self.moving) != len(other.moving):
            return False
        both = zip(self.moving, other.moving, strict=True)
        return all(one.geom.shape == before.geom.shape for one, before in both)


OPEN_FLOOR = Surroundings()  # no obstacles

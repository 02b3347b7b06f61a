"""A room with furniture, and what a laser and a depth camera with real errors measure of it."""

from collections.abc import Mapping, Sequence

import numpy as np
from pinocchio import SE3, exp3

from config.planar import in_space
from hw.sim import D435Noise, DepthRenderer
from perception.registration import LASER, Cloud, Surfaces, depth_cloud
from robots import Box, Cylinder, Geom, Intrinsics, load_robot

LASER_AT = np.array([0.25, 0.0, 0.19])
CAMERA = Intrinsics(width=212, height=120, fx=154.0, fy=154.0, cx=106.0, cy=60.0)
EYE = np.array([[0.0, -0.77, 0.64], [-1.0, 0.0, 0.0], [0.0, -0.64, -0.77]])
"""A camera that looks ahead and 50 degrees down."""
CAMERA_AT = SE3(EYE, np.array([0.35, 0.0, 1.15]))
Pieces = dict[str, list[Geom]]


def box(size: Sequence[float], centre: Sequence[float]) -> Geom:
    x, y, z = (0.5 * edge for edge in size)
    return Geom(Box((x, y, z)), SE3(np.eye(3), np.array(centre, dtype=float)))


def table(x: float, y: float, length: float = 1.4, width: float = 0.8) -> list[Geom]:
    a, b, leg = width / 2 - 0.025, length / 2 - 0.025, (0.05, 0.05, 0.72)
    legs = [box(leg, (x + i * a, y + j * b, 0.36)) for i in (-1, 1) for j in (-1, 1)]
    return [box((width, length, 0.03), (x, y, 0.735)), *legs]


def room() -> Pieces:
    """Two tables, a pedestal, a column and the walls around 6 m by 5 m."""
    column = Geom(Cylinder(0.12, 1.1), SE3(np.eye(3), np.array([-1.2, 1.6, 1.1])))
    return {
        "walls": [
            box((0.1, 5.2, 2.5), (3.05, 0.0, 1.25)),
            box((0.1, 5.2, 2.5), (-3.05, 0.0, 1.25)),
            box((6.0, 0.1, 2.5), (0.0, 2.55, 1.25)),
            box((6.0, 0.1, 2.5), (0.0, -2.55, 1.25)),
        ],
        "near table": table(1.3, 0.2),
        "far table": table(0.2, -1.7, length=0.8, width=1.4),
        "pedestal": [box((0.5, 0.5, 0.6), (0.9, 1.5, 0.3))],
        "column": [column],
    }


def displaced(geoms: Sequence[Geom], by: Sequence[float]) -> list[Geom]:
    """A piece moved by x, y and a turn about the mean of its shapes."""
    centre = np.mean([g.pose.translation for g in geoms], axis=0)
    there = SE3(np.eye(3), centre + np.array([by[0], by[1], 0.0]))
    turn = SE3(exp3(np.array([0.0, 0.0, by[2]])), np.zeros(3))
    return [g.moved(there * turn * SE3(np.eye(3), -centre)) for g in geoms]


class Robot:
    """Laser and camera on a base, wrong in a way that lasts: where they are, and in scale."""

    def __init__(self, rng: np.random.Generator) -> None:
        self.rng = rng
        shift, turn = (v / np.linalg.norm(v) for v in rng.normal(size=(2, 3)))
        self.wrong = SE3(exp3(np.deg2rad(0.5) * turn), 0.003 * shift)
        self.mount = rng.normal(size=3) * [0.002, 0.002, np.deg2rad(0.1)]  # x, y, heading
        self.scale = 1.0 + 0.005 * rng.choice([-1.0, 1.0])

    def scan(self, world: Mapping[str, Sequence[Geom]], mTb: np.ndarray, step: int = 1) -> Cloud:
        angles = np.deg2rad(np.arange(-120, 121, step))
        mTl = in_space(mTb) * SE3(np.eye(3), LASER_AT) * in_space(self.mount)
        directions = np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=1)
        ranges = np.full(len(angles), np.inf)
        for geom in (g for geoms in world.values() for g in geoms):
            lTs = mTl.inverse() * geom.pose
            ranges = np.minimum(ranges, hits(geom, lTs.inverse(), directions))
        seen = ranges < 10.0
        ranges = ranges[seen] + self.rng.normal(size=seen.sum()) * 0.01
        return Cloud(LASER_AT + ranges[:, None] * directions[seen], LASER_AT, LASER)

    def image(self, world: Mapping[str, Sequence[Geom]], mTb: np.ndarray) -> Cloud:
        shapes = [g for geoms in world.values() for g in geoms]
        mTc = in_space(mTb) * CAMERA_AT * self.wrong
        depth = DepthRenderer(CAMERA).render(shapes, mTc)
        depth = D435Noise().apply(depth, load_robot("frankie").camera, self.rng)
        return depth_cloud(depth * np.float32(self.scale), CAMERA, CAMERA_AT)


def hits(geom: Geom, sTl: SE3, directions: np.ndarray) -> np.ndarray:
    """(N,) ranges at which rays from the laser enter a box or an upright cylinder."""
    eye, rays = sTl.translation, directions @ sTl.rotation.T
    rays = np.where(np.abs(rays) < 1e-12, 1e-12, rays)
    match geom.shape:
        case Box(half):
            one, two = (-np.array(half) - eye) / rays, (np.array(half) - eye) / rays
            enter, leave = np.minimum(one, two).max(axis=1), np.maximum(one, two).min(axis=1)
        case Cylinder(radius, length):
            middle = -rays[:, :2] @ eye[:2]
            inside = middle**2 - eye[:2] @ eye[:2] + radius**2
            root = np.sqrt(np.where(inside > 0.0, inside, np.nan))
            enter = np.where(abs(eye[2]) < length, middle - root, np.nan)
            leave = middle + root
    return np.where((leave > enter) & (enter > 0.02), enter, np.inf)


MAP = room()
SURFACES = Surfaces(MAP, fixed={"walls"})

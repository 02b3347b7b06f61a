"""Where one depth image shows a region of the map, by the furniture around it.

Localisation and camera mount are wrong by a centimetre; the walls of a container, seen in the image
itself, tell to a millimetre where its inside is, and how high its floor.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from pinocchio import SE3, exp3

from config.arrays import Array, Mask
from config.planar import on_floor
from config.poses import MapPose, OdometryPose
from perception.frame import Frame
from perception.registration.matching import LOSS_SCALE, SUPPORT, Problem, Solution
from perception.registration.sensors import DEPTH_CAMERA, Cloud
from perception.registration.surfaces import Surfaces
from robots import Geom, bounding_radius, reach

_STRIDE = 4  # only every n-th pixel is used, along rows and columns
_MOST = 300  # points that are matched, about
_AROUND = 0.08  # how far outside of the region they are looked for [m]
_BESIDE = 0.03  # how far inside or outside of it its walls may seem to stand [m]
_WALL = 0.012  # furniture that is lower than this over its floor is no wall [m] ...
_UPPER = 0.5  # ... and what lies beside one reaches less high than this share of it, mostly
UNKNOWN_COVER = 0.01  # two standard deviations of a height by the camera alone [m]
_SIGMAS = 2.0  # standard deviations of a tolerance
_AROUND_IT = "around it"  # name of the furniture that tells where a region is
_UP = np.array([0.0, 0.0, 1.0])


class Place(NamedTuple):
    """Where an image shows a region, and how certain that is."""

    oTr: OdometryPose
    """Its centre in odometry; its height is that of the map."""
    tolerance: Array
    """(2,) how far off it may be, along its edges [m]."""
    floor: float
    """Expected height of its floor over the lower face of `oTr` [m]."""
    floor_tolerance: float
    """How far off that may be [m] ..."""
    cover: float
    """... unless something so high lies flat over all of it that is seen [m]."""


def place_in_image(
    frame: Frame,
    oTr: OdometryPose,
    size: Array,
    *,
    furniture: Sequence[Geom],
    oTb: OdometryPose,
    mTb: MapPose,
    covariance: Array,
    moved: str = "",
) -> Place:
    """Match what the image shows around a region to the furniture, as one piece.

    Inside of the region only the upper part of its walls counts: objects stand there, and a mat may
    cover the floor.

    Args:
        frame: that shows the region, or a part of it.
        oTr: centre of the region, in odometry.
        size: (3,) full edge lengths [m].
        furniture: all of the map, where it stands now.
        oTb: the base in odometry.
        mTb: the base on the map.
        covariance: (3, 3) of x, y [m] and heading [rad] of `mTb`.
        moved: the piece that the region is on, if it may have been moved; all else is another one.
    """
    mTo = mTb * oTb.inverse()
    centre, radius = (mTo * oTr).translation, _AROUND + float(np.hypot(*size[:2])) / 2.0
    near = [
        one
        for one in furniture
        if np.hypot(*(one.pose.translation - centre)[:2]) < bounding_radius(one.shape) + radius
    ]
    bTo = oTb.inverse()
    floor = mTo.act(oTr.act(np.array([0.0, 0.0, -size[2] / 2.0])))
    tops = [reach(one, _UP) - floor[2] for one in near]
    lowest = min((top for top in tops if top > _WALL), default=np.inf)
    points = _points_around(frame, oTr, size, max(_WALL, _UPPER * lowest))
    eye = bTo.act(frame.oTc.translation)
    cloud = Cloud(points @ bTo.rotation.T + bTo.translation, eye, DEPTH_CAMERA)
    around = [one for one in near if moved in ("", one.piece)]
    pieces = {_AROUND_IT: around, "beside it": [one for one in near if one not in around]}
    problem = Problem(Surfaces(pieces), [cloud], on_floor(mTb), covariance)
    others = (n for n in range(len(problem.pieces)) if problem.name(n) != _AROUND_IT)
    solution = problem.solve(frozenset(others))
    by, spread = _motion_at(floor, mTb * eye, mTb.translation, problem, solution)
    turn = SE3(exp3(np.array([0.0, 0.0, -by[3]])), np.zeros(3))
    shift = mTo.rotation.T @ np.array([*by[:2], 0.0])
    axes = (mTo * oTr).rotation[:2, :2]
    across = axes.T @ spread[:2, :2] @ axes
    turned = spread[3, 3] * (size[1::-1] / 2.0) ** 2
    used = solution.match.points[solution.losses < 0.5 * LOSS_SCALE**2]
    is_sure = np.count_nonzero(np.abs(used[:, 2] - floor[2]) > _WALL) >= SUPPORT
    higher = -float(by[2]) if is_sure else min(-float(by[2]), UNKNOWN_COVER)
    return Place(
        oTr=SE3(turn.rotation @ oTr.rotation, oTr.translation - shift),
        tolerance=_SIGMAS * np.sqrt(np.diag(across) + turned),
        floor=higher,
        floor_tolerance=_SIGMAS * float(np.sqrt(spread[2, 2])),
        cover=0.0 if is_sure else UNKNOWN_COVER + max(0.0, higher),
    )


def _points_around(frame: Frame, oTr: OdometryPose, size: Array, high: float) -> Array:
    """(N, 3) measured points that may lie on the furniture around a region, in odometry [m].

    Inside of it they are at least `high` over its floor [m].
    """
    points = frame.cloud.every(_STRIDE, _STRIDE // 2, _STRIDE // 2).points
    local = (points - oTr.translation) @ oTr.rotation
    height = local[:, 2] + size[2] / 2.0
    outside = (np.abs(local[:, :2]) - size[:2] / 2.0).max(axis=1)
    used: Mask = (outside < _AROUND) & (height > -_BESIDE) & (height < size[2])
    used &= (outside > _BESIDE) | ((outside > -_BESIDE) & (height > high))
    points = points[used]
    return points[:: max(1, -(-len(points) // _MOST))]


def _motion_at(
    point: Array, eye: Array, base: Array, problem: Problem, solution: Solution
) -> tuple[Array, Array]:
    """Motion (4,) of what is measured at a point onto the furniture, x, y, z [m] and turn [rad].

    Also its covariance (4, 4). Point, eye and base are (3,) on the map.
    """
    J, arm, (x, y, z) = np.zeros((4, problem.n)), (point - base)[:2], point - eye
    J[:2, :2] = np.eye(2)
    J[:, 2] = -arm[1], arm[0], 0.0, 1.0
    J[:3, 3:6] = np.eye(3)
    J[:3, 6:9] = [[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]]
    J[3, 8] = 1.0
    J[:3, 9] = x, y, z
    for column, centre in enumerate(problem.centres):  # less where that stands
        if problem.name(column) != _AROUND_IT:
            continue
        at, arm = problem.displacement(column), point[:2] - centre
        J[:2, at.start : at.start + 2] = -np.eye(2)
        J[:, at.start + 2] = arm[1], -arm[0], 0.0, -1.0
    return J @ solution.x, J @ np.linalg.inv(solution.information) @ J.T

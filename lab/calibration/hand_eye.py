"""Hand-eye calibration: where the camera is on the hand, from views of a board that lies still.

The arm takes the camera to many poses. A closed form gives a start; the result makes the corners of
the board fall where they were seen. A quarter of the views is held out and says how good it is.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
import pinocchio as pin
from pinocchio import SE3

from lab.calibration.board import Array, Board, Corners, Grey, find_corners, pose_of
from lab.calibration.fit import Poses, Problem, Spread, difference
from lab.calibration.result import Calibration, Limits, require_views, worst
from robots import Intrinsics

FEWEST = 10  # views in which the board must be found
LIMITS = Limits(residual=1.0, uncertainty=Spread(1.0, 0.1), check=Spread(3.0, 1.0))
_HINT = (
    "did the board or the camera's mount move, is the edge of a square what --square says, "
    "does the camera turn about several axes?"
)
_SCALE = 0.5  # A corner that is further off counts less [px]
_ALL = range(6)


@dataclass(frozen=True, eq=False)
class View:
    """One image of the board."""

    aTe: SE3  # the end effector on the arm's foot
    corners: Corners
    cTm: SE3  # the board before the camera, from this view alone


def views_of(taken: Sequence[tuple[SE3, Grey]], board: Board, camera: Intrinsics) -> list[View]:
    """Those of the images (aTe, image) that show the board."""
    views = []
    for aTe, image in taken:
        if (corners := find_corners(image, board)) is not None:
            views.append(View(aTe, corners, pose_of(corners, camera)))
    return views


def solve(
    taken: Sequence[tuple[SE3, Grey]], board: Board, camera: Intrinsics, nominal: SE3
) -> Calibration:
    """eTc, the camera on the end effector.

    Args:
        taken: the end effector on the arm's foot, and the image seen from there.
        board: that lay still.
        camera: intrinsics of the images.
        nominal: eTc as the robot file has it; only compared with.

    Raises:
        CalibrationError: too few images show the board. Whether the result is good is for the
            caller to ask.
    """
    views = views_of(taken, board, camera)
    require_views(len(views), len(taken), FEWEST)
    problem = Problem[View](lambda x, them: _misses(x, them, camera), (_ALL, _ALL), _SCALE)
    poses, checks = problem.solve_checked(
        start, views, lambda x, held: [_check(view, x, board) for view in held]
    )
    eTc, _ = poses
    return Calibration(
        key="camera_mount",
        what="eTc, the camera on the end effector",
        transform=eTc,
        views=len(views),
        held_out=len(checks),
        residual=problem.rms(poses, views),
        unit="px",
        uncertainty=problem.uncertainty(poses, views),
        check=worst(checks),
        from_nominal=difference(eTc, nominal),
        limits=LIMITS,
        hint=_HINT,
    )


def start(views: Sequence[View]) -> Poses:
    """(eTc, aTm) in closed form (Park and Martin 1994), from the motions between all views.

    Of a motion A of the hand and the same motion B of the camera, A eTc = eTc B.
    """
    pairs = list(combinations(views, 2))
    hands = [one.aTe.actInv(other.aTe) for one, other in pairs]
    cameras = [one.cTm * other.cTm.inverse() for one, other in pairs]
    turns = np.array([pin.log3(one.rotation) for one in hands])
    seen = np.array([pin.log3(one.rotation) for one in cameras])
    left, _, right = np.linalg.svd(turns.T @ seen)
    rotation = left @ np.diag([1.0, 1.0, np.linalg.det(left @ right)]) @ right
    rows = np.concatenate([one.rotation - np.eye(3) for one in hands])
    shifts = [
        rotation @ camera.translation - hand.translation
        for hand, camera in zip(hands, cameras, strict=True)
    ]
    translation = np.linalg.lstsq(rows, np.concatenate(shifts), rcond=None)[0]
    eTc = SE3(rotation, translation)
    return eTc, views[0].aTe * eTc * views[0].cTm


def _misses(poses: Poses, views: Sequence[View], camera: Intrinsics) -> Array:
    """(N, 2) by how far the corners of all views miss those that were seen [px]."""
    eTc, aTm = poses
    eTm = [view.aTe.actInv(aTm) for view in views]
    cTm = [eTc.actInv(one) for one in eTm]
    counts = [len(view.corners.board) for view in views]
    turns = np.repeat([one.rotation for one in cTm], counts, axis=0)
    shifts = np.repeat([one.translation for one in cTm], counts, axis=0)
    points = np.concatenate([view.corners.board for view in views])
    seen = np.concatenate([view.corners.image for view in views])
    x, y, z = (np.einsum("nij,nj->ni", turns, points) + shifts).T
    pixels = np.stack([camera.fx * x / z + camera.cx, camera.fy * y / z + camera.cy], axis=1)
    missed: Array = pixels - seen
    return missed


def _check(view: View, poses: Poses, board: Board) -> Spread:
    """By how far the board of a view that was not used is off, in its middle."""
    eTc, aTm = poses
    middle = SE3(np.eye(3), board.centre)
    return difference(view.cTm * middle, (view.aTe * eTc).actInv(aTm) * middle)

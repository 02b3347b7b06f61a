"""Hand-eye calibration: where the camera is on the hand, from views of a board at rest.

A closed form gives a start; the result minimises the reprojection error of the board's corners. A
quarter of the views is held out to check it.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
import pinocchio as pin
from pinocchio import SE3

from controller import RobotModel
from lab.calibration.board import Array, Board, Corners, find_corners, pose_of
from lab.calibration.fit import Poses, Problem, Spread, difference
from lab.calibration.live import LiveArm
from lab.calibration.postures import aTe_of, postures
from lab.calibration.result import Calibration, CalibrationError, Limits, require_views, worst
from lab.calibration.rigs import SimulatedArm
from robots import Intrinsics, RobotDescription

FEWEST = 10  # views in which the board must be found
LIMITS = Limits(residual=1.0, uncertainty=Spread(1.0, 0.1), check=Spread(3.0, 1.0))
_HINT = (
    "did the board or the camera's mount move, is the edge of a square what --square says, "
    "does the camera turn about several axes?"
)
_SCALE = 0.5  # larger errors of a corner count less [px]
_ALL = range(6)


@dataclass(frozen=True, eq=False)
class View:
    """One image of the board."""

    aTe: SE3  # end effector on the arm's foot
    corners: Corners
    cTk: SE3  # board in the camera's frame, from this view alone


def calibrate_hand_eye(
    rig: SimulatedArm | LiveArm,
    description: RobotDescription,
    board: Board,
    count: int,
    rng: np.random.Generator,
    say: Callable[[str], None] = lambda _: None,
) -> Calibration:
    """Move the camera around the board, and find eTc, the camera on the end effector.

    Raises CalibrationError: the board is not seen, or too seldom. The caller asks whether the
    result is good.
    """
    model, eTc, camera = (
        RobotModel(description),
        description.camera.eTc,
        description.camera.intrinsics,
    )
    first = rig.q()
    corners = find_corners(rig.image(), board)
    if corners is None:
        raise CalibrationError(
            "the camera does not see the board: take the hand 0.4 m above its middle; compare "
            "--columns and --rows with what was printed"
        )
    aTk = aTe_of(model, first) * eTc * pose_of(corners, camera)
    views = []
    for number, q in enumerate(postures(description, model, first, aTk, board, count, rng), 1):
        rig.move_to(q)
        aTe, corners = aTe_of(model, rig.q()), find_corners(rig.image(), board)
        if corners is not None:
            views.append(View(aTe, corners, pose_of(corners, camera)))
        say(f"view {number} of {count}")
    require_views(len(views), count, FEWEST)
    problem = Problem[View](lambda x, them: _residuals(x, them, camera), (_ALL, _ALL), _SCALE)
    poses, checks = problem.solve_checked(
        _start, views, lambda x, held: [_check(view, x, board) for view in held]
    )
    return Calibration(
        key="camera_mount",
        what="eTc, the camera on the end effector",
        transform=poses[0],
        views=len(views),
        held_out=len(checks),
        residual=problem.rms(poses, views),
        unit="px",
        uncertainty=problem.uncertainty(poses, views),
        check=worst(checks),
        from_nominal=difference(poses[0], eTc),
        limits=LIMITS,
        hint=_HINT,
    )


def _start(views: Sequence[View]) -> Poses:
    """(eTc, aTk) in closed form (Park and Martin, 1994), from the motions between all views.

    Of a motion A of the hand and the same motion B of the camera, A eTc = eTc B.
    """
    pairs = list(combinations(views, 2))
    hands = [one.aTe.actInv(other.aTe) for one, other in pairs]
    cameras = [one.cTk * other.cTk.inverse() for one, other in pairs]
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
    return eTc, views[0].aTe * eTc * views[0].cTk


def _residuals(poses: Poses, views: Sequence[View], camera: Intrinsics) -> Array:
    """(N, 2) reprojection errors of the corners of all views [px]."""
    eTc, aTk = poses
    eTk = [view.aTe.actInv(aTk) for view in views]
    cTk = [eTc.actInv(one) for one in eTk]
    counts = [len(view.corners.board) for view in views]
    turns = np.repeat([one.rotation for one in cTk], counts, axis=0)
    shifts = np.repeat([one.translation for one in cTk], counts, axis=0)
    points = np.concatenate([view.corners.board for view in views])
    seen = np.concatenate([view.corners.image for view in views])
    x, y, z = (np.einsum("nij,nj->ni", turns, points) + shifts).T
    pixels = np.stack([camera.fx * x / z + camera.cx, camera.fy * y / z + camera.cy], axis=1)
    errors: Array = pixels - seen
    return errors


def _check(view: View, poses: Poses, board: Board) -> Spread:
    """Error of the board's middle in a view that was not used."""
    eTc, aTk = poses
    middle = SE3(np.eye(3), board.centre)
    return difference(view.cTk * middle, (view.aTe * eTc).actInv(aTk) * middle)

"""Base-arm calibration: where the arm stands on the base, from views of a board on the floor.

The base stands at many places around the board, turned differently, while the arm holds the camera
over it. That the board lies flat on the floor gives height and tilt of the arm's foot, which no
motion of a base in the plane could tell; the motion gives the rest.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from pinocchio import SE3

from lab.calibration.board import Array, Board, Grey, find_corners, pose_of
from lab.calibration.fit import Poses, Problem, Spread, difference
from lab.calibration.result import Calibration, CalibrationError, Limits, require_views, worst
from robots import Intrinsics

FEWEST = 10  # views in which the board must be found
LIMITS = Limits(residual=15.0, uncertainty=Spread(3.0, 0.3), check=Spread(30.0, 1.5))
_HINT = (
    "did the board move, does it lie flat on the floor, is the camera calibrated, does the base "
    "know where it is, did it turn by half a turn or more between the views?"
)
_SCALE = 5.0  # A board that is further off counts less [mm]
_ARM = 0.3  # on which a turn of the board counts: 0.2 deg as much as 1 mm [m]
_WEIGHTS = np.array([1.0, 1.0, 3.0])  # of the board's place along its edges, and of its height
_ALL, _ON_THE_FLOOR = range(6), (0, 1, 5)
_FACE_UP = pin.utils.rotate("x", np.pi)


@dataclass(frozen=True, kw_only=True, eq=False)
class Taken:
    """One image, and where base and arm were."""

    wTb: SE3  # the base in its own map, or by its odometry
    aTe: SE3  # the end effector on the arm's foot
    image: Grey


@dataclass(frozen=True, eq=False)
class View:
    """One image of the board."""

    wTb: SE3
    aTm: SE3  # the board on the arm's foot, from this view alone


def solve(
    taken: Sequence[Taken],
    board: Board,
    camera: Intrinsics,
    eTc: SE3,
    nominal: SE3,
    thickness: float = 0.0,
) -> Calibration:
    """bTa, the arm's foot on the base.

    Args:
        taken: images of the board, and where they were taken from.
        board: that lay still on the floor.
        camera: intrinsics of the images.
        eTc: the camera on the end effector, calibrated.
        nominal: bTa as the robot file has it; the search begins there.
        thickness: of the board: so high is its face above the floor [m].

    Raises:
        CalibrationError: too few images show the board, or it is not the floor that it lies on.
            Whether the result is good is for the caller to ask.
    """
    views = []
    for one in taken:
        if (corners := find_corners(one.image, board)) is not None:
            views.append(View(one.wTb, one.aTe * eTc * pose_of(corners, camera)))
    require_views(len(views), len(taken), FEWEST)
    middle = SE3(np.eye(3), board.centre)
    problem = Problem[View](lambda x, them: _misses(x, them, middle), (_ALL, _ON_THE_FLOOR), _SCALE)
    poses, checks = problem.solve_checked(
        lambda used: (nominal, _on_the_floor(used, nominal, thickness)),
        views,
        lambda x, held: [difference(SE3.Identity(), one) for one in _apart(x, held, middle)],
    )
    bTa, _ = poses
    return Calibration(
        key="arm_mount",
        what="bTa, the arm's foot on the base",
        transform=bTa,
        views=len(views),
        held_out=len(checks),
        residual=_rms(poses, views, middle),
        unit="mm",
        uncertainty=problem.uncertainty(poses, views),
        check=worst(checks),
        from_nominal=difference(bTa, nominal),
        limits=LIMITS,
        hint=_HINT,
    )


def _on_the_floor(views: Sequence[View], nominal: SE3, thickness: float) -> SE3:
    """About where the board lies, face up on the floor.

    Raises:
        CalibrationError: it does not lie there.
    """
    guesses = [one.wTb * nominal * one.aTm for one in views]
    steepness = np.median([one.rotation[2, 2] for one in guesses])
    if steepness > -0.7:  # its z goes into the board
        raise CalibrationError(
            "refused: the board does not lie face up on the floor, or the camera's mount is not "
            "calibrated: do `calibrate hand-eye` first"
        )
    headings = np.array([one.rotation[:2, 0] for one in guesses]).mean(0)
    turn = pin.utils.rotate("z", float(np.arctan2(headings[1], headings[0])))
    x, y = np.median([one.translation[:2] for one in guesses], axis=0)
    return SE3(turn @ _FACE_UP, np.array([x, y, thickness]))


def _misses(poses: Poses, views: Sequence[View], middle: SE3) -> Array:
    """(2 N, 3) by how far the middle of the board misses itself, and its turn on an arm [mm].

    Its height is worth more than its place: the floor moves less than the base errs.
    """
    apart = _apart(poses, views, middle)
    places = [_WEIGHTS * one.translation for one in apart]
    return 1e3 * np.array([*places, *(_ARM * pin.log3(one.rotation) for one in apart)])


def _rms(poses: Poses, views: Sequence[View], middle: SE3) -> float:
    """By how far the middle of the board misses itself [mm]."""
    misses = [one.translation for one in _apart(poses, views, middle)]
    return 1e3 * float(np.sqrt((np.array(misses) ** 2).sum(1).mean()))


def _apart(poses: Poses, views: Sequence[View], middle: SE3) -> list[SE3]:
    bTa, wTm = poses
    there = wTm * middle
    return [there.actInv(one.wTb * bTa * one.aTm * middle) for one in views]

"""Base-arm calibration: where the arm stands on the base, from views of a board on the floor.

The base stands at many places around the board while the arm holds the camera over it. That the
board lies flat on the floor gives height and tilt of the arm's foot, which motion in the plane
cannot; the motion gives the rest.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from pinocchio import SE3

from config.poses import OdometryPose
from controller import RobotModel
from lab.calibration.board import Array, Board, find_corners, pose_of
from lab.calibration.fit import Poses, Problem, Spread, difference
from lab.calibration.live import LiveBase
from lab.calibration.postures import aTe_of
from lab.calibration.result import Calibration, CalibrationError, Limits, require_views, worst
from lab.calibration.rigs import SimulatedBase
from robots import RobotDescription

FEWEST = 10  # views in which the board must be found
LIMITS = Limits(residual=15.0, uncertainty=Spread(3.0, 0.3), check=Spread(30.0, 1.5))
_HINT = (
    "did the board move, does it lie flat on the floor, is the camera calibrated, does the base "
    "know where it is, did it turn by half a turn or more between the views?"
)
_SCALE = 5.0  # larger errors of the board count less [mm]
_ARM = 0.3  # lever of a turn of the board: 0.2 deg counts as 1 mm [m]
_WEIGHTS = np.array([1.0, 1.0, 3.0])  # of the board's place along its edges, and of its height
_ALL, _ON_THE_FLOOR = range(6), (0, 1, 5)
_FACE_UP = pin.utils.rotate("x", np.pi)


@dataclass(frozen=True, eq=False)
class View:
    """One image of the board."""

    oTb: OdometryPose
    aTk: SE3  # the board on the arm's foot, from this view alone


def calibrate_base_arm(
    rig: SimulatedBase | LiveBase,
    description: RobotDescription,
    board: Board,
    thickness: float = 0.0,
    say: Callable[[str], None] = lambda _: None,
) -> Calibration:
    """View a board on the floor from many places, and find bTa, the arm's foot on the base.

    The camera mount of `description` is calibrated; `thickness` is the height of the board's face
    above the floor [m], and `say` receives lines of progress. Raises CalibrationError: the board is
    seen too seldom, or does not lie on the floor. The caller asks whether the result is good.
    """
    model, camera, nominal = RobotModel(description), description.camera, description.bTa
    views, taken = [], 0
    while rig.next_place():
        oTb, aTe, corners = rig.oTb(), aTe_of(model, rig.q()), find_corners(rig.image(), board)
        taken += 1
        if corners is not None:
            views.append(View(oTb, aTe * camera.eTc * pose_of(corners, camera.intrinsics)))
        say(f"view {taken}: the board is {'not seen' if corners is None else 'seen'}")
    require_views(len(views), taken, FEWEST)
    middle = SE3(np.eye(3), board.centre)
    problem = Problem[View](
        lambda x, them: _residuals(x, them, middle), (_ALL, _ON_THE_FLOOR), _SCALE
    )
    poses, checks = problem.solve_checked(
        lambda used: (nominal, _on_the_floor(used, nominal, thickness)),
        views,
        lambda x, held: [difference(SE3.Identity(), one) for one in _apart(x, held, middle)],
    )
    return Calibration(
        key="arm_mount",
        what="bTa, the arm's foot on the base",
        transform=poses[0],
        views=len(views),
        held_out=len(checks),
        residual=_rms(poses, views, middle),
        unit="mm",
        uncertainty=problem.uncertainty(poses, views),
        check=worst(checks),
        from_nominal=difference(poses[0], nominal),
        limits=LIMITS,
        hint=_HINT,
    )


def _on_the_floor(views: Sequence[View], nominal: SE3, thickness: float) -> SE3:
    """Approximate pose of the board, face up on the floor.

    Raises CalibrationError: it does not lie there.
    """
    guesses = [one.oTb * nominal * one.aTk for one in views]
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


def _residuals(poses: Poses, views: Sequence[View], middle: SE3) -> Array:
    """(2 N, 3) errors of the board's middle, and of its rotation on a lever [mm]."""
    apart = _apart(poses, views, middle)
    places = [_WEIGHTS * one.translation for one in apart]
    return 1e3 * np.array([*places, *(_ARM * pin.log3(one.rotation) for one in apart)])


def _rms(poses: Poses, views: Sequence[View], middle: SE3) -> float:
    """Root mean square error of the board's middle [mm]."""
    errors = [one.translation for one in _apart(poses, views, middle)]
    return 1e3 * float(np.sqrt((np.array(errors) ** 2).sum(1).mean()))


def _apart(poses: Poses, views: Sequence[View], middle: SE3) -> list[SE3]:
    bTa, oTk = poses
    there = oTk * middle
    return [there.actInv(one.oTb * bTa * one.aTk * middle) for one in views]

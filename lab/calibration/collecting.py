"""Take the images of a calibration with a rig."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from pinocchio import SE3

from controller import RobotModel
from lab.calibration import base_arm, hand_eye
from lab.calibration.board import Board, find_corners, pose_of
from lab.calibration.postures import aTe_of, postures
from lab.calibration.result import Calibration, CalibrationError
from lab.calibration.rigs import ArmRig, BaseRig
from robots import RobotDescription

Say = Callable[[str], None]


def calibrate_hand_eye(
    rig: ArmRig,
    description: RobotDescription,
    board: Board,
    count: int,
    rng: np.random.Generator,
    say: Say = lambda _: None,
) -> Calibration:
    """Take the camera around the board, and find out where it is on the hand.

    Args:
        rig: whose camera sees the board.
        description: of the robot, with a camera mount that is right to some centimetres.
        board: that lies still.
        count: of views.
        rng: chooses the postures.
        say: told how it goes.

    Raises:
        CalibrationError: the board is not seen. Whether the result is good is for the caller to
            ask.
    """
    model, camera = RobotModel(description), description.camera
    first = rig.q()
    corners = find_corners(rig.image(), board)
    if corners is None:
        raise CalibrationError(
            "the camera does not see the board: take the hand 0.4 m above its middle; compare "
            "--columns and --rows with what was printed"
        )
    aTm = aTe_of(model, first) * camera.eTc * pose_of(corners, camera.intrinsics)
    taken = []
    for number, q in enumerate(postures(description, model, first, aTm, board, count, rng), 1):
        rig.move_to(q)
        taken.append((aTe_of(model, rig.q()), rig.image()))
        say(f"view {number} of {count}")
    return hand_eye.solve(taken, board, camera.intrinsics, camera.eTc)


def calibrate_base_arm(
    rig: BaseRig,
    description: RobotDescription,
    board: Board,
    thickness: float = 0.0,
    say: Say = lambda _: None,
) -> Calibration:
    """Look at a board on the floor from many places, and find out where the arm is on the base.

    Args:
        rig: whose camera sees the board.
        description: of the robot, with a camera mount that was calibrated.
        board: that lies still.
        thickness: of the board [m].
        say: told how it goes.

    Raises:
        CalibrationError: the board is seen too seldom, or does not lie on the floor. Whether the
            result is good is for the caller to ask.
    """
    model, camera = RobotModel(description), description.camera
    taken: list[base_arm.Taken] = []
    while rig.next_place():
        wTb: SE3 = rig.wTb()
        view = base_arm.Taken(wTb=wTb, aTe=aTe_of(model, rig.q()), image=rig.image())
        taken.append(view)
        seen = "seen" if find_corners(view.image, board) is not None else "not seen"
        say(f"view {len(taken)}: the board is {seen}")
    return base_arm.solve(
        taken, board, camera.intrinsics, camera.eTc, description.bTa, thickness=thickness
    )

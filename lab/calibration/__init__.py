"""Where the camera is on the hand, and where the arm is on the base.

`board` is the ChArUco board and finds its corners, `hand_eye` and `base_arm` are the two problems,
`fit` the least squares behind both, `result` what comes out and whether it is good enough.
`postures` says where the arm goes, `collecting` takes the images with a rig: `rigs` has simulated
ones (`rendering` draws what they see), `live` the real ones.
"""

from lab.calibration.board import Board, find_corners, pose_of
from lab.calibration.collecting import calibrate_base_arm, calibrate_hand_eye
from lab.calibration.fit import Spread, difference
from lab.calibration.live import LiveArm, LiveBase, live_arm, live_base
from lab.calibration.postures import aTe_of
from lab.calibration.rendering import Look, render
from lab.calibration.result import Calibration, CalibrationError
from lab.calibration.rigs import ArmRig, BaseRig, Noise, SimulatedArm, SimulatedBase

__all__ = [
    "ArmRig",
    "BaseRig",
    "Board",
    "Calibration",
    "CalibrationError",
    "LiveArm",
    "LiveBase",
    "Look",
    "Noise",
    "SimulatedArm",
    "SimulatedBase",
    "Spread",
    "aTe_of",
    "calibrate_base_arm",
    "calibrate_hand_eye",
    "difference",
    "find_corners",
    "live_arm",
    "live_base",
    "pose_of",
    "render",
]

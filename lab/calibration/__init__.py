"""Calibration of the camera on the hand and of the arm on the base, with a ChArUco board."""

from lab.calibration.base_arm import calibrate_base_arm
from lab.calibration.board import Board, find_corners
from lab.calibration.fit import difference
from lab.calibration.hand_eye import calibrate_hand_eye
from lab.calibration.live import LiveArm, live_arm, live_base
from lab.calibration.postures import aTe_of
from lab.calibration.result import Calibration, CalibrationError
from lab.calibration.rigs import Look, Noise, SimulatedArm, SimulatedBase, render

"""Calibration: camera on the hand and arm on the base, with a ChArUco board; delays of the axes."""

from lab.calibration.base_arm import calibrate_base_arm
from lab.calibration.board import Board
from lab.calibration.delays import delays
from lab.calibration.fit import difference
from lab.calibration.hand_eye import calibrate_hand_eye
from lab.calibration.live import LiveArm, live_arm, live_base
from lab.calibration.postures import aTe_of
from lab.calibration.result import Calibration, CalibrationError
from lab.calibration.rigs import Look, Noise, SimulatedArm, SimulatedBase, render

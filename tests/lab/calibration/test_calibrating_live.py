"""Hand-eye calibration through the drivers of arm and camera, which talk to emulated ones."""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from pinocchio import SE3

from controller import RobotModel
from drivers import panda, realsense
from drivers.panda import PandaArm
from drivers.realsense import RealSenseCamera, RealSenseSettings
from extensions.emulators.realsense import Options, RealSenseEmulator, Shot
from hw import WallClock
from hw.clock import stopwatch
from lab.calibration import Board, LiveArm, Look, aTe_of, calibrate_hand_eye, difference, render
from robots import load_robot

ROOT = Path(__file__).parents[3]
FRANKIE, BOARD = load_robot("frankie"), Board()
_missing = panda.missing() or realsense.missing()
pytestmark = [pytest.mark.realtime, pytest.mark.skipif(bool(_missing), reason=_missing)]


@pytest.fixture
def arm():
    """A connected arm; the emulated one stands in free air."""
    address = f"127.77.{os.getpid() % 250}.{os.getpid() // 250 % 250 + 1}"
    process = subprocess.Popen(
        [sys.executable, "-m", "extensions.emulators.panda", address],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT), *filter(None, sys.path)])},
    )
    try:
        assert json.loads(process.stdout.readline()) == {"did": "begin"}
        process.stdin.write("patience 1000\n")
        process.stdin.flush()
        arm = PandaArm(address, WallClock())
        arm.connect()
        yield arm
        arm.close()
    finally:
        process.stdin.close()
        process.wait(5.0)
        process.stdout.close()


def infrared(clock: WallClock, address: str) -> RealSenseCamera:
    settings = RealSenseSettings(emulator=address, infrared=True, emitter=False, rate=6)
    camera = RealSenseCamera(FRANKIE.camera, clock, settings)
    camera.connect()
    return camera


@pytest.mark.slow
def test_hand_eye_through_both_drivers(arm):
    rng, model = np.random.default_rng(0), RobotModel(FRANKIE)
    eTc = FRANKIE.camera.eTc * SE3(pin.exp3(np.array([0.02, -0.01, 0.03])), np.full(3, 0.006))
    arm.move_to(FRANKIE.arm.ready, speed=1.0)
    turn = pin.utils.rotate("z", 0.4)
    cTk = SE3(turn, np.array([0.0, 0.0, 0.42]) - turn @ BOARD.centre)
    aTk = aTe_of(model, FRANKIE.arm.ready) * eTc * cTk
    depth = np.full((480, 640), 0.4, np.float32)
    eye = RobotModel(FRANKIE)  # of the thread that sends images

    def shoot() -> Shot:
        stamp = stopwatch()
        cTk = (aTe_of(eye, arm.read().q) * eTc).actInv(aTk)
        grey = render(BOARD, cTk, FRANKIE.camera.intrinsics, Look(), rng)
        return Shot(depth=depth, stamp=stamp, infrared=grey)

    with RealSenseEmulator(shoot, Options(infrared=True, rate=6)) as emulator:
        clock = WallClock()
        camera = infrared(clock, emulator.address)
        try:
            live = LiveArm(arm, camera, clock, speed=1.0)
            found = calibrate_hand_eye(live, FRANKIE, BOARD, 16, np.random.default_rng(1))
        finally:
            camera.close()
    found.require_good()
    wrong = difference(found.transform, eTc)
    print(f"wrong by {wrong.mm:.3f} mm and {wrong.deg:.4f} deg")
    assert wrong.mm < 1.0
    assert wrong.deg < 0.1

"""A client that shares no code with the vendor's library moves the emulated robot, too."""

from __future__ import annotations

import time

import numpy as np
import pytest
from emulated_panda import Emulator

franka = pytest.importorskip("franka", reason="franka-rs is not installed: pip install franka-rs")


def test_another_library_moves_arm_and_hand_and_recovers():
    emulator = Emulator()
    try:
        robot = franka.Robot(emulator.address, realtime="ignore")
        assert robot.server_version == 5
        start = np.array(robot.read_once().q)
        goal = start + np.array([0.1, 0.0, 0.0, 0.1, 0.0, 0.0, 0.0])
        with robot.joint_targets(fraction=0.3, backend="robot") as arm:
            arm.move_to(goal)
            emulator.wait(lambda told: np.abs(np.array(told["q"]) - goal).max() < 2e-3)
            emulator.do("reflex")
            time.sleep(0.1)
            with pytest.raises(franka.ControlException, match="cartesian_reflex"):
                arm.stop()
        assert emulator.tell()["violations"] == []
        robot.automatic_error_recovery()
        assert emulator.tell()["mode"] == "IDLE"

        hand = robot.gripper()
        assert hand.move(0.03, 0.1)
        assert hand.read_once().width == pytest.approx(0.03, abs=1e-3)
        assert not hand.grasp(0.02, 0.1, 20.0, 0.005, 0.005)  # nothing is there
        assert hand.read_once().width == pytest.approx(0.0, abs=1e-3)
    finally:
        emulator.close()

"""A camera on the hand is found over the emulated Frankie, by the command that a person types."""

from __future__ import annotations

import numpy as np
import pytest
from command_line import call
from emulated_robot import emulated, needs_drivers, robot_file

from robots import load_robot

pytestmark = [needs_drivers, pytest.mark.slow]


def test_hand_eye_over_the_emulated_robot(tmp_path):
    board, out = tmp_path / "board.png", tmp_path / "hand_eye.yaml"
    assert call("calibrate", "board", board)[0] == 0
    path = robot_file(tmp_path)
    with emulated(path) as link:
        link.do(f"board {board}")
        words = ("--robot", path, "--views", 16, "--out", out)
        code, said, err = call("calibrate", "hand-eye", *words)
    assert code == 0, said + err
    path.write_text(path.read_text() + f"camera_mount: {out.name}\n")
    found, true = load_robot(path).camera.eTc, load_robot("frankie").camera.eTc
    wrong = true.actInv(found)
    print(f"wrong by {1e3 * np.linalg.norm(wrong.translation):.2f} mm")
    np.testing.assert_allclose(wrong.homogeneous, np.eye(4), atol=1e-3)

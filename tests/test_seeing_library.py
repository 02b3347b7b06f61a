"""The face for depth images of others: frames of poses, and mistakes named."""

import numpy as np
import pytest
from pinocchio import SE3, exp3

from frankie_task.seeing import GraspFinder

K = np.array([[615.0, 0.0, 320.0], [0.0, 615.0, 240.0], [0.0, 0.0, 1.0]])
FIND = GraspFinder()


def box_on_a_table() -> np.ndarray:
    """Half a metre below the camera, 44 mm wide along x."""
    depth = np.full((480, 640), 0.50)
    depth[200:280, 290:350] = 0.45
    return depth


def test_a_grasp_is_told_in_the_frame_that_the_camera_is_told_in() -> None:
    own = FIND(box_on_a_table(), K).grasps[0]
    assert own.pose[:3, 2] == pytest.approx([0.0, 0.0, 1.0])
    assert abs(own.pose[:2, 3]).max() < 0.03
    assert 0.45 < own.pose[2, 3] < 0.50
    assert own.width == pytest.approx(0.044, abs=0.004)
    assert own.width < own.opening
    turn = exp3(np.array([0.0, 0.0, 0.7])) @ np.diag([1.0, -1.0, -1.0])
    camera = SE3(turn, np.array([1.0, 2.0, -3.0]))
    told = camera.inverse() * SE3(FIND(box_on_a_table(), K, camera.homogeneous).grasps[0].pose)
    assert told.translation == pytest.approx(own.pose[:3, 3], abs=5e-3)
    assert told.rotation == pytest.approx(own.pose[:3, :3], abs=0.1)


def test_a_mistake_is_named_instead_of_a_grasp() -> None:
    found = FIND(1000.0 * box_on_a_table(), K)
    assert found.grasps == ()
    assert "millimetres" in found.reason

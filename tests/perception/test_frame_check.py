"""Implausible frames are refused; the reason names the mistake."""

import re
from dataclasses import replace

import cv2
import numpy as np
import pytest
from pinocchio import SE3

from hw import DepthFrame
from hw.sim import D435Noise, DepthRenderer
from perception import FrameChecker, GraspDetector, frame_problem
from perception.grasps.candidates import SpreadPoints
from robots import Box, Geom, Plane, load_robot

FRANKIE = load_robot("frankie").camera
CAMERA = FRANKIE.intrinsics
TABLE = 0.7
DOWN = np.diag([1.0, -1.0, -1.0])
OVER_IT = SE3(DOWN, np.array([0.02, 0.01, TABLE + 0.45]))
PLANE = Geom(Plane(), SE3(np.eye(3), np.array([0.0, 0.0, TABLE])))
BOX = Geom(Box((0.02, 0.04, 0.025)), SE3(np.eye(3), np.array([0.0, 0.0, TABLE + 0.025])))
RENDER = DepthRenderer(CAMERA)
GOOD = RENDER.render([PLANE, BOX], OVER_IT)


def frame(depth: np.ndarray, oTc: SE3 = OVER_IT, stamp: float = 0.0) -> DepthFrame:
    return DepthFrame(depth=depth, intrinsics=CAMERA, oTc=oTc, stamp=stamp)


WRONG = {
    "millimetres as metres": (GOOD * 1000, "millimetres given as metres"),
    "whole millimetres": ((GOOD * 1000).astype(np.uint16), "holds uint16, .* in millimetres"),
    "a thousandth": (GOOD / 1000, "metres divided by 1000"),
    "ten times": (GOOD * 10, "below the floor: a wrong scale"),
    "inverted": (1 / GOOD, "below the floor"),
    "half the size": (cv2.resize(GOOD, (320, 240)), "scaled or cut without them"),
    "transposed": (GOOD.T.copy(), "transposed"),
    "three channels": (np.repeat(GOOD[..., None], 3, 2), "in colour"),
}


@pytest.mark.parametrize("name", WRONG)
def test_a_wrong_image_is_not_believed_and_the_mistake_is_named(name: str) -> None:
    depth, mistake = WRONG[name]
    detector = GraspDetector(load_robot("frankie").gripper, [SpreadPoints()])
    found = detector.detect(frame(depth))
    assert found.grasps == ()
    assert re.search(mistake, found.reason)
    assert "\n" not in found.reason


@pytest.mark.parametrize("wrong", [{"oTc": SE3(DOWN, np.full(3, np.nan))}, {"stamp": np.nan}])
def test_a_pose_or_stamp_that_is_not_finite_is_not_believed(wrong: dict) -> None:
    assert "not finite" in frame_problem(replace(frame(GOOD), **wrong))


def test_what_a_camera_really_delivers_is_believed() -> None:
    rng = np.random.default_rng(0)
    noisy = D435Noise().apply(GOOD, FRANKIE, rng)
    holes = [np.where(rng.random(GOOD.shape) < 0.3, bad, GOOD) for bad in (0, np.nan, np.inf, 65.5)]
    nothing = np.full_like(GOOD, np.nan)
    for depth in (noisy, *holes, nothing, GOOD.astype(float)):
        assert frame_problem(frame(depth)) == ""
    level = SE3(np.array([[0, 0, 1], [-1, 0, 0], [0, -1, 0]], dtype=float), np.array([0, 0, 1.0]))
    assert frame_problem(frame(RENDER.render([PLANE, BOX], level), level)) == ""


def moved(x: float) -> SE3:
    return SE3(DOWN, OVER_IT.translation + np.array([x, 0.0, 0.0]))


@pytest.mark.parametrize(("noise", "turns"), [(True, False), (False, True)])
def test_a_picture_that_does_not_change_while_the_hand_moves_is_a_fault(noise, turns) -> None:
    rng, checker = np.random.default_rng(0), FrameChecker()

    def picture(oTc: SE3) -> np.ndarray:
        depth = RENDER.render([PLANE, BOX], oTc)
        return D435Noise().apply(depth, FRANKIE, rng) if noise else depth

    frozen = picture(moved(0.0))
    assert checker.mistake(frame(picture(moved(-0.1)), moved(-0.1), 0.1)) == ""
    assert checker.mistake(frame(frozen, moved(0.0), 0.2)) == ""
    turn = SE3(cv2.Rodrigues(np.array([0.0, 0.02, 0.0]))[0], np.zeros(3))
    turned = OVER_IT * turn
    for k in range(3):  # also when the hand rests again: it has not looked since
        where = turned if turns else moved(0.01)
        mistake = checker.mistake(frame(frozen.copy(), where, 0.3 + k / 30))
        assert mistake == "the picture has not changed while the hand moved: the camera hangs"
    assert checker.mistake(frame(picture(where), where, 0.5)) == ""


def test_from_rest_two_equal_pictures_are_a_fault_only_of_a_camera_with_noise() -> None:
    checker = FrameChecker()
    for k in range(5):
        assert checker.mistake(frame(GOOD.copy(), stamp=k / 30)) == ""
    rng = np.random.default_rng(0)
    for k in range(5, 8):
        noisy = D435Noise().apply(GOOD, FRANKIE, rng)
        assert checker.mistake(frame(noisy, stamp=k / 30)) == ""
    assert "not even its noise" in checker.mistake(frame(noisy.copy(), stamp=8 / 30))


def test_a_base_that_is_relocalised_is_no_hand_that_moves() -> None:
    checker = FrameChecker()
    assert checker.mistake(frame(GOOD)) == ""
    checker.relocalise()
    assert checker.mistake(frame(GOOD.copy(), moved(0.2), 0.1)) == ""
    assert "hangs" in checker.mistake(frame(GOOD.copy(), moved(0.3), 0.2))


def test_a_frame_that_is_older_than_the_one_before_is_not_believed() -> None:
    checker = FrameChecker()
    assert checker.mistake(frame(GOOD, stamp=1.0)) == ""
    assert "clock jumps" in checker.mistake(frame(GOOD + 0.01, stamp=0.9))
    assert checker.mistake(frame(GOOD, stamp=0.93)) == ""

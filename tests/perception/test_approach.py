"""Grasps along any approach: as from straight above in a turned scene, and over the table."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from pinocchio import SE3, exp3
from test_detector import FLOOR, GRIPPER, WORKSPACE, box_world, frame, looking_down

from config.arrays import Array, Mask
from hw import DepthFrame
from hw.sim import Hand, World
from perception import Detection, GraspDetector, SceneMemory, Workspace
from perception.grasps.candidates import SpreadPoints
from robots import Box, Geom

DETECTOR = GraspDetector(GRIPPER, [SpreadPoints()])
MIDDLE = np.array([3.0, 0.0, FLOOR])


@dataclass
class Turned:
    """A workspace that was turned about the origin with all in it, over a floor far below."""

    turn: SE3
    floor: float = FLOOR - 20.0

    def contains(self, points: Array) -> Mask:
        before = (points - self.turn.translation) @ self.turn.rotation
        return np.asarray(WORKSPACE.contains(before) & (before[:, 2] > FLOOR + 0.01))


def turned_scene(turn: SE3) -> tuple[DepthFrame, Workspace]:
    world = box_world()
    objects = [replace(one, pose=turn * one.pose) for one in world.objects]
    around = World([geom.moved(turn) for geom in world.fixtures], objects)
    return frame(around, turn * looking_down(0.42, yaw=0.3)), Turned(turn)


@pytest.mark.parametrize("tilt", [0.6, -0.8, 1.5])
def test_a_scene_turned_with_the_approach_has_the_same_grasps(tilt: float) -> None:
    before = DETECTOR.detect(*turned_scene(SE3.Identity())).grasps
    turn = exp3(tilt * before[0].oTg.rotation[:, 1])  # the hand closes level as before
    oTa = SE3(turn, MIDDLE - turn @ MIDDLE + np.array([0.0, 0.0, 1.0]))
    after = DETECTOR.detect(*turned_scene(oTa), oRa=turn).grasps
    assert before
    best = oTa * before[0].oTg
    nearest = min(after, key=lambda one: np.linalg.norm(one.oTg.translation - best.translation))
    apart = best.actInv(nearest.oTg).translation  # on a long box grasps are alike along x
    assert apart == pytest.approx([0.0, 0.0, 0.0], abs=0.016)
    assert apart[1:] == pytest.approx([0.0, 0.0], abs=0.002)
    assert abs(nearest.oTg.rotation[:, 1] @ best.rotation[:, 1]) > np.cos(0.05)
    assert nearest.oTg.rotation[:, 2] == pytest.approx(-turn[:, 2])
    assert nearest.width == pytest.approx(before[0].width, abs=0.002)
    assert nearest.depth == pytest.approx(before[0].depth, abs=0.002)
    assert nearest.middle is None


def along(
    tilt_deg: float, height: float, before: float | None = None
) -> tuple[World, Detection, Array]:
    """What is found along a tilted approach on a box of a height on a wide table.

    A camera from above has seen something of a height `before` it, which is not in the image.
    """
    table = Geom(Box((1.0, 1.0, 0.1)), SE3(np.eye(3), MIDDLE - [0.0, 0.0, 0.1]), "table")
    wall = Geom(Box((0.1, 3.0, 3.0)), SE3(np.eye(3), MIDDLE - [2.0, 0.0, 0.0]), "wall")
    pose = SE3(exp3(np.array([0.0, 0.0, 0.2])), MIDDLE + np.array([0.0, 0.0, height / 2.0]))
    half = (0.02, 0.03, height / 2.0)
    box = replace(box_world().objects[0], parts=(Geom(Box(half), SE3.Identity()),), pose=pose)
    world = World([table, wall], [box])
    oRa = exp3(np.array([0.0, np.radians(tilt_deg), 0.0]))
    at = pose.translation + 0.42 * oRa[:, 2]
    at[2] = max(at[2], FLOOR + 0.1)
    sight, level = pose.translation - at, np.array([0.0, 1.0, 0.0])
    sight /= np.linalg.norm(sight)
    camera = SE3(np.stack([level, np.cross(sight, level), sight], axis=1), at)
    memory = SceneMemory()
    if before is not None:
        half = (0.03, 0.03, before / 2.0)
        tall = Geom(Box(half), SE3(np.eye(3), MIDDLE + np.array([0.14, 0.0, before / 2.0])), "tall")
        seen = frame(World([*world.fixtures, tall], [box]), looking_down(0.5))
        DETECTOR.detect(seen, WORKSPACE, memory, exp3(np.array([0.0, 0.2, 0.0])))
    return world, DETECTOR.detect(frame(world, camera), WORKSPACE, memory, oRa), oRa


@pytest.mark.parametrize(("tilt_deg", "height"), [(30.0, 0.05), (60.0, 0.12), (90.0, 0.18)])
def test_the_hand_never_enters_the_table(tilt_deg: float, height: float) -> None:
    world, found, oRa = along(tilt_deg, height)
    assert found.grasps, found.reason
    for grasp in found.grasps:
        assert grasp.oTg.rotation[:, 2] == pytest.approx(-oRa[:, 2])
        assert world.collision(Hand(GRIPPER, grasp.oTg), grasp.opening) is None
        assert grasp.oTg.rotation[2, 0] > -0.18  # with the camera above


@pytest.mark.parametrize(("before", "has_way"), [(None, True), (0.03, True), (0.12, False)])
def test_a_tilted_hand_does_not_reach_through_what_was_seen_before_it(before, has_way) -> None:
    _, found, _ = along(60.0, 0.12, before)
    assert bool(found.grasps) == has_way, found.reason


def test_what_is_lower_than_the_palm_is_not_grasped_level() -> None:
    _, found, _ = along(90.0, 0.03)
    assert found.grasps == ()
    assert "does not fit" in found.reason


def test_a_camera_that_looks_elsewhere_is_of_no_use() -> None:
    away = exp3(np.array([0.0, -1.5, 0.0]))
    found = DETECTOR.detect(frame(box_world(), looking_down(0.42)), WORKSPACE, oRa=away)
    assert found.reason == "the camera does not look along the approach"


def test_what_was_seen_along_another_approach_is_forgotten() -> None:
    memory, fresh = SceneMemory(), SceneMemory()
    seen = frame(box_world(), looking_down(0.26))
    oRa = exp3(np.array([0.2, 0.0, 0.0]))
    DETECTOR.detect(frame(box_world(), looking_down(0.5)), WORKSPACE, memory)
    one, other = (DETECTOR.detect(seen, WORKSPACE, of, oRa) for of in (memory, fresh))
    assert [g.quality for g in one.grasps] == [g.quality for g in other.grasps]

"""What was seen on the way counts where the newest image shows nothing, and nowhere else."""

from dataclasses import replace

import numpy as np
from pinocchio import SE3
from test_detector import FLOOR, WORKSPACE, box_world, detector, frame, looking_down
from test_stereo import seen_from, unknown_at

from hw import DepthFrame
from hw.sim import World
from perception import GraspDetector, GraspEstimate, HeightMap, SceneMemory
from perception.grasps.scene_memory import completed
from robots import Box, Geom

__all__ = ["detector"]  # a fixture

BOX = box_world(yaw=0.0, x=3.0, y=0.0)


def from_afar(stamp: float, world: World = BOX) -> DepthFrame:
    """The whole container."""
    return replace(frame(world, looking_down(0.5)), stamp=stamp)


def from_near(stamp: float, world: World = BOX) -> DepthFrame:
    """The box at the border of an image that is hardly wider than the hand."""
    wTc = looking_down(0.26)
    wTc.translation[1] += 0.1
    return replace(frame(world, wTc), stamp=stamp)


def across(
    detector: GraspDetector, seen: DepthFrame, memory: SceneMemory | None = None
) -> list[GraspEstimate]:
    """The grasps that are likely to hold; one on a corner of the box is not."""
    return [one for one in detector.detect(seen, WORKSPACE, memory).grasps if one.quality > 0.7]


def from_both(shift: float) -> tuple[HeightMap, HeightMap]:
    """What is seen from near and, `shift` beside it, from afar."""
    far = looking_down(0.5)
    far.translation[1] += shift
    return seen_from(looking_down(0.26)), seen_from(far)


def test_where_the_newest_map_shows_nothing_it_is_the_earlier_one() -> None:
    near, far = from_both(shift=-0.0123)
    both = completed(near, [far])
    assert near.unknown is not None
    row, column = np.nonzero(~near.unknown)
    x, y = near.origin[0] + near.cell * column, near.origin[1] + near.cell * row
    np.testing.assert_array_equal(both.at(x, y), near.heights[row, column])
    x, y = np.full(60, 3.0), near.origin[1] - near.cell * np.arange(60)
    assert unknown_at(near, 3.0, y[-1])
    assert not unknown_at(both, 3.0, y[-1])
    np.testing.assert_array_equal(both.at(x, y), far.at(x, y))


def test_a_hand_that_reaches_out_of_the_image_goes_where_the_camera_has_looked(
    detector: GraspDetector,
) -> None:
    memory = SceneMemory()
    assert not across(detector, from_near(1.0))
    assert detector.detect(from_afar(0.0), WORKSPACE, memory).grasps
    assert across(detector, from_near(1.0), memory)


def test_what_was_seen_there_is_in_the_way(detector: GraspDetector) -> None:
    """A post beside the box, which the image from near does not show."""
    post = Geom(Box((0.1, 0.012, 0.09)), SE3(np.eye(3), np.array([3.0, -0.062, 0.546])), "post")
    world = World([*BOX.fixtures, post], BOX.objects)
    memory = SceneMemory()
    detector.detect(from_afar(0.0, world), WORKSPACE, memory)
    assert not across(detector, from_near(1.0, world), memory)


def test_what_moves_is_forgotten_where_it_was_and_what_stands_still_is_not() -> None:
    """The box was seen at y = 0, and has come to y = 0.1 since."""
    memory = SceneMemory()
    memory.completed(seen_from(looking_down(0.5)), 1.0)
    moved = GraspEstimate(
        wTg=SE3(np.diag([1.0, -1.0, -1.0]), np.array([3.0, 0.1, FLOOR + 0.02])),
        width=0.03,
        opening=0.05,
        quality=1.0,
        stamp=2.0,
        pixel=(0.0, 0.0),
        angle=0.0,
        velocity=np.array([0.0, 0.1, 0.0]),
    )
    left = memory.without(moved, FLOOR)
    blind = seen_from(looking_down(0.5))
    assert blind.unknown is not None
    blind = replace(blind, unknown=np.ones_like(blind.unknown))
    before, after = memory.completed(blind, 2.0), left.completed(blind, 2.0)
    assert not unknown_at(before, 3.0, 0.0)
    assert unknown_at(after, 3.0, 0.0)
    assert not unknown_at(after, 3.0, 0.12)
    wall = 3.0 - 0.22 - 0.003
    assert unknown_at(before, wall, 0.0) == unknown_at(after, wall, 0.0)

"""Searching for grasps beside the loop."""

from dataclasses import replace
from math import inf

import numpy as np
import pytest
from harness import (
    ON_TABLE,
    TABLE_TOP,
    ByHand,
    Harness,
    block,
    detector,
    looking_down,
    table_world,
    with_the_hand_at,
)
from py_trees.common import Status

from behaviours import Vision
from behaviours.grasp import Grasp
from hw import DepthFrame
from hw.sim import DepthRenderer
from robots import load_robot

FRANKIE = load_robot("frankie")
LONG = block(half=(0.06, 0.02, 0.025))


def over_a_block() -> Harness:
    return with_the_hand_at(table_world(block()), 0.65, 0.0, 0.85)


@pytest.fixture
def beside():
    harness, executor = over_a_block(), ByHand()
    vision = Vision(harness.robot.camera, detector(), executor)
    harness.context.vision = vision
    return harness, executor, vision


def test_a_frame_is_new_in_one_tick_only_and_for_all_who_ask_in_it():
    harness = over_a_block()
    vision = Vision(harness.robot.camera, detector())
    vision.begin_tick()
    frame = vision.new_frame()
    assert frame is not None
    assert vision.new_frame() is frame
    vision.begin_tick()
    assert vision.new_frame() is None
    assert vision.frame is frame


def test_beside_the_loop_no_tick_waits_and_the_result_comes_once(beside):
    harness, executor, vision = beside
    for _ in range(5):
        harness.tick(None)
        assert vision.detect(ON_TABLE) is None
    assert len(executor.waiting) == 1
    executor.work()
    harness.tick(None)
    detection = vision.detect(ON_TABLE)
    assert vision.detect(ON_TABLE) is detection  # for every leaf of the tick
    assert vision.frame.stamp == detection.stamp < harness.robot.camera.latest(inf).stamp + 1e-9
    in_step = detector().detect(vision.frame, ON_TABLE)
    assert [one.oTg for one in detection.grasps] == [one.oTg for one in in_step.grasps] != []
    harness.tick(None)
    assert vision.detect(ON_TABLE) is None


@pytest.mark.parametrize("other", ["region", "time"])
def test_a_result_for_another_region_or_of_before_a_reset_is_dropped(beside, other):
    harness, executor, vision = beside
    vision.begin_tick()
    vision.detect(ON_TABLE)
    executor.work()
    where = replace(ON_TABLE, name="other") if other == "region" else ON_TABLE
    if other == "time":
        vision.reset()
    harness.run_for(None, 1.0)
    vision.begin_tick()
    assert vision.detect(where) is None
    assert len(executor.waiting) == 1  # the newest frame is searched instead


class Given:
    """A camera whose frames a test gives."""

    def __init__(self) -> None:
        self._render = DepthRenderer(FRANKIE.camera.intrinsics)
        self.frame: DepthFrame | None = None

    def latest(self, max_age: float) -> DepthFrame | None:
        return self.frame

    def look(self, stamp: float, above: float, aside: float = 0.0) -> None:
        oTc = looking_down(0.7, aside, TABLE_TOP + above)
        depth = self._render.render(table_world(LONG).shapes(), oTc)
        self.frame = DepthFrame(
            depth=depth, intrinsics=FRANKIE.camera.intrinsics, oTc=oTc, stamp=stamp
        )


@pytest.mark.parametrize("forgets", ["nothing", "reset", "relocalise late"])
def test_what_was_seen_on_the_way_counts_as_long_as_a_grasp_is_followed(forgets):
    camera = Given()
    vision = Vision(camera, detector())
    camera.look(0.0, above=0.5)
    vision.begin_tick()
    assert vision.track(ON_TABLE, 0.0) is not None
    camera.look(0.5, above=0.26, aside=0.1)  # nearly out of sight: narrower than the hand
    if forgets == "reset":
        vision.reset()
    elif forgets == "relocalise late":  # a frame of before is still to come
        vision.relocalise(0.4)
        camera.look(0.3, above=0.5)
        vision.begin_tick()
        vision.track(ON_TABLE, 0.4)
        camera.look(0.5, above=0.26, aside=0.1)
    vision.begin_tick()
    vision.track(ON_TABLE, 0.5)
    likely = [grasp for grasp in vision.detection.grasps if grasp.quality > 0.7]
    assert bool(likely) == (forgets == "nothing")


def test_a_frame_that_is_not_what_it_claims_to_be_counts_as_none_for_whoever_looks():
    camera = Given()
    vision = Vision(camera, detector())
    camera.look(0.0, above=0.5)
    vision.begin_tick()
    good = vision.new_frame()
    for k, wrong in enumerate([camera.frame.depth.T, (1e3 * camera.frame.depth).astype(np.uint16)]):
        camera.frame = replace(camera.frame, depth=wrong, stamp=0.1 * (k + 1))
        vision.begin_tick()
        assert vision.new_frame() is None
        assert vision.newest(-1.0) is good
        assert vision.frame is good
        vision.detect(ON_TABLE)
        assert not vision.blindness(0.1)  # one image in between is no reason to stop
    assert "millimetres" in vision.blindness(0.2)
    camera.look(0.3, above=0.5)
    vision.begin_tick()
    assert vision.new_frame() is camera.frame
    assert vision.blindness(0.3) == ""
    assert "ahead of the clock" in vision.blindness(-1.0)


@pytest.mark.parametrize(
    ("late", "end"), [(0.5, "closed at 4"), (3.0, "closed at 4"), (30.0, "not done after 20 s")]
)
def test_where_every_search_is_late_the_grasp_locks_or_says_why_it_ends(beside, late, end):
    """As where the computer is slower than the camera."""
    harness, executor, _ = beside
    leaf, begun = Grasp("grasp", harness.context, within=ON_TABLE), None
    while harness.run(leaf, seconds=0.01) is Status.RUNNING:
        begun = (begun or harness.clock.now()) if executor.waiting else None
        if begun is not None and harness.clock.now() - begun >= late:
            executor.work()
    assert leaf.feedback_message.startswith(end)
    assert (harness.world.held is not None) is (leaf.status is Status.SUCCESS)

"""Ranking of grasps by how likely they hold, the fallback, and what a grasp knows of its object."""

from dataclasses import replace

import numpy as np
import pytest
from pinocchio import SE3, exp3
from test_detector import GRIPPER, WORKSPACE, box_world, frame, looking_down
from test_region_map import world
from test_tracker import FAR, seen

from config.arrays import Array, Image, Mask
from perception import (
    NUMBERS,
    Candidates,
    GraspDetector,
    GraspPatches,
    GraspTracker,
    Proposals,
    SpreadPoints,
)

SHIPPED = GraspDetector.shipped(GRIPPER)
MIDDLE = NUMBERS.index("middle_along")


def test_grasps_are_ranked_by_how_likely_they_hold_if_that_is_told() -> None:
    def at_the_far_end(patches: GraspPatches) -> Array:
        return 100.0 * np.hypot(*patches.numbers[:, [MIDDLE, MIDDLE + 1]].T)

    def in_the_middle(patches: GraspPatches) -> Array:
        return 10.0 - at_the_far_end(patches)

    view = frame(box_world(), looking_down(0.45))
    far, near = (
        GraspDetector(GRIPPER, SHIPPED.sources, hold).detect(view, WORKSPACE).grasps
        for hold in (at_the_far_end, in_the_middle)
    )
    assert far[0].lever == max(grasp.lever for grasp in far)
    assert near[0].lever == min(grasp.lever for grasp in near) < far[0].lever
    assert far[0].quality == pytest.approx(100.0 * far[0].lever, abs=1e-3)


def likely(share: float):
    """Every grasp is as likely to hold."""
    return lambda patches: np.full(len(patches.numbers), share)


def test_of_grasps_that_are_as_likely_to_hold_the_narrow_one_comes_first():
    both = world((0.05, 0.033, 0.03), (0.05, 0.016, 0.03), gap=0.06)
    detector = GraspDetector(GRIPPER, SHIPPED.sources, likely(0.9))
    found = detector.detect(frame(both, looking_down(0.45)), WORKSPACE)
    widths = [grasp.width for grasp in found.grasps]
    assert widths[0] < 0.045 < 0.06 < max(widths)


def test_a_grasp_without_room_for_an_inaccurate_hand_is_less_likely() -> None:
    detector = GraspDetector(GRIPPER, SHIPPED.sources, likely(0.9))
    for gap, quality in ((0.026, 0.81), (0.032, 0.9)):  # between two boxes: a finger fits in both
        both = world((0.05, 0.016, 0.03), (0.05, 0.016, 0.03), gap=gap)
        found = detector.detect(frame(both, looking_down(0.45)), WORKSPACE)
        assert found.grasps[0].quality == pytest.approx(quality)


class Nothing:
    """Proposes nothing anywhere."""

    name = "nothing"

    def propose(self, image: Image, allowed: Mask) -> Proposals:
        nowhere = Candidates(
            pixel=np.empty((0, 2)), angle=np.empty(0), width=np.empty(0), quality=np.empty(0)
        )
        return Proposals(nowhere, np.zeros_like(image), directions=3)


def test_where_a_network_proposes_nothing_points_all_over_are_looked_at() -> None:
    view = frame(box_world(), looking_down(0.45))
    sources = Nothing(), SpreadPoints()
    told, alone = GraspDetector(GRIPPER, sources, *SHIPPED.holds), GraspDetector(GRIPPER, sources)
    found = told.detect(view, WORKSPACE)
    assert found.grasps[0].oTg.translation[:2] == pytest.approx([3.03, -0.02], abs=0.01)
    assert alone.detect(view, WORKSPACE).reason == "the network sees no grasp in the workspace"


def test_a_grasp_knows_how_far_its_object_reaches_however_it_is_tracked() -> None:
    view = frame(box_world(), looking_down(0.45))
    first = SHIPPED.detect(view, WORKSPACE).grasps[0]
    other_way_round = first.oTg * SE3(exp3(np.array([0.0, 0.0, np.pi])), np.zeros(3))
    assert first.outline is not None
    same_object = first.outline * np.array([-1.0, -1.0, 1.0])
    tracker = GraspTracker(lock_distance=0.1)
    for one in (first, replace(first, oTg=other_way_round, outline=same_object)):
        tracker.update(seen(one), FAR)
    tracked = tracker.update(seen(replace(first, outline=None)), FAR)
    assert tracked.outline is not None
    outline = np.array([tracked.oTg.act(corner)[:2] for corner in tracked.outline])
    box = np.array([(0.06, 0.02), (0.06, -0.02), (-0.06, -0.02), (-0.06, 0.02)])
    for corner in box @ exp3(np.array([0.0, 0.0, 0.5]))[:2, :2].T + [3.03, -0.02]:
        assert np.linalg.norm(outline - corner, axis=1).min() < 0.006


def test_what_is_not_likely_to_hold_is_no_grasp():
    view = frame(box_world(), looking_down(0.45))
    found = GraspDetector(GRIPPER, SHIPPED.sources, likely(0.2)).detect(view, WORKSPACE)
    assert not found.grasps
    assert found.reason == "the hand fits, but is not likely to hold anything"

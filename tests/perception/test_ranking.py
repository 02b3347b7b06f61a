"""Ranking of grasps by how likely they hold, and the fallback when a network proposes none."""

import numpy as np
import pytest
from test_detector import GRIPPER, WORKSPACE, box_world, frame, looking_down
from test_region_map import world

from perception import NUMBERS, Candidates, GraspDetector, GraspPatches, Proposals
from perception.frame import Array, Image, Mask

MIDDLE = NUMBERS.index("middle_along")


def test_grasps_are_ranked_by_how_likely_they_hold_if_that_is_told() -> None:
    def at_the_far_end(patches: GraspPatches) -> Array:
        return 100.0 * np.hypot(*patches.numbers[:, [MIDDLE, MIDDLE + 1]].T)

    def in_the_middle(patches: GraspPatches) -> Array:
        return 10.0 - at_the_far_end(patches)

    seen = frame(box_world(), looking_down(0.45))
    far, near = (
        GraspDetector(gripper=GRIPPER, hold=hold).detect(seen, WORKSPACE).grasps
        for hold in (at_the_far_end, in_the_middle)
    )
    assert far[0].lever == max(grasp.lever for grasp in far)
    assert near[0].lever == min(grasp.lever for grasp in near) < far[0].lever
    assert far[0].quality == pytest.approx(100.0 * far[0].lever, abs=1e-3)


def test_of_grasps_that_are_as_likely_to_hold_the_narrow_one_comes_first() -> None:
    def equally(patches: GraspPatches) -> Array:
        return np.full(len(patches.numbers), 0.9)

    both = world((0.05, 0.033, 0.03), (0.05, 0.016, 0.03), gap=0.06)
    found = GraspDetector(gripper=GRIPPER, hold=equally).detect(
        frame(both, looking_down(0.45)), WORKSPACE
    )
    widths = [grasp.width for grasp in found.grasps]
    assert widths[0] < 0.045 < 0.06 < max(widths)


class Nothing:
    """Proposes nothing anywhere."""

    name = "nothing"

    def propose(self, image: Image, allowed: Mask) -> Proposals:
        nowhere = Candidates(
            pixel=np.empty((0, 2)), angle=np.empty(0), width=np.empty(0), quality=np.empty(0)
        )
        return Proposals(nowhere, np.zeros_like(image), directions=3)


def test_where_a_network_proposes_nothing_points_all_over_are_looked_at() -> None:
    seen = frame(box_world(), looking_down(0.45))
    told, alone = GraspDetector(gripper=GRIPPER), GraspDetector(gripper=GRIPPER, by_check=True)
    told.proposer = alone.proposer = Nothing()
    found = told.detect(seen, WORKSPACE)
    assert found.grasps[0].wTg.translation[:2] == pytest.approx([3.03, -0.02], abs=0.01)
    assert alone.detect(seen, WORKSPACE).reason == "the network sees no grasp in the workspace"


def test_what_is_not_likely_to_hold_is_no_grasp() -> None:
    def hardly(patches: GraspPatches) -> Array:
        return np.full(len(patches.numbers), 0.2)

    seen = frame(box_world(), looking_down(0.45))
    found = GraspDetector(gripper=GRIPPER, hold=hardly).detect(seen, WORKSPACE)
    assert not found.grasps
    assert found.reason == "the hand fits, but is not likely to hold anything"

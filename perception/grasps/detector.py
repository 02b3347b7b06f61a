"""The grasp detector: from one depth frame to ranked grasps in odometry."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from config.arrays import Array, Image
from perception.detected_grasp import Detection, GraspEstimate
from perception.frame import Frame, ObjectRegion, Workspace
from perception.frame_check import frame_problem
from perception.grasps.candidates import CandidateSource, Proposals, SpreadPoints
from perception.grasps.height_map import local_heights, with_floor
from perception.grasps.network_input import INPUT_SIZE, Crop, NoDepthError, prepare
from perception.grasps.patches import HoldProbability
from perception.grasps.ranking import GraspRanking
from perception.grasps.scene_memory import SceneMemory
from perception.grasps.view import MAX_CAMERA_AXIS_Z, View
from perception.networks.ggcnn import load_ggcnn
from perception.networks.hold import shipped_hold
from robots import GripperDescription

_MIN_VALID = 0.02  # share of pixels with a depth in a usable frame
_MIN_SIDE = 16  # of a usable frame [px]
_EVERY = 16  # of these rows and columns two depths that differ are sought first: it is faster [px]
_NOTHING = "nothing stands out in the workspace"


class GraspDetector:
    """Finds the grasps of one hand in depth frames.

    A source proposes candidates in the image; the hand is tried at each on the measured heights;
    what fits is ranked by how likely it holds.

    Args:
        gripper: the hand.
        sources: of candidates; the next is asked where the last one's give no grasp, if `hold` is
            known or on given objects (`ObjectRegion`). ValueError: there is none.
        hold: how likely a grasp from straight above holds; None ranks by check and source.
        hold_tilted: the same of a tilted hand.
    """

    def __init__(
        self,
        gripper: GripperDescription,
        sources: Sequence[CandidateSource],
        hold: HoldProbability | None = None,
        hold_tilted: HoldProbability | None = None,
    ) -> None:
        if not sources:
            raise ValueError("grasps need a source of candidates, as SpreadPoints()")
        self.sources, self.holds = tuple(sources), (hold, hold_tilted)
        self._gripper = gripper

    @classmethod
    def shipped(cls, gripper: GripperDescription, weights: Path | None = None) -> GraspDetector:
        """GG-CNN, then perhaps points all over; ranked by the networks of this hand.

        Args:
            gripper: the hand; one without networks of its own ranks by check and GG-CNN.
            weights: of GG-CNN; None takes the shipped ones.

        Raises:
            WeightsError: the weights are missing or do not fit.
        """
        hold, hold_tilted = (shipped_hold(gripper, tilted=tilted) for tilted in (False, True))
        return cls(gripper, (load_ggcnn(weights), SpreadPoints()), hold, hold_tilted)

    def detect(
        self,
        frame: Frame,
        workspace: Workspace | None = None,
        memory: SceneMemory | None = None,
        oRa: Array | None = None,
    ) -> Detection:
        """Find grasps along an approach: best first, or none and the reason.

        Without a workspace they are sought everywhere above the largest level surface. What stands
        out beside the middle of the image is searched where the middle has no grasp. The frame is
        added to the memory, and what it does not show is taken from there.

        Args:
            frame: of a camera that looks along the approach, by less than 60 degrees.
            workspace: where to grasp.
            memory: of earlier frames.
            oRa: (3, 3) rotation in odometry of the frame a, along whose -z the hand approaches,
                at most level; None is from straight above.
        """
        if oRa is not None and np.array_equal(oRa, np.eye(3)):
            oRa = None
        if reason := _unusable(frame, oRa):
            return _detection(frame.stamp, reason=reason)
        view = View.of(frame, workspace, oRa)
        raised = None if view.oRa is None else view.raised()
        if memory is not None and raised is not None:
            raised = memory.raised(raised, view.stamp)
        middle = view.crop()
        found = self._search(view, middle, memory, raised)
        if found.grasps or (aside := view.stands_out_beside(middle)) is None:
            return found
        beside = self._search(view, view.crop(aside), memory, raised)
        return found if found.reason != _NOTHING and not beside.grasps else beside

    def _search(
        self, view: View, crop: Crop, memory: SceneMemory | None, raised: Array | None
    ) -> Detection:
        """Find grasps in a part of a view, among what stands out (N, 3) in all of it."""
        try:
            prepared = prepare(view.along, crop)
        except NoDepthError:
            return _detection(view.stamp, reason="no depth was measured in the middle of the image")
        scene, border = local_heights(view.along, crop, view.support, view.oRa)
        if memory is not None:
            scene = memory.completed(scene, view.stamp)
        allowed = view.allowed(prepared)
        if not allowed.any():
            return _detection(view.stamp, crop=crop, reason=_NOTHING)
        hold = self.holds[view.oRa is not None]
        scene = with_floor(scene, view.floor)
        ranking = GraspRanking(view, prepared, scene, border, self._gripper, hold, raised)
        # The hand may fit only where a network proposes nothing: as between neighbours. But
        # points all over find chords at rims of what is too wide, if nothing tells what holds.
        is_meant = isinstance(view.workspace, ObjectRegion)
        sources = self.sources if is_meant or hold is not None else self.sources[:1]
        proposals: list[Proposals] = []
        grasps: tuple[GraspEstimate, ...] = ()
        for source in sources:
            proposals.append(source.propose(prepared.network_input, allowed))
            if grasps := ranking.among(proposals[-1]):
                break
        reason = "" if grasps else _why_none(ranking, proposals[0], is_meant=is_meant)
        return _detection(view.stamp, grasps, proposals[0].quality, crop, reason)


def _why_none(ranking: GraspRanking, first: Proposals, *, is_meant: bool) -> str:
    """Why there is no grasp where something stands out; `first` is of the first source."""
    if ranking.unlikely:
        return "the hand fits, but is not likely to hold anything"
    if is_meant:
        return "the hand fits nowhere on what is meant"
    if len(first.candidates.quality) == 0:
        return "the network sees no grasp in the workspace"
    return "the hand does not fit at any of the grasps that the network proposes"


def _detection(
    stamp: float,
    grasps: tuple[GraspEstimate, ...] = (),
    quality: Image | None = None,
    crop: Crop | None = None,
    reason: str = "",
) -> Detection:
    if quality is None:
        quality = np.zeros((INPUT_SIZE, INPUT_SIZE), dtype=np.float32)
    covered = (float(crop.u0), float(crop.v0), float(crop.size)) if crop else (0.0, 0.0, 0.0)
    return Detection(grasps=grasps, reason=reason, quality=quality, crop=covered, stamp=stamp)


def _unusable(frame: Frame, oRa: Array | None) -> str:
    """Why a frame is unusable; empty if it is usable."""
    if mistake := frame_problem(frame):
        return mistake
    depth, valid = frame.cloud.depth, frame.cloud.valid
    if min(depth.shape) < _MIN_SIDE:
        return f"the depth image has {depth.shape} pixels: too few to grasp by"
    up = np.array([0.0, 0.0, 1.0]) if oRa is None else oRa[:, 2]  # against the approach
    if frame.oTc.rotation[:, 2] @ up > MAX_CAMERA_AXIS_Z:
        return "the camera does not look along the approach"
    if np.count_nonzero(valid) < _MIN_VALID * valid.size:
        return "hardly any depth was measured"
    for every in (_EVERY, 1):
        measured = depth[::every, ::every][valid[::every, ::every]]
        if (measured != measured[:1]).any():
            return ""
    return "the depth is the same in every pixel"

"""The grasp detector: from one depth frame to ranked grasps in the world."""

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np

from perception.frame import Array, Frame, Image, Mask, ObjectRegion, Workspace
from perception.frame_check import frame_problem
from perception.geometry import world_points
from perception.grasp import Detection
from perception.grasps.approach import frame_along, workspace_along
from perception.grasps.candidates import CandidateSource, SpreadPoints
from perception.grasps.height_map import local_heights, with_floor
from perception.grasps.network_input import (
    INPUT_SIZE,
    OUTPUT_STRIDE,
    Crop,
    NoDepthError,
    Prepared,
    measured,
    prepare,
    scaled_crop,
    valid_depth,
)
from perception.grasps.patches import HoldProbability
from perception.grasps.ranking import MIN_OBJECT_HEIGHT, GraspRanking
from perception.grasps.scene_memory import SceneMemory
from perception.grasps.stereo import FAR, near_floor_filled, smoothed
from perception.region_map import WALL_MARGIN
from robots import GripperDescription

OCCUPIED_HEIGHT = 0.010  # surfaces lower than this above the floor are not occupied [m]
_MIN_VALID = 0.02  # share of pixels with a depth in a usable frame
_MAX_CAMERA_AXIS_Z = -0.5  # the optical axis is within 60 degrees of the approach
_FAR_END = 90.0  # of the depths in the workspace that a level camera sees [percent]
_LEVEL_BIN = 0.005  # of the histogram of heights that finds the support surface [m]
_STEP = 3  # only every third row and column of the image is looked at for what stands out [px]
_MIN_PIXELS = 100  # of the image that a piece outside the middle covers; fewer are noise
NOTHING = "nothing stands out in the workspace"


class GraspDetector:
    """GG-CNN, whose candidates are refined and tested against the measured depth.

    Args:
        weights: a weights file; None takes the shipped weights.
        gripper: the hand.
        proposer: another source of candidates, instead of GG-CNN.
        hold: how likely grasps hold; None takes what is shipped for this hand, if anything is.
        by_check: rank grasps by check and network, not by how likely they hold.

    Raises:
        WeightsError: the weights are missing or do not fit.
    """

    def __init__(
        self,
        weights: Path | None = None,
        *,
        gripper: GripperDescription,
        proposer: CandidateSource | None = None,
        hold: HoldProbability | None = None,
        by_check: bool = False,
    ) -> None:
        self._gripper = gripper
        # Between neighbours, or on the handle of a cup, the hand may fit only where a network
        # proposes nothing.
        self._otherwise: CandidateSource | None = SpreadPoints() if proposer is None else None
        if proposer is None:
            # Not at the top: torch takes a second to import.
            from perception.networks import Proposer, load_network, shipped_network

            proposer = Proposer(load_network(weights) if weights else shipped_network())
        hold_tilted = hold
        if hold is None and not by_check:
            from perception.networks import shipped_hold

            hold, hold_tilted = (shipped_hold(gripper, tilted=t) for t in (False, True))
        self.proposer: CandidateSource = proposer
        self._hold, self._hold_tilted = hold, hold_tilted

    def detect(
        self,
        frame: Frame,
        workspace: Workspace | None = None,
        memory: SceneMemory | None = None,
        wRa: Array | None = None,
    ) -> Detection:
        """Find grasps along an approach: best first, or none and the reason.

        Without a workspace they are sought everywhere above the largest level surface. What stands
        out beside the middle of the image is searched where the middle has no grasp. The frame is
        added to the memory, and what it does not show is taken from there.

        Args:
            frame: of a camera that looks along the approach, by less than 60 degrees.
            workspace: where to grasp.
            memory: of earlier frames.
            wRa: (3, 3) rotation in the world of the frame a, along whose -z the hand approaches,
                at most level; None is from straight above.
        """
        if wRa is not None and np.array_equal(wRa, np.eye(3)):
            wRa = None
        if reason := _unusable(frame, wRa):
            return _no_grasp(frame, reason)
        depth = np.asarray(frame.depth, dtype=np.float32)
        support = _support_depth(depth, frame, workspace)
        if support > FAR:
            depth = smoothed(depth, frame.intrinsics.fx)
        floor = _level(frame) if workspace is None else workspace.floor
        if wRa is not None:
            depth = near_floor_filled(depth, frame.intrinsics, frame.wTc, floor)
        middle = scaled_crop(depth.shape, frame.intrinsics, support)
        found = self._search(frame, depth, middle, support, workspace, floor, memory, wRa)
        if found.grasps or (aside := _stands_out_beside(middle, frame, workspace, floor)) is None:
            return found
        crop = scaled_crop(depth.shape, frame.intrinsics, support, aside)
        beside = self._search(frame, depth, crop, support, workspace, floor, memory, wRa)
        return found if found.reason != NOTHING and not beside.grasps else beside

    def _search(
        self,
        frame: Frame,
        depth: Image,
        crop: Crop,
        support: float,
        workspace: Workspace | None,
        floor: float,
        memory: SceneMemory | None,
        wRa: Array | None,
    ) -> Detection:
        """Find grasps in a crop of an image whose support surface is at a depth [m]."""
        along = frame_along(frame, wRa)
        try:
            prepared = prepare(depth, crop, frame.intrinsics, along.wTc)
        except NoDepthError:
            return _no_grasp(frame, "no depth was measured in the middle of the image")
        around = local_heights(along, depth, crop, support, wRa)
        allowed = _allowed(prepared, frame, workspace, floor)
        covered = (float(crop.u0), float(crop.v0), float(crop.size))
        scene = around.scene
        if memory is not None:
            scene = memory.completed(scene, frame.stamp)
        around = replace(around, scene=with_floor(scene, floor))
        if not allowed.any():
            return _no_grasp(frame, NOTHING, covered)
        proposals = self.proposer.propose(prepared.network_input, allowed)
        is_meant = isinstance(workspace, ObjectRegion)
        hold = self._hold if wRa is None else self._hold_tilted
        ranking = GraspRanking(
            along,
            prepared,
            around,
            workspace_along(workspace, wRa),
            floor,
            self._gripper,
            hold,
        )
        grasps = ranking.among(proposals)
        # Without a hold estimate, spread points find chords at the rims of objects that are too
        # wide, so then they are tried only on given objects.
        if not grasps and self._otherwise is not None and (is_meant or hold is not None):
            grasps = ranking.among(self._otherwise.propose(prepared.network_input, allowed))
        if grasps:
            reason = ""
        elif ranking.unlikely:
            reason = "the hand fits, but is not likely to hold anything"
        elif is_meant:
            reason = "the hand fits nowhere on what is meant"
        elif len(proposals.candidates.quality) == 0:
            reason = "the network sees no grasp in the workspace"
        else:
            reason = "the hand does not fit at any of the grasps that the network proposes"
        return Detection(
            grasps=grasps,
            reason=reason,
            quality=proposals.quality,
            crop=covered,
            stamp=frame.stamp,
        )


def _unusable(frame: Frame, wRa: Array | None) -> str:
    """Why a frame is unusable; empty if it is usable."""
    if mistake := frame_problem(frame):
        return mistake
    depth = np.asarray(frame.depth)
    if min(depth.shape) < 16:
        return f"the depth image has {depth.shape} pixels: too few to grasp by"
    if frame_along(frame, wRa).wTc.rotation[2, 2] > _MAX_CAMERA_AXIS_Z:
        return "the camera does not look along the approach"
    valid = valid_depth(depth)
    count = np.count_nonzero(valid)
    if count < _MIN_VALID * valid.size:
        return "hardly any depth was measured"
    if np.count_nonzero(depth == depth.flat[valid.argmax()]) >= count:
        return "the depth is the same in every pixel"
    return ""


def _no_grasp(
    frame: Frame,
    reason: str,
    crop: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> Detection:
    return Detection(
        grasps=(),
        reason=reason,
        quality=np.zeros((INPUT_SIZE, INPUT_SIZE), dtype=np.float32),
        crop=crop,
        stamp=frame.stamp,
    )


def _support_depth(depth: Image, frame: Frame, workspace: Workspace | None) -> float:
    """Depth of the support surface along the optical axis; or of its far end, seen level [m]."""
    wTc = frame.wTc
    if workspace is not None and wTc.rotation[2, 2] <= _MAX_CAMERA_AXIS_Z:
        along_axis = float((workspace.floor - wTc.translation[2]) / wTc.rotation[2, 2])
        if along_axis > 0.0:
            return along_axis
    elif workspace is not None:
        row, column, points = measured(frame, _STEP)
        inside = workspace.contains(points)
        if inside.any():
            return float(np.percentile(depth[row[inside], column[inside]], _FAR_END))
    return float(np.median(depth[valid_depth(depth)]))


def _level(frame: Frame) -> float:
    """Height of the largest level surface in an image [m]."""
    heights = measured(frame, _STEP)[2][:, 2]
    bins = np.rint(heights / _LEVEL_BIN).astype(np.int64)
    lowest = int(bins.min())
    level = (int(np.bincount(bins - lowest).argmax()) + lowest) * _LEVEL_BIN
    return float(np.median(heights[np.abs(heights - level) < _LEVEL_BIN]))


def _well_inside(workspace: Workspace, points: Array) -> Mask:
    """Which of the (N, 3) points are inside and `WALL_MARGIN` or more from the upright sides."""
    inside = np.ones(len(points), dtype=np.bool_)
    for dx, dy in ((1, 0), (-1, 0), (0, 1), (0, -1)):
        inside &= workspace.contains(points + WALL_MARGIN * np.array([dx, dy, 0.0]))
    return inside


def _allowed(prepared: Prepared, frame: Frame, workspace: Workspace | None, floor: float) -> Mask:
    """(300, 300) where a grasp may be: the depth was measured, inside the workspace."""
    middle = np.arange(OUTPUT_STRIDE // 2, INPUT_SIZE, OUTPUT_STRIDE)
    grid = np.stack(np.meshgrid(middle, middle), axis=-1).astype(float)
    pixel = prepared.crop.to_image(grid)
    depth = prepared.depth[np.ix_(middle, middle)]
    points = world_points(depth, frame.intrinsics, frame.wTc, pixel[..., 0], pixel[..., 1])
    allowed = points[..., 2] >= floor + MIN_OBJECT_HEIGHT
    if workspace is not None:
        allowed[allowed] = _well_inside(workspace, points[allowed])
    enlarged = cv2.resize(
        allowed.astype(np.uint8), (INPUT_SIZE, INPUT_SIZE), interpolation=cv2.INTER_NEAREST
    )
    mask: Mask = enlarged.astype(np.bool_) & ~prepared.missing
    return mask


def _stands_out_beside(
    crop: Crop, frame: Frame, workspace: Workspace | None, floor: float
) -> Array | None:
    """(2,) the pixel in the middle of what stands out nearest to a crop, outside it; or None."""
    row, column, points = measured(frame, _STEP)
    high = points[:, 2] >= floor + OCCUPIED_HEIGHT
    if workspace is not None:
        high[high] = _well_inside(workspace, points[high])
    mask = np.zeros(np.asarray(frame.depth).shape, dtype=np.uint8)[::_STEP, ::_STEP]
    mask[row[high] // _STEP, column[high] // _STEP] = 1
    first, end = crop.v0 // _STEP, (crop.v0 + crop.size) // _STEP
    mask[first:end, crop.u0 // _STEP : (crop.u0 + crop.size) // _STEP] = 0
    _, _, stats, middles = cv2.connectedComponentsWithStats(mask)
    pieces = np.asarray(middles[1:])[stats[1:, cv2.CC_STAT_AREA] >= _MIN_PIXELS / _STEP**2]
    if not len(pieces):
        return None
    centre = np.array([crop.u0, crop.v0]) + 0.5 * crop.size
    nearest: Array = _STEP * pieces[np.linalg.norm(_STEP * pieces - centre, axis=1).argmin()]
    return nearest

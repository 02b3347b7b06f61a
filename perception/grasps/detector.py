"""The grasp detector: from one depth frame to ranked grasps in the world."""

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
from pinocchio import SE3

from perception.frame import Array, Frame, Image, Mask, ObjectRegion, Workspace
from perception.frame_check import frame_problem
from perception.geometry import world_points
from perception.grasp import Detection
from perception.grasps.candidates import WITHOUT_NETWORK, CandidateSource, SpreadPoints
from perception.grasps.height_map import HeightMap, local_heights
from perception.grasps.network_input import (
    INPUT_SIZE,
    OUTPUT_STRIDE,
    NoDepthError,
    Prepared,
    central_crop,
    prepare,
    valid_depth,
)
from perception.grasps.patches import HoldProbability
from perception.grasps.ranking import MIN_OBJECT_HEIGHT, GraspRanking
from perception.grasps.scene_memory import SceneMemory
from perception.grasps.stereo import FAR, smoothed
from perception.region_map import WALL_MARGIN
from robots import GripperDescription

OCCUPIED_HEIGHT = 0.010  # surfaces lower than this above the floor are not occupied [m]
_MIN_VALID = 0.02  # share of pixels with a depth in a usable frame
_MAX_CAMERA_AXIS_Z = -0.5  # the optical axis is within 60 degrees of straight down
_LEVEL_BIN = 0.005  # of the histogram of heights that finds the support surface [m]
_AREA_STEP = 3  # only every third row and column counts for areas [px]
_LITTLE = 1e-4  # a smaller area is noise [m^2]


class GraspDetector:
    """A grasp network whose candidates are refined and tested against the measured depth.

    Args:
        weights: a weights file; None takes shipped weights.
        network: name of a shipped network or of a source without one, instead of `weights`.
        gripper: the hand.
        proposer: source of candidates, instead of `weights` and `network`.
        hold: how likely grasps hold; None takes what is shipped for this hand, if anything is.
        by_check: rank grasps by check and network, not by how likely they hold; None does so for
            sources without a network.

    Raises:
        WeightsError: the weights are missing or do not fit.
    """

    def __init__(
        self,
        weights: Path | None = None,
        network: str | None = None,
        *,
        gripper: GripperDescription,
        proposer: CandidateSource | None = None,
        hold: HoldProbability | None = None,
        by_check: bool | None = None,
    ) -> None:
        self._gripper = gripper
        if network is not None and network in WITHOUT_NETWORK:
            proposer = WITHOUT_NETWORK[network]()
            by_check = True if by_check is None else by_check
        # Between neighbours, or on the handle of a cup, the hand may fit only where a network
        # proposes nothing.
        self._otherwise: CandidateSource | None = SpreadPoints() if proposer is None else None
        if proposer is None:
            # Not at the top: torch takes a second to import.
            from perception.networks import DEFAULT_NETWORK, Proposer, load_network, shipped_network

            proposer = Proposer(
                load_network(weights) if weights else shipped_network(network or DEFAULT_NETWORK)
            )
        if hold is None and not by_check:
            from perception.networks import shipped_hold

            hold = shipped_hold(gripper)
        self.proposer: CandidateSource = proposer
        self._hold = hold

    def detect(
        self, frame: Frame, workspace: Workspace | None = None, memory: SceneMemory | None = None
    ) -> Detection:
        """Find grasps from straight above: best first, or none and the reason.

        Without a workspace they are sought everywhere above the largest level surface. The frame is
        added to the memory, and what it does not show is taken from there.
        """
        if reason := _unusable(frame):
            return _no_grasp(frame, reason)
        depth = np.asarray(frame.depth, dtype=np.float32)
        support = _support_depth(depth, frame.wTc, workspace)
        if support > FAR:
            depth = smoothed(depth, frame.intrinsics.fx)
        crop = central_crop(depth.shape, frame.intrinsics, support)
        try:
            prepared = prepare(depth, crop, frame.intrinsics, frame.wTc)
        except NoDepthError:
            return _no_grasp(frame, "no depth was measured in the middle of the image")

        around = local_heights(frame, depth, crop, support)
        scene = around.scene
        floor = _level(scene) if workspace is None else workspace.floor
        allowed = _allowed(prepared, frame, workspace, floor)
        occupied = _occupied_area(frame, workspace, floor)
        covered = (float(crop.u0), float(crop.v0), float(crop.size))

        if memory is not None:
            around = replace(around, scene=memory.completed(scene, frame.stamp))
        if not allowed.any():
            reason = "nothing stands out in the workspace"
            if occupied > _LITTLE:
                area = f"{1e4 * occupied:.0f} cm²"
                reason = (
                    f"{area} stand out beside the middle of the image, where none is looked for"
                )
            return _no_grasp(frame, reason, covered, occupied)
        proposals = self.proposer.propose(prepared.network_input, allowed)
        is_meant = isinstance(workspace, ObjectRegion)
        ranking = GraspRanking(frame, prepared, around, workspace, floor, self._gripper, self._hold)
        grasps = ranking.among(proposals)
        # Without a hold estimate, spread points find chords at the rims of objects that are too
        # wide, so then they are tried only on given objects.
        if not grasps and self._otherwise is not None and (is_meant or self._hold is not None):
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
            occupied_area=occupied,
            stamp=frame.stamp,
        )


def _unusable(frame: Frame) -> str:
    """Why a frame is unusable; empty if it is usable."""
    if mistake := frame_problem(frame):
        return mistake
    depth = np.asarray(frame.depth)
    if min(depth.shape) < 16:
        return f"the depth image has {depth.shape} pixels: too few to grasp by"
    if frame.wTc.rotation[2, 2] > _MAX_CAMERA_AXIS_Z:
        return "the camera does not look down"
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
    occupied: float = np.nan,
) -> Detection:
    return Detection(
        grasps=(),
        reason=reason,
        quality=np.zeros((INPUT_SIZE, INPUT_SIZE), dtype=np.float32),
        crop=crop,
        occupied_area=occupied,
        stamp=frame.stamp,
    )


def _support_depth(depth: Image, wTc: SE3, workspace: Workspace | None) -> float:
    """Depth of the support surface along the optical axis [m]."""
    if workspace is not None:
        along_axis = float((workspace.floor - wTc.translation[2]) / wTc.rotation[2, 2])
        if along_axis > 0.0:
            return along_axis
    return float(np.median(depth[valid_depth(depth)]))


def _level(scene: HeightMap) -> float:
    """Height of the largest level surface [m]."""
    bins = np.rint(scene.heights / _LEVEL_BIN).astype(np.int64)
    lowest = int(bins.min())
    counts = np.bincount((bins - lowest).ravel()[:: max(1, bins.size // 20000)])
    level = (int(counts.argmax()) + lowest) * _LEVEL_BIN
    return float(np.median(scene.heights[np.abs(scene.heights - level) < _LEVEL_BIN]))


def _well_inside(workspace: Workspace, points: Array) -> Mask:
    """Which of the (N, 3) points are inside and at least `WALL_MARGIN` from the upright sides."""
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


def _occupied_area(frame: Frame, workspace: Workspace | None, floor: float) -> float:
    """Area from above of all in the image that stands out of the floor [m^2]."""
    depth = np.asarray(frame.depth)[::_AREA_STEP, ::_AREA_STEP]
    row, column = np.nonzero(valid_depth(depth))
    z = depth[row, column].astype(float)
    u, v = (_AREA_STEP * index.astype(float) for index in (column, row))
    points = world_points(z, frame.intrinsics, frame.wTc, u, v)
    high = points[:, 2] >= floor + OCCUPIED_HEIGHT
    if workspace is not None:
        high[high] = _well_inside(workspace, points[high])
    if not high.any():
        return 0.0
    side = _AREA_STEP / frame.intrinsics.fx * float(z[high].max())
    cells = np.unique(np.floor(points[high, :2] / side), axis=0)
    return float(len(cells) * side**2)

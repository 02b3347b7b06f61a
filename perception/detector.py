"""From one depth frame to ranked grasps in the world."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import cv2
import numpy as np
from pinocchio import SE3

from perception.arrays import Array, Image, Mask
from perception.frame import Frame, Workspace
from perception.geometry import Camera, closing_direction, grasp_pose, world_points
from perception.grasp import Detection, GraspEstimate
from perception.height_map import HeightMap, height_map
from perception.maps import SIZE, STRIDE
from perception.preprocess import NoDepthError, Prepared, central_square, measured, prepare
from perception.refine import ALL_DIRECTIONS, refine

if TYPE_CHECKING:
    from perception.propose import Proposals, Proposer

LEAST_HEIGHT = 0.008
"""What stands less than this above the floor is not grasped [m]."""
OCCUPIED_HEIGHT = 0.010
"""What stands less than this above the floor does not occupy it [m]."""
WALL_MARGIN = 0.008
"""How far inside the workspace's sides a grasp or an object has to be [m]."""
_SPARSE = 3  # every so many cells are counted where it is about areas


class GraspDetector:
    """GG-CNN on a depth frame, with its proposals checked against the measured depth.

    Args:
        weights: a file of them, which also tells the network; None takes those that come with the
            package.
        network: which of the shipped networks proposes; None takes the best. Not with `weights`.
        proposer: a network made ready elsewhere, instead of both.

    Raises:
        WeightsError: the weights cannot be used.
    """

    def __init__(
        self,
        weights: Path | None = None,
        network: str | None = None,
        *,
        proposer: Proposer | None = None,
    ) -> None:
        if proposer is None:
            from perception.propose import Proposer  # torch takes a second to import
            from perception.weights import SHIPPED, load_network, shipped_network

            proposer = Proposer(
                load_network(weights) if weights else shipped_network(network or SHIPPED[0])
            )
        self.propose = proposer

    def detect(self, frame: Frame, workspace: Workspace | None = None) -> Detection:
        """Find grasps from straight above.

        Args:
            frame: what the camera saw, and from where.
            workspace: where grasps are wanted; None takes what stands out of the largest level
                surface in sight.

        Returns:
            Grasps, best first, or none and why. A frame that cannot be used is such a reason too.
        """
        if reason := _unusable(frame):
            return _nothing(frame, reason)
        depth = np.asarray(frame.depth, dtype=np.float32)
        square = central_square(
            depth.shape, frame.intrinsics, _support_depth(depth, frame.wTc, workspace)
        )
        try:
            prepared = prepare(depth, square, frame.intrinsics, frame.wTc)
        except NoDepthError:
            return _nothing(frame, "no depth was measured in the middle of the image")

        u = np.arange(square.size, dtype=float)[None, :] + square.u0
        v = np.arange(square.size, dtype=float)[:, None] + square.v0
        scene = height_map(prepared.native, frame.intrinsics, frame.wTc, u, v)
        floor = _level(scene) if workspace is None else workspace.floor
        allowed = _allowed(prepared, frame, workspace, floor)
        occupied = _occupied_area(scene, workspace, floor)
        crop = (float(square.u0), float(square.v0), float(square.size))

        if not allowed.any():
            return _nothing(frame, "nothing stands out in the workspace", crop, occupied)
        proposals = self.propose(prepared.network_input, allowed)
        grasps = _grasps(frame, prepared, scene, proposals, workspace, floor)
        if grasps:
            reason = ""
        elif len(proposals.candidates.quality) == 0:
            reason = "the network sees no grasp in the workspace"
        else:
            reason = "the hand does not fit at any of the grasps that the network proposes"
        return Detection(
            grasps=grasps,
            reason=reason,
            quality=proposals.quality,
            crop=crop,
            occupied_area=occupied,
            stamp=frame.stamp,
        )


def _unusable(frame: Frame) -> str:
    """Why nothing can be made of a frame; empty if something can."""
    depth = np.asarray(frame.depth)
    if depth.ndim != 2 or min(depth.shape, default=0) < 16:
        return f"the depth image has shape {depth.shape}, not (H, W) of 16 pixels or more"
    if not np.issubdtype(depth.dtype, np.number):
        return f"the depth image holds {depth.dtype}, not metres"
    if not np.isfinite(frame.wTc.homogeneous).all():
        return "the camera's pose is not finite"
    if frame.wTc.rotation[2, 2] > -0.5:
        return "the camera does not look down"
    valid = measured(depth)
    count = np.count_nonzero(valid)
    if count < 0.02 * valid.size:
        return "hardly any depth was measured"
    if np.count_nonzero(depth == depth.flat[valid.argmax()]) >= count:
        return "the depth is the same in every pixel"
    return ""


def _nothing(
    frame: Frame,
    reason: str,
    crop: tuple[float, float, float] = (0.0, 0.0, 0.0),
    occupied: float = np.nan,
) -> Detection:
    return Detection(
        grasps=(),
        reason=reason,
        quality=np.zeros((SIZE, SIZE), dtype=np.float32),
        crop=crop,
        occupied_area=occupied,
        stamp=frame.stamp,
    )


def _support_depth(depth: Image, wTc: SE3, workspace: Workspace | None) -> float:
    """Depth of what the objects stand on, where the optical axis meets it [m]."""
    if workspace is not None:
        along_axis = float((workspace.floor - wTc.translation[2]) / wTc.rotation[2, 2])
        if along_axis > 0.0:
            return along_axis
    return float(np.median(depth[measured(depth)]))


def _level(scene: HeightMap) -> float:
    """Height of the largest level surface [m]."""
    bins = np.rint(scene.heights / 0.005).astype(np.int64)
    lowest = int(bins.min())
    counts = np.bincount((bins - lowest).ravel()[:: max(1, bins.size // 20000)])
    level = (int(counts.argmax()) + lowest) * 0.005
    return float(np.median(scene.heights[np.abs(scene.heights - level) < 0.005]))


def _well_inside(workspace: Workspace, points: Array) -> Mask:
    """Which of the (N, 3) points lie inside, and `WALL_MARGIN` from the upright sides too."""
    inside = np.ones(len(points), dtype=np.bool_)
    for dx, dy in ((1, 0), (-1, 0), (0, 1), (0, -1)):
        inside &= workspace.contains(points + WALL_MARGIN * np.array([dx, dy, 0.0]))
    return inside


def _allowed(prepared: Prepared, frame: Frame, workspace: Workspace | None, floor: float) -> Mask:
    """(300, 300) where the network's quality counts."""
    middle = np.arange(STRIDE // 2, SIZE, STRIDE)
    grid = np.stack(np.meshgrid(middle, middle), axis=-1).astype(float)
    pixel = prepared.square.to_image(grid)
    depth = prepared.depth[np.ix_(middle, middle)]
    points = world_points(depth, frame.intrinsics, frame.wTc, pixel[..., 0], pixel[..., 1])
    allowed = points[..., 2] >= floor + LEAST_HEIGHT
    if workspace is not None:
        allowed[allowed] = _well_inside(workspace, points[allowed])
    enlarged = cv2.resize(allowed.astype(np.uint8), (SIZE, SIZE), interpolation=cv2.INTER_NEAREST)
    mask: Mask = enlarged.astype(np.bool_) & ~prepared.missing
    return mask


def _occupied_area(scene: HeightMap, workspace: Workspace | None, floor: float) -> float:
    heights = scene.heights[::_SPARSE, ::_SPARSE]
    row, column = np.nonzero(heights >= floor + OCCUPIED_HEIGHT)
    side = _SPARSE * scene.cell
    if workspace is None:
        return float(len(row) * side**2)
    x, y = scene.origin[0] + column * side, scene.origin[1] + row * side
    points = np.stack([x, y, heights[row, column].astype(float)], axis=1)
    return float(_well_inside(workspace, points).sum() * side**2)


def _grasps(
    frame: Frame,
    prepared: Prepared,
    scene: HeightMap,
    proposals: Proposals,
    workspace: Workspace | None,
    floor: float,
) -> tuple[GraspEstimate, ...]:
    candidates = proposals.candidates
    if len(candidates.quality) == 0:
        return ()
    pixel = prepared.square.to_image(candidates.pixel)
    column, row = np.clip(np.rint(candidates.pixel).astype(np.int64), 0, SIZE - 1).T
    points = world_points(
        prepared.depth[row, column], frame.intrinsics, frame.wTc, pixel[:, 0], pixel[:, 1]
    )
    direction = closing_direction(
        frame.intrinsics, frame.wTc, pixel, candidates.angle, points[:, 2]
    )
    proposed = (points[:, 0], points[:, 1], direction, candidates.quality, floor)
    found = refine(scene, *proposed, directions=proposals.directions)
    if len(found.score) == 0 and proposals.directions < ALL_DIRECTIONS:
        found = refine(scene, *proposed, directions=ALL_DIRECTIONS)
    camera = Camera(intrinsics=frame.intrinsics, wTc=frame.wTc)
    centre = np.stack([found.x, found.y, found.top], axis=1)
    along = 0.005 * np.stack(
        [np.cos(found.direction), np.sin(found.direction), np.zeros(len(found.x))], axis=1
    )
    pixel = camera.project(centre)
    line = camera.project(centre + along) - camera.project(centre - along)
    inside = np.ones(len(centre), dtype=np.bool_)
    if workspace is not None and len(centre):
        inside = workspace.contains(centre)
    return tuple(
        GraspEstimate(
            wTg=grasp_pose(found.x[i], found.y[i], found.z[i], found.direction[i], frame.wTc),
            width=float(found.width[i]),
            opening=float(found.opening[i]),
            quality=float(found.score[i]),
            stamp=frame.stamp,
            pixel=(float(pixel[i, 0]), float(pixel[i, 1])),
            angle=float(np.arctan2(line[i, 1], line[i, 0])),
        )
        for i in np.flatnonzero(inside)
    )

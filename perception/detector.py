"""From one depth frame to ranked grasps in the world."""

from __future__ import annotations

from dataclasses import dataclass
from importlib.resources import as_file, files
from pathlib import Path

import cv2
import numpy as np
from pinocchio import SE3

from perception.arrays import Array, Image, Mask
from perception.frame import Frame, Intrinsics, Workspace
from perception.grasp import Detection, GraspEstimate
from perception.height_map import HeightMap, height_map, world_points
from perception.maps import SIZE
from perception.postprocess import Candidates, find_candidates, grasp_maps
from perception.preprocess import Prepared, central_square, prepare
from perception.refine import refine

LEAST_HEIGHT = 0.008
"""What stands less than this above the floor is not grasped [m]."""
OCCUPIED_HEIGHT = 0.010
"""What stands less than this above the floor does not occupy it [m]."""
WALL_MARGIN = 0.008
"""How far inside the workspace's sides a grasp or an object has to be [m]."""
FARTHEST = 5.0
"""Farther is not believed [m]."""
_STRIDE = 3  # network pixels to a pixel of the mask of where grasps are allowed


class GraspDetector:
    """GG-CNN on a depth frame, with its proposals checked against the measured depth.

    Args:
        weights: of the network; None takes those that come with the package.

    Raises:
        WeightsError: the weights cannot be used.
    """

    def __init__(self, weights: Path | None = None) -> None:
        from perception.network import Inference, load_network  # torch takes a second to import

        if weights is None:
            with as_file(files("perception") / "weights" / "ggcnn.safetensors") as path:
                network = load_network(path)
        else:
            network = load_network(weights)
        self._network = Inference(network)

    def detect(self, frame: Frame, workspace: Workspace | None = None) -> Detection:
        """Find grasps from straight above.

        Args:
            frame: what the camera saw, and from where.
            workspace: where grasps are wanted; None takes what stands out of the largest level
                surface in sight.

        Returns:
            Grasps, best first, or none and why. A frame that cannot be used is such a reason too.
        """
        reason = _unusable(frame)
        if reason:
            return _nothing(frame, reason)
        depth = np.asarray(frame.depth, dtype=np.float32)
        depth = np.where((depth > 0.0) & (depth < FARTHEST), depth, np.float32(np.nan))
        square = central_square(
            depth.shape, frame.intrinsics, _support_depth(depth, frame.wTc, workspace)
        )
        part = depth[square.v0 : square.v0 + square.size, square.u0 : square.u0 + square.size]
        if not np.isfinite(part).any():
            return _nothing(frame, "no depth was measured in the middle of the image")
        prepared = prepare(depth, square)

        u = np.arange(square.size, dtype=float)[None, :] + square.u0
        v = np.arange(square.size, dtype=float)[:, None] + square.v0
        points = world_points(prepared.native, frame.intrinsics, frame.wTc, u, v)
        scene = height_map(points, frame.wTc)
        floor = _level(scene) if workspace is None else workspace.floor
        allowed = _allowed(prepared, frame, workspace, floor)
        occupied = _occupied_area(scene, workspace, floor)
        crop = (float(square.u0), float(square.v0), float(square.size))

        if not allowed.any():
            return _nothing(frame, "nothing stands out in the workspace", crop, occupied)
        maps = grasp_maps(self._network(prepared.network_input), allowed)
        candidates = find_candidates(maps)
        grasps = _grasps(frame, prepared, scene, candidates, workspace, floor)
        if grasps:
            reason = ""
        elif len(candidates.quality) == 0:
            reason = "the network sees no grasp in the workspace"
        else:
            reason = "the hand does not fit at any of the grasps that the network proposes"
        return Detection(
            grasps=grasps,
            reason=reason,
            quality=maps.quality,
            crop=crop,
            occupied_area=occupied,
            stamp=frame.stamp,
        )


def _unusable(frame: Frame) -> str:
    """Why nothing can be made of a frame; empty if something can."""
    depth = np.asarray(frame.depth)
    if depth.ndim != 2 or min(depth.shape, default=0) < 16:
        return f"the depth image has shape {depth.shape}, not (H, W) of at least 16 pixels each"
    if not np.issubdtype(depth.dtype, np.number):
        return f"the depth image holds {depth.dtype}, not metres"
    if not np.isfinite(frame.wTc.homogeneous).all():
        return "the camera's pose is not finite"
    if frame.wTc.rotation[2, 2] > -0.5:
        return "the camera does not look down"
    valid = np.isfinite(depth) & (depth > 0.0) & (depth < FARTHEST)
    if valid.mean() < 0.02:
        return "hardly any depth was measured"
    if np.ptp(depth[valid]) == 0.0:
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
    return float(np.nanmedian(depth))


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
    middle = np.arange(_STRIDE // 2, SIZE, _STRIDE)
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
    row, column = np.nonzero(scene.heights >= floor + OCCUPIED_HEIGHT)
    if workspace is None:
        return float(len(row) * scene.cell**2)
    x = scene.origin[0] + column * scene.cell
    y = scene.origin[1] + row * scene.cell
    points = np.stack([x, y, scene.heights[row, column].astype(float)], axis=1)
    return float(_well_inside(workspace, points).sum() * scene.cell**2)


@dataclass(frozen=True, kw_only=True, eq=False)
class _Camera:
    """A pinhole camera in the world."""

    intrinsics: Intrinsics
    wTc: SE3

    def project(self, points: Array) -> Array:
        """(N, 2) pixels of (N, 3) world points."""
        x, y, z = ((points - self.wTc.translation) @ self.wTc.rotation).T
        camera = self.intrinsics
        return np.stack([camera.fx * x / z + camera.cx, camera.fy * y / z + camera.cy], axis=1)

    def meet(self, pixel: Array, height: Array) -> Array:
        """(N, 3) where the rays of (N, 2) pixels meet the planes at (N,) heights."""
        camera = self.intrinsics
        ray = np.stack(
            [
                (pixel[:, 0] - camera.cx) / camera.fx,
                (pixel[:, 1] - camera.cy) / camera.fy,
                np.ones(len(pixel)),
            ],
            axis=1,
        )
        ray = ray @ self.wTc.rotation.T
        reach = (height - self.wTc.translation[2]) / ray[:, 2]
        return np.asarray(self.wTc.translation + ray * reach[:, None])


def closing_direction(
    intrinsics: Intrinsics, wTc: SE3, pixel: Array, angle: Array, height: Array
) -> Array:
    """Directions in the horizontal plane that directions in the image show.

    Args:
        intrinsics: the camera's pinhole model.
        wTc: camera in the world.
        pixel: (N, 2) full-image (u, v).
        angle: (N,) from u towards v [rad].
        height: (N,) height of the horizontal plane [m].

    Returns:
        (N,) from x towards y of the world [rad].
    """
    camera = _Camera(intrinsics=intrinsics, wTc=wTc)
    step = 4.0 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    line = camera.meet(pixel + step, height) - camera.meet(pixel - step, height)
    return np.arctan2(line[:, 1], line[:, 0])


def grasp_pose(x: float, y: float, z: float, direction: float, wTc: SE3) -> SE3:
    """Grasp from straight above, of the two equal ones that which turns the camera less.

    Args:
        x: centre in the world [m].
        y: [m].
        z: [m].
        direction: closing direction, from x towards y of the world [rad].
        wTc: camera in the world.
    """
    closing = np.array([np.cos(direction), np.sin(direction), 0.0])
    if closing @ wTc.rotation[:, 0] < 0.0:
        closing = -closing
    approach = np.array([0.0, 0.0, -1.0])
    rotation = np.stack([np.cross(closing, approach), closing, approach], axis=1)
    return SE3(rotation, np.array([x, y, z]))


def _grasps(
    frame: Frame,
    prepared: Prepared,
    scene: HeightMap,
    candidates: Candidates,
    workspace: Workspace | None,
    floor: float,
) -> tuple[GraspEstimate, ...]:
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
    found = refine(scene, points[:, 0], points[:, 1], direction, candidates.quality, floor)
    camera = _Camera(intrinsics=frame.intrinsics, wTc=frame.wTc)
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

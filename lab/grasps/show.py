"""`frankie-task grasp show`: grasps in a depth image of any camera.

The table is the plane with the most inliers, found by RANSAC on three pixels at a time (Fischler
and Bolles, "Random sample consensus", 1981) and refitted to its inliers; it gives the pose of the
camera.
"""

from pathlib import Path
from typing import TypeAlias

import cv2
import numpy as np
import numpy.typing as npt
from pinocchio import SE3

from config import counted
from config.arrays import Image
from config.reader import ConfigError
from hw import DepthFrame
from lab.grasps.depth_files import DepthFile
from perception import Detection, GraspDetector, GraspEstimate
from robots import Array, Intrinsics

Picture: TypeAlias = npt.NDArray[np.uint8]  # (H, W, 3) blue, green, red, as in OpenCV

_BEST, _OTHER = (60, 60, 240), (200, 180, 60)
_SHOWN = 5  # number of grasps
_PAD_HALF = 0.010  # half of the drawn length of a finger pad [m]
_STRIDE = 6  # only every sixth row and column is used, for speed [px]
_SAMPLES = 300  # of three points: enough for one free of outliers at 25 % inliers, to 1 %
_INLIER_DISTANCE = 0.006  # of the order of the depth noise at 1 m [m]
_MIN_INLIERS = 0.15  # share of the pixels


class NoTableError(Exception):
    """No table was found; the message says why."""


def show_grasps(name: Path, image: DepthFile, out: Path, detector: GraspDetector) -> str:
    """Draw the grasps of a depth image; the camera's pose is estimated from the table in it.

    `name` is that of the image, for people, and `out` a .png. Returns a summary. Raises
    ConfigError: the image shows no table, or the picture cannot be written.
    """
    depth, camera, assumed = image
    try:
        wTc = camera_above_table(np.where(depth > 0.0, depth, np.float32(np.nan)), camera)
    except NoTableError as error:
        raise ConfigError(f"{name}: {error}; give a depth image of objects on a table") from error
    detection = detector.detect(DepthFrame(depth=depth, intrinsics=camera, oTc=wTc, stamp=0.0))
    summary = f"no grasp: {detection.reason}"
    if detection.grasps:
        best = detection.grasps[0]
        x, y, z = wTc.actInv(best.oTg).translation
        summary = (
            f"{counted(len(detection.grasps), 'grasp')}; the best {1000 * best.width:.0f} mm wide, "
            f"quality {best.quality:.2f}, at x {x:.3f} y {y:.3f} z {z:.3f} m from the camera"
        )
    picture = overlay(depth, camera, detection)
    try:
        written = cv2.imwrite(str(out), picture)
    except cv2.error:
        written = False
    if not written:
        raise ConfigError(f"{out}: cannot be written; give a .png file in an existing folder")
    told = f"assumed: {assumed}; give --focal or --camera\n" if assumed else ""
    return f"{told}{summary}\n{out}"


def depth_picture(depth: Image) -> Picture:
    """A depth image from near (bright) to far (dark); missing depth is blue."""
    known = np.isfinite(depth) & (depth > 0.0)
    low, high = np.percentile(depth[known], (1, 99)) if known.any() else (0.0, 1.0)
    scaled = np.clip((high - np.where(known, depth, high)) / max(high - low, 1e-3), 0.0, 1.0)
    grey = (40.0 + 200.0 * scaled).astype(np.uint8)
    picture = np.repeat(grey[..., None], 3, axis=2)
    picture[~known] = (90, 40, 20)
    return picture


def overlay(depth: Image, intrinsics: Intrinsics, detection: Detection) -> Picture:
    """An (H, W) depth image [m], the quality and the best grasps over it."""
    picture = depth_picture(depth)
    u, v, size = (round(x) for x in detection.crop)
    if size > 0:
        quality = cv2.resize(detection.quality, (size, size), interpolation=cv2.INTER_LINEAR)
        quality = np.clip(quality, 0.0, 1.0)
        colours = cv2.applyColorMap((255 * quality).astype(np.uint8), cv2.COLORMAP_INFERNO)
        part = picture[v : v + size, u : u + size]
        weight = (0.6 * np.sqrt(quality))[: part.shape[0], : part.shape[1], None]
        part[:] = ((1 - weight) * part + weight * colours[: part.shape[0], : part.shape[1]]).astype(
            np.uint8
        )
    for rank, grasp in reversed(list(enumerate(detection.grasps[:_SHOWN]))):
        _draw(picture, grasp, depth, intrinsics, _OTHER if rank else _BEST)
    return picture


def _draw(
    picture: Picture,
    grasp: GraspEstimate,
    depth: Image,
    intrinsics: Intrinsics,
    colour: tuple[int, int, int],
) -> None:
    """A rectangle as wide as the opening; its thick sides are the finger pads."""
    u, v = grasp.pixel
    row, column = np.clip(np.rint((v, u)).astype(int), 0, np.array(depth.shape) - 1)
    distance = depth[row, column]
    if not np.isfinite(distance) or distance <= 0.0:
        distance = float(np.nanmedian(depth))
    along = 0.5 * grasp.opening * intrinsics.fx / distance
    across = _PAD_HALF * intrinsics.fx / distance
    direction = np.array([np.cos(grasp.angle), np.sin(grasp.angle)])
    normal = np.array([-direction[1], direction[0]])
    centre = np.array([u, v])
    corners = [
        tuple(np.rint(centre + a * along * direction + b * across * normal).astype(int).tolist())
        for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))
    ]
    for index, thick in enumerate((1, 3, 1, 3)):
        cv2.line(
            picture, corners[index], corners[(index + 1) % 4], colour, thick, lineType=cv2.LINE_AA
        )


def camera_above_table(depth: Image, intrinsics: Intrinsics) -> SE3:
    """Pose of the camera in a world whose floor, z = 0, is the table.

    Its origin is the point of the table at the middle of the image; x is along u. `depth` is (H, W)
    along the optical axis [m], NaN where missing. Raises NoTableError: no plane has enough inliers,
    or it is not a table.
    """
    height, width = depth.shape
    v, u = (each.ravel() for each in np.mgrid[0:height:_STRIDE, 0:width:_STRIDE])
    ray = np.stack(
        [(u - intrinsics.cx) / intrinsics.fx, (v - intrinsics.cy) / intrinsics.fy, np.ones(len(u))],
        axis=1,
    )
    points = ray * depth[v, u, None].astype(float)
    points = points[np.isfinite(points).all(axis=1)]
    if len(points) < 50:
        raise NoTableError("hardly any depth was measured")
    centre, normal = _plane(points)
    near = np.abs((points - centre) @ normal) < _INLIER_DISTANCE
    if near.mean() < _MIN_INLIERS:
        raise NoTableError(f"only {100 * near.mean():.0f} % of the image lies in one plane")
    up = -normal * np.sign(normal[2])
    if up[2] > -0.25:
        raise NoTableError("the largest plane in sight is a wall, not a table")
    x = np.array([1.0, 0.0, 0.0]) - up[0] * up
    x /= np.linalg.norm(x)
    rotation = np.stack([x, np.cross(up, x), up])  # rows: axes of the world in the camera
    middle = np.array([0.0, 0.0, (centre @ up) / up[2]])
    return SE3(rotation, -rotation @ middle)


def _plane(points: Array) -> tuple[Array, Array]:
    """A point and the unit normal of the plane with the most inliers."""
    rng = np.random.default_rng(0)
    best, kept = -1, points
    for corners in points[rng.integers(len(points), size=(_SAMPLES, 3))]:
        normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
        length = np.linalg.norm(normal)
        if length < 1e-9:
            continue
        near = np.abs((points - corners[0]) @ (normal / length)) < _INLIER_DISTANCE
        if near.sum() > best:
            best, kept = int(near.sum()), points[near]
    for _ in range(2):
        centre = kept.mean(axis=0)
        normal = np.linalg.svd(kept - centre, full_matrices=False)[2][2]
        kept = points[np.abs((points - centre) @ normal) < _INLIER_DISTANCE]
    return centre, normal

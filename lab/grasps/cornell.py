"""The rectangle metric on a folder in the format of the Cornell grasping data set.

A grasp is correct if its rectangle overlaps a positive one by more than a quarter (intersection
over union) and the angle between them is less than 30 degrees (Jiang, Moseson and Saxena,
"Efficient grasping from RGBD images", ICRA 2011). Only depth is used.

This evaluates a network alone, without the feasibility check. The camera of the data set views the
table from the side, at 1.2 m; its pose is estimated from the plane of the table. The image is
levelled with it and cropped such that an input pixel covers `METRES_PER_PIXEL`, the scale of the
training images. The rectangles of the data set are as wide as the opening of the hand, so room for
the fingers is added to the width of the object.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

import cv2
import numpy as np
import numpy.typing as npt

from config import ConfigError
from perception import (
    INPUT_SIZE,
    METRES_PER_PIXEL,
    CandidateSource,
    Crop,
    NoTableError,
    camera_above_table,
    prepare,
)
from robots import Intrinsics

Array: TypeAlias = npt.NDArray[np.float64]

MIN_OVERLAP = 0.25
"""Of a correct grasp, as intersection over union."""
MAX_TURN = np.radians(30.0)
"""Of a correct grasp [rad]."""
CAMERA = Intrinsics(width=640, height=480, fx=570.0, fy=570.0, cx=319.5, cy=239.5)
"""The camera of the data set, approximately."""
ROOM = 0.024
"""Typical distance between an object and the ends of its rectangles in the data set [m]."""

_SHAPE = (CAMERA.height, CAMERA.width)


@dataclass(frozen=True, kw_only=True, eq=False)
class CornellImage:
    """A depth image and its labels."""

    name: str
    depth: npt.NDArray[np.float32]
    """(480, 640) along the optical axis [m]; NaN where missing."""
    rectangles: tuple[Array, ...]
    """(4, 2) corners (u, v) of each positive rectangle; its first edge is along the closing
    direction."""


def read_folder(folder: Path) -> Iterator[CornellImage]:
    """Every image of a folder and its subfolders.

    Raises:
        ConfigError: there is no image, or one cannot be read.
    """
    labels = sorted(folder.rglob("pcd*cpos.txt"))
    if not labels:
        raise ConfigError(
            f"{folder}: no file pcd*cpos.txt; give the folder where the data set was unpacked"
        )
    for path in labels:
        name = path.name.removesuffix("cpos.txt")
        try:
            yield CornellImage(
                name=name, depth=_depth(path.with_name(name)), rectangles=_rectangles(path)
            )
        except (OSError, ValueError) as error:
            raise ConfigError(f"{path}: {name} cannot be read: {error}") from error


def _depth(stem: Path) -> npt.NDArray[np.float32]:
    """Depth from `…d.tiff` [m] if it exists, else from the point cloud `….txt` [mm]."""
    image = stem.with_name(stem.name + "d.tiff")
    depth = np.full(_SHAPE, np.nan, dtype=np.float32)
    if image.is_file():
        read = cv2.imread(str(image), cv2.IMREAD_UNCHANGED)
        if read is None or read.shape != _SHAPE:
            raise ValueError(f"{image.name} is not a depth image of 640 x 480")
        depth[:] = read
    else:
        lines = stem.with_suffix(".txt").read_text(encoding="ascii").splitlines()
        rows = [line.split() for line in lines[lines.index("DATA ascii") + 1 :]]
        x, y, z, index = np.array([[*row[:3], row[4]] for row in rows], dtype=float).T
        depth.ravel()[index.astype(int)] = np.sqrt(x**2 + y**2 + z**2) / 1000.0
    depth[~(depth > 0.0)] = np.nan
    v, u = np.mgrid[0 : CAMERA.height, 0 : CAMERA.width]
    # The files contain distances from the camera, not depths along its axis.
    x, y = (u - CAMERA.cx) / CAMERA.fx, (v - CAMERA.cy) / CAMERA.fy
    return np.asarray(depth / np.sqrt(1.0 + x**2 + y**2), dtype=np.float32)


def _rectangles(path: Path) -> tuple[Array, ...]:
    """Rectangles of a label file, except those with a missing corner."""
    corners = np.array([line.split() for line in path.read_text().split("\n") if line.strip()])
    whole = corners[: len(corners) // 4 * 4].astype(float).reshape(-1, 4, 2)
    return tuple(each for each in whole if np.isfinite(each).all())


def matches(proposer: CandidateSource, image: CornellImage, *, room: float = ROOM) -> bool:
    """Whether a network's best grasp agrees with a positive rectangle.

    Args:
        proposer: the network.
        image: cropped around its labels.
        room: added on either side of the network's width [m]; 0 for a network that was trained on
            rectangles like these.
    """
    try:
        wTc = camera_above_table(image.depth, CAMERA)
    except NoTableError:
        return False
    u, v = np.concatenate(image.rectangles).mean(axis=0)
    distance = float(np.nanmedian(image.depth))
    size = round(INPUT_SIZE * METRES_PER_PIXEL * CAMERA.fx / distance)
    crop = Crop(
        u0=int(np.clip(u - size / 2, 0, CAMERA.width - size)),
        v0=int(np.clip(v - size / 2, 0, CAMERA.height - size)),
        size=size,
    )
    prepared = prepare(image.depth, crop, CAMERA, wTc)
    found = proposer.propose(prepared.network_input, ~prepared.missing).candidates
    if len(found.quality) == 0:
        return False
    u, v = crop.to_image(found.pixel[:1])[0]
    width = (float(found.width[0]) + 2.0 * room / METRES_PER_PIXEL) * crop.scale
    best = rectangle(u, v, float(found.angle[0]), width, width / 2.0)
    return any(agree(best, other) for other in image.rectangles)


def rectangle(u: float, v: float, angle: float, width: float, height: float) -> Array:
    """(4, 2) corners of a grasp with a closing direction at an angle from u towards v [px, rad]."""
    along = 0.5 * width * np.array([np.cos(angle), np.sin(angle)])
    across = 0.5 * height * np.array([-np.sin(angle), np.cos(angle)])
    centre = np.array([u, v])
    ends = (centre - along, centre + along)
    return np.array([ends[0] - across, ends[1] - across, ends[1] + across, ends[0] + across])


def agree(a: Array, b: Array) -> bool:
    """Whether two rectangles agree by the rectangle metric."""
    turn = abs((_angle(a) - _angle(b) + np.pi / 2.0) % np.pi - np.pi / 2.0)
    return bool(turn < MAX_TURN) and overlap(a, b) > MIN_OVERLAP


def _angle(corners: Array) -> float:
    u, v = corners[1] - corners[0]
    return float(np.arctan2(v, u))


def overlap(a: Array, b: Array) -> float:
    """Intersection over union of two convex quadrangles."""
    first, second = (np.asarray(each, dtype=np.float32) for each in (a, b))
    common = float(cv2.intersectConvexConvex(first, second)[0])
    union = float(cv2.contourArea(first) + cv2.contourArea(second)) - common
    return common / union if union > 0.0 else 0.0

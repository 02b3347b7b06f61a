"""`frankie-task grasp show`: grasps in a depth image of any camera."""

from __future__ import annotations

from os.path import isfile
from pathlib import Path
from textwrap import wrap
from typing import Any, TypeAlias

import cv2
import numpy as np
import numpy.typing as npt

from config import ConfigError
from hw import DepthFrame
from lab.grasps.table_plane import NoTableError, camera_above_table
from perception import Detection, GraspDetector, GraspEstimate
from robots import Intrinsics

_D435_FOCAL = 0.6  # focal length of a D435 in image widths
Picture: TypeAlias = npt.NDArray[np.uint8]  # (H, W, 3) blue, green, red, as in OpenCV

_BEST, _OTHER, _TEXT = (60, 60, 240), (200, 180, 60), (255, 255, 255)
_SHOWN = 5  # number of grasps
_LINE, _LETTER = 18, 9  # height of a line and width of a letter of the caption [px]
_PAD_HALF = 0.010  # half of the drawn length of a finger pad [m]


def show_grasps(
    image: Path, out: Path, *, focal: float | None, at: float | None, detector: GraspDetector
) -> str:
    """Draw the grasps of a depth image; the camera's pose is estimated from the table in it.

    Args:
        image: a depth image or an .rrd recording.
        out: the picture to write (.png).
        focal: focal length [px]; None is that of the recording or of a D435.
        at: time in a recording [s]; None is the last image.
        detector: finds the grasps.

    Returns:
        A summary in words.

    Raises:
        ConfigError: the image cannot be read or shows no table, or the picture cannot be written.
    """
    if image.suffix == ".rrd":
        from app.review import recorded_depth

        depth, recorded = recorded_depth(image, at)
    else:
        depth, recorded = read_depth(image), None
    height, width = depth.shape
    focal = focal or recorded or _D435_FOCAL * width
    camera = Intrinsics(
        width=width, height=height, fx=focal, fy=focal, cx=(width - 1) / 2, cy=(height - 1) / 2
    )
    try:
        wTc = camera_above_table(np.where(depth > 0.0, depth, np.float32(np.nan)), camera)
    except NoTableError as error:
        raise ConfigError(f"{image}: {error}; give a depth image of objects on a table") from error
    detection = detector.detect(DepthFrame(depth=depth, intrinsics=camera, wTc=wTc, stamp=0.0))
    summary = f"no grasp: {detection.reason}"
    if detection.grasps:
        best = detection.grasps[0]
        x, y, z = wTc.actInv(best.wTg).translation
        summary = (
            f"{len(detection.grasps)} grasps; the best: {1000 * best.width:.0f} mm wide, quality "
            f"{best.quality:.2f}, at x {x:.3f} y {y:.3f} z {z:.3f} m from the camera"
        )
    picture = overlay(depth, camera, detection, summary)
    try:
        written = cv2.imwrite(str(out), picture)
    except cv2.error:
        written = False
    if not written:
        raise ConfigError(f"{out}: cannot be written; give a .png file in an existing folder")
    return f"{summary}\n{out}"


def read_depth(path: Path) -> npt.NDArray[np.float32]:
    """Read a depth image [m]; integers are millimetres.

    Raises:
        ConfigError: the file is missing or not a depth image.
    """
    if not isfile(path):
        raise ConfigError(f"{path}: no such file; give a depth image as .npy, .png or .tiff")
    try:
        if path.suffix == ".npy":
            values = np.load(path, allow_pickle=False)
        else:
            values = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    except Exception as error:  # of a parser of files that anybody may have made
        what = " ".join(f"{type(error).__name__}: {error}".split())[:200]
        raise ConfigError(f"{path}: cannot be read ({what}); give another image") from error
    is_array = isinstance(values, np.ndarray)
    if not is_array or values.ndim != 2 or not _is_depth(values.dtype):
        content = f"{values.dtype} of shape {values.shape}" if is_array else "no image"
        raise ConfigError(
            f"{path}: contains {content}, not a depth image; give an (H, W) array of 16-bit "
            "millimetres or of metres as floats"
        )
    metres = 1e-3 if np.issubdtype(values.dtype, np.integer) else 1.0
    with np.errstate(over="ignore"):  # what is too far for a float is missing
        return np.asarray(values * metres, dtype=np.float32)


def _is_depth(dtype: np.dtype[Any]) -> bool:
    """Whether numbers of a type can be depths: real, and of more than 8 bits."""
    return dtype.kind in "fiu" and dtype.itemsize > 1


def depth_picture(depth: npt.NDArray[np.float32]) -> Picture:
    """A depth image from near (bright) to far (dark); missing depth is blue."""
    known = np.isfinite(depth) & (depth > 0.0)
    low, high = np.percentile(depth[known], (1, 99)) if known.any() else (0.0, 1.0)
    scaled = np.clip((high - np.where(known, depth, high)) / max(high - low, 1e-3), 0.0, 1.0)
    grey = (40.0 + 200.0 * scaled).astype(np.uint8)
    picture = np.repeat(grey[..., None], 3, axis=2)
    picture[~known] = (90, 40, 20)
    return picture


def overlay(
    depth: npt.NDArray[np.float32], intrinsics: Intrinsics, detection: Detection, caption: str
) -> Picture:
    """An (H, W) depth image [m], the quality and best grasps over it, and a caption below."""
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
    lines = wrap(caption, picture.shape[1] // _LETTER)
    below = np.zeros((_LINE * len(lines) + 8, picture.shape[1], 3), dtype=np.uint8)
    for number, line in enumerate(lines, 1):
        font = cv2.FONT_HERSHEY_SIMPLEX
        cv2.putText(below, line, (6, _LINE * number), font, 0.45, _TEXT, 1, cv2.LINE_AA)
    return np.vstack([picture, below])


def _draw(
    picture: Picture,
    grasp: GraspEstimate,
    depth: npt.NDArray[np.float32],
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

"""`frankie-task grasp show`: grasps in a depth image of any camera."""

from __future__ import annotations

from os.path import isfile
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from config import ConfigError
from hw import DepthFrame
from lab.grasps.picture import overlay
from perception import GraspDetector, NoTableError, camera_above_table
from robots import Intrinsics

_D435_FOCAL = 0.6  # focal length of a D435 in image widths


def show_grasps(
    image: Path, out: Path, *, focal: float | None, at: float | None, detector: GraspDetector
) -> str:
    """Draw the grasps of a depth image; the camera's pose is estimated from the table in it.

    Args:
        image: a depth image or an .rrd recording.
        out: the picture to write (.png).
        focal: focal length of the camera [px]; None is that of a D435.
        at: time in a recording [s]; None is the last image.
        detector: finds the grasps.

    Returns:
        A summary in words.

    Raises:
        ConfigError: the image cannot be read or shows no table, or the picture cannot be written.
    """
    recorded = None
    if image.suffix == ".rrd":
        depth, recorded = _recorded(image, at)
    else:
        depth = read_depth(image)
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


def _recorded(path: Path, at: float | None) -> tuple[npt.NDArray[np.float32], float | None]:
    """Depth [m] from a recording, and the camera's focal length [px] if it was recorded."""
    from app.review import recorded_depth

    return recorded_depth(path, at)


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

"""`frankie-task grasp show`: grasps in a depth image of anybody's camera."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import numpy.typing as npt

from app.lab.grasps.picture import overlay
from config import ConfigError
from hw import DepthFrame, Intrinsics
from perception import GraspDetector
from perception.table_plane import NoTableError, camera_above_table

_D435_FOCAL = 0.6  # of a D435's depth image, in image widths


def show_grasps(
    image: Path, out: Path, *, focal: float | None, at: float | None, detector: GraspDetector
) -> str:
    """Draw the grasps of a depth image; the table in it tells where the camera is.

    Args:
        image: the file; an .rrd recording will do, too.
        out: where the picture goes (.png).
        focal: of the camera [px]; None for that of a D435.
        at: time in a recording [s]; None takes the last image.
        detector: finds them.

    Returns:
        What was found, for people.

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
        raise ConfigError(
            f"{image}: {error}; show a depth image of things that lie on a table"
        ) from error
    detection = detector.detect(DepthFrame(depth=depth, intrinsics=camera, wTc=wTc, stamp=0.0))
    said = f"no grasp: {detection.reason}"
    if detection.grasps:
        best = detection.grasps[0]
        x, y, z = wTc.actInv(best.wTg).translation
        said = (
            f"{len(detection.grasps)} grasps; the best: {1000 * best.width:.0f} mm wide, quality "
            f"{best.quality:.2f}, at x {x:.3f} y {y:.3f} z {z:.3f} m from the camera"
        )
    picture = overlay(depth, camera, detection, said)
    try:
        written = cv2.imwrite(str(out), picture)
    except cv2.error:
        written = False
    if not written:
        raise ConfigError(f"{out}: cannot be written; name a .png file in a folder that exists")
    return f"{said}\n{out}"


def _recorded(path: Path, at: float | None) -> tuple[npt.NDArray[np.float32], float | None]:
    """Depth [m] out of a recording, and its camera's focal length if that was recorded."""
    from app.live.monitor.recorded_depth import NoDepthError, recorded_depth

    try:
        return recorded_depth(path, at)
    except NoDepthError as error:
        raise ConfigError(f"{path}: {error}; give a recording with depth in it") from error


def read_depth(path: Path) -> npt.NDArray[np.float32]:
    """A depth image [m] from a file; whole numbers are millimetres.

    Raises:
        ConfigError: there is no such file, or it is not a depth image.
    """
    if not path.is_file():
        raise ConfigError(f"{path}: no such file; give a depth image as .npy, .png or .tiff")
    try:
        if path.suffix == ".npy":
            values = np.load(path, allow_pickle=False)
        else:
            values = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    except (OSError, ValueError, cv2.error) as error:
        raise ConfigError(f"{path}: cannot be read: {error}") from error
    if values is None or values.ndim != 2 or values.dtype == np.uint8:
        shape = "nothing readable" if values is None else f"{values.dtype} of shape {values.shape}"
        raise ConfigError(
            f"{path}: holds {shape}, not a depth image; give (H, W) of 16-bit millimetres or of "
            "floating metres"
        )
    metres = 1e-3 if np.issubdtype(values.dtype, np.integer) else 1.0
    return np.asarray(values * metres, dtype=np.float32)

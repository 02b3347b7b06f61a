"""Depth images and point clouds of other cameras, in image files, clouds, recordings and bags."""

from __future__ import annotations

from collections.abc import Callable
from os.path import isfile
from pathlib import Path
from typing import Any, NamedTuple

import cv2
import numpy as np
import yaml

from config import counted, extra
from config.arrays import Image
from config.reader import ConfigError
from extensions.ros2.sensing import depth_of
from robots import Array, Intrinsics

_D435_FOCAL = 0.6  # focal length of a D435 in image widths
_USUAL = (0.1, 5.0)  # median depth of a picture of a table [m]
_FORMATS = (
    "give a depth image (.png, .tiff, .npy), a point cloud (.ply, .pcd), a recording (.rrd) or a "
    "ROS bag (.mcap, .db3, .bag)"
)
_BAGS = (".mcap", ".db3", ".bag")
_NUMPY_TYPES = {"F": "f", "I": "i", "U": "u"}  # of the types of a PCD file


class DepthFile(NamedTuple):
    """What a file shows."""

    depth: Image  # (H, W) along the optical axis; 0 or NaN where missing [m]
    intrinsics: Intrinsics
    assumed: str  # what the file did not say, for people; empty if nothing


def load_depth_file(
    path: Path,
    *,
    scale: float | None = None,
    focal: float | None = None,
    camera: Path | None = None,
    at: float | None = None,
) -> DepthFile:
    """Load a depth image, or the one that a point cloud gives.

    Args:
        path: of the file.
        scale: metres per unit; None is 0.001 for whole numbers and 1 for others.
        focal: focal length [px], unless `camera` tells it; None is that of the recording or a D435.
        camera: file of a ROS `CameraInfo` or of fx, fy, cx, cy [px].
        at: time in a recording or bag [s]; None is the last image.

    Raises:
        ConfigError: the file or that of the camera cannot be read or has no depth, or the depth is
            not that of a table in metres.
    """
    if not isfile(path):
        raise ConfigError(f"{path}: no such file; {_FORMATS}")
    k: Any = None  # the camera matrix, row by row
    if path.suffix == ".rrd":
        from app.review import recorded_depth

        values, recorded = recorded_depth(path, at)
        focal = focal or recorded
    elif path.suffix in _BAGS:
        values, k = _parsed(path, lambda bag: _bag(bag, at))
    elif path.suffix in _CLOUDS:
        points = _parsed(path, _CLOUDS[path.suffix]) * (scale or 1.0)
        _check_scale(path, np.abs(points[:, 2]))
        return DepthFile(*_projected(path, points), "")
    else:
        values = _parsed(path, _IMAGES.get(path.suffix, _image))
    depth = _metres(path, values, scale)
    _check_scale(path, depth)
    if camera is not None:
        return DepthFile(depth, _camera_info(camera, depth.shape), "")
    if k is not None and focal is None:
        return DepthFile(depth, _intrinsics(depth.shape, k[0], k[4], k[2], k[5]), "")
    assumed = "" if focal else f"the focal length of a D435, {_D435_FOCAL * depth.shape[1]:.0f} px"
    return DepthFile(depth, _pinhole(depth.shape, focal or _D435_FOCAL * depth.shape[1]), assumed)


def _pinhole(shape: tuple[int, ...], focal: float) -> Intrinsics:
    return _intrinsics(shape, focal, focal, (shape[1] - 1) / 2, (shape[0] - 1) / 2)


def _intrinsics(shape: tuple[int, ...], fx: float, fy: float, cx: float, cy: float) -> Intrinsics:
    return Intrinsics(width=shape[1], height=shape[0], fx=fx, fy=fy, cx=cx, cy=cy)


def _parsed(path: Path, read: Callable[[Path], Any]) -> Any:
    """What a reader makes of a file; ConfigError for whatever goes wrong in it."""
    try:
        return read(path)
    except ConfigError:
        raise
    except Exception as error:  # of a parser of files that anybody may have made
        what = " ".join(f"{type(error).__name__}: {error}".split())[:200]
        raise ConfigError(f"{path}: cannot be read ({what}); {_FORMATS}") from error


def _metres(path: Path, values: Any, scale: float | None) -> Image:
    is_array = isinstance(values, np.ndarray)
    if not is_array or values.ndim != 2 or not _is_depth(values.dtype):
        content = f"{values.dtype} of shape {values.shape}" if is_array else "no image"
        raise ConfigError(f"{path}: contains {content}, not a depth image; {_FORMATS}")
    scale = scale or (1e-3 if np.issubdtype(values.dtype, np.integer) else 1.0)
    with np.errstate(over="ignore"):  # what is too far for a float is missing
        return np.asarray(values * scale, dtype=np.float32)


def _check_scale(path: Path, depth: Array | Image) -> None:
    known = depth[np.isfinite(depth) & (depth > 0.0)]
    median = float(np.median(known)) if known.size else 1.0
    if not _USUAL[0] <= median <= _USUAL[1]:
        raise ConfigError(
            f"{path}: the median depth is {median:.3g} m; --scale says how many metres a unit is "
            "(0.001 for millimetres, 0.0002 for PNG files of TUM)"
        )


def _is_depth(dtype: np.dtype[Any]) -> bool:
    """Whether numbers of a type can be depths: real, and of more than 8 bits."""
    return dtype.kind in "fiu" and dtype.itemsize > 1


def _image(path: Path) -> Any:
    return cv2.imread(str(path), cv2.IMREAD_UNCHANGED)


def _numpy(path: Path) -> Any:
    return np.load(path, allow_pickle=False)


def _ply(path: Path) -> Array:
    import trimesh

    cloud: Any = trimesh.load(path)
    return np.array(cloud.vertices, dtype=np.float64)


def _pcd(path: Path) -> Array:
    """The points of a PCD file, text or binary (https://pointclouds.org, PCD version 0.7)."""
    head, _, body = path.read_bytes().partition(b"\nDATA ")
    fields = {}
    for line in head.decode("ascii").splitlines():
        key, *words = line.split()
        fields[key] = words
    form, _, data = body.partition(b"\n")
    names = fields["FIELDS"]
    counts = [int(number) for number in fields.get("COUNT", ["1"] * len(names))]
    if form.strip() == b"ascii":
        at = np.concatenate([[0], np.cumsum(counts)])
        table = np.array([line.split() for line in data.decode("ascii").splitlines()], dtype=float)
        return table[:, [int(at[names.index(axis)]) for axis in "xyz"]]
    if form.strip() != b"binary":
        kind = form.decode("ascii", "replace").strip()
        raise ConfigError(f"{path}: its points are `{kind}`; convert it to binary or text")
    sizes, types = fields["SIZE"], fields["TYPE"]
    row = np.dtype(
        [
            (f"{name} {k}", f"<{_NUMPY_TYPES[types[k]]}{sizes[k]}", counts[k])
            for k, name in enumerate(names)
        ]
    )
    rows = np.frombuffer(data, row, count=int(fields["POINTS"][0]))
    columns = [rows[f"{axis} {names.index(axis)}"].reshape(-1) for axis in "xyz"]
    return np.stack(columns, axis=1).astype(float)


def _bag(path: Path, at: float | None) -> tuple[Any, Any]:
    """The depth image nearest to a time in a ROS bag, or the last, and its camera matrix."""
    try:
        from rosbags.highlevel import AnyReader
    except ModuleNotFoundError:
        raise ConfigError(f"{path}: reading bags needs {extra('foxglove')}") from None
    is_depth: dict[str, bool] = {}
    best, found, image = np.inf, "", None
    with AnyReader([path]) as bag:
        for one, time, raw in bag.messages():
            if one.msgtype not in ("sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage"):
                continue
            if one.topic not in is_depth:
                is_depth[one.topic] = depth_of(bag.deserialize(raw, one.msgtype)) is not None
            away = -time if at is None else abs(time - bag.start_time - 1e9 * at)
            if is_depth[one.topic] and away < best:
                best, found, image = away, one.topic, (raw, one.msgtype)
        if image is None:
            raise ConfigError(f"{path}: the bag has no depth images; {_FORMATS}")
        depth = depth_of(bag.deserialize(*image))
        for one, _, raw in bag.messages():
            near = found.startswith(one.topic.rpartition("/")[0])
            if one.msgtype == "sensor_msgs/msg/CameraInfo" and near:
                info: Any = bag.deserialize(raw, one.msgtype)
                return depth, info.k if hasattr(info, "k") else info.K
    return depth, None


_IMAGES: dict[str, Callable[[Path], Any]] = {".npy": _numpy}
_CLOUDS: dict[str, Callable[[Path], Array]] = {".ply": _ply, ".pcd": _pcd}


def _projected(path: Path, points: Array) -> tuple[Image, Intrinsics]:
    """The depth image of a cloud of (N, 3) points, with about one point a pixel.

    The cloud is in the optical frame of its camera: x right, y down, z forward, or y up and z back,
    as viewers of RealSense and OpenGL write it.
    """
    points = points[np.isfinite(points).all(axis=1) & (points[:, 2] != 0.0)]
    if len(points) < 100:
        raise ConfigError(f"{path}: contains {counted(len(points), 'point')}; {_FORMATS}")
    if np.median(points[:, 2]) < 0.0:
        points = points * np.array([1.0, -1.0, -1.0])
    points = points[points[:, 2] > 0.0]
    x, y = (points[:, :2] / points[:, 2:]).T
    wide, high = 2.0 * np.percentile(np.abs(x), 99.0), 2.0 * np.percentile(np.abs(y), 99.0)
    focal = float(np.sqrt(len(points) / max(wide * high, 1e-6)))
    intrinsics = _pinhole((max(round(focal * high), 1), max(round(focal * wide), 1)), focal)
    u, v = (np.rint(a * focal + c).astype(int) for a, c in ((x, intrinsics.cx), (y, intrinsics.cy)))
    inside = (u >= 0) & (u < intrinsics.width) & (v >= 0) & (v < intrinsics.height)
    depth = np.full((intrinsics.height, intrinsics.width), np.inf, dtype=np.float32)
    np.minimum.at(depth, (v[inside], u[inside]), points[inside, 2].astype(np.float32))
    return np.where(np.isinf(depth), np.float32(np.nan), depth), intrinsics


def _camera_info(path: Path, shape: tuple[int, ...]) -> Intrinsics:
    """The pinhole model in a file, of an (H, W) image."""
    try:
        content = yaml.safe_load(path.read_text(encoding="utf-8"))
        k = content.get("k") or content.get("K") or content.get("camera_matrix", {}).get("data")
        given = (
            (k[0], k[4], k[2], k[5]) if k else [content[one] for one in ("fx", "fy", "cx", "cy")]
        )
        fx, fy, cx, cy = (float(one) for one in given)
        size = content.get("height") or content.get("image_height") or shape[0]
    except Exception as error:
        hint = "give a ROS CameraInfo as YAML, or fx, fy, cx and cy"
        raise ConfigError(f"{path}: not the model of a camera ({error}); {hint}") from error
    if size != shape[0] or min(fx, fy) <= 0.0:
        raise ConfigError(f"{path}: is of {size} rows and the depth image has {shape[0]}")
    return _intrinsics(shape, fx, fy, cx, cy)

"""What messages of ROS 2 tell, checked: a function for each type, which raises `RefusedError`."""

from collections.abc import Collection, Sequence
from math import atan2, hypot, pi
from typing import Any, NamedTuple

import numpy as np
from pinocchio import SE3

from config.planar import in_space
from hw import Array, RefusedError, covariance, number, numbers

_LENGTH = 0.01  # a unit quaternion has its length with this tolerance, as in tf2
_UPRIGHT = 0.9  # cosine of the largest tilt of a base
_TURN = 2.0 * pi + 0.1  # no scan goes farther around [rad]
_OFF_END = 2.5  # increments by which drivers differ about the last angle of a scan


class Lens(NamedTuple):
    """What a CameraInfo tells."""

    K: Array
    """(3, 3) the intrinsic matrix [pixels]."""
    width: int
    height: int

    def is_like(self, other: "Lens") -> bool:
        """Whether it is the same."""
        sizes = (self.width, self.height) == (other.width, other.height)
        return sizes and np.array_equal(self.K, other.K)


class ElsewhereError(RefusedError):
    """It tells of something else, which others on the topic may do rightly."""


def stamp_of(header: Any) -> float | None:
    """The stamp of a header [s]; None of one that was never filled in."""
    seconds, nanoseconds = header.stamp.sec, header.stamp.nanosec
    if seconds < 0 or not 0 <= nanoseconds < 1e9:
        raise RefusedError("header.stamp", f"{seconds} s {nanoseconds} ns", "no time")
    return (seconds + 1e-9 * nanoseconds) or None


def joints(message: Any, names: Sequence[str]) -> tuple[Array, Array | None]:
    """Positions and velocities (n,) of joints by a JointState; None: it does not tell the latter.

    NaN is what joint_state_broadcaster has for a velocity that nobody measures.
    """
    places = {name: k for k, name in enumerate(message.name)}
    if lacking := [name for name in names if name not in places]:
        raise ElsewhereError("name", _list(message.name), f"it does not tell {_list(lacking)}")
    for field in ("position", "velocity"):
        size = len(getattr(message, field))
        if size != len(message.name) and (size or field == "position"):
            raise RefusedError(field, f"{size} values", f"for {len(message.name)} names")
    rows = [places[name] for name in names]
    q = numbers(message.position[rows], names, "position")
    if not len(message.velocity) or np.isnan(qd := message.velocity[rows]).any():
        return q, None
    return q, numbers(qd, names, "velocity")


def odometry(message: Any, frame: str = "") -> tuple[SE3, Array]:
    """The pose oTb and the twist (3,) of an Odometry, in a frame of this name if there is one."""
    if frame:
        _named(message.header.frame_id, frame, "header.frame_id")
    twist, pose = message.twist.twist, message.pose.pose
    told = (twist.linear.x, twist.linear.y, twist.angular.z)
    moving = numbers(told, ("linear.x", "linear.y", "angular.z"), "twist.twist")
    return _pose(pose.position, pose.orientation, "pose.pose"), moving


def placed(message: Any, frame: str) -> tuple[SE3, Array]:
    """The pose mTb and its covariance (3, 3) of a PoseWithCovarianceStamped in this frame."""
    _named(message.header.frame_id, frame, "header.frame_id")
    pose, rows = message.pose.pose, np.ix_((0, 1, 5), (0, 1, 5))
    told = covariance(np.reshape(message.pose.covariance, (6, 6))[rows], "pose.covariance")
    return _pose(pose.position, pose.orientation, "pose.pose"), told


def transform(message: Any, parent: str, child: str) -> SE3:
    """The transform from one frame to another in a TFMessage."""
    seen: list[str] = []
    for one in message.transforms:
        frames = one.header.frame_id.lstrip("/"), one.child_frame_id.lstrip("/")
        if frames == (parent, child):
            moved = one.transform
            return _pose(moved.translation, moved.rotation, f"{parent} -> {child}")
        seen.append(" -> ".join(frames))
    raise ElsewhereError("transforms", _list(seen), f"{parent} -> {child} is not among them")


def scan(message: Any) -> tuple[Array, Array]:
    """Angles [rad] and ranges (n,) [m] of a LaserScan, inf where nothing is in reach.

    NaN where a beam tells nothing (REP 117): it is shorter or longer than the laser can measure.
    """
    count = len(message.ranges)
    low, high, step = (
        number(getattr(message, field), field, -_TURN, _TURN)
        for field in ("angle_min", "angle_max", "angle_increment")
    )
    if step == 0.0 or abs(step) * (count - 1) > _TURN:
        raise RefusedError("angle_increment", f"{step:g}", f"impossible with {count} ranges")
    if abs(low + step * (count - 1) - high) > _OFF_END * abs(step):
        raise RefusedError("ranges", f"{count} values", f"not those from {low:g} to {high:g} rad")
    nearest = number(message.range_min, "range_min", 0.0)
    farthest = number(message.range_max, "range_max", nearest)
    ranges: Array = np.array(message.ranges, dtype=np.float64)
    tells = (ranges > 0.0) & (ranges >= nearest) & ((ranges <= farthest) | np.isinf(ranges))
    ranges[~tells] = np.nan
    angles: Array = low + step * np.arange(count, dtype=np.float64)
    return angles, ranges


def lens(message: Any) -> Lens:
    """A CameraInfo of a camera that was calibrated."""
    width, height = message.width, message.height
    K = np.array(message.k, dtype=float).reshape(3, 3)
    for index, least, most in ((0, 1.0, 1e5), (4, 1.0, 1e5), (2, 0.0, width), (5, 0.0, height)):
        number(K.flat[index], f"k[{index}]", least, most)
    return Lens(K, width, height)


def sized(width: int, height: int, of: Lens) -> None:
    """Refuse an image whose size is not that of its intrinsics."""
    if (width, height) != (of.width, of.height):
        why = f"its camera_info says {of.width} x {of.height}"
        raise RefusedError("width x height", f"{width} x {height}", why)


def _pose(position: Any, quaternion: Any, field: str) -> SE3:
    """On the floor."""
    x, y = numbers((position.x, position.y), ("x", "y"), f"{field}.position").tolist()
    yaw = _heading(quaternion, f"{field}.orientation")
    return in_space((x, y, yaw))


def _named(told: str, expected: str, field: str) -> None:
    if told.lstrip("/") != expected.lstrip("/"):
        raise RefusedError(field, f"`{told}`", f"not `{expected}`")


def _list(names: Collection[str]) -> str:
    return ", ".join(names) or "none"


def _heading(quaternion: Any, field: str) -> float:
    """The heading of an upright base [rad], by a unit quaternion with x, y, z and w."""
    x, y, z, w = (quaternion.x, quaternion.y, quaternion.z, quaternion.w)
    shown = f"({x:g}, {y:g}, {z:g}, {w:g})"
    if not abs(hypot(x, y, z, w) - 1.0) < _LENGTH:  # NaN is none either
        raise RefusedError(field, shown, "no unit quaternion")
    if 1.0 - 2.0 * (x * x + y * y) < _UPRIGHT:
        raise RefusedError(field, shown, "the base would not stand upright")
    return atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))

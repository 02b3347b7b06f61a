"""What is true of a robot: kinematics, limits, lag, hand, camera, shapes; all of it once.

Simulator, controller, perception, viewer and judges read it here. Frames: b is the base on the
floor below its turning axis, a the arm's foot, h the hand's flange, e the end effector, which is
the grasp centre between the finger tips (z along the approach, y the closing direction), c the
camera (z along the optical axis, x right, y down).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from pinocchio import SE3

from robots.shapes import Geom

Array = npt.NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class Limits:
    """What the robot may do, as every command is held against it."""

    q_min: Array
    """(7,) lower joint positions [rad]."""
    q_max: Array
    """(7,) upper joint positions [rad]."""
    qd: Array
    """(7,) joint speeds [rad/s]."""
    qdd: Array
    """(7,) joint accelerations [rad/s^2]."""
    base_twist: Array
    """(3,) base speeds along x, y and about z [m/s, m/s, rad/s]."""
    base_reverse: float
    """Base speed along -x [m/s]."""
    base_acceleration: Array
    """(3,) base accelerations along x, y and about z [m/s^2, m/s^2, rad/s^2]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ArmDescription:
    """A serial arm of seven joints, each turning about its own z."""

    joints: tuple[SE3, ...]
    """Placement of each joint on the one before, the first on the foot."""
    flange: SE3
    """lTh: the hand's flange on the last link."""
    ready: Array
    """(7,) posture that tasks call `ready` [rad]: the hand in front, pointing down."""
    lag: float
    """Time constant with which the joints follow velocity commands [s]."""
    collision: tuple[tuple[Geom, ...], ...]
    """Capsules of foot and seven links, each in its own frame: 8 tuples."""
    reach: Array
    """(7,) how far a point of the arm or hand is at most from each joint's axis [m]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class BaseDescription:
    """A mobile base."""

    axes: Array
    """(3, n_base) how the degrees of freedom make up the base twist (Haviland 2022, eq. 4)."""
    size: tuple[float, float, float]
    """Footprint along x and y, and height of the deck [m]."""
    lag: float
    """Time constant with which it follows velocity commands [s]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class GripperDescription:
    """A parallel gripper, fingers closing along y of e."""

    hTe: SE3
    """End effector on the flange."""
    opening: float
    """Distance between the pads when fully open [m]."""
    speed: float
    """Change of the opening when the fingers move [m/s]."""
    tip: float
    """How far the pads reach beyond the grasp centre along the approach [m]."""
    palm: Geom
    """In e."""
    finger: Geom
    """One finger in e, its pose at the left (+y) and closed."""
    pad: Geom
    """One pad in e, its pose at the left (+y) and closed."""
    collision: tuple[Geom, ...]
    """Capsules of hand and fingers at any opening, in h."""


@dataclass(frozen=True, kw_only=True)
class Intrinsics:
    """Pinhole camera: pixel (u, v) of a point (x, y, z) is (fx x/z + cx, fy y/z + cy)."""

    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float


@dataclass(frozen=True, kw_only=True, eq=False)
class CameraDescription:
    """A depth camera on the wrist."""

    eTc: SE3
    """Camera on the end effector."""
    intrinsics: Intrinsics
    rate: float
    """Frames a second [Hz]."""
    body: Geom
    """Its housing, in h."""


@dataclass(frozen=True, kw_only=True, eq=False)
class RobotDescription:
    """One mobile manipulator."""

    name: str
    base: BaseDescription
    bTa: SE3
    """Arm's foot on the base."""
    arm: ArmDescription
    gripper: GripperDescription
    camera: CameraDescription
    limits: Limits
    may_touch: tuple[tuple[str, str], ...]
    """Pairs of parts (`base`, `floor`, `link0` ... `link7`, `hand`) that can meet within the
    joints' ranges; the second of a pair is moved by more joints."""

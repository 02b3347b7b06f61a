"""Robot descriptions: kinematics, limits, lag, hand, camera and shapes, shared by all modules.

Frames: b is the base on the floor below its turning axis, s the laser on it, a the foot of the arm,
l its last link, h the flange of the hand, e the end effector, c the camera. The end effector is the
grasp centre between the finger tips, z along the approach and y the closing direction. The camera
looks along z, x right and y down.

An arm has j joints: where they are said in rad, those of a sliding joint are in m.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from pinocchio import SE3, Inertia

from config.arrays import Mask
from robots.shapes import Array, Geom

_UPRIGHT = 0.99  # cosine of the largest tilt of an upright axis
_STILL = 1e-3  # a base without this speed stands still [m/s, rad/s]


@dataclass(frozen=True, kw_only=True, eq=False)
class Limits:
    """Limits of the robot, enforced by controller and gate."""

    q_min: Array  # (j,) lower joint positions, infinite for a continuous joint [rad]
    q_max: Array  # (j,) upper joint positions [rad]
    qd: Array  # (j,) joint speeds [rad/s]
    qdd: Array  # (j,) joint accelerations [rad/s^2]
    base_twist: Array  # (3,) base speeds along x, y and about z [m/s, m/s, rad/s]
    base_reverse: float  # base speed along -x [m/s]
    base_acceleration: Array  # (3,) accelerations along x, y and about z [m/s^2, m/s^2, rad/s^2]
    base_emergency: Array  # (3,) base decelerations of an emergency stop [m/s^2, m/s^2, rad/s^2]

    def base_speed(self, twist: Array) -> Array:
        """(3,) largest base speeds in the directions of a twist (3,) [m/s, m/s, rad/s]."""
        return self._base_backwards if twist[0] < 0.0 else self.base_twist

    @cached_property
    def _base_backwards(self) -> Array:
        return np.array([self.base_reverse, *self.base_twist[1:]])

    @property
    def within_a_turn(self) -> tuple[Array, Array]:
        """(j,) lower and upper positions between which every posture is met once [rad]."""
        wide = self.q_max - self.q_min > 2.0 * np.pi
        return np.where(wide, -np.pi, self.q_min), np.where(wide, np.pi, self.q_max)

    def margins(self, most: float, share: float) -> Array:
        """(j,) margins to the joint limits [rad]: `most`, or a share of a short range."""
        return np.minimum(most, share * (self.q_max - self.q_min))


@dataclass(frozen=True, kw_only=True, eq=False)
class ArmDescription:
    """A serial arm of j joints, each turning about its own z or sliding along it."""

    joints: tuple[SE3, ...]  # pose of each at zero on the one before, or the foot
    slides: Mask  # (j,) which of them slide
    lTh: SE3  # flange of the hand on the last link
    ready: Array  # (j,) posture named `ready` in tasks [rad]: the hand in front, pointing down
    lag: float  # time constant with which the joints follow velocity commands [s]
    collision: tuple[tuple[Geom, ...], ...]  # j + 1 tuples of shapes, on foot and links
    may_touch: tuple[tuple[str, str], ...]
    """Pairs of `base`, `floor`, `link0` (the foot) to the last link, `hand` and `camera` that
    can collide, the second of a pair the outer one; without `camera` it counts as the hand."""
    inertias: tuple[Inertia, ...]  # j + 1, of the foot and the links, each in its frame; or none
    torque: Array  # (j,) largest torques of the joints [Nm]
    visual: str | None  # mesh drawn instead of the collision shapes, if it is installed
    names: tuple[str, ...] = ()  # of the joints in its URDF, if they are known
    links: tuple[tuple[str, SE3], ...] = ()  # of the URDF: names, and frames on foot and links

    @cached_property
    def telescopes(self) -> tuple[int, ...]:
        """(j,) the first slide of the telescope that a joint is part of, or the joint itself."""
        firsts: list[int] = []
        for joint, (placement, slides) in enumerate(zip(self.joints, self.slides, strict=True)):
            along = slides and joint > 0 and self.slides[joint - 1]
            is_next = along and placement.rotation[2, 2] > _UPRIGHT
            firsts.append(firsts[-1] if is_next else joint)
        return tuple(firsts)

    def called(self, joint: int) -> str:
        """A joint, counted from 0, in words."""
        return f"joint `{self.names[joint]}`" if self.names else f"joint {joint + 1}"

    def is_like(self, other: ArmDescription) -> bool:
        """Whether joints and shapes are those of another arm."""
        return len(self.joints) == len(other.joints) and (
            all(map(SE3.isApprox, self.joints, other.joints))
            and [[one.shape for one in link] for link in self.collision]
            == [[one.shape for one in link] for link in other.collision]
        )


@dataclass(frozen=True, kw_only=True, eq=False)
class BaseDescription:
    """A mobile base that moves in the plane."""

    axes: Array  # (3, n_base) twist of each degree of freedom (Haviland 2022, eq. 4)
    size: tuple[float, float, float]  # footprint along x and y, and height [m]
    lag: float  # time constant with which it follows velocity commands [s]
    mass: float  # [kg]
    visual: str | None  # mesh that the viewer draws instead of a box, if it is installed


@dataclass(frozen=True, kw_only=True, eq=False)
class GripperDescription:
    """A parallel gripper. `left` is the finger on the side of +y of e."""

    hTe: SE3  # end effector on the flange
    opening: float  # distance between the pads when fully open [m]
    speed: float  # rate at which the distance between the pads changes [m/s]
    palm: Geom  # the hand without its fingers, a box in e
    finger: Geom  # the left finger, a box in e, when the pads touch
    pad: Geom  # the left pad, a box in e, when the pads touch; its inner face lies in y = 0
    tip: float  # distance from the grasp centre to the end of the pads, along the approach [m]
    ball: Geom  # a ball around palm and fingers at any opening, in e
    collision: tuple[Geom, ...]  # around the hand and its fingers at any opening, in h
    inertia: Inertia  # without the fingers, in h
    finger_mass: float  # of one finger [kg]
    visual: str | None  # mesh that the viewer draws instead of the boxes, if it is installed
    grasps: bool = True  # whether it is a gripper, not a tool
    camera: Geom | None = None  # the camera housing, a box in e along its axes, if there is one
    wrist: tuple[Geom, ...] = ()
    """Boxes around the last two links behind a hand that points down at `ready`: at the grasp
    centre, z up and x ahead. Whichever way the fingers close, a tilted hand has them below it."""


@dataclass(frozen=True, kw_only=True)
class Intrinsics:
    """Pinhole camera: pixel (u, v) of a point (x, y, z) is (fx x/z + cx, fy y/z + cy)."""

    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float

    @property
    def matrix(self) -> Array:
        """(3, 3) from a point in the camera's frame to homogeneous pixels [px]."""
        return np.array([[self.fx, 0.0, self.cx], [0.0, self.fy, self.cy], [0.0, 0.0, 1.0]])


@dataclass(frozen=True, kw_only=True, eq=False)
class CameraDescription:
    """A stereo depth camera on the wrist."""

    eTc: SE3  # camera on the end effector
    intrinsics: Intrinsics
    rate: float  # frames per second [Hz]
    min_range: float  # smallest depth that it measures [m]
    max_range: float  # largest depth that it measures [m]
    baseline: float  # distance between its two imagers [m]
    body: Geom  # the housing, a box in c
    mass: float  # [kg]


@dataclass(frozen=True, kw_only=True, eq=False)
class LaserDescription:
    """A laser on the base that scans a level plane."""

    bTs: SE3  # laser on the base: x along the middle beam, z up
    angles: Array  # (n,) directions of its beams from x towards y, rising [rad]
    max_range: float  # largest range that it measures [m]
    rate: float  # scans per second [Hz]
    noise: float  # standard deviation of a range [m]

    @cached_property
    def beams(self) -> Array:
        """(n, 3) unit directions of its beams in the base."""
        level = np.zeros_like(self.angles)
        beams = np.stack([np.cos(self.angles), np.sin(self.angles), level], axis=1)
        turned: Array = beams @ self.bTs.rotation.T
        return turned

    def points(self, ranges: Array) -> Array:
        """(n, 3) ends of the beams in the base, of ranges (n,) [m], of inf out of reach."""
        reached = np.minimum(ranges, self.max_range)
        points: Array = self.bTs.translation + reached[:, None] * self.beams
        return points


class Swivel(NamedTuple):
    """The joint of an arm that turns all of it about the vertical."""

    joint: int
    sign: float  # -1 where its axis points down
    pivot: Array  # (3,) a point of its axis, in the base


@dataclass(frozen=True, kw_only=True, eq=False)
class RobotDescription:
    """One mobile manipulator: a base, an arm on it, a gripper with a camera at the end."""

    name: str
    base: BaseDescription
    bTa: SE3  # foot of the arm on the base
    arm: ArmDescription
    gripper: GripperDescription
    camera: CameraDescription
    limits: Limits
    laser: LaserDescription | None = None  # on the base, if there is one
    pace: float = 1.0  # share of the nominal speeds that the limits are scaled to

    @cached_property
    def swivel(self) -> Swivel | None:
        """The first joint that turns, if it is upright and those before it slide up and down."""
        bTj = self.bTa
        for joint, (placement, slides) in enumerate(
            zip(self.arm.joints, self.arm.slides, strict=True)
        ):
            bTj = bTj * placement
            up = float(bTj.rotation[2, 2])
            if abs(up) < _UPRIGHT:
                return None
            if not slides:
                pivot = np.array([*bTj.translation[:2], self.bTa.translation[2]])
                return Swivel(joint, float(np.sign(up)), pivot)
        return None

    @property
    def stands_still(self) -> bool:
        """Whether its base does not drive."""
        return bool(self.limits.base_twist.max() < _STILL)

    @cached_property
    def strokes(self) -> Array:
        """(j,) how far each sliding joint gets from its zero [m]; 0 for one that turns."""
        ends = np.maximum(np.abs(self.limits.q_min), np.abs(self.limits.q_max))
        return np.where(self.arm.slides, ends, 0.0)


def with_base_speeds(
    description: RobotDescription,
    forward: float | None = None,
    reverse: float | None = None,
    turn_rate: float | None = None,
) -> RobotDescription:
    """The same robot with other base speeds [m/s, rad/s]; None keeps a speed or its share."""
    if forward is None and reverse is None and turn_rate is None:
        return description
    limits = description.limits
    twist, back = limits.base_twist, limits.base_reverse
    if forward is not None:
        back = forward * float(limits.base_reverse / limits.base_twist[0])
        twist = np.array([*np.where(twist[:2] > 0.0, forward, 0.0), twist[2]])
    if turn_rate is not None:
        twist = np.array([*twist[:2], turn_rate])
    back = back if reverse is None else reverse
    return replace(description, limits=replace(limits, base_twist=twist, base_reverse=back))


def at_pace(description: RobotDescription, pace: float) -> RobotDescription:
    """The same robot at a share of its speeds; its accelerations stay."""
    limits = description.limits
    return replace(
        description,
        pace=pace,
        limits=replace(
            limits,
            qd=pace * limits.qd,
            base_twist=pace * limits.base_twist,
            base_reverse=pace * limits.base_reverse,
        ),
    )

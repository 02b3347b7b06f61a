"""Reachability of poses and postures for a robot, and collisions with the furniture of a scene."""

from collections.abc import Iterator, Sequence
from math import degrees, pi, radians
from typing import NamedTuple

import numpy as np
from pinocchio import SE3

from behaviours import (
    ApproachWord,
    BasePose,
    Posture,
    Region,
    ToolPose,
    region_direction,
    slots,
)
from config import counted
from config.poses import MapPose
from controller import Array, out_of_reach, reached_instead, why_no_stance
from robots import Box, Geom, Plane, RobotDescription, Sphere

_ROUNDING = 1e-3  # of degrees in files [rad]
_UP = 0.5  # cosine between approach and vertical from which the hand points up
_DIPS = 0.005  # finger tips this far below the floor are below it [m]
_DEEP = 0.01  # penetration of furniture that counts [m]
NEAR = 0.03  # distance between a surface and the floor of a region that counts as none [m] ...
_LEVEL = 0.015  # ... and where something is set down, as `place` measures it [m]
_LOW = 0.05  # a hand lower than this over the floor nearly touches it [m]
_COLUMN = 0.12  # width of the foot of an arm [m]
_SAME_TILT = radians(1.0)  # largest difference of tilts that are the same [rad]
_RISES = (-0.05, 0.05, -0.1, 0.1, -0.15, 0.15)  # of a pose that are tried [m]
_SPACING = 0.1  # between the tested points of a region's floor [m]


def why_not_reached(value: object, robot: RobotDescription) -> tuple[str, str] | None:
    """Message and hint about a place where the robot cannot be; None if it can."""
    if isinstance(value, Posture):
        return _beyond_joints(value.on(robot).q, robot)
    if isinstance(value, BasePose) and robot.stands_still:
        return f"the base of `{robot.name}` stands still", "name a pose of the hand"
    if not isinstance(value, ToolPose):
        return None
    if (lowest := _lowest(value, robot)) < -_DIPS:
        return f"the hand would be {-lowest:.2f} m below the floor", "give it another height"
    if why := out_of_reach(robot, value.mTe):
        return f"out of reach: {why}", reached_instead(robot, value.mTe)
    return None


def odd_pose(value: object, robot: RobotDescription) -> tuple[str, str] | None:
    """Message and hint about a pose of the hand that nobody means; else None."""
    if not isinstance(value, ToolPose):
        return None
    if value.mTe.rotation[2, 2] > _UP:
        return "the hand points up", "roll 180 lets it look down"
    if (low := _lowest(value, robot)) < _LOW:
        return f"the hand would be {low:.2f} m above the floor", "give it another height"
    return None


def _lowest(value: ToolPose, robot: RobotDescription) -> float:
    """Height of the finger tips, or of the point between them [m]."""
    tip = value.mTe.act(np.array([0.0, 0.0, robot.gripper.tip]))
    return float(min(tip[2], value.mTe.translation[2]))


def _beyond_joints(q: Array, robot: RobotDescription) -> tuple[str, str] | None:
    if q.shape not in ((0,), robot.arm.ready.shape):  # empty is `ready`
        joints = counted(len(robot.arm.joints), "joint")
        return f"`{robot.name}` has {joints}, not {len(q)}", "write one position a joint"
    if not len(q):
        return None
    low, high = robot.limits.q_min - _ROUNDING, robot.limits.q_max + _ROUNDING
    beyond = np.flatnonzero((q < low) | (q > high))
    if len(beyond) == 0:
        return None
    joint = int(beyond[0])
    called = robot.arm.called(joint)
    ends = (float(one[joint]) for one in (robot.limits.q_min, robot.limits.q_max, q))
    if robot.arm.slides[joint]:
        first, last, here = ends
        message = f"{called} of `{robot.name}` goes from {first:g} m to {last:g} m"
        return f"{message}, not to {here:g} m", f"write {first:g} to {last:g}"
    first, last, here = map(degrees, ends)
    message = f"{called} of `{robot.name}` goes from {first:.0f}° to {last:.0f}°, not to {here:g}°"
    meant = np.degrees(q)  # as if the numbers were radians
    if (np.abs(meant) <= 2.0 * pi).all() and ((meant >= low) & (meant <= high)).all():
        angles = ", ".join(f"{degrees(angle):.0f}" for angle in meant)
        return message, f"did you mean [{angles}]? These look like radians"
    return message, f"write {first:.0f} to {last:.0f}"


def what_is_in_the_way(
    value: object, robot: RobotDescription, fixtures: Sequence[Geom]
) -> tuple[str, str] | None:
    """Message and hint about a pose of the base inside furniture; None if there is room."""
    if not isinstance(value, BasePose):
        return None
    solid = [fixture for fixture in fixtures if not isinstance(fixture.shape, Plane)]
    body = list(_base(value.mTb, robot))
    depths = ((-_gap(part, fixture), fixture.name) for part in body for fixture in solid)
    depth, name = max(depths, default=(0.0, ""), key=lambda found: found[0])
    if depth < _DEEP:
        return None
    return f"the base would be inside `{name}` of the scene", "move the pose, or the furniture"


def why_no_stance_is_free(
    value: object, robot: RobotDescription, fixtures: Sequence[Geom]
) -> tuple[str, str] | None:
    """Message and hint about a pose that the robot cannot reach among the furniture; else None."""
    if not fixtures or not isinstance(value, ToolPose):
        return None
    why, hint = why_no_stance(robot, value.mTe, tuple(fixtures)), "move the pose, or the furniture"
    for rise in _RISES if why else ():
        moved = SE3(value.mTe.rotation, value.mTe.translation + np.array([0.0, 0.0, rise]))
        if not why_no_stance(robot, moved, tuple(fixtures)):
            hint = f"give it a height of {moved.translation[2]:.2f} m, or {hint}"
            break
    return (f"out of reach in the scene: {why}", hint) if why else None


def why_not_come_to(
    region: Region,
    robot: RobotDescription,
    fixtures: Sequence[Geom],
    word: ApproachWord,
    least_tilt: float,
) -> tuple[str, str] | None:
    """Message and hint about a region that the hand does not reach as it may come; else None."""
    if region_direction(robot, tuple(fixtures), region, word, least_tilt) is not None:
        return None
    anyhow = region_direction(robot, tuple(fixtures), region)
    if anyhow is None and robot.stands_still:
        message = f"`{region.name}`: the base stands still, and the arm does not get there"
        return message, "move it nearer"
    if anyhow is None:
        hint = "lower it, or move what is in the way"
        return f"`{region.name}`: no stance lets the hand get to it", hint
    hint = f"tilted by {degrees(anyhow.tilt):.0f}° it does; allow `approach: auto`"
    return f"`{region.name}`: no stance lets the hand come to it like this", hint


def why_not_set_down(
    region: Region, robot: RobotDescription, fixtures: Sequence[Geom], tilts: Sequence[float]
) -> tuple[str, str] | None:
    """Message and hint about a region below or above which no hand of the task is tilted enough.

    What is gripped is set down with the tilt of its grasp; `tilts` are those of all grasps [rad].
    """
    needed = region_direction(robot, tuple(fixtures), region)
    if needed is None or not tilts or max(tilts) > needed.tilt - _SAME_TILT:
        return None
    least = degrees(needed.tilt)
    message = f"`{region.name}` is reached with the hand tilted by {least:.0f}°, and no grasp is"
    return message, f"add `least_tilt_deg: {least:.0f}` to `grasp`: things are set down as gripped"


class Bare(NamedTuple):
    """Places without a surface."""

    missing: int
    of: int
    nearest: float  # the nearest surface is so far from any of the places [m]


def bare_places(
    region: Region, pitch: float | None, fixtures: Sequence[Geom], set_down: bool
) -> Bare:
    """How many places on a region's floor have no surface of the scene below.

    `pitch` is that of the places [m]; None if nothing is to be put there, and any surface will do.
    What is `set_down` needs it more exactly.
    """
    points = slots(region, _SPACING if pitch is None else pitch)
    heights = [_height(point, fixtures) for point in points]
    missing = sum(height > (_LEVEL if set_down else NEAR) for height in heights)
    enough = pitch is None and missing < len(points)
    return Bare(0 if enough else missing, len(points), min(heights))


def _base(mTb: MapPose, robot: RobotDescription) -> Iterator[Geom]:
    """The base and the column of the arm on it, up to the shoulder, in the world."""
    x, y, height = robot.base.size
    shoulder = robot.bTa * robot.arm.joints[0]
    for corner, low, high, middle in (
        ((x, y), 0.0, height, np.zeros(3)),
        ((_COLUMN, _COLUMN), height, shoulder.translation[2], shoulder.translation),
    ):
        at = SE3(np.eye(3), np.array([middle[0], middle[1], (low + high) / 2.0]))
        half = (corner[0] / 2.0, corner[1] / 2.0, max(high - low, 0.01) / 2.0)
        yield Geom(Box(half), mTb * at, "base")


def _height(point: Array, fixtures: Sequence[Geom]) -> float:
    """From a (3,) point to the nearest surface of a fixture, both in the world [m]."""
    ball = Geom(Sphere(1e-4), SE3(np.eye(3), point))
    return min((abs(_gap(ball, fixture)) for fixture in fixtures), default=np.inf)


def _gap(part: Geom, fixture: Geom) -> float:
    """Between two bodies in the world; negative is how deep one is in the other [m]."""
    from hw.sim import separation  # loaded with the scene

    return separation(part, fixture)[0]

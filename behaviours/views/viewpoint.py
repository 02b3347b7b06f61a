"""Viewpoints of the wrist camera: poses of camera and hand, and the motion to one."""

from collections import Counter
from collections.abc import Callable
from math import cos, radians, sin, tan

import numpy as np
import pinocchio as pin
from pinocchio import SE3
from py_trees.common import Status

from behaviours.core.context import Context
from behaviours.core.directions import Direction, heading_of, looking_down, points_down
from behaviours.core.leaf import Leaf
from behaviours.core.motion import Approach, hand_twist
from config.poses import OdometryPose
from controller import Array, PoseGoal
from robots import bounding_radius, half_extents

LOOK_SPEED = 0.5  # of the hand that moves the camera [m/s]
CAMERA_PATIENCE = 2.0  # a camera without a frame for longer is blind [s] ...
GLANCE_PATIENCE = 1.0  # ... and where the hand looks from where it is, and may be asked again [s]
_STEEP = tan(radians(75.0))  # a flatter view shows less of a floor, and objects hide more of it
_ASIDE = 0.18  # how far the hand moves to let the camera see what it is above [m]
_SIDES = [(turn, 0.0) for turn in (0, 50, -50, 100, -100, 180)]
_SIDES += [(turn, 0.12) for turn in (0, 50, -50)]
"""Of a hand that points down: turned from the side without the camera [deg], and up [m]."""
_WAYS_ASIDE = [(back, side) for back in (1.0, 1.7) for side in (0.0, 0.7, -0.7, 1.2, -1.2)]
"""Of a tilted hand, in these lengths: back and to its left."""
_STRAY = 0.1  # share of the points that need not be seen
_NEARBY = 0.5  # what is farther from the points does not hide them [m]
_CLEAR = 0.02  # a point counts so much higher, where something stands before it [m]
_SHADOW = 0.01  # around what is held, from where one of two imagers sees nothing [m]
_AT_REST = 0.05  # a slower hand stands still [m/s and rad/s]
_IMAGE_UP = np.array([[0.0, -1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
"""Camera in the axes of a direction: x to the side, so that up in the image is up in odometry."""


def camera_pose(context: Context) -> SE3:
    """Camera in odometry, as read this tick."""
    return context.oTe * context.robot.description.camera.eTc


def hand_for(context: Context, oTc: OdometryPose) -> SE3:
    """End effector in odometry when the camera is at `oTc`."""
    return oTc * context.robot.description.camera.eTc.inverse()


def straight_down(point: Array, height: float, like: SE3) -> SE3:
    """A camera that looks straight down, in odometry.

    Args:
        point: (3,) what it looks at, in odometry [m].
        height: above that [m].
        like: camera in odometry whose turn about the vertical it keeps.
    """
    return SE3(looking_down(like.rotation[:, 0]), point + np.array([0.0, 0.0, height]))


def looking_along(direction: Direction, point: Array, distance: float, like: SE3) -> SE3:
    """A camera that looks in a direction, in odometry.

    Args:
        direction: in odometry.
        point: (3,) what it looks at, in odometry [m].
        distance: from that [m].
        like: camera in odometry whose turn it keeps where it looks straight down.
    """
    if direction.is_straight:
        return straight_down(point, distance, like)
    oRa = direction.rotation
    return SE3(oRa @ _IMAGE_UP, point + distance * oRa[:, 2])


def turned_towards(
    oTc: OdometryPose, point: Array, distance: float | None = None, *, from_above: bool = False
) -> SE3:
    """A camera turned by the smallest angle that makes it look at a point.

    Args:
        oTc: the camera before, in odometry.
        point: (3,) to look at [m].
        distance: from the point, on the line of sight [m]; None keeps the camera's position.
        from_above: raise it where it looks down by less than 75 degrees.
    """
    away = point - oTc.translation
    if from_above:
        away[2] = min(away[2], -_STEEP * max(float(np.hypot(*away[:2])), 1e-9))
    sight = away / max(float(np.linalg.norm(away)), 1e-9)
    turn = pin.Quaternion.FromTwoVectors(oTc.rotation[:, 2], sight).toRotationMatrix()
    eye = oTc.translation if distance is None else point - distance * sight
    return SE3(turn @ oTc.rotation, eye)


def out_of_view(context: Context, above: SE3, points: Array) -> list[SE3]:
    """Hands that have moved aside, so that nothing known hides what is below; the best first.

    The least motion that shows most of the points counts: of a tilted hand back, or back and to a
    side; of another one away from the camera, to another side, or up.

    Args:
        context: what is held, and stands around.
        above: the hand before, in odometry.
        points: (N, 3) to be seen, in odometry [m].
    """
    if points_down(above.rotation):
        camera = context.robot.description.camera.eTc.translation[:2]
        back = -_ASIDE * camera / max(float(np.linalg.norm(camera)), 1e-6)
        turned = ((pin.utils.rotate("z", radians(turn)), up) for turn, up in _SIDES)
        hands = [above * SE3(np.eye(3), R @ [*back, 0.0] - [0.0, 0.0, up]) for R, up in turned]
    else:
        heading = heading_of(above.rotation)
        c, s = cos(heading), sin(heading)
        ahead, left = np.array([[c, s, 0.0], [-s, c, 0.0]])
        ways = (side * _ASIDE * left - back * _ASIDE * ahead for back, side in _WAYS_ASIDE)
        hands = [SE3(above.rotation, above.translation + way) for way in ways]
    hidden = [(hidden_by(context, hand, points).total(), hand) for hand in hands]
    some = [(max(n, _STRAY * len(points)), hand) for n, hand in hidden if n < len(points)]
    return [hand for _, hand in sorted(some, key=lambda one: one[0])] or hands[:1]


def hidden_by(context: Context, oTe: OdometryPose, points: Array) -> Counter[str]:
    """How many of (N, 3) points in odometry a hand would not see, by what is known to hide them.

    That is what it holds, what stands on the map, what was set down, or the edge of the image.
    """
    camera, oTm = context.robot.description.camera, context.localisation.oTm
    eye, eTo = camera.eTc.translation, oTe.inverse()
    ray = eTo.rotation @ (points - oTe.translation).T - eye[:, None]
    u, v, depth = camera.intrinsics.matrix @ camera.eTc.rotation.T @ ray
    shown = (u > 0.0) & (u < camera.intrinsics.width * depth)
    shown &= (v > 0.0) & (v < camera.intrinsics.height * depth)
    hides = Counter({"it is outside the picture": int((~shown).sum())})
    eTm = eTo if oTm is None else eTo * oTm
    middle, over = ray.mean(axis=1) + eye, ray + _CLEAR * eTo.rotation[:, 2:]
    around = context.surroundings.fixtures + context.surroundings.loose
    known = [("what the hand holds", one.shape, one.pose, ray) for one in context.memory.held]
    known += [(one.name, one.shape, eTm * one.pose, over) for one in around]
    for name, shape, pose, way in known:
        if np.linalg.norm(pose.translation - middle) > bounding_radius(shape) + _NEARBY:
            continue
        half = np.array(half_extents(shape)) + _SHADOW
        start, along = pose.actInv(eye), way.T @ pose.rotation
        with np.errstate(divide="ignore", invalid="ignore"):
            enter, leave = np.sort((np.array([-half, half])[:, None] - start) / along, axis=0)
        behind = shown & (enter.max(axis=1) <= np.minimum(leave.min(axis=1), 1.0))
        hides[f"{name} is before it"] += int(behind.sum())
        shown &= ~behind
    return hides


def is_at_rest(context: Context) -> bool:
    """Whether the hand stands still, as read this tick, even if base and arm move."""
    return bool(np.abs(hand_twist(context)).max() <= _AT_REST)


class MoveCamera:
    """The motion of the camera to a viewpoint, until the hand is at rest.

    Args:
        leaf: sets the goal and gets the feedback message.
        view: gives the viewpoint, in every tick: camera in odometry.
        target: its name in messages.
        timeout: fail after this [s].
    """

    def __init__(self, leaf: Leaf, view: Callable[[], SE3], target: str, timeout: float) -> None:
        self._leaf = leaf

        def goal() -> PoseGoal[OdometryPose]:
            return PoseGoal(target=hand_for(leaf.context, view()), speed=LOOK_SPEED)

        self._approach = Approach(leaf, goal, target, timeout)

    def tick(self) -> Status:
        """SUCCESS when the camera rests there, FAILURE as for an `Approach`."""
        status = self._approach.tick()
        if status is Status.SUCCESS and not is_at_rest(self._leaf.context):
            return self._leaf.running("steadying the camera")  # it keeps the goal
        return status

"""A place that is given exactly: a pose, or the top of what stands there; and a look at it."""

from __future__ import annotations

from dataclasses import replace
from math import atan2, degrees, hypot, pi

import numpy as np
import pinocchio as pin
from pinocchio import SE3
from py_trees.common import Status

from behaviours.core.context import Context
from behaviours.core.directions import Direction
from behaviours.core.held_object import in_hand
from behaviours.core.leaf import Leaf
from behaviours.core.parameter_types import Region, ToolPose
from behaviours.views.objects import Choice, ObjectDetection
from behaviours.views.survey import VIEW_HEIGHT
from behaviours.views.viewpoint import (
    CAMERA_PATIENCE,
    MoveCamera,
    camera_pose,
    hand_for,
    looking_along,
    out_of_view,
)
from config.arrays import Array
from config.planar import yaw_of
from perception import DetectedObject, DetectedObjects

_SIDE, _HEIGHT = 0.1, 0.2  # of the region around such a place [m]
_LONG = 1.2  # length by width from which an object has a heading
_AROUND = 0.3  # side of what is looked at to measure where an object stands [m]
_TIMEOUT = 30.0  # of the way to a view [s]


def region_at(pose: ToolPose, side: float = _SIDE) -> Region:
    """The region of a pose that is a point of a surface, and a heading along its x axis."""
    centre = pose.mTe.translation + np.array([0.0, 0.0, _HEIGHT / 2.0])
    return Region(
        name=pose.name,
        on=pose.on,
        frame=pose.frame,
        mTr=SE3(pin.utils.rotate("z", yaw_of(pose.mTe.rotation)), centre),
        size=np.array([side, side, _HEIGHT]),
    )


def region_on(context: Context, one: DetectedObject) -> Region:
    """The region on top of an object, along its longer edge, on the map."""
    return _at_height(context, one, one.size[2] / 2.0, min(_SIDE, one.width))


def region_around(context: Context, one: DetectedObject) -> Region:
    """The region in which an object stands, on the map, to look for it again."""
    return _at_height(context, one, one.floor - float(one.seen_at.translation[2]), _AROUND)


def _at_height(context: Context, one: DetectedObject, up: float, side: float) -> Region:
    seen = one.seen_at * SE3(np.eye(3), np.array([0.0, 0.0, up]))
    mTe = context.to_map(seen if one.drift is None else one.drift() * seen)
    return region_at(ToolPose(name=one.name, frame=context, mTe=mTe), side)


def aligned(context: Context, oRe: Array, region: Region) -> tuple[Array, Array]:
    """How the hand sets down what it holds along the x axis of a region, by the least turn.

    Returns (3, 3) its rotation, and (3,) from the middle of the object to the hand [m], level, both
    in odometry.
    """
    off, angle = in_hand(context.log.grip_outline, context.state.gripper_width)
    edge = oRe[:, 0] * np.cos(angle) + oRe[:, 1] * np.sin(angle)
    turn = _between(atan2(edge[1], edge[0]), yaw_of(region.oTr.rotation))
    turned = pin.utils.rotate("z", turn) @ oRe
    return turned, -off * turned[:, 0] * [1.0, 1.0, 0.0]


def _between(one: float, other: float) -> float:
    """The turn from a line to another one, at most 90 degrees [rad]."""
    return (other - one + pi / 2.0) % pi - pi / 2.0


class LookAtPlace:
    """The camera goes over a place, and tells apart what stands there.

    Where it sees nothing, as the held object hides a part, it looks again from aside.

    Args:
        leaf: sets the goals and gets the feedback message.
        region: of the place.
        direction: in which the camera looks, in odometry.
    """

    def __init__(self, leaf: Leaf, region: Region, direction: Direction) -> None:
        self._leaf, self._region, like = leaf, region, camera_pose(leaf.context)
        self._detection = ObjectDetection(leaf.context, region, Choice())
        self._since = leaf.context.clock.now()
        self._arrived = self._is_aside = False
        self._aside: SE3 | None = None  # the camera there, from where it looked first
        context, camera = leaf.context, leaf.context.robot.description.camera

        def view() -> SE3:
            over = looking_along(direction, _floor(region), VIEW_HEIGHT, like)
            if not self._is_aside:
                return over
            hand, middle = hand_for(context, over), _floor(region)[None]
            if self._aside is None:
                self._aside = over.inverse() * out_of_view(context, hand, middle)[0] * camera.eTc
            return over * self._aside

        self._camera = MoveCamera(leaf, view, f"a view of {region.name}", _TIMEOUT)

    def tick(self) -> DetectedObjects | Status:
        """What stands there, RUNNING before, FAILURE if that is not seen."""
        context, leaf = self._leaf.context, self._leaf
        if not self._arrived:
            if (status := self._camera.tick()) is not Status.SUCCESS:
                return status
            self._arrived, self._since = True, context.clock.now()
            self._detection.begin(context.state.stamp)
        found = self._detection.update()
        if isinstance(found, DetectedObjects):
            if found or not (unseen := self._detection.unseen(found)):
                return found
            if self._is_aside:
                return leaf.failure(unseen)
            self._is_aside, self._arrived = True, False
            return leaf.running(f"{unseen}; looking from aside")
        if found is None and context.clock.now() - self._since <= CAMERA_PATIENCE:
            return leaf.running(f"looking at {self._region.name}")
        return leaf.failure(
            found or context.vision.blindness(context.state.stamp) or "no camera frame"
        )

    def nearest(self, found: DetectedObjects) -> DetectedObject:
        """What stands nearest to the middle of the region."""
        return min(found, key=self.off)

    def off(self, one: DetectedObject) -> float:
        """How far from there it stands [m]."""
        return hypot(*(one.position - self._region.oTr.translation)[:2])


def _floor(region: Region) -> Array:
    floor: Array = region.oTr.act(np.array([0.0, 0.0, -region.size[2] / 2.0]))
    return floor


class Measurement(LookAtPlace):
    """Measures how far from a place, and how turned, an object stands that was set down there.

    Args:
        within: the largest distance [m].
        turn: the largest turn of what is longer than wide [rad].
        least: how high it reaches over the place at least [m]; what fell off is lower.
    """

    def __init__(
        self,
        leaf: Leaf,
        place: Region,
        direction: Direction,
        *,
        within: float,
        turn: float,
        least: float,
    ) -> None:
        size = np.array([_AROUND, _AROUND, _HEIGHT])
        super().__init__(leaf, replace(place, size=size), direction)
        self._within, self._turn, self._least = within, turn, least

    def judge(self) -> Status:
        """SUCCESS if it stands there, FAILURE if it does not, or is not seen."""
        found, leaf, oTr = self.tick(), self._leaf, self._region.oTr
        if found is Status.RUNNING:
            return found
        if isinstance(found, Status):
            return self._missed(f"it is not seen where it stands: {leaf.feedback_message}")
        if not found:
            return self._missed(f"let go, but nothing stands at {self._region.name}")
        one = self.nearest(found)
        if (low := self._least - one.size[2]) > 0.0:
            place = self._region.name
            return self._missed(f"it does not stand on {place}: {1000 * low:.0f} mm too low")
        off, turn = self.off(one), 0.0
        text = f"it stands {1000 * off:.0f} mm"
        if one.size[0] >= _LONG * one.size[1]:
            turn = abs(_between(yaw_of(one.seen_at.rotation), yaw_of(oTr.rotation)))
            text += f" and {degrees(turn):.0f}°"
        text += f" from {self._region.name}{self._if_in_place}"
        is_there = off <= self._within and turn <= self._turn
        return leaf.success(text) if is_there else self._missed(text)

    @property
    def _if_in_place(self) -> str:
        """What the pose of the base rests on, if that may have been moved with the place."""
        here = self._leaf.context.localisation
        alone = set() if here.registration is None else set(here.registration.alone)
        alone = (alone | set(here.furniture.names)) - {self._region.on}
        return f", if {' and '.join(sorted(alone))} stands as on the map" if alone else ""

    def _missed(self, why: str) -> Status:
        """Fail; the object does not count as placed."""
        self._leaf.context.log.carried[-1].placed = None
        return self._leaf.failure(why)

"""The directions of approach in which a robot reaches regions and poses of the map.

Where furniture is high, deep or below something, that with the least tilt for which a stance
reaches all that matters.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from dataclasses import replace
from math import atan2, cos, pi, radians, sin
from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin
from pinocchio import SE3

from behaviours.core.directions import DOWN, ApproachWord, Direction, points_down
from config.planar import yaw_of
from controller import Array, stance_search, why_no_stance
from robots import Geom, Plane, RobotDescription, reach

if TYPE_CHECKING:
    from behaviours.core.parameter_types import Region, ToolPose

_RANGES: dict[ApproachWord, tuple[float, float]] = {
    "auto": (0.0, 90.0),
    "down": (0.0, 0.0),
    "tilted": (15.0, 75.0),
    "level": (75.0, 90.0),
}
_TILTS = (0.0, 15.0, 30.0, 45.0, 60.0, 75.0, 90.0)  # that are tried [deg]
_LOW = 0.7  # below this height the hand reaches everything straight down [m] ...
_CLEAR = 0.75  # ... if nothing stands this high above it [m]
PASSES = 0.05
"""Tolerance from which on a tool pose is a way point, at which the hand may tilt [m]."""
_EASY = 1.0  # a way point lower than this has a stance for a hand that looks down [m]
_BESIDE = 0.1  # or this near beside that [m]
_OVER_FLOOR = 0.05  # height over the floor of a region that the hand reaches [m]
_BACK = (0.0, 0.12, 0.24)  # where it is tried along the way in, before the place [m]
_ASTRAY = 0.02  # a way point is reached though it lies this much farther, and higher [m]
_TURNS = tuple(radians(turn) for turn in (-90.0, 90.0, -75.0, 75.0))  # to come from the side ...
_SIDEWAYS = (radians(50.0), radians(60.0))  # ... and the tilts then
_CLOSE = (0.0, 0.12, 0.2)  # where it must be reached along its way, before the place [m]
_SPREAD = 0.25  # of the tried places to either side of the middle, as a share of its size


def region_direction(
    robot: RobotDescription,
    fixtures: tuple[Geom, ...],
    region: Region,
    word: ApproachWord = "auto",
    least_tilt: float = 0.0,
) -> Direction | None:
    """The direction in which the hand reaches most of a region of the map; None if none does.

    Args:
        robot: the robot.
        fixtures: what stands on the map.
        region: that the hand works in.
        word: the directions that are allowed.
        least_tilt: of these, those with at least this tilt [rad].
    """
    least, most = (radians(end) for end in _RANGES[word])
    least = max(least, least_tilt)
    is_low = not is_high(region, fixtures) and not robot.stands_still
    if Direction(least, 0.0).is_straight and is_low:
        return DOWN
    directions = list(_directions(least, most, headings_into(region)))
    for direction in directions:
        poses = list(_inside(region, direction))
        farthest_out = poses[len(_BACK) - 1 :: len(_BACK)]  # most often these are not reached
        if _count_reached(robot, fixtures, farthest_out) == len(farthest_out) and _count_reached(
            robot, fixtures, poses
        ) == len(poses):
            return direction
    counts = [_count_reached(robot, fixtures, _inside(region, one)) for one in directions]
    most_reached = max(counts, default=0)
    return directions[counts.index(most_reached)] if most_reached else None


def _count_reached(
    robot: RobotDescription, fixtures: tuple[Geom, ...], poses: Iterable[tuple[SE3, bool]]
) -> int:
    """How many poses are reached before one is not; with each, whether the hand may touch there."""
    reached = 0
    for mTe, touches in poses:
        if why_no_stance(robot, mTe, fixtures, hand_may_touch=touches):
            break
        reached += 1
    return reached


def sideways(
    robot: RobotDescription, fixtures: tuple[Geom, ...], direction: Direction, point: Array
) -> Iterator[Direction | None]:
    """Directions to either side of a tilted one, in which the hand gets to a point (3,) of the map.

    What lies across one of them, and is too long for the fingers, lies along another: those that
    are turned most come first. None comes after each bounded piece of work.
    """
    ahead = np.array([cos(direction.heading), sin(direction.heading), 0.0])
    farther = point + _ASTRAY * ahead
    for turn in _TURNS:
        for tilt in _SIDEWAYS:
            beside = Direction(max(tilt, direction.tilt), direction.heading + turn)
            way = [SE3(beside.hand, farther - back * beside.hand[:, 2]) for back in _CLOSE]
            if (yield from _are_reached(robot, fixtures, way, ahead)):
                yield beside
                break


def _are_reached(
    robot: RobotDescription, fixtures: tuple[Geom, ...], poses: Iterable[SE3], ahead: Array
) -> Generator[None, None, bool]:
    """Whether stances, none `ahead` (3,) of it, reach each of the poses of the hand on the map.

    The way around the furniture takes long. Works in bounded pieces.
    """
    for pose in poses:
        search = stance_search(robot, pose, fixtures)
        while not search.done:
            search.advance()
            yield
        if search.best is None:
            return False
        x, y, _ = search.best.base_for(pose)
        if ahead @ (np.array([x, y, 0.0]) - pose.translation) > 0.0:
            return False
    return True


def is_high(region: Region, fixtures: Sequence[Geom]) -> bool:
    """Whether a region is high, or something is above it."""
    return _floor(region) >= _LOW or room_above(region, fixtures) < _CLEAR


def room_above(region: Region, fixtures: Sequence[Geom]) -> float:
    """How far the lowest thing above or beside a region is over its floor [m]; infinite for none.

    What stands on its floor does not count.
    """
    axes = (*np.eye(3)[:2], *-np.eye(3)[:2])
    centre = region.mTr.translation
    half = [float(np.abs(region.mTr.rotation.T @ axis) @ region.size / 2.0) for axis in axes]
    room = np.inf
    for one in fixtures:
        if isinstance(one.shape, Plane):
            continue
        lowest = -reach(one, np.array([0.0, 0.0, -1.0])) - _floor(region)
        if _BESIDE < lowest < room and all(
            axis @ centre - side - _BESIDE < reach(one, axis)
            for axis, side in zip(axes, half, strict=True)
        ):
            room = lowest
    return room


def _floor(region: Region) -> float:
    floor: float = region.mTr.translation[2] - region.size[2] / 2.0
    return floor


def headings_into(region: Region) -> list[float]:
    """Directions on the map in which the hand may reach into a region [rad].

    Across its sides, the one first that leads away from where the robot starts.
    """
    if region.front is not None:
        return [region.front]
    x, y = region.mTr.translation[:2]
    yaw = yaw_of(region.mTr.rotation)
    sides = [yaw + quarter * pi / 2.0 for quarter in range(4)]
    return sorted(sides, key=lambda side: round(-cos(side - atan2(y, x)), 6))


def _directions(least: float, most: float, headings: Sequence[float]) -> Iterator[Direction]:
    """Those with a tilt between two bounds [rad], the least tilt first."""
    tilts = {least, *(radians(tilt) for tilt in _TILTS if least <= radians(tilt) <= most)}
    for tilt in sorted(tilts):
        for heading in headings:
            direction = Direction(tilt, heading)
            yield direction
            if direction.is_straight:
                break


def _inside(region: Region, direction: Direction) -> Iterator[tuple[SE3, bool]]:
    """Poses of the hand on the map that work in a region needs, the indispensable ones first.

    And whether the hand may touch something there.
    """
    floor = np.array([0.0, 0.0, _OVER_FLOOR - region.size[2] / 2.0])
    way = region.mTr.rotation.T @ np.array([cos(direction.heading), sin(direction.heading), 0.0])
    spread = _SPREAD * float(np.abs(way) @ region.size) * way
    mRe = direction.hand  # the camera is over it
    quarter = pin.utils.rotate("z", pi / 2.0)
    for aside in (np.zeros(3), spread, -spread):
        at = region.mTr.act(floor + aside)
        for back in _BACK:
            yield SE3(mRe, at - back * mRe[:, 2]), back == 0.0
    yield SE3(mRe @ quarter, region.mTr.act(floor)), True


def tilted_if_needed(
    robot: RobotDescription, fixtures: tuple[Geom, ...], pose: ToolPose, within: float
) -> ToolPose:
    """A pose of the map for which there is a stance: tilted about the finger tips if it must be.

    As it is if no tilt helps, if it is low, if the hand does not look down there, or if it has to
    be met nearer than `PASSES`: within `within` [m].
    """
    mTe = pose.mTe
    if within < PASSES or mTe.translation[2] < _EASY or not points_down(mTe.rotation):
        return pose
    ahead = atan2(mTe.translation[1], mTe.translation[0])
    headings = [ahead + turn * pi / 4.0 for turn in (0, 1, -1, 2, -2, 3, -3, 4)]

    def leaning(direction: Direction, farther: float = 0.0) -> SE3:
        way = np.array([cos(direction.heading), sin(direction.heading), 1.0])
        return SE3(_tilted(mTe.rotation, direction), mTe.translation + farther * way)

    barely = None
    for direction in reached(robot, fixtures, headings, leaning):
        if not why_no_stance(robot, leaning(direction, _ASTRAY), fixtures):
            return replace(pose, mTe=leaning(direction))
        barely = barely or direction
    return pose if barely is None else replace(pose, mTe=leaning(barely))


def _tilted(oRe: Array, direction: Direction) -> Array:
    """(3, 3) a hand that looks down, tilted in a direction; the camera comes to be over it."""
    heading = np.array([cos(direction.heading), sin(direction.heading)])
    axis = np.array([-sin(direction.heading), cos(direction.heading), 0.0])
    turned: Array = pin.exp3(-direction.tilt * axis) @ oRe
    if not direction.is_straight and oRe[:2, 0] @ heading < 0.0:  # the fingers are alike
        turned = turned @ np.diag([-1.0, -1.0, 1.0])
    return turned


def reached(
    robot: RobotDescription,
    fixtures: tuple[Geom, ...],
    headings: Sequence[float],
    pose: Callable[[Direction], SE3],
) -> Iterator[Direction]:
    """Directions for which a stance reaches the hand's pose on the map, the least tilt first.

    `headings` are tried in order [rad].
    """
    for direction in _directions(0.0, pi / 2.0, headings):
        if not why_no_stance(robot, pose(direction), fixtures):
            yield direction

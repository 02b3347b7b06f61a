"""Walkers, and which contacts with them the robot could have avoided."""

from dataclasses import dataclass
from math import ceil, inf

import numpy as np
from pinocchio import SE3

from controller import Array, Obstacle
from robots import Cylinder, Geom, RobotDescription

SIGHT = 2.0  # the robot is expected to react to a course that a walker has had for this time [s]
STILL = 0.05  # a robot that approaches a walker more slowly than this does not run into it [m/s]
MARGIN = 0.05  # distance that counts as out of the walker's way [m]


@dataclass(frozen=True, kw_only=True, eq=False)
class Walker:
    """An upright cylinder that moves along a line, at constant speed or to and fro."""

    name: str
    shape: Cylinder
    start: Array  # (2,) one end of its line [m]
    direction: Array  # (2,) unit vector
    speed: float  # [m/s]
    length: float = inf  # of its line, where it turns round [m]; infinite if it never does
    phase: float = 0.0  # path length at time 0 [m]

    def positions(self, times: Array) -> Array:
        """(k, 3) centre at times (k,) [s]."""
        walked = self.phase + self.speed * times
        if self.length < inf:
            walked = self.length - np.abs(walked % (2.0 * self.length) - self.length)
        height = np.full(len(times), self.shape.half_length)
        return np.column_stack([self.start + np.outer(walked, self.direction), height])

    def velocity(self, time: float) -> Array:
        """(3,) [m/s]."""
        back = self.length < inf and (self.phase + self.speed * time) // self.length % 2 == 1
        return np.array([*self.direction, 0.0]) * (-self.speed if back else self.speed)

    def course_time(self, time: float) -> float:
        """Time since it took its present course, at most the time itself [s]."""
        if self.length == inf:
            return time
        walked = (self.phase + self.speed * time) % self.length
        return min(time, walked / self.speed)

    def obstacle(self, time: float) -> Obstacle:
        """As given to the controller."""
        place = SE3(np.eye(3), self.positions(np.array([time]))[0])
        return Obstacle(Geom(self.shape, place, self.name), self.velocity(time))


def could_have_left(
    robot: RobotDescription, base: Array, period: float, walker: Walker, sample: int
) -> bool:
    """Whether the robot could have been out of the way of a walker that touches it.

    The way of the walker is the strip that it sweeps, wider on both sides by the circle around the
    base. Since `SIGHT` before the contact, or since the walker took its present course, a robot
    beside the strip could have stopped there, if it brakes in that distance; and any could have
    driven out of it, accelerating outwards at its limits after its lag: along its heading, and an
    omnidirectional base sideways at the same time. `base` is (k, 3) x, y [m] and heading [rad]
    along the motion, in samples of a `period` [s], of which `sample` is the first of the contact.
    """
    limits = robot.limits
    before, time = _since(walker, sample, period)
    velocity = walker.velocity(sample * period)[:2]
    across = np.array([-velocity[1], velocity[0]]) / np.linalg.norm(velocity)
    there = walker.positions(np.array([before * period]))[0, :2]
    offset = float(across @ (base[before, :2] - there))
    half = walker.shape.radius + float(np.hypot(*robot.base.size[:2])) / 2.0 + MARGIN
    moved = (base[before, :2] - base[max(before - 1, 0), :2]) / period
    beside, side = abs(offset) >= half, float(np.sign(offset))
    if beside:
        speed = float(np.linalg.norm(moved))
        braking = speed * robot.base.lag + speed * speed / (2.0 * limits.base_acceleration[0])
        inwards = -side * float(across @ moved) / max(speed, 1e-9)
        if abs(offset) - half >= braking * inwards:
            return True
    heading, lag = base[before, 2], min(time, robot.base.lag)
    axes = [np.array([np.cos(heading), np.sin(heading)])]
    if limits.base_twist[1] > 0.0:
        axes.append(np.array([-np.sin(heading), np.cos(heading)]))
    for out in (1.0, -1.0):
        if beside and out == side:
            continue  # it cannot stop before the strip: only the other side is left
        gone = out * float(across @ moved) * lag
        for number, axis in enumerate(axes):
            way = float(np.sign(out * float(axis @ across))) or 1.0
            top = float(limits.base_speed(way * np.eye(3)[number])[number])
            driven = _driven(
                min(way * float(axis @ moved), top),
                top,
                float(limits.base_acceleration[number]),
                time - lag,
            )
            gone += abs(float(axis @ across)) * driven
        if gone >= half - out * offset:
            return True
    return False


def remaining_speed(
    robot: RobotDescription, base: Array, period: float, walker: Walker, sample: int
) -> float:
    """Speed of a robot that brakes since it knows the walker's course [m/s]; see above."""
    before, time = _since(walker, sample, period)
    x, y, turn = np.abs(base[before] - base[max(before - 1, 0)]) / period
    speed = np.hypot(x, y) + turn * np.hypot(*robot.base.size[:2]) / 2.0
    braked = robot.limits.base_acceleration[0] * max(0.0, time - robot.base.lag)
    return max(0.0, float(speed - braked))


def _since(walker: Walker, sample: int, period: float) -> tuple[int, float]:
    """Sample from which the robot knows the walker's course, and the time since then [s]."""
    known = ceil(min(SIGHT, walker.course_time(sample * period)) / period)
    before = max(sample - known, 0)
    return before, (sample - before) * period


def _driven(speed: float, top: float, acceleration: float, time: float) -> float:
    """Distance that a base drives in a time, accelerating to its top speed [m]."""
    speeding = min(time, (top - speed) / acceleration)
    return speed * speeding + 0.5 * acceleration * speeding**2 + top * (time - speeding)

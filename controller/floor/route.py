"""Leading the base to a pose between things that stand on the floor.

Where plain driving touches nothing, the base drives plainly. Else it comes straight out of where it
cannot turn, follows the cheapest way with round corners, and goes straight in where it cannot turn
at the goal. A way is planned once, and anew when the room, the goal or the base's place is another.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import cos, exp, hypot, inf, sin

import numpy as np

from controller.command import Array
from controller.floor.base_drive import Lead, Pose2D, drive_to, time_to_drive, wrap
from controller.floor.floor_map import FloorMap
from controller.floor.path import SPACING
from controller.floor.route_planner import CLEARANCE, Leg, Planner, duration, turns
from controller.model import RobotModel
from controller.settings import ControllerSettings

_NEW_GOAL = (0.1, 0.2)
"""A goal that has moved this far is another one [m, rad]."""
_LOST = 0.30
"""This far off its way the base looks for another [m]."""
_CHECK = 100
"""Periods after which plain driving is checked anew."""
_NEAR_END = 0.015
"""A leg ends this far before its last point [m]."""
_ARRIVED = 0.02
"""The base drives plainly where that ends nearer to the goal than this [m and rad]."""
_TRIAL = 0.15
"""Time between the poses of a trial [s]."""
_WORTH_PLANNING = 1.0
"""Plain driving that takes so much longer than turns and straights at full speed is compared with
a way [s]."""
_TRIAL_NEAR = 1.0
"""Nearer to the goal than this the poses are three times as close [m]."""
_TRIAL_STEPS = 100
"""Steps after which a trial is given up."""


class Route:
    """The way of the base to one pose after the other.

    Args:
        model: the robot.
        settings: of the controller.
    """

    def __init__(self, model: RobotModel, settings: ControllerSettings) -> None:
        self._model = model
        self._settings = settings
        self.reset()

    def reset(self) -> None:
        """Forget the way."""
        self._room: FloorMap | None = None
        self._goal = Pose2D(inf, inf, inf)
        self._reverse = False
        self._legs: list[Leg] = []
        self._turns: list[float] = []
        self._leg = self._at = self._unchecked = 0
        self._plain = False
        self._why_not = ""
        self._plain_time = inf
        """What plain driving would take from where the way was planned; inf if it cannot [s]."""
        self._search: Iterator[list[Leg] | None] = iter(())
        self.way = np.zeros((0, 3))
        """(N, 3) poses of the base on its way; the same object as long as it is the same way."""

    def lead(self, room: FloorMap, wTb: Pose2D, goal: Pose2D, reverse: bool = False) -> Lead:
        """Where to drive now.

        Args:
            room: what stands around; the same object as long as nothing changes.
            wTb: base pose.
            goal: base pose to get to.
            reverse: drive there backwards.
        """
        if room.free:
            return self._plainly(wTb, goal, reverse)
        if room is not self._room or reverse != self._reverse or self._is_another(goal):
            self.reset()
            self._room, self._goal, self._reverse = room, goal, reverse
            self._start(room, wTb, goal)
        self._unchecked += 1
        if self._plain and self._unchecked > _CHECK:
            self._plain = self._trial_time(room, wTb, goal, inf) < inf
            if not self._plain:
                self._start(room, wTb, goal)
        if not self._plain and not self._legs:
            waiting = self._think(wTb, goal)
            if waiting is not None:
                return waiting
        if self._plain:
            self.way = self._tried
            return self._plainly(wTb, goal, reverse)
        return self._follow(room, wTb, goal)

    def _is_another(self, goal: Pose2D) -> bool:
        far, turned = _NEW_GOAL
        moved = hypot(goal.x - self._goal.x, goal.y - self._goal.y)
        return not (moved < far and abs(wrap(goal.heading - self._goal.heading)) < turned)

    def _plainly(self, wTb: Pose2D, goal: Pose2D, reverse: bool) -> Lead:
        return plain_lead(self._model, self._settings, wTb, goal, reverse)

    def _trial_time(self, room: FloorMap, wTb: Pose2D, goal: Pose2D, within: float) -> float:
        """Time of plain driving that ends `within` of the goal [m and rad] and touches nothing [s].

        Inf if it does not.
        """
        self._unchecked = 0
        poses, time = trial(
            self._model, self._settings, wTb, goal, self._reverse, self._velocities()
        )
        self._tried = np.concatenate([poses, [goal]])
        here, *clearances = room.stands_free(poses).tolist()
        (there,) = room.stands_free(np.array([goal])).tolist()
        x, y, turn = goal.relative_to(Pose2D(*poses[-1].tolist()))
        arrives = hypot(x, y) < within and abs(turn) < within
        free = min(clearances, default=inf) >= min(CLEARANCE, here, there) - 0.005
        return time if arrives and free else inf

    def _is_plain(self, room: FloorMap, wTb: Pose2D, goal: Pose2D, left: float) -> bool:
        """Whether plain driving is as good as the way, on which it takes a time [s]."""
        self._plain = self._trial_time(room, wTb, goal, _ARRIVED) < left + _WORTH_PLANNING
        if self._plain:
            self._legs = []
        return self._plain

    def _velocities(self) -> Array:
        """(n_base,) about what the base has on its way now; a holonomic base may have any."""
        velocities = np.zeros(self._model.n_base)
        if self._legs and self._model.n_base == 2:
            leg, at = self._legs[self._leg], self._at
            gained = (2.0 * float(self._model.acceleration_limits[1]) * at * SPACING) ** 0.5
            speed = min(gained, float(leg.path.speeds[at]))  # it sets out from rest
            turn = float(leg.headings[at] - leg.headings[max(0, at - 1)])
            backwards = self._reverse != leg.backwards
            velocities[:] = turn / SPACING * speed, -speed if backwards else speed
        return velocities

    def _start(self, room: FloorMap, wTb: Pose2D, goal: Pose2D) -> None:
        self._why_not = ""
        self._leg = self._at = 0
        self._legs = []
        self._plain_time = self._trial_time(room, wTb, goal, _ARRIVED)
        drive, target = self._settings.drive, goal.relative_to(wTb)
        least = min(time_to_drive(self._model, drive, target, back) for back in (False, True))
        self._plain = self._plain_time < least + _WORTH_PLANNING
        if not self._plain:
            self._search = Planner(self._model, room, self._reverse).search(wTb, goal)

    def _think(self, wTb: Pose2D, goal: Pose2D) -> Lead | None:
        """Go on looking for a way; where to drive until there is one."""
        legs = [] if self._why_not else next(self._search)
        if legs:
            rate = float(self._model.limits.base_twist[2])
            self._plain = self._plain_time <= duration(legs, wTb, goal, rate)
            self._legs = [] if self._plain else legs
            poses = [np.column_stack([leg.path.points[:, :2], leg.headings]) for leg in legs]
            self.way = np.concatenate([[wTb], *poses, [goal]])
            self._turns = turns(legs, wTb, goal)
            return None
        if legs is not None and self._plain_time < inf:
            self._plain = True
            return None
        if legs is not None and not self._why_not:
            start, end = (f"({pose.x:.2f}, {pose.y:.2f})" for pose in (wTb, goal))
            self._why_not = f"no way for the base from {start} to {end}"
        still = Pose2D(0.0, 0.0, 0.0)
        return Lead(still, self._reverse, False, 0.0, inf, unreachable=self._why_not)

    def _follow(self, room: FloorMap, wTb: Pose2D, goal: Pose2D) -> Lead:
        """The point ahead on the way."""
        leg = self._legs[self._leg]
        points = leg.path.points
        window = points[self._at : self._at + 12, :2]
        away = np.hypot(window[:, 0] - wTb.x, window[:, 1] - wTb.y)
        nearest = int(away.argmin())
        passed = range(self._at, self._at + nearest + 1)
        self._at += nearest
        if away[nearest] > _LOST:
            self._start(room, wTb, goal)
            return self.lead(room, wTb, goal, self._reverse)
        left = self._time_left(wTb)
        opens = bool(leg.narrow[passed[0]] and not leg.narrow[self._at])
        bends = any(bend in passed for bend in leg.path.bends)
        if (opens or bends) and self._is_plain(room, wTb, goal, left):
            return self._plainly(wTb, goal, self._reverse)
        if self._passed(leg, wTb):
            if self._leg + 1 == len(self._legs):
                self._plain, self._legs = True, []
                return self._plainly(wTb, goal, self._reverse)
            self._leg, self._at = self._leg + 1, 0
            self._is_plain(room, wTb, goal, self._time_left(wTb))
            return self.lead(room, wTb, goal, self._reverse)
        speed = float(leg.path.speeds[self._at])
        close = self._model.n_base == 3 or leg.narrow[self._at]
        ahead = (0.12 if close else 0.25) * (1.0 + speed)
        ahead = max(ahead, float(away[nearest]) + SPACING)
        rest = np.hypot(points[self._at :, 0] - wTb.x, points[self._at :, 1] - wTb.y)
        far = np.flatnonzero(rest >= ahead)
        index = self._at + int(far[0]) if len(far) else len(points) - 1
        beyond = 0.0 if len(far) else ahead - float(rest[-1])
        x, y, way = points[index].tolist()
        x, y = x + beyond * cos(way), y + beyond * sin(way)
        heading = float(leg.headings[self._at])
        target = Pose2D(x, y, heading).relative_to(wTb)
        if self._model.n_base == 3:
            speed = min(speed, self._until_turned(leg, wTb))
        return Lead(
            target,
            self._reverse != leg.backwards,
            False,
            speed,
            left,
            straight=bool(leg.narrow[self._at]),
        )

    def _time_left(self, wTb: Pose2D) -> float:
        """Least time to the goal along the way [s]."""
        leg, later = self._legs[self._leg], self._legs[self._leg + 1 :]
        driving = float(leg.path.times[self._at])
        driving += sum(float(other.path.times[0]) for other in later)
        if self._model.n_base == 3:
            return driving
        turn = abs(wrap(float(leg.headings[self._at]) - wTb.heading))
        turn += sum(self._turns[self._leg + 1 :])
        return driving + turn / float(self._model.limits.base_twist[2])

    def _passed(self, leg: Leg, wTb: Pose2D) -> bool:
        """Whether the base is beyond the end of a leg, or as good as there."""
        x, y, way = leg.path.points[-1].tolist()
        left = (x - wTb.x) * cos(way) + (y - wTb.y) * sin(way)
        return self._at >= len(leg.headings) - 3 and left < _NEAR_END

    def _until_turned(self, leg: Leg, wTb: Pose2D) -> float:
        """Speed at which a base that turns on the way has turned where it gets narrow [m/s]."""
        narrow = np.flatnonzero(leg.narrow[self._at :])
        if not len(narrow):
            return inf
        first = int(narrow[0])
        turn = abs(wrap(float(leg.headings[self._at + first]) - wTb.heading))
        turning = turn / float(self._model.limits.base_twist[2])
        return inf if turn < 0.05 else max(0.05, (first * SPACING - 0.1) / turning)


def plain_lead(
    model: RobotModel, settings: ControllerSettings, wTb: Pose2D, goal: Pose2D, reverse: bool
) -> Lead:
    """The goal itself, as where nothing is in the way."""
    target = goal.relative_to(wTb)
    time = time_to_drive(model, settings.drive, target, reverse)
    return Lead(target, reverse, True, inf, time)


def trial(
    model: RobotModel,
    settings: ControllerSettings,
    start: Pose2D,
    goal: Pose2D,
    reverse: bool,
    velocities: Array,
) -> tuple[Array, float]:
    """Poses (N, 3) of a base that drives plainly from one pose to another, and its time [s].

    At first it has velocities (n_base,) [m/s, rad/s].
    """
    poses, pose, time = [start], start, 0.0
    base = model.description.base
    most = model.acceleration_limits[: model.n_base]
    command, moving = velocities, velocities
    for _ in range(_TRIAL_STEPS):
        target = goal.relative_to(pose)
        distance = hypot(target.x, target.y)
        if distance < _ARRIVED and abs(target.heading) < _ARRIVED:
            break
        dt = _TRIAL if distance > _TRIAL_NEAR else _TRIAL / 3.0
        wanted = drive_to(model, settings, target, reverse=reverse)
        command = np.clip(wanted, command - most * dt, command + most * dt)
        moving = moving + (1.0 - exp(-dt / base.lag)) * (command - moving)
        vx, vy, w = (base.axes @ moving * dt).tolist()
        middle = pose.heading + w / 2.0
        c, s = cos(middle), sin(middle)
        pose = Pose2D(pose.x + c * vx - s * vy, pose.y + s * vx + c * vy, pose.heading + w)
        poses.append(pose)
        time += dt
    return np.array(poses), time

"""Leads the base to a pose among static obstacles.

Where the direct way is free, the base takes it. Else it follows a planned path, with straight lines
out of and into places where it cannot turn. The path is planned anew when map or goal change, or
the base has left it.
"""

from collections.abc import Iterator
from math import cos, exp, hypot, inf, sin

import numpy as np

from config.arrays import Array
from config.planar import Pose2D, wrap
from controller.floor.base_drive import Lead, drive_to, time_to_drive
from controller.floor.floor_map import FloorMap
from controller.floor.path import SPACING
from controller.floor.route_planner import CLEARANCE, Leg, Planner, duration, turns
from controller.model import RobotModel
from controller.settings import ControllerSettings

_NEW_GOAL = (0.1, 0.2)  # a goal that has moved this far is a new goal [m, rad]
_LOST = 0.30  # distance to the path from which it is planned anew [m]
_CHECK = 100  # periods after which the direct way is checked anew
_NEAR_END = 0.015  # distance to its last point at which a leg ends [m]
_ARRIVED = 0.02  # error at the end of a simulated direct way that reaches the goal [m and rad]
_TRIAL = 0.15  # time step of the simulation of the direct way [s] ...
_TRIAL_NEAR = 1.0  # ... which is a third of it nearer to the goal than this [m]
_TRIAL_STEPS = 100
_WORTH_PLANNING = 1.0
"""Excess of the time of the direct way over its lower bound from which a path is planned [s]."""


class Route:
    """The route of one base to successive poses."""

    def __init__(self, model: RobotModel, settings: ControllerSettings) -> None:
        self._model = model
        self._settings = settings
        self.reset()

    def reset(self) -> None:
        """Forget the path."""
        self._room: FloorMap | None = None
        self._goal = Pose2D(inf, inf, inf)
        self._reverse = False
        self._legs: list[Leg] = []
        self._turns: list[float] = []
        self._leg = self._at = self._unchecked = 0
        self._plain = False
        self._why_not = ""
        self._plain_time = inf
        """Time of the direct way from where the path was planned; inf if it is not free [s]."""
        self._search: Iterator[list[Leg] | None] = iter(())
        self.way = np.zeros((0, 3))
        """(N, 3) base poses on the path; the same object as long as it is the same path."""

    def lead(self, room: FloorMap, mTb: Pose2D, goal: Pose2D, reverse: bool = False) -> Lead:
        """Where to drive now; `room` is the same object as long as the obstacles do not change."""
        if room.free:
            return plain_lead(self._model, mTb, goal, reverse)
        if room is not self._room or reverse != self._reverse or self._is_another(goal):
            self.reset()
            self._room, self._goal, self._reverse = room, goal, reverse
            self._start(room, mTb, goal)
        self._unchecked += 1
        if self._plain and self._unchecked > _CHECK:
            self._plain = self._trial_time(room, mTb, goal, inf) < inf
            if not self._plain:
                self._start(room, mTb, goal)
        if not self._plain and not self._legs:
            waiting = self._plan(mTb, goal)
            if waiting is not None:
                return waiting
        if self._plain:
            self.way = self._tried
            return plain_lead(self._model, mTb, goal, reverse)
        return self._follow(room, mTb, goal)

    def _is_another(self, goal: Pose2D) -> bool:
        far, turned = _NEW_GOAL
        moved = hypot(goal.x - self._goal.x, goal.y - self._goal.y)
        return not (moved < far and abs(wrap(goal.heading - self._goal.heading)) < turned)

    def _trial_time(self, room: FloorMap, mTb: Pose2D, goal: Pose2D, within: float) -> float:
        """Time of the direct way; inf unless it is free and ends `within` of the goal [s]."""
        self._unchecked = 0
        poses, time = trial(self._model, self._settings, mTb, goal, self._reverse)
        self._tried = np.concatenate([poses, [goal]])
        here, *clearances = room.stands_free(poses).tolist()
        (there,) = room.stands_free(goal).tolist()
        x, y, turn = goal.relative_to(Pose2D(*poses[-1].tolist()))
        arrives = hypot(x, y) < within and abs(turn) < within
        free = min(clearances, default=inf) >= min(CLEARANCE, here, there) - 0.005
        return time if arrives and free else inf

    def _is_plain(self, room: FloorMap, mTb: Pose2D, goal: Pose2D, left: float) -> bool:
        """Whether the direct way is about as fast as the rest of the path, `left` [s]."""
        self._plain = self._trial_time(room, mTb, goal, _ARRIVED) < left + _WORTH_PLANNING
        if self._plain:
            self._legs = []
        return self._plain

    def _start(self, room: FloorMap, mTb: Pose2D, goal: Pose2D) -> None:
        self._why_not = ""
        self._leg = self._at = 0
        self._legs = []
        self._plain_time = self._trial_time(room, mTb, goal, _ARRIVED)
        target = goal.relative_to(mTb)
        least = min(time_to_drive(self._model, target, back) for back in (False, True))
        self._plain = self._plain_time < least + _WORTH_PLANNING
        if not self._plain:
            self._search = Planner(self._model, room, self._reverse).search(mTb, goal)

    def _plan(self, mTb: Pose2D, goal: Pose2D) -> Lead | None:
        """Continue planning; the lead until there is a path."""
        legs = [] if self._why_not else next(self._search)
        if legs:
            rate = float(self._model.limits.base_twist[2])
            self._plain = self._plain_time <= duration(legs, mTb, goal, rate)
            self._legs = [] if self._plain else legs
            poses = [np.column_stack([leg.path.points[:, :2], leg.headings]) for leg in legs]
            self.way = np.concatenate([[mTb], *poses, [goal]])
            self._turns = turns(legs, mTb, goal)
            return None
        if legs is not None and self._plain_time < inf:
            self._plain = True
            return None
        if legs is not None and not self._why_not:
            start, end = (f"({pose.x:.2f}, {pose.y:.2f})" for pose in (mTb, goal))
            self._why_not = f"no way for the base from {start} to {end}"
        return Lead.nowhere(self._reverse, self._why_not)

    def _follow(self, room: FloorMap, mTb: Pose2D, goal: Pose2D) -> Lead:
        """The lead to a point ahead on the path."""
        leg = self._legs[self._leg]
        points = leg.path.points
        window = points[self._at : self._at + 12, :2]
        away = np.hypot(window[:, 0] - mTb.x, window[:, 1] - mTb.y)
        nearest = int(away.argmin())
        passed = range(self._at, self._at + nearest + 1)
        self._at += nearest
        if away[nearest] > _LOST:
            self._start(room, mTb, goal)
            return self.lead(room, mTb, goal, self._reverse)
        left = self._time_left(mTb)
        opens = bool(leg.narrow[passed[0]] and not leg.narrow[self._at])
        bends = any(bend in passed for bend in leg.path.bends)
        if (opens or bends) and self._is_plain(room, mTb, goal, left):
            return plain_lead(self._model, mTb, goal, self._reverse)
        if self._passed(leg, mTb):
            if self._leg + 1 == len(self._legs):
                self._plain, self._legs = True, []
                return plain_lead(self._model, mTb, goal, self._reverse)
            self._leg, self._at = self._leg + 1, 0
            self._is_plain(room, mTb, goal, self._time_left(mTb))
            return self.lead(room, mTb, goal, self._reverse)
        speed = float(leg.path.speeds[self._at])
        close = self._model.n_base == 3 or leg.narrow[self._at]
        ahead = (0.12 if close else 0.25) * (1.0 + speed)
        ahead = max(ahead, float(away[nearest]) + SPACING)
        rest = np.hypot(points[self._at :, 0] - mTb.x, points[self._at :, 1] - mTb.y)
        far = np.flatnonzero(rest >= ahead)
        index = self._at + int(far[0]) if len(far) else len(points) - 1
        beyond = 0.0 if len(far) else ahead - float(rest[-1])
        x, y, way = points[index].tolist()
        x, y = x + beyond * cos(way), y + beyond * sin(way)
        heading = float(leg.headings[self._at])
        target = Pose2D(x, y, heading).relative_to(mTb)
        if self._model.n_base == 3:
            speed = min(speed, self._until_turned(leg, mTb))
        return Lead(target, self._reverse != leg.backwards, False, speed, left)

    def _time_left(self, mTb: Pose2D) -> float:
        """Least time to the goal along the path [s]."""
        leg, later = self._legs[self._leg], self._legs[self._leg + 1 :]
        driving = float(leg.path.times[self._at])
        driving += sum(float(other.path.times[0]) for other in later)
        if self._model.n_base == 3:
            return driving
        turn = abs(wrap(float(leg.headings[self._at]) - mTb.heading))
        turn += sum(self._turns[self._leg + 1 :])
        return driving + turn / float(self._model.limits.base_twist[2])

    def _passed(self, leg: Leg, mTb: Pose2D) -> bool:
        """Whether the base has reached the end of a leg."""
        x, y, way = leg.path.points[-1].tolist()
        left = (x - mTb.x) * cos(way) + (y - mTb.y) * sin(way)
        return self._at >= len(leg.headings) - 3 and left < _NEAR_END

    def _until_turned(self, leg: Leg, mTb: Pose2D) -> float:
        """Speed at which a holonomic base has turned before the next narrow place [m/s]."""
        narrow = np.flatnonzero(leg.narrow[self._at :])
        if not len(narrow):
            return inf
        first = int(narrow[0])
        turn = abs(wrap(float(leg.headings[self._at + first]) - mTb.heading))
        turning = turn / float(self._model.limits.base_twist[2])
        return inf if turn < 0.05 else max(0.05, (first * SPACING - 0.1) / turning)


def plain_lead(model: RobotModel, mTb: Pose2D, goal: Pose2D, reverse: bool) -> Lead:
    """The lead on the direct way to a goal."""
    target = goal.relative_to(mTb)
    return Lead(target, reverse, True, inf, time_to_drive(model, target, reverse))


def trial(
    model: RobotModel,
    settings: ControllerSettings,
    start: Pose2D,
    goal: Pose2D,
    reverse: bool,
) -> tuple[Array, float]:
    """Poses (N, 3) of a base that sets out from rest for another pose, and its time there [s]."""
    poses, pose, time = [start], start, 0.0
    base = model.description.base
    most = model.acceleration_limits[: model.n_base]
    command = moving = np.zeros(model.n_base)
    for _ in range(_TRIAL_STEPS):
        target = goal.relative_to(pose)
        distance = hypot(target.x, target.y)
        if distance < _ARRIVED and abs(target.heading) < _ARRIVED:
            break
        dt = _TRIAL if distance > _TRIAL_NEAR else _TRIAL / 3.0
        wanted = drive_to(model, settings, target, reverse=reverse)
        command = np.clip(wanted, command - most * dt, command + most * dt)
        moving = moving + (1.0 - exp(-dt / base.lag)) * (command - moving)
        pose = pose.moved(*(base.axes @ moving * dt).tolist())
        poses.append(pose)
        time += dt
    return np.array(poses), time

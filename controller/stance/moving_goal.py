"""Following of a moving goal by a differential drive: sampled predictive control of the base.

A base that cannot drive sideways cannot keep its place below a goal that turns or moves across, so
the goal may be on any side of it, within reach, as long as joint 1 and the wrist stay off their
limits. Every tenth of a second a few hundred pairs of base velocities are rolled out with the
moving goal, and the one that is best for the arm is taken. So the base stops, backs or turns in
time to unwind an arm that a circling goal winds up.
"""

from functools import lru_cache
from itertools import product
from math import atan2, hypot
from typing import NamedTuple

import numpy as np
from pinocchio import SE3

from config.arrays import Mask
from config.planar import Pose2D, rotate, wrap
from config.poses import MapPose
from controller.command import Array, PoseGoal
from controller.model import RobotModel
from controller.servo import PoseError
from controller.settings import ControllerSettings
from controller.stance.stance import Stance

_HORIZON, _STEPS = 1.8, 6  # horizon [s] and its steps: half with one velocity, half with another
_AGAIN = 0.1  # time between two choices [s]
_SPEEDS = (-1.0, -0.4, 0.0, 0.5, 1.0, 1.5)
_LATER_SPEEDS = (-1.0, 0.0, 1.0)
"""Candidates of both speeds, as shares of the goal's, or of the largest while it is far away."""
_TURNS = (-1.0, -0.5, -0.2, 0.0, 0.2, 0.5, 1.0)
_LATER_TURNS = (-0.8, 0.0, 0.8)  # candidates of both turn rates, as shares of the largest
_NUDGES = np.concatenate([scale * np.kron(np.eye(4), [[1.0], [-1.0]]) for scale in (0.05, 0.2)])
"""Changes of the last choice among the candidates [m/s, rad/s, m/s, rad/s]."""
_SLOW = 0.02  # a goal slower than this has no course [m/s]
_TRUST, _TIGHTEST = 0.3, 1.0  # gain of the estimated turn rate of its course, and its limit [rad/s]
_FAR = 0.5  # distance beyond the preferred reach from which the goal is far away [m]
_REACH, _WOUND, _LEAN = 0.09, 1.0, 0.4
"""Deviations of equal cost: of the reach from the stance's [m], of joint 1 or the wrist from
their middle [rad], and of the turn of a hand that is not vertical from the stance's [rad]."""
_NEAREST, _FARTHEST = 0.3, 0.72  # distances to the arm's foot at which it is dexterous [m]
_LIMIT = 0.9  # distance of joint 1 and the wrist to their limits below which it costs [rad]
_STEEP = 30.0  # cost per radian of that, and per 10 cm outside the dexterous range
_CHANGE = (0.2, 0.05)  # cost of the square of a change of speed [s²/m²] and turn rate [s²/rad²]
_WEIGHT = 40.0  # weight of the base velocity in the QP when the tool has caught up ...
_ALONG, _IN_PLANE = 0.99, 0.5  # cosines of axes along the approach, and in the arm's plane
_CAUGHT_UP = 0.005  # ... to this [m]; it falls as 1/|e|, like the weight of the tool
MIN_TRACKING = 4.0  # weight of the twist at s = 1: a tool that cannot keep up stays upright


def follow_weight(distance: float) -> float:
    """Weight of the base velocity at a distance of the end effector to the goal [m]."""
    return _WEIGHT * _CAUGHT_UP / max(distance, _CAUGHT_UP)


def is_followed(model: RobotModel) -> bool:
    """Whether the first turn of the arm is about the vertical, and the last about the approach."""
    lTe = model.description.arm.lTh * model.description.gripper.hTe
    turns = not model.description.arm.slides[-1] and abs(lTe.rotation[2, 2]) > _ALONG
    return model.n_base == 2 and model.description.swivel is not None and turns


def elbow_upright(model: RobotModel, q: Array) -> Array:
    """(j,) error to the posture in which those two joints alone turn the hand about the vertical.

    The joints between them whose axes lie in the arm's plane when it is ready are as they are then.
    """
    return np.where(_in_plane(model), model.description.arm.ready - q, 0.0)


@lru_cache(maxsize=4)
def _in_plane(model: RobotModel) -> Mask:
    links = model.link_poses(SE3.Identity(), model.description.arm.ready)[1:-1]
    in_plane = np.array([abs(link.rotation[1, 2]) < _IN_PLANE for link in links])
    in_plane[[0, -1]] = False
    return in_plane


class _Arm(NamedTuple):
    """The goal and the arm that reaches it, seen from the present base."""

    x: float  # of the goal in the base [m]
    y: float
    bearing: float  # of the goal, seen from the foot of the arm [rad]
    first: float  # joint 1 at the goal [rad]
    last: float  # joint 7 at the goal, if the hand is vertical [rad]
    lean: float  # turn of the hand relative to the bearing, minus that of the stance [rad]
    upright: float  # 1 if the hand points up, -1 if it points down, 0 if it is level


class MovingGoalFollower:
    """Chooses the velocities of a differential drive that follows a moving goal."""

    def __init__(self, model: RobotModel, settings: ControllerSettings) -> None:
        self._model = model
        self._periods = max(1, round(_AGAIN / settings.period))
        limits = model.limits
        self._reverse, self._turn = float(limits.base_reverse), float(limits.base_twist[2])
        assert model.description.swivel is not None
        self._swivel = model.description.swivel
        ends = np.minimum(limits.q_max, -limits.q_min)
        self._joints = ends[[self._swivel.joint, -1]] - _LIMIT
        ways = product(_SPEEDS, _TURNS, _LATER_SPEEDS, _LATER_TURNS)
        self._ways = np.array(list(ways))
        self.reset()

    def reset(self) -> None:
        """Forget the last choice."""
        self._choice = np.zeros(4)
        self._left = 0
        self._course: float | None = None
        self._bend = 0.0

    def __call__(
        self, stance: Stance, goal: PoseGoal[MapPose], error: PoseError, mTb: Pose2D, q: Array
    ) -> Array:
        """Velocities (2,) of the base for an error in base axes [rad/s, m/s]."""
        if not self._left:
            self._choice = self._choose(stance, goal, error, mTb, q)
            self._left = self._periods
        self._left -= 1
        return self._choice[[1, 0]]

    def _choose(
        self, stance: Stance, goal: PoseGoal[MapPose], error: PoseError, mTb: Pose2D, q: Array
    ) -> Array:
        """The best speeds and turn rates (4,): those now, and those later."""
        assert goal.twist is not None
        self._watch_course(goal.twist)
        foot = self._swivel.pivot
        arm = self._arm(stance, goal, error, mTb, q)
        liked = hypot(*(stance.bTe.translation - foot)[:2].tolist())
        far = hypot(arm.x - foot[0], arm.y - foot[1]) - liked > _FAR
        top = min(float(self._model.limits.base_twist[0]), goal.speed)
        speed = top if far else min(top, hypot(goal.twist[0], goal.twist[1]))
        ways = self._ways * [speed, self._turn, speed, self._turn]
        ways = np.vstack([self._choice, self._choice + _NUDGES, ways])
        ways = np.clip(ways, [-self._reverse, -self._turn] * 2, [top, self._turn] * 2)
        costs = self._costs(ways, arm, goal, mTb, liked)
        best: Array = ways[int(costs.argmin())]
        return best

    def _watch_course(self, twist: Array) -> None:
        """Estimate how fast the course of the goal turns."""
        before, self._course = self._course, None
        if hypot(twist[0], twist[1]) < _SLOW:
            self._bend = 0.0
            return
        self._course = atan2(twist[1], twist[0])
        if before is not None:
            turning = wrap(self._course - before) / _AGAIN
            self._bend += _TRUST * (min(_TIGHTEST, max(-_TIGHTEST, turning)) - self._bend)

    def _arm(
        self, stance: Stance, goal: PoseGoal[MapPose], error: PoseError, mTb: Pose2D, q: Array
    ) -> _Arm:
        gx, gy, _ = goal.target.translation.tolist()
        at = Pose2D(gx, gy, 0.0).relative_to(mTb)
        ex, ey, _ = error.translation_vector.tolist()
        fx, fy, _ = self._swivel.pivot.tolist()
        bearing = atan2(at.y - fy, at.x - fx)
        swing = wrap(bearing - atan2(at.y - ey - fy, at.x - ex - fx))
        upright = float(goal.target.rotation[2, 2])
        turn = float(error.rotation_vector[2])
        base = stance.base_for(goal.target)
        sx, sy, _ = stance.bTe.translation.tolist()
        lean = wrap(base.heading - mTb.heading - (bearing - atan2(sy - fy, sx - fx)))
        swivel = self._swivel.sign * float(q[self._swivel.joint])
        first, last = swivel + swing, float(q[-1]) + upright * (turn - swing)
        return _Arm(at.x, at.y, bearing, first, last, lean, upright)

    def _costs(
        self, ways: Array, arm: _Arm, goal: PoseGoal[MapPose], mTb: Pose2D, liked: float
    ) -> Array:
        """Costs (N,) of candidates (N, 4)."""
        assert goal.twist is not None
        fx, fy, _ = self._swivel.pivot.tolist()
        step = _HORIZON / _STEPS
        forward, turning = self._model.acceleration_limits[[1, 0]] * step
        vx, vy = rotate(-mTb.heading, *goal.twist[:2].tolist())
        gx, gy = arm.x, arm.y
        v, w = np.full(len(ways), self._choice[0]), np.full(len(ways), self._choice[1])
        x, y, heading, costs = (np.zeros(len(ways)) for _ in range(4))
        costs += _CHANGE[0] * (ways[:, 0] - v) ** 2 + _CHANGE[1] * (ways[:, 1] - w) ** 2
        for number in range(1, _STEPS + 1):
            now = 0 if 2 * number <= _STEPS else 2
            v = v + np.clip(ways[:, now] - v, -forward, forward)
            w = w + np.clip(ways[:, now + 1] - w, -turning, turning)
            middle = heading + w * (step / 2.0)
            x, y = x + v * np.cos(middle) * step, y + v * np.sin(middle) * step
            heading = heading + w * step
            gx, gy = gx + 0.5 * vx * step, gy + 0.5 * vy * step
            vx, vy = rotate(self._bend * step, vx, vy)
            gx, gy = gx + 0.5 * vx * step, gy + 0.5 * vy * step
            dx, dy = rotate(-heading, gx - x, gy - y)
            dx, dy = dx - fx, dy - fy
            swing = wrap(np.arctan2(dy, dx) - arm.bearing)
            twisted = float(goal.twist[5]) * step * number - heading - swing
            cost = self._discomfort(arm, np.hypot(dx, dy), liked, swing, twisted)
            costs += cost if number < _STEPS else 2.0 * cost
        return costs

    def _discomfort(
        self, arm: _Arm, reach: Array, liked: float, swing: Array, twisted: Array
    ) -> Array:
        """Costs of the arm (N,) with the goal at distances `reach` (N,) from its foot [m].

        Joint 1 turns by `swing` (N,) from now on, the hand by `twisted` (N,) against that [rad].
        """
        first, last = arm.first + swing, arm.last + arm.upright * twisted
        level = (1.0 - arm.upright**2) * (arm.lean + twisted) ** 2
        cost = ((reach - liked) / _REACH) ** 2 + (first**2 + last**2) / _WOUND**2 + level / _LEAN**2
        beyond = np.maximum(0.0, np.abs(first) - self._joints[0])
        beyond += np.maximum(0.0, np.abs(last) - self._joints[1])
        beyond += 10.0 * np.maximum(0.0, np.maximum(_NEAREST - reach, reach - _FARTHEST))
        result: Array = cost + _STEEP * beyond
        return result

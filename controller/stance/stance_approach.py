"""Approach of a stance: where base and arm are led now, and how strongly.

Usually base and arm move to the stance together. Where the arm would hit an obstacle on the way, it
takes its transport posture; the base then drives to the dock of the stance, waits there until the
arm has unfolded, and drives straight in.
"""

from enum import Enum, auto
from math import hypot

import numpy as np

from config.planar import Pose2D, rotate
from config.poses import MapPose
from controller.command import Array, PoseGoal
from controller.floor.base_drive import drive_along
from controller.floor.route import Route
from controller.model import RobotModel
from controller.servo import PoseError
from controller.settings import ControllerSettings
from controller.stance.bias import Remaining, StanceBias
from controller.stance.dexterity import dexterity
from controller.stance.finder import StanceFinder
from controller.stance.moving_goal import (
    MIN_TRACKING,
    MovingGoalFollower,
    elbow_upright,
    follow_weight,
    is_followed,
)
from controller.stance.stance import Stance
from controller.stance.transport_posture import TransportPosture

_AT_DOCK = 0.1  # the base drives in when nearer than this to the line from the dock [m and rad] ...
_TURNED = 1.0  # ... or, past its middle, turned by less than this [rad] ...
_UNFOLDED = 0.5  # ... and when no joint is farther than this from the posture of the stance [rad]
_PAST = 0.05  # it backs out to a dock that it has passed by more than this [m]
_FAST, _SLOWEST = 2.0, 4.0
"""A posture draws an arm that is slower than this so much more, at most by this factor, that hand
and manipulability do not hold it back [rad/s]."""
_LONGEST_FOLD = 100.0  # largest time that the arm adapts to; infinite without a path [s]


class Phase(Enum):
    """How base and arm move to a stance."""

    TOGETHER = auto()  # each on its own way, perhaps with the arm in its transport posture
    TO_DOCK = auto()
    BACK_TO_DOCK = auto()  # out of the place, since the base has passed the dock
    GOES_IN = auto()  # from the dock, the arm in its posture


_DOCKS = (Phase.TO_DOCK, Phase.BACK_TO_DOCK)


class Approach:
    """The approach of one robot to successive stances."""

    def __init__(
        self, model: RobotModel, settings: ControllerSettings, finder: StanceFinder
    ) -> None:
        assert settings.guidance is not None
        self._model, self._settings = model, settings
        self._guidance = settings.guidance
        self._finder = finder
        self.route = Route(model, settings)
        self._transport = TransportPosture(model, settings.guidance.posture_time)
        self._follower = MovingGoalFollower(model, settings) if is_followed(model) else None
        self._has_choice = dexterity(model.description).has_choice
        self.reset()

    def reset(self) -> None:
        """Forget stance and goal."""
        self.restart()
        if self._follower is not None:
            self._follower.reset()

    def restart(self) -> None:
        """Approach the stance anew."""
        self._stance: Stance | None = None
        self.phase = Phase.TOGETHER
        self._transport.reset()

    def base_follows(self, goal: PoseGoal[MapPose]) -> bool:
        """Whether the base follows a goal because it moves."""
        return goal.is_moving and not goal.straight and self._follower is not None

    def remaining(
        self,
        stance: Stance,
        base: Pose2D,
        goal: PoseGoal[MapPose],
        distance: float,
        mTb: Pose2D,
        q: Array,
    ) -> Remaining:
        """The remaining motion, and where it leads now.

        `base` is the base pose of the stance, `distance` that of the end effector to the goal,
        rotation included [m]; `q` are (j,) joint positions [rad]. On the way to a moving goal there
        is no transport posture.
        """
        if self._model.description.stands_still:
            base = mTb
        if stance is not self._stance or goal.is_moving:
            self._stance, self.phase = stance, Phase.TOGETHER
        if self.phase in _DOCKS and _is_docked(stance, base, mTb, q):
            self.phase = Phase.GOES_IN
        dock = stance.dock if self.phase in _DOCKS else None
        if dock is not None and _is_past(dock, base, mTb):
            self.phase = Phase.BACK_TO_DOCK
        target = base if dock is None else base.moved(dock)
        reverse = stance.reverse != (self.phase is Phase.BACK_TO_DOCK)
        lead = self.route.lead(self._finder.floor, mTb, target, reverse)
        joint_error, transport = stance.q - q, None
        max_joint_error, joint_time = self._left(joint_error)
        if not goal.is_moving and self.phase is not Phase.GOES_IN:
            way, space, waits = self.route.way, self._finder.space, dock is not None
            times = lead.time_left, joint_time / self._guidance.joint_speed
            transport = self._transport.posture(space, way, mTb, q, stance, times, waits=waits)
            if transport is not None and stance.dock is not None and dock is None:
                self.phase = Phase.TO_DOCK
        if dock is not None:
            straight = abs(dock) / float(self._model.limits.base_twist[0])
            lead = lead._replace(time_left=lead.time_left + straight)
        if transport is not None:
            joint_error = transport - q
            max_joint_error, joint_time = self._left(joint_error)
        return Remaining(
            distance,
            base_target=lead.target if lead.final else target.relative_to(mTb),
            lead=lead,
            joint_error=joint_error,
            max_joint_error=max_joint_error,
            joint_time=joint_time,
            in_transport=transport is not None,
            docks=dock is not None,
        )

    def bias(
        self,
        remaining: Remaining,
        stance: Stance,
        goal: PoseGoal[MapPose],
        error: PoseError,
        mTb: Pose2D,
        q: Array,
        *,
        detour: bool,
    ) -> StanceBias:
        """The bias of one period; on a `detour` the end effector waits.

        `error` is that of the end effector, `q` are (j,) joint positions [rad].
        """
        # An arm with few postures for a pose must be in the right one before the hand leads.
        g, to_the_end = self._guidance, detour or not self._has_choice
        blend = remaining.blend(g, to_the_end=to_the_end)
        min_tracking = 0.0 if detour or remaining.hand_waits else g.min_tracking * blend
        base_share = blend
        if goal.is_moving:
            min_tracking = MIN_TRACKING * blend
            base_share = max(blend, follow_weight(remaining.distance))
        base_weight = base_share * g.base_weight
        with_base = g.posture_time * min(remaining.lead.time_left, _LONGEST_FOLD)
        duration = max(
            1.0 / g.posture_rate,
            0.0 if remaining.in_transport else with_base,
            remaining.joint_time / g.joint_speed,
        )
        joint_velocity = remaining.joint_error / duration
        if self._follower is not None and self.base_follows(goal):
            posture_weight = g.posture_weight
            upright = elbow_upright(self._model, q)  # in a second
            joint_velocity = joint_velocity * blend + (1.0 - blend) * upright
            base_velocity = self._follower(stance, goal, error, mTb, q)
        else:
            slowness = _FAST * remaining.joint_time / max(remaining.max_joint_error, 1e-9)
            slowness = min(max(1.0, slowness), _SLOWEST)
            posture_weight = slowness * g.posture_weight * max(blend, g.min_posture)
            base_velocity = drive_along(self._model, self._settings, remaining.lead, goal.speed)
            if goal.twist is not None:
                along = rotate(-mTb.heading, *goal.twist[:2])
                base_velocity += self._model.description.base.axes[:2].T @ along
        pull = np.concatenate([base_weight * base_velocity, posture_weight * joint_velocity])
        return StanceBias(blend, min_tracking, base_weight, base_velocity, posture_weight, pull)

    def _left(self, joint_error: Array) -> tuple[float, float]:
        """The largest of joint errors (7,) [rad], and the time for them at full speed [s]."""
        size = np.abs(joint_error)
        return max(size.tolist()), max((size / self._model.limits.qd).tolist())


def _is_docked(stance: Stance, base: Pose2D, mTb: Pose2D, q: Array) -> bool:
    """Whether the base is on the line from the dock and the arm in its posture."""
    assert stance.dock is not None
    x, y, turn = mTb.relative_to(base)
    share = min(1.0, max(0.0, x / stance.dock))
    near = hypot(x - share * stance.dock, y) < _AT_DOCK
    turned = _AT_DOCK if share > 0.5 else _TURNED
    return near and abs(turn) < turned and bool(np.abs(stance.q - q).max() < _UNFOLDED)


def _is_past(dock: float, base: Pose2D, mTb: Pose2D) -> bool:
    """Whether the base stands between the dock and its place."""
    x, y, turn = mTb.relative_to(base)
    return abs(x) < abs(dock) - _PAST and abs(y) < _AT_DOCK and abs(turn) < _TURNED

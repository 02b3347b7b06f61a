"""Motions that leaves share: approach a goal, back off, rise; and when a motion is stuck."""

from collections.abc import Callable
from dataclasses import replace
from math import degrees, hypot, inf

import numpy as np
from pinocchio import SE3
from py_trees.common import Status

from behaviours.core.context import Context
from behaviours.core.directions import way_out
from behaviours.core.leaf import Leaf
from config.poses import OdometryPose
from controller import Array, BaseGoal, Command, MotionGoal, PoseGoal, PostureGoal, StepReport

METRES_PER_RADIAN = 0.3  # weight of a rotation error: about the length of the hand [m/rad]
_STEP = 0.005  # a smaller improvement does not count [m, s or rad]
_AT_REST = 0.03  # a slower robot stands still [m/s and rad/s]
_PATIENCE = 2.5  # without improvement, while the robot stands still [s]
_DETOUR_PATIENCE = 12.0  # while it moves: a base that turns brings the hand no nearer at first [s]
_STRAIGHT_PATIENCE = 2.0  # while the hand is to go straight [s]
_PENDING = 0.02  # the map still moves there: no goal on it is reached before [m]
_LONGEST_TICK = 0.1  # a longer time between two ticks counts as this [s]
IN_THE_WAY = 0.05  # furniture nearer than this blocks arm and base [m]
_BACK_OFF = 0.3  # how far the base backs off [m]
AWAY_SPEED = 0.15  # of base and hand away from a contact [m/s]
_RISE_SPEED = 0.3  # after a fault, among furniture [m/s]
_RISE_TOLERANCE = 0.03  # [m]
_BACK_TOLERANCE = 0.01  # of the hand that goes back where it came from [m]
_ASTRAY = 0.012  # a hand this far beside its way down goes back over the grasp [m] ...
_ASTRAY_ABOVE = 0.02  # ... unless it is nearer than this to the grasp [m]
_BACKWARDS = np.array([-1.0, 0.0])


class Progress:
    """Detects that a motion makes no progress.

    A motion makes progress while hand, base or arm come nearer to their references than ever
    before. Without progress it is stuck once the robot has stood still for `rest`, or has moved for
    12 s (2 s on a straight path, which has no detour). Only time between two calls counts, and
    not while the robot waits for a moving obstacle. An unreachable goal is stuck at once.

    Args:
        context: shared by the leaves.
        straight: whether the goal is approached on a straight line.
        rest: how long the robot may stand still [s].
    """

    def __init__(
        self, context: Context, *, straight: bool = False, rest: float = _PATIENCE
    ) -> None:
        self._context = context
        self._patience = _STRAIGHT_PATIENCE if straight else _DETOUR_PATIENCE
        self._rest = rest
        self._best: tuple[float, ...] = inf, inf, inf
        self._last = context.clock.now()
        self._without = self._at_rest = 0.0
        self.because = ""
        """`: ` and why the goal is unreachable, to append to a message; else empty."""

    def is_stuck(self, report: StepReport) -> bool:
        """Call once a tick, with the report about the goal of the last one."""
        if report.unreachable:
            self.because = f": {report.unreachable}"
            return True
        now = self._context.clock.now()
        passed = min(now - self._last, _LONGEST_TICK)
        self._last = now
        if report.waits_for:
            passed = 0.0
        turn = METRES_PER_RADIAN * report.orientation_error
        remaining = report.position_error + turn, report.base_time, report.posture_error
        self._without += passed
        self._at_rest = 0.0 if self._moves else self._at_rest + passed
        both = zip(remaining, self._best, strict=True)
        if any(left < best - _STEP for left, best in both):
            self._best = tuple(map(min, remaining, self._best))
            self._without = self._at_rest = 0.0
        return self._at_rest > self._rest or self._without > self._patience

    @property
    def _moves(self) -> bool:
        state = self._context.state
        fastest = max(np.abs(state.qd).max(), np.abs(state.base_twist).max())
        return bool(fastest > _AT_REST)


class Approach:
    """A motion to one goal.

    Args:
        leaf: sets the goal and gets the feedback message.
        goal: where to go; a function is asked every tick, as a place on the map is where the newest
            estimate of the localisation has it.
        target: name of the goal in messages.
        timeout: fail after this [s].
    """

    def __init__(
        self,
        leaf: Leaf,
        goal: MotionGoal[OdometryPose] | Callable[[], MotionGoal[OdometryPose]],
        target: str,
        timeout: float,
    ) -> None:
        self._leaf, self._goal, self._target, self._timeout = leaf, goal, target, timeout
        self._begun = leaf.context.clock.now()
        self._progress = Progress(leaf.context)
        self._set_out = False
        self.is_blocked = False
        """Whether it has ended because the robot got stuck beside an obstacle."""

    def tick(self) -> Status:
        """SUCCESS at the goal, FAILURE on a fault, when stuck and after the timeout.

        It stops and waits while it is not certain where the base is on the map.
        """
        leaf = self._leaf
        if fault := leaf.fault():
            return leaf.failure(fault)
        if leaf.context.now.lost:
            return leaf.failure(f"{leaf.context.now.relocalised}: it is not certain where it is")
        if doubt := leaf.context.localisation.doubt:
            self._set_out = False
            unsure = f"{doubt}: it is not certain where it is"
            return self._late(unsure) if self._is_late else leaf.running(f"waiting: {unsure}")
        goal = self._goal() if callable(self._goal) else self._goal
        report = leaf.pursue(goal, self._target)
        if report is None or not self._set_out:  # then it is about some other goal
            self._set_out = True
            return leaf.running(f"setting out for {self._target}")
        here = leaf.context.localisation
        if report.arrived and here.agreement.since is None and here.pending <= _PENDING:
            return leaf.success(f"at {self._target}")
        if report.arrived and not self._is_late:
            return leaf.running("there, but what is in sight is not where the map has it")
        if report.unreachable:
            leaf.out_of_reach = True
            return leaf.failure(f"cannot get to {self._target}: {report.unreachable}")
        remaining = f"{degrees(report.orientation_error):.0f}° to go"
        if not isinstance(goal, PostureGoal):
            remaining = f"{report.position_error:.2f} m, {remaining}"
        if self._is_late:
            return self._late(remaining)
        if self._progress.is_stuck(report):
            self.is_blocked = report.clearance < IN_THE_WAY
            return leaf.failure(f"stuck on the way to {self._target}: {remaining}")
        return leaf.running(remaining)

    @property
    def _is_late(self) -> bool:
        return self._leaf.context.clock.now() - self._begun > self._timeout

    def _late(self, why: str) -> Status:
        return self._leaf.failure(f"not at {self._target} after {self._timeout:g} s: {why}")


class BackOff:
    """The base drives a short distance, the arm held.

    Args:
        leaf: sets the goal.
        away: (2,) unit vector in the base frame: the direction.
        speed: largest speed [m/s].
    """

    def __init__(self, leaf: Leaf, away: Array = _BACKWARDS, speed: float = inf) -> None:
        self._leaf = leaf
        way = SE3(np.eye(3), np.array([*(_BACK_OFF * away), 0.0]))
        oTb = leaf.context.state.oTb * way
        self._goal = BaseGoal(target=oTb, reverse=bool(away[0] < 0.0), speed=speed)
        self._progress = Progress(leaf.context)

    def tick(self) -> bool:
        """Whether it has ended: arrived or stuck."""
        report = self._leaf.pursue(self._goal, "back off")
        return report is not None and (report.arrived or self._progress.is_stuck(report))


def straight_out(
    context: Context, distance: float, speed: float, next_goal: SE3 | None = None
) -> PoseGoal[OdometryPose]:
    """The goal of a hand that rises from its present pose, or goes back the way it came.

    Args:
        context: shared by the leaves.
        distance: how far it goes [m].
        speed: of the hand [m/s].
        next_goal: the next pose of the end effector in odometry; the base sets out for it.
    """
    here = context.oTe
    return PoseGoal(
        target=SE3(here.rotation, here.translation + distance * way_out(here.rotation)),
        speed=speed,
        position_tolerance=_RISE_TOLERANCE,
        straight=True,
        hand_may_touch=True,
        next_goal=next_goal,
    )


class Rise:
    """The hand leaves slowly, as furniture may be near, upwards or the way it came.

    Args:
        leaf: sets the goal.
        height: how far it goes [m].
        back: where the hand goes first, in odometry: away from a contact.
    """

    def __init__(self, leaf: Leaf, height: float, back: SE3 | None = None) -> None:
        self._leaf, self._height = leaf, height
        self._is_back = back is None
        self._go(back)

    def tick(self) -> bool:
        """Whether it has ended: the hand is up, or stuck."""
        report = self._leaf.pursue(self._goal, "rise" if self._is_back else "back")
        if report is None:
            return False
        is_there = report.position_error <= self._goal.position_tolerance
        if not (is_there or self._progress.is_stuck(report)):
            return False
        if not self._is_back:
            self._is_back = True
            self._go()
            return False
        return True

    def _go(self, back: SE3 | None = None) -> None:
        context = self._leaf.context
        self._goal = straight_out(context, self._height, _RISE_SPEED)
        if back is not None:
            tolerance = _BACK_TOLERANCE
            self._goal = replace(
                self._goal, target=back, speed=AWAY_SPEED, position_tolerance=tolerance
            )
        self._progress = Progress(context, straight=True)


def over_grasp(oTg: OdometryPose, context: Context) -> SE3:
    """The goal of a hand on its way down to a grasp: the grasp, or above it if it has strayed."""
    x, y, z = oTg.actInv(context.oTe.translation)
    if hypot(x, y) <= _ASTRAY or -z <= _ASTRAY_ABOVE:
        return oTg
    return oTg * SE3(np.eye(3), np.array([0.0, 0.0, z]))


def hand_twist(context: Context) -> Array:
    """(6,) of the hand, which base and arm move, in base axes, as read this tick [m/s, rad/s]."""
    model, state = context.model, context.state
    moves = Command(base_twist=state.base_twist, qd=state.qd)
    twist: Array = model.kinematics(state.q).J @ model.velocities(moves)
    return twist


def closing_in_speed(context: Context) -> float:
    """How fast the hand moves against its way out, as read this tick [m/s]."""
    out = way_out(context.model.bTe(context.state.q).rotation)
    return -float(hand_twist(context)[:3] @ out)

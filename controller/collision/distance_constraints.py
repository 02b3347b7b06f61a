"""Rows of the QP that keep shapes apart: velocity dampers that can always be braked.

NEO (Haviland and Corke, RA-L 2021), after Faverjon and Tournassoud (ICRA 1987), lets a distance
shrink in proportion to itself,

    ḋ = r q̇ + v_o >= -ξ (d - d_s) / (d_i - d_s),

with r = nᵀ J of the nearest points and v_o the obstacle's own share. A robot with limited
acceleration that follows its commands late cannot keep that at any speed. Here the speed allowed
at a distance is the one from which the robot still stops before d_s,

    v L + v² / 2a = d - d_s,    so    v = sqrt((a L)² + 2 a (d - d_s)) - a L,

with L the time that passes before it brakes, and a what its acceleration limits allow along r. For
small distances that is the damper of NEO with ξ / (d_i - d_s) = 1 / L.

Base and arm follow a command q̇ with lags τ: beside what the command itself does to the distance, it
changes by rᵀ τ (v - q̇) until they have caught up, v being how fast they move now. So d - d_s above
includes that; else a row can hold in command while the fast arm moves before the slow base.
"""

from __future__ import annotations

import numpy as np

from controller.collision.collision_model import PairKind
from controller.collision.proximity import Distances, Ranges
from controller.command import Array, MotionGoal, PoseGoal
from controller.model import RobotModel
from controller.qp_solver import Rows
from controller.settings import CollisionSettings, ControllerSettings

SLACK_COSTS = np.array([1e4, 1e4, 1e4, 1e4, 1e4, 1e3, 3e3, 1.5e3])
"""By `PairKind`: what does not move is not hit to give way to what does, and who has looked ahead
knows better than the distance of now."""


class DistanceConstraints:
    """Makes rows of distances, and keeps the velocities that the robot really has.

    Args:
        model: the robot.
        settings: of the controller.
        collision: when, and how strongly.
    """

    def __init__(
        self, model: RobotModel, settings: ControllerSettings, collision: CollisionSettings
    ) -> None:
        self._settings = collision
        self._acceleration = model.acceleration_limits
        self._turns = model.description.base.axes[2] != 0.0
        robot = model.description
        self._lag = np.concatenate(
            [np.full(model.n_base, robot.base.lag), np.full(len(robot.arm.joints), robot.arm.lag)]
        )
        self._share = 1.0 - np.exp(-settings.period / self._lag)
        self.velocities = np.zeros(model.n)
        """(n,) that base and arm have now, as far as their lags tell."""
        self._last = np.zeros(model.n)
        wait = collision.delay_periods * settings.period
        self._delay = np.full(len(PairKind), robot.base.lag + wait)
        self._delay[PairKind.SELF] = robot.arm.lag + wait
        deceleration = np.full(len(PairKind), _LEAST_DECELERATION)
        deceleration[PairKind.SELF] = collision.max_deceleration
        drive = self._acceleration[: model.n_base][~self._turns]
        braking = collision.braking * float(drive.min())
        deceleration[PairKind.BASE] = min(_LEAST_DECELERATION, braking)
        most = np.full(len(PairKind), collision.influence_distance)
        most[PairKind.SELF] = collision.self_influence_distance
        self._far = np.full(len(PairKind), collision.stop_distance)
        self._far[PairKind.SELF] = collision.near_stop_distance
        self._near = np.full(len(PairKind), collision.near_stop_distance)
        self._touching = self._near.copy()
        self._touching[PairKind.PALM] = collision.palm_stop_distance
        """Distances to stop at, by `PairKind` [m]."""
        self.ranges = Ranges(collision.stop_distance, self._delay, deceleration, most)
        """When a pair matters."""

    def follow(self, last: Array) -> None:
        """Note what was applied in the last period, (n,): base and arm follow it with their lag."""
        self._last = last
        self.velocities += self._share * (last - self.velocities)

    def rows(
        self, distances: Distances, bounds: tuple[Array, Array], goal: MotionGoal | None
    ) -> Rows | None:
        """The rows that can bind within the bounds; None if there are none.

        Args:
            distances: pairs of shapes that are near each other.
            bounds: lower and upper bounds (n,) of the velocities.
            goal: how near the robot may come. Without one it comes to rest: it does not come
                nearer to anything, but does not make way either.
        """
        if not len(distances.d):
            return None
        allowed, slope = self._allowed(distances, self._stop(goal))
        drift = distances.drift
        if goal is None:  # standing still keeps every row
            allowed, drift = np.maximum(allowed, 0.0), np.maximum(drift, 0.0)
            slope = np.zeros(len(slope))
        # Linear in the command at the last one: the base, which follows late, gives way late, too.
        late = distances.rows * self._lag
        A = distances.rows - slope[:, None] * late
        least = -allowed - slope * (late @ self._last) - drift
        worst = np.minimum(A * bounds[0], A * bounds[1]).sum(axis=1)
        binds = worst < least
        if not binds.any():
            return None
        return Rows(A[binds], least[binds], distances.kind[binds])

    def _stop(self, goal: MotionGoal | None) -> Array:
        if goal is None:
            return self._near
        if not isinstance(goal, PoseGoal):
            return self._far
        if goal.hand_may_touch:
            return self._touching
        return self._near if goal.straight else self._far

    def _allowed(self, distances: Distances, stop: Array) -> tuple[Array, Array]:
        """How fast each distance may shrink (K,) [m/s], and by how much more with more room [1/s].

        Where that is negative it must grow.
        """
        s, rows, kind = self._settings, distances.rows, distances.kind
        # The lag alone never turns room into none.
        room = distances.d - stop[kind]
        ahead = self._lag * (self.velocities - self._last)  # until they have caught up [m or rad]
        room = np.minimum(room + rows @ ahead, np.maximum(room, 0.0) + _MOST_GAINED)

        braking = s.braking * self._braking(np.abs(rows) * self._acceleration)
        deceleration = np.minimum(np.maximum(braking, s.min_deceleration), s.max_deceleration)
        late = deceleration * self._delay[kind]
        root = np.sqrt(late * late + 2.0 * deceleration * np.maximum(room, 0.0))
        back = np.maximum(s.return_gain * room, -s.return_speed)
        return np.where(room < 0.0, back, root - late), deceleration / root

    def _braking(self, shares: Array) -> Array:
        """Deceleration (K,) that the degrees of freedom have together, of shares (K, n).

        The base alone brakes by driving or by turning, whichever is more: a turn that makes up for
        speed brings its next corner there.
        """
        base = shares[:, : len(self._turns)]
        turn, drive = base[:, self._turns].sum(axis=1), base[:, ~self._turns].sum(axis=1)
        arm = shares[:, len(self._turns) :].sum(axis=1)
        both: Array = np.where(arm > 0.0, turn + drive + arm, np.maximum(turn, drive))
        return both


_LEAST_DECELERATION = 1.0
"""Of base and arm, to judge which pairs matter; where the limits of an arm allow less, the pair is
slower than is assumed of it, too. A heavy base is not [m/s^2]."""
_MOST_GAINED = 0.05
"""By how much the lag may make a distance larger than it is [m]."""

"""Distance constraints of the QP: velocity dampers from which the robot can always brake.

NEO (Haviland and Corke, RA-L 2021), after Faverjon and Tournassoud (ICRA 1987), lets a distance
shrink in proportion to itself,

    ḋ = r q̇ + v_o >= -ξ (d - d_s) / (d_i - d_s),

with r = nᵀ J of the nearest points and v_o the obstacle's own velocity. A robot with limited
acceleration and lag cannot keep that at any speed. Here the speed allowed at a distance is the one
from which the robot still stops before d_s,

    v L + v² / 2a = d - d_s,    so    v = sqrt((a L)² + 2 a (d - d_s)) - a L,

with L the delay before it brakes, and a the deceleration along r within the acceleration limits.
For small distances that is the damper of NEO with ξ / (d_i - d_s) = 1 / L.

Base and arm follow a command q̇ with lags τ: until they have caught up, the distance also changes by
rᵀ τ (v - q̇), v being their present velocities. d - d_s above includes that.
"""

from math import inf
from typing import NamedTuple

import numpy as np

from config.arrays import Mask
from config.poses import MapPose
from controller.collision.collision_model import CollisionModels, PairKind
from controller.collision.moving_obstacles import MovingObstacleAvoidance
from controller.collision.proximity import Distances, Proximity, Ranges
from controller.command import Array, MotionGoal, PoseGoal
from controller.floor.floor_map import FloorMap
from controller.limits import Constraints
from controller.model import Lag, RobotModel
from controller.qp_solver import Rows
from controller.settings import CollisionSettings
from controller.situation import Situation
from controller.surroundings import Surroundings

_ASSUMED_DECELERATION = 1.0  # of base and arm, to decide which pairs matter [m/s^2]
_MAX_GAIN = 0.05  # by which the lag may enlarge a distance [m]


class DistanceConstraints:
    """Turns distances into rows."""

    def __init__(self, model: RobotModel, collision: CollisionSettings, period: float) -> None:
        self._settings = collision
        acceleration, numbers = model.acceleration_limits, np.arange(model.n)
        robot, turns = model.description, numbers == model.turning
        drives = (numbers < model.n_base) & ~turns
        parts = np.array([turns, drives, numbers >= model.n_base])
        self._braking = (collision.braking * parts * acceleration).T
        """(n, 3) deceleration of a degree of freedom that turns the base, drives it, is a joint."""
        wait = collision.delay_periods * period
        slowest = float(acceleration[drives].min())
        base_braking = min(_ASSUMED_DECELERATION, collision.braking * slowest)
        self._delay = _by_kind(robot.base.lag + wait, SELF=robot.arm.lag + wait)
        near_stop = collision.near_stop_distance
        self._far = _by_kind(collision.stop_distance, SELF=near_stop)
        self._near = _by_kind(near_stop)
        self._touching = _by_kind(near_stop, PALM=collision.palm_stop_distance)
        """Distances to stop at, by `PairKind` [m]."""
        self.ranges = Ranges(
            collision.stop_distance,
            self._delay,
            _by_kind(_ASSUMED_DECELERATION, SELF=collision.max_deceleration, BASE=base_braking),
            _by_kind(collision.influence_distance, SELF=collision.self_influence_distance),
        )
        """When a pair matters."""

    def rows(
        self,
        distances: Distances,
        bounds: tuple[Array, Array],
        goal: MotionGoal[MapPose] | None,
        lag: Lag,
        margins: Array | None = None,
    ) -> Rows | None:
        """The rows that can bind within the bounds (n,); None if there are none.

        The goal decides the stop distance, to which margins (K,) are added [m]; what is within its
        margin need not give way. Without a goal the robot comes to rest: it does not come nearer to
        anything, but does not give way either.
        """
        if not len(distances.d):
            return None
        allowed, slope = self._allowed(distances, self._stop_distances(goal), lag, margins)
        drift = distances.drift
        if goal is None:  # standing still satisfies every row
            allowed, drift = np.maximum(allowed, 0.0), np.maximum(drift, 0.0)
            slope = np.zeros(len(slope))
        # Linearised in the command at the last one, because of the lag.
        late = distances.rows * lag.constants
        A = distances.rows - slope[:, None] * late
        least = -allowed - slope * (late @ lag.commanded) - drift
        worst = np.minimum(A * bounds[0], A * bounds[1]).sum(axis=1)
        binds = worst < least
        if not binds.any():
            return None
        return Rows(A[binds], least[binds], distances.kind[binds])

    def _stop_distances(self, goal: MotionGoal[MapPose] | None) -> Array:
        if goal is None:
            return self._near
        if not isinstance(goal, PoseGoal):
            return self._far
        if goal.hand_may_touch:
            return self._touching
        return self._near if goal.straight else self._far

    def _allowed(
        self, distances: Distances, stop: Array, lag: Lag, margins: Array | None
    ) -> tuple[Array, Array]:
        """Speeds (K,) at which distances may shrink [m/s], and their slopes by distance [1/s].

        Where a speed is negative the distance must grow.
        """
        s, rows, kind = self._settings, distances.rows, distances.kind
        room = distances.d - stop[kind]
        if margins is not None:
            room = np.minimum(room, np.maximum(room - margins, 0.0))
        # Until they have caught up [m or rad].
        ahead = lag.constants * (lag.velocities - lag.commanded)
        room = np.minimum(room + rows @ ahead, np.maximum(room, 0.0) + _MAX_GAIN)

        # The base alone brakes by driving or turning, whichever is more: a turn that compensates
        # for speed brings its next corner there.
        turn, drive, arm = (np.abs(rows) @ self._braking).T
        braking = np.where(arm > 0.0, turn + drive + arm, np.maximum(turn, drive))
        deceleration = np.minimum(np.maximum(braking, s.min_deceleration), s.max_deceleration)
        late = deceleration * self._delay[kind]
        root = np.sqrt(late * late + 2.0 * deceleration * np.maximum(room, 0.0))
        back = np.maximum(s.return_gain * room, -s.return_speed)
        return np.where(room < 0.0, back, root - late), deceleration / root


def _by_kind(value: float, **exceptions: float) -> Array:
    """Values by `PairKind`."""
    values = np.full(len(PairKind), value)
    for name, exception in exceptions.items():
        values[PairKind[name]] = exception
    return values


class NearestPair(NamedTuple):
    """The pair of shapes with the smallest distance, the robot's own pairs left out."""

    clearance: float = inf
    name: str = ""
    points: tuple[Array, Array] | None = None  # the nearest points (3,) of the two on the map


NOTHING_NEAR = NearestPair()


class CollisionAvoidance:
    """The limit of distances; also gives way to the predicted motion of moving obstacles."""

    def __init__(self, model: RobotModel, collision: CollisionSettings, period: float) -> None:
        self.models = CollisionModels(model)
        self.nearest = NOTHING_NEAR  # in the last period
        self._constraints = DistanceConstraints(model, collision, period)
        self._proximity = Proximity(model, self._constraints.ranges, self.models)
        self._moving_obstacles = MovingObstacleAvoidance(model)
        self._most_margin = collision.most_margin

    def prepare(self, surroundings: Surroundings) -> None:
        """Compute in advance what the first period in these surroundings needs."""
        self._proximity.update_shapes(surroundings)

    def __call__(self, constraints: Constraints, now: Situation) -> None:
        """Add the distances that can bind within the velocity bounds."""
        goal, state, surroundings = now.goal, now.state, now.surroundings
        fastest = np.maximum(-constraints.lower, constraints.upper)
        margin = min(surroundings.uncertainty, self._most_margin)
        near = self._proximity.near(state.mTb, state.q, surroundings, fastest, now.base, margin)
        if isinstance(goal, PoseGoal) and goal.hand_may_touch:
            near = near.without(PairKind.HAND)
        self.nearest = NOTHING_NEAR
        if not len(near.d):
            return
        margins = None
        if margin > 0.0:
            margins = np.where(self._may_be_nearer(near, goal), margin, 0.0)
        bounds = constraints.bounds
        constraints.add(self._constraints.rows(near, bounds, goal, now.lag, margins))
        to_obstacles = np.where(near.kind == PairKind.SELF, inf, near.d)
        first = int(to_obstacles.argmin())
        if (clearance := float(to_obstacles[first])) < inf:
            pair = int(near.pair[first])
            name, points = self._proximity.pair_name(pair), self._proximity.pair_points(pair)
            self.nearest = NearestPair(clearance, name, points)

    def _may_be_nearer(self, near: Distances, goal: MotionGoal[MapPose] | None) -> Mask:
        """(K,) whether the second of a pair is only known from the map.

        Not for a hand at work, which goes by what it sees.
        """
        mapped = self._proximity.is_mapped(near.pair)
        if isinstance(goal, PoseGoal) and (goal.straight or goal.hand_may_touch):
            mapped &= (near.kind != PairKind.HAND) & (near.kind != PairKind.PALM)
        return mapped

    def give_way(
        self,
        now: Situation,
        wanted: Array,
        led: Array | None,
        floor: FloorMap | None,
        bounds: tuple[Array, Array],
    ) -> Rows | None:
        """The rows that give way to moving obstacles; see `MovingObstacleAvoidance.rows`."""
        q, velocities, moving = now.state.q, now.lag.velocities, now.surroundings.moving
        return self._moving_obstacles.rows(
            now.base, q, velocities, wanted, led, moving, floor, bounds
        )

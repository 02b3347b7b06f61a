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
from controller.situation import Situation
from controller.surroundings import Surroundings

_STOP = 0.02  # d_s: distance at which the approach to an obstacle ends [m] ...
_NEAR_STOP = 0.01  # ... for straight motion, and from the robot to itself and the floor ...
_PALM_STOP = 0.001  # ... and for the palm where the hand may touch [m]
_INFLUENCE = 0.6
"""d_i: farther obstacles are ignored [m]; at least d_s + v²/2a + v times the delay, for the fastest
approach."""
_SELF_INFLUENCE = 0.25  # the same from the robot to itself and the floor [m]
_BRAKING = 0.8  # share of the acceleration limits assumed for braking
_LEAST_DECELERATION, _MOST_DECELERATION = 0.2, 2.0  # assumed for braking [m/s^2]
_DELAY = 3.0  # before a pair brakes, besides the lags [control periods]
_RETURN_GAIN = 4.0  # speed at which shapes separate, per distance below d_s [1/s] ...
_RETURN_SPEED = 0.2  # ... and at most [m/s]
_MOST_MARGIN = 0.05
"""The robot stops so much farther from fixtures as their places are uncertain, and at most by this
[m]."""
_ASSUMED_DECELERATION = 1.0  # of base and arm, to decide which pairs matter [m/s^2]
_MAX_GAIN = 0.05  # by which the lag may enlarge a distance [m]


class DistanceConstraints:
    """Turns distances into rows."""

    def __init__(self, model: RobotModel, period: float) -> None:
        acceleration, numbers = model.acceleration_limits, np.arange(model.n)
        robot, turns = model.description, numbers == model.turning
        drives = (numbers < model.n_base) & ~turns
        parts = np.array([turns, drives, numbers >= model.n_base])
        self._braking = (_BRAKING * parts * acceleration).T
        """(n, 3) deceleration of a degree of freedom that turns the base, drives it, is a joint."""
        wait = _DELAY * period
        slowest = float(acceleration[drives].min())
        base_braking = min(_ASSUMED_DECELERATION, _BRAKING * slowest)
        self._delay = _by_kind(robot.base.lag + wait, SELF=robot.arm.lag + wait)
        self._far = _by_kind(_STOP, SELF=_NEAR_STOP)
        self._near = _by_kind(_NEAR_STOP)
        self._touching = _by_kind(_NEAR_STOP, PALM=_PALM_STOP)
        """Distances to stop at, by `PairKind` [m]."""
        self.ranges = Ranges(
            _STOP,
            self._delay,
            _by_kind(_ASSUMED_DECELERATION, SELF=_MOST_DECELERATION, BASE=base_braking),
            _by_kind(_INFLUENCE, SELF=_SELF_INFLUENCE),
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
        rows, kind = distances.rows, distances.kind
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
        deceleration = np.minimum(np.maximum(braking, _LEAST_DECELERATION), _MOST_DECELERATION)
        late = deceleration * self._delay[kind]
        root = np.sqrt(late * late + 2.0 * deceleration * np.maximum(room, 0.0))
        back = np.maximum(_RETURN_GAIN * room, -_RETURN_SPEED)
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

    def __init__(self, model: RobotModel, period: float) -> None:
        self.models = CollisionModels(model)
        self.nearest = NOTHING_NEAR  # in the last period
        self._constraints = DistanceConstraints(model, period)
        self._proximity = Proximity(model, self._constraints.ranges, self.models)
        self._moving_obstacles = MovingObstacleAvoidance(model)

    def prepare(self, surroundings: Surroundings) -> None:
        """Compute in advance what the first period in these surroundings needs."""
        self._proximity.update_shapes(surroundings)

    def __call__(self, constraints: Constraints, now: Situation) -> None:
        """Add the distances that can bind within the velocity bounds."""
        goal, state, surroundings = now.goal, now.state, now.surroundings
        fastest = np.maximum(-constraints.lower, constraints.upper)
        margin = min(surroundings.uncertainty, _MOST_MARGIN)
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

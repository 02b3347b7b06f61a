"""Avoidance of moving obstacles: the base predicts its motion and theirs, and gives way.

Distance constraints react too late to an obstacle that crosses the way of the base. So the wanted
velocity is rolled out for `HORIZON`, as in the dynamic window approach (Fox, Burgard and Thrun, RAM
1997), and moving obstacles with their own velocity. Nothing changes as long as the base, seen from
above with its arm, can keep its velocity for a moment and then stop before a collision.

Else the base takes another velocity within its limits. It is kept for a while, and then the base
stops or follows its lead. The rollout with the least cost is chosen: the final distance to where
the base would be without moving obstacles, and the distances below `MARGIN`. The QP gets the chosen
velocity as rows.
"""

from math import hypot, inf

import numpy as np

from config.arrays import Array
from config.planar import Pose2D, act
from controller.collision.collision_model import PairKind
from controller.collision.rollouts import (
    ARM_RADIUS,
    HORIZON,
    MARGIN,
    STOPPING,
    MovingScene,
    Rollouts,
    arm_points,
    radius,
)
from controller.floor.floor_map import FloorMap
from controller.model import RobotModel
from controller.qp_solver import Rows
from controller.surroundings import Obstacle

_TOLERATED = 0.06  # distance to moving obstacles above which the base does not give way [m]
_HYSTERESIS = 1  # shortest stopping rollouts that do not count while the base gives way
_CHANGE = 0.3  # cost of a change of the velocity chosen in the last period
_TURN = 0.3  # distance equivalent to a radian of heading at the end of a rollout [m]
_SHARES = (1.0, 0.75, 0.5, 0.25, 0.0)  # multiples of the lead velocity among the candidates
_STILL = 0.05  # slower obstacles count as static [m/s]
_REACH = 1.3  # largest distance of a part of the robot from the centre of its base [m]
_ROOM = 0.02  # distance kept from static obstacles, unless the base is nearer already [m]
_NOISE = 0.005  # accuracy of the floor map [m]
_BATCH = 8  # number of rollouts that are checked for static obstacles together ...
_MAX_CHECKED = 96  # ... and at most
_TOLERANCE = 1e-3  # of the velocity that the QP must keep [m/s, rad/s]
_BINDS = 1e-4  # a row with less margin than this binds [m/s]


class MovingObstacleAvoidance:
    """Decides how the base of one robot gives way, from period to period."""

    def __init__(self, model: RobotModel) -> None:
        self._model = model
        n_base = model.n_base
        self._lower, self._upper = model.velocity_limits[:, :n_base]
        self._velocities = _grid(model)
        self._rollouts = Rollouts(model)
        self._taken: Array | None = None  # (n_base,) velocity chosen in the last period, if any

    def rows(
        self,
        mTb: Pose2D,
        q: Array,
        velocities: Array,
        wanted: Array,
        led: Array | None,
        obstacles: tuple[Obstacle, ...],
        floor: FloorMap | None,
        bounds: tuple[Array, Array],
    ) -> Rows | None:
        """Rows that keep the base at a velocity that gives way; None if it need not.

        Args:
            mTb: base pose.
            q: (j,) joint positions [rad].
            velocities: (n,) present velocities.
            wanted: (n,) velocities of this period without giving way.
            led: (n_base,) velocity at which the base is led somewhere; None if it is not.
            obstacles: the moving obstacles.
            floor: map of the static obstacles, if there is one.
            bounds: lower and upper bounds (n,) of the velocities.
        """
        n_base, n = self._model.n_base, self._model.n
        before, self._taken = self._taken, None
        near = [one for one in obstacles if self._may_meet(one, mTb)]
        if not near:
            return None
        scene = MovingScene(mTb, arm_points(self._model, q), near)
        now, wanted = velocities[:n_base], wanted[:n_base]
        skipped = 0 if before is None else _HYSTERESIS
        led = wanted if led is None else np.clip(led, self._lower, self._upper)
        rollouts = self._rollouts.predict(now, np.array([wanted, led]), led)
        there = rollouts[1, STOPPING - 1, -1]
        cost = self._rollouts.cost(rollouts, scene, _TOLERATED)
        if min(cost[0, skipped:STOPPING].min(), cost[1, STOPPING - 1]) <= 0.0:
            return None
        others = [*self._velocities, *(share * led for share in _SHARES), wanted]
        if before is not None:
            others.append(before)
        tried = np.array(others)
        rollouts = self._rollouts.predict(now, tried, led)
        cost = self._rollouts.cost(rollouts, scene, MARGIN)
        cost += np.sqrt(((rollouts[:, :, -1] - there) ** 2) @ [1.0, 1.0, _TURN**2])
        if before is not None:
            cost += _CHANGE * (((tried - before) / self._upper) ** 2).sum(axis=1)[:, None]
        rollouts = rollouts.reshape(-1, *rollouts.shape[2:])
        found = self._cheapest(cost.ravel(), rollouts, scene, floor)
        self._taken = taken = tried[found // cost.shape[1]]
        command = np.clip(taken, bounds[0][:n_base], bounds[1][:n_base])
        A = np.zeros((2 * n_base, n))
        A[:n_base, :n_base], A[n_base:, :n_base] = np.eye(n_base), -np.eye(n_base)
        least = np.concatenate([command, -command]) - _TOLERANCE
        # Where one cannot be kept because of a static obstacle, the others still are.
        return Rows(A, least, PairKind.AHEAD + np.tile(np.arange(n_base), 2))

    def _may_meet(self, obstacle: Obstacle, mTb: Pose2D) -> bool:
        """Whether an obstacle moves and can reach the robot within the horizon."""
        speed = hypot(*obstacle.velocity[:2].tolist())
        x, y, _ = obstacle.geom.pose.translation.tolist()
        reach = _REACH + radius(obstacle.geom.shape) + MARGIN
        fastest = float(self._model.limits.base_twist[0])
        return speed > _STILL and hypot(x - mTb.x, y - mTb.y) < reach + (speed + fastest) * HORIZON

    def _cheapest(
        self, cost: Array, rollouts: Array, scene: MovingScene, floor: FloorMap | None
    ) -> int:
        """Index of the cheapest rollout free of static obstacles; else of that with most room."""
        order = np.argsort(cost, kind="stable")
        if floor is None or floor.free:
            return int(order[0])
        mTb = scene.mTb
        here = _rooms(floor, scene.arm, np.array([mTb]))
        best, most = int(order[0]), -inf
        for first in range(0, min(_MAX_CHECKED, len(order)), _BATCH):
            some = order[first : first + _BATCH]
            x, y, heading = np.moveaxis(rollouts[some][:, 1::2], -1, 0)
            poses = np.stack([*act(mTb, x, y), mTb.heading + heading], axis=-1)
            rooms = _rooms(floor, scene.arm, poses)
            rooms = rooms.reshape(2, *x.shape).min(axis=2)
            room = (rooms - np.minimum(here - _NOISE, _ROOM)).min(axis=0)
            (free,) = np.nonzero(room >= 0.0)
            if len(free):
                return int(some[free[0]])
            if room.max() > most:
                best, most = int(some[room.argmax()]), float(room.max())
        return best


def _grid(model: RobotModel) -> Array:
    """(V, n_base) velocities on a grid over the limits."""
    lower, upper = model.velocity_limits[:, : model.n_base]
    turning = np.arange(model.n_base) == model.turning
    counts = np.where(turning, 5, 6) if model.n_base == 2 else np.where(turning, 3, 5)
    axes = [np.linspace(a, b, n) for a, b, n in zip(lower, upper, counts.tolist(), strict=True)]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, model.n_base)


def _rooms(floor: FloorMap, arm: Array, bases: Array) -> Array:
    """(2, N) distances of base and arm to static obstacles, seen from above, at poses (..., 3)."""
    bases = bases.reshape(-1, 3)
    x, y = act(bases.T[:, :, None], arm[:, 0], arm[:, 1])
    above = floor.clearance(np.stack([x, y], axis=-1).reshape(-1, 2)).reshape(x.shape).min(axis=1)
    return np.stack([floor.stands_free(bases), above - ARM_RADIUS])


def waits_for(
    here: Pose2D, moving: tuple[Obstacle, ...], rows: Rows | None, velocities: Array | None
) -> str:
    """Name of the nearest moving obstacle, if a row because of one binds velocities (n,)."""
    if rows is None or velocities is None:
        return ""
    because = rows.group >= PairKind.BASE_MOVING
    if not (because & (rows.A @ velocities < rows.least + _BINDS)).any():
        return ""

    def distance(one: Obstacle) -> float:
        x, y, _ = one.geom.pose.translation.tolist()
        return hypot(x - here.x, y - here.y)

    return min(moving, key=distance).geom.name

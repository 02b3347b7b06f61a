"""Dexterity of any arm: which degrees of freedom make it up, and how much of it is usual."""

from functools import lru_cache
from itertools import combinations
from math import atan2, cos, sin
from typing import NamedTuple

import numpy as np

from config.arrays import Array, Mask
from controller.stance.tool_poses import ToolPoses, forward_kinematics
from robots import RobotDescription, load_robot, robot_names

SEED = 20220101
DRAWN = 4096  # postures that are drawn at once
_JUDGED = 256  # of these by which the rank is judged

_PANDA = 0.0837  # what `_USUAL` of the random postures of a Panda do not exceed
_USUAL = 0.9
_LIMIT_MARGIN = 0.12, 0.04
"""Least distance of a stance to a joint limit [rad], share of its range."""
_INDEPENDENT = 1e-3
"""Median of a singular value from which a direction counts as one that the hand can be moved in."""


class Dexterity(NamedTuple):
    """What the manipulability of a robot is that of, and what is usual for its postures."""

    base: tuple[int, ...]
    """Degrees of freedom of the base that give an arm of lower rank those that it lacks."""
    rank: int  # of the Jacobian of these and the arm; below 6 the base cannot help
    usual: float  # typical manipulability, as a share of that of a Panda
    bearing: float
    """Of the end effector seen from the base, as its postures have it; 0 where a swivel turns the
    arm to the front [rad]."""
    is_free: Mask
    """(j,) joints that an arm of lower rank need not have where height and tilt of the end effector
    ask for, as those that turn it about the vertical; all others of it go up to their limits."""

    @property
    def has_choice(self) -> bool:
        """Whether the arm moves the end effector in every direction, its base at rest.

        Another has few postures for a pose, at a joint limit or singular as they may be.
        """
        return self.rank == 6 and not self.base

    def margins(self, robot: RobotDescription, most: float, share: float) -> Array:
        """(j,) least distances to the joint limits as `Limits.margins`, where there is a choice."""
        return robot.limits.margins(most, share) * (self.has_choice | self.is_free)

    def columns(self, n_base: int, n: int) -> slice | list[int]:
        """Those of the Jacobian of base and arm, the base first."""
        return [*self.base, *range(n_base, n)] if self.base else slice(n_base, n)

    def bearing_of(self, x: Array, y: Array) -> Array:
        """(N,) bearings of directions in the base from the one that the robot prefers [rad]."""
        c, s = cos(self.bearing), sin(self.bearing)
        return np.arctan2(c * y - s * x, c * x + s * y)


@lru_cache(maxsize=8)
def dexterity(robot: RobotDescription) -> Dexterity:
    """The dexterity of a robot: of the arm where it has rank 6, else together with its base."""
    if has_shipped_bank(robot):
        return Dexterity((), 6, 1.0, 0.0, np.ones(len(robot.arm.joints), bool))
    ends, swivel = robot.limits.within_a_turn, robot.swivel
    q = uniform_postures(robot, np.random.default_rng(SEED), *ends, DRAWN)
    if swivel is not None:
        q[:, swivel.joint] = 0.0
    tools = forward_kinematics(robot, q)
    base = range(robot.base.axes.shape[1])
    is_free = np.median(np.linalg.norm(tools.J[:, [2, 3, 4]], axis=1), axis=0) < _INDEPENDENT
    found = Dexterity((), 0, 1.0, 0.0, is_free)
    few, volume = ToolPoses(*(values[:_JUDGED] for values in tools)), 0.0
    for some in (some for count in range(len(base) + 1) for some in combinations(base, count)):
        values = np.median(_singular_values(_jacobians(robot, few, some)), axis=0)
        rank = int((values > _INDEPENDENT).sum())
        if rank > found.rank or (
            rank == found.rank and len(some) == len(found.base) and values[:rank].prod() > volume
        ):
            found, volume = found._replace(base=some, rank=rank), float(values[:rank].prod())
    m = manipulabilities(robot, tools, found)
    usual = max(float(np.quantile(m, _USUAL)) / _PANDA, 1e-6)
    x, y, _ = (m[:, None] * tools.positions).sum(axis=0).tolist()
    bearing = 0.0 if robot.swivel is not None else atan2(y, x)
    return found._replace(usual=usual, bearing=bearing)


def stance_margins(robot: RobotDescription) -> Array:
    """(j,) least distances of stances to the joint limits [rad]."""
    return dexterity(robot).margins(robot, *_LIMIT_MARGIN)


def manipulabilities(
    robot: RobotDescription, tools: ToolPoses, of: Dexterity | None = None
) -> Array:
    """(N,) Yoshikawa's measure of postures: the product of the singular values of their rank."""
    of = dexterity(robot) if of is None else of
    if of.rank == 6:
        J = _jacobians(robot, tools, of.base)
        squared: Array = np.linalg.det(J @ np.swapaxes(J, 1, 2))
        return np.sqrt(np.maximum(squared, 0.0))
    return np.asarray(
        _singular_values(_jacobians(robot, tools, of.base))[:, : of.rank].prod(axis=1)
    )


def has_shipped_bank(robot: RobotDescription) -> bool:
    """Whether joints and shapes of its arm are those of a shipped robot."""
    return any(robot.arm.is_like(load_robot(name).arm) for name in robot_names())


def random_postures(robot: RobotDescription, rng: np.random.Generator) -> tuple[Array, ToolPoses]:
    """Postures (`DRAWN`, j) within the joint limits [rad], and where they have the hand."""
    q = uniform_postures(robot, rng, *robot.limits.within_a_turn, DRAWN)
    return q, forward_kinematics(robot, q)


def uniform_postures(
    robot: RobotDescription, rng: np.random.Generator, low: Array, high: Array, count: int
) -> Array:
    """(count, j) postures between limits (j,) [rad]; the slides of a telescope go out together."""
    q = rng.uniform(low, high, size=(count, len(low)))
    for joint, first in enumerate(robot.arm.telescopes):
        if first != joint:
            share = (q[:, first] - low[first]) / (high[first] - low[first])
            q[:, joint] = low[joint] + share * (high[joint] - low[joint])
    return q


def _singular_values(J: Array) -> Array:
    """(N, 6) of Jacobians (N, M, j), M <= 6; 0 beyond M and j."""
    found = np.linalg.svd(J, compute_uv=False)
    return np.pad(found, ((0, 0), (0, 6 - found.shape[1])))


def _jacobians(robot: RobotDescription, tools: ToolPoses, base: tuple[int, ...]) -> Array:
    """(N, 6, b + j) of the end effector, of some degrees of freedom of the base and of the arm."""
    if not base:
        return tools.J
    columns = np.zeros((len(tools.J), 6, len(base)))
    (vx, vy, turn), (x, y, _) = robot.base.axes[:, base], tools.positions.T[:, :, None]
    columns[:, 0], columns[:, 1], columns[:, 5] = vx - turn * y, vy + turn * x, turn
    return np.concatenate([columns, tools.J], axis=2)

"""Drawing of the posture bank of any arm, and where it is stored; its ready posture.

The bank of the shipped robots comes with the package. That of another arm is drawn when it is
needed first, and kept in the user's cache by the hash of its description.
"""

import hashlib
import os
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

import numpy as np

from config import UserError, user_cache
from config.arrays import Array
from config.planar import wrap
from controller.collision.self_collision import SelfCollision
from controller.model import RobotModel
from controller.stance.dexterity import (
    DRAWN,
    SEED,
    dexterity,
    has_shipped_bank,
    manipulabilities,
    random_postures,
    uniform_postures,
)
from controller.stance.tool_poses import forward_kinematics
from robots import RobotDescription

BANK = Path(__file__).with_name("postures.npy")
"""The shipped bank: (60 000, 7) joint positions in half precision [rad], by `draw` with `SEED`."""

# A bank must be drawn again when one of these changes.
_VERSION = 2
_COUNT, _LEAST = 30_000, 2_000  # postures of a bank that is drawn, and that it must have
_LIMIT_MARGIN = 0.2, 0.067  # least distance to every joint limit [rad], share of a short range
_MIN_MANIPULABILITY = 0.035  # of an arm as dexterous as a Panda
_MAX_BEARING = 0.3  # largest |θ_ε|, the bearing of the end effector seen from the arm's foot [rad]
_MIN_REACH = 0.25, 0.25
"""Least horizontal distance of the end effector from the arm's foot [m], share of its reach."""
_USUAL = 0.9  # quantile that counts as usual
_CLEARANCE = 0.03, 0.25
"""Least distance from the robot itself and the floor [m], share of what is usual for it."""
_MOST_DRAWS = 300


def stored_postures(robot: RobotDescription, every: int = 1) -> Array:
    """Every n-th posture of the bank, (N, j), within the joint limits of a robot [rad].

    UserError: the arm has no postures in which it stands clear of itself.
    """
    if has_shipped_bank(robot):
        q = np.load(BANK)
    else:
        path = _cached(robot)
        try:
            q = np.load(path, allow_pickle=False)
        except (OSError, ValueError):
            q = draw([robot], _COUNT, np.random.default_rng(SEED)).astype(np.float32)
            _keep(path, q)
    q = q[::every].astype(float)
    q = q[((robot.limits.q_min <= q) & (q <= robot.limits.q_max)).all(axis=1)]
    return np.asarray(q)


def _cached(robot: RobotDescription) -> Path:
    arm, limits = robot.arm, robot.limits
    poses = (robot.bTa, arm.lTh * robot.gripper.hTe, robot.camera.eTc, *arm.joints)
    shapes = [*(one for link in arm.collision for one in link), *robot.gripper.collision]
    poses = (*poses, *(one.pose for one in shapes))
    numbers = [*(pose.homogeneous for pose in poses), limits.q_min, limits.q_max, arm.slides]
    digest = hashlib.sha256(b"".join(np.round(np.float64(one), 9).tobytes() for one in numbers))
    told = [_VERSION, robot.base.size, arm.may_touch, [(one.name, one.shape) for one in shapes]]
    digest.update(repr(told).encode())
    return user_cache() / "posture-banks" / f"{digest.hexdigest()[:24]}.npy"


def _keep(path: Path, q: Array) -> None:
    part = path.with_suffix(f".{os.getpid()}.npy")
    with suppress(OSError):  # it is drawn again the next time
        path.parent.mkdir(parents=True, exist_ok=True)
        np.save(part, q)
        part.replace(path)


def draw(robots: Sequence[RobotDescription], count: int, rng: np.random.Generator) -> Array:
    """Draw (count, j) postures that are good on every one of some robots with the same arm [rad].

    UserError: there are too few.
    """
    robot = robots[0]
    collisions = [SelfCollision(RobotModel(one)) for one in robots]
    swivel, (low, high) = robot.swivel, robot.limits.within_a_turn
    foot = robot.bTa.translation if swivel is None else swivel.pivot
    margins = dexterity(robot).margins(robot, *_LIMIT_MARGIN)
    low, high = low + margins, high - margins
    least, nearest, clearance = _thresholds(robot, collisions[0])
    drawn: list[Array] = []
    for _ in range(_MOST_DRAWS):
        q = uniform_postures(robot, rng, low, high, DRAWN)
        if swivel is not None:
            q[:, swivel.joint] = 0.0
        tools = forward_kinematics(robot, q)
        x, y, _ = (tools.positions - foot).T
        good = (manipulabilities(robot, tools) > least) & (np.hypot(x, y) > nearest)
        if swivel is not None and dexterity(robot).has_choice:
            turn = rng.uniform(-_MAX_BEARING, _MAX_BEARING, len(q)) - np.arctan2(y, x)
            q[:, swivel.joint] = turned = wrap(swivel.sign * turn)
            good &= (turned > low[swivel.joint]) & (turned < high[swivel.joint])
        elif swivel is not None:  # too few joints to have the hand in front whatever its pose
            q[:, swivel.joint] = rng.uniform(low[swivel.joint], high[swivel.joint], len(q))
        drawn += [p for p in q[good] if all(c.clearance(p) > clearance for c in collisions)]
        if len(drawn) >= count:
            break
    if len(drawn) < min(count, _LEAST):
        raise UserError(
            f"{robot.name}: hardly any posture of the arm is dexterous and clear of the robot "
            f"itself ({len(drawn)} of {DRAWN * _MOST_DRAWS}); look at its shapes with "
            "`frankie-task robot show`, and at `may_touch` in its file"
        )
    return np.array(drawn[:count])


def _thresholds(robot: RobotDescription, collision: SelfCollision) -> tuple[float, float, float]:
    """Least manipulability, distance from the foot [m] and clearance [m] of a good posture."""
    if has_shipped_bank(robot):
        return _MIN_MANIPULABILITY, _MIN_REACH[0], _CLEARANCE[0]
    q, tools = random_postures(robot, np.random.default_rng(SEED))
    reach = np.linalg.norm(tools.positions - robot.bTa.translation, axis=1).max()
    usual = np.quantile([collision.clearance(p) for p in q], _USUAL)
    return (
        _MIN_MANIPULABILITY * dexterity(robot).usual if dexterity(robot).has_choice else -1.0,
        min(_MIN_REACH[0], _MIN_REACH[1] * float(reach)),
        min(_CLEARANCE[0], max(0.0, _CLEARANCE[1] * float(usual))),
    )

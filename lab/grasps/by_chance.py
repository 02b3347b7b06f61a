"""Whether an object can be grasped at all: by trying many grasps that nobody has chosen."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from pinocchio import SE3, exp3

from lab.grasps.physical_judge import execute
from lab.grasps.physical_scenes import dropped
from lab.grasps.scenes import EVALUATION_SEED, FLOOR, ROBOT
from perception import GraspEstimate

_DRAWS = 6  # the stream of random numbers that grasps are drawn from
_UP = np.array([0.0, 0.0, 1.0])
_DOWN = np.diag([1.0, -1.0, -1.0])


def holds_by_chance(tries: int, meshes: Sequence[Path], seed: int) -> bool:
    """Whether any of many grasps by chance holds the object of a scene.

    They come from straight above like all others, the hand wide open, anywhere over the box around
    the object, in any direction, and at any height down to where the finger tips meet the floor.

    Args:
        tries: how many grasps.
        meshes: as for `dropped`.
        seed: of the scene.
    """
    scene = dropped(seed, 1, meshes)
    (obj,) = scene.world.objects
    high = np.array([obj.reach(axis) for axis in np.eye(3)])
    low = np.array([*(-obj.reach(-axis) for axis in np.eye(3)[:2]), FLOOR + ROBOT.gripper.tip])
    rng = np.random.default_rng((EVALUATION_SEED, _DRAWS, seed))
    for _ in range(tries):
        centre, direction = rng.uniform(low, np.maximum(high, low)), rng.uniform(0.0, np.pi)
        grasp = GraspEstimate(
            wTg=SE3(exp3(direction * _UP) @ _DOWN, centre),
            width=0.0,
            opening=ROBOT.gripper.opening,
            quality=0.0,
            stamp=0.0,
            pixel=(0.0, 0.0),
            angle=0.0,
        )
        if execute(*scene.hand(), grasp).held:
            return True
    return False

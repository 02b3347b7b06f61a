"""The goals of Experiment 2: drawn with a seed and reachable."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
from pinocchio import SE3

from controller import RobotModel
from lab.bench.contacts import ContactChecker
from robots import reach

PLACES = ("anywhere", "near", "far", "floor", "above")
"""Regions of the goals: the disc, within 1 m, between 3.5 and 4 m, low, or above the base."""
_RINGS = {"near": (0.0, 1.0), "far": (3.5, 4.0), "above": (0.0, 0.35)}
"""Least and largest distance of these from the start [m]."""
_LOW, _HIGH = 0.15, 0.8
"""Largest height of goals at the floor, least height of goals above the base [m]."""
DISC = 4.0
"""Largest distance of goals from the start [m]."""
_MARGIN = 0.1
"""Distance of postures from every joint limit [rad]."""
_LOWEST = 0.05
"""Least height of tool and flange [m]."""
_PALM_LOWEST = 0.005
"""Least height of the corners of the palm of low goals, which the capsules leave free [m]."""


def generate_goals(model: RobotModel, count: int, seed: int, where: str = "anywhere") -> list[SE3]:
    """Poses `wTe` of the tool that the robot can reach without contact.

    The posture is drawn uniformly within the joint limits, the heading of the base uniformly, and
    the position of the tool uniformly in a disc of 4 m around the start. Postures in which the
    arm touches itself, the base or the floor are rejected.

    Args:
        model: the robot.
        count: number of goals.
        seed: the same seed gives the same goals.
        where: one of `PLACES`.
    """
    nearest, farthest = _RINGS.get(where, (0.0, DISC))
    rng = np.random.default_rng(seed)
    contacts = ContactChecker(model)
    limits = model.limits
    goals: list[SE3] = []
    while len(goals) < count:
        q = rng.uniform(limits.q_min + _MARGIN, limits.q_max - _MARGIN)
        heading = rng.uniform(-np.pi, np.pi)
        radius = np.sqrt(rng.uniform(nearest**2, farthest**2))
        bearing = rng.uniform(-np.pi, np.pi)
        tool = model.bTe(q)
        height = float(tool.translation[2])
        if (where == "floor" and height > _LOW) or (where == "above" and height < _HIGH):
            continue
        flange = model.link_poses(SE3.Identity(), q)[-1].translation[2]
        if min(height, flange) < _LOWEST or np.hypot(radius, height) > DISC or contacts(q).any:
            continue
        if where == "floor" and _palm_height(model, tool) < _PALM_LOWEST:
            continue
        place = np.array([radius * np.cos(bearing), radius * np.sin(bearing), height])
        goals.append(SE3(pin.utils.rotate("z", heading) @ tool.rotation, place))
    return goals


def _palm_height(model: RobotModel, tool: SE3) -> float:
    """Height of the lowest corner of the palm [m]."""
    return -reach(model.description.gripper.palm.moved(tool), np.array([0.0, 0.0, -1.0]))

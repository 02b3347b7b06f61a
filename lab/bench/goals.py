"""Starts and goals of Experiment 2: drawn with a seed, reachable and free of contact."""

import numpy as np
import pinocchio as pin
from pinocchio import SE3

from controller import Array, RobotModel
from lab.bench.contacts import ContactChecker
from lab.bench.motion_evaluation import Evaluator

DISC = 4.0  # largest distance of goals from the start [m]
_MARGIN = 0.1  # distance of postures from every joint limit [rad]
_ROOM = 0.03  # to itself, of an arm of which only its own shapes are known [m]
_LOWEST = 0.05  # least height of tool and flange [m]

STARTS = ("ready", "random", "limits", "singular", "stretched")  # start postures of the arm
_AT_A_LIMIT = 0.02  # distance of joints at a limit [rad]
_STRETCHED = -0.09  # elbow of a stretched arm [rad]; it straightens at the joint's limit of -0.07
_SINGULAR_OF = 200  # number of random postures of which the least manipulable one is chosen


def generate_goals(model: RobotModel, count: int, seed: int) -> list[SE3]:
    """Poses `mTe` of the tool that the robot can reach without contact.

    The posture is drawn uniformly within the joint limits, the heading of the base uniformly, and
    the position of the tool uniformly in a disc of 4 m around the start. Postures in which the
    arm touches itself, the base or the floor are rejected.
    """
    rng = np.random.default_rng(seed)
    contacts = ContactChecker(model)
    limits = model.limits
    (low, high), margins = limits.within_a_turn, limits.margins(_MARGIN, 0.03)
    goals: list[SE3] = []
    while len(goals) < count:
        q = rng.uniform(low + margins, high - margins)
        heading = rng.uniform(-np.pi, np.pi)
        radius = np.sqrt(rng.uniform(0.0, DISC**2))
        bearing = rng.uniform(-np.pi, np.pi)
        tool = model.bTe(q)
        height = float(tool.translation[2])
        flange = model.link_poses(SE3.Identity(), q)[-1].translation[2]
        if min(height, flange) < _LOWEST or np.hypot(radius, height) > DISC or contacts(q, _ROOM):
            continue
        place = np.array([radius * np.cos(bearing), radius * np.sin(bearing), height])
        goals.append(SE3(pin.utils.rotate("z", heading) @ tool.rotation, place))
    return goals


def draw_start(model: RobotModel, kind: str, rng: np.random.Generator) -> Array:
    """(j,) joint positions free of contact, of one of `STARTS` [rad]."""
    limits, contacts = model.limits, ContactChecker(model)
    if kind == "ready":
        return model.description.arm.ready.copy()

    def drawn() -> Array:
        while True:
            q = rng.uniform(*limits.within_a_turn)
            if kind == "limits":
                side = rng.integers(3, size=len(q))
                q = np.where(side == 0, limits.q_min + _AT_A_LIMIT, q)
                q = np.where(side == 1, limits.q_max - _AT_A_LIMIT, q)
            elif kind == "stretched":
                q[3] = _STRETCHED
            if not contacts(q):
                return np.asarray(q, float)

    if kind != "singular":
        return drawn()

    return min((drawn() for _ in range(_SINGULAR_OF)), key=Evaluator(model).manipulability)

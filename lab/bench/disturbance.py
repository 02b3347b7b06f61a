"""Start postures, sensor noise and delay of the reach bench."""

from __future__ import annotations

from dataclasses import dataclass
from math import radians

import numpy as np
import pinocchio as pin
from pinocchio import SE3

from controller import (
    Array,
    Command,
    KinematicState,
    MotionGoal,
    RobotModel,
    StepReport,
    Surroundings,
    manipulability,
)
from lab.bench.contacts import ContactChecker
from lab.bench.motion import State, Step

STARTS = ("ready", "random", "limits", "singular", "stretched")
"""Start postures of the arm."""
_AT_A_LIMIT = 0.02
"""Distance of joints at a limit [rad]."""
_STRETCHED = -0.09
"""Elbow of a stretched arm [rad]; it straightens at the joint's limit of -0.07."""
_SINGULAR_OF = 200
"""Number of random postures of which the least manipulable one is chosen."""


def draw_start(model: RobotModel, kind: str, rng: np.random.Generator) -> Array:
    """(7,) joint positions free of contact, of one of `STARTS` [rad]."""
    limits, contacts = model.limits, ContactChecker(model)
    if kind == "ready":
        return model.description.arm.ready.copy()

    def drawn() -> Array:
        while True:
            q = rng.uniform(limits.q_min, limits.q_max)
            if kind == "limits":
                side = rng.integers(3, size=len(q))
                q = np.where(side == 0, limits.q_min + _AT_A_LIMIT, q)
                q = np.where(side == 1, limits.q_max - _AT_A_LIMIT, q)
            elif kind == "stretched":
                q[3] = _STRETCHED
            if not contacts(q).any:
                return np.asarray(q, float)

    if kind != "singular":
        return drawn()

    def measure(q: Array) -> float:
        n = model.n_base
        kinematics = model.kinematics(q)
        return manipulability(kinematics.screws[:, n:], kinematics.hessian[n:, n:])[0]

    return min((drawn() for _ in range(_SINGULAR_OF)), key=measure)


@dataclass(frozen=True, kw_only=True)
class Disturbance:
    """White noise of the state (standard deviations) and delay of the commands."""

    joint_noise: float = 0.0
    """Of the joint positions [rad]."""
    base_noise: float = 0.0
    """Of the base's x and y [m]."""
    heading_noise: float = 0.0
    """Of the base's heading [rad]."""
    delay: float = 0.0
    """From the state to the command that follows from it [s]."""


QUIET = Disturbance()
NOISY = Disturbance(joint_noise=1e-3, base_noise=5e-3, heading_noise=radians(0.3))
"""An ordinary encoder and an ordinary localisation."""


def disturbed(
    plain: Step, disturbance: Disturbance, period: float, rng: np.random.Generator
) -> Step:
    """A step with a noisy state and delayed commands; it continues from its own last command."""
    own, delayed = Command.stop(), list[Command]()

    def step(
        state: KinematicState, goal: MotionGoal | None, last: Command, surroundings: Surroundings
    ) -> tuple[Command, StepReport]:
        nonlocal own
        x, y = rng.normal(size=2) * disturbance.base_noise
        turn = pin.utils.rotate("z", rng.normal() * disturbance.heading_noise)
        wTb = SE3(turn @ state.wTb.rotation, state.wTb.translation + np.array([x, y, 0.0]))
        q = state.q + rng.normal(size=len(state.q)) * disturbance.joint_noise
        own, report = plain(State(wTb=wTb, q=q), goal, own, surroundings)
        delayed.append(own)
        if len(delayed) <= round(disturbance.delay / period):
            return Command.stop(), report
        return delayed.pop(0), report

    return step

"""Evaluation of a motion: failure, limit violations, contacts, smoothness, manipulability.

Everything is computed from the samples of the motion, nothing from the reports of the controller.
"""

from dataclasses import dataclass
from enum import StrEnum

import numpy as np
import pinocchio as pin

from controller import Array, RobotModel
from lab.bench.contacts import ContactChecker
from lab.bench.simulated_motion import Motion

_ROUNDING = 1e-9  # tolerance of a limit, as a share of it
_FINAL_SECONDS = 5.0  # the end of a motion, which classifies its failure [s]
_STILL = 5e-3  # an error that varies by less than this does not change [m]
_PROGRESS = 1e-3  # an error that decreases by less than this is no progress [m]


class Failure(StrEnum):
    """Why a goal was not reached."""

    TIME_OVER = "time over"  # the error was still decreasing
    STUCK_STILL = "stuck still"
    STUCK_MOVING = "stuck moving"
    INFEASIBLE = "infeasible"  # the QP had no solution at least once
    UNREACHABLE = "called unreachable"  # by the controller


@dataclass(frozen=True, kw_only=True)
class Trial:
    """The result of one motion."""

    failure: Failure | None  # None if the goal was reached
    time: float  # until the goal was reached or given up [s]
    heading_error: float  # θ_ε at the end: bearing of the end effector seen from the base [rad]
    manipulability: float  # of the arm at the end
    limit_violations: int  # samples over a limit of position, velocity or acceleration
    contact_samples: int  # in which the arm touches itself, the base or the floor
    jerk: float  # cumulative jerk of the tool [m/s^2], from rest


class Evaluator:
    """Evaluates the motions of one robot."""

    def __init__(self, model: RobotModel) -> None:
        self.model = model
        self._checker = ContactChecker(model)
        self._data = model.chain.createData()
        self._tool = model.chain.getFrameId("tool")

    def __call__(self, motion: Motion) -> Trial:
        """The result of a motion."""
        x, y = self.model.bTe(motion.q[-1]).translation[:2]
        return Trial(
            failure=failure_of(motion),
            time=motion.duration,
            heading_error=float(np.arctan2(y, x)),
            manipulability=self.manipulability(motion.q[-1]),
            limit_violations=count_violations(self.model, motion),
            contact_samples=sum(self._checker(q) for q in motion.q),
            jerk=cumulative_jerk(motion.tool, motion.period),
        )

    def manipulability(self, q: Array) -> float:
        """Yoshikawa's measure of the arm at joint positions q (j,) [rad]."""
        chain, joints = self.model.chain, self.model.joints(q)
        axes = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        J = pin.computeFrameJacobian(chain, self._data, joints, self._tool, axes)
        arm = J[:, self.model.n_base :]
        return float(np.sqrt(max(np.linalg.det(arm @ arm.T), 0.0)))


def failure_of(motion: Motion) -> Failure | None:
    """Why a motion did not arrive; None if it did."""
    if motion.arrived:
        return None
    if not motion.solved:
        return Failure.INFEASIBLE
    if motion.unreachable:
        return Failure.UNREACHABLE
    samples = round(_FINAL_SECONDS / motion.period)
    before, last = motion.position_error[:-samples], motion.position_error[-samples:]
    if np.ptp(last) < _STILL:
        return Failure.STUCK_STILL
    if len(before) and last.min() > before.min() - _PROGRESS:
        return Failure.STUCK_MOVING
    return Failure.TIME_OVER


def count_violations(model: RobotModel, motion: Motion) -> int:
    """Number of samples in which a limit of a joint or of the base was exceeded."""
    limits, most = model.limits, 1.0 + _ROUNDING
    accelerations = np.diff(motion.velocities, axis=0, prepend=np.zeros((1, model.n)))
    lower, upper = model.velocity_limits
    outside = (motion.q < limits.q_min - _ROUNDING) | (motion.q > limits.q_max + _ROUNDING)
    fast = motion.velocities / np.where(motion.velocities < 0.0, lower, upper) > most
    hasty = np.abs(accelerations) / (model.acceleration_limits * motion.period) > most
    return int((outside[1:].any(axis=1) | (fast | hasty).any(axis=1)).sum())


def cumulative_jerk(positions: Array, period: float, after: float = 0.0) -> float:
    """Sum of |third difference| / period² of positions (k, 3) [m], preceded by rest [m/s^2].

    The first `after` seconds do not count.
    """
    resting = np.repeat(positions[:1], 3, axis=0)
    thirds = np.diff(np.vstack([resting, positions[1:]]), n=3, axis=0)
    return float(np.linalg.norm(thirds[round(after / period) :], axis=1).sum() / period**2)

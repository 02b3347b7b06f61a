"""The gains of the holistic controller, with the symbols of the paper."""

from __future__ import annotations

from dataclasses import dataclass
from math import radians


@dataclass(frozen=True, kw_only=True)
class ControllerSettings:
    """How the terms of the quadratic programme weigh against each other."""

    period: float = 0.01
    """Control period [s]."""
    arm_effort: float = 0.01
    """k_a: cost of joint motion (Haviland 2022, eq. 8)."""
    base_effort: float = 0.01
    """Cost of base motion at one metre from the goal; grows as 1/|e| nearer to it (eq. 8)."""
    manipulability_gain: float = 1.0
    """Reward for motion that makes the arm more manipulable (eq. 9)."""
    heading_gain: float = 0.5
    """k_ε: how strongly the base turns to keep the hand in front of it (eq. 11, 12)."""
    damper_gain: float = 1.0
    """η: joint speed allowed at the influence distance of a joint limit [rad/s] (eq. 13)."""
    damper_stop: float = radians(2.0)
    """ρ_s: distance to a joint limit at which no motion towards it is left [rad] (eq. 13)."""
    damper_influence: float = radians(50.0)
    """ρ_i: distance to a joint limit at which slowing down begins [rad] (eq. 13)."""
    servo_gain: float = 4.0
    """β: end-effector speed per metre or radian of error near the goal [1/s] (eq. 17)."""
    servo_deceleration: float = 1.0
    """Deceleration that the approach to a goal is planned with [m/s^2]."""
    servo_turn_deceleration: float = 3.0
    """The same for the end effector's rotation [rad/s^2]."""
    smallest_error: float = 0.005
    """The weights that grow as 1/|e| stop growing here [m]."""

"""The terms of the holistic controller, with the symbols of the paper, and its presets."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import Literal


@dataclass(frozen=True, kw_only=True)
class ControllerSettings:
    """How the terms of the quadratic qp weigh against each other.

    The defaults are the preset `frankie`; `PAPER` is the published controller.
    """

    period: float = 0.01
    """Control period [s]."""

    # The qp of the paper.
    arm_effort: float = 0.01
    """k_a: cost of joint motion (Haviland 2022, eq. 8)."""
    base_effort: float = 0.01
    """Cost of base motion at one metre from the goal; grows as 1/|e| nearer to it (eq. 8)."""
    manipulability_of: Literal["none", "whole body", "arm"] = "arm"
    """Ĵ_m: what is to become more manipulable (eq. 9, 10 and Table III)."""
    manipulability_gain: float = 1.0
    """Reward for motion that makes it more manipulable (eq. 9)."""
    heading_gain: float = 0.1
    """k_ε: how strongly the base turns to keep the hand in front of it (eq. 11, 12)."""
    damper_gain: float = 1.0
    """η: joint speed allowed at the influence distance of a joint limit [rad/s] (eq. 13)."""
    damper_stop: float = 0.03
    """ρ_s: distance to a joint limit at which no motion towards it is left [rad] (eq. 13)."""
    damper_influence: float = 0.3
    """ρ_i: distance to a joint limit at which slowing down begins [rad] (eq. 13)."""
    servo_gain: float = 4.0
    """β: end-effector speed per metre of error near the goal [1/s] (eq. 17)."""
    rotation_gain: float = 4.0
    """The same per radian [1/s]."""
    smallest_error: float = 0.005
    """The weights that grow as 1/|e| stop growing here [m]."""
    rotation_error: Literal["rotation vector", "roll pitch yaw"] = "rotation vector"
    """How the difference of two orientations becomes a vector (eq. 17)."""
    distance: Literal["euclidean", "manhattan"] = "euclidean"
    """|e| of the weights: the norm of the position error in the end effector's axes."""

    # What makes it smooth and keeps the robot whole.
    servo_deceleration: float = 1.0
    """Deceleration that the approach to a goal is planned with [m/s^2]; inf for eq. 17 alone."""
    servo_turn_deceleration: float = 3.0
    """The same for the end effector's rotation [rad/s^2]."""
    limit_acceleration: bool = True
    """Whether the bounds keep the acceleration limits and brake for joint limits."""
    lag: float = 0.03
    """How far the joints may be behind their commands while they brake for a limit [s]."""
    smoothness: float = 3.0
    """Cost of changing the velocities from one period to the next while under way."""
    avoid_contact: bool = True
    """Whether the arm keeps off itself, the base and the floor."""
    contact_influence: float = 0.12
    """Distance between parts at which they begin to approach more slowly [m]."""
    contact_stop: float = 0.01
    """Distance between parts at which they do not approach any longer [m]."""
    contact_gain: float = 8.0
    """Speed of approach per distance left just before the stop [1/s]."""
    contact_deceleration: float = 1.0
    """Deceleration that parts farther from each other can count on [m/s^2]."""

    # What leads out of local minima.
    guidance: bool = True
    """Whether far goals are approached towards a posture that is known to reach them."""
    base_guidance: float = 1.0
    """Weight of the base's way to where it will stand."""
    posture_guidance: float = 0.5
    """Weight of the arm's way to that posture."""
    bearing_cost: float = 4.0
    """Time that a posture may cost more for a smaller |θ_ε| [s/rad]."""
    dexterity_cost: float = 60.0
    """Time that a posture may cost more for its manipulability below `dexterity` [s]."""
    dexterity: float = 0.10
    """Manipulability from which a posture is not preferred any more."""
    patience: float = 1.0
    """No progress for this long is a stall [s]."""


PAPER = ControllerSettings(
    manipulability_gain=1.0,
    heading_gain=0.5,
    damper_stop=0.1,
    damper_influence=0.9,
    servo_gain=1.5,
    rotation_gain=1.5 * 1.3,
    smallest_error=1e-6,
    rotation_error="roll pitch yaw",
    distance="manhattan",
    servo_deceleration=inf,
    servo_turn_deceleration=inf,
    limit_acceleration=False,
    smoothness=0.0,
    avoid_contact=False,
    guidance=False,
)
"""The published controller with the numbers of its published example. The paper itself prints
another |e| (Euclidean), no extra gain for rotation, and dampers of 2° and 50°."""

PRESETS = {"frankie": ControllerSettings(), "paper": PAPER}
"""The presets by name; `frankie` is the default."""

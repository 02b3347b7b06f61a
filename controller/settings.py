"""Settings and presets of the holistic controller.

Symbols and equation numbers are those of Haviland, Sünderhauf and Corke, "A Holistic Approach to
Reactive Mobile Manipulation", RA-L 2022.
"""

from dataclasses import dataclass, fields
from math import inf
from typing import Any, ClassVar, Literal


class Checked:
    """Base of frozen dataclasses of settings: no number is NaN or negative.

    A subclass names in `POSITIVE` those that may not be zero either.

    Raises:
        ValueError: names the setting and says what it must be.
    """

    POSITIVE: ClassVar[tuple[str, ...]] = ()

    def __post_init__(self) -> None:
        settings: Any = self
        for name in (field.name for field in fields(settings)):
            value = getattr(self, name)
            if isinstance(value, bool) or not isinstance(value, int | float):
                continue
            setting = f"`{name}` of {type(self).__name__}"
            if name in self.POSITIVE and not value > 0.0:
                raise ValueError(f"{setting} must be a number above 0, got {value}")
            if not value >= 0.0:
                raise ValueError(f"{setting} must be at least 0, got {value}")


@dataclass(frozen=True, kw_only=True)
class ServoSettings(Checked):
    """How end effector and base approach their goals: position-based servoing (eq. 17)."""

    POSITIVE = ("gain", "rotation_gain", "deceleration", "turn_deceleration")

    gain: float = 4.0  # β: speed per metre of error near the goal [1/s]
    rotation_gain: float = 4.0  # the same per radian, of the end effector [1/s]
    rotation_error: Literal["rotation vector", "roll pitch yaw"] = "rotation vector"
    """How the difference between two orientations becomes a vector."""
    deceleration: float = 1.0  # deceleration assumed for the approach [m/s^2]; inf for eq. 17 alone
    turn_deceleration: float = 3.0  # the same for rotations [rad/s^2]
    steadying: float = 0.1  # time constant of the low-pass filter of the twist near the goal [s]


@dataclass(frozen=True, kw_only=True)
class JointLimitSettings(Checked):
    """Velocity dampers before the joint limits (eq. 15, 16), and braking for them."""

    stop_distance: float = 0.03  # ρ_s: distance to a limit at which motion towards it stops [rad]
    influence_distance: float = 0.3  # ρ_i: distance to a limit at which the damper begins [rad]

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.influence_distance > self.stop_distance:
            raise ValueError("`influence_distance` must be larger than `stop_distance`")


@dataclass(frozen=True, kw_only=True)
class ControllerSettings(Checked):
    """Weights of the QP and settings of its parts.

    The defaults are the preset `frankie`; `PAPER` is the published controller.
    """

    POSITIVE = ("period", "min_error", "slow_periods")

    period: float = 0.01  # control period [s]

    # The QP of the paper.
    min_error: float = 0.005
    """The weights that grow as 1/|e|, λ_q of the base and λ_δ, stop growing here [m]."""
    error_norm: Literal["euclidean", "manhattan"] = "euclidean"
    """|e| of these weights: the norm of the position error in the end effector's axes."""
    manipulability_of: Literal["none", "whole body", "arm"] = "arm"
    """Ĵ_m: the part of the chain whose manipulability is maximised (eq. 12 and Table III)."""
    heading_gain: float = 0.1
    """k_ε: how strongly the base turns to keep the hand in front of it (eq. 13 and Table II)."""

    servo: ServoSettings = ServoSettings()
    joint_limits: JointLimitSettings = JointLimitSettings()

    # Not in the paper.
    limit_acceleration: bool = True  # keep the acceleration limits and brake for joint limits
    smoothness: float = 3.0  # cost of changing the velocities from one period to the next
    collision: bool = True  # avoid collisions
    slow_periods: int = 3
    """Periods between computations of what changes slowly: Ĵ_m, and the bias on a free way."""
    guidance: bool = True
    """Lead base and arm to stances; without, the end effector may get stuck in local minima."""


PAPER = ControllerSettings(
    slow_periods=1,
    heading_gain=0.5,
    min_error=1e-6,
    error_norm="manhattan",
    servo=ServoSettings(
        gain=1.5,
        rotation_gain=1.5 * 1.3,
        rotation_error="roll pitch yaw",
        deceleration=inf,
        turn_deceleration=inf,
        steadying=0.0,
    ),
    joint_limits=JointLimitSettings(stop_distance=0.1, influence_distance=0.9),
    limit_acceleration=False,
    smoothness=0.0,
    collision=False,
    guidance=False,
)
"""The published controller with the numbers of its published example. The paper itself prints
another |e| (Euclidean), no extra gain for rotation, a base effort of 1, and dampers of 2° and 50°.
The example's bounds of ±10 on the slack (X± in eq. 6), reached only more than 6 m from the goal,
are left out."""

PRESETS = {"frankie": ControllerSettings(), "paper": PAPER}  # by name; `frankie` is the default

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

    POSITIVE = (
        "gain",
        "rotation_gain",
        "straight_gain",
        "deceleration",
        "turn_deceleration",
        "joint_deceleration",
    )

    gain: float = 4.0  # β: speed per metre of error near the goal [1/s]
    rotation_gain: float = 4.0  # the same per radian, of the end effector [1/s]
    straight_gain: float = 6.0
    """Both for straight motion with guidance, where the arm compensates for the lag of the base
    [1/s]."""
    rotation_error: Literal["rotation vector", "roll pitch yaw"] = "rotation vector"
    """How the difference between two orientations becomes a vector."""
    deceleration: float = 1.0  # deceleration assumed for the approach [m/s^2]; inf for eq. 17 alone
    turn_deceleration: float = 3.0  # the same for rotations [rad/s^2]
    joint_deceleration: float = 0.5
    """Deceleration towards a posture, as a share of the smallest joint acceleration limit."""
    steadying: float = 0.1  # time constant of the low-pass filter of the twist near the goal [s]
    straight_steadying: float = 0.04  # the same for straight motion with guidance [s]


@dataclass(frozen=True, kw_only=True)
class JointLimitSettings(Checked):
    """Velocity dampers before the joint limits (eq. 15, 16), and braking for them."""

    POSITIVE = ("damper_gain",)

    damper_gain: float = 1.0  # η: joint speed allowed at the influence distance [rad/s]
    stop_distance: float = 0.03  # ρ_s: distance to a limit at which motion towards it stops [rad]
    influence_distance: float = 0.3  # ρ_i: distance to a limit at which the damper begins [rad]
    return_speed: float = 0.2  # largest speed of a joint that returns into its limits [rad/s]

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.influence_distance > self.stop_distance:
            raise ValueError("`influence_distance` must be larger than `stop_distance`")


@dataclass(frozen=True, kw_only=True)
class CollisionSettings(Checked):
    """Velocity dampers between shapes; see `controller/collision/distance_constraints.py`."""

    POSITIVE = ("influence_distance", "braking", "max_deceleration", "delay_periods")

    stop_distance: float = 0.02  # d_s: distance at which the approach to an obstacle ends [m] ...
    near_stop_distance: float = 0.01
    """... for straight motion, and from the robot to itself and the floor ..."""
    palm_stop_distance: float = 0.001  # ... and for the palm where the hand may touch [m]
    influence_distance: float = 0.6
    """d_i: farther obstacles are ignored [m]; at least d_s + v²/2a + v times the delay, for the
    fastest approach."""
    self_influence_distance: float = 0.25  # the same from the robot to itself and the floor [m]
    braking: float = 0.8  # share of the acceleration limits assumed for braking
    max_deceleration: float = 2.0  # largest deceleration assumed for braking [m/s^2]
    min_deceleration: float = 0.2  # smallest deceleration assumed for braking [m/s^2]
    delay_periods: float = 3.0  # delay before a pair brakes, besides the lags [control periods]
    return_gain: float = 4.0  # speed at which shapes separate, per distance below d_s [1/s] ...
    return_speed: float = 0.2  # ... and at most [m/s]
    most_margin: float = 0.05
    """The robot stops so much farther from fixtures as their places are uncertain, and at most by
    this [m]."""


@dataclass(frozen=True, kw_only=True)
class GuidanceSettings(Checked):
    """When and how strongly base and arm are led to a stance that reaches the goal.

    The blend s in [0, 1] moves the weight from the end effector (0) to base and arm (1).
    """

    POSITIVE = (
        "fade_length",
        "fade_base",
        "fade_heading",
        "fade_joint",
        "posture_rate",
        "joint_speed",
    )

    # Weights in the QP.
    base_weight: float = 2.0  # weight of the base velocity towards the stance, at s = 1
    posture_weight: float = 0.5  # weight of the joint velocities towards the posture, at s = 1
    min_tracking: float = 0.1  # weight of the end-effector twist at s = 1
    min_posture: float = 0.1  # share of `posture_weight` at s = 0: keeps the elbow posture

    # How s depends on the remaining motion.
    metres_per_radian: float = 0.3  # distance equivalent to one radian of orientation error [m]
    fade_distance: float = 0.10  # nearer to the goal than this s is 0 [m] ...
    fade_length: float = 0.5  # ... and it is at most 1 after this much more [m]
    fade_base: float = 0.4  # s fades nearer to the base pose of the stance than this [m] ...
    fade_heading: float = 0.6  # ... and than this to its heading [rad] ...
    fade_joint: float = 0.8  # ... and than this to its posture, by the largest joint error [rad]

    # How fast the arm moves to the posture of the stance.
    posture_rate: float = 3.0  # largest rate [1/s]
    posture_time: float = 0.4  # share of the base's driving time that the arm takes
    joint_speed: float = 0.7  # share of the joint speed limits that it may use

    # Which goals get a stance.
    stance_distance: float = 0.35  # a new goal nearer than this gets no stance until a stall [m]
    goal_jump: float = 0.1  # a goal that moves this far in one period is a new goal [m] ...
    goal_turn: float = 0.3  # ... or turns this far [rad]
    goal_rise: float = 0.05
    """A goal that has drifted up or down this far needs another stance [m] ..."""
    goal_tilt: float = 0.97  # ... or has tilted this far [cosine of the angle]

    # Stalls and detours.
    progress: float = 1e-3  # least progress of end effector, base or arm [m, s and rad]
    patience: float = 1.0  # no progress for this long is a stall [s]
    close_distance: float = 0.06  # nearer there is no stall, and a detour is over [m]
    detours: int = 4  # largest number of detours for one goal


@dataclass(frozen=True, kw_only=True)
class ControllerSettings(Checked):
    """Weights of the QP and settings of its parts.

    The defaults are the preset `frankie`; `PAPER` is the published controller.
    """

    POSITIVE = ("period", "min_error", "slow_periods")

    period: float = 0.01  # control period [s]

    # The QP of the paper.
    arm_effort: float = 0.01  # k_a: cost of joint motion, λ_q of the arm (eq. 14)
    base_effort: float = 0.01
    """Cost of base motion one metre from the goal; λ_q of the base grows as 1/|e| (eq. 14). The
    paper prints 1, its published example has 0.01."""
    resting_effort: float = 20.0  # cost of base motion added for goals with `base_rests`
    min_error: float = 0.005
    """The weights that grow as 1/|e|, λ_q of the base and λ_δ, stop growing here [m]."""
    error_norm: Literal["euclidean", "manhattan"] = "euclidean"
    """|e| of these weights: the norm of the position error in the end effector's axes."""
    manipulability_of: Literal["none", "whole body", "arm"] = "arm"
    """Ĵ_m: the part of the chain whose manipulability is maximised (eq. 12 and Table III)."""
    manipulability_gain: float = 1.0  # factor of Ĵ_m in C (eq. 11)
    heading_gain: float = 0.1
    """k_ε: how strongly the base turns to keep the hand in front of it (eq. 13 and Table II)."""

    servo: ServoSettings = ServoSettings()
    joint_limits: JointLimitSettings = JointLimitSettings()

    # Not in the paper.
    limit_acceleration: bool = True  # keep the acceleration limits and brake for joint limits
    smoothness: float = 3.0  # cost of changing the velocities from one period to the next
    collision: CollisionSettings | None = CollisionSettings()  # None for no collision avoidance
    slow_periods: int = 3
    """Periods between computations of what changes slowly: Ĵ_m, and the bias on a free way."""
    guidance: GuidanceSettings | None = GuidanceSettings()
    """None for no stances: the end effector may get stuck in local minima."""


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
    collision=None,
    guidance=None,
)
"""The published controller with the numbers of its published example. The paper itself prints
another |e| (Euclidean), no extra gain for rotation, a base effort of 1, and dampers of 2° and 50°.
The example's bounds of ±10 on the slack (X± in eq. 6), reached only more than 6 m from the goal,
are left out."""

PRESETS = {"frankie": ControllerSettings(), "paper": PAPER}  # by name; `frankie` is the default

"""The settings of the holistic controller, with the symbols of the paper, and its presets.

The paper is Haviland, Sünderhauf and Corke, "A Holistic Approach to Reactive Mobile Manipulation",
RA-L 2022; equation numbers are its own.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import inf
from typing import Literal

from controller.checked import Checked
from controller.stance_settings import StanceSettings


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

    gain: float = 4.0
    """β: speed per metre of error near the goal [1/s]."""
    rotation_gain: float = 4.0
    """The same per radian, of the end effector [1/s]."""
    straight_gain: float = 6.0
    """Both where guided end effectors go straight: the arm, which is quick, makes up for the lag of
    the base there [1/s]."""
    rotation_error: Literal["rotation vector", "roll pitch yaw"] = "rotation vector"
    """How the difference between two orientations becomes a vector."""
    deceleration: float = 1.0
    """Deceleration that the approach is planned with [m/s^2]; inf for eq. 17 alone."""
    turn_deceleration: float = 3.0
    """The same for rotations [rad/s^2]."""
    joint_deceleration: float = 0.5
    """Deceleration towards a posture, as a share of the smallest acceleration limit of a joint: the
    other half is left to start with and to correct."""
    steadying: float = 0.1
    """Time constant with which the twist follows the error near the goal [s]; 0 follows at once."""
    straight_steadying: float = 0.04
    """The same where guided end effectors go straight [s]."""


@dataclass(frozen=True, kw_only=True)
class JointLimitSettings(Checked):
    """Velocity dampers before the joint limits (eq. 15, 16), and braking for them."""

    POSITIVE = ("damper_gain",)

    damper_gain: float = 1.0
    """η: joint speed allowed at the influence distance [rad/s]."""
    stop_distance: float = 0.03
    """ρ_s: distance to a limit at which no motion towards it is left [rad]."""
    influence_distance: float = 0.3
    """ρ_i: distance to a limit at which slowing down begins [rad]."""
    return_speed: float = 0.2
    """A joint outside its limits comes back no faster than this [rad/s]."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.influence_distance > self.stop_distance:
            raise ValueError("`influence_distance` must be larger than `stop_distance`")


@dataclass(frozen=True, kw_only=True)
class CollisionSettings(Checked):
    """Velocity dampers between shapes, from whose speed the robot can always brake.

    They keep it off itself, the floor and what stands around; see
    `controller/collision/distance_constraints.py`.
    """

    POSITIVE = ("influence_distance", "braking", "max_deceleration", "delay_periods")

    stop_distance: float = 0.02
    """d_s: distance at which the robot does not approach what stands around any longer [m] ..."""
    near_stop_distance: float = 0.01
    """... for goals that are reached straight, and from the robot to itself and the floor ..."""
    palm_stop_distance: float = 0.001
    """... and for the palm where the hand may touch, as when fingers close beside a wall [m]."""
    influence_distance: float = 0.6
    """d_i: nothing that is farther from the robot matters [m]; at least d_s + v²/2a + v times the
    delay, for the fastest approach."""
    self_influence_distance: float = 0.25
    """The same from the robot to itself and the floor [m]: hand and upper arm close at 0.9 m/s."""
    braking: float = 0.8
    """Share of the acceleration limits that braking is planned with."""
    max_deceleration: float = 2.0
    """Braking is never planned with more than this [m/s^2], however many joints could help."""
    min_deceleration: float = 0.2
    """Nor with less, where the degrees of freedom hardly move the pair [m/s^2]."""
    delay_periods: float = 3.0
    """Besides the lag of base or arm, a pair goes on for this many periods before it brakes."""
    return_gain: float = 4.0
    """Speed at which shapes part per distance that is missing to d_s [1/s] ..."""
    return_speed: float = 0.2
    """... and at most [m/s]."""


@dataclass(frozen=True, kw_only=True)
class DriveSettings(Checked):
    """How a differential drive steers to a pose (Park and Kuipers, ICRA 2011)."""

    POSITIVE = ("pivot_blend", "arrival_distance", "detour")

    heading_gain: float = 0.6
    """k1: how strongly the path bends to arrive with the goal's heading."""
    detour: float = 0.6
    """To arrive with the goal's heading the path swings out no farther than this from the straight
    way [m]: farther away it is the tangent of a circle of this radius around the goal."""
    curvature_gain: float = 2.0
    """k2: how fast the base turns onto that path."""
    curvature_slowdown: float = 0.1
    """β: how much slower it drives where the path is curved [m^2]."""
    pivot_angle: float = 0.6
    """Misalignment with the path from which it turns more than it drives [rad]."""
    pivot_blend: float = 0.8
    """Misalignment beyond that at which it does not drive at all [rad]."""
    arrival_distance: float = 0.06
    """Nearer than this it only turns to its final heading and creeps along its axis [m]."""


@dataclass(frozen=True, kw_only=True)
class GuidanceSettings(Checked):
    """When and how strongly base and arm are led to a stance that reaches the goal."""

    POSITIVE = (
        "fade_length",
        "fade_base",
        "fade_heading",
        "fade_joint",
        "posture_rate",
        "joint_speed",
    )

    stance: StanceSettings = field(default_factory=StanceSettings)

    # Weights in the QP.
    base_weight: float = 2.0
    """Weight of the base's velocity towards its place, at s = 1."""
    posture_weight: float = 0.5
    """Weight of the joint velocities towards the posture, at s = 1."""
    min_tracking: float = 0.1
    """Weight of the end effector's twist that is left at s = 1, so that the hand keeps its way to
    the goal where the stance does not mind."""
    min_posture: float = 0.1
    """Share of `posture_weight` that is left at s = 0, so that the elbow stays where the stance has
    it while the end effector arrives."""

    # How s depends on what is left to do.
    metres_per_radian: float = 0.3
    """What one radian of orientation error counts like [m]."""
    fade_distance: float = 0.10
    """Nearer to the goal than this s is 0 [m] ..."""
    fade_length: float = 0.5
    """... and it is at most 1 after this much more [m]."""
    fade_base: float = 0.4
    """s fades nearer to the place of the base than this [m] ..."""
    fade_heading: float = 0.6
    """... and than this to its heading [rad] ..."""
    fade_joint: float = 0.8
    """... and than this to the posture, in the joint that is farthest [rad]."""

    # How fast the arm folds into the posture.
    posture_rate: float = 3.0
    """Largest rate [1/s]."""
    posture_time: float = 0.4
    """Share of the base's driving time that it takes: the arm is ready before the base arrives."""
    joint_speed: float = 0.7
    """Share of the joint speed limits that it may use."""

    # Which goals get a stance.
    min_distance: float = 0.35
    """A new goal nearer than this is left to the end effector until that stalls [m]."""
    goal_jump: float = 0.1
    """A goal that moves this far in one period is another goal [m] ..."""
    goal_turn: float = 0.3
    """... or turns this far [rad]."""
    goal_rise: float = 0.05
    """A goal that has crept up or down this far needs another stance [m] ..."""
    goal_tilt: float = 0.97
    """... or has tilted this far [cosine of the angle]."""

    # Stalls and detours.
    progress: float = 1e-3
    """What counts as progress of end effector, base or arm [m, s and rad]."""
    patience: float = 1.0
    """No progress for this long is a stall [s]."""
    close: float = 0.06
    """Nearer to the goal than this nothing is a stall, and a detour is over [m]."""
    detours: int = 4
    """After this many stalls before the same goal the end effector goes on alone."""


@dataclass(frozen=True, kw_only=True)
class OnwardSettings(Checked):
    """How the base sets out for the next goal while the end effector is busy with this one."""

    POSITIVE = ("spare_manipulability", "spare_limit_margin")

    speed: float = 0.4
    """Largest speed of the base meanwhile [m/s]."""
    base_weight: float = 0.1
    """Of the base's velocity in the QP, as a share of the end effector's λ_δ."""
    acceleration: float = 0.6
    """Share of its acceleration that it uses: the arm has to make up for it at once."""
    least_manipulability: float = 0.08
    """Of the arm, at which the base stops ..."""
    spare_manipulability: float = 0.04
    """... and so much above that it still has its full speed."""
    least_limit_margin: float = 0.1
    """Of the arm's joints to their limits, at which the base stops [rad] ..."""
    spare_limit_margin: float = 0.15
    """... and so much above that it still has its full speed [rad]."""


@dataclass(frozen=True, kw_only=True)
class ControllerSettings(Checked):
    """How the terms of the QP weigh against each other, and what surrounds it.

    The defaults are the preset `frankie`; `PAPER` is the published controller.
    """

    POSITIVE = ("period", "min_error")

    period: float = 0.01
    """Control period [s]."""

    # The QP of the paper.
    arm_effort: float = 0.01
    """k_a: cost of joint motion, λ_q of the arm (eq. 14)."""
    base_effort: float = 0.01
    """Cost of base motion one metre from the goal; λ_q of the base grows as 1/|e| (eq. 14). The
    paper prints 1, its published example has 0.01."""
    min_error: float = 0.005
    """The weights that grow as 1/|e|, λ_q of the base and λ_δ, stop growing here [m]."""
    error_norm: Literal["euclidean", "manhattan"] = "euclidean"
    """|e| of these weights: the norm of the position error in the end effector's axes."""
    manipulability_of: Literal["none", "whole body", "arm"] = "arm"
    """Ĵ_m: which part of the chain is to become more manipulable (eq. 12 and Table III)."""
    manipulability_gain: float = 1.0
    """Reward for motion that makes it more manipulable, a factor of Ĵ_m in C (eq. 11)."""
    heading_gain: float = 0.1
    """k_ε: how strongly the base turns to keep the hand in front of it (eq. 13 and Table II)."""

    servo: ServoSettings = ServoSettings()
    joint_limits: JointLimitSettings = JointLimitSettings()

    # What the paper does not have.
    limit_acceleration: bool = True
    """Whether the bounds keep the acceleration limits and brake for joint limits."""
    smoothness: float = 3.0
    """Cost of changing the velocities from one period to the next."""
    collision: CollisionSettings | None = CollisionSettings()
    """None lets the robot touch itself, the floor and everything else."""
    drive: DriveSettings = DriveSettings()
    onward: OnwardSettings = OnwardSettings()
    guidance: GuidanceSettings | None = GuidanceSettings()
    """None leaves every goal to the end effector alone, local minima included."""


PAPER = ControllerSettings(
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
The example's bounds of ±10 on the slack (X± in eq. 6) are left out: a slack reaches them only more
than 6 m from the goal."""

PRESETS = {"frankie": ControllerSettings(), "paper": PAPER}
"""The presets by name; `frankie` is the default."""

"""Stance bias: the terms that guidance adds to the QP, and what they depend on.

Far from the goal base and arm are led to the stance, near the goal the end effector takes over. A
blend s in [0, 1] moves the weights from one to the other: with base velocities v towards the base
pose of the stance, joint velocities w towards its posture, and their weights λ_v and λ_w, both of
them growing with s, the cost gains

    ½ λ_v |q̇_base - v|² + ½ λ_w |q̇_arm - w|²,    and λ_δ becomes (1 - s)² λ_δ + λ_s.
"""

from math import hypot, inf
from typing import NamedTuple

import numpy as np

from config.planar import ORIGIN, Pose2D
from controller.command import Array
from controller.floor.base_drive import STAY, Lead
from controller.settings import GuidanceSettings


class StanceBias(NamedTuple):
    """Terms of one QP towards a stance."""

    blend: float  # s: 0 leaves the motion to the end effector, 1 to base and arm
    min_tracking: float  # λ_s, weight of the end-effector twist at s = 1; 0 on a detour
    base_weight: float  # λ_v
    base_velocity: Array  # v (n_base,)
    posture_weight: float  # λ_w
    pull: Array  # (n,) v and w times their weights
    coasting: Array | None = None  # (n_base,) present velocity of a lagging base; None without lag
    response: float = 1.0  # share of a commanded change that the base takes up, in (0, 1]


class Remaining(NamedTuple):
    """Remaining motion to a goal and its stance."""

    distance: float  # of the end effector to the goal, rotation included [m]
    base_target: Pose2D = ORIGIN  # base pose of the stance in the base frame
    lead: Lead = STAY  # where the base is led now
    joint_error: Array = np.zeros(0)  # (j,) from the joint positions to the posture [rad]
    max_joint_error: float = 0.0  # the largest of these [rad]
    joint_time: float = 0.0  # time of the joints at full speed [s]
    in_transport: bool = False  # whether the posture is the transport posture
    docks: bool = False  # whether the base is led to the dock

    @property
    def hand_waits(self) -> bool:
        """Whether the end effector waits for base and arm."""
        return self.in_transport or self.docks

    def blend(self, g: GuidanceSettings, *, to_the_end: bool) -> float:
        """s: share of the motion that is led by the stance; `to_the_end` that is all until it."""
        if self.hand_waits or not self.lead.final:
            return 1.0
        x, y, turn = self.base_target
        left = hypot(x, y) / g.fade_base, abs(turn) / g.fade_heading
        near = inf if to_the_end else max(0.0, (self.distance - g.fade_distance) / g.fade_length)
        return min(1.0, near, max(*left, self.max_joint_error / g.fade_joint))

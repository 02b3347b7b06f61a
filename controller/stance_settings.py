"""The settings of the choice of a stance."""

from __future__ import annotations

from dataclasses import dataclass

from controller.checked import Checked


@dataclass(frozen=True, kw_only=True)
class StanceSettings(Checked):
    """What a stance costs. Costs are in seconds: a stance is preferred for the time it saves."""

    POSITIVE = ("arm_speed",)

    # How long it takes to get there.
    arm_speed: float = 0.5
    """Share of their speed limits that the joints are expected to move at."""
    turn_weight: float = 1.2
    """Factor of the time that the base turns: its curves take longer than turns on the spot."""
    reverse_cost: float = 0.4
    """What driving there backwards costs, times `turn_weight` [s]."""
    overlap: float = 0.3
    """Base and arm move together; the share of the shorter of their times that is still added."""

    # How good it is there.
    min_manipulability: float = 0.10
    """Manipulability below which a posture costs something."""
    manipulability_cost: float = 60.0
    """Cost per manipulability below that [s]."""
    bearing_cost: float = 4.0
    """Cost per |θ_ε|, the bearing of the end effector seen from the base, where the end effector
    points sideways: the base carries it in, so it has to be in front [s/rad] ..."""
    bearing_cost_down: float = 0.3
    """... and where it points down, as the arm alone lowers it [s/rad]."""
    limit_margin: float = 0.12
    """No posture is nearer to a joint limit than this [rad]."""
    preferred_limit_margin: float = 0.35
    """A posture nearer to a joint limit than this costs something [rad]."""
    limit_cost: float = 2.0
    """Cost per distance missing to that [s/rad]."""

    # What rules it out, unless there is no other.
    clearance: float = 0.02
    """The straight path to the posture keeps this distance from the robot, the floor and what
    stands around [m]."""
    standing_room: float = 0.05
    """The base keeps this distance from what stands around [m]."""
    contact_cost: float = 1000.0
    """Cost per distance missing to that [s/m]."""
    unreached_cost: float = 100.0
    """Cost of a posture that could not be brought to the goal's height and tilt, and the same again
    per metre and radian that is left [s]."""
    failed_cost: float = 50.0
    """Cost of a posture that was tried for the same goal and stalled [s]; a stance that costs less
    than this is good enough to end the search."""
    joint_difference: float = 0.7
    """Postures are the same if no joint differs by more than this [rad]."""

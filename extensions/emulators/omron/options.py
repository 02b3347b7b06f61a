"""Options and reported behaviours of an emulated base."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import inf

from extensions.emulators.common import chosen, reported, set_options
from extensions.emulators.omron.onboard_controller import Motion, Teleop

EVERYTHING = frozenset({"Movement", "Stop", "RobotInfo", "SensorInfo", "UnsafeMovement", "Config"})
"""All access groups."""


@dataclass(kw_only=True)
class Options:
    """Of one emulated base; may be changed while it runs."""

    host: str = "127.0.0.1"
    port: int = 0  # of ArNetworking; 0: any free one. The robot's is 7272
    arcl_port: int = 0  # of the text interface; 0: any free one. The robot's is 7171
    users: dict[str, tuple[str, frozenset[str]]] = field(
        default_factory=lambda: {"frankie": ("", EVERYTHING)}
    )
    """Passwords and access groups by user."""
    arcl_password: str = "adept"  # of the text interface; empty: there is none
    protocol: str = "5MTX"
    seed: int = 0  # of the numbers of requests, of jitter and of pieces
    teleop: Teleop = field(default_factory=Teleop)
    motion: Motion = field(default_factory=Motion)
    omit: frozenset[str] = frozenset()  # requests that this base does not offer
    data_store_kind: bytes = b"d"  # the byte before a value of the data store
    score_scale: float = 1000.0  # a full localisation score on the wire
    score: float = 0.87  # localisation score, 0 to 1
    lost: bool = False  # whether localisation is lost
    offset: tuple[float, float, float] = (0.0, 0.0, 0.0)  # of the reported pose [m, m, rad]
    charge: float = 0.87  # of the battery, 0 to 1
    pieces: bool = False  # whether it writes a few bytes at a time
    jitter: float = 0.0  # largest additional delay of replies [s]
    delay: float = 0.0  # of replies [s]
    garbage: bool = False  # whether there are stray bytes and damaged frames between replies
    frozen: bool = False  # whether the server does nothing, as if the cable were pulled
    clients: int = 8  # largest number; more are rejected
    least_interval: float = 0.0  # between two replies to one request [s]
    jumps: float = 0.0  # interval of jumps of its pose on the map [s]; 0: none
    direction: float = 1.0  # -1: forwards is backwards
    clearance: float = inf  # free way in front, for safe driving [m]
    needs_button: bool = False  # after an emergency stop only `push_button` helps
    arcl_clients: int = 8  # largest number on the text interface; more are closed
    arcl_lasts: float = inf  # connections of the text interface are closed after this time [s]


AS_REPORTED = reported("""
dead-zone-larger | 20 % and 10 % do not move it, as it tells | ARIA 2.9: dead zones are of a site
full-scale-lower | 100 % are 0.67 m/s | CollaborativeRoboticsLab/omron_amr: 41.7 % are 0.28 m/s
full-scale-is-top | FullThrottleForwards is 0: the top speed, 1.8 m/s | ARIA 2.9, ArActionRatioInput
timeout-as-delivered | it drives on for 2 s without commands | ARIA 2.9; amor-ros-pkg/rosaria #51
timeout-off | it drives on for ever without commands | ARIA 2.9: a Timeout of 0 is none
timeout-short | it stops between commands 50 ms apart | ARIA 2.9: Timeout may be less than a cycle
safe-drive-blocks | its laser keeps it from going forwards | ARIA 2.9, ArActionDeceleratingLimiter
direction-reversed | it goes back instead of forwards | UbiquityRobotics/ubiquity_motor #9
pose-jumps | it finds itself 0.3 m and 5 degrees away every 2 s | neobotix/neo_localization2 #36
pose-10-hz | replies come 10 times a second at most | qcr/ros_omron_agv, src/robot_status.cpp
brake-button | after an emergency stop only its button switches the motors on | ARCL guide I617-E-01
one-arcl-client | the text interface takes one client | OmronAPAC/Omron_AMR_ROS2 #4, in one reading
arcl-kicks-out | the text interface closes connections after 2 s | OmronAPAC/Omron_AMR_ROS2 #4
""")
"""Reported behaviours by name."""
_VALUES: dict[str, dict[str, object]] = {
    "dead-zone-larger": {"teleop.dead_translation": 20.0, "teleop.dead_rotation": 10.0},
    "full-scale-lower": {"teleop.forwards": 0.67},
    "full-scale-is-top": {"teleop.forwards": 1.8, "teleop.tells_forwards": 0.0},
    "timeout-as-delivered": {"teleop.timeout": 2.0},
    "timeout-off": {"teleop.timeout": 0.0},
    "timeout-short": {"teleop.timeout": 0.03},
    "safe-drive-blocks": {"clearance": 0.05},
    "direction-reversed": {"direction": -1.0},
    "pose-jumps": {"jumps": 2.0},
    "pose-10-hz": {"least_interval": 0.1},
    "brake-button": {"needs_button": True},
    "one-arcl-client": {"arcl_clients": 1},
    "arcl-kicks-out": {"arcl_lasts": 2.0},
}
"""What they are as options."""


def configure(options: Options, as_reported: Sequence[str]) -> None:
    """Set the options of reported behaviours."""
    for name in sorted(chosen(as_reported, AS_REPORTED, "base")):
        set_options(options, _VALUES[name])

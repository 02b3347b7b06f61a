"""Options, faults and reported behaviours of an emulated base."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import inf

from hw.emulators.common import NoFaultError, Reported, chosen, set_options
from hw.emulators.omron.controller import Motion, Teleop

EVERYTHING = frozenset({"Movement", "Stop", "RobotInfo", "SensorInfo", "UnsafeMovement", "Config"})
"""All access groups."""


@dataclass(kw_only=True)
class Options:
    """Of one emulated base; fault options may be changed while it runs."""

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
    offset: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Of the reported pose from the true one [m, m, rad]."""
    charge: float = 0.87  # of the battery, 0 to 1
    pieces: bool = False  # whether it writes a few bytes at a time
    jitter: float = 0.0  # largest additional delay of replies [s]
    delay: float = 0.0  # of replies [s]
    garbage: bool = False  # whether there are stray bytes and damaged frames between replies
    frozen: bool = False  # whether the server does nothing, as if the cable were pulled
    clients: int = 8  # largest number; more are rejected
    least_interval: float = 0.0  # between two replies to one request [s]
    jumps: float = 0.0  # interval of jumps of its pose on the map [s]; 0: none
    heeds_throttle: bool = True  # whether the throttle of `ratioDrive` is obeyed
    direction: float = 1.0  # -1: forwards is backwards
    clearance: float = inf  # free way in front, for safe driving [m]
    needs_button: bool = False
    """Whether only `push_button` switches the motors on after an emergency stop."""
    arcl_clients: int = 8  # largest number on the text interface; more are closed
    arcl_lasts: float = inf  # connections of the text interface are closed after this time [s]


_FINE_POSE = frozenset(f"DataStore_RobotPoseInterpolated_{axis}" for axis in ("X", "Y", "Th"))
_FAULTS: dict[str, tuple[str, dict[str, object]]] = {
    "pieces": ("replies come a few bytes at a time", {"pieces": True}),
    "jitter": ("replies come up to 90 ms late, each by another time", {"jitter": 0.09}),
    "delay": ("replies come 50 ms late", {"delay": 0.05}),
    "garbage": ("stray bytes and damaged frames between the replies", {"garbage": True}),
    "frozen": ("the server accepts connections and does nothing", {"frozen": True}),
    "lost": ("the base does not know where it is", {"lost": True}),
    "locked": ("the base stands in its dock, in a mode that is locked", {}),
    "emergency stop": ("the button is pressed", {}),
    "no fine pose": ("the values of the data store are not offered", {"omit": _FINE_POSE}),
    "no movement": ("the user may not move the base", {}),
    "new protocol": ("the base speaks a protocol version that nobody knows", {"protocol": "9MTX"}),
    "full": ("the base has too many clients", {"clients": 0}),
}
FAULTS: Mapping[str, str] = {name: what for name, (what, _) in _FAULTS.items()}
"""Initial faults by name."""
_ARIA = "source of the open library ARIA 2.9 (ArNetworking)"
AS_REPORTED: Mapping[str, Reported] = {
    "throttle-ignored": Reported(
        "the third argument of ratioDrive counts as 100",
        "BenBurgessLimerick/ros_omron_agv and CollaborativeRoboticsLab/omron_amr, which drove LD "
        "bases, send 100 always; nobody reports that less is heeded",
        {"heeds_throttle": False},
    ),
    "dead-zone-larger": Reported(
        "20 % and 10 % do not move it; it tells so in its configuration",
        f"{_ARIA}: TransDeadZone and RotDeadZone are values of a site",
        {"teleop.dead_translation": 20.0, "teleop.dead_rotation": 10.0},
    ),
    "full-scale-lower": Reported(
        "100 % are 0.67 m/s",
        "CollaborativeRoboticsLab/omron_amr: 41.7 % are 0.28 m/s on an LD-90",
        {"teleop.forwards": 0.67},
    ),
    "full-scale-is-top": Reported(
        "FullThrottleForwards is 0, which stands for the top speed, 1.8 m/s",
        f"{_ARIA}, ArActionRatioInput; the top speed: pioneer-lx.p",
        {"teleop.forwards": 1.8, "teleop.tells_forwards": 0.0},
    ),
    "timeout-as-delivered": Reported(
        "it drives on for 2 s without commands",
        f"{_ARIA}: Timeout is 2 s; amor-ros-pkg/rosaria pull request 51: it ran into equipment",
        {"teleop.timeout": 2.0},
    ),
    "timeout-off": Reported(
        "it drives on for ever without commands",
        f"{_ARIA}: a Timeout of 0 is none",
        {"teleop.timeout": 0.0},
    ),
    "timeout-short": Reported(
        "it stops between commands that are 50 ms apart",
        f"{_ARIA}: Timeout may be less than a cycle",
        {"teleop.timeout": 0.03},
    ),
    "safe-drive-blocks": Reported(
        "it does not go forwards for what its laser sees; it turns and goes back",
        f"{_ARIA}, ArActionDeceleratingLimiter",
        {"clearance": 0.05},
    ),
    "direction-reversed": Reported(
        "it goes back where it should go forwards",
        "UbiquityRobotics/ubiquity_motor issue 9 (another base)",
        {"direction": -1.0},
    ),
    "pose-jumps": Reported(
        "it finds itself 0.3 m and 5 degrees away every 2 s",
        "neobotix/neo_localization2 issue 36 (another base)",
        {"jumps": 2.0},
    ),
    "pose-10-hz": Reported(
        "replies come 10 times a second at most",
        "qcr/ros_omron_agv, src/robot_status.cpp",
        {"least_interval": 0.1},
    ),
    "brake-button": Reported(
        "after an emergency stop a program cannot switch the motors on: its button must be pushed",
        "Omron ARCL guide I617-E-01: EStop relieved but motors still disabled",
        {"needs_button": True},
    ),
    "one-arcl-client": Reported(
        "the text interface takes one client, and closes the connection of a second",
        "OmronAPAC/Omron_AMR_ROS2 issue 4, in one reading",
        {"arcl_clients": 1},
    ),
    "arcl-kicks-out": Reported(
        "the text interface closes its connections after 2 s",
        "OmronAPAC/Omron_AMR_ROS2 issue 4",
        {"arcl_lasts": 2.0},
    ),
    "no-config": Reported(
        "protocol 6MTX; the configuration is told by the text interface only",
        "KalanaRatnayake/ros_omron_agv, CollaborativeRoboticsLab/omron_amr",
        {"protocol": "6MTX", "omit": frozenset({"getConfigBySectionsV4"})},
    ),
}
"""Reported behaviours by name."""


def configure(options: Options, faults: Sequence[str], as_reported: Sequence[str]) -> None:
    """Set the options of initial faults and reported behaviours."""
    for name in sorted(chosen(as_reported, AS_REPORTED, "base")):
        set_options(options, AS_REPORTED[name].values)
    for name in faults:
        if name not in FAULTS:
            raise NoFaultError(name, FAULTS)
        set_options(options, _FAULTS[name][1])
        if name == "no movement":
            options.users = {
                user: (password, groups - {"Movement", "UnsafeMovement"})
                for user, (password, groups) in options.users.items()
            }

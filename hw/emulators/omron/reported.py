"""How real bases were reported to behave, as far as the emulated one usually does not."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType

from hw.emulators.common import Reported, chosen
from hw.emulators.omron.options import Options

_ARIA = "source of the open library ARIA 2.9 (ArNetworking)"


def _set(**values: object) -> Callable[[Options], None]:
    """Gives options these values."""

    def change(options: Options) -> None:
        for name, value in values.items():
            setattr(options, name, value)

    return change


def _teleop(**values: float) -> Callable[[Options], None]:
    """Gives "Teleop settings" these values."""

    def change(options: Options) -> None:
        for name, value in values.items():
            setattr(options.teleop, name, value)

    return change


_WAYS: dict[str, tuple[str, str, Callable[[Options], None]]] = {
    "throttle-ignored": (
        "the third argument of ratioDrive counts as 100",
        "BenBurgessLimerick/ros_omron_agv and CollaborativeRoboticsLab/omron_amr, which drove LD "
        "bases, send 100 always; nobody reports that less is heeded",
        _set(heeds_throttle=False),
    ),
    "dead-zone-larger": (
        "20 % and 10 % do not move it; it tells so in its configuration",
        f"{_ARIA}: TransDeadZone and RotDeadZone are values of a site",
        _teleop(dead_translation=20.0, dead_rotation=10.0),
    ),
    "full-scale-lower": (
        "100 % are 0.67 m/s",
        "CollaborativeRoboticsLab/omron_amr: 41.7 % are 0.28 m/s on an LD-90",
        _teleop(forwards=0.67),
    ),
    "full-scale-is-top": (
        "FullThrottleForwards is 0, which stands for the top speed, 1.8 m/s",
        f"{_ARIA}, ArActionRatioInput; the top speed: pioneer-lx.p",
        _teleop(forwards=1.8, tells_forwards=0.0),
    ),
    "timeout-as-delivered": (
        "it drives on for 2 s without commands",
        f"{_ARIA}: Timeout is 2 s; amor-ros-pkg/rosaria pull request 51: it ran into equipment",
        _teleop(timeout=2.0),
    ),
    "timeout-off": (
        "it drives on for ever without commands",
        f"{_ARIA}: a Timeout of 0 is none",
        _teleop(timeout=0.0),
    ),
    "timeout-short": (
        "it stops between commands that are 50 ms apart",
        f"{_ARIA}: Timeout may be less than a cycle",
        _teleop(timeout=0.03),
    ),
    "safe-drive-blocks": (
        "it does not go forwards for what its laser sees; it turns and goes back",
        f"{_ARIA}, ArActionDeceleratingLimiter",
        _set(clearance=0.05),
    ),
    "direction-reversed": (
        "it goes back where it should go forwards",
        "UbiquityRobotics/ubiquity_motor issue 9 (another base)",
        _set(direction=-1.0),
    ),
    "pose-jumps": (
        "it finds itself 0.3 m and 5 degrees away every 2 s",
        "neobotix/neo_localization2 issue 36 (another base)",
        _set(jumps=2.0),
    ),
    "pose-10-hz": (
        "replies come 10 times a second at most",
        "qcr/ros_omron_agv, src/robot_status.cpp",
        _set(least_interval=0.1),
    ),
    "brake-button": (
        "after an emergency stop a program cannot switch the motors on: its button must be pushed",
        "Omron ARCL guide I617-E-01: EStop relieved but motors still disabled",
        _set(needs_button=True),
    ),
    "one-arcl-client": (
        "the text interface takes one client, and closes the connection of a second",
        "OmronAPAC/Omron_AMR_ROS2 issue 4, in one reading",
        _set(arcl_clients=1),
    ),
    "arcl-kicks-out": (
        "the text interface closes its connections after 2 s",
        "OmronAPAC/Omron_AMR_ROS2 issue 4",
        _set(arcl_lasts=2.0),
    ),
    "no-config": (
        "protocol 6MTX; the configuration is told by the text interface only",
        "KalanaRatnayake/ros_omron_agv, CollaborativeRoboticsLab/omron_amr",
        _set(protocol="6MTX", omit=frozenset({"getConfigBySectionsV4"})),
    ),
}

AS_REPORTED: Mapping[str, Reported] = MappingProxyType(
    {name: Reported(what, source) for name, (what, source, _) in _WAYS.items()}
)
"""Ways by name."""


def behave(options: Options, names: Sequence[str]) -> None:
    """Have a base with these options behave in these ways.

    Raises:
        UserError: there is no such way.
    """
    for name in sorted(chosen(names, AS_REPORTED, "base")):
        _WAYS[name][2](options)

"""How an emulated base is set up, and what can be made to go wrong with it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import inf
from types import MappingProxyType

from hw.emulators.common import NoFaultError
from hw.emulators.omron.controller import Motion, Teleop

EVERYTHING = frozenset({"Movement", "Stop", "RobotInfo", "SensorInfo", "UnsafeMovement", "Config"})
"""All access groups."""


@dataclass(kw_only=True)
class Options:
    """Of one emulated base; what concerns faults may be changed while it runs."""

    host: str = "127.0.0.1"
    port: int = 0
    """Of ArNetworking; 0: one that is free. The robot's is 7272."""
    arcl_port: int = 0
    """Of the text interface; 0: one that is free. The robot's is 7171."""
    users: dict[str, tuple[str, frozenset[str]]] = field(
        default_factory=lambda: {"frankie": ("", EVERYTHING)}
    )
    """Passwords and access groups by user."""
    arcl_password: str = "adept"
    """Of the text interface; there is none without."""
    protocol: str = "5MTX"
    seed: int = 0
    """Of the numbers of requests, of jitter and of pieces."""
    teleop: Teleop = field(default_factory=Teleop)
    motion: Motion = field(default_factory=Motion)
    omit: frozenset[str] = frozenset()
    """Requests that this base does not offer."""
    data_store_kind: bytes = b"d"
    """The byte before a value of the data store."""
    score_scale: float = 1000.0
    """What a full localisation score is on the wire."""
    score: float = 0.87
    """Of the localisation, 0 to 1."""
    lost: bool = False
    """Whether the base does not know where it is."""
    offset: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Of the reported pose from the true one [m, m, rad]."""
    charge: float = 0.87
    """Of the battery, 0 to 1."""
    pieces: bool = False
    """Whether it writes a few bytes at a time."""
    jitter: float = 0.0
    """Replies are held back by up to this [s]."""
    delay: float = 0.0
    """Replies are held back by this [s]."""
    garbage: bool = False
    """Whether stray bytes and damaged frames come in between."""
    frozen: bool = False
    """Whether the server does nothing; as a pulled cable looks from outside."""
    clients: int = 8
    """More are rejected."""
    least_interval: float = 0.0
    """Between two replies to one request [s]."""
    jumps: float = 0.0
    """It finds itself elsewhere on its map this often [s]; 0: never."""
    heeds_throttle: bool = True
    """Of `ratioDrive`."""
    direction: float = 1.0
    """-1: forwards is backwards."""
    clearance: float = inf
    """Free way in front, for safe driving [m]."""
    needs_button: bool = False
    """Whether a person has to switch the motors on after an emergency stop."""
    arcl_clients: int = 8
    """Of the text interface; the connections of more are closed."""
    arcl_lasts: float = inf
    """Connections of the text interface are closed after this [s]."""
    goes_on_after_rejecting: bool = False
    """A fault of the open-source server: after reason 4 it sends CONNECTED and the lists."""


FAULTS: Mapping[str, str] = MappingProxyType(
    {
        "pieces": "replies come a few bytes at a time",
        "jitter": "replies come up to 90 ms late, each by another time",
        "delay": "replies come 50 ms late",
        "garbage": "stray bytes and damaged frames between the replies",
        "frozen": "the server accepts connections and does nothing",
        "lost": "the base does not know where it is",
        "locked": "the base stands in its dock, in a mode that is locked",
        "emergency stop": "the button is pressed",
        "no fine pose": "the values of the data store are not offered",
        "no movement": "the user may not move the base",
        "new protocol": "the base speaks a protocol version that nobody knows",
        "full": "the base has too many clients",
    }
)
"""What can be wrong from the beginning, by name."""


def with_fault(options: Options, name: str) -> Options:
    """The same options with something wrong.

    Raises:
        NoFaultError: nothing is called so.
    """
    match name:
        case "pieces" | "garbage" | "frozen" | "lost":
            setattr(options, name, True)
        case "jitter":
            options.jitter = 0.09
        case "delay":
            options.delay = 0.05
        case "no fine pose":
            options.omit |= {f"DataStore_RobotPoseInterpolated_{axis}" for axis in ("X", "Y", "Th")}
        case "no movement":
            options.users = {
                user: (password, groups - {"Movement", "UnsafeMovement"})
                for user, (password, groups) in options.users.items()
            }
        case "new protocol":
            options.protocol = "9MTX"
        case "full":
            options.clients = 0
        case "locked" | "emergency stop":
            pass  # of the base, not of the server
        case _:
            raise NoFaultError(name, FAULTS)
    return options

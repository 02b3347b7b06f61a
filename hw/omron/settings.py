"""Settings of one LD-60: addresses, accounts, full-scale values and times."""

from __future__ import annotations

from dataclasses import dataclass, field

from hw.omron.site import Site


@dataclass(frozen=True, kw_only=True)
class ArclSettings:
    """The text interface, which exists only where MobilePlanner has a password for it."""

    password: str
    port: int = 7171
    poll: float = 0.25  # polling interval of motors, faults and localisation score [s]
    patience: float = 1.5  # without any answer for this long the connection is lost [s]


@dataclass(frozen=True, kw_only=True)
class OmronSettings:
    """One base; port and users without a password are as reported."""

    host: str
    user: str
    password: str = ""
    port: int = 7272
    arcl: ArclSettings | None = None
    """None: no text interface, so motors, emergency stop and faults are not reported."""
    site: Site = field(default_factory=Site)
    acceleration: float = 1.5
    """Commanded velocities grow no faster than this, whoever commands them [m/s^2]. The limits of
    the robot file hold before, those of the base itself after."""
    turn_acceleration: float = 3.0  # the same for turning [rad/s^2]
    pose_delay: float = 0.0  # age of a pose on arrival [s]
    silence: float = 1.0  # without a byte for this long the connection is lost [s]
    connect_patience: float = 3.0  # timeout of each step of connecting [s]
    lists_patience: float = 5.0  # timeout of the list of requests [s]
    least_score: float | None = None
    """A localisation score below this is a fault, 0 to 1; None: only a lost localisation is."""
    score_scale: float | None = None
    """A full score in `getLocState`: 100 or 1000 (sources disagree); None: unknown, the score is
    not used until one above 100 settles it."""

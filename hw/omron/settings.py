"""What a person tells about one LD-60: where it is, who we are there, and how it is set up."""

from __future__ import annotations

from dataclasses import dataclass, field

from hw.omron.site import Site


@dataclass(frozen=True, kw_only=True)
class ArclSettings:
    """The text interface, which exists only where MobilePlanner has a password for it."""

    password: str
    port: int = 7171
    poll: float = 0.25
    """How often motors, faults and the localisation score are asked for [s]."""
    patience: float = 1.5
    """Without any answer for this long the connection is lost [s]."""


@dataclass(frozen=True, kw_only=True)
class OmronSettings:
    """One base: address and account [reported: port, users without a password], and times."""

    host: str
    user: str
    password: str = ""
    port: int = 7272
    arcl: ArclSettings | None = None
    """None: no text interface; motors, emergency stop and faults are not told then."""
    site: Site = field(default_factory=Site)
    acceleration: float = 1.5
    """Commanded velocities grow no faster than this, whoever commands them [m/s^2]. The limits of
    the robot file hold before, those of the base itself after."""
    turn_acceleration: float = 3.0
    """The same for turning [rad/s^2]."""
    pose_delay: float = 0.0
    """How old a pose is on arrival [s]."""
    pose_interval: float = 0.03
    """How often a pose is asked for [s]; real bases are said to send at most 37 a second."""
    oldest_pose: float = 0.25
    """Up to this age a pose is carried on with the measured velocity; then it is stale [s]."""
    silence: float = 1.0
    """A connection without a byte for this long is lost [s]."""
    resend: float = 0.025
    """How often the velocity is sent again [s]."""
    zero_after: float = 0.1
    """A command older than this counts as a velocity of zero [s]."""
    stop_after: float = 0.2
    """A command older than this is a stop, repeated until the base is at rest [s]."""
    connect_patience: float = 3.0
    """For each step of connecting [s]."""
    lists_patience: float = 5.0
    """For what the robot says that this account may ask for [s]."""
    least_score: float | None = None
    """A localisation score below this is a fault, 0 to 1; None: only what the robot calls lost."""
    score_scale: float | None = None
    """What a full score is in `getLocState`: 100 or 1000 (sources disagree); None: not known, the
    score is not used until one above 100 settles it."""

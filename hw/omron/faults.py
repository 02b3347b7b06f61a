"""What keeps the base from moving, seen from what it tells and from what it does."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from hw.omron.arcl_text import ArclState, Motors
from hw.omron.commander import is_at_rest
from hw.omron.settings import OmronSettings
from hw.omron.site import Velocity
from hw.omron.telemetry import Docking, Localisation, Telemetry
from hw.state import Fault, FaultKind

_STANDS = 0.6
"""A base that is commanded and stands still for this long does not follow [s]."""
_COASTS = 2.5
"""A base that moves this long after it was told to rest is moved by somebody else [s]."""
_NOTICEABLE = Velocity(0.05, 0.1)
"""Slower commands do not tell whether it follows [m/s, rad/s]."""
_MOVES = 0.05
"""A base that is faster than this moves [m/s, rad/s]."""


@dataclass
class Obedience:
    """Compares what the base is told with what it does; a finding stays until it is cleared."""

    finding: str = ""
    _stood_since: float | None = None
    _rests_since: float | None = None

    def watch(self, told: Velocity | None, measured: Velocity, now: float) -> None:
        """Look at what is told (None: nothing) and measured at a moment [s]."""
        is_told = told is not None and (abs(told.v) > _NOTICEABLE.v or abs(told.w) > _NOTICEABLE.w)
        stands, moves = is_at_rest(measured), max(map(abs, measured)) > _MOVES
        self._stood_since = _since(self._stood_since, is_told and stands, now)
        rests = told is not None and is_at_rest(told)
        self._rests_since = _since(self._rests_since, rests, now)
        if self._stood_since is not None and now - self._stood_since > _STANDS:
            self.finding = (
                "the base stands although it is commanded; look for an obstacle before its laser, "
                "a pressed emergency stop, motors that are off, or another program that commands it"
            )
        elif moves and self._rests_since is not None and now - self._rests_since > _COASTS:
            self.finding = (
                "the base moves although it is told to rest: somebody else commands it; close "
                "MobilePlanner's drive mode or the other program"
            )

    def clear(self) -> None:
        """Forget the finding."""
        self.finding, self._stood_since, self._rests_since = "", None, None


def _since(before: float | None, holds: bool, now: float) -> float | None:
    if not holds:
        return None
    return now if before is None else before


_BUMPED = ("Bumped", "Stalled")
"""What the base says of itself when it has run into something [read in the source]."""


def connection_lost(cause: str) -> Fault:
    """The connection is gone; the base stops by its own timeout if nothing else reaches it."""
    return Fault(
        kind=FaultKind.CONNECTION,
        text=f"connection to the base lost: {cause}; check cable, WLAN and that the base is on",
        clearable=True,
    )


def telemetry_faults(
    telemetry: Telemetry, settings: OmronSettings, pose_age: float, score: float | None
) -> Iterator[Fault]:
    """What ArNetworking tells.

    Args:
        telemetry: the newest readings.
        settings: of the base.
        pose_age: of the newest pose [s].
        score: of the localisation, 0 to 1; None where it is not known.
    """
    if pose_age > settings.oldest_pose:
        yield Fault(
            kind=FaultKind.STALE_POSE,
            text=f"no pose of the base for {settings.oldest_pose:g} s; is its network overloaded?",
            clearable=True,
        )
    if telemetry.localisation in (Localisation.LOST, Localisation.INITIALISING):
        yield _unlocalised("the base does not know where it is on its map")
    elif score is not None and settings.least_score is not None and score < settings.least_score:
        yield _unlocalised(f"localisation score {score:.2f}")
    if telemetry.status in _BUMPED:
        yield Fault(
            kind=FaultKind.BUMPER,
            text=f"the base says {telemetry.status!r}: it has met something; free it, then recover",
            clearable=True,
        )
    if telemetry.locked or telemetry.docking in (Docking.DOCKING, Docking.UNDOCKING):
        yield Fault(
            kind=FaultKind.NOT_READY,
            text=f"the base is in mode {telemetry.mode!r} ({telemetry.status}) and does not let go "
            "of it; wait, or end it in MobilePlanner",
            clearable=True,
        )


def arcl_faults(arcl: ArclState) -> Iterator[Fault]:
    """What the text interface tells."""
    if arcl.lost:
        yield Fault(
            kind=FaultKind.CONNECTION,
            text=f"text interface of the base lost: {arcl.lost}; its emergency stop is not seen",
            clearable=True,
        )
    match arcl.motors:
        case Motors.PRESSED:
            yield Fault(
                kind=FaultKind.EMERGENCY_STOP,
                text="emergency stop of the base is pressed; release it",
                clearable=False,
            )
        case Motors.RELIEVED | Motors.DISABLED:
            yield Fault(
                kind=FaultKind.NOT_READY,
                text="the motors of the base are off; press its motor button, or recover",
                clearable=True,
            )
    for name in arcl.faults:
        yield Fault(
            kind=FaultKind.NOT_READY,
            text=f"the base reports {name}; see MobilePlanner",
            clearable=False,
        )


def obedience_faults(obedience: Obedience) -> Iterator[Fault]:
    """What its motion tells."""
    if obedience.finding:
        yield Fault(kind=FaultKind.NOT_READY, text=obedience.finding, clearable=True)


def _unlocalised(what: str) -> Fault:
    return Fault(
        kind=FaultKind.STALE_POSE,
        text=f"{what}; localise it in MobilePlanner",
        clearable=False,
    )

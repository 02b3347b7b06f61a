"""Faults of the base, from its readings and from commanded against measured motion."""

from collections.abc import Iterator
from dataclasses import dataclass
from math import degrees

from drivers.omron.arcl import ArclState, Motors
from drivers.omron.site import Site, Velocity, is_at_rest
from drivers.omron.telemetry import OLDEST_POSE, Localisation, Telemetry
from hw import Fault, FaultKind

_STANDS, _OWED = 0.6, Velocity(0.04, 0.06)  # at rest so long [s] and owing so far [m, rad]
_SURPLUS, _SHARE = Velocity(0.04, 0.1), 0.1
"""A base that is faster than commanded by more than this [m/s, rad/s] plus this share of it ..."""
_TOO_FAST = 0.2  # ... for this long [s] is stopped
_DECELERATION = Velocity(0.3, 0.8)  # assumed, of earlier commands [m/s^2, rad/s^2]


@dataclass
class MotionMonitor:
    """Compares commanded with measured velocities; a finding stays until it is cleared."""

    site: Site
    finding: Fault | None = None
    _owed: tuple[float, float] = (0.0, 0.0)
    _stands_since: float | None = None
    _fast_since: float | None = None
    _least: tuple[float, float] = (0.0, 0.0)  # velocities allowed now [m/s, rad/s]
    _most: tuple[float, float] = (0.0, 0.0)
    _at: float = 0.0

    def update(self, commanded: Velocity | None, measured: Velocity, now: float) -> None:
        """Compare velocities (commanded None: nothing is ordered) at a time [s]."""
        dt, self._at = min(now - self._at, 0.1), now
        if commanded is None or self.finding is not None:
            self._forget()
            return
        self._allow(commanded, dt)
        is_fast = any(
            not low - surplus - _SHARE * abs(low) <= one <= high + surplus + _SHARE * abs(high)
            for one, low, high, surplus in zip(
                measured, self._least, self._most, _SURPLUS, strict=True
            )
        )
        self._fast_since = _since(self._fast_since, is_fast, now)
        stands = is_at_rest(measured) and not is_at_rest(commanded)
        self._stands_since = _since(self._stands_since, stands, now)
        v, w = self._owed if stands else (0.0, 0.0)
        self._owed = (v + abs(commanded.v) * dt, w + abs(commanded.w) * dt)
        if self._fast_since is not None and now - self._fast_since >= _TOO_FAST:
            self.finding = _too_fast(commanded, measured)
        elif (
            self._stands_since is not None
            and now - self._stands_since > _STANDS
            and (self._owed[0] > _OWED.v or self._owed[1] > _OWED.w)
        ):
            self.finding = _STANDS_STILL

    def clear(self) -> None:
        """Forget the finding."""
        self.finding = None
        self._forget()

    def _forget(self) -> None:
        self._stands_since = self._fast_since = None
        self._owed = self._least = self._most = (0.0, 0.0)

    def _allow(self, commanded: Velocity, dt: float) -> None:
        """Allow the command, pulses included, and earlier ones with their decay."""
        pulse = self.site.least(commanded)
        low, high = [], []
        for axis, one in enumerate(commanded):
            may = max(abs(one), pulse[axis]) if one else 0.0
            decay = _DECELERATION[axis] * dt
            high.append(max(may if one > 0.0 else 0.0, self._most[axis] - decay))
            low.append(min(-may if one < 0.0 else 0.0, self._least[axis] + decay))
        self._least, self._most = (low[0], low[1]), (high[0], high[1])


def _since(before: float | None, holds: bool, now: float) -> float | None:
    if not holds:
        return None
    return now if before is None else before


def _fault(kind: FaultKind, text: str, *, clearable: bool = True) -> Fault:
    return Fault(kind=kind, text=text, clearable=clearable)


_STANDS_STILL = _fault(
    FaultKind.NOT_READY,
    "the base stands although it is commanded; look for an obstacle before its laser, "
    "a pressed emergency stop, motors that are off, dead zones that are larger than `full_scale` "
    "says, or another program that commands it",
)


def _too_fast(commanded: Velocity, measured: Velocity) -> Fault:
    if is_at_rest(commanded):
        return _fault(
            FaultKind.NOT_READY,
            f"the base moves at {_text(measured)} although it is told to rest: somebody else "
            "commands it; close MobilePlanner's drive mode or the other program",
        )
    if any(one * other < -(_SURPLUS.v**2) for one, other in zip(commanded, measured, strict=True)):
        cause = "it goes the other way: look how its drive is set up"
    else:
        cause = "`full_scale` is not that of its Teleop settings; frankie-task doctor compares them"
    text = f"the base moves at {_text(measured)}, told {_text(commanded)}, and was stopped: {cause}"
    return _fault(FaultKind.NOT_READY, text, clearable=False)


def _text(velocity: Velocity) -> str:
    return f"{velocity.v:.2f} m/s and {degrees(velocity.w):.0f} deg/s"


_BUMPED = ("Bumped", "Stalled")  # status of a base that has hit something [read in the source]


def connection_lost(cause: str) -> Fault:
    """The connection is lost; the base stops by its own timeout."""
    return _fault(
        FaultKind.CONNECTION,
        f"connection to the base lost: {cause}; check cable, WLAN and that the base is on",
    )


def telemetry_faults(
    telemetry: Telemetry, least_score: float | None, pose_age: float, score: float | None
) -> Iterator[Fault]:
    """Faults in the readings; a score (0 to 1) below `least_score` is one; `pose_age` in s."""
    if pose_age > OLDEST_POSE:
        yield _fault(
            FaultKind.STALE_POSE,
            f"no pose of the base for {OLDEST_POSE:g} s; is its network overloaded?",
        )
    if lost := why_lost(telemetry, least_score, score):
        text = f"{lost}; localise it in MobilePlanner"
        yield _fault(FaultKind.STALE_POSE, text, clearable=False)
    if telemetry.status in _BUMPED:
        yield _fault(
            FaultKind.BUMPER,
            f"the base says {telemetry.status!r}: it has met something; free it, then recover",
        )
    if telemetry.locked:
        yield _fault(
            FaultKind.NOT_READY,
            f"the base is in mode {telemetry.mode!r} and does not let go of it; wait, or end "
            "it in MobilePlanner",
        )


def why_lost(telemetry: Telemetry, least_score: float | None, score: float | None) -> str:
    """Why its localised pose means nothing; empty if it does. Scores are 0 to 1."""
    if telemetry.localisation in (Localisation.LOST, Localisation.INITIALISING):
        return "the base does not know where it is on its map"
    if score is not None and least_score is not None and score < least_score:
        return f"its localisation score is below {least_score:g}"
    return ""


def arcl_faults(arcl: ArclState) -> Iterator[Fault]:
    """Faults that the text interface reports."""
    if arcl.lost:
        yield _fault(
            FaultKind.CONNECTION,
            f"text interface of the base lost: {arcl.lost}; its emergency stop is not seen",
        )
    match arcl.motors:
        case Motors.PRESSED:
            yield _fault(
                FaultKind.EMERGENCY_STOP,
                "emergency stop of the base is pressed; release it",
                clearable=False,
            )
        case Motors.RELIEVED | Motors.DISABLED:
            yield _fault(
                FaultKind.NOT_READY,
                "the motors of the base are off; press its motor button, or recover",
            )
    for name in arcl.faults:
        yield _fault(
            FaultKind.NOT_READY, f"the base reports {name}; see MobilePlanner", clearable=False
        )

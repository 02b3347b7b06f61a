"""What is written to the base in each cycle, decided from the newest command and its age."""

from __future__ import annotations

from math import hypot, inf
from typing import Literal

from hw.omron.pulses import Pulses
from hw.omron.settings import OmronSettings
from hw.omron.site import REST, Ramp, Ratios, Velocity

_STOP_EVERY = 0.1
"""A stop is repeated after this time until the base is at rest [s]."""
_ON_ITS_WAY = 0.03
"""A velocity that comes sooner after a stop may be from before it [s]."""
_AT_REST = 0.01
"""A base slower than this stands [m/s, rad/s]."""
_LONGEST_STEP = 0.05
"""Velocities grow for this long at most between two cycles [s]."""
_HALT = Ratios(0.0, 0.0, 100.0)

Order = Ratios | Literal["stop"] | None


def is_at_rest(velocity: Velocity) -> bool:
    """Whether a base of this measured velocity stands."""
    return hypot(velocity.v, velocity.w) < _AT_REST


class Commander:
    """Turns commands that come at any rate into orders at a fixed one.

    A young command is driven, with velocities that grow no faster than the base can. One that is
    older than `zero_after` counts as zero, which lets motion resume at once. When it is older than
    `stop_after`, when somebody says so, or when the base may not move, the order is `stop`,
    repeated until the base is at rest; then there is none, until the next command.

    Args:
        settings: of the base.
    """

    def __init__(self, settings: OmronSettings) -> None:
        self._settings = settings
        self._ramp = Ramp(settings.acceleration, settings.turn_acceleration)
        self._pulses = Pulses(settings.site)
        self._target = REST
        self._given: float | None = None
        """When the newest command came; None after a stop."""
        self._stopping = False
        self._stopped_at: float | None = None
        self._stopping_since = 0.0
        self._stepped = 0.0

    def command(self, velocity: Velocity, now: float) -> None:
        """Drive at a velocity from a moment of the computer's clock on [s]."""
        self._target, self._given = velocity, now
        self._stopping = False

    def stop(self) -> None:
        """Forget the command and stop, whether or not there was one."""
        self._target, self._given = REST, None
        self._stopping, self._stopped_at = True, None

    @property
    def told(self) -> Velocity | None:
        """What the base was told last; None where nothing is ordered."""
        return None if self.is_idle else self._ramp.now

    @property
    def is_idle(self) -> bool:
        """Whether nothing is ordered."""
        return self._given is None and not self._stopping

    def order(
        self, now: float, measured: Velocity, *, may_move: bool, measured_at: float = inf
    ) -> Order:
        """What to write now.

        Args:
            now: on the computer's clock [s].
            measured: velocity of the base.
            may_move: whether nothing keeps it from moving.
            measured_at: when that velocity came [s].
        """
        gap, self._stepped = now - self._stepped, now
        if gap > self._settings.stop_after:  # suspended: the base has been stopped meanwhile
            self._halt()
        dt = min(gap, _LONGEST_STEP)
        if self._given is not None:
            age = now - self._given
            if may_move and age <= self._settings.stop_after:
                target = REST if age > self._settings.zero_after else self._target
                return self._ratios(target, measured.v, dt)
            self.stop()
        self._halt()
        return self._stop(now, measured, measured_at)

    def _ratios(self, target: Velocity, measured: float, dt: float) -> Ratios:
        now = self._pulses.step(self._ramp.step(target, dt), target, measured, dt)
        return _HALT if now == REST else self._settings.site.ratios(now, measured)

    def _halt(self) -> None:
        self._ramp.halt()
        self._pulses.halt()

    def _stop(self, now: float, measured: Velocity, measured_at: float) -> Order:
        if not self._stopping:
            return None
        if self._stopped_at is None:
            self._stopping_since = self._stopped_at = now
            return "stop"
        if now - self._stopped_at < _STOP_EVERY:
            return None
        if is_at_rest(measured) and measured_at > self._stopping_since + _ON_ITS_WAY:
            self._stopping = False
            return None
        self._stopped_at = now
        return "stop"

"""What is sent to the base in each cycle: ratios or a stop, from the newest command and its age."""

from math import copysign, inf
from typing import Literal

from drivers.omron.site import REST, Ratios, Site, Velocity, is_at_rest

ZERO_AFTER = 0.1  # a command older than this counts as a velocity of zero [s]
STOP_AFTER = 0.2  # a command older than this is a stop, repeated until the base is at rest [s]
_STOP_EVERY = 0.1  # a stop is repeated after this time until the base is at rest [s]
_ON_ITS_WAY = 0.03  # a velocity that arrives sooner after a stop may be from before it [s]
_LONGEST_STEP = 0.05  # velocities grow for this long at most between two cycles [s]
_HALT = Ratios(0.0, 0.0)
_PULSE = 0.2  # two cycles of a base that takes a velocity every 0.1 s [s]

Accelerations = tuple[float, float]
ACCELERATIONS: Accelerations = (1.5, 3.0)
"""Commanded velocities grow no faster than this, whoever commands them [m/s^2, rad/s^2]. The limits
of the robot file hold before, those of the base itself after."""

Order = Ratios | Literal["stop"] | None


class Commander:
    """Turns commands that come at any rate into orders at a fixed one.

    A recent command is driven, with velocities that grow no faster than the base can. One that is
    older than `ZERO_AFTER` counts as zero, which lets motion resume at once. When it is older than
    `STOP_AFTER`, after `stop`, or when the base may not move, the order is `stop`, repeated until
    the base is at rest; then there is none until the next command.
    """

    def __init__(self, site: Site, accelerations: Accelerations = ACCELERATIONS) -> None:
        self._site, self._accelerations = site, accelerations
        self._now = REST  # on its way to the target
        self._pulses = _Pulses(site)
        self._target = REST
        self._given: float | None = None  # when the newest command came; None after a stop
        self._stopping = False
        self._stopped_at: float | None = None
        self._stopping_since = 0.0
        self._stepped = 0.0

    def command(self, velocity: Velocity, now: float) -> None:
        """Drive at a velocity from a time of `stopwatch` on [s]."""
        self._target, self._given = velocity, now
        self._stopping = False

    def stop(self) -> None:
        """Forget the command and stop, whether or not there was one."""
        self._target, self._given = REST, None
        self._stopping, self._stopped_at = True, None

    @property
    def commanded(self) -> Velocity | None:
        """Velocity in force; None where nothing is ordered."""
        return None if self.is_idle else self._now

    @property
    def is_idle(self) -> bool:
        """Whether nothing is ordered."""
        return self._given is None and not self._stopping

    def order(
        self, now: float, measured: Velocity, *, may_move: bool, measured_at: float = inf
    ) -> Order:
        """What to send now [s], with the measured velocity that arrived at `measured_at` [s]."""
        gap, self._stepped = now - self._stepped, now
        if gap > STOP_AFTER:  # suspended: the base has been stopped meanwhile
            self._halt()
        dt = min(gap, _LONGEST_STEP)
        if self._given is not None:
            age = now - self._given
            if may_move and age <= STOP_AFTER:
                target = REST if age > ZERO_AFTER else self._target
                self._now = self._grown(target, dt)
                sent = self._pulses.step(self._now, target, measured.v, dt)
                return _HALT if sent == REST else self._site.ratios(sent, measured.v)
            self.stop()
        self._halt()
        return self._stop(now, measured, measured_at)

    def _grown(self, target: Velocity, dt: float) -> Velocity:
        """The velocity after `dt` [s]; both axes take the same share of their way."""
        start = Velocity(_start(self._now.v, target.v), _start(self._now.w, target.w))
        way = Velocity(target.v - start.v, target.w - start.w)
        needed = max(abs(one) / most for one, most in zip(way, self._accelerations, strict=True))
        share = min(1.0, dt / needed) if needed > 0.0 else 1.0
        return Velocity(start.v + share * way.v, start.w + share * way.w)

    def _halt(self) -> None:
        self._now = REST
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


def _start(now: float, target: float) -> float:
    """Where growing begins: as much of `now` as the target still wants."""
    return copysign(min(abs(now), abs(target)), target) if now * target > 0.0 else 0.0


class _Pulses:
    """Velocities inside the dead zones, as pulses of the slowest one outside.

    `ratioDrive` ignores ratios inside a dead zone. The base is driven at its slowest velocity for a
    moment whenever the distance that it lags behind makes up for a pulse: never faster than that,
    and as far as commanded in the mean.
    """

    def __init__(self, site: Site) -> None:
        self._site = site
        self.halt()

    def halt(self) -> None:
        """Begin at rest again."""
        self._lag, self._remaining = [0.0, 0.0], [0.0, 0.0]

    def step(self, now: Velocity, target: Velocity, measured: float, dt: float) -> Velocity:
        """The velocity to send after `dt` [s] on the way `now` to `target`, at a measured speed."""
        kept, least = self._site.kept(now, measured), self._site.least(now)
        passes = self._site.kept(target, measured)
        sent = []
        for axis, (one, slow) in enumerate(zip(now, least, strict=True)):
            if kept[axis] or passes[axis]:  # or on its way through the dead zone
                self._lag[axis] = self._remaining[axis] = 0.0
                sent.append(one if kept[axis] else copysign(slow, one))
            else:
                sent.append(copysign(slow, one) if self._is_pulse(axis, abs(one), slow, dt) else 0)
        return Velocity(*sent) if any(sent) else REST

    def _is_pulse(self, axis: int, wanted: float, slow: float, dt: float) -> bool:
        self._remaining[axis] -= dt
        self._lag[axis] += wanted * dt
        if self._remaining[axis] <= 0.0 and self._lag[axis] >= slow * _PULSE / 2.0:
            self._remaining[axis] = _PULSE
            self._lag[axis] -= slow * _PULSE
        return self._remaining[axis] > 0.0

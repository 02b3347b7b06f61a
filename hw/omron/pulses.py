"""Velocities that are too slow for the base, as pulses of the slowest one that moves it.

What lies inside a dead zone of `ratioDrive` is lost. Where the throttle does not help, the base is
driven at its slowest velocity for a moment whenever the way that it lacks makes up for one: never
faster than that, and as far as it was told in the mean.
"""

from __future__ import annotations

from math import copysign

from hw.omron.site import REST, Site, Velocity

_PULSE = 0.2
"""Two cycles of a base that takes a velocity every 0.1 s [s]."""


class Pulses:
    """Turns velocities into such as the base does not lose.

    Args:
        site: of the base.
    """

    def __init__(self, site: Site) -> None:
        self._site = site
        self.halt()

    def halt(self) -> None:
        """Begin at rest again."""
        self._lacks, self._left = [0.0, 0.0], [0.0, 0.0]

    def step(self, now: Velocity, target: Velocity, measured: float, dt: float) -> Velocity:
        """The velocity to be sent.

        Args:
            now: wanted at this moment, on its way to the target.
            target: as commanded.
            measured: speed of the base [m/s].
            dt: since the step before [s].
        """
        kept, least = self._site.kept(now, measured), self._site.least(now)
        passes = self._site.kept(target, measured)
        sent = []
        for axis, (one, slow) in enumerate(zip(now, least, strict=True)):
            if kept[axis] or passes[axis]:  # or on its way through the dead zone
                self._lacks[axis] = self._left[axis] = 0.0
                sent.append(one if kept[axis] else copysign(slow, one))
            else:
                sent.append(copysign(slow, one) if self._is_pulse(axis, abs(one), slow, dt) else 0)
        return Velocity(*sent) if any(sent) else REST

    def _is_pulse(self, axis: int, wanted: float, slow: float, dt: float) -> bool:
        """Whether the axis is driven at its slowest velocity now."""
        self._left[axis] -= dt
        self._lacks[axis] += wanted * dt
        if self._left[axis] <= 0.0 and self._lacks[axis] >= slow * _PULSE / 2.0:
            self._left[axis] = _PULSE
            self._lacks[axis] -= slow * _PULSE
        return self._left[axis] > 0.0

"""Conversion between velocities and the ratios of `ratioDrive`, for the settings of one site.

The command takes percentages of full-scale speeds that MobilePlanner keeps under "Teleop settings".
The formula and the dead zones were read in the open ARIA library and verified on its server; that
the LD-60 keeps them is inferred. That 100 % are 1.0 m/s forwards, 0.25 m/s backwards and 50 deg/s
is what drivers that ran on real LD bases use [reported].
"""

from __future__ import annotations

from dataclasses import dataclass
from math import hypot, inf, radians
from typing import NamedTuple


class Velocity(NamedTuple):
    """Twist of a base that cannot move sideways."""

    v: float  # forwards [m/s]
    w: float  # counter-clockwise [rad/s]


REST = Velocity(0.0, 0.0)
_BEYOND = 1.05  # ratios leave a dead zone by this factor
_MOST_BEYOND = 3.0, 10.0  # largest factors of translation and rotation, where both share a throttle
_AT_REST = 0.01  # a slower base is at rest [m/s, rad/s]


class Ratios(NamedTuple):
    """The arguments of `ratioDrive` [%]; its fourth, for sideways, is always 0."""

    translation: float
    rotation: float
    throttle: float


@dataclass(frozen=True, kw_only=True)
class Site:
    """The values of "Teleop settings" at one site."""

    forward: float = 1.0  # FullThrottleForwards [m/s]
    reverse: float = 0.25  # FullThrottleBackwards [m/s]
    turn: float = radians(50.0)  # RotAtStopped [rad/s]
    turn_at_forward: float | None = None
    """RotAtFullForwards [rad/s]; None: as at rest. ARIA's own default is 25 deg/s."""
    turn_at_reverse: float | None = None  # RotAtFullBackwards [rad/s]; None: as at rest
    dead_translation: float = 10.0
    """TransDeadZone [%]: a ratio up to this one does not move the base."""
    dead_rotation: float = 5.0  # RotDeadZone [%]: a ratio below this one does not turn the base
    throttle: bool = False
    """Whether the base obeys the third argument of `ratioDrive`: then velocities inside the dead
    zones are reached by larger ratios and a smaller throttle. Ratios grow no further than out of
    the dead zones, so that a base that does not obey it after all goes slowly, too."""

    def saturate(self, wanted: Velocity, measured: float) -> Velocity:
        """The wanted velocity, scaled down along the same arc where it is above full scale.

        Args:
            wanted: finite.
            measured: current speed of the base [m/s]; full scale of turning depends on it.
        """
        straight = abs(wanted.v) / self._full_scale(wanted.v)
        turning = abs(wanted.w) / self._full_turn(wanted.v, measured)
        share = max(straight, turning, 1.0)
        return Velocity(wanted.v / share, wanted.w / share)

    def ratios(self, wanted: Velocity, measured: float) -> Ratios:
        """The ratios for a velocity within full scale."""
        translation = 100.0 * wanted.v / self._full_scale(wanted.v)
        rotation = 100.0 * wanted.w / self._full_turn(wanted.v, measured)
        throttle = 100.0
        if self.throttle and self._loses(translation, rotation):
            larger = self._larger(translation, rotation)
            translation, rotation = larger * translation, larger * rotation
            throttle /= larger
        if abs(translation) <= self.dead_translation:  # full scale of turning is that at rest
            rotation *= self._full_turn(wanted.v, measured) / self.turn
        return Ratios(_percent(translation), _percent(rotation), throttle)

    def velocity(self, ratios: Ratios, measured: float) -> Velocity:
        """The velocity that ratios give, by the formula of ARIA."""
        translation, rotation, throttle = ratios
        share = throttle / 100.0
        if abs(rotation) < self.dead_rotation:
            rotation = 0.0
        if abs(translation) <= self.dead_translation:
            return Velocity(0.0, rotation / 100.0 * self.turn * share)
        v = translation / 100.0 * self._full_scale(translation) * share
        return Velocity(v, rotation / 100.0 * self._full_turn(v, measured) * share)

    def kept(self, wanted: Velocity, measured: float) -> tuple[bool, bool]:
        """Whether the velocity on each axis is not lost in a dead zone."""
        made = self.velocity(self.ratios(wanted, measured), measured)
        return (made.v != 0.0 or wanted.v == 0.0, made.w != 0.0 or wanted.w == 0.0)

    def least(self, direction: Velocity) -> Velocity:
        """The slowest speeds outside of the dead zones, without sign."""
        v = self._full_scale(direction.v) * self.dead_translation / 100.0
        return Velocity(_BEYOND * v, _BEYOND * self.turn * self.dead_rotation / 100.0)

    def _full_scale(self, direction: float) -> float:
        return self.reverse if direction < 0.0 else self.forward

    def _full_turn(self, direction: float, measured: float) -> float:
        """Full scale of turning at a measured speed [rad/s]; it counts as a share of `forward`."""
        at_full = self.turn_at_reverse if direction < 0.0 else self.turn_at_forward
        if at_full is None or direction == 0.0:
            return self.turn
        share = min(abs(measured) / self.forward, 1.0)
        return self.turn + (at_full - self.turn) * share

    def _larger(self, translation: float, rotation: float) -> float:
        """The factor, at least 1, that brings ratios out of the dead zones.

        With the throttle ignored the base goes at most `_MOST_BEYOND` times its slowest velocities.
        """
        zones = ((translation, self.dead_translation), (rotation, self.dead_rotation))
        needed = [_BEYOND * dead / abs(ratio) if ratio else inf for ratio, dead in zones]
        wanted = max(one for one in needed if one < inf)
        most = min(times * one for times, one in zip(_MOST_BEYOND, needed, strict=True))
        return max(1.0, min(wanted, most))

    def _loses(self, translation: float, rotation: float) -> bool:
        return (
            0.0 < abs(translation) <= self.dead_translation
            or 0.0 < abs(rotation) < self.dead_rotation
        )


def _percent(ratio: float) -> float:
    return max(-100.0, min(100.0, ratio))


def is_finite(velocity: Velocity) -> bool:
    """Whether both numbers are finite."""
    return abs(velocity.v) < inf and abs(velocity.w) < inf


def is_at_rest(velocity: Velocity) -> bool:
    """Whether a base of this measured velocity is at rest."""
    return hypot(velocity.v, velocity.w) < _AT_REST

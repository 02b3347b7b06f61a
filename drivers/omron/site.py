"""Full scale of one LD-60, and conversion between velocities and the ratios of `ratioDrive`.

The command takes percentages of full-scale speeds that MobilePlanner keeps under "Teleop settings".
The formula and the dead zones were read in the open ARIA library and verified on its server; that
the LD-60 keeps them is inferred. That 100 % are 1.0 m/s forwards, 0.25 m/s backwards and 50 deg/s
is what drivers that ran on real LD bases use [reported].
"""

from math import hypot, radians
from typing import NamedTuple

from config.reader import StrictModel
from robots import NotNegative, Positive


class Velocity(NamedTuple):
    """Twist of a base that cannot move sideways."""

    v: float  # forwards [m/s]
    w: float  # counter-clockwise [rad/s]


REST = Velocity(0.0, 0.0)
_BEYOND = 1.05  # ratios leave a dead zone by this factor
_AT_REST = 0.01  # a slower base is at rest [m/s, rad/s]


class Ratios(NamedTuple):
    """The first arguments of `ratioDrive` [%]; the throttle is always 100, sideways 0."""

    translation: float
    rotation: float


class Site(StrictModel):
    """The values of "Teleop settings" at one site, as `full_scale` in a robot file has them."""

    forward: Positive = 1.0  # FullThrottleForwards [m/s]
    reverse: Positive = 0.25  # FullThrottleBackwards [m/s]
    turn_deg: Positive = 50.0  # RotAtStopped [deg/s]
    turn_at_forward_deg: Positive | None = None  # RotAtFullForwards; None: as at rest
    turn_at_reverse_deg: Positive | None = None  # RotAtFullBackwards; None: as at rest
    dead_translation: NotNegative = 10.0  # TransDeadZone [%]: up to this the base does not move
    dead_rotation: NotNegative = 5.0  # RotDeadZone [%]: a ratio below this one does not turn it

    @property
    def values(self) -> dict[str, float]:
        """Every value by its key."""
        return {key: self.turn_deg if one is None else one for key, one in self}

    @property
    def turn(self) -> float:
        """Full scale of turning at rest [rad/s]."""
        return radians(self.turn_deg)

    def saturate(self, wanted: Velocity, measured: float) -> Velocity:
        """The finite velocity within full scale along the same arc, at a measured speed [m/s]."""
        straight = abs(wanted.v) / self._full_scale(wanted.v)
        turning = abs(wanted.w) / self._full_turn(wanted.v, measured)
        share = max(straight, turning, 1.0)
        return Velocity(wanted.v / share, wanted.w / share)

    def ratios(self, wanted: Velocity, measured: float) -> Ratios:
        """The ratios for a velocity within full scale."""
        translation = 100.0 * wanted.v / self._full_scale(wanted.v)
        rotation = 100.0 * wanted.w / self._full_turn(wanted.v, measured)
        if abs(translation) <= self.dead_translation:  # full scale of turning is that at rest
            rotation *= self._full_turn(wanted.v, measured) / self.turn
        return Ratios(_percent(translation), _percent(rotation))

    def velocity(self, ratios: Ratios, measured: float) -> Velocity:
        """The velocity that ratios give, by the formula of ARIA."""
        translation, rotation = ratios
        if abs(rotation) < self.dead_rotation:
            rotation = 0.0
        if abs(translation) <= self.dead_translation:
            return Velocity(0.0, rotation / 100.0 * self.turn)
        v = translation / 100.0 * self._full_scale(translation)
        return Velocity(v, rotation / 100.0 * self._full_turn(v, measured))

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
        at_full = self.turn_at_reverse_deg if direction < 0.0 else self.turn_at_forward_deg
        if at_full is None or direction == 0.0:
            return self.turn
        share = min(abs(measured) / self.forward, 1.0)
        return self.turn + (radians(at_full) - self.turn) * share


def _percent(ratio: float) -> float:
    return max(-100.0, min(100.0, ratio))


def is_at_rest(velocity: Velocity) -> bool:
    """Whether a base of this measured velocity is at rest."""
    return hypot(velocity.v, velocity.w) < _AT_REST

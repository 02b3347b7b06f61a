"""Where odometry is in the map: fuses the base's own localisation with registrations (REP 105)."""

from __future__ import annotations

from copy import copy
from math import exp, hypot, inf, radians
from typing import NamedTuple

import numpy as np

from config.arrays import Array
from config.planar import compose, difference, inverse
from perception.registration.registering import CHI2_3, Registration, parallel

_SPEED, _TURN = 0.2, radians(12.0)  # at which the pose of the base is corrected [m/s, rad/s]
_ROUNDING = 1e-9  # of information matrices, relative to their largest element
_SLIP = np.array([0.04, 0.04, radians(0.5)])
"""Odometry errors: share of the distance, share of the angle, heading a metre [rad/m]."""
_ALIKE = np.array([2.0, 3.0, 2.0])
"""Distance [m], angle [rad] and distance over which they last: a first-order process."""
_DRIFT = np.array([0.001, 0.001, radians(0.03)])
"""What else is wrong after one metre, or radian, and grows with the root of it."""
_CORRELATION_TIME = 5.0
"""Time constant of the error of the base's own localisation [s]."""
_READING_NOISE = (0.003, 0.003, radians(0.1))
"""Part of that error which is independent from reading to reading: x, y [m], heading [rad]."""
_DOUBT = (0.01, 0.01, radians(0.3))
"""Uncertainty that a registration adds which contradicts the estimate: x, y [m], heading."""
_AGREEING = 8
"""How many more registrations than not must contradict what was known without a piece of
furniture, until that is taken to be elsewhere; twice as many agree, and it is in its place."""
_LOST = 0.3
"""A registration that explains a smaller share of its points contradicts the estimate."""
_PERSISTENCE = 1.0
"""How long readings must contradict the estimate before they can replace it [s]."""
_BETTER = 1.1
"""How many times as many points must then lie on the map."""
_DOUBTFUL = 1.5
"""How long they must, unrefuted by points, until it is doubtful where the base is [s]."""
_LONG = 2.5
"""How long they must contradict the estimate until that is told [s]."""
_CARRIED = 5.0
"""How long, until they replace the estimate though no points speak for them [s]."""


class Update(NamedTuple):
    """What a measurement did to the estimate."""

    nis: float
    """Normalised innovation squared: three on average (Bar-Shalom et al. 2001, 5.4)."""
    accepted: bool
    """Whether the estimate explains it; otherwise it did not move it."""
    moved: frozenset[str] = frozenset()
    """Furniture that was moved, else the estimate would be wrong."""


class _Contradiction(NamedTuple):
    """A pose that the base's own localisation insists on."""

    since: float
    unrefuted: float
    """Since when points have not spoken against it [s]."""
    mTo: Array
    covariance: Array


class _Without(NamedTuple):
    """What is known without the furniture that alone is in sight."""

    pieces: frozenset[str]
    estimate: LocalisationFilter
    against: int = 0
    """How many more registrations have contradicted it than not; negative if fewer."""


class LocalisationFilter:
    """Estimates `mTo`, the pose of odometry in the map, with its covariance.

    A Kalman filter whose states are `mTo` and the errors of the base's own localisation and of its
    odometry, first-order Gauss-Markov processes: many readings in a second are worth one, and a
    slip that lasts is compensated. Registrations count until they have said what the error that
    they have in common allows (`Registration.limit`). Poses on the floor are arrays (3,): x, y [m],
    heading [rad]; covariances (3, 3) are of mTb in the axes of the map.
    """

    def __init__(self, mTb: Array, covariance: Array, stamp: float, oTb: Array) -> None:
        """Start from the first reading; arguments as of `localised`."""
        self.restart(mTb, covariance, stamp, oTb)

    def restart(self, mTb: Array, covariance: Array, stamp: float, oTb: Array) -> None:
        """Forget all and believe one reading; arguments as of `localised`."""
        self._stamp, self._oTb = stamp, oTb
        self._contradiction: _Contradiction | None = None
        self._without: _Without | None = None
        self._in_place: set[str] = set()  # furniture that agreed with what was known without it
        self.mTo = compose(mTb, inverse(oTb))
        """(3,) the newest estimate; it steps when a measurement comes (see `smoothed`)."""
        self._bias = np.zeros(3)
        """(3,) error of the reading, in axes of the map."""
        self._slip = np.zeros(3)
        """(3,) by which the base moves farther than odometry tells, as in `_SLIP`."""
        # The error of the estimate is that of the reading, with the other sign.
        back = self._back(oTb)
        both = np.concatenate([-back, np.eye(3)])
        self._P = np.diag(np.square([0.0] * 6 + [*_SLIP]))
        self._P[:6, :6] = both @ covariance @ both.T
        self._P[:3, :3] += back @ np.diag(_READING_NOISE) ** 2 @ back.T

    def pose(self, oTb: Array) -> Array:
        """(3,) mTb for odometry (3,)."""
        return compose(self.mTo, oTb)

    def covariance(self, oTb: Array) -> Array:
        """(3, 3) of `pose`."""
        arm = self._arm(oTb)
        return np.asarray(arm @ self._P[:3, :3] @ arm.T)

    def travelled(self, oTb: Array) -> None:
        """Follow odometry since the last call; call it often."""
        if self._without is not None:
            self._without.estimate.travelled(oTb)
        mTb = self.pose(oTb)
        x, y, turned = difference(mTb, self.pose(self._oTb)).tolist()
        way, self._oTb = hypot(x, y), oTb
        slipping = np.array([[x, 0.0, 0.0], [y, 0.0, 0.0], [0.0, turned, way]])
        self.mTo = compose(mTb + slipping @ self._slip, inverse(oTb))
        kept = np.exp(-np.array([way, abs(turned), way]) / _ALIKE)
        self._slip = kept * self._slip
        back, F = self._back(oTb), np.eye(9)
        F[:3, 6:], F[6:, 6:] = back @ slipping, np.diag(kept)
        self._P = F @ self._P @ F.T
        self._P[[6, 7, 8], [6, 7, 8]] += (1.0 - kept**2) * np.square(_SLIP)
        self._widen((way + abs(turned)) * np.square(_DRIFT), back)

    def localised(self, mTb: Array, covariance: Array, stamp: float, oTb: Array) -> Update:
        """Take a reading of the base's own localisation.

        Args:
            mTb: (3,) the reading.
            covariance: (3, 3) of its error.
            stamp: of the reading [s].
            oTb: (3,) odometry at that stamp.
        """
        if self._without is not None:
            self._without.estimate.localised(mTb, covariance, stamp, oTb)
        P = self._P
        kept = exp(-max(stamp - self._stamp, 0.0) / _CORRELATION_TIME)
        self._stamp = max(stamp, self._stamp)
        self._bias = kept * self._bias
        P[3:6] *= kept
        P[:, 3:6] *= kept
        P[3:6, 3:6] += (1.0 - kept**2) * covariance
        H = np.concatenate([self._arm(oTb), np.eye(3), np.zeros((3, 3))], axis=1)
        innovation = difference(mTb, self.pose(oTb)) - self._bias
        S = H @ P @ H.T + np.diag(_READING_NOISE) ** 2
        gain = np.linalg.solve(S, H @ P).T
        nis = float(innovation @ np.linalg.solve(S, innovation))
        if nis > CHI2_3:
            self._contradict(compose(mTb, inverse(oTb)), covariance, stamp, oTb)
            self._without = None  # it rests on readings that may have jumped
            return Update(nis, accepted=False)
        self._contradiction = None
        self._correct(gain @ innovation, gain @ H @ P, oTb)
        return Update(nis, accepted=True)

    def registered(self, result: Registration, oTb: Array) -> Update:
        """Take a registration, whose prior was an estimate of this filter; oTb (3,) at capture."""
        if moved := self._contradicted(result, oTb):
            return Update(inf, accepted=False, moved=moved)
        across = self._P[:, :3] @ self._arm(oTb).T
        covariance = self._arm(oTb) @ across[:3]
        prior: Array = np.asarray(np.linalg.inv(covariance))
        innovation, nis = result.innovation(self.pose(oTb), prior)
        data = result.information
        rounding = _ROUNDING * np.diag(np.diag(data + prior))
        if nis > CHI2_3 or result.explained < _LOST:
            if len(result.points):
                self._widen(np.square(_DOUBT), self._back(oTb))
            return Update(nis, accepted=False)
        values, vectors = np.linalg.eigh(result.limit - prior)
        unsaid = (vectors * np.maximum(values, 0.0)) @ vectors.T
        news = parallel(data, unsaid + rounding)
        gain = across @ np.linalg.inv(np.eye(3) + news @ covariance)
        self._correct(gain @ news @ innovation, gain @ news @ across.T, oTb)
        return Update(nis, accepted=True)

    def _contradicted(self, result: Registration, oTb: Array) -> frozenset[str]:
        """Furniture that speaks alone, against all that is known without it.

        The estimate goes back to that: it may have followed the furniture step by step.
        """
        if result.confirmed:
            self._without = None
        if not result.alone or result.alone <= self._in_place:
            return frozenset()
        if self._without is None or self._without.pieces.isdisjoint(result.alone):
            known = copy(self)
            known._P, known._without = self._P.copy(), None
            self._without = _Without(result.alone, known)
        known = self._without.estimate
        information: Array = np.asarray(np.linalg.inv(known.covariance(oTb)))
        nis = result.innovation(known.pose(oTb), information)[1]
        count = self._without.against + (1 if nis > CHI2_3 else -1)
        self._without = self._without._replace(against=count)
        if count <= -2 * _AGREEING:
            self._in_place |= result.alone
            self._without = None
        if count < _AGREEING:
            return frozenset()
        vars(self).update(vars(known))
        return result.alone

    def proposal(self, oTb: Array) -> tuple[Array, Array] | None:
        """Another pose mTb (3,), with its covariance, on which the base's localisation insists.

        Register the same points from there and from here, and hand both to `relocalised`.
        """
        other = self._contradiction
        if other is None or self._stamp - other.since < _PERSISTENCE:
            return None
        return compose(other.mTo, oTb), other.covariance

    def relocalised(self, there: Registration, here: Registration, oTb: Array) -> bool:
        """Take the proposal over if it explains the points better; whether it did.

        Args:
            there: registration whose prior is the proposal.
            here: of the same points; its prior is the estimate.
            oTb: (3,) odometry at capture.
        """
        other = self._contradiction
        if other is None:
            return False
        if there.consistent and len(there.points) > _BETTER * len(here.points):
            self.restart(compose(other.mTo, oTb), other.covariance, self._stamp, oTb)
            self.registered(there, oTb)
            return True
        if not there.consistent or len(here.points) > _BETTER * len(there.points):
            self._contradiction = other._replace(unrefuted=self._stamp)
        return False

    @property
    def doubt(self) -> tuple[float, float] | None:
        """Distance [m] and turn [rad] to the pose on which the base's localisation insists.

        None while nothing contradicts the estimate, or points refute what does.
        """
        other = self._contradiction
        if other is None or self._stamp - other.unrefuted < _DOUBTFUL:
            return None
        x, y, turn = difference(compose(other.mTo, self._oTb), self.pose(self._oTb)).tolist()
        return hypot(x, y), abs(turn)

    @property
    def is_contradicted(self) -> bool:
        """Whether points have long spoken against what the base's localisation insists on."""
        other = self._contradiction
        return other is not None and min(other.unrefuted, self._stamp - _LONG) > other.since

    def carried(self, oTb: Array) -> bool:
        """Take the proposal over if nothing has refuted it for long; whether it did."""
        other = self._contradiction
        if other is None or self._stamp - other.unrefuted < _CARRIED:
            return False
        self.restart(compose(other.mTo, oTb), other.covariance, self._stamp, oTb)
        return True

    def unlocalised(self) -> None:
        """The base's own localisation is lost: it insists on nothing."""
        self._contradiction = None

    def _contradict(self, mTo: Array, covariance: Array, stamp: float, oTb: Array) -> None:
        """Note a reading that the estimate cannot explain; its covariance may be zero."""
        covariance = covariance + np.diag(_READING_NOISE) ** 2
        other = self._contradiction
        if other is not None:
            off = difference(compose(mTo, oTb), compose(other.mTo, oTb))
            if off @ np.linalg.solve(2.0 * covariance, off) < CHI2_3:
                self._contradiction = other._replace(mTo=mTo, covariance=covariance)
                return
        self._contradiction = _Contradiction(stamp, stamp, mTo, covariance)

    def _arm(self, oTb: Array) -> Array:
        """(3, 3) from an error of `mTo` to that of mTb."""
        x, y, _ = (compose(self.mTo, oTb) - self.mTo).tolist()
        return np.array([[1.0, 0.0, -y], [0.0, 1.0, x], [0.0, 0.0, 1.0]])

    def _back(self, oTb: Array) -> Array:
        """The inverse of `_arm`."""
        back = self._arm(oTb)
        back[:2, 2] *= -1.0
        return back

    def _widen(self, variances: Array, back: Array) -> None:
        """Add variances (3,) of mTb where `_back` is (3, 3)."""
        self._P[:3, :3] += (back * variances) @ back.T

    def _correct(self, step: Array, less: Array, oTb: Array) -> None:
        """Add a step (9,) to the state, and take (9, 9) off its covariance."""
        mTb = self.pose(oTb) + self._arm(oTb) @ step[:3]
        self.mTo = compose(mTb, inverse(oTb))
        self._bias, self._slip = self._bias + step[3:6], self._slip + step[6:]
        P = self._P - less
        self._P = 0.5 * (P + P.T)


def smoothed(applied: Array, newest: Array, oTb: Array, dt: float) -> Array:
    """`mTo` (3,) a period later, on its way to the newest estimate without a step at the base.

    Args:
        applied: (3,) mTo of the last period.
        newest: (3,) mTo of the estimate.
        oTb: (3,) odometry now.
        dt: period [s].
    """
    mTb = compose(applied, oTb)
    off = difference(compose(newest, oTb), mTb)
    most = max(hypot(off[0], off[1]) / (_SPEED * dt), abs(float(off[2])) / (_TURN * dt), 1.0)
    return compose(mTb + off / most, inverse(oTb))

"""Whether what tells the place of a base on the map still does."""

from math import hypot

import numpy as np
from pinocchio import SE3, log3

from config.poses import OdometryPose

_LONGEST = 2.5  # silence that is suspicious [s] ...
_FAR, _TURN = 0.6, 1.0  # ... of a source that tells when the base has moved by less [m, rad] ...
_IN_A_ROW = 5  # ... or has told so many times of a base at rest, so that it tells all the time
_AT_REST = 0.01  # a smaller motion is none [m, rad]


class MapSource:
    """Hears when a place on the map is told; AMCL tells it only of a base that has moved."""

    def __init__(self) -> None:
        self.has_told = False
        self._at = 0.0
        self._oTb = SE3.Identity()
        self._at_rest = 0

    def heard(self, now: float, oTb: OdometryPose) -> None:
        """The place was told at a time [s], when the base was there in odometry."""
        if self._at_rest < _IN_A_ROW:  # else it is known to tell all the time
            self._at_rest = self._at_rest + 1 if max(self._moved(oTb)) < _AT_REST else 0
        self.has_told, self._at, self._oTb = True, now, oTb

    def is_silent(self, now: float, oTb: OdometryPose) -> bool:
        """Whether it has told nothing for so long, or on such a way, that it has failed."""
        if now - self._at < _LONGEST:
            return False
        way, turn = self._moved(oTb)
        return way > _FAR or turn > _TURN or self._at_rest >= _IN_A_ROW

    def _moved(self, oTb: OdometryPose) -> tuple[float, float]:
        """Since it was told last [m, rad]."""
        by = self._oTb.actInv(oTb)
        return hypot(*by.translation[:2].tolist()), float(np.linalg.norm(log3(by.rotation)))

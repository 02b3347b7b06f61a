"""Where the base is: its odometry in the world, and what its localisation tells of the map."""

import numpy as np
from pinocchio import SE3

from hw.omron.site import REST, OmronSettings
from hw.omron.telemetry import Pose, Telemetry, extrapolate
from hw.state import Array

_GOOD_SCORE, _LEAST_SCORE = 0.7, 0.1
"""With a lower score its pose is less accurate, in inverse proportion [inferred]."""
_AGREE = 0.3
"""Encoders whose way while disconnected differs by more from that on the map counted anew [m]."""


def begun(telemetry: Telemetry) -> SE3:
    """Odometry in a world that begins now, as the map."""
    return _pose(telemetry.pose) * _pose(telemetry.odometry).inverse()


def continued(wTo: SE3, before: Telemetry, telemetry: Telemetry) -> SE3:
    """Odometry of a new connection in the world of the last one, where it was at `wTo`.

    Without encoders, or after a restart of the base, the way meanwhile is that on the map.
    """
    oTb, oTb_now = _pose(before.odometry), _pose(telemetry.odometry)
    way = _pose(before.pose).actInv(_pose(telemetry.pose))
    if before.has_encoders and telemetry.has_encoders:
        counted = oTb.actInv(oTb_now)
        if np.linalg.norm(counted.translation - way.translation) < _AGREE:
            return wTo
    return wTo * oTb * way * oTb_now.inverse()


def covariance(settings: OmronSettings, score: float | None) -> Array:
    """(3, 3) of the localised pose: x, y and yaw on the map [m², m rad, rad²]."""
    worse = 1.0 if score is None else max(1.0, _GOOD_SCORE / max(score, _LEAST_SCORE))
    sigma = worse * np.array([settings.sigma, settings.sigma, settings.sigma_turn])
    return np.diag(sigma**2)


def _pose(pose: Pose | None) -> SE3:
    assert pose is not None  # `connect` waited for it
    return extrapolate(pose, REST, 0.0)

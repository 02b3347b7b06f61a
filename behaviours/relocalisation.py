"""Detection of relocalisations: jumps of the base pose that its motion does not explain."""

from __future__ import annotations

from collections import deque
from math import degrees, radians
from typing import NamedTuple

import numpy as np
import pinocchio as pin
from pinocchio import SE3

from hw import RobotState

_DISTANCE, _TURN = 0.03, radians(2.0)  # a larger difference is a jump [m, rad] ...
_WINDOW = 0.25  # ... within this time [s]
_CORRECTION, _CORRECTION_TURN = 0.1, radians(8.0)  # a larger jump may be an error [m, rad]


class _Reading(NamedTuple):
    stamp: float
    wTb: SE3
    oTb: SE3
    """Dead reckoning: the integral of the measured twists."""


class Relocalisation:
    """Compares the localised base pose with dead reckoning over a short window.

    A jump of the localisation may be spread over several readings. A gap between two readings
    starts a new window.
    """

    def __init__(self) -> None:
        self._readings: deque[_Reading] = deque()
        self._twist = np.zeros(3)
        self.was_large = False
        """Whether the last jump was too large for a correction: it may be an error."""

    def note(self, state: RobotState) -> str:
        """Take a reading.

        Returns:
            A message if the base was relocalised, else empty.
        """
        oTb = SE3.Identity()
        if self._readings:
            last = self._readings[-1]
            passed = state.stamp - last.stamp
            if not 0.0 <= passed <= _WINDOW:
                self._readings.clear()
            else:
                vx, vy, w = passed * (self._twist + state.base_twist) / 2.0
                oTb = last.oTb * pin.exp6(np.array([vx, vy, 0.0, 0.0, 0.0, w]))
        self._twist = state.base_twist
        self._readings.append(_Reading(state.stamp, state.wTb, oTb))
        while state.stamp - self._readings[0].stamp > _WINDOW:
            self._readings.popleft()
        first = self._readings[0]
        jump = (first.wTb * first.oTb.actInv(oTb)).actInv(state.wTb)
        distance = float(np.linalg.norm(jump.translation))
        turn = float(np.linalg.norm(pin.log3(jump.rotation)))
        if distance <= _DISTANCE and turn <= _TURN:
            return ""
        self._readings.clear()
        self.was_large = distance > _CORRECTION or turn > _CORRECTION_TURN
        return f"the base was relocalised by {distance:.2f} m and {degrees(turn):.0f}°"

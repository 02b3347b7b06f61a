"""Whether the base was localised anew: its pose has jumped by more than its motion explains."""

from __future__ import annotations

from collections import deque
from math import degrees
from typing import NamedTuple

import numpy as np
import pinocchio as pin
from pinocchio import SE3

from behaviours.settings import RelocalisationSettings
from hw import RobotState


class _Reading(NamedTuple):
    stamp: float
    wTb: SE3
    oTb: SE3
    """The base where its measured twists would have brought it."""


class Relocalisation:
    """Compares the localised pose of the base with what its measured twists add up to.

    It looks back over a short window, as a jump of the localisation may be spread over several
    readings. After a gap between two readings it begins anew: nobody knows what happened in it.

    Args:
        settings: what counts as a jump.
    """

    def __init__(self, settings: RelocalisationSettings) -> None:
        self._settings = settings
        self._readings: deque[_Reading] = deque()
        self._twist = np.zeros(3)
        self.was_large = False
        """Whether the last jump was more than a localisation corrects: it may as well be wrong."""

    def note(self, state: RobotState) -> str:
        """Take a reading.

        Returns:
            That the base was relocalised, in words; empty if it was not.
        """
        oTb = SE3.Identity()
        if self._readings:
            last = self._readings[-1]
            passed = state.stamp - last.stamp
            if not 0.0 <= passed <= self._settings.window:
                self._readings.clear()
            else:
                vx, vy, w = passed * (self._twist + state.base_twist) / 2.0
                oTb = last.oTb * pin.exp6(np.array([vx, vy, 0.0, 0.0, 0.0, w]))
        self._twist = state.base_twist
        self._readings.append(_Reading(state.stamp, state.wTb, oTb))
        while state.stamp - self._readings[0].stamp > self._settings.window:
            self._readings.popleft()
        first = self._readings[0]
        jump = (first.wTb * first.oTb.actInv(oTb)).actInv(state.wTb)
        distance = float(np.linalg.norm(jump.translation))
        turn = float(np.linalg.norm(pin.log3(jump.rotation)))
        if distance <= self._settings.distance and turn <= self._settings.turn:
            return ""
        self._readings.clear()
        most = self._settings
        self.was_large = distance > most.correction or turn > most.correction_turn
        return f"the base was relocalised by {distance:.2f} m and {degrees(turn):.0f}°"

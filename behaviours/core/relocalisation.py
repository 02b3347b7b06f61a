"""Whether the pose of the base has jumped: what was seen before is then not where it was."""

from collections import deque
from math import degrees, hypot, radians

import numpy as np
import pinocchio as pin
from pinocchio import SE3

from hw import RobotState

_DISTANCE, _TURN = 0.03, radians(2.0)  # a larger difference is a jump [m, rad] ...
_WINDOW = 0.25  # ... within this time [s]
_CORRECTION, _CORRECTION_TURN = 0.1, radians(8.0)  # a larger jump may be an error [m, rad]


class Relocalisation:
    """Compares the pose of the base with the integral of its measured twists, over a short window.

    A jump may be spread over several readings. A gap between two readings starts a new window.
    """

    def __init__(self) -> None:
        self._readings: deque[tuple[RobotState, SE3]] = deque()  # with the integral
        self.was_large = False
        """Whether the last jump was too large for a correction: it may be an error."""

    def note(self, state: RobotState) -> str:
        """Take a reading; returns a message if the base was relocalised, else an empty one."""
        went = SE3.Identity()
        if self._readings:
            last, by_then = self._readings[-1]
            passed = state.stamp - last.stamp
            if not 0.0 <= passed <= _WINDOW:
                self._readings.clear()
            else:
                vx, vy, w = passed * (last.base_twist + state.base_twist) / 2.0
                went = by_then * pin.exp6(np.array([vx, vy, 0.0, 0.0, 0.0, w]))
        self._readings.append((state, went))
        while state.stamp - self._readings[0][0].stamp > _WINDOW:
            self._readings.popleft()
        first, had_gone = self._readings[0]
        jump = (first.oTb * had_gone.actInv(went)).actInv(state.oTb)
        distance = hypot(*jump.translation.tolist())
        turn = hypot(*pin.log3(jump.rotation).tolist())
        if distance <= _DISTANCE and turn <= _TURN:
            return ""
        self._readings.clear()
        self.was_large = distance > _CORRECTION or turn > _CORRECTION_TURN
        return f"the base was relocalised by {distance:.2f} m and {degrees(turn):.0f}°"

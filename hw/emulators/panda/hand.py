"""The hand as it behaves at its interface: one motion of the fingers at a time."""

from __future__ import annotations

from dataclasses import dataclass

from hw.emulators.panda.parts import OPENING, PERIOD, Fingers
from hw.emulators.panda.wire import HandCommand, HandStatus

_HOMING_SPEED = 0.05
"""[m/s]"""
_MOVING_FORCE = 20.0
"""Of a motion that is no grasp [N]."""
_TOLERANCE = 1e-3
"""Distance from its goal at which a move has failed [m]."""


@dataclass(frozen=True)
class _Motion:
    command: HandCommand
    width: float
    speed: float
    inner: float = 0.0
    outer: float = 0.0
    force: float = _MOVING_FORCE


class EmulatedHand:
    """One hand; `tick` is one millisecond of it.

    Args:
        fingers: that it moves.
    """

    def __init__(self, fingers: Fingers) -> None:
        self.fingers = fingers
        self.is_grasped = False
        self.number = 0
        self._motion: _Motion | None = None

    @property
    def moving(self) -> bool:
        """Whether a motion is under way."""
        return self._motion is not None

    def begin(self, command: HandCommand, arguments: tuple[float, ...]) -> HandStatus | None:
        """Begin a motion; an answer if it ends at once.

        Args:
            command: which.
            arguments: of a grasp width, inner, outer [m], speed [m/s], force [N]; of a move width
                [m] and speed [m/s].
        """
        if command is HandCommand.HOMING:
            motion = _Motion(command, OPENING, _HOMING_SPEED)
        elif command is HandCommand.GRASP:
            width, inner, outer, speed, force = arguments
            if not force > 0.0:
                return HandStatus.FAIL
            motion = _Motion(command, width, speed, inner, outer, force)
        else:
            motion = _Motion(command, *arguments)
        if not (0.0 <= motion.width <= OPENING and motion.speed > 0.0):
            return HandStatus.FAIL
        self.is_grasped, self._motion = False, motion
        return None

    def stop(self) -> None:
        """End a motion where the fingers are."""
        self._motion = None
        self.fingers.stop()

    def tick(self) -> HandStatus | None:
        """One millisecond; how a motion has ended, if it has."""
        self.number += 1
        motion = self._motion
        if motion is None:
            return None
        # A grasp closes until something resists, and then looks at the width.
        goal = 0.0 if motion.command is HandCommand.GRASP else motion.width
        if not self.fingers.close_to(goal, motion.speed * PERIOD, motion.force):
            return None
        self._motion = None
        width = self.fingers.width
        if motion.command is HandCommand.GRASP:
            self.is_grasped = motion.width - motion.inner <= width <= motion.width + motion.outer
            done = self.is_grasped
        else:
            done = abs(width - motion.width) <= _TOLERANCE
        return HandStatus.SUCCESS if done else HandStatus.UNSUCCESSFUL

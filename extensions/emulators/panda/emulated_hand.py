"""Emulated hand: one motion of the fingers at a time."""

from dataclasses import dataclass, replace

from extensions.emulators.panda.joints_and_fingers import OPENING, PERIOD, Fingers
from extensions.emulators.panda.wire import HandCommand, HandStatus

_HOMING_SPEED = 0.05  # [m/s]
_MOVING_FORCE = 20.0  # of a motion without a grasp [N]
_TOLERANCE = 1e-3  # of the goal of a move [m]
_LONG_HOMING, _LONG_GRASP = 12_000, 4_000  # milliseconds, as reported
_WIDE = 0.9 * OPENING  # [m]


@dataclass(frozen=True)
class _Motion:
    command: HandCommand
    width: float
    speed: float
    inner: float = 0.0
    outer: float = 0.0
    force: float = _MOVING_FORCE


class EmulatedHand:
    """One hand; `tick` is one millisecond of it."""

    def __init__(self, fingers: Fingers, reported: frozenset[str] = frozenset()) -> None:
        self.fingers, self._reported = fingers, reported
        self.is_homed = not reported & {"unhomed", "slow-homing"}
        self.is_grasped = False
        self.number = 0
        self.homings = self.stops = 0
        self._motion: _Motion | None = None
        self._not_before = 0  # earliest end of the motion

    def begin(self, command: HandCommand, arguments: tuple[float, ...]) -> HandStatus | None:
        """Begin a motion with arguments as of the wire [m, m/s, N]; its status if it ends now."""
        self._not_before = 0
        if command is HandCommand.HOMING:
            self.homings += 1
            motion = _Motion(command, 0.0, _HOMING_SPEED)
            if "slow-homing" in self._reported:
                self._not_before = self.number + _LONG_HOMING
        elif not self.is_homed:
            return HandStatus.FAIL
        elif command is HandCommand.GRASP:
            width, inner, outer, speed, force = arguments
            if not force > 0.0:
                return HandStatus.FAIL
            if self.is_grasped and "second-grasp-false" in self._reported:
                return HandStatus.UNSUCCESSFUL
            if self.is_grasped and "second-grasp-fails" in self._reported:
                self._not_before = self.number + _LONG_GRASP
            motion = _Motion(command, width, speed, inner, outer, force)
        else:
            motion = _Motion(command, *arguments)
        if not (0.0 <= motion.width <= OPENING and motion.speed > 0.0):
            return HandStatus.FAIL
        self.is_grasped, self._motion = False, motion
        return None

    def stop(self) -> bool:
        """Stop a motion; whether that is obeyed."""
        self.stops += 1
        if self._motion is not None and "stop-unheeded" in self._reported:
            return False
        self._motion = None
        self.fingers.stop()
        return True

    def black_out(self) -> None:
        """Lose power for a moment, and forget homing and grasp."""
        self.is_homed = self.is_grasped = False
        self._motion = None

    def tick(self) -> HandStatus | None:
        """Advance by one millisecond; the status of a motion that has ended."""
        self.number += 1
        motion = self._motion
        if motion is None:
            return None
        # A grasp closes until something resists, and then looks at the width.
        goal = 0.0 if motion.command is HandCommand.GRASP else motion.width
        if not self.fingers.close_to(goal, motion.speed * PERIOD, motion.force):
            return None
        if motion.command is HandCommand.HOMING and motion.width == 0.0:
            self._motion = replace(motion, width=OPENING)
            return None
        if self.number < self._not_before:
            return None
        return self._end(motion, self.fingers.width)

    def _end(self, motion: _Motion, width: float) -> HandStatus | None:
        """Status of a motion whose fingers rest; None if it goes on nevertheless."""
        reported = self._reported
        if motion.command is HandCommand.GRASP:
            done = motion.width - motion.inner <= width <= motion.width + motion.outer
            has_failed = bool(self._not_before) or (
                width > _WIDE and "wide-grasp-fails" in reported
            )
            self.is_grasped = done and not has_failed and "never-grasped" not in reported
        else:
            done = abs(width - motion.width) <= _TOLERANCE
            has_failed = not done and "move-fails" in reported
            self.is_homed |= motion.command is HandCommand.HOMING
            if not done and reported & {"move-blocks", "stop-unheeded"}:
                return None
        self._motion = None
        if motion.command is HandCommand.GRASP and not done and "strict-grasp" in reported:
            self._motion = _Motion(HandCommand.MOVE, OPENING, motion.speed)
        if has_failed:
            return HandStatus.FAIL
        return HandStatus.SUCCESS if done else HandStatus.UNSUCCESSFUL

"""Emulated arm: modes, motions, limits, reflexes, lost packets."""

from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass, field
from math import isfinite

from drivers.panda import JointLimits, Mode
from extensions.emulators.panda.joints_and_fingers import PERIOD, Joints
from extensions.emulators.panda.wire import ERRORS, MotionCommand, MoveStatus

_MOST_LOST = 20  # lost packets in a row that end a motion, as of the real arm
_PATIENCE = 500  # periods that a new motion waits for its first command
_RECOVERY = 100  # periods that a recovery takes
_LONG_RECOVERY, _LATE_REFLEX = 12_000, 1_500  # the same, and delay of a reflex [ms], as reported
_LOW_SPEED = 0.05  # speed of a reported velocity violation [rad/s]
_BEGINS = {"locked": Mode.OTHER, "guided": Mode.GUIDING, "user-stopped": Mode.USER_STOPPED}
"""Initial modes, as reported."""
_ROUNDING = 1e-6  # relative tolerance of limits
_ENDS = 1e-3  # slower is a command to rest, with which a motion may end [rad/s]
_RESTS = 0.01  # a slower joint is at rest [rad/s]
_Z7: tuple[float, ...] = (0.0,) * 7
NEEDS_A_PERSON = {"joint_position_limits_violation", "self_collision_avoidance_violation"}
"""Errors that no program can clear."""


@dataclass
class Seen:
    """Statistics of motions; the first three as fractions of their limits."""

    speed: float = 0.0
    acceleration: float = 0.0
    jerk: float = 0.0
    commands: int = 0
    lost: int = 0
    lost_in_a_row: int = 0
    violations: list[str] = field(default_factory=list)  # reflexes because of commands


class EmulatedArm:
    """One arm; `tick` is one millisecond of it."""

    def __init__(
        self, joints: Joints, limits: JointLimits, reported: frozenset[str] = frozenset()
    ) -> None:
        self.joints, self._limits, self._reported = joints, limits, reported
        self.mode = next((_BEGINS[one] for one in reported if one in _BEGINS), Mode.IDLE)
        self.needs_recovery = "needs-recovery" in reported  # and refuses everything else
        self.recoveries = 0
        self.rush = 0.0  # added to the speed of the first joint in a motion [rad/s]
        self.errors: frozenset[str] = frozenset()
        self.last_errors: frozenset[str] = frozenset()
        self.q_d, self.qd_d, self.qdd_d = joints.q, _Z7, _Z7
        self.number = 0  # milliseconds since power-on
        self.ended: MoveStatus | None = None  # how the motion has ended; the server takes it
        self.recovered = False  # whether a recovery has just ended; the server takes it
        self.resting = self.still = 0  # milliseconds at rest, and commanded so
        self.most_lost = _MOST_LOST
        self.seen = Seen()
        self._lost = self._waited = 0
        self._arrived: deque[bool] = deque(maxlen=100)
        self._recovery = 0
        self._late: tuple[int, str] | None = None

    @property
    def success_rate(self) -> float:
        """Fraction of the last 100 commands that arrived; 0 without a motion."""
        return sum(self._arrived) / len(self._arrived) if self._arrived else 0.0

    def flags(self, errors: Iterable[str]) -> bytes:
        """(41,) flags of the state."""
        if self.resting and "forgets-errors" in self._reported and errors is self.errors:
            errors = frozenset()
        return bytes(name in errors for name in ERRORS) if errors else bytes(len(ERRORS))

    def begin_motion(self) -> MoveStatus:
        """Begin a motion by joint velocities."""
        if self.mode is not Mode.IDLE or self.needs_recovery:
            return MoveStatus.NOT_POSSIBLE
        self.mode, self.last_errors = Mode.MOVE, frozenset()
        self.q_d, self.qd_d, self.qdd_d = self.joints.q, _Z7, _Z7
        self._lost = self._waited = 0
        self._arrived.clear()
        return MoveStatus.STARTED

    def stop_motion(self) -> None:
        """End a motion at any speed; the arm decelerates by itself."""
        if self.mode is Mode.MOVE:
            self._end(MoveStatus.PREEMPTED, Mode.IDLE)

    def recover(self) -> bool:
        """Begin to clear the errors; False if the user has to act."""
        self.recoveries += 1
        if self.mode not in (Mode.IDLE, Mode.REFLEX) or self.errors & NEEDS_A_PERSON:
            return False
        is_slow = "slow-recovery" in self._reported
        self.mode, self._recovery = Mode.RECOVERING, _LONG_RECOVERY if is_slow else _RECOVERY
        return True

    def reflex(self, error: str) -> None:
        """Stop because of an error."""
        if "late-reflex" in self._reported and self.mode is Mode.MOVE:
            self._late = self._late or (self.number + _LATE_REFLEX, error)
            if self.number < self._late[0]:
                return
        self._late = None
        self.errors = self.last_errors = frozenset({error})
        self._end(MoveStatus.REFLEX_ABORTED, Mode.REFLEX)

    def switch(self, mode: Mode) -> None:
        """Change the mode, as the user does by buttons or in Desk."""
        self.needs_recovery |= mode is Mode.USER_STOPPED and "stop-needs-recovery" in self._reported
        self._end(MoveStatus.EMERGENCY_ABORTED, mode)
        if mode is Mode.IDLE and self.errors:
            self.mode = Mode.REFLEX

    def commander_left(self) -> None:
        """Handle the end of the connection."""
        if self.mode is Mode.MOVE:
            self._end(MoveStatus.ABORTED, Mode.IDLE)
        self.ended = None

    def tick(self, command: MotionCommand | None, *, excused: bool = False) -> None:
        """Advance by one millisecond; `excused`: the emulator was too late for a command."""
        self.number += 1
        if self._late is not None:
            self.reflex(self._late[1])
        if self.mode is Mode.MOVE and self._late is None:
            self._move(command, excused)
        if self.mode is not Mode.MOVE or self._late is not None:
            self._brake()
        if self.mode is Mode.RECOVERING:
            self._recovery -= 1
            if self._recovery <= 0:
                self.mode, self.errors, self.recovered = Mode.IDLE, frozenset(), True
                self.needs_recovery = False
                self.joints.release()
        joints, limits = self.joints, self._limits
        rush = self.rush if self.mode is Mode.MOVE else 0.0
        met = joints.follow((self.qd_d[0] + rush, *self.qd_d[1:]) if rush else self.qd_d)
        self.still = self.still + 1 if max(map(abs, self.qd_d)) < _ENDS else 0
        self.resting = self.resting + 1 if max(map(abs, joints.qd)) < _RESTS else 0
        if met and self.mode is Mode.IDLE:
            self.reflex(met)
        if self.mode is Mode.MOVE:
            rows = zip(joints.q, limits.q_min, limits.q_max, strict=True)
            if "velocity-violation" in self._reported and max(map(abs, joints.qd)) > _LOW_SPEED:
                self.reflex("joint_velocity_violation")
            elif met:
                self.reflex(met)
            elif any(not low <= q <= high for q, low, high in rows):
                self.reflex("joint_position_limits_violation")

    def _move(self, command: MotionCommand | None, excused: bool) -> None:
        if command is None:
            self._go_on(excused)
            return
        self._lost = 0
        self._arrived.append(True)
        self.seen.commands += 1
        if command.finished:
            if max(map(abs, self.qd_d)) > _ENDS:
                self._refuse("joint_motion_generator_velocity_discontinuity")
            else:
                self._end(MoveStatus.SUCCESS, Mode.IDLE)
            return
        self._waited = _PATIENCE
        self._accept(command.qd)

    def _go_on(self, excused: bool) -> None:
        """Without a command: keep the acceleration, and count; if excused, keep the velocity."""
        if self._waited < _PATIENCE:
            self._waited += 1
            return
        if excused:
            self._apply(self.qd_d)
            return
        self._count_lost()
        if self.mode is not Mode.MOVE:
            return
        fastest = self._limits.qd
        kept = [v + PERIOD * a for v, a in zip(self.qd_d, self.qdd_d, strict=True)]
        if any(abs(v) > most for v, most in zip(kept, fastest, strict=True)):
            kept = list(self.qd_d)
        self._apply(kept)

    def _count_lost(self) -> None:
        self._arrived.append(False)
        self._lost += 1
        self.seen.lost += 1
        self.seen.lost_in_a_row = max(self.seen.lost_in_a_row, self._lost)
        if self._lost >= self.most_lost:
            self.reflex("communication_constraints_violation")

    def _accept(self, qd: tuple[float, ...]) -> None:
        limits = self._limits
        if not all(map(isfinite, qd)):
            self._refuse("joint_motion_generator_velocity_limits_violation")
            return
        qdd = [(w - v) / PERIOD for w, v in zip(qd, self.qd_d, strict=True)]
        qddd = [(b - a) / PERIOD for b, a in zip(qdd, self.qdd_d, strict=True)]
        seen = self.seen
        speed, acceleration, jerk = (
            max(abs(v) / most for v, most in zip(values, most_of, strict=True))
            for values, most_of in ((qd, limits.qd), (qdd, limits.qdd), (qddd, limits.qddd))
        )
        most = 1.0 + _ROUNDING
        seen.speed = max(seen.speed, speed)
        seen.acceleration = max(seen.acceleration, acceleration)
        seen.jerk = max(seen.jerk, jerk)
        if speed > most:
            self._refuse("joint_motion_generator_velocity_limits_violation")
        elif acceleration > most:
            self._refuse("joint_motion_generator_velocity_discontinuity")
        elif jerk > most:
            self._refuse("joint_motion_generator_acceleration_discontinuity")
        else:
            self._apply(qd)

    def _apply(self, qd: Iterable[float]) -> None:
        limits, qd = self._limits, tuple(qd)
        self.qdd_d = tuple([(w - v) / PERIOD for w, v in zip(qd, self.qd_d, strict=True)])
        self.qd_d = qd
        self.q_d = tuple([p + PERIOD * v for p, v in zip(self.q_d, qd, strict=True)])
        rows = zip(self.q_d, limits.q_min, limits.q_max, strict=True)
        if any(not low <= q <= high for q, low, high in rows):
            self._refuse("joint_motion_generator_position_limits_violation")

    def _refuse(self, error: str) -> None:
        self.seen.violations.append(error)
        self.reflex(error)

    def _end(self, status: MoveStatus, mode: Mode) -> None:
        if self.mode is Mode.MOVE:
            self.ended = status
            self._arrived.clear()
        self.mode = mode

    def _brake(self) -> None:
        if not any(self.qd_d):
            self.qdd_d = _Z7
            return
        steps = [PERIOD * a for a in self._limits.qdd]
        self.qd_d = tuple([v - min(max(v, -s), s) for v, s in zip(self.qd_d, steps, strict=True)])
        self.q_d = tuple([p + PERIOD * v for p, v in zip(self.q_d, self.qd_d, strict=True)])

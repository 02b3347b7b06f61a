"""Monitor of commanded against measured motion.

Frozen readings with fresh stamps, a base that ignores commands, and an arm that moves by itself
have plausible single readings. Over the last second they do not fit the commands; nor does an axis
that is faster than commanded, or moves the other way.
"""

from collections import deque
from collections.abc import Callable
from math import hypot
from operator import attrgetter
from typing import NamedTuple

import numpy as np

from config.planar import ORIGIN, Pose2D
from controller import Command
from hw.state import Array, RobotState
from robots import RobotDescription

_WINDOW = 1.0  # of the comparison [s]
_BASE_PATH = 0.25  # commanded way after which the base must have moved [m]
_ARM_PATH = 0.15  # the same of a joint [rad]
_MIN_SHARE = 0.2  # of the commanded way that was moved, at least
_BASE_SURPLUS = 0.3  # largest motion of the base without a command, its lag apart [m]
_ARM_SURPLUS = 0.15  # the same of a joint [rad]
_BASE_FASTER = np.array([0.1, 0.1, 0.2])  # largest surplus speed, x, y, yaw [m/s, m/s, rad/s]
_ARM_FASTER = 0.3  # the same of a joint [rad/s]
_FASTER_FOR = 0.2  # time for which a larger surplus is tolerated [s]
_DEAD_TIME = 0.1  # a command counts for the lag and this [s]; then it fades at the limit
_TOLD = 300  # commands that are kept: they have faded in this many periods
_WRONG = "moves as it was not commanded", "does not do what it is commanded"
_METRES_PER_RADIAN = 0.3  # weight of a rotation of the base [m/rad]
_JUMP = 0.03  # a base that moves this much farther than it can was relocalised [m]


class _Moment(NamedTuple):
    stamp: float
    base_path: float  # Commanded [m]
    arm_path: float  # commanded, of the fastest joint in each period [rad]
    base_commanded: Pose2D  # dead reckoning of the commanded twists: x, y, heading
    base_measured: Pose2D
    arm_commanded: Array  # (j,) integral of the commanded joint velocities [rad]
    q: Array

    def base_since(self, then: "_Moment") -> tuple[Pose2D, Pose2D]:
        """How the base was commanded to move, and moved."""
        return (
            self.base_commanded.relative_to(then.base_commanded),
            self.base_measured.relative_to(then.base_measured),
        )


class MotionMonitor:
    """Compares the commands of one robot with its measured motion."""

    def __init__(self, description: RobotDescription) -> None:
        limits, base_lag, arm_lag = description.limits, description.base.lag, description.arm.lag
        self._base_lag, self._arm_lag = base_lag, arm_lag
        self._base_surplus = _BASE_SURPLUS + 2.0 * base_lag * limits.base_twist.max()
        self._arm_surplus = _ARM_SURPLUS + 2.0 * arm_lag * limits.qd
        self._fastest = 2.0 * (limits.base_twist[:2].max() + 0.3 * limits.base_twist[2])
        self._moments: deque[_Moment] = deque()
        self._told: deque[tuple[float, Command]] = deque(maxlen=_TOLD)  # with their stamps [s]
        self._base = _SpeedMonitor(limits.base_acceleration, base_lag, _BASE_FASTER)
        self._slides, self._called = description.arm.slides, description.arm.called
        self._arm = _SpeedMonitor(limits.qdd, arm_lag, np.full(len(limits.qd), _ARM_FASTER))

    def reset(self) -> None:
        """Compare from the next reading on, for example after a fault or a gap in the commands."""
        self._moments.clear()
        self._told.clear()
        self._base.reset()
        self._arm.reset()

    def mismatch(self, state: RobotState, applied: Command) -> str:
        """How measured and commanded motion differ, for people; empty if they agree."""
        measured = Pose2D.of(state.oTb)
        if not self._moments:
            start = ORIGIN
            self._moments.append(
                _Moment(state.stamp, 0.0, 0.0, start, measured, np.zeros(len(state.q)), state.q)
            )
            return ""
        before = self._moments[-1]
        dt = state.stamp - before.stamp
        if dt <= 0.0:
            return ""
        self._told.append((state.stamp, applied))
        vx, vy, w = self._followed(self._base_lag).base_twist.tolist()
        qd = self._followed(self._arm_lag).qd
        if _length(measured.relative_to(before.base_measured)) > self._fastest * dt + _JUMP:
            self._rebase(measured)
            before = self._moments[-1]
        newest = _Moment(
            stamp=state.stamp,
            base_path=before.base_path + (hypot(vx, vy) + _METRES_PER_RADIAN * abs(w)) * dt,
            arm_path=before.arm_path + float(np.abs(qd).max()) * dt,
            base_commanded=before.base_commanded.moved(vx * dt, vy * dt, w * dt),
            base_measured=measured,
            arm_commanded=before.arm_commanded + qd * dt,
            q=state.q,
        )
        self._moments.append(newest)
        while self._moments[1].stamp < newest.stamp - _WINDOW:
            self._moments.popleft()
        return (
            self._overspeed(state, applied)
            or self._base_mismatch(newest)
            or self._arm_mismatch(newest)
        )

    def _followed(self, lag: float) -> Command:
        """The command that a part follows now, after its lag [s]."""
        now = self._told[-1][0]
        return next((one for at, one in reversed(self._told) if at <= now - lag), self._told[0][1])

    def _overspeed(self, state: RobotState, applied: Command) -> str:
        axis = self._base.faster(state.stamp, state.base_twist, applied.base_twist)
        if axis is not None:
            does, told = float(state.base_twist[axis]), float(applied.base_twist[axis])
            verb, unit = ("turns", "rad/s") if axis == 2 else ("drives", "m/s")
            what, own = f"the base {verb}", "its own settings of speed are not those of its file"
        elif (axis := self._arm.faster(state.stamp, state.qd, applied.qd)) is not None:
            does, told = float(state.qd[axis]), float(applied.qd[axis])
            verb, unit = ("slides", "m/s") if self._slides[axis] else ("turns", "rad/s")
            what, own = f"{self._called(axis)} {verb}", "its limits are not those of its file"
        else:
            return ""
        cause = f"{own}, or somebody else moves it"
        if does * told < 0.0:
            cause = "the direction of this axis is the other way round"
        return f"{what} at {does:.2f} {unit} and was told {told:.2f} {unit}: {cause}"

    def _base_mismatch(self, newest: _Moment) -> str:
        then = self._before(newest, attrgetter("base_path"), _BASE_PATH)
        asked, moved = newest.base_since(then)
        ignores = _length(asked) >= 0.8 * _BASE_PATH
        if not ignores or _length(moved) >= _MIN_SHARE * _length(asked):
            then = self._moments[0]
            asked, moved = newest.base_since(then)
            surplus = _length(moved.relative_to(asked))
            if surplus <= self._base_surplus:
                return ""
            ignores = _lags(_length(asked), _length(moved), surplus)
        told, does = (
            f"({one.x / dt:.2f}, {one.y / dt:.2f}) m/s and {one.heading / dt:.2f} rad/s"
            for dt in [newest.stamp - then.stamp]
            for one in (asked, moved)
        )
        return f"the base {_WRONG[ignores]}: told {told}, it moved at {does}"

    def _arm_mismatch(self, newest: _Moment) -> str:
        then = self._before(newest, attrgetter("arm_path"), _ARM_PATH)
        asked, moved = newest.arm_commanded - then.arm_commanded, newest.q - then.q
        joint = int(np.abs(asked).argmax())
        ignores = bool(abs(asked[joint]) >= 0.8 * _ARM_PATH)
        if not ignores or abs(moved[joint]) >= _MIN_SHARE * abs(asked[joint]):
            then = self._moments[0]
            asked, moved = newest.arm_commanded - then.arm_commanded, newest.q - then.q
            over = np.abs(moved - asked) - self._arm_surplus
            joint = int(over.argmax())
            if over[joint] <= 0.0:
                return ""
            ignores = _lags(*np.abs([asked, moved, moved - asked])[:, joint].tolist())
        dt, unit = newest.stamp - then.stamp, "m/s" if self._slides[joint] else "rad/s"
        told, does = float(asked[joint] / dt), float(moved[joint] / dt)
        return (
            f"{self._called(joint)} {_WRONG[ignores]}: told {told:.2f} {unit}, "
            f"it moved at {does:.2f} {unit}"
        )

    def _before(self, newest: _Moment, path: Callable[[_Moment], float], least: float) -> _Moment:
        """The beginning of the shortest path that is long enough, or of all."""
        long = (one for one in reversed(self._moments) if path(newest) - path(one) >= least)
        return next(long, self._moments[0])

    def _rebase(self, measured: Pose2D) -> None:
        """Go on from a new pose of the base in the world, after a relocalisation."""
        last = self._moments[-1]
        self._moments.clear()
        self._moments.append(last._replace(base_measured=measured))


class _SpeedMonitor:
    """Bounds of the (n,) speeds of a part that follows late: limits, lag [s], tolerated surplus."""

    def __init__(self, acceleration: Array, lag: float, margin: Array) -> None:
        self._acceleration, self._margin = acceleration, margin
        self._memory = lag + _DEAD_TIME
        self._told: deque[tuple[float, Array]] = deque(maxlen=_TOLD)  # with their stamps [s]
        self._since: float | None = None

    def reset(self) -> None:
        self._told.clear()
        self._since = None

    def faster(self, stamp: float, measured: Array, commanded: Array) -> int | None:
        """The axis that was faster than commanded, (n,) velocities at a stamp [s], for too long."""
        if not self._told:  # its present speed may be commanded before
            self._told.append((stamp - self._memory, measured))
        self._told.append((stamp, commanded))
        axes = zip(measured.tolist(), commanded.tolist(), self._margin.tolist(), strict=True)
        if all(min(told, 0.0) - m <= does <= max(told, 0.0) + m for does, told, m in axes):
            self._since = None
            return None
        stamps, told = map(np.array, zip(*self._told, strict=True))
        fade = np.maximum(stamp - self._memory - stamps, 0.0)[:, None] * self._acceleration
        low = np.minimum((told + fade).min(axis=0), 0.0)
        high = np.maximum((told - fade).max(axis=0), 0.0)
        surplus = np.maximum(low - measured, measured - high) - self._margin
        axis = int(surplus.argmax())
        if surplus[axis] <= 0.0:
            self._since = None
            return None
        self._since = stamp if self._since is None else self._since
        return axis if stamp - self._since >= _FASTER_FOR else None


def _lags(asked: float, moved: float, surplus: float) -> bool:
    """Whether what was moved is less than what was commanded, and not another way [m or rad]."""
    return moved < asked and surplus <= (1.0 + _MIN_SHARE) * asked


def _length(pose: Pose2D) -> float:
    return hypot(pose.x, pose.y) + _METRES_PER_RADIAN * abs(pose.heading)

"""Where the map is in the world of the odometry (REP 105)."""

from bisect import bisect_left
from collections import deque
from collections.abc import Collection
from concurrent.futures import Executor, Future
from dataclasses import dataclass, field, replace
from math import degrees, hypot, inf, sqrt
from typing import Any, NamedTuple

import numpy as np
from pinocchio import SE3

from behaviours.sensing.agreement import Agreement
from behaviours.sensing.furniture import Furniture
from behaviours.sensing.vision import Vision
from controller import Array, BaseGoal, MotionGoal, PoseGoal
from hw import DepthFrame, InlineExecutor, LaserScan, Robot, RobotState
from perception.registration import (
    Judge,
    Registration,
    Surfaces,
    Update,
    depth_cloud,
    difference,
    in_space,
    on_floor,
    register,
    scan_cloud,
    smoothed,
)
from perception.registration import Localisation as Filter

SENSORS = ("laser", "camera")  # what is registered to the map

_INTERVAL = 0.2  # between two registrations [s]
_FRAME_LEAD = 0.03  # before one the camera is asked for a frame [s] ...
_FRAME_AGE = 0.1  # ... unless there is one that will not be older then [s]
_SCAN_WAIT = 0.1  # a frame waits for a scan this long [s]
_MAX_AGE = 0.3  # of a scan or frame that is registered [s]
_HISTORY = 1.0  # how far back odometry is kept [s]
_MOVED = 0.002  # motion of the base that is one [m, rad]
_ROUNDING = 1e-9  # of a pose that is moved to the world and back [m]


class _Job(NamedTuple):
    """A registration in progress; poses on the floor (3,)."""

    oTb: Array
    """At the capture."""
    result: Future[tuple[Registration, Registration | None]]
    """From the estimate, and from a pose that the base's own localisation insists on."""


@dataclass(kw_only=True, eq=False)
class Localiser:
    """Estimates the transform from map to odometry, and spreads its corrections.

    The world w in which everything moves is that of the odometry: smooth, and never jumping. The
    map m is where the newest estimate has it; both are the same where the robot reports no
    localised pose of its own.
    """

    surfaces: Surfaces = field(default_factory=lambda: Surfaces({}))  # of the map
    sensors: Collection[str] = SENSORS  # those that are registered to it
    executor: Executor = field(default_factory=InlineExecutor)  # registers beside the loop

    def __post_init__(self) -> None:
        self.wTm: SE3 | None = None
        """The map in the world; None where they are the same."""
        self.mTw: SE3 | None = None
        """Its inverse."""
        self.mTb = SE3.Identity()
        """The base on the map, as read this tick."""
        self.furniture = Furniture()
        """Where it was moved from its place on the map."""
        self.registration: Registration | None = None
        """The newest."""
        self.scan: LaserScan | None = None
        """The newest that was registered, or is being."""
        self.updates: list[Update] = []
        """What the measurements of this tick did to the estimate."""
        self._asked: tuple[object, ...] = (None, None, None)
        self._on_map: tuple[Any, MotionGoal | None] = None, None  # what was answered
        self.relocalised = ""
        """What happened if this tick replaced the estimate by what the base says; else empty."""
        self.agreement = Agreement()
        """Of the map with what is seen."""
        self.confirmed = -inf
        """Stamp of the newest measurement that the estimate explains [s]."""
        self.registrations = 0
        """How many the estimate has taken."""
        self.largest = 0.0, 0.0
        """Largest correction by one of them: of position [m], and of heading [rad]."""
        self._filter: Filter | None = None
        self._applied = np.zeros(3)
        self._has_moved = False
        """Whether the base has moved since the first reading: until then corrections are free."""
        self._stamp = 0.0
        self._history: deque[tuple[float, Array]] = deque()
        self._localised: object = None
        self._source = ""
        self._job: _Job | None = None
        self._frame: DepthFrame | None = None
        self._due = -inf
        self._judge = Judge()

    @property
    def estimate(self) -> tuple[Array, Array] | None:
        """The newest estimate of mTb, x, y [m] and heading [rad] (3,), with its covariance (3, 3).

        Its corrections reach `mTb` smoothly. None where `mTb` is exact.
        """
        if self._filter is None:
            return None
        oTb = self._history[-1][1]
        return self._filter.pose(oTb), self._filter.covariance(oTb)

    @property
    def uncertainty(self) -> float:
        """Two standard deviations of where the base is on the map, the way it is larger [m]."""
        if (estimate := self.estimate) is None:
            return 0.0
        return 2.0 * sqrt(float(np.linalg.eigvalsh(estimate[1][:2, :2])[1]))

    @property
    def pending(self) -> float:
        """How far the newest estimate is from where the base is taken to be [m]."""
        return 0.0 if self.estimate is None else _between(self.estimate[0], on_floor(self.mTb))[0]

    @property
    def doubt(self) -> str:
        """Why it is not certain where the base is; empty while it is."""
        if self._filter is None or (off := self._filter.doubt) is None:
            return ""
        return f"{self._source} has it {off[0]:.2f} m and {degrees(off[1]):.0f}° away"

    @property
    def wrong(self) -> str:
        """What is wrong with the map, or with who tells the base where it is; else empty."""
        if (lost := self.agreement.fault) is not None:
            return lost.text
        if self._filter is None or not self._filter.is_contradicted:
            return ""
        return f"{self._source} has the base where laser and camera do not see it"

    def read(self, state: RobotState) -> None:
        """Take a reading: odometry, and the localised pose if there is a new one."""
        localised, self.updates, self.relocalised = state.localised, [], ""
        if self._filter is None and localised is None:
            self.mTb = state.wTb
            return
        oTb = on_floor(state.wTb)
        passed, self._stamp = state.stamp - self._stamp, state.stamp
        self._note(state.stamp, oTb)
        if self._filter is not None:
            self._filter.travelled(oTb)
        if localised is not None and localised is not self._localised:
            self._localised = localised
            self._source = localised.source
            given = on_floor(localised.mTb), localised.covariance, localised.stamp
            then = self._odometry(localised.stamp)
            if self._filter is None:
                self._filter, self.confirmed = Filter(*given, then), localised.stamp
                self._applied = self._filter.mTo
            else:
                self.updates.append(self._filter.localised(*given, then))
                self._confirm(localised.stamp)
        elif localised is None and self._filter is not None:
            self._filter.unlocalised()
        assert self._filter is not None
        newest = self._filter.mTo
        if not self._has_moved:
            self._applied = newest
            self._has_moved = bool(np.linalg.norm(oTb - self._history[0][1]) > _MOVED)
        elif passed > 0.0:
            self._applied = smoothed(self._applied, newest, oTb, passed)
        self.mTw = in_space(self._applied)
        self.wTm = self.mTw.inverse()
        self.mTb = self.mTw * state.wTb

    def look(self, robot: Robot, vision: Vision) -> None:
        """Take the registration that is done, and begin the next one when it is due."""
        if self._filter is None:
            return
        oTb = self._history[-1][1]
        before = self._filter.pose(oTb)
        if self._filter.carried(oTb):
            self._replaced(before, oTb, ": nothing in sight speaks against it")
        if not len(self.surfaces):
            return
        frame = None
        if "camera" in self.sensors and self._stamp >= self._due - _FRAME_LEAD:
            frame = vision.newest(self._due - _FRAME_AGE)
        if self._job is None and self._stamp >= self._due:
            self._begin(robot, frame)
        if self._job is not None and self._job.result.done():
            (oTb, result), self._job = self._job, None
            self._take(*result.result(), oTb)

    def _take(self, here: Registration, there: Registration | None, oTb: Array) -> None:
        """Take a registration from the estimate, and one from what the base insists on."""
        assert self._filter is not None
        self.registration, before = here, self._filter.pose(oTb)
        moved: Collection[str] = ()
        if there is not None and self._filter.relocalised(there, here, oTb):
            self.registration = there
            self._replaced(before, oTb)
        else:
            self.updates.append(self._filter.registered(here, oTb))
            if self.updates[-1].accepted:
                off, turn = _between(before, self._filter.pose(oTb))
                self.registrations += 1
                self.largest = max(self.largest[0], off), max(self.largest[1], turn)
            moved = self.updates[-1].moved
            self.agreement.note(self._stamp, self.updates[-1].accepted, here, self.surfaces)
            self._confirm(self._stamp)
        self.furniture.note(self.registration)
        self.furniture.suspect(moved)

    def _confirm(self, stamp: float) -> None:
        self.confirmed = stamp if self.updates[-1].accepted else self.confirmed

    def _replaced(self, before: Array, oTb: Array, how: str = "") -> None:
        """What the base says has replaced the estimate: the map jumps there."""
        assert self._filter is not None
        self._applied = self._filter.mTo
        self.furniture.forget()
        self._judge = Judge()
        self.agreement = Agreement()
        off, turn = _between(before, self._filter.pose(oTb))
        self.relocalised = f"the base was relocalised by {off:.2f} m and {degrees(turn):.0f}°{how}"

    def wTm_on(self, piece: str) -> SE3 | None:
        """The map in the world, for what stands on a piece of furniture; None: they are the same.

        Where the piece was moved from its place on the map, so is what stands on it.
        """
        motion = self.furniture.motion(piece)
        return self.wTm if motion is None or self.wTm is None else self.wTm * motion

    def on_map(
        self, state: RobotState, goal: MotionGoal | None
    ) -> tuple[RobotState, MotionGoal | None]:
        """A reading and a goal of the world, on the map, as the controller needs them."""
        if (mTw := self.mTw) is None:
            return state, goal
        asked, before = (mTw, state, goal), self._on_map[1]
        if any(one is not known for one, known in zip(asked, self._asked, strict=True)):
            moved = None if goal is None else _same(goal.moved(mTw), before)
            self._asked, self._on_map = asked, (replace(state, wTb=self.mTb), moved)
        return self._on_map

    def close(self) -> None:
        """End the thread."""
        self.executor.shutdown(wait=False, cancel_futures=True)

    def _begin(self, robot: Robot, frame: DepthFrame | None) -> None:
        assert self._filter is not None
        scan = robot.laser.latest(_MAX_AGE) if "laser" in self.sensors else None
        scan = None if scan is self.scan else scan
        if frame is self._frame or (frame and self._stamp - frame.stamp > _MAX_AGE):
            frame = None
        waits = "laser" in self.sensors and self._stamp < self._due + _SCAN_WAIT
        if scan is None and (frame is None or waits):
            return
        self._due = self._stamp + _INTERVAL
        self.scan, self._frame = scan or self.scan, frame or self._frame
        oTb = self._odometry(scan.stamp if scan else frame.stamp if frame else self._stamp)
        here = self._filter.pose(oTb), self._filter.covariance(oTb)
        there = self._filter.proposal(oTb)
        moved, judge = self.furniture.names, self._judge

        def work() -> tuple[Registration, Registration | None]:
            bTw = in_space(oTb).inverse()
            clouds = []
            if scan is not None and (laser := robot.description.laser) is not None:
                clouds.append(scan_cloud(scan.points, laser))
            if frame is not None:
                bTc = bTw * frame.wTc
                clouds.append(depth_cloud(frame.depth, frame.intrinsics, bTc))
            found = register(self.surfaces, clouds, *here, moved=moved, judge=judge)
            if there is None:
                return found, None
            return found, register(self.surfaces, clouds, *there, moved=moved)

        self._job = _Job(oTb, self.executor.submit(work))

    def _note(self, stamp: float, oTb: Array) -> None:
        if self._history and self._history[-1][0] >= stamp:
            return
        self._history.append((stamp, oTb))
        while self._history[0][0] < stamp - _HISTORY:
            self._history.popleft()

    def _odometry(self, stamp: float) -> Array:
        """(3,) the base in odometry at a stamp [s], interpolated."""
        known = list(self._history)
        k = bisect_left(known, stamp, key=lambda one: one[0])
        if k in (0, len(known)):
            return known[min(k, len(known) - 1)][1]
        (before, a), (after, b) = known[k - 1], known[k]
        share = (stamp - before) / (after - before)
        between: Array = a + share * difference(b, a)
        return between


def _same(goal: MotionGoal, before: MotionGoal | None) -> MotionGoal:
    """A goal with exactly the pose that it had before, if that differs by rounding only."""
    match goal, before:
        case PoseGoal(), PoseGoal() if goal.wTe.isApprox(before.wTe, _ROUNDING):
            return replace(goal, wTe=before.wTe)
        case BaseGoal(), BaseGoal() if goal.wTb.isApprox(before.wTb, _ROUNDING):
            return replace(goal, wTb=before.wTb)
    return goal


def _between(a: Array, b: Array) -> tuple[float, float]:
    """Distance [m] and angle [rad] between two poses on the floor (3,)."""
    x, y, turn = difference(b, a).tolist()
    return hypot(x, y), abs(turn)

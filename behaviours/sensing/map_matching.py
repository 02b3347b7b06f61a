"""Registrations of scans and frames to the map: made beside the loop, a few times a second."""

from bisect import bisect_left
from collections.abc import Callable, Collection
from concurrent.futures import Executor, Future
from math import inf
from typing import NamedTuple

from behaviours.sensing.vision import Vision
from config.planar import compose, difference, in_space, inverse
from controller import Array
from hw import DepthFrame, InlineExecutor, LaserScan
from perception.registration import (
    Judge,
    LocalisationFilter,
    Registration,
    Surfaces,
    depth_cloud,
    register,
    rivals,
    scan_cloud,
)
from robots import RobotDescription

_INTERVAL = 0.2  # between two registrations [s]
_FRAME_LEAD = 0.03  # before one the camera is asked for a frame [s] ...
_FRAME_AGE = 0.1  # ... unless there is one that will not be older then [s]
_SCAN_WAIT = 0.1  # a frame waits for a scan this long [s]
_MAX_AGE = 0.3  # of a frame that is registered [s]
_HISTORY = 1.0  # how far back odometry is kept [s]


class Odometry:
    """Where the base was in odometry lately; poses on the floor (3,)."""

    def __init__(self, stamp: float, oTb: Array) -> None:
        self._known = [(stamp, oTb)]
        self.oldest = self.newest = oTb

    def note(self, stamp: float, oTb: Array) -> None:
        """Add a pose at a stamp [s]; one that is not newer is left out."""
        if stamp > self._known[-1][0]:
            self._known.append((stamp, oTb))
        while self._known[0][0] < stamp - _HISTORY:
            del self._known[0]
        self.oldest, self.newest = self._known[0][1], self._known[-1][1]

    def at(self, stamp: float) -> Array:
        """The pose at a stamp [s], interpolated; outside of what is kept the nearest."""
        k = bisect_left(self._known, stamp, key=lambda one: one[0])
        if k in (0, len(self._known)):
            return self.newest if k else self.oldest
        (before, a), (after, b) = self._known[k - 1 : k + 1]
        between: Array = a + (stamp - before) / (after - before) * difference(b, a)
        return between


class MapSensors(NamedTuple):
    """What is registered to a map."""

    surfaces: Surfaces = Surfaces({})  # of the map
    names: Collection[str] = ("laser", "camera")
    executor: Executor = InlineExecutor()  # does the work, beside the loop


class Match(NamedTuple):
    """What a registration found."""

    stamp: float  # of the scan, or else of the frame [s]
    oTb: Array  # (3,) at that stamp
    from_estimate: Registration
    from_proposal: Registration | None  # from the pose on which the base's localisation insists
    rivals: list[Array] | None  # other poses mTb (3,) that agree as well; None: not looked for


class MapMatching:
    """Registers what a robot sees, from where it is estimated to be; one registration at a time."""

    def __init__(
        self,
        sensors: MapSensors,
        robot: RobotDescription,
        vision: Vision,
        newest_scan: Callable[[], LaserScan | None],
    ) -> None:
        self.surfaces, self._names, self._executor = sensors
        self._laser, self._vision, self._newest_scan = robot.laser, vision, newest_scan
        self._work: Future[Match] | None = None
        self._due = -inf
        self._frame: DepthFrame | None = None
        self.scan: LaserScan | None = None
        """The newest that was registered, or is being."""
        self.forget()

    def forget(self) -> None:
        """What is seen is judged anew, as the estimate was replaced."""
        self._judge = Judge()
        self.rivals: list[Array] | None = None
        """Other mTo (3,) that agree as well; None: not looked for yet."""

    def look(
        self, now: float, estimate: LocalisationFilter, odometry: Odometry, moved: Collection[str]
    ) -> Match | None:
        """Begin what is due at session time `now` [s]; returns what is done.

        No pose rests on `moved` furniture.
        """
        if not len(self.surfaces):
            return None
        frame = scan = None
        if "camera" in self._names and now >= self._due - _FRAME_LEAD:
            frame = self._vision.newest(self._due - _FRAME_AGE)
        if self._work is None and now >= self._due:
            if "laser" in self._names and (scan := self._newest_scan()) is self.scan:
                scan = None
            if frame is self._frame or (frame and now - frame.stamp > _MAX_AGE):
                frame = None
            waits = "laser" in self._names and now < self._due + _SCAN_WAIT
            if (newest := scan or (None if waits else frame)) is not None:
                self._due = now + _INTERVAL
                self.scan, self._frame = scan or self.scan, frame or self._frame
                self._begin(scan, frame, newest.stamp, odometry, estimate, moved)
        if self._work is None or not self._work.done():
            return None
        found, self._work = self._work.result(), None
        back = inverse(found.oTb)
        self.rivals = found.rivals and [compose(one, back) for one in found.rivals]
        return found

    def _begin(
        self,
        scan: LaserScan | None,
        frame: DepthFrame | None,
        stamp: float,
        odometry: Odometry,
        estimate: LocalisationFilter,
        moved: Collection[str],
    ) -> None:
        oTb = odometry.at(stamp)
        prior, proposal = (estimate.pose(oTb), estimate.covariance(oTb)), estimate.proposal(oTb)
        known = self.rivals and [compose(one, oTb) for one in self.rivals]
        surfaces, laser, judge = self.surfaces, self._laser, self._judge

        def work() -> Match:
            clouds = []
            if scan is not None and laser is not None:
                clouds.append(scan_cloud(scan.ranges, scan.points, laser))
            if frame is not None:
                bTc = in_space(oTb).inverse() * frame.oTc
                clouds.append(depth_cloud(frame.depth, frame.intrinsics, bTc))
            found = register(surfaces, clouds, *prior, moved=moved, judge=judge)
            proposed = proposal and register(surfaces, clouds, *proposal, moved=moved)
            looks = known != [] and found.consistent and found.support > 0
            others = rivals(surfaces, clouds, found, known) if looks else known
            return Match(stamp, oTb, found, proposed, others)

        self._work = self._executor.submit(work)

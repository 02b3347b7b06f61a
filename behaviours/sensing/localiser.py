"""Where the map is in odometry (REP 105): at one with it, or as is estimated."""

from abc import ABC, abstractmethod
from dataclasses import replace
from math import degrees, hypot, inf, sqrt
from typing import cast

import numpy as np
from pinocchio import SE3

from behaviours.sensing.agreement import Agreement
from behaviours.sensing.map_matching import MapMatching, Match, Odometry
from behaviours.sensing.moved_furniture import Furniture
from config.planar import compose, difference, in_space, on_floor
from config.poses import MapFromOdometry, MapPose, OdometryFromMap, OdometryPose
from controller import Array, BaseGoal, MotionGoal, PoseGoal
from hw import LaserScan, RobotState
from perception.registration import LocalisationFilter, Registration, smoothed

_MOVED = 0.002  # a base that has driven farther, or turned by more, in a second moves [m, rad]
_ROUNDING = 1e-9  # of a pose that is moved to odometry and back [m]


class Localiser(ABC):
    """Tells where the map m is in odometry o, in which everything moves smoothly.

    In a tick `read` moves the map, then `look` corrects the estimate, then behaviours run. Where
    `look` replaces the estimate the map jumps in the next tick, in which `Context.now` says so: no
    behaviour meets a map that has jumped unawares. Only these two write the attributes.
    """

    def __init__(self) -> None:
        self.mTo: MapFromOdometry | None = None  # odometry on the map; None: they are one
        self.oTm: OdometryFromMap | None = None  # its inverse
        self.mTb = SE3.Identity()  # the base on the map, as read this tick
        self.estimate: tuple[Array, Array] | None = None
        """The newest of mTb, x, y [m] and heading [rad] (3,), with its covariance (3, 3), which
        `mTb` smoothly follows. None where that is exact."""
        self.relocalised = ""  # what happened if this tick replaced the estimate; else empty
        self.warning = ""  # what is wrong with the map, or with who localises the base, or `rival`
        self.doubt = ""  # why it is not certain where the base is; empty while it is
        self.rival = ""  # where else laser and camera agree with the map as well; empty if nowhere
        self.agreement = Agreement()  # of the map with what is seen
        self.furniture = Furniture()  # where it was moved from its place on the map
        self.confirmed = -inf
        """Stamp of the newest measurement that the estimate explains [s]; -inf until points lie on
        the map, as a pose with which the estimate begins explains itself."""
        self.scan: LaserScan | None = None  # the newest that was registered, or is being
        self.registration: Registration | None = None  # the newest
        self.registrations = 0  # how many the estimate has taken
        self.largest = 0.0, 0.0  # correction by one of them: of position [m], and heading [rad]
        self._goal: MotionGoal[MapPose] | None = None  # the last on the map

    @abstractmethod
    def read(self, state: RobotState) -> None:
        """Take a reading: odometry, and the localised pose if there is a new one."""

    @abstractmethod
    def look(self) -> None:
        """Take what was registered to the map, and begin to register what is new."""

    @property
    def uncertainty(self) -> float:
        """Two standard deviations of where the base is on the map, the way it is larger [m]."""
        if self.estimate is None:
            return 0.0
        return 2.0 * sqrt(float(np.linalg.eigvalsh(self.estimate[1][:2, :2])[1]))

    @property
    def pending(self) -> float:
        """How far the newest estimate is from where the base is taken to be [m]."""
        return 0.0 if self.estimate is None else _between(self.estimate[0], on_floor(self.mTb))[0]

    def oTm_on(self, piece: str) -> OdometryFromMap | None:
        """The map in odometry, for what stands on a piece of furniture; None: they are the same.

        Where the piece was moved from its place on the map, so is what stands on it.
        """
        motion = self.furniture.motion(piece)
        return self.oTm if motion is None or self.oTm is None else self.oTm * motion

    def on_map(self, goal: MotionGoal[OdometryPose] | None) -> MotionGoal[MapPose] | None:
        """A goal in odometry on the map, with the pose that it had before but for rounding."""
        if goal is None or self.mTo is None:
            self._goal = cast("MotionGoal[MapPose] | None", goal)
        else:
            self._goal = _steady(goal.on_map(self.mTo), self._goal)
        return self._goal


class ExactLocaliser(Localiser):
    """Of a robot that tells no localised pose: odometry is the map."""

    def read(self, state: RobotState) -> None:
        """The base is where the robot has it."""
        self.mTb = state.oTb

    def look(self) -> None:
        """Nothing is registered."""


class EstimatedLocaliser(Localiser):
    """Of a robot that tells a localised pose: fuses that with odometry, scans and images.

    Args:
        state: the first reading with such a pose.
        matching: of scans and images to the map.
    """

    estimate: tuple[Array, Array]

    def __init__(self, state: RobotState, matching: MapMatching) -> None:
        super().__init__()
        localised, oTb = state.localised, on_floor(state.oTb)
        assert localised is not None
        self._stamp, self._localised, self._matching = state.stamp, localised, matching
        self._odometry = Odometry(state.stamp, oTb)
        mTb, stamp = on_floor(localised.mTb), localised.stamp
        self._filter = LocalisationFilter(mTb, localised.covariance, stamp, oTb)
        self._has_moved = False
        self._smoothed = self._filter.mTo  # (3,) what `mTo` is: on its way to that of the filter
        self._tell(state)

    def read(self, state: RobotState) -> None:
        """A pose that is new corrects the estimate; once the base moves, `mTb` follows smoothly."""
        self.relocalised = ""
        passed, self._stamp = state.stamp - self._stamp, state.stamp
        oTb, localised = on_floor(state.oTb), state.localised
        self._odometry.note(state.stamp, oTb)
        self._filter.travelled(oTb)
        if localised is None:
            self._filter.unlocalised()
        elif localised is not self._localised:
            self._localised, stamp = localised, localised.stamp
            measured = on_floor(localised.mTb), localised.covariance, stamp
            update = self._filter.localised(*measured, self._odometry.at(stamp))
            if update.accepted and self.confirmed > -inf:
                self.confirmed = max(self.confirmed, stamp)
        if not self._has_moved:
            self._smoothed = self._filter.mTo
            self._has_moved = max(_between(oTb, self._odometry.oldest)) > _MOVED
        elif passed > 0.0:
            self._smoothed = smoothed(self._smoothed, self._filter.mTo, oTb, passed)
        self._tell(state)

    def look(self) -> None:
        """A registration corrects the estimate, or shows that the base is elsewhere."""
        if self._filter.carried(oTb := self._odometry.newest):
            self._replaced(self.estimate[0], oTb, ": nothing in sight speaks against it")
        moved = self.furniture.names
        found = self._matching.look(self._stamp, self._filter, self._odometry, moved)
        self.scan = self._matching.scan
        if found is not None:
            self._take(found)
        if found is not None or self.relocalised:
            self._judge()

    def _tell(self, state: RobotState) -> None:
        self.mTo = in_space(self._smoothed)
        self.oTm = self.mTo.inverse()
        self.mTb = self.mTo * state.oTb
        self._judge()

    def _judge(self) -> None:
        """Say what is known of the estimate."""
        oTb, fault, source = self._odometry.newest, self.agreement.fault, self._localised.source
        mTb = self._filter.pose(oTb)
        self.estimate = mTb, self._filter.covariance(oTb)
        self.doubt = self.rival = ""
        if doubt := self._filter.doubt:
            off, turn = doubt
            self.doubt = f"{source} has it {off:.2f} m and {degrees(turn):.0f}° away"
        if others := self._matching.rivals:
            off = min(_between(compose(one, oTb), mTb)[0] for one in others)
            self.rival = f"it may as well be {off:.1f} m away: what is in sight is the same there"
        unseen = f"{source} has the base where laser and camera do not see it"
        unsure = unseen if self._filter.is_contradicted else self.rival
        self.warning = unsure if fault is None else fault.text

    def _take(self, found: Match) -> None:
        """Take a registration from the estimate, and one from what the base insists on."""
        oTb, result, proposed = found.oTb, found.from_estimate, found.from_proposal
        before = self._filter.pose(oTb)
        if proposed is not None and self._filter.relocalised(proposed, result, oTb):
            self._replaced(before, oTb)
            self.confirmed, self.registration = found.stamp, proposed
            self.furniture.note(proposed)
            return
        update = self._filter.registered(result, oTb)
        if update.accepted:
            off, turn = _between(before, self._filter.pose(oTb))
            self.registrations += 1
            self.confirmed = max(self.confirmed, found.stamp)
            self.largest = max(self.largest[0], off), max(self.largest[1], turn)
        self.agreement.note(found.stamp, update.accepted, result, self._matching.surfaces)
        self.registration = result
        self.furniture.note(result)
        self.furniture.suspect(update.moved)

    def _replaced(self, before: Array, oTb: Array, how: str = "") -> None:
        """What the base says has replaced the estimate: the map jumps there."""
        self._smoothed, self.confirmed = self._filter.mTo, -inf
        self.furniture.forget()
        self._matching.forget()
        self.agreement = Agreement()
        off, turn = _between(before, self._filter.pose(oTb))
        self.relocalised = f"the base was relocalised by {off:.2f} m and {degrees(turn):.0f}°{how}"


def _steady(goal: MotionGoal[MapPose], last: MotionGoal[MapPose] | None) -> MotionGoal[MapPose]:
    """A goal with exactly the pose of the last one, if that differs by rounding only."""
    if isinstance(goal, PoseGoal | BaseGoal) and isinstance(last, type(goal)):
        is_same = goal.target.isApprox(last.target, _ROUNDING)
        return replace(goal, target=last.target) if is_same else goal
    return goal


def _between(a: Array, b: Array) -> tuple[float, float]:
    """Distance [m] and angle [rad] between two poses on the floor (3,)."""
    x, y, turn = difference(b, a).tolist()
    return hypot(x, y), abs(turn)

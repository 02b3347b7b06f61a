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
from perception.registration import Localisation as Filter
from perception.registration import Registration, smoothed

_MOVED = 0.002  # motion of the base that is one [m, rad]
_ROUNDING = 1e-9  # of a pose that is moved to odometry and back [m]


class Localiser(ABC):
    """Tells where the map m is in odometry o, in which everything moves.

    Odometry is smooth, and never jumps; the map may be corrected in it.
    """

    def __init__(self) -> None:
        self.mTo: MapFromOdometry | None = None  # odometry on the map; None: they are one
        self.oTm: OdometryFromMap | None = None  # its inverse
        self.mTb = SE3.Identity()  # the base on the map, as read this tick
        self.estimate: tuple[Array, Array] | None = None
        """The newest of mTb, x, y [m] and heading [rad] (3,), with its covariance (3, 3), which
        `mTb` smoothly follows. None where that is exact."""
        self.relocalised = ""  # what happened if this tick replaced the estimate; else empty
        self.doubt = ""  # why it is not certain where the base is; empty while it is
        self.rival = ""  # where else laser and camera agree with the map as well; empty if nowhere
        self.wrong = ""  # what is wrong with the map, or with who tells the base where it is
        self.agreement = Agreement()  # of the map with what is seen
        self.furniture = Furniture()  # where it was moved from its place on the map
        self.confirmed = -inf
        """Stamp of the newest measurement that the estimate explains [s]; -inf until points lie on
        the map, as what the base tells first explains itself."""
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
            self._goal = _same(goal.on_map(self.mTo), self._goal)
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
        told, oTb = state.localised, on_floor(state.oTb)
        assert told is not None
        self._stamp, self._told, self._matching = state.stamp, told, matching
        self._odometry = Odometry(state.stamp, oTb)
        self._filter = Filter(on_floor(told.mTb), told.covariance, told.stamp, oTb)
        self._mTo, self._has_moved = self._filter.mTo, False
        self._tell(state)

    def read(self, state: RobotState) -> None:
        """A pose that is new corrects the estimate; once the base moves, `mTb` follows smoothly."""
        self.relocalised = ""
        passed, self._stamp = state.stamp - self._stamp, state.stamp
        oTb, told = on_floor(state.oTb), state.localised
        self._odometry.note(state.stamp, oTb)
        self._filter.travelled(oTb)
        if told is None:
            self._filter.unlocalised()
        elif told is not self._told:
            self._told, then = told, self._odometry.at(told.stamp)
            given = on_floor(told.mTb), told.covariance, told.stamp
            if self._filter.localised(*given, then).accepted and self.confirmed > -inf:
                self.confirmed = told.stamp
        if not self._has_moved:
            self._mTo = self._filter.mTo
            self._has_moved = bool(np.linalg.norm(oTb - self._odometry.oldest) > _MOVED)
        elif passed > 0.0:
            self._mTo = smoothed(self._mTo, self._filter.mTo, oTb, passed)
        self._tell(state)

    def look(self) -> None:
        """A registration corrects the estimate, or shows that the base is elsewhere."""
        if self._filter.carried(oTb := self._odometry.newest):
            self._replaced(self.estimate[0], oTb, ": nothing in sight speaks against it")
            self.confirmed = -inf
        moved = self.furniture.names
        found = self._matching.look(self._stamp, self._filter, self._odometry, moved)
        self.scan = self._matching.scan
        if found is not None:
            self._take(found)
        if found is not None or self.relocalised:
            self._judge()

    def _tell(self, state: RobotState) -> None:
        self.mTo = in_space(self._mTo)
        self.oTm = self.mTo.inverse()
        self.mTb = self.mTo * state.oTb
        self._judge()

    def _judge(self) -> None:
        """Say what is known of the estimate."""
        oTb, known, source = self._odometry.newest, self._filter, self._told.source
        mTb = known.pose(oTb)
        self.estimate = mTb, known.covariance(oTb)
        self.doubt = self.rival = ""
        if (away := known.doubt) is not None:
            off, turn = away
            self.doubt = f"{source} has it {off:.2f} m and {degrees(turn):.0f}° away"
        if others := self._matching.rivals:
            off = min(_between(compose(one, oTb), mTb)[0] for one in others)
            self.rival = f"it may as well be {off:.1f} m away: what is in sight is the same there"
        self.wrong = self.rival
        if self.agreement.fault is not None:
            self.wrong = self.agreement.fault.text
        elif known.is_contradicted:
            self.wrong = f"{source} has the base where laser and camera do not see it"

    def _take(self, found: Match) -> None:
        """Take a registration from the estimate, and one from what the base insists on."""
        oTb, here, there, _ = found
        before = self._filter.pose(oTb)
        if there is not None and self._filter.relocalised(there, here, oTb):
            self._replaced(before, oTb)
            self.registration = there
            self.furniture.note(there)
            return
        update = self._filter.registered(here, oTb)
        if update.accepted:
            off, turn = _between(before, self._filter.pose(oTb))
            self.registrations, self.confirmed = self.registrations + 1, self._stamp
            self.largest = max(self.largest[0], off), max(self.largest[1], turn)
        self.agreement.note(self._stamp, update.accepted, here, self._matching.surfaces)
        self.registration = here
        self.furniture.note(here)
        self.furniture.suspect(update.moved)

    def _replaced(self, before: Array, oTb: Array, how: str = "") -> None:
        """What the base says has replaced the estimate: the map jumps there."""
        self._mTo = self._filter.mTo
        self.furniture.forget()
        self._matching.forget()
        self.agreement = Agreement()
        off, turn = _between(before, self._filter.pose(oTb))
        self.relocalised = f"the base was relocalised by {off:.2f} m and {degrees(turn):.0f}°{how}"


def _same(goal: MotionGoal[MapPose], before: MotionGoal[MapPose] | None) -> MotionGoal[MapPose]:
    """A goal with exactly the pose that it had before, if that differs by rounding only."""
    match goal, before:
        case PoseGoal(), PoseGoal() if goal.target.isApprox(before.target, _ROUNDING):
            return replace(goal, target=before.target)
        case BaseGoal(), BaseGoal() if goal.target.isApprox(before.target, _ROUNDING):
            return replace(goal, target=before.target)
    return goal


def _between(a: Array, b: Array) -> tuple[float, float]:
    """Distance [m] and angle [rad] between two poses on the floor (3,)."""
    x, y, turn = difference(b, a).tolist()
    return hypot(x, y), abs(turn)

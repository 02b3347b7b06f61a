"""Decoding of the readings of the base: poses, velocity, mode, localisation, battery, laser.

Positions are in mm and angles in degrees on the wire, in the frame of the robot's map. Layouts of
`updateNumbers`, `updateStrings`, `batteryInfo` and `getModeInfo`: verified with a reference server.
Of `getLocState`: read in the source. Of `DataStore_*`: reported by a driver that ran
on an LD-60; the meaning of their first byte is unknown.
"""

from collections.abc import Callable, Iterator
from enum import IntEnum
from math import radians, tau
from typing import NamedTuple, TypeAlias

import numpy as np
from pinocchio import SE3

from config.planar import ORIGIN, Pose2D, in_space
from drivers.omron.handshake import Catalogue
from drivers.omron.laser import LASER, LASER_INTERVAL, Echoes, read_points
from drivers.omron.packet import Fields, LayoutError, Packet, number_field, parse_number
from drivers.omron.site import REST, Ratios, Velocity

POSE, ENCODERS = (
    tuple(f"DataStore_{pose}PoseInterpolated_{axis}" for axis in ("X", "Y", "Th"))
    for pose in ("Robot", "Encoder")
)
"""Fine poses on the map (`updateNumbers` has whole millimetres and degrees), and odometry."""
OLDEST_POSE = 0.25  # up to this age a pose is extrapolated; then it is stale [s]
Taker: TypeAlias = Callable[[Fields, float], None]
_INTERVAL = 0.03  # of poses [s]; real bases are said to send at most 37 a second
_TOGETHER = 0.02  # the three values of one pose arrive within this time [s]
_ACCEPT_SKEWED = 0.1  # without a pose so long, values that came apart count [s]


class Localisation(IntEnum):
    """State of localisation."""

    GOOD = 0
    IDLE = 1
    LOST = 2
    INITIALISING = 3


class Pose(NamedTuple):
    """On the map of the robot, or in odometry."""

    place: Pose2D
    at: float  # time of arrival, of `stopwatch` [s]


def moved(pose: Pose, velocity: Velocity, at: float) -> Pose:
    """The pose at another time of `stopwatch` [s], at a constant velocity."""
    seconds = at - pose.at
    turn = velocity.w * seconds
    way = velocity.v * seconds * float(np.sinc(turn / tau))
    return Pose(pose.place.moved(way, turn=turn), at)


def extrapolate(pose: Pose, velocity: Velocity, seconds: float) -> SE3:
    """Pose of the base a time later [s], at a constant velocity."""
    return in_space(moved(pose, velocity, pose.at + seconds).place)


def drive_payload(ratios: Ratios) -> bytes:
    """The arguments of `ratioDrive`."""
    return b"".join(number_field(value) for value in (*ratios, 100.0, 0.0))


class PoseAssembly:
    """Assembles a pose from three values, each in a packet, that come within `_TOGETHER`."""

    def __init__(self, names: tuple[str, ...]) -> None:
        self._names = names
        self._values: dict[str, tuple[float, float]] = {}
        self._last = -1.0

    def take(self, name: str, value: float, at: float) -> Pose | None:
        """Add a value that arrived at a time [s]; the pose that is complete with it."""
        if not self._values and self._last < 0.0:
            self._last = at
        self._values[name] = (value, at)
        if at - self._last <= _ACCEPT_SKEWED:
            self._values = {
                key: kept for key, kept in self._values.items() if at - kept[1] <= _TOGETHER
            }
        if len(self._values) < len(self._names):
            return None
        (x, at_x), (y, at_y), (theta, at_theta) = (self._values[key] for key in self._names)
        self._values, self._last = {}, at
        arrived = min(at_x, at_y, at_theta)
        return Pose(Pose2D(x / 1000.0, y / 1000.0, radians(theta)), arrived)


class Telemetry:
    """The newest readings of one connection; scans arrive older than poses by `lead` [s]."""

    def __init__(
        self, catalogue: Catalogue, score_scale: float | None = None, lead: float = 0.0
    ) -> None:
        self.echoes: Echoes | None = None  # newest scan of the laser
        self._lead = lead
        self.pose: Pose | None = None  # on the map; fine where the robot offers it
        self.coarse: Pose | None = None  # of `updateNumbers`
        self.velocity = REST
        self.has_encoders = catalogue.has(*ENCODERS)  # else odometry is integrated
        self._encoders: Pose | None = None
        self._integral: Pose | None = None
        self.battery: float | None = None  # charge, 0 to 1; None: it sends a voltage
        self.status = self.mode = ""
        self.locked = False  # whether the mode is locked
        self.localisation: Localisation | None = None
        self.score: float | None = None  # 0 to 1; None where its scale is unknown
        self.damaged = 0  # number of replies with an unexpected layout
        self._has_charge = False
        self._score_scale = score_scale
        self._is_fine = catalogue.has(*POSE)
        takers: dict[str, Taker] = {
            "updateNumbers": self._numbers,
            "updateStrings": self._strings,
            "batteryInfo": self._battery_info,
            "getModeInfo": self._mode_info,
            "getLocState": self._loc_state,
            LASER: self._laser,
        }
        self._takers: dict[int, Taker] = {}
        takers |= self._axes(POSE, "pose") | self._axes(ENCODERS, "_encoders")
        for name, take in takers.items():
            if (number := catalogue.numbers.get(name)) is not None:
                self._takers[number] = take

    def requests(self, catalogue: Catalogue) -> Iterator[bytes]:
        """The frames that subscribe to all readings."""
        intervals: dict[str, float | None] = {
            **dict.fromkeys(POSE if self._is_fine else (), _INTERVAL),
            **dict.fromkeys(ENCODERS if self.has_encoders else (), _INTERVAL),
            "updateNumbers": 0.05 if self._is_fine else _INTERVAL,
            "updateStrings": None,
            "getModeInfo": 0.2,
            "getLocState": 0.25,
            LASER: LASER_INTERVAL,
        }
        if catalogue.has("batteryInfo"):
            yield catalogue.command("batteryInfo")
        for name, period in intervals.items():
            if catalogue.has(name):
                yield catalogue.request(name, period)

    def take(self, packet: Packet, at: float) -> None:
        """Process a packet that arrived at a time of `stopwatch` [s]; unknown ones are ignored."""
        taker = self._takers.get(packet.command)
        if taker is None:
            return
        try:
            taker(Fields(packet.payload), at)
        except LayoutError:
            self.damaged += 1

    @property
    def odometry(self) -> Pose | None:
        """In a frame of its own, smooth while connected."""
        return self._encoders if self.has_encoders else self._integral

    @property
    def placed_at(self) -> float | None:
        """When the older one of pose and odometry arrived, of `stopwatch` [s]."""
        if self.pose is None or self.odometry is None:
            return None
        return min(self.pose.at, self.odometry.at)

    @property
    def is_complete(self) -> bool:
        """Whether there are poses, odometry and a velocity."""
        return self.placed_at is not None and self.coarse is not None

    def _numbers(self, fields: Fields, at: float) -> None:
        battery, x, y, theta, v, w, _, _ = fields.integers("hiihhhhb")
        self.coarse = Pose(Pose2D(x / 1000.0, y / 1000.0, radians(theta)), at)
        before, self.velocity = self.velocity, Velocity(v / 1000.0, radians(w))
        mean = Velocity(*np.mean((before, self.velocity), axis=0).tolist())
        self._integral = moved(self._integral or Pose(ORIGIN, at), mean, at)
        if self._has_charge:
            self.battery = max(0.0, min(1.0, battery / 1000.0))
        if not self._is_fine:
            self.pose = self.coarse

    def _axes(self, names: tuple[str, ...], pose_of: str) -> dict[str, Taker]:
        """What takes each of the three values of a pose."""
        assembly = PoseAssembly(names)

        def taker(name: str) -> Taker:
            def take(fields: Fields, at: float) -> None:
                if (pose := assembly.take(name, _data_store_value(fields), at)) is not None:
                    setattr(self, pose_of, pose)

            return take

        return {name: taker(name) for name in names}

    def _strings(self, fields: Fields, at: float) -> None:
        self.status, self.mode = fields.text(), fields.text()

    def _battery_info(self, fields: Fields, at: float) -> None:
        fields.number()
        fields.number()
        self._has_charge = fields.integer("B") == 1

    def _mode_info(self, fields: Fields, at: float) -> None:
        mode, locked = fields.text(), fields.integer("B")
        self.mode, self.locked = mode, locked == 1

    def _loc_state(self, fields: Fields, at: float) -> None:
        state, score = fields.integers("BH")
        if state not in list(Localisation):
            raise LayoutError(f"no state of localisation: {state}")
        self.localisation = Localisation(state)
        if self._score_scale is None and score > 100:
            self._score_scale = 1000.0
        self.score = None if self._score_scale is None else min(1.0, score / self._score_scale)

    def _laser(self, fields: Fields, at: float) -> None:
        """The base has put its points on the map with its pose at their capture."""
        points = read_points(fields)
        if self.pose is not None:
            then = extrapolate(self.pose, self.velocity, at - self.pose.at - self._lead)
            points = (points - then.translation[:2]) @ then.rotation[:2, :2]
            self.echoes = Echoes(points, at - self._lead)


def _data_store_value(fields: Fields) -> float:
    """A value of the data store: any byte that cannot be part of a number, then one as text."""
    kind, text = fields.raw(1), fields.text()
    if kind in b"0123456789+-.":
        raise LayoutError(f"the first byte of a value is {kind!r}")
    return parse_number(text.strip(" "))

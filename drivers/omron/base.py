"""The LD-60 as a `Base`: readings, commands and recoveries, none of which waits for the network."""

import threading
from collections.abc import Callable, Iterator
from math import radians

import numpy as np
from pinocchio import SE3

from config.poses import OdometryPose
from drivers.omron.arcl import Arcl, Motors
from drivers.omron.base_faults import connection_lost, why_lost
from drivers.omron.base_options import OmronOptions
from drivers.omron.commander import ACCELERATIONS, Accelerations
from drivers.omron.connection import first_readings, named_errors, open_connection
from drivers.omron.examination import examine
from drivers.omron.handshake import Catalogue
from drivers.omron.laser import Echoes
from drivers.omron.link import Link
from drivers.omron.site import REST, Site, Velocity, is_at_rest
from drivers.omron.telemetry import OLDEST_POSE, Pose, Telemetry, extrapolate
from drivers.omron.teleop_settings import TELEOP, Values, site_of
from hw import (
    RECOVERY_MEMORY,
    RECOVERY_PAUSES,
    Array,
    BaseState,
    Clock,
    Finding,
    HardwareError,
    LocalisedPose,
    stopwatch,
)
from robots import RobotDescription

_POLL = 0.01  # polling interval of recoveries [s]
_RECOVERY = 3.0  # timeout of each step of a recovery [s]
_READING = 3.0  # timeout of reading the configuration [s]
_PAUSES = (0.0, *RECOVERY_PAUSES)
_GOOD_SCORE, _LEAST_SCORE = 0.7, 0.1  # a lower score is less accurate in proportion [inferred]
_AGREE = 0.3  # encoders that differ more from the map while disconnected were reset [m]


class OmronBase:
    """An Omron LD-60, or another base with the same server.

    The world is that of its odometry, of encoders or else integrated velocity; it begins with
    the map where the base is localised first. Without a message for `OLDEST_POSE` the pose
    stands still, with a fault; its stamp goes on, so that a recovery gets its chance.
    """

    def __init__(
        self,
        settings: OmronOptions,
        clock: Clock,
        accelerations: Accelerations = ACCELERATIONS,
    ) -> None:
        self._settings, self._clock, self._accelerations = settings, clock, accelerations
        self._arcl: Arcl | None = None
        self._link: Link | None = None
        self._has_begun = False  # whether the world has: at the first localised pose
        self._localised: tuple[Pose, LocalisedPose] | None = None  # as it came, and as it is read
        self._recoveries, self._recovered_at = 0, -RECOVERY_MEMORY
        self._closing = threading.Event()
        self.catalogue = Catalogue()  # requests that the base offers to this account
        self.protocol = ""  # protocol version of the base; empty before it is connected

    @property
    def echoes(self) -> Echoes | None:
        """The newest scan of its laser; None before the first."""
        with self.link.lock:
            return self.link.telemetry.echoes

    @property
    def pose_age(self) -> float:
        """Time since the newest pose and odometry arrived [s]."""
        at = self.link.telemetry.placed_at
        assert at is not None  # `connect` waited for it
        return stopwatch() - at

    def connect(self) -> None:
        """Log in, and wait for the first readings; HardwareError: with cause and hint."""
        self._closing.clear()
        self._link, self._has_begun = None, False
        if self._settings.arcl is not None:
            self._arcl = Arcl(self._settings.address, self._settings.arcl)
            self._arcl.connect(self._settings.connect_patience)
        try:
            self._open(claim=False)
        except BaseException:
            if self._arcl is not None:
                self._arcl.close()
            raise

    def read(self) -> BaseState:
        """The reading of this moment."""
        link = self.link
        with link.lock:
            now, telemetry = stopwatch(), link.telemetry
            faults = (connection_lost(link.lost),) if link.lost else link.faults(now)
            odometry, velocity = telemetry.odometry, telemetry.velocity
            localised = self._newest_localised(link, now)
            if localised is not None and not self._has_begun:
                link.oTd, self._has_begun = begun(telemetry), True
            oTd, battery = link.oTd, telemetry.battery
        assert odometry is not None  # `connect` waited for it
        age = min(now - odometry.at, OLDEST_POSE) + self._settings.pose_delay
        measured = REST if link.lost else velocity
        return BaseState(
            stamp=self._clock.now(),
            oTb=oTd * extrapolate(odometry, velocity, age),
            twist=np.array([measured.v, 0.0, measured.w]),
            battery=battery,
            faults=faults,
            localised=localised,
        )

    def _newest_localised(self, link: Link, now: float) -> LocalisedPose | None:
        """The pose on the map that came last; None while it is lost. The caller holds the lock."""
        pose, settings = link.telemetry.pose, self._settings
        if pose is None or why_lost(link.telemetry, settings.least_score, link.score):
            return None
        if self._localised is None or self._localised[0] is not pose:
            localised = LocalisedPose(
                stamp=self._clock.now() - (now - pose.at) - settings.pose_delay,
                mTb=extrapolate(pose, REST, 0.0),
                covariance=_covariance(settings, link.score),
            )
            self._localised = pose, localised
        return self._localised[1]

    def send(self, twist: Array) -> Array:
        """Drive, in pulses inside a dead zone; returns the mean velocity, zero in a fault."""
        link = self.link
        wanted = Velocity(float(twist[0]), float(twist[2]))
        with link.lock:
            now, measured, site = stopwatch(), link.telemetry.velocity.v, self._settings.site
            if not np.isfinite(wanted).all():
                link.commander.stop()
                return np.zeros(3)
            if link.is_closing or link.faults(now):
                return np.zeros(3)
            applied = site.saturate(wanted, measured)
            link.commander.command(applied, now)
        return np.array([applied.v, 0.0, applied.w])

    def read_site(self) -> Site:
        """Full-scale values and dead zones of the base; missing ones are those of the settings."""
        return site_of(self.read_teleop(), self._settings.site)

    def read_teleop(self) -> Values:
        """The section "Teleop settings" of the base; HardwareError: ARCL does not tell it."""
        if self._arcl is None:
            raise HardwareError("only ARCL tells them, and there is no `arcl` in the file")
        return self._arcl.section(TELEOP, _READING)

    def site_text(self) -> str:
        """The values of `read_site` as YAML."""
        lines = [f"# As the base at {self._settings.address} tells; m/s, deg/s and %."]
        lines += [f"{key}: {round(value, 4)}" for key, value in self.read_site().values.items()]
        return "\n".join(lines) + "\n"

    def examine(self, robot: RobotDescription) -> Iterator[Finding]:
        """What is good and bad about it, while it is connected."""
        return examine(self, self._settings, float(robot.limits.base_twist[0]))

    def recover(self) -> None:
        """Clear all that a program can, after pauses that grow; raises HardwareError."""
        link = self.link
        if self._is_sound(link) or self._wait(lambda: self._is_sound(link), self._pause()):
            return
        if self._arcl is not None and self._arcl.state.lost:
            self._arcl.connect(self._settings.connect_patience)
        if link.lost or not self._wait(lambda: self.pose_age <= OLDEST_POSE, _RECOVERY):
            link.close()
            self._open(claim=True)
            link = self.link
        if self._arcl is not None and self._arcl.state.motors is not Motors.ENABLED:
            self._arcl.enable_motors()
        finding = link.monitor.finding
        if finding is not None and not finding.clearable:
            raise HardwareError(finding.text)
        if finding is not None or link.telemetry.locked or self._clearable_faults(link):
            self.stop()
            if not self._wait(lambda: is_at_rest(link.telemetry.velocity), _RECOVERY):
                raise HardwareError("the base still moves under somebody else's command")
            with link.lock:
                link.monitor.clear()
        if not self._wait(lambda: not self._clearable_faults(link), _RECOVERY):
            raise HardwareError(self._clearable_faults(link)[0])

    def stop(self) -> None:
        """Send the base's own `stop`, at once and until it is at rest."""
        if self._link is not None:
            with self._link.lock:
                self._link.commander.stop()
            self._link.wake()

    def close(self) -> None:
        """Stop, wait until the base is at rest (2 s at most), and log out."""
        self._closing.set()
        if self._link is not None:
            self._link.close()
        if self._arcl is not None:
            self._arcl.close()

    @property
    def link(self) -> Link:
        """The open connection; HardwareError: there is none."""
        if self._link is None:
            raise HardwareError(f"Omron base at {self._settings.address}: not connected")
        return self._link

    def _open(self, *, claim: bool) -> None:
        """Open a new connection; `claim`: stop a moving base."""
        settings = self._settings
        connection = open_connection(settings)
        try:
            with named_errors(settings):
                self.catalogue, self.protocol = connection.catalogue, connection.protocol
                telemetry = first_readings(connection, settings, claim=claim)
                limits, before = self._accelerations, self._link
                link = Link(connection, telemetry, settings, limits, self._arcl)
                link.oTd = (
                    begun(telemetry)
                    if before is None
                    else continued(before.oTd, before.telemetry, telemetry)
                )
                link.start()
                self._link = link
        except BaseException:
            connection.socket.close()
            raise

    def _pause(self) -> float:
        """Pause before a recovery; it grows with their number [s]."""
        is_new = stopwatch() - self._recovered_at > RECOVERY_MEMORY
        self._recoveries = 0 if is_new else min(self._recoveries + 1, len(_PAUSES) - 1)
        pause = _PAUSES[self._recoveries]
        self._recovered_at = stopwatch() + pause
        return pause

    def _is_sound(self, link: Link) -> bool:
        """Whether there is no fault; HardwareError: the base was closed meanwhile."""
        if self._closing.is_set():
            raise HardwareError(f"Omron base at {self._settings.address}: closed")
        with link.lock:
            return not link.lost and not link.faults(stopwatch())

    def _clearable_faults(self, link: Link) -> list[str]:
        """Texts of the faults that a recovery should have cleared."""
        with link.lock:
            return [fault.text for fault in link.faults(stopwatch()) if fault.clearable]

    @staticmethod
    def _wait(done: Callable[[], bool], patience: float) -> bool:
        """Whether a condition becomes true within a time [s]."""
        until, pause = stopwatch() + patience, threading.Event()
        while not done():
            if stopwatch() > until:
                return False
            pause.wait(_POLL)
        return True


def begun(telemetry: Telemetry) -> SE3:
    """Odometry in a world that begins now, as the map."""
    return _pose(telemetry.pose) * _pose(telemetry.odometry).inverse()


def continued(oTd: OdometryPose, before: Telemetry, telemetry: Telemetry) -> SE3:
    """Odometry of a new connection in the last one's world, by encoders, or else by the map."""
    oTb, oTb_now = _pose(before.odometry), _pose(telemetry.odometry)
    way = _pose(before.pose).actInv(_pose(telemetry.pose))
    if before.has_encoders and telemetry.has_encoders:
        counted = oTb.actInv(oTb_now)
        if np.linalg.norm(counted.translation - way.translation) < _AGREE:
            return oTd
    return oTd * oTb * way * oTb_now.inverse()


def _covariance(settings: OmronOptions, score: float | None) -> Array:
    """(3, 3) of the localised pose: x, y and yaw on the map [m², m rad, rad²]."""
    worse = 1.0 if score is None else max(1.0, _GOOD_SCORE / max(score, _LEAST_SCORE))
    site = settings.localisation
    sigma = worse * np.array([site.sigma, site.sigma, radians(site.sigma_deg)])
    return np.diag(sigma**2)


def _pose(pose: Pose | None) -> SE3:
    assert pose is not None  # `connect` waited for it
    return extrapolate(pose, REST, 0.0)

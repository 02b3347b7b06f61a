"""The LD-60 as a `Base`: readings, commands and recoveries, none of which waits for the network."""

from __future__ import annotations

import threading
from collections.abc import Callable
from math import atan2, degrees
from struct import pack

import numpy as np
from pinocchio import SE3

from hw.clock import Clock, stopwatch
from hw.omron.arcl import Arcl
from hw.omron.arcl_text import Motors
from hw.omron.commander import is_at_rest
from hw.omron.config import SECTIONS, TELEOP, Values, site_of
from hw.omron.connection import open_connection, said_of
from hw.omron.faults import connection_lost
from hw.omron.first_readings import first_readings
from hw.omron.handshake import Catalogue
from hw.omron.link import Link
from hw.omron.settings import OmronSettings
from hw.omron.site import REST, Site, Velocity, is_finite
from hw.omron.telemetry import carried_on
from hw.robot import HardwareError
from hw.state import Array, BaseState

_LOOK = 0.01  # how often something that is waited for is looked at [s]
_RECOVERY = 3.0  # for each step of a recovery [s]
_PAUSES = (0.0, 0.5, 2.0, 8.0)  # before a recovery, the longer the more came before [s]
_FORGOTTEN = 30.0  # a recovery so long after the last is the first again [s]


class OmronBase:
    """An Omron LD-60, or another base with the same server.

    The world is the map of the base. The pose between two messages is carried on with the measured
    velocity, so that a reading is of the moment at which it is asked for. Without a message for
    `oldest_pose` the pose stands still and the reading has a fault; its stamp goes on, so that a
    recovery gets its chance.

    Args:
        settings: where the base is, and how it is set up.
        clock: session time, for the stamps.
    """

    def __init__(self, settings: OmronSettings, clock: Clock) -> None:
        self._settings, self._clock = settings, clock
        self._arcl: Arcl | None = None
        self._link: Link | None = None
        self._catalogue = Catalogue()
        self._recoveries, self._recovered_at = 0, -_FORGOTTEN
        self._closing = threading.Event()
        self.protocol = ""
        """Version that the base announces; empty before it is connected."""

    @property
    def catalogue(self) -> Catalogue:
        """What the base offers to this account."""
        return self._catalogue

    @property
    def arcl(self) -> Arcl | None:
        """The text interface: dock and goals."""
        return self._arcl

    @property
    def guardian_pid(self) -> int:
        """Process that stops the base when this one is killed or suspended."""
        return self._connected.guardian_pid

    @property
    def localisation_score(self) -> float | None:
        """0 to 1; None where it is not told, or its scale is not known."""
        return self._connected.score

    @property
    def pose_age(self) -> float:
        """How long ago the newest pose arrived [s]."""
        pose = self._connected.telemetry.pose
        assert pose is not None  # `connect` waited for it
        return stopwatch() - pose.at

    def connect(self) -> None:
        """Log in, and wait for the first readings.

        Raises:
            HardwareError: wrong address, account, protocol version or rights; or the base moves or
                is in a mode that does not let go of it: somebody else commands it.
        """
        self._closing.clear()
        if self._settings.arcl is not None:
            self._arcl = Arcl(self._settings.host, self._settings.arcl)
            self._arcl.connect(self._settings.connect_patience)
        try:
            self._open(claim=False)
        except BaseException:
            if self._arcl is not None:
                self._arcl.close()
            raise

    def read(self) -> BaseState:
        """The reading of this moment.

        Raises:
            HardwareError: it was never connected.
        """
        link = self._connected
        with link.lock:
            now, telemetry = stopwatch(), link.telemetry
            faults = (connection_lost(link.lost),) if link.lost else link.faults(now)
            pose, velocity = telemetry.pose, telemetry.velocity
            battery = telemetry.battery
        assert pose is not None  # `connect` waited for it
        age = min(now - pose.at, self._settings.oldest_pose) + self._settings.pose_delay
        told = REST if link.lost else velocity
        return BaseState(
            stamp=self._clock.now(),
            wTb=carried_on(pose, velocity, age),
            twist=np.array([told.v, 0.0, told.w]),
            battery=battery,
            faults=faults,
        )

    def send(self, twist: Array) -> Array:
        """Drive; returns what the base can make of it in the mean, nothing while there is a fault.

        A velocity inside a dead zone is driven in pulses of the slowest one outside.

        Raises:
            HardwareError: it was never connected.
        """
        link = self._connected
        wanted = Velocity(float(twist[0]), float(twist[2]))
        with link.lock:
            now, measured, site = stopwatch(), link.telemetry.velocity.v, self._settings.site
            if not is_finite(wanted):
                link.commander.stop()
                return np.zeros(3)
            if link.is_closing or link.faults(now):
                return np.zeros(3)
            applied = site.saturate(wanted, measured)
            link.commander.command(applied, now)
        return np.array([applied.v, 0.0, applied.w])

    def localise(self, wTb: SE3) -> None:
        """Tell the base where it is on its map; a reading tells when it believes it.

        Raises:
            HardwareError: it was never connected, or does not offer this.
        """
        x, y, _ = (round(1000.0 * one) for one in wTb.translation)
        heading = round(degrees(atan2(wTb.rotation[1, 0], wTb.rotation[0, 0])))
        self._say("localizeToPose", pack("<iii", x, y, heading))

    def read_site(self, patience: float = 3.0) -> Site:
        """The values of "Teleop settings" that the base itself keeps; what it lacks, as told.

        Raises:
            HardwareError: as for `read_teleop`.
        """
        return site_of(self.read_teleop(patience), self._settings.site)

    def read_teleop(self, patience: float = 3.0) -> Values:
        """The section "Teleop settings" of the base, by its own names and in its own units.

        Bases of version 6MTX do not offer it here; the text interface is asked then.

        Raises:
            HardwareError: it does not offer its configuration to this account, or does not answer.
        """
        sections = self._connected.telemetry.sections
        if self._catalogue.has(SECTIONS):
            self._say(SECTIONS, b"\x09")
            if self._wait(lambda: TELEOP in sections, patience):
                return sections[TELEOP]
        elif self._arcl is None:
            raise HardwareError(f"the base does not offer {SECTIONS} to this account")
        if self._arcl is not None:
            return self._arcl.section(TELEOP, patience)
        raise HardwareError(f"the base does not tell its section {TELEOP!r}")

    def recover(self) -> None:
        """Connect again, switch the motors on, take the base back from whoever had it.

        Where there is nothing to do it returns at once. Recoveries that follow each other begin
        after pauses that grow, unless all is well by then.

        Raises:
            HardwareError: that does not help; the text says what does.
        """
        link = self._connected
        if self._is_sound(link) or self._wait(lambda: self._is_sound(link), self._pause()):
            return
        if self._arcl is not None and self._arcl.state.lost:
            self._arcl.connect(self._settings.connect_patience)
        if link.lost or not self._wait(lambda: not self._is_stale(link), _RECOVERY):
            link.close()
            self._open(claim=True)
            link = self._connected
        if self._arcl is not None and self._arcl.state.motors is not Motors.ENABLED:
            self._arcl.enable_motors()
        finding = link.obedience.finding
        if finding is not None and not finding.clearable:
            raise HardwareError(finding.text)
        if finding is not None or link.telemetry.locked or self._clearable_faults(link):
            self.stop()
            if not self._wait(lambda: is_at_rest(link.telemetry.velocity), _RECOVERY):
                raise HardwareError("the base still moves under somebody else's command")
            with link.lock:
                link.obedience.clear()
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
    def _connected(self) -> Link:
        if self._link is None:
            raise HardwareError(f"Omron base at {self._settings.host}: not connected")
        return self._link

    def _say(self, name: str, payload: bytes) -> None:
        link = self._connected
        if not self._catalogue.has(name):
            raise HardwareError(f"the base does not offer {name} to this account")
        link.say(self._catalogue.command(name, payload))

    def _open(self, *, claim: bool) -> None:
        """A new connection at work.

        Args:
            claim: whether a base that moves is stopped; else it is left to whoever moves it.

        Raises:
            HardwareError: as for `connect`.
        """
        settings = self._settings
        connection = open_connection(settings)
        try:
            with said_of(settings):
                self._catalogue, self.protocol = connection.catalogue, connection.protocol
                telemetry = first_readings(connection, settings, claim=claim)
                self._link = Link(connection, telemetry, settings, self._arcl)
        except BaseException:
            connection.socket.close()
            raise
        self._link.start()

    def _pause(self) -> float:
        """Before a recovery: the longer, the more came before [s]."""
        is_new = stopwatch() - self._recovered_at > _FORGOTTEN
        self._recoveries = 0 if is_new else min(self._recoveries + 1, len(_PAUSES) - 1)
        pause = _PAUSES[self._recoveries]
        self._recovered_at = stopwatch() + pause
        return pause

    def _is_sound(self, link: Link) -> bool:
        """Whether there is nothing to recover from.

        Raises:
            HardwareError: the base was closed meanwhile.
        """
        if self._closing.is_set():
            raise HardwareError(f"Omron base at {self._settings.host}: closed")
        with link.lock:
            return not link.lost and not link.faults(stopwatch())

    def _is_stale(self, link: Link) -> bool:
        pose = link.telemetry.pose
        return pose is None or stopwatch() - pose.at > self._settings.oldest_pose

    def _clearable_faults(self, link: Link) -> list[str]:
        """The texts of faults that a recovery should have cleared."""
        with link.lock:
            return [fault.text for fault in link.faults(stopwatch()) if fault.clearable]

    @staticmethod
    def _wait(done: Callable[[], bool], patience: float) -> bool:
        """Whether something has come true within a time [s]."""
        until, pause = stopwatch() + patience, threading.Event()
        while not done():
            if stopwatch() > until:
                return False
            pause.wait(_LOOK)
        return True

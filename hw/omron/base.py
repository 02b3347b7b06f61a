"""The LD-60 as a `Base`: readings, commands and recoveries, none of which waits for the network."""

from __future__ import annotations

import threading
from collections.abc import Callable
from math import cos, remainder, sin, tau

import numpy as np
from pinocchio import SE3

from hw.clock import Clock, stopwatch
from hw.omron.arcl import Arcl
from hw.omron.arcl_text import Motors
from hw.omron.commander import is_at_rest
from hw.omron.connection import Connection, open_connection, said_of
from hw.omron.faults import connection_lost
from hw.omron.handshake import Catalogue
from hw.omron.link import Link
from hw.omron.settings import OmronSettings
from hw.omron.site import REST, Velocity, is_finite
from hw.omron.telemetry import Pose, Telemetry
from hw.robot import HardwareError
from hw.state import Array, BaseState

_LOOK = 0.01
"""How often something that is waited for is looked at [s]."""
_RECOVERY = 3.0
"""For each step of a recovery [s]."""
_POSES_AGREE = 0.1, 0.1
"""Fine and coarse pose of a base that stands differ by less than this [m, rad]."""


class OmronBase:
    """An Omron LD-60, or another base with the same server.

    The pose between two messages is carried on with the measured velocity, so that a reading is of
    the moment at which it is asked for. Without a message for `oldest_pose` the pose stands still
    and the reading has a fault; its stamp goes on, so that a recovery gets its chance.

    Args:
        settings: where the base is, and how it is set up.
        clock: session time, for the stamps.
    """

    def __init__(self, settings: OmronSettings, clock: Clock) -> None:
        self._settings, self._clock = settings, clock
        self._arcl: Arcl | None = None
        self._link: Link | None = None
        self._catalogue = Catalogue()

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
        score = self._connected.telemetry.score
        if score is None and self._arcl is not None:
            return self._arcl.state.score
        return score

    def connect(self) -> None:
        """Log in, and wait for the first readings.

        Raises:
            HardwareError: wrong address, account, protocol version or rights; or the base moves or
                is in a mode that does not let go of it: somebody else commands it.
        """
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
        if link.lost:
            velocity = REST
        return BaseState(
            stamp=self._clock.now(),
            wTb=_carried_on(pose, velocity, age),
            twist=np.array([velocity.v, 0.0, velocity.w]),
            battery=battery,
            faults=faults,
        )

    def send(self, twist: Array) -> Array:
        """Drive; returns what the base can make of it, nothing while there is a fault.

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
            if link.lost or link.faults(now):
                return np.zeros(3)
            reached = site.saturate(wanted, measured)
            applied = site.velocity(site.ratios(reached, measured), measured)
            link.commander.command(applied, now)
        return np.array([applied.v, 0.0, applied.w])

    def recover(self) -> None:
        """Connect again, switch the motors on, take the base back from whoever had it.

        Raises:
            HardwareError: that does not help; the text says what does.
        """
        link = self._connected
        if self._arcl is not None and self._arcl.state.lost:
            self._arcl.connect(self._settings.connect_patience)
        if link.lost or not self._wait(lambda: not self._is_stale(link), _RECOVERY):
            link.close()
            self._open(claim=True)
            link = self._connected
        if self._arcl is not None and self._arcl.state.motors is not Motors.ENABLED:
            self._arcl.enable_motors()
        if link.obedience.finding or link.telemetry.locked:
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
        if self._link is not None:
            self._link.close()
        if self._arcl is not None:
            self._arcl.close()

    @property
    def _connected(self) -> Link:
        if self._link is None:
            raise HardwareError(f"Omron base at {self._settings.host}: not connected")
        return self._link

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
                self._catalogue = connection.catalogue
                telemetry = Telemetry(connection.catalogue, settings.score_scale)
                if claim:
                    connection.send(connection.catalogue.command("stop"))
                requests = telemetry.requests(connection.catalogue, settings.pose_interval)
                connection.send(b"".join(requests))
                patience = settings.connect_patience
                _listen(connection, telemetry, patience, lambda: _is_known(connection, telemetry))
                if claim:
                    _listen(connection, telemetry, patience, lambda: is_at_rest(telemetry.velocity))
                _check_is_free(telemetry)
                _check_poses_agree(telemetry)
                self._link = Link(connection, telemetry, settings, self._arcl)
        except BaseException:
            connection.socket.close()
            raise
        self._link.start()

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


def _listen(
    connection: Connection, telemetry: Telemetry, patience: float, enough: Callable[[], bool]
) -> None:
    """Take packets until there is enough, or for `patience` [s]."""
    for packet in connection.packets(stopwatch() + patience):
        telemetry.take(packet, stopwatch())
        if enough():
            return


def _is_known(connection: Connection, telemetry: Telemetry) -> bool:
    """Whether all has been told that `connect` wants to know."""
    is_mode_known = bool(telemetry.mode) or not connection.catalogue.has("getModeInfo")
    is_place_known = telemetry.localisation is not None or not connection.catalogue.has(
        "getLocState"
    )
    return telemetry.is_complete and is_mode_known and is_place_known


def _check_is_free(telemetry: Telemetry) -> None:
    """That nobody else commands the base.

    Raises:
        HardwareError: somebody does, or it does not tell.
    """
    if not telemetry.is_complete:
        raise HardwareError("it is connected but tells no pose; has it a map, is it localised?")
    if telemetry.locked:
        raise HardwareError(
            f"it is in mode {telemetry.mode!r} ({telemetry.status}) and does not let go of it; "
            "undock it, or end that in MobilePlanner"
        )
    if not is_at_rest(telemetry.velocity):
        raise HardwareError(
            f"it moves already, in mode {telemetry.mode!r}: somebody else commands it; "
            "stop it first"
        )


def _check_poses_agree(telemetry: Telemetry) -> None:
    """That the fine pose is read as it is meant: its layout was never verified on a robot.

    Raises:
        HardwareError: it is somewhere else than the coarse one.
    """
    fine, coarse = telemetry.pose, telemetry.coarse
    assert fine is not None
    assert coarse is not None
    away = max(abs(fine.x - coarse.x), abs(fine.y - coarse.y))
    turned = abs(remainder(fine.theta - coarse.theta, tau))
    if away > _POSES_AGREE[0] or turned > _POSES_AGREE[1]:
        raise HardwareError(
            f"its two poses differ by {away:.2f} m and {turned:.2f} rad: the fine one "
            "(DataStore_RobotPoseInterpolated) is not what this driver takes it for"
        )


def _carried_on(pose: Pose, velocity: Velocity, seconds: float) -> SE3:
    """Where a base is so long after a pose, at a constant velocity."""
    turn = velocity.w * seconds
    heading = pose.theta + turn / 2.0
    way = velocity.v * seconds * float(np.sinc(turn / tau))
    translation = np.array([pose.x + way * cos(heading), pose.y + way * sin(heading), 0.0])
    c, s = cos(pose.theta + turn), sin(pose.theta + turn)
    return SE3(np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]), translation)

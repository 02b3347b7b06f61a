"""The end of connecting: ask for everything, wait for the first of it, and see that all is well."""

from __future__ import annotations

from collections.abc import Callable
from math import remainder, tau

from hw.clock import stopwatch
from hw.omron.commander import is_at_rest
from hw.omron.connection import Connection
from hw.omron.settings import OmronSettings
from hw.omron.telemetry import Telemetry
from hw.robot import HardwareError

_POSES_AGREE = 0.1, 0.1
"""Fine and coarse pose of a base that stands differ by less than this [m, rad]."""

_LEAVES, _GOES_BACK = 1.0, 0.4
"""A base that is told to stop leaves its mode within the first; where another program goes on, it
is back in it within the second [s]."""


def first_readings(connection: Connection, settings: OmronSettings, *, claim: bool) -> Telemetry:
    """What a base tells that stands and that nobody else has.

    Args:
        connection: past its handshake.
        settings: of the base.
        claim: whether a base that moves is stopped; else it is left to whoever moves it.

    Raises:
        HardwareError: it moves, is in a mode that is locked, or does not tell where it is.
        OSError: the connection is lost.
    """
    catalogue, patience = connection.catalogue, settings.connect_patience
    telemetry = Telemetry(catalogue, settings.score_scale)
    if claim:
        connection.send(catalogue.command("stop"))
    connection.send(b"".join(telemetry.requests(catalogue, settings.pose_interval)))
    _listen(connection, telemetry, patience, lambda: _is_known(connection, telemetry))
    if claim:
        _listen(connection, telemetry, patience, lambda: is_at_rest(telemetry.velocity))
    _check_is_free(telemetry)
    if not claim and telemetry.mode and not telemetry.mode.lower().startswith("stop"):
        _check_is_left(connection, telemetry)
    _check_poses_agree(telemetry)
    return telemetry


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


def _check_is_left(connection: Connection, telemetry: Telemetry) -> None:
    """That nobody holds the base at rest: told to stop, it leaves its mode and does not go back.

    Raises:
        HardwareError: somebody sends it velocities, of zero for the moment.
    """
    mode = telemetry.mode
    connection.send(connection.catalogue.command("stop"))
    _listen(connection, telemetry, _LEAVES, lambda: telemetry.mode != mode)
    if telemetry.mode != mode:
        _listen(connection, telemetry, _GOES_BACK, lambda: telemetry.mode == mode)
    if telemetry.mode == mode:
        raise HardwareError(
            f"it stays in mode {mode!r} although it was told to stop: another program commands it; "
            "close that first"
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

"""ARCL, the text interface of the base (Omron's manual I617-E-01): motors, faults, settings."""

from __future__ import annotations

import socket
import threading
from contextlib import suppress
from dataclasses import dataclass, replace
from enum import Enum

from drivers.omron.base_options import ArclOptions
from drivers.omron.teleop_settings import Values
from hw import HardwareError, begun, stopwatch

_POLLS = ("queryMotors", "status", "faultsGet")
_LONGEST_LINE = 65536
_PATIENCE = 3.0  # for an answer [s]


class Motors(Enum):
    """State of the motors, by the beginning of the line that reports it."""

    ENABLED = "motors enabled"
    DISABLED = "motors disabled"
    PRESSED = "estop pressed"
    RELIEVED = "estop relieved"


@dataclass(frozen=True)
class ArclState:
    """The newest state that the text interface reported."""

    motors: Motors | None = None
    faults: tuple[str, ...] = ()
    score: float | None = None  # localisation score, 0 to 1
    lost: str = ""  # why the connection is lost; empty while connected


class Arcl:
    """One connection to the text interface; a thread of its own reads and polls it."""

    def __init__(self, host: str, settings: ArclOptions) -> None:
        self._settings = settings
        self._where = f"Omron text interface at {host}:{settings.port}"
        self._address = (host, settings.port)
        self._parser = _StateParser()
        self._changed = threading.Condition()
        self._listeners: list[list[str]] = []
        self._closing = threading.Event()
        self._socket: socket.socket | None = None
        self._thread: threading.Thread | None = None

    @property
    def state(self) -> ArclState:
        """The newest state."""
        return self._parser.state

    def connect(self, patience: float) -> None:
        """Log in, and wait for the state of the motors; raises HardwareError."""
        try:
            connection = socket.create_connection(self._address, timeout=patience)
        except OSError as error:
            raise HardwareError(
                f"{self._where}: {error.strerror or error}; is ARCL switched on in MobilePlanner?"
            ) from error
        lines = _LineSplitter()
        try:
            self._log_in(connection, lines, stopwatch() + patience)
        except (OSError, HardwareError) as error:
            connection.close()
            raise HardwareError(f"{self._where}: {error}") from error
        self._parser, self._closing = _StateParser(), threading.Event()
        self._socket = connection
        try:
            self._thread = begun(self._run, "omron arcl", connection, lines)
        except HardwareError:
            connection.close()
            raise
        with self._changed:
            known = self._changed.wait_for(lambda: self.state.motors or self.state.lost, patience)
        if not known or self.state.lost:
            self.close()
            raise HardwareError(f"{self._where}: it does not tell the state of the motors")

    def stop(self) -> None:
        """Stop the base, without waiting for the answer."""
        with self._changed:
            self._send(("stop",))

    def enable_motors(self) -> None:
        """Switch the motors on; HardwareError: they stay off, as under the emergency stop."""
        try:
            lines = self._ask("enableMotors", ("motors enabled", "estop pressed"), _PATIENCE)
        except HardwareError:
            if self.state.lost:
                raise
            lines = []
        if any(_is(line, "estop pressed") for line in lines):
            raise HardwareError("the motors stay off: emergency stop pressed; release it first")
        if not lines:
            raise HardwareError("the motors stay off: push the motor button of the base")

    def section(self, name: str, patience: float) -> Values:
        """The values of a section of the configuration; HardwareError: no access, no answer."""
        command, refusals = f"getConfigSectionValues {name}", ("commanderror", "unknown command")
        lines = self._ask(command, ("endofgetconfigsectionvalues", *refusals), patience)
        refused = [line for line in lines if _is(line, *refusals)]
        if refused:
            raise HardwareError(f"{self._where}: `{command}`: {refused[0]}; see ArclConfig")
        values: Values = {}
        for line in lines:
            if _is(line, "getconfigsectionvalue:"):
                key, _, value = line.partition(":")[2].strip().partition(" ")
                values[key] = value.strip()
                with suppress(ValueError):
                    values[key] = float(value)
        return values

    def close(self) -> None:
        """End the connection."""
        self._closing.set()
        if self._thread is not None and self._thread is not threading.current_thread():
            self._thread.join(2.0)

    def _ask(self, command: str, ends: tuple[str, ...], patience: float) -> list[str]:
        """Send a command; the lines up to the first that begins with one of `ends`."""

        def is_done() -> bool:
            return bool(self.state.lost) or any(_is(line, *ends) for line in heard)

        heard: list[str] = []
        with self._changed:
            self._listeners.append(heard)
            try:
                self._send((command,))
                found = self._changed.wait_for(is_done, patience)
            finally:
                self._listeners.remove(heard)
            if not found or self.state.lost:
                why = self.state.lost or f"no answer to `{command}` within {patience:g} s"
                raise HardwareError(f"{self._where}: {why}")
            return heard

    def _log_in(self, connection: socket.socket, lines: _LineSplitter, until: float) -> None:
        sent = False
        while (remaining := until - stopwatch()) > 0.0:
            connection.settimeout(remaining)
            try:
                data = connection.recv(4096)
            except TimeoutError:
                break
            if not data:
                raise HardwareError(
                    "it refuses the password; see ARCL server setup in MobilePlanner"
                    if sent
                    else "it closed the connection; close other programs that use ARCL"
                )
            complete = lines.feed(data)
            if not sent and any("password" in one.lower() for one in (*complete, lines.rest)):
                connection.sendall(f"{self._settings.password}\n".encode())
                sent = True
            if any(_is(line, "end of commands") for line in complete):
                return
        raise HardwareError("no greeting with its commands; check the port (7171 is usual)")

    def _run(self, connection: socket.socket, lines: _LineSplitter) -> None:
        why = ""
        try:
            self._serve(connection, lines)
        except (OSError, HardwareError) as error:
            why = str(error)
        finally:
            with self._changed:
                self._socket = None
                self._parser.state = replace(self._parser.state, lost=why or "closed")
                self._changed.notify_all()
            connection.close()

    def _serve(self, connection: socket.socket, lines: _LineSplitter) -> None:
        heard = polled = stopwatch()
        polled -= self._settings.poll
        while not self._closing.is_set():
            now = stopwatch()
            if now - heard > self._settings.patience:
                raise HardwareError(f"nothing heard for {self._settings.patience:g} s")
            if now - polled >= self._settings.poll:
                polled = now
                with self._changed:
                    self._send(_POLLS)
            connection.settimeout(max(0.005, polled + self._settings.poll - now))
            try:
                data = connection.recv(65536)
            except TimeoutError:
                continue
            if not data:
                raise HardwareError("it closed the connection")
            heard = stopwatch()
            with self._changed:
                for line in lines.feed(data):
                    self._parser.take(line)
                    for listener in self._listeners:
                        listener.append(line)
                self._changed.notify_all()

    def _send(self, commands: tuple[str, ...]) -> None:
        for command in commands:
            if self._socket is None:
                raise HardwareError(f"{self._where}: not connected")
            self._socket.sendall(f"{command}\r\n".encode())


class _LineSplitter:
    def __init__(self) -> None:
        self._buffer = b""

    def feed(self, data: bytes) -> list[str]:
        """The lines that are complete with these bytes."""
        *lines, self._buffer = (self._buffer + data).split(b"\n")
        self._buffer = self._buffer[-_LONGEST_LINE:]
        return [line.decode("utf-8", "replace").strip() for line in lines]

    @property
    def rest(self) -> str:
        """The incomplete line: a prompt."""
        return self._buffer.decode("utf-8", "replace").strip()


class _StateParser:
    def __init__(self) -> None:
        self.state = ArclState()
        self._listed: list[str] = []

    def take(self, line: str) -> None:
        key, _, value = line.partition(":")
        match key.lower():
            case "faultlist":
                self._listed.append(" ".join(value.split()[:2]))
            case "end of faultlist":
                self.state = replace(self.state, faults=tuple(self._listed))
                self._listed = []
            case "localizationscore":
                with suppress(ValueError):
                    self.state = replace(self.state, score=float(value))
            case _:
                for motors in Motors:
                    if _is(line, motors.value):
                        self.state = replace(self.state, motors=motors)


def _is(line: str, *beginnings: str) -> bool:
    return line.lower().startswith(beginnings)

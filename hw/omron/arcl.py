"""ARCL, the text interface: motors, emergency stop, faults, dock and goals.

Lines, answers to what is asked and events that come by themselves, in any case of letters. What is
in Omron's manual (I617-E-01) is marked [M], what was read in drivers [D]. Velocities cannot be
streamed here.
"""

from __future__ import annotations

import socket
import threading
from collections.abc import Callable
from dataclasses import replace

from hw.clock import stopwatch
from hw.omron.arcl_text import ArclState, Lines, Reader, setting_of, tells_setting
from hw.omron.config import Values
from hw.omron.settings import ArclSettings
from hw.robot import HardwareError

_POLLS = ("queryMotors", "status", "faultsGet")


class Arcl:
    """One connection to the text interface; a thread of its own reads and polls it.

    Args:
        host: of the base.
        settings: of the interface.
    """

    def __init__(self, host: str, settings: ArclSettings) -> None:
        self._settings = settings
        self._where = f"Omron text interface at {host}:{settings.port}"
        self._address = (host, settings.port)
        self._reader = Reader()
        self._changed = threading.Condition()
        self._listeners: list[list[str]] = []
        self._closing = threading.Event()
        self._socket: socket.socket | None = None
        self._thread: threading.Thread | None = None

    @property
    def state(self) -> ArclState:
        """The newest."""
        return self._reader.state

    def connect(self, patience: float) -> None:
        """Log in, and wait until the state of the motors is known.

        Args:
            patience: for each step [s].

        Raises:
            HardwareError: there is no such interface, or it refuses the password.
        """
        try:
            connection = socket.create_connection(self._address, timeout=patience)
        except OSError as error:
            raise HardwareError(
                f"{self._where}: {error.strerror or error}; is ARCL switched on in MobilePlanner?"
            ) from error
        lines = Lines()
        try:
            self._log_in(connection, lines, stopwatch() + patience)
        except (OSError, HardwareError) as error:
            connection.close()
            raise HardwareError(f"{self._where}: {error}") from error
        self._reader, self._closing = Reader(), threading.Event()
        self._socket = connection
        self._thread = threading.Thread(
            target=self._run, args=(connection, lines), name="omron arcl", daemon=True
        )
        self._thread.start()
        with self._changed:
            known = self._changed.wait_for(lambda: self.state.motors or self.state.lost, patience)
        if not known or self.state.lost:
            self.close()
            raise HardwareError(f"{self._where}: it does not tell the state of the motors")

    def ask(self, command: str, until: Callable[[str], bool], patience: float) -> list[str]:
        """Say a command; the lines from then on, up to the first for which `until` holds.

        Raises:
            HardwareError: there is none within `patience` [s], or no connection.
        """
        heard: list[str] = []
        with self._changed:
            self._listeners.append(heard)
            try:
                self._say(command)
                found = self._changed.wait_for(
                    lambda: self.state.lost or any(map(until, heard)), patience
                )
            finally:
                self._listeners.remove(heard)
            if not found or self.state.lost:
                why = self.state.lost or f"no answer to `{command}` within {patience:g} s"
                raise HardwareError(f"{self._where}: {why}")
            return heard

    def stop(self) -> None:
        """Stop the base, without waiting for the answer [M].

        Raises:
            HardwareError: there is no connection.
        """
        with self._changed:
            self._say("stop")

    def enable_motors(self, patience: float = 3.0) -> None:
        """Switch the motors on [M].

        Raises:
            HardwareError: they stay off, for example because the emergency stop is pressed.
        """
        try:
            lines = self.ask("enableMotors", _tells_of_motors, patience)
        except HardwareError:
            if self.state.lost:
                raise
            lines = []
        if any(_is(line, "estop pressed") for line in lines):
            raise HardwareError("the motors stay off: emergency stop pressed; release it first")
        if not lines:
            raise HardwareError("the motors stay off: push the motor button of the base")

    def section(self, name: str, patience: float = 3.0) -> Values:
        """The values of a section of the configuration, by their names [M].

        Raises:
            HardwareError: it does not answer, or does not tell its configuration (`ArclConfig`).
        """
        command, ends = f"getConfigSectionValues {name}", ("commanderror", "unknown command")
        end = "endofgetconfigsectionvalues"
        lines = self.ask(command, lambda line: _is(line, end, *ends), patience)
        refused = [line for line in lines if _is(line, *ends)]
        if refused:
            raise HardwareError(f"{self._where}: `{command}`: {refused[0]}; see ArclConfig")
        return dict(map(setting_of, filter(tells_setting, lines)))

    def goals(self, patience: float = 3.0) -> list[str]:
        """The names of the goals on the robot's map [M].

        Raises:
            HardwareError: it does not answer.
        """
        lines = self.ask("getGoals", lambda line: _is(line, "end of goals"), patience)
        return [line.partition(":")[2].strip() for line in lines if _is(line, "goal:")]

    def go_to(self, goal: str, patience: float = 300.0) -> None:
        """Drive to a goal by the robot's own navigation [M]; returns on arrival.

        Raises:
            HardwareError: it does not arrive.
        """
        self._until_done(f"goto {goal}", (f"arrived at {goal.lower()}",), patience)

    def dock(self, patience: float = 180.0) -> None:
        """Go and charge [M]; returns when docked.

        Raises:
            HardwareError: it does not dock.
        """
        self._until_done("dock", ("dockingstate: docked",), patience)

    def undock(self, patience: float = 60.0) -> None:
        """Leave the dock [M].

        Raises:
            HardwareError: it does not.
        """
        self._until_done("undock", ("dockingstate: undocked",), patience)

    def close(self) -> None:
        """End the connection."""
        self._closing.set()
        if self._thread is not None and self._thread is not threading.current_thread():
            self._thread.join(2.0)

    def _until_done(self, command: str, done: tuple[str, ...], patience: float) -> None:
        ends = (*done, "error:", "interrupted:", "unknown command", "commanderror")
        lines = self.ask(command, lambda line: _is(line, *ends), patience)
        failed = [line for line in lines if _is(line, *ends) and not _is(line, *done)]
        if failed:
            raise HardwareError(f"{self._where}: `{command}`: {failed[0]}")

    def _log_in(self, connection: socket.socket, lines: Lines, until: float) -> None:
        said = False
        while (left := until - stopwatch()) > 0.0:
            connection.settimeout(left)
            try:
                data = connection.recv(4096)
            except TimeoutError:
                break
            if not data:
                raise HardwareError(
                    "it refuses the password; see ARCL server setup in MobilePlanner"
                    if said
                    else "it closed the connection; close other programs that use ARCL"
                )
            complete = lines.feed(data)
            if not said and any(map(_asks_for_password, (*complete, lines.rest))):
                connection.sendall(f"{self._settings.password}\n".encode())
                said = True
            if any(_is(line, "end of commands") for line in complete):
                return
        raise HardwareError("no greeting with its commands; check the port (7171 is usual)")

    def _run(self, connection: socket.socket, lines: Lines) -> None:
        """Read and poll until closed or lost."""
        why = ""
        try:
            self._serve(connection, lines)
        except (OSError, HardwareError) as error:
            why = str(error)
        finally:
            with self._changed:
                self._socket = None
                self._reader.state = replace(self._reader.state, lost=why or "closed")
                self._changed.notify_all()
            connection.close()

    def _serve(self, connection: socket.socket, lines: Lines) -> None:
        heard = polled = stopwatch()
        polled -= self._settings.poll
        while not self._closing.is_set():
            now = stopwatch()
            if now - heard > self._settings.patience:
                raise HardwareError(f"nothing heard for {self._settings.patience:g} s")
            if now - polled >= self._settings.poll:
                polled = now
                with self._changed:
                    for poll in _POLLS:
                        self._say(poll)
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
                    self._reader.take(line)
                    for listener in self._listeners:
                        listener.append(line)
                self._changed.notify_all()

    def _say(self, line: str) -> None:
        if self._socket is None:
            raise HardwareError(f"{self._where}: not connected")
        self._socket.sendall(f"{line}\r\n".encode())


def _is(line: str, *beginnings: str) -> bool:
    return line.lower().startswith(beginnings)


def _tells_of_motors(line: str) -> bool:
    return _is(line, "motors enabled", "estop pressed")


def _asks_for_password(line: str) -> bool:
    return "password" in line.lower()

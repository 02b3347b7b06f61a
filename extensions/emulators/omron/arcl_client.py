"""One client of the emulated text interface (ARCL)."""

import socket
from collections.abc import Iterator, Sequence

from extensions.emulators.omron.client import GoneError, received
from extensions.emulators.omron.onboard_controller import Controller
from extensions.emulators.omron.options import Options
from extensions.emulators.omron.requests import (
    reported_pose,
    reported_score,
    settings,
    signed_degrees,
)
from hw import stopwatch

_HELP = ("status", "stop", "queryMotors", "enableMotors", "faultsGet", "getConfigSectionValues")


class ArclClient:
    """A connection, driven by the emulator's thread."""

    def __init__(
        self,
        connection: socket.socket,
        controller: Controller,
        options: Options,
        faults: Sequence[str],
    ) -> None:
        self.socket = connection
        self._controller, self._options, self._faults = controller, options, faults
        self._waiting, self._since = b"", stopwatch()
        self.is_welcome = False
        self._write("Enter password:\r\n")

    def serve(self, now: float) -> None:
        """Once a cycle; raise GoneError when the connection has lasted for its time."""
        if now - self._since > self._options.arcl_lasts:
            raise GoneError

    def hear(self, now: float) -> None:
        """Read and answer; raise GoneError when the client has left or its password is wrong."""
        *lines, self._waiting = (self._waiting + received(self.socket)).split(b"\n")
        for line in lines:
            self._heed(line.decode("utf-8", "replace").strip())

    def tell(self, line: str) -> None:
        """Send an event, after the password."""
        if self.is_welcome:
            self._write(f"{line}\r\n")

    def _heed(self, line: str) -> None:
        if not self.is_welcome:
            if line != self._options.arcl_password:
                raise GoneError
            self.is_welcome = True
            self._write("".join(f"{name}\tabout {name}\r\n" for name in _HELP))
            self._write("End of commands\r\n")
            return
        command, _, rest = line.partition(" ")
        if command.lower() == "quit":
            raise GoneError
        self._write("".join(f"{one}\r\n" for one in self._answer(command.lower(), rest.strip())))

    def _answer(self, command: str, rest: str) -> Iterator[str]:
        controller = self._controller
        match command:
            case "querymotors":
                yield self._motors()
            case "enablemotors":
                on, pressed = controller.enable_motors(), controller.pressed
                refused = "Estop pressed, cannot enable motors" if pressed else "Motors disabled"
                yield "Motors enabled" if on else refused
            case "status":
                yield from self._status()
            case "stop":
                controller.stop()
                yield "Stopping"
            case "faultsget":
                for fault in self._faults:
                    yield f'FaultList: Fault_Driving {fault} "short" "long" true false false'
                yield "End of FaultList"
            case "getconfigsectionvalues":
                yield from self._section(rest)
            case "":
                return
            case _:
                yield f"Unknown command {command}"

    def _section(self, name: str) -> Iterator[str]:
        if name != "Teleop settings":  # in the right case of letters
            yield "CommandError: getConfigSectionValues"
            yield "CommandErrorDescription: No section of that name"
            return
        for key, value in settings(self._options.teleop).items():
            yield f"GetConfigSectionValue: {key} {value:g}"
        yield "EndOfGetConfigSectionValues"

    def _motors(self) -> str:
        if self._controller.pressed:
            return "EStop pressed"
        on = self._controller.motors_on
        return "Motors enabled" if on else "EStop relieved but motors still disabled"

    def _status(self) -> Iterator[str]:
        x, y, theta = reported_pose(self._controller, self._options)
        score = reported_score(self._controller, self._options)
        yield f"Status: {self._controller.status}"
        yield f"StateOfCharge: {100.0 * self._options.charge:.1f}"
        yield f"Location: {x * 1000.0:.0f} {y * 1000.0:.0f} {signed_degrees(theta):.0f}"
        yield f"LocalizationScore: {score:.6f}"
        yield "Temperature: -128"

    def _write(self, text: str) -> None:
        try:
            self.socket.send(text.encode())
        except OSError as error:
            raise GoneError from error

"""One client of the emulated text interface."""

from __future__ import annotations

import re
import socket
from collections.abc import Callable, Iterator
from math import radians

from hw.emulators.omron.client import GoneError
from hw.emulators.omron.controller import Controller, Goal
from hw.emulators.omron.options import Options
from hw.emulators.omron.requests import believe, reported_pose, settings, signed_degrees

NUMBER = re.compile(r"-?[0-9]{1,9}(\.[0-9]{1,9})?")
GOALS = {"table": (1.0, 0.0, 0.0), "bin": (0.0, 1.0, 90.0)}
"""On the map of the emulated base: x, y, heading [m, m, deg]."""
_DOCKING = ("Undocked", "Docking", "Docked", "Undocking")
_HELP = ("status", "stop", "goto", "dock", "undock", "queryMotors", "enableMotors", "faultsGet")


class ArclClient:
    """A connection, driven by the emulator's thread.

    Args:
        connection: not blocking.
        controller: what is spoken about.
        options: of the base.
        now: time [s].
    """

    def __init__(
        self,
        connection: socket.socket,
        controller: Controller,
        options: Options,
        now: Callable[[], float],
    ) -> None:
        self.socket = connection
        self._controller, self._options, self._now = controller, options, now
        self._waiting, self._since = b"", now()
        self.is_welcome = False
        self.faults: list[str] = []
        """Names that `faultsGet` lists."""
        self._write("Enter password:\r\n")

    def last(self, now: float) -> None:
        """Close the connection when it has lasted for its time.

        Raises:
            GoneError: it has.
        """
        if now - self._since > self._options.arcl_lasts:
            raise GoneError

    def hear(self) -> None:
        """Read and answer.

        Raises:
            GoneError: it has left, or its password is wrong.
        """
        try:
            data = self.socket.recv(65536)
        except BlockingIOError:
            return
        except OSError as error:
            raise GoneError from error
        if not data:
            raise GoneError
        *lines, self._waiting = (self._waiting + data).split(b"\n")
        for line in lines:
            self._heed(line.decode("utf-8", "replace").strip())

    def tell(self, line: str) -> None:
        """An event, to those who are past the password."""
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
            case "status" | "onelinestatus":
                yield from self._status() if command == "status" else (" ".join(self._status()),)
            case "stop":
                controller.stop()
                yield "Stopping"
            case "dock" | "undock":
                controller.dock(self._now(), leave=command == "undock")
                yield self._docking()
            case "querydockstatus":
                yield self._docking()
            case "goto" | "dotask":
                yield from self._goto(rest)
            case "localizetopoint":
                x, y, theta = _numbers(rest)
                believe(controller, self._options, (x / 1000.0, y / 1000.0, radians(theta)))
                yield "Localizing at point"
                yield "Localized to point"
            case "getgoals":
                yield from (f"Goal: {name}" for name in GOALS)
                yield "End of goals"
            case "faultsget":
                for fault in self.faults:
                    yield f'FaultList: Fault_Driving {fault} "short" "long" true false false'
                yield "End of FaultList"
            case "getconfigsectionvalues":
                yield from self._section(rest)
            case "":
                return
            case _:
                yield f"Unknown command {command}"

    def _goto(self, rest: str) -> Iterator[str]:
        words = rest.split()
        if words[:1] == ["gotoPoint"] and len(words) >= 3:
            x, y, theta = _numbers(rest.partition(" ")[2])
            goal = Goal(x / 1000.0, y / 1000.0, radians(theta) if len(words) > 3 else None)
        elif rest in GOALS:
            x, y, heading = GOALS[rest]
            goal = Goal(x, y, radians(heading), rest)
        else:
            yield "CommandError: goto"
            yield "CommandErrorDescription: No such goal"
            return
        if not self._controller.go_to(goal):
            yield "Error: Failed going to goal"

    def _section(self, name: str) -> Iterator[str]:
        if name != "Teleop settings":  # in the right case of letters
            yield "CommandError: getConfigSectionValues"
            yield "CommandErrorDescription: No section of that name"
            return
        for key, kind, value in settings(self._options.teleop):
            if kind != b".":
                yield f"GetConfigSectionValue: {key} {value:g}"
        yield "EndOfGetConfigSectionValues"

    def _motors(self) -> str:
        controller = self._controller
        if controller.pressed:
            return "EStop pressed"
        return (
            "Motors enabled" if controller.motors_on else "EStop relieved but motors still disabled"
        )

    def _status(self) -> Iterator[str]:
        x, y, theta = reported_pose(self._controller, self._options)
        score = 0.0 if self._options.lost else self._options.score
        yield f"Status: {self._controller.status}"
        yield f"StateOfCharge: {100.0 * self._options.charge:.1f}"
        yield f"Location: {x * 1000.0:.0f} {y * 1000.0:.0f} {signed_degrees(theta):.0f}"
        yield f"LocalizationScore: {score:.6f}"
        yield "Temperature: -128"

    def _docking(self) -> str:
        docking = self._controller.docking
        charge = "Bulk" if docking == 2 else "Not"
        return f"DockingState: {_DOCKING[docking]} ForcedState: Unforced ChargeState: {charge}"

    def _write(self, text: str) -> None:
        try:
            self.socket.send(text.encode())
        except OSError as error:
            raise GoneError from error


def _numbers(text: str) -> tuple[float, float, float]:
    """Three numbers, 0 where there is none."""
    values = [float(word) if NUMBER.fullmatch(word) else 0.0 for word in text.split()[:3]]
    x, y, theta = (*values, 0.0, 0.0, 0.0)[:3]
    return x, y, theta
